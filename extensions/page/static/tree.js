// The tree of a run: a row per node, with folding, search, and the running path in sight.
"use strict";

const MARKS = { i: "·", r: "▶", s: "✔", n: "○", f: "✗", h: "■" };
const LOOKS = { i: "idle", r: "running", s: "success", n: "not-yet", f: "failure", h: "stopped" };
const HANDS_OFF = 6000;  // so long after a person has scrolled, the tree stays where it is [ms]

const element = (id) => document.getElementById(id);

// A new element with some properties, and children or texts.
function made(kind, properties = {}, ...children) {
  const one = Object.assign(document.createElement(kind), properties);
  one.append(...children);
  return one;
}

// A browser works for each property that is set, even to what it was.
const set = (one, property, value) => { if (one[property] !== value) one[property] = value; };
const setText = (one, text) => set(one, "textContent", text);

// Lines whose last column hangs where it begins.
function setLines(place, text) {
  if (place.text === text) return;
  place.text = text;
  place.replaceChildren(...text.split("\n").map((line) => {
    const one = made("div", { textContent: line || " " });
    one.style.setProperty("--hang", line.lastIndexOf("  ") + 2);
    return one;
  }));
}

class Tree {
  constructor(place, nodes, choose) {
    this.nodes = nodes.map(([title, kind, depth, does]) => ({ title, kind, depth, does }));
    this.folded = new Set();
    this.words = "";
    this.tip = -1;
    this.touched = 0;
    const path = [];
    this.nodes.forEach((node, index) => {
      path.length = node.depth;
      node.parent = path.length ? path[path.length - 1] : null;
      path.push(index);
      if (node.parent !== null) this.nodes[node.parent].inner = true;
    });
    this.parts = this.nodes.map((node, index) => {
      const parts = {
        fold: made("span", { className: "fold" }), mark: made("span", { className: "mark", role: "img" }),
        badge: made("span", { className: "badge" }), spent: made("span", { className: "spent" }),
      };
      parts.row = made("div", { tabIndex: -1, title: `${node.title} (${node.kind})` }, parts.fold, parts.mark,
        made("span", { className: "name", textContent: node.title }), parts.badge, parts.spent);
      parts.row.style.setProperty("--depth", node.depth);
      parts.row.dataset.node = index;
      parts.row.setAttribute("role", "treeitem");
      parts.row.setAttribute("aria-level", node.depth + 1);
      return parts;
    });
    place.replaceChildren(...this.parts.map(({ row }) => row));
    place.onscroll = () => { if (!this.follows) this.touched = performance.now(); };
    place.onclick = (event) => {
      const row = event.target.closest(".row");
      if (!row) return;
      const index = Number(row.dataset.node);
      if (event.target.className === "fold") this.fold(index, !this.folded.has(index));
      else choose(index);
      this.focus(index);
    };
    place.onkeydown = (event) => this.press(event, choose);
    this.place = place;
    this.focus(0, false);
    this.arrange();
  }

  // Move the only tab stop of the tree.
  focus(index, really = true) {
    if (this.focused !== undefined) this.parts[this.focused].row.tabIndex = -1;
    this.focused = index;
    const { row } = this.parts[index];
    row.tabIndex = 0;
    if (really) row.focus();
  }

  press(event, choose) {
    const shown = this.parts.flatMap(({ row }, index) => (row.hidden ? [] : [index]));
    const at = shown.indexOf(this.focused), node = this.nodes[this.focused];
    const folded = this.folded.has(this.focused);
    const moves = {
      ArrowDown: () => this.focus(shown[Math.min(at + 1, shown.length - 1)]),
      ArrowUp: () => this.focus(shown[Math.max(at - 1, 0)]),
      ArrowLeft: () => (node.inner && !folded ? this.fold(this.focused, true) : this.focus(node.parent ?? 0)),
      ArrowRight: () => (folded ? this.fold(this.focused, false) : node.inner && this.focus(shown[at + 1] ?? this.focused)),
      Home: () => this.focus(shown[0]),
      End: () => this.focus(shown.at(-1)),
      Enter: () => choose(this.focused),
      " ": () => choose(this.focused),
    };
    if (!moves[event.key]) return;
    event.preventDefault();
    moves[event.key]();
  }

