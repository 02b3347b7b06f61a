// Texts of the page and enabled buttons: a pure function of the state.
"use strict";

const OLD = 1.0;  // age from which a tick is reported as old [s]

// Whole seconds.
const whole = (seconds) => `${Math.floor(seconds)} s`;

/* State of the page:
     run       last state of the run; null before the first
     about     what does not change during the run
     answer    "told", "none" yet, "refused" (no connection), "forbidden", "asleep" (a hidden tab)
     silent    time since the last news [s]
     patience  longest time without news on this connection [s]
     wanted    action that is not confirmed yet: { id, name, seconds }, or null
     note      result of the last action, or ""
     chosen    number of the selected node, or null
     trouble   what failed last: { text, seconds }, or null
     shownAt   time that the viewer shows [s], or null
     pictured  stamp of the picture, or null
     tab       the tab that is shown: `tasks` is about what can be started, not about the run
     saved     name of a finished run that is looked at, or null
*/
function view(state) {
  const run = { phase: "unknown", breaks: [], forced: {}, faults: [], figures: {}, purpose: [], ...state.run };
  const about = { nodes: [], ...state.about };
  const over = run.phase === "over", idle = run.phase === "idle";
  const ended = over || idle || Boolean(state.saved);
  const silent = state.silent > state.patience && (!ended || run.desk);
  const age = state.silent + (run.age || 0);
  const stuck = run.phase === "running" && age > Math.max(OLD, state.patience);
  const live = run.phase === "running" && !silent && !stuck && !["forbidden", "asleep"].includes(state.answer);
  const open = live && !run.stopped;
  const latched = Boolean(run.emergency), faults = run.faults;
  const asks = Boolean(run.approve) && run.paused && !run.stopped && !latched && run.phase === "running";
  const forced = state.chosen === null ? undefined : run.forced[state.chosen];
  const broken = run.breaks.includes(state.chosen);
  const planned = !state.saved || Boolean(about.plan);
  const desk = state.tab === "tasks";
  // What it did, without why: `✔ pick_one succeeded after 12.3 s`.
  const outcome = (run.outcome || "").split(": ")[0];
  const tip = about.nodes[run.tip], force = Boolean(about.can_force);

  function sentence() {
    if (state.saved && !state.run) return ["over", "reading the run"];
    const danger = ended ? "" : ", the robot may be moving; press the emergency stop";
    if (ended && !silent && state.answer !== "forbidden") {
      if (idle) return ["over", "nothing runs; choose a task"];
      return ["over", `${desk ? "the last run" : "the run has ended"}: ${outcome}`];
    }
    if (state.answer === "forbidden") {
      return ["lost", "no valid token, Stop does not work here: open the address that the run printed"];
    }
    if (state.answer === "asleep") return ["over", "connecting"];
    if (silent && state.answer === "refused") return ["lost", `connection lost ${whole(state.silent)} ago${danger}`];
    if (silent || stuck) {
      const what = silent || run.unheard > OLD ? "no answer" : "its control loop stands still";
      return ["lost", `frozen for ${whole(age)}: ${what}${danger}`];
    }
    if (!state.run) return ["over", "connecting"];
    if (run.phase === "finished") return ["over", "the robot is at rest; the run is being written down"];
    if (run.stopped) return ["over", "stopping"];
    if (run.phase === "starting") return ["over", "starting"];
    return run.paused ? ["paused", `paused: ${run.why}`] : ["running", "running"];
  }

  function notice() {
    if (state.wanted && state.wanted.seconds > 0.3) return `${state.wanted.name} sent, not confirmed yet (${whole(state.wanted.seconds)})`;
    return state.note;
  }

  const [look, sentenced] = sentence();
  const said = desk && !ended ? `${about.task}: ${sentenced}` : sentenced;
  const enabled = {
    stop: !ended,
    pause: !over && !idle && run.phase !== "finished" && !(live && (run.paused || run.stopped)),
    resume: open && Boolean(run.paused) && !latched && !asks,
    step: open && !latched && !asks,
    next: open && !latched && !asks,
    again: over && !silent, jump: state.shownAt !== null,
    fault: open, inject: open, clear: open,
    acknowledge: open && !run.pressed,
    approve: open && asks, refuse: open && asks,
    break: open, unbreak: open,
    "force-success": open, "force-failure": open, "force-nothing": open,
  };
  const shown = {
    controls: !ended || (over && Boolean(run.desk) && !desk) || Boolean(state.saved), tabs: !idle,
    back: Boolean(state.saved), time: !desk, progress: !desk, age: !desk,
    pause: !ended, resume: !ended, step: !ended, next: !ended, stop: !ended,
    acknowledge: latched && run.phase === "running",
    approve: asks, refuse: asks, wanted: asks,
    again: over && Boolean(run.desk) && !desk,
    faults: faults.length > 0 && !over,
    over: over, hint: state.chosen === null, chosen: state.chosen !== null,
    break: !broken && !ended, unbreak: broken && !ended,
    "force-success": force, "force-failure": force,
    forced: forced !== undefined, "force-nothing": forced !== undefined && force,
    notice: notice() !== "",
    now: Boolean(tip) && !over && !desk, otherwise: Boolean(run.then) && run.otherwise !== run.then[0], views: Boolean(tip || state.saved), room: planned, "no-plan": !planned, jump: !over, tests: !over && Boolean(about.injectable?.length),
    picture: state.pictured !== null, trouble: state.trouble !== null, "trouble-label": state.trouble !== null,
    "tab-viewer": Boolean(about.viewer), "tab-tasks": Boolean(run.desk),
    "ticks-label": Boolean(tip) && !desk && !state.saved,
  };
  const progress = [about.objects ? `${run.placed || 0} of ${about.objects} placed` : "", run.holds ? "one in the hand" : ""];
  const texts = {
    run: said,
    notice: notice(),
    task: desk ? "Tasks" : about.task || state.saved || "frankie-task",
    again: `Start ${about.task} again`,
    world: state.saved ? about.where || "" : about.where && !desk ? (about.real ? `ARMED · ${about.where}` : `simulated · ${about.where}`) : run.desk || "",
    progress: progress.filter(Boolean).join(", "),
    trouble: state.trouble ? `${state.trouble.text}, ${whole(Math.max(0, run.seconds - state.trouble.seconds))} ago` : "",
    behind: state.shownAt === null ? "loading" : over
      ? `${whole(Math.max(0, run.stamp - state.shownAt))} before the end; the tree beside it is that of the end`
      : `${whole(Math.max(0, run.stamp - state.shownAt + age))} behind the run`,
    age: state.run && !over && !idle ? `${age.toFixed(1)} s old` : "",
    time: run.time ? `${run.time}${run.paused_s >= 1 ? `, paused ${whole(run.paused_s)}` : ""}` : "",
    people: run.people > 1 ? `${run.people} people watch` : "",
    ticks: state.run ? String(run.ticks || 0) : "–",
    doing: tip ? [tip[0], run.message].filter(Boolean).join(": ") : "",
    purpose: [(about.description || about.task || "").replace(/\.$/, ""), ...run.purpose].join(" › "),
    onward: run.then ? run.then[0] : "",
    "onward-does": run.then ? run.then[1] : "",
    otherwise: tip ? `If this fails: ${run.otherwise}` : "",
    faults: faults.join("; "),
    wanted: `the robot wants to: ${run.approve}`,
    forced: `It will end with ${forced}, whatever it does.`,
    outcome: run.outcome || "",
    pictured: state.pictured === null ? `no image of the wrist camera ${over ? "was recorded" : "yet"}`
      : state.saved ? "the last depth image of the wrist camera"
      : `wrist camera, ${over ? "the last image" : `${Math.max(0, run.stamp - state.pictured + age).toFixed(1)} s old`}; best grasp green`,
  };
  const old = live || over || idle ? "" : "old";
  const looks = {
    run: look,
    banner: faults.length && !over ? "fault" : asks || latched ? "asks" : "",
    line: old, tree: old, views: old, now: old,
    world: (about.real && !desk) || ((desk || !about.where) && /^ARMED/.test(run.desk)) ? "real" : "",
  };
  return { enabled, shown, texts, looks, figures: run.figures, forced: over ? {} : run.forced, explanation: run.explanation || "" };
}
