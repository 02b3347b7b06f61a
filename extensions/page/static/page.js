// Hears of the run by server-sent events, draws it with `view`, and sends the actions of buttons.
"use strict";

const PERIOD = 200, TIMEOUT = 4000;  // [ms]
const SILENCE = 3;  // after which to connect anew [s]
const SEVERITIES = ["info", "warning", "error"];
const MOST_LINES = 300, LONGEST_NAME = 39;  // of the log
const seconds = () => performance.now() / 1000;

let run = null, about = null, answer = "none", heard = seconds(), took = 0;
let wanted = null;  // Stop or Pause, sent again until the state confirms it
let note = "", trouble = null, chosen = null, tree = null, pictured = null, drawn = null, desk = null;

function state() {
  return {
    run, about, answer, note, chosen, pictured, trouble, shownAt,
    silent: seconds() - heard, tab: document.body.dataset.tab, saved,
    patience: OLD + Math.min(took, 3),
    wanted: wanted && { id: wanted.id, name: wanted.name, seconds: seconds() - wanted.since },
  };
}

class Refusal extends Error {}

// One request; its result, or that there is none, is stored in `answer`.
async function ask(path, method = "GET", more = {}) {
  const sent = seconds();
  let reply;
  try {
    const headers = { ...(run ? { "X-Seen": run.told_at } : {}), ...more.headers };
    reply = await fetch(path, { method, ...more, headers, signal: AbortSignal.timeout(TIMEOUT) });
    const body = reply.ok ? await reply.json() : null;
    answer = reply.status === 403 ? "forbidden" : "told";
    took = seconds() - sent;
    if (body !== null) return body;
  } catch (error) {
    answer = error.name === "TimeoutError" ? "none" : "refused";
    throw error;
  }
  if (reply.status === 503) throw new Error("busy");  // Stop and Pause are sent again
  throw new Refusal(reply.status === 409 ? "came too late" : "was refused");
}

// Keep the newest state; ignore one that was overtaken by another.
function hear(told) {
  heard = seconds();
  if (run && (told.run < run.run || (told.run === run.run && told.told_at < run.told_at))) return;
  const over = run && run.phase !== "over" && told.phase === "over";
  run = told;
  const done = run.stopped || run.phase === "idle" || run.phase === "over";
  if (wanted && (done || (wanted.id === "pause" && (run.paused || run.phase === "over")))) wanted = null;
  if (run.desk && desk === null) {
    desk = new Tasks(element("tasks"), started);
    if (new URLSearchParams(location.search).has("tasks")) show("tasks");
  }
  if (run.phase === "idle" && document.body.dataset.tab === "robot") show("tasks");
  if (over && desk) desk.loadRuns();
}