  fold(index, is) {
    this.folded[is ? "add" : "delete"](index);
    this.arrange();
  }

  // Fold everything but the running path, or nothing.
  foldAll(is) {
    const open = new Set(this.pathTo(this.tip));
    this.folded = new Set(is ? this.nodes.flatMap((node, index) => (node.inner && !open.has(index) ? [index] : [])) : []);
    this.arrange();
  }

  search(words) {
    this.words = words.trim().toLowerCase();
    this.arrange();
  }

  // Hide what is folded, and what is neither found nor above something found.
  arrange() {
    const found = new Set();
    this.nodes.forEach((node, index) => {
      if (`${node.title} ${node.kind}`.toLowerCase().includes(this.words)) this.pathTo(index).forEach((one) => found.add(one));
    });
    this.nodes.forEach((node, index) => {
      const { row, fold } = this.parts[index], above = node.parent === null ? null : this.nodes[node.parent];
      node.shut = above !== null && (above.shut || (this.folded.has(node.parent) && !this.words));
      row.hidden = node.shut || !found.has(index);
      setText(fold, node.inner ? (this.folded.has(index) ? "▸" : "▾") : "");
      if (node.inner) row.setAttribute("aria-expanded", Boolean(this.words) || !this.folded.has(index));
    });
    this.place.hidden = found.size === 0;
    setText(element("unfound"), found.size ? "" : `no node has “${this.words}” in its name or kind`);
    if (this.parts[this.focused].row.hidden) {  // the tab stop is always one that is shown
      const shown = this.pathTo(this.focused).find((one) => !this.parts[one].row.hidden);
      this.focus(shown ?? Math.max(0, this.parts.findIndex(({ row }) => !row.hidden)), false);
    }
  }

  pathTo(index) {
    const path = [];
    for (let one = index; one !== null && one >= 0; one = this.nodes[one].parent) path.push(one);
    return path;
  }

  show(state, chosen) {
    const over = state.phase === "over", breaks = new Set(over ? [] : state.breaks);
    this.parts.forEach(({ row, mark, badge, spent }, index) => {
      const last = state.looks ? state.looks[index] : "i", look = over && last === "r" ? "h" : last;
      const classes = ["row", LOOKS[look]];
      if (index === state.tip && look === "r") classes.push("tip");
      if (breaks.has(index)) classes.push("stops");
      if (index === state.waiting && !over) classes.push("waits");
      if (index === chosen) classes.push("chosen");
      const all = classes.join(" ");
      if (row.className !== all) {
        row.className = all;
        row.setAttribute("aria-selected", index === chosen);
        mark.setAttribute("aria-label", LOOKS[look].replace("-", " "));
      }
      setText(mark, MARKS[look]);
      const seconds = state.spent ? state.spent[index] : 0;
      setText(spent, seconds ? `${seconds.toFixed(1)} s` : "");
      const forced = state.forced && state.forced[index];
      setText(badge, `${breaks.has(index) ? "● pauses" : ""}${forced ? ` forced: ${forced}` : ""}`.trim());
    });
    if (state.tip !== undefined && state.tip !== this.tip) {
      this.tip = state.tip;
      if (performance.now() - this.touched > HANDS_OFF && !this.words) this.follow();
    }
  }

  // Scroll to a node, or what it is folded into.
  follow(index = this.tip) {
    const shown = this.pathTo(index).find((one) => !this.parts[one].row.hidden);
    if (shown === undefined) return;
    const { row } = this.parts[shown], { place } = this;
    const middle = row.offsetTop - place.clientHeight / 2;
    if (row.offsetTop < place.scrollTop || row.offsetTop + row.offsetHeight > place.scrollTop + place.clientHeight) {
      this.follows = true;
      place.scrollTop = middle;
      setTimeout(() => { this.follows = false; }, 100);
    }
  }
}
