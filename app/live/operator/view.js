// Texts of the page and enabled buttons: a pure function of the state.
"use strict";

const OLD = 1.0;  // age from which a tick is reported as old [s]

// Whole seconds.
const whole = (seconds) => `${Math.floor(seconds)} s`;

/* State of the page:
     run       last state of the run; null before the first
     answer    of the last request: "told", "none" yet, "refused" (no connection), "forbidden"
     silent    time since the last answer [s]
     patience  longest time for an answer on this connection [s]
     wanted    action that is not confirmed yet: { id, name, seconds }, or null
     note      result of the last action, or ""
     chosen    number of the selected node, or null
*/
function view(state) {
  const run = { phase: "unknown", breaks: [], forced: {}, faults: [], ...state.run };
  const over = run.phase === "over", ended = over && !run.again;
  const silent = !ended && state.silent > state.patience;
  const age = state.silent + (run.age || 0);
  const stuck = run.phase === "running" && age > Math.max(OLD, state.patience);
  const live = run.phase === "running" && !silent && !stuck && state.answer !== "forbidden";
  const open = live && !run.stopped;
  const latched = Boolean(run.emergency), faults = run.faults;
  const asks = Boolean(run.approve) && run.paused && !run.stopped && run.phase === "running";
  const forced = state.chosen === null ? undefined : run.forced[state.chosen];
  const broken = run.breaks.includes(state.chosen);

  function sentence() {
    if (ended) return ["over", "the run has ended"];
    if (state.answer === "forbidden") {
      return ["lost", "no valid token, Stop does not work here: open the address that the run printed"];
    }
    if (silent && state.answer === "refused") {
      return ["lost", `connection lost ${whole(state.silent)} ago, the robot may be moving; press the emergency stop`];
    }
    if (silent || stuck) {
      const what = silent ? "no answer" : "its control loop stands still";
      return ["lost", `frozen for ${whole(age)}: ${what}, the robot may be moving; press the emergency stop`];
    }
    if (!state.run) return ["over", "connecting"];
    if (over) return ["over", "the run has ended; the next begins when the task is saved"];
    if (run.phase === "finished") return ["over", "the robot is at rest; the run is being written down"];
    if (run.stopped) return ["over", "stopping"];
    if (run.phase === "starting") return ["over", "starting"];
    return run.paused ? ["paused", `paused ${run.why}`] : ["running", "running"];
  }

  function notice() {
    if (state.wanted && state.wanted.seconds > 0.3) return `${state.wanted.name} sent, not confirmed yet (${whole(state.wanted.seconds)})`;
    return state.note;
  }

  const [look, said] = sentence();
  const enabled = {
    stop: !ended,
    pause: !over && run.phase !== "finished" && !(live && (run.paused || run.stopped)),
    resume: open && Boolean(run.paused) && !latched && !asks,
    step: open && !latched && !asks,
    next: open && !latched && !asks,
    fault: open, inject: open, clear: open,
    acknowledge: open && !run.pressed,
    approve: open && asks, refuse: open && asks,
    break: open, unbreak: open,
    "force-success": open, "force-failure": open, "force-nothing": open,
  };
  const shown = {
    acknowledge: latched && run.phase === "running",
    approve: asks, refuse: asks, wanted: asks,
    faults: faults.length > 0 && !over,
    over: over, hint: state.chosen === null, chosen: state.chosen !== null,
    break: !broken, unbreak: broken,
    "force-success": Boolean(run.can_force), "force-failure": Boolean(run.can_force),
    forced: forced !== undefined, "force-nothing": forced !== undefined && Boolean(run.can_force),
    notice: notice() !== "",
  };
  const texts = {
    run: said,
    notice: notice(),
    age: state.run && !over ? `${age.toFixed(1)} s old` : "",
    time: run.time || "",
    localised: run.localised || "",
    ticks: state.run ? String(run.ticks || 0) : "–",
    node: run.node ? `${run.node}: ${run.message}` : "",
    faults: faults.join("; "),
    wanted: `the robot wants to: ${run.approve}`,
    forced: `It will end with ${forced}, whatever it does.`,
    outcome: run.outcome || "",
    explanation: run.explanation || "",
  };
  const looks = {
    run: look,
    banner: faults.length && !over ? "fault" : asks ? "asks" : "",
    line: live || over ? "" : "old",
    tree: live || over ? "" : "old",
  };
  return { enabled, shown, texts, looks, viewer: run.viewer };
}
