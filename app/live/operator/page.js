// Polls the state of the run five times a second, draws it with `view`, and sends the actions of
// buttons and keys.
"use strict";

const PERIOD = 200, TIMEOUT = 4000;  // [ms]
const token = location.hash.slice(1);
const element = (id) => document.getElementById(id);
const seconds = () => performance.now() / 1000;

let run = null, answer = "none", heard = seconds(), took = 0;
let wanted = null;  // Stop or Pause, sent again until the state confirms it
let note = "", chosen = null, tree = null, nodes = [], drawn = null;

function state() {
  return {
    run, answer, note, chosen,
    silent: seconds() - heard,
    patience: OLD + Math.min(took, 3),
    wanted: wanted && { id: wanted.id, name: wanted.name, seconds: seconds() - wanted.since },
  };
}

class Refusal extends Error {}

// One request; its result, or that there is none, is stored in `answer`.
async function ask(path, method = "GET") {
  const sent = seconds();
  let reply;
  try {
    const headers = { "X-Token": token, ...(run ? { "X-Seen": run.told_at } : {}) };
    reply = await fetch(path, { method, headers, signal: AbortSignal.timeout(TIMEOUT) });
    const body = reply.ok ? await reply.json() : null;
    answer = reply.status === 403 ? "forbidden" : "told";
    heard = seconds();
    took = heard - sent;
    if (body !== null) return body;
  } catch (error) {
    answer = error.name === "TimeoutError" ? "none" : "refused";
    throw error;
  }
  throw new Refusal(reply.status === 409 ? "came too late" : "was refused");
}

// Keep the newest state; ignore one that was overtaken by another.
function hear(told) {
  if (run && told.run === run.run && told.told_at < run.told_at) return;
  run = told;
  const done = run.stopped || (run.phase === "over" && !run.again);
  if (wanted && (done || (wanted.id === "pause" && (run.paused || run.phase === "over")))) wanted = null;
}

async function press(id) {
  const { name, path } = BUTTONS[id], repeated = id === "stop" || id === "pause";
  note = "";
  if (repeated && !(wanted && wanted.id === "stop")) {
    wanted = { id, name, path: path(), since: seconds() };
  }
  try {
    draw();
    hear(await ask(path(), "POST"));
  } catch (error) {
    const refused = error instanceof Refusal;
    if (refused && repeated) wanted = null;
    if (refused || !repeated) note = `${name} ${refused ? error.message : "was not heard"}: look, and press it again`;
  }
  draw();
}

const BUTTONS = {
  pause: { name: "Pause", path: () => "/pause" },
  resume: { name: "Resume", path: () => "/resume" },
  step: { name: "Step", path: () => "/step" },
  next: { name: "Next change", path: () => "/next" },
  stop: { name: "Stop", path: () => "/stop" },
  inject: { name: "Inject", path: () => `/fault/${encodeURIComponent(element("fault").value)}` },
  clear: { name: "Clear faults", path: () => "/clear" },
  acknowledge: { name: "Acknowledge", path: () => "/acknowledge" },
  approve: { name: "Approve", path: () => `/approve/${run.waiting}` },
  refuse: { name: "Refuse", path: () => `/refuse/${run.waiting}` },
  break: { name: "Pause before it", path: () => `/break/${chosen}` },
  unbreak: { name: "Remove breakpoint", path: () => `/unbreak/${chosen}` },
  "force-success": { name: "Force success", path: () => `/force/${chosen}/success` },
  "force-failure": { name: "Force failure", path: () => `/force/${chosen}/failure` },
  "force-nothing": { name: "Take back", path: () => `/force/${chosen}/nothing` },
};

function draw() {
  drawn = view(state());
  for (const [id, is] of Object.entries(drawn.enabled)) element(id).disabled = !is;
  for (const [id, is] of Object.entries(drawn.shown)) element(id).hidden = !is;
  for (const [id, text] of Object.entries(drawn.texts)) {
    if (element(id).textContent !== text) element(id).textContent = text;
  }
  for (const [id, look] of Object.entries(drawn.looks)) element(id).className = look;
  if (run && run.injectable && !element("fault").length) {
    for (const name of run.injectable) element("fault").add(new Option(name));
  }
  embed(drawn.viewer);
  if (tree && run && run.run === planted) tree.show(run, chosen);
}

function embed(source) {
  const frame = document.querySelector("iframe");
  if (!source || (frame && frame.getAttribute("src") === source)) return;
  const made = document.createElement("iframe");
  made.src = source;
  made.title = "viewer";
  element("viewer").replaceChildren(made);
}

function choose(index) {
  chosen = index;
  element("chosen-name").textContent = nodes[index].title;
  draw();
}

let planted = 0;  // number of the run whose tree is drawn
async function plant() {
  const told = await ask("/tree");
  nodes = told.nodes;
  planted = told.run;
  chosen = null;
  element("tree").replaceChildren();
  tree = nodes.length ? new Tree(element("tree"), nodes, choose) : null;
}

async function poll() {
  try {
    const told = wanted ? await ask(wanted.path, "POST") : await ask("/state");
    if (told.run !== planted) await plant();
    if (told.run === planted) hear(told);
  } catch {
    // stored by `ask`
  }
  setTimeout(poll, PERIOD);
}

for (const id of Object.keys(BUTTONS)) {
  element(id).addEventListener("click", (event) => {
    if (event.detail) element(id).blur();  // so that keys for the page do not press it again
    press(id);
  });
}

// A control that has the focus keeps its keys. Space only ever pauses.
const KEYS = { " ": "pause", s: "step", n: "next" };
document.addEventListener("keydown", (event) => {
  const id = KEYS[event.key];
  if (!id || event.ctrlKey || event.metaKey || event.altKey || document.activeElement !== document.body) return;
  event.preventDefault();
  if (drawn.enabled[id] && !event.repeat) press(id);
});

draw();
setInterval(draw, PERIOD);
poll();
