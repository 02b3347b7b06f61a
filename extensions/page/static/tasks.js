// The desk of `frankie-task serve`: tasks with the form of their parameters, their mistakes, and runs.
"use strict";

// What is at a path; an error with the server's words if that is not JSON.
async function json(path, more = {}) {
  const reply = await fetch(path, more), text = await reply.text();
  if (!reply.ok) throw new Error(text || reply.statusText);
  try {
    return JSON.parse(text);
  } catch {
    throw new Error(text);
  }
}
let fields = 0;

// A labelled control of a form, and a place for what is wrong with it; a long name wraps after `_`.
function field(name, control, help = "", at = name) {
  control.id = `field-${++fields}`;
  Object.assign(control, { name, at });
  control.setAttribute("aria-describedby", `${control.id}-help ${control.id}-wrong`);
  control.oninput = () => blame(control, "");
  const label = made("label", { htmlFor: control.id }, ...name.split(/(?<=_)/).flatMap((part) => [part, made("wbr")]));
  return made("div", { className: "field" }, label, control, made("small", { id: `${control.id}-help`, textContent: help }),
    made("small", { id: `${control.id}-wrong`, className: "error" }));
}

// Say at a control what is wrong with it; nothing if that is "".
function blame(control, text) {
  control.setAttribute("aria-invalid", text !== "");
  setText(element(`${control.id}-wrong`), text.replace(/^`-p [^`]*`: /, ""));
}

function choices(options, chosen) {
  const one = made("select", {}, ...options.map((option) => new Option(option)));
  if (options.includes(chosen)) one.value = chosen;
  return one;
}

// A text with suggestions: a shipped name, or the path of a file.
function suggested(options, value, placeholder = "") {
  const list = made("datalist", { id: `list-${++fields}` }, ...options.map((option) => new Option(option)));
  const one = made("input", { value, placeholder, spellcheck: false });
  one.setAttribute("list", list.id);
  one.append(list);
  return one;
}

class Tasks {
  constructor(place, started) {
    this.started = started;
    this.choice = made("ul", { id: "choice" });
    this.form = made("form", { hidden: true, noValidate: true });
    this.start = made("button", { name: "start", className: "start", textContent: "Start" });
    this.busy = made("p", { id: "busy" });
    this.start.setAttribute("aria-describedby", "busy");
    this.said = made("ul", { className: "mistakes" });
    this.alert = made("div", { role: "alert" }, this.said);
    this.runs = made("ul", { id: "runs" });
    this.form.onsubmit = (event) => {
      event.preventDefault();
      this.send(event.submitter && event.submitter.name === "check" ? "/check" : "/start");
    };
    const part = (title, ...children) => made("section", {}, ...(title ? [made("h2", { textContent: title })] : []), ...children);
    place.replaceChildren(part("Tasks", this.choice), part("", this.form, this.alert), part("Runs", this.runs));
    this.load();
    this.loadRuns();
  }

  async load() {
    try {
      this.all = await json("/tasks");
    } catch (error) {
      return this.tell([{ text: `the tasks cannot be read (${error.message}); try again`, severity: "error" }]);
    }
    this.choice.replaceChildren(...this.all.tasks.map((task) => {
      const button = made("button", { type: "button", onclick: () => this.choose(task.name) },
        made("span", { innerHTML: task.picture, ariaHidden: true }), made("b", { textContent: task.name }),
        made("small", task.bad ? { className: "error", textContent: "has mistakes" } : { textContent: task.description }));
      button.setAttribute("aria-pressed", this.task === task.name);
      button.dataset.task = task.name;
      return made("li", {}, button);
    }));
  }

  // Nothing else is started while a task runs.
  show(run, about) {
    const runs = !["idle", "over"].includes(run.phase);
    set(this.start, "disabled", runs);
    setText(this.busy, runs ? `${about.task} runs: stop it before you start another task` : "");
  }

  // The form of a task, read anew: its file may have been edited.
  async choose(name) {
    this.task = name;
    await this.load();
    const task = (this.all ? this.all.tasks : []).find((one) => one.name === name);
    if (!task) return;
    const parameters = task.parameters.map((one) => {
      const options = one.choices && one.choices.length ? one.choices : null;
      const control = options ? choices(options, one.default) : made("input", { value: one.default, required: !one.default });
      if (one.step) Object.assign(control, { type: "number", step: one.step, min: one.min ?? "", max: one.max ?? "" });
      return field(one.name, control, one.description || one.type, `parameters.${one.name}`);
    });
    const run = [
      field("robot", suggested(this.all.robots, "frankie")),
      field("world", choices(this.all.worlds)),
      field("scene", suggested(this.all.scenes, "", task.scene || "household")),
      field("seed", made("input", { type: "number", min: 0, step: 1, value: 0 })),
      field("speed", choices(["real", "max"]), "of a simulated robot"),
      field("approve", made("input", { type: "checkbox" }), "every motion waits for a person, who may choose how a node ends"),
    ];
    this.parameters = made("fieldset", {}, made("legend", { textContent: "parameters" }), ...parameters);
    this.options = made("fieldset", {}, made("legend", { textContent: "run" }), ...run);
    const title = made("h2", { textContent: task.name, tabIndex: -1 });
    this.form.replaceChildren(title, made("p", { textContent: task.description }),
      ...(parameters.length ? [this.parameters] : []), this.options, this.alert,
      made("div", { className: "go" }, this.start, made("button", { name: "check", textContent: "Check" }), this.busy));
    this.form.hidden = false;
    this.said.replaceChildren();
    title.focus({ preventScroll: true });
    title.scrollIntoView({ block: "start" });
    if (task.bad) this.send("/check");
  }

  // The values of the fields that are right; the server takes the default for an empty one.
  order() {
    const values = (place) => Object.fromEntries([...place.querySelectorAll("[name]")].filter((one) => one.validity.valid).map(
      (one) => [one.name, one.type === "checkbox" ? one.checked : one.value]));
    return { task: this.task, ...values(this.options), parameters: values(this.parameters) };
  }

  async send(path) {
    const again = path.startsWith("/again"), name = again ? about.task : this.task;
    const wrong = again ? [] : [...this.form.elements].filter((one) => one.name && !one.validity.valid).map(
      (one) => ({ field: one.at, text: one.validationMessage }));
    this.tell([{ text: again ? "starting again" : "checking", severity: "" }]);
    try {
      const body = again ? "" : JSON.stringify(this.order());
      const told = await json(wrong.length ? "/check" : path, { method: "POST", body });
      const mistakes = told.mistakes || [{ text: told.refused, severity: "error" }];
      const fine = [{ text: "good: no mistakes", severity: "" }];
      this.tell(mistakes.length || wrong.length || told.started ? [...wrong, ...mistakes] : fine);
      if (told.started) this.started(told.started, name);
      else if (again) show("tasks");
    } catch (error) {
      this.tell([{ text: `${again ? "start again" : path.slice(1)} was not heard (${error.message}); try again`, severity: "error" }]);
      if (again) show("tasks");
    }
  }

  // Say what is wrong: at its field, or in a list; the first such field has the focus.
  tell(mistakes) {
    const controls = [...this.form.elements].filter((one) => one.name && one.id);
    controls.forEach((one) => blame(one, ""));
    const at = mistakes.map(({ field }) => controls.find((one) => one.at === field));
    mistakes.forEach(({ text }, index) => at[index] && blame(at[index], text));
    this.said.replaceChildren(...mistakes.map(({ text, severity, source, field }, index) => made("li",
      { className: severity || (field ? "error" : "") }, at[index] ? `${at[index].name}: ${text}` : text,
      ...(source ? [made("code", { textContent: source, tabIndex: 0 })] : []))));
    const first = controls.find((one) => at.includes(one));
    if (first) first.focus();
    else if (mistakes.length) this.said.scrollIntoView({ block: "nearest" });
  }

  async loadRuns() {
    const all = await json("/runs").catch((error) => (this.runs.textContent = error.message, null));
    if (all === null) return;
    const link = (href, textContent) => made("a", { href, textContent, target: "_blank" });
    this.runs.replaceChildren(...all.map((run) => made("li", {}, made("b", { textContent: run.task }),
      ` ${run.outcome}${run.time && ` after ${run.time}`} `, made("small", { textContent: run.when }),
      made("p", { textContent: run.cause }), link(run.explanation, "explanation"), " ",
      link(`/?run=${encodeURIComponent(run.name)}`, "tree, log and recording"))));
    if (!all.length) this.runs.textContent = "none yet";
  }
}