// The page is at once that of the run that was started, not of the one before.
function started(number, task) {
  begin({ task });
  hear({ phase: "starting", stopped: false, run: number, told_at: run.told_at, desk: run.desk });
  show("robot");
  draw();
  element("tab-robot").focus();
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

// What has the focus after a button that has gone; the name of the task otherwise.
const PARTNERS = { break: "unbreak", unbreak: "break" };

function draw() {
  const held = document.activeElement;
  drawn = view(state());
  for (const [id, is] of Object.entries(drawn.enabled)) set(element(id), "disabled", !is);
  for (const [id, is] of Object.entries(drawn.shown)) set(element(id), "hidden", !is);
  for (const [id, text] of Object.entries(drawn.texts)) setText(element(id), text);
  for (const [id, look] of Object.entries(drawn.looks)) set(element(id), "className", look);
  set(document, "title", `${drawn.texts.run.slice(0, 20)} · ${drawn.texts.task}`);
  drawFigures(drawn.figures);
  drawPending(drawn.forced);
  setLines(element("explanation"), drawn.explanation);
  if (held !== document.body && !held.checkVisibility()) element(PARTNERS[held.id] || "task").focus();
  if (desk && run) desk.show(run, about);
  if (tree && run) tree.show(run, chosen);
  if (run && run.moving && element("moving").drawn !== run.moving) {
    element("moving").innerHTML = element("moving").drawn = run.moving;
    element("plan").setAttribute("viewBox", run.view_box);
    measurePlan();
  }
}

// The size of a pixel in the units of the plan, for its letters.
function measurePlan() {
  const plan = element("plan"), { width, height } = plan.viewBox.baseVal;
  if (plan.clientWidth) plan.style.setProperty("--pixel", Math.max(width / plan.clientWidth, height / plan.clientHeight));
}

function drawFigures(figures) {
  const place = element("figures"), names = Object.keys(figures);
  if (place.names !== names.join()) {
    place.names = names.join();
    place.replaceChildren(...names.flatMap((name) => [made("dt", { textContent: name }), made("dd")]));
  }
  place.querySelectorAll("dd").forEach((one, index) => setText(one, figures[names[index]]));
}

// The outcomes that people have chosen and that have not struck yet.
function drawPending(forced) {
  const place = element("pending"), all = JSON.stringify(forced);
  if (place.all === all || !tree) return;
  place.all = all;
  place.replaceChildren(...Object.entries(forced).map(([index, outcome]) => made("p", {},
    `${tree.nodes[index].title} will end with ${outcome}`,
    made("button", { textContent: "Take back", onclick: () => ask(`/force/${index}/nothing`, "POST").then(hear) }))));
}

function choose(index) {
  chosen = index;
  setText(element("chosen-name"), tree.nodes[index].title);
  setText(element("chosen-does"), tree.nodes[index].does || tree.nodes[index].kind);
  draw();
}

const TABS = ["robot", "tree", "log", "viewer", "tasks"];
const WIDE = matchMedia("(min-width: 1000px)");  // as in page.css: tree and log stand beside the robot
function show(tab) {
  if ((tab === "viewer" && !(about && about.viewer)) || (WIDE.matches && ["tree", "log"].includes(tab))) tab = "robot";
  document.body.dataset.tab = tab;
  for (const one of TABS) {
    element(`tab-${one}`).setAttribute("aria-selected", one === tab);
    element(`tab-${one}`).tabIndex = one === tab ? 0 : -1;
  }
  showViewer(tab === "viewer" && about.viewer);
  if (tab === "tree" && tree) tree.follow();
}

// The arrow keys go round the tabs that are shown, and choose.
element("tabs").addEventListener("keydown", (event) => {
  const tabs = TABS.filter((one) => element(`tab-${one}`).checkVisibility()), at = tabs.indexOf(event.target.id.slice(4));
  const to = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: -1 }[event.key];
  if (to === undefined || at < 0) return;
  event.preventDefault();
  const tab = tabs.at(to % tabs.length);
  show(tab);
  draw();
  element(`tab-${tab}`).focus();
});
WIDE.addEventListener("change", () => show(document.body.dataset.tab));

// Begin to show another run, or the same again after a gap.
function begin(told) {
  const same = JSON.stringify(about) === JSON.stringify(told || {});
  about = told || {};
  element("log").replaceChildren();
  trouble = null;
  if (same) return;
  [chosen, pictured] = [null, null];
  element("moving").innerHTML = "";
  element("fixed").innerHTML = about.plan || "";
  element("fault").replaceChildren(...(about.injectable || []).map((name) => new Option(name)));
  tree = (about.nodes || []).length ? new Tree(element("tree"), about.nodes, choose) : null;
  if (!tree) element("tree").replaceChildren();
  show(document.body.dataset.tab);
}

function log(lines) {
  const worst = lines.filter(([, severity, node]) => severity !== "info" && node !== null).at(-1);
  if (worst) trouble = { text: worst[3].slice(2), seconds: worst[0] };
  const place = element("log");
  place.prepend(...lines.reverse().map(([time, severity, node, text, stamp]) => made("li", {
    className: severity,
    onclick: () => {
      if (node === null) return;
      choose(node);
      tree.follow(node);
    },
  }, shown(time, stamp), made("span", { textContent: text }))));
  while (place.childElementCount > MOST_LINES) place.lastChild.remove();
  filter();
}

// A time of the log, which leads to its moment in the viewer.
function shown(time, stamp) {
  const textContent = `${time.toFixed(1)} s`;
  if (!about.viewer) return made("time", { textContent });
  return made("button", { textContent, title: "show it in 3-D", onclick() {
    show("viewer");
    seek(stamp);
  } });
}

