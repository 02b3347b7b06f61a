// Polls the state of the run five times a second, draws it, and sends what buttons and keys ask for.
"use strict";

const token = location.hash.slice(1);
const element = (id) => document.getElementById(id);
let tree = null, chosen = null, last = null;

async function ask(path, method = "GET") {
  const reply = await fetch(path, { method, headers: { "X-Token": token } });
  if (reply.status === 403) throw new Error("this page has no valid token: open the address that the run printed");
  if (!reply.ok) throw new Error(`unknown request ${path}`);
  return reply.json();
}

const send = (path) => ask(path, "POST").then(show).catch(failed);

function visible(id, is) { element(id).hidden = !is; }
function text(id, value) { if (element(id).textContent !== value) element(id).textContent = value; }

// Whether a motion waits for a person: then only the button approves it, and no key by mistake.
function asks(state) { return state.approve !== "" && state.paused && state.over === null && !state.stopped; }

function show(state) {
  last = state;
  const over = state.over !== null, ended = over || state.stopped;
  const run = over ? "over" : state.stopped ? "over" : state.paused ? "paused" : "running";
  element("run").className = run;
  text("run", over ? "over" : state.stopped ? "stopping" : run === "paused" ? `paused ${state.why}` : run);
  element("ticks").value = state.ticks;
  text("node", state.node ? `${state.time.toFixed(2)} s  ${state.node}: ${state.message}` : "");
  const latched = state.emergency !== "";
  const approve = asks(state);
  element("pause").disabled = state.paused || ended;
  element("resume").disabled = !state.paused || ended || latched || approve;
  for (const id of ["step", "next"]) element(id).disabled = ended || latched || approve;
  for (const id of ["stop", "inject", "clear", "fault"]) element(id).disabled = ended;
  const faults = state.faults || [];
  visible("faults", faults.length > 0 && !over);
  text("faults", faults.join("; "));
  visible("acknowledge", latched && !ended);
  element("acknowledge").disabled = state.pressed;
  for (const id of ["wanted", "approve", "refuse"]) visible(id, approve);
  text("wanted", `the robot wants to: ${state.approve}`);
  element("banner").className = faults.length && !over ? "fault" : approve ? "asks" : "";
  if (!element("fault").length) {
    for (const name of state.injectable) element("fault").add(new Option(name));
  }
  embed(over ? state.over.viewer : state.viewer);
  visible("over", over);
  if (over) { text("outcome", state.over.outcome); text("explanation", state.over.explanation); }
  if (tree) tree.show(state, chosen);
  showChosen(state, ended);
}

function embed(source) {
  const frame = document.querySelector("iframe");
  if (!source || (frame && frame.getAttribute("src") === source)) return;
  const made = document.createElement("iframe");
  made.src = source;
  made.title = "viewer";
  element("viewer").replaceChildren(made);
}

function showChosen(state, ended) {
  visible("chosen", chosen !== null);
  visible("hint", chosen === null);
  if (chosen === null) return;
  text("break", state.breaks.includes(chosen) ? "Remove breakpoint" : "Pause before it");
  element("break").disabled = ended || !state.can_break;
  for (const id of ["force-success", "force-failure"]) {
    visible(id, state.can_force);
    element(id).disabled = ended;
  }
}

async function showHistory() {
  if (chosen === null) return;
  const changes = await ask(`/history?node=${chosen}`);
  const lines = changes.slice(-60).reverse().map(({ time, status, message }) => {
    const line = document.createElement("li");
    line.textContent = `${time.toFixed(2)} s  ${status === "invalid" ? "halted or reset" : status}  ${message}`;
    line.className = status;
    return line;
  });
  element("history").replaceChildren(...lines);
}

function choose(index) {
  chosen = index;
  text("chosen-name", nodes[index].title);
  if (last) show(last);
  showHistory().catch(failed);
}

function failed(error) {
  const isGone = error instanceof TypeError;
  element("run").className = "over";
  text("run", isGone ? "the run has ended" : error.message);
  if (isGone) for (const button of document.querySelectorAll("button")) button.disabled = true;
}

for (const button of document.querySelectorAll("[data-action]")) {
  button.addEventListener("click", () => { button.blur(); send(`/${button.dataset.action}`); });
}
for (const id of ["inject", "break", "force-success", "force-failure"]) {
  element(id).addEventListener("click", () => element(id).blur());  // so that Space does not press it again
}
element("inject").addEventListener("click", () => send(`/fault/${encodeURIComponent(element("fault").value)}`));
element("break").addEventListener("click", () => send(`/break/${chosen}`));
for (const outcome of ["success", "failure"]) {
  element(`force-${outcome}`).addEventListener("click", () => send(`/force/${chosen}/${outcome}`));
}

const KEYS = { s: "/step", n: "/next" };
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLSelectElement) return;
  const path = event.key === " " ? (last && last.paused ? "/resume" : "/pause") : KEYS[event.key];
  if (!path || event.repeat || !last || last.over || asks(last)) return;
  event.preventDefault();
  send(path);
});

let nodes = [];
async function poll() {
  try {
    if (!tree) {
      nodes = await ask("/tree");
      tree = new Tree(element("tree"), nodes, choose);
    }
    show(await ask("/state"));
    await showHistory();
  } catch (error) {
    failed(error);
  }
  setTimeout(poll, 200);
}
poll();
