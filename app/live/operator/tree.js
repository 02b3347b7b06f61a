// Draws the tree of a run as SVG: a pill per node, with the colour and mark of its status.
"use strict";

const SVG = "http://www.w3.org/2000/svg";
const ROW = 28, INDENT = 22, HEIGHT = 22, LETTER = 7.3;
const MARKS = { idle: "·", running: "▶", success: "✔", "not yet": "○", failure: "✗" };
const KINDS = { sequence: "→", reactive_sequence: "⇒", fallback: "?", reactive_fallback: "?", parallel: "‖",
  forever: "↻", until: "↻", retry: "↻", repeat: "↻", invert: "¬", timeout: "◇" };

function shape(kind, attributes, parent) {
  const made = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  parent.append(made);
  return made;
}

class Tree {
  constructor(place, nodes, choose) {
    const parents = [], path = [];
    nodes.forEach((node, index) => {
      path.length = node.depth;
      parents.push(path.length ? path[path.length - 1] : null);
      path.push(index);
    });
    const titles = nodes.map((node) => `${KINDS[node.kind] || ""} ${node.title}`.trim());
    const widths = titles.map((title) => LETTER * (title.length + 3) + 24);
    const right = Math.max(...nodes.map((node, i) => INDENT * node.depth + widths[i]));
    const svg = shape("svg", { width: right + 150, height: ROW * nodes.length + 12 }, place);
    this.edges = shape("g", {}, svg);
    this.parts = nodes.map((node, index) => {
      const x = 18 + INDENT * node.depth, y = ROW * index + 18;
      const group = shape("g", { class: "node idle", tabindex: 0, "data-node": index }, svg);
      shape("circle", { class: "breakpoint", cx: x - 10, cy: y, r: 5 }, group);
      shape("rect", { x, y: y - HEIGHT / 2, width: widths[index], height: HEIGHT, rx: HEIGHT / 2 }, group);
      const mark = shape("text", { x: x + 12, y: y + 4 }, group);
      shape("text", { x: x + 30, y: y + 4 }, group).textContent = titles[index];
      const badge = shape("text", { x: x + widths[index] + 6, y: y + 4, class: "badge" }, group);
      group.addEventListener("click", () => { group.blur(); choose(index); });
      group.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        choose(index);
      });
      let edge = null;
      if (parents[index] !== null) {
        const px = 18 + INDENT * nodes[parents[index]].depth + 11, py = ROW * parents[index] + 18 + HEIGHT / 2;
        edge = shape("path", { d: `M${px} ${py}V${y}H${x}`, class: "edge idle" }, this.edges);
      }
      return { group, mark, badge, edge };
    });
  }

  show(state, chosen) {
    const looks = state.looks || this.parts.map(() => "idle");
    this.parts.forEach(({ group, mark, badge, edge }, index) => {
      const look = looks[index];
      const classes = ["node", look.replace(" ", "-")];
      if (index === state.tip && look === "running") classes.push("tip");
      if (state.breaks.includes(index)) classes.push("stops");
      if (index === state.waiting) classes.push("waits");
      if (index === chosen) classes.push("chosen");
      const all = classes.join(" ");
      if (group.getAttribute("class") !== all) group.setAttribute("class", all);
      if (mark.textContent !== MARKS[look]) mark.textContent = MARKS[look];
      const forced = state.forced[index] ? `forced: ${state.forced[index]}` : "";
      if (badge.textContent !== forced) badge.textContent = forced;
      const line = `edge ${look.replace(" ", "-")}`;
      if (edge && edge.getAttribute("class") !== line) edge.setAttribute("class", line);
    });
  }
}