function filter() {
  const least = SEVERITIES.indexOf(element("severity").value), words = element("words").value.trim().toLowerCase();
  for (const line of element("log").children) {
    line.hidden = SEVERITIES.indexOf(line.className) < least || !line.textContent.toLowerCase().includes(words);
  }
}

// A finished run, from the list of runs.
const saved = new URLSearchParams(location.search).get("run");
let reads = false;
async function look() {
  if (reads || about) return;
  reads = true;
  try {
    const told = await json(`/runs/${encodeURIComponent(saved)}`);
    const recording = told.recording && encodeURIComponent(OTHER + told.recording);
    begin({ ...told.about, viewer: recording && `/viewer/?url=${recording}&theme=dark&hide_welcome_screen=1` });
    log(told.log);
    depict(told.picture);
    hear({ ...told.state, run: 0, told_at: 0, stopped: true });
    // As `base x [m]`: 0.3.
    run.figures = Object.fromEntries(Object.entries(run.figures).map(([name, value]) => {
      const [, what, unit] = name.match(/^(.*?)(?: \[(.*)\])?$/);
      return [what, `${value} ${unit || ""}`];
    }));
  } catch (error) {
    note = `${saved} cannot be read: ${error.message}`;
  }
  reads = false;
  draw();
}

function depict(told) {
  pictured = told && told.stamp;
  if (told) element("picture").src = told.url;
}

let events = null, opened = 0, retry = 0;
function listen() {
  if (saved) return look();
  clearTimeout(retry);
  if (events) events.close();
  if (document.hidden) return;
  opened = seconds();
  const stream = events = new EventSource("/events");
  const on = (kind, act) => stream.addEventListener(kind, (event) => act(JSON.parse(event.data)));
  on("about", begin);
  on("state", (told) => {
    answer = "told";
    hear(told);
    draw();
  });
  on("log", log);
  on("picture", depict);
  stream.onerror = async () => {
    stream.close();
    if (stream !== events) return;
    await ask("/state").catch(() => {});  // for the reason
    retry = setTimeout(listen, 2 * PERIOD);
  };
}

// A hidden tab lets go of its connection: a browser has six of them.
document.addEventListener("visibilitychange", () => {
  if (document.hidden) answer = "asleep";
  listen();
});
window.addEventListener("offline", listen);

async function enter() {
  const token = location.hash.slice(1);
  if (token) {
    try {
      await ask("/enter", "POST", { headers: { "X-Token": token } });
      history.replaceState(null, "", location.pathname);
    } catch (error) {
      if (!(error instanceof Refusal)) return setTimeout(enter, 2 * PERIOD);
    }
  }
  listen();
}

for (const id of Object.keys(BUTTONS)) element(id).addEventListener("click", () => press(id));
for (const tab of TABS) element(`tab-${tab}`).addEventListener("click", () => show(tab));
element("again").addEventListener("click", () => desk.send(`/again/${run.run}`));
element("search").addEventListener("input", (event) => tree && tree.search(event.target.value));
element("fold").addEventListener("click", () => tree && tree.foldAll(true));
element("unfold").addEventListener("click", () => tree && tree.foldAll(false));
element("severity").addEventListener("change", filter);
element("words").addEventListener("input", filter);
element("jump").addEventListener("click", () => tellViewer(FOLLOW));
element("history").addEventListener("click", () => {
  element("words").value = tree.nodes[chosen].title.slice(0, LONGEST_NAME);
  filter();
  if (element("tab-log").offsetParent) show("log");
});
new ResizeObserver(measurePlan).observe(element("plan"));

// The only key of the whole page; it stops, and nothing else.
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && drawn.enabled.stop && !event.repeat) press("stop");
});

let sending = false;
setInterval(async () => {
  draw();
  if (seconds() - Math.max(heard, opened) > SILENCE) listen();  // the connection may be dead
  if (!wanted || sending || seconds() - wanted.since < 0.3) return;
  sending = true;
  await ask(wanted.path, "POST").then(hear).catch(() => {});
  sending = false;
}, PERIOD);

show("robot");
draw();
enter();
