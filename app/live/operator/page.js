// Polls the state of the run four times a second, and sends the buttons' requests.
"use strict";

const token = location.hash.slice(1);
const element = (id) => document.getElementById(id);

async function ask(path, method = "GET") {
  const reply = await fetch(path, { method, headers: { "X-Token": token } });
  if (reply.status === 403) throw new Error("this page has no valid token: open the address that the run printed");
  if (!reply.ok) throw new Error(`unknown request ${path}`);
  show(await reply.json());
}

function show(state) {
  const run = state.stopped ? "over" : state.paused ? "paused" : "running";
  element("run").className = run;
  element("run").textContent = run === "over" ? "stopping" : run === "paused" ? `paused ${state.why}` : run;
  element("ticks").value = state.ticks;
  element("node").textContent = state.node ? `${state.time.toFixed(2)} s  ${state.node}: ${state.message}` : "";
  element("pause").disabled = state.paused || state.stopped;
  const latched = state.emergency !== "";
  element("acknowledge").hidden = !latched;
  element("acknowledge").disabled = state.pressed || state.stopped;
  element("resume").disabled = !state.paused || state.stopped || latched;
  for (const id of ["step", "next"]) element(id).disabled = state.stopped || latched;
  element("stop").disabled = state.stopped;
  const faults = state.faults || [];
  element("faults").hidden = faults.length === 0;
  element("faults").textContent = faults.join("; ");
  if (!element("fault").length) {
    for (const name of state.injectable) element("fault").add(new Option(name));
  }
  if (state.viewer && !document.querySelector("iframe")) {
    const frame = document.createElement("iframe");
    frame.src = state.viewer;
    frame.title = "viewer";
    document.querySelector("main").replaceChildren(frame);
  }
}

function failed(error) {
  element("run").className = "over";
  element("run").textContent = error instanceof TypeError ? "the run has ended" : error.message;
  for (const button of document.querySelectorAll("button")) button.disabled = error instanceof TypeError;
}

for (const button of document.querySelectorAll("[data-action]")) {
  button.addEventListener("click", () => ask(`/${button.dataset.action}`, "POST").catch(failed));
}
element("inject").addEventListener("click", () =>
  ask(`/fault/${encodeURIComponent(element("fault").value)}`, "POST").catch(failed));

async function poll() {
  try {
    await ask("/state");
  } catch (error) {
    failed(error);
  }
  setTimeout(poll, 250);
}
poll();
