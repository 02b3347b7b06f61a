// The desk of `frankie-task serve`: tasks with the form of their parameters, their mistakes, and runs.
"use strict";

const json = async (path) => (await fetch(path)).json();
let fields = 0;

// A labelled control of a form.
function field(name, control, help = "") {
  control.id = `field-${++fields}`;
  control.name = name;
  const label = made("label", { htmlFor: control.id, textContent: name });
  return made("div", { className: "field" }, label, control, ...(help ? [made("small", { textContent: help })] : []));
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
    this.form = made("form", { hidden: true });
    this.said = made("ul", { className: "mistakes", role: "alert" });
    this.runs = made("ul", { id: "runs" });
    this.form.onsubmit = (event) => {
      event.preventDefault();
      this.send(event.submitter && event.submitter.name === "check" ? "/check" : "/start");
    };
    const part = (title, ...children) => made("section", {}, ...(title ? [made("h2", { textContent: title })] : []), ...children);
    place.replaceChildren(part("Tasks", this.choice), part("", this.form, this.said), part("Runs", this.runs));
    this.load();
    this.loadRuns();
  }

  async load() {
    this.all = await json("/tasks");
    this.choice.replaceChildren(...this.all.tasks.map((task) => {
      const button = made("button", { type: "button", onclick: () => this.choose(task.name) },
        made("span", { innerHTML: task.picture, ariaHidden: true }), made("b", { textContent: task.name }),
        made("small", task.bad ? { className: "error", textContent: "has mistakes" } : { textContent: task.description }));
      button.setAttribute("aria-pressed", this.task === task.name);
      button.dataset.task = task.name;
      return made("li", {}, button);
    }));
  }

  // The form of a task, read anew: its file may have been edited.
  async choose(name) {
    this.task = name;
    await this.load();
    const task = this.all.tasks.find((one) => one.name === name);
    if (!task) return;
    const parameters = task.parameters.map((one) => {
      const options = one.choices && one.choices.length ? one.choices : null;
      const control = options ? choices(options, one.default) : made("input", { value: one.default, required: !one.default });
      if (one.step) Object.assign(control, { type: "number", step: one.step, min: one.min ?? "", max: one.max ?? "" });
      return field(one.name, control, one.description || one.type);
    });
    const run = [
      field("robot", suggested(this.all.robots, "frankie")),
      field("world", choices(this.all.worlds)),
      field("scene", suggested(this.all.scenes, "", task.scene || "household")),
      field("seed", made("input", { type: "number", min: 0, step: 1, value: 0 })),
      field("speed", choices(["real", "max"]), "of a simulated robot"),
      field("approve", made("input", { type: "checkbox" }), "every motion waits for a person"),
      field("force", made("input", { type: "checkbox" }), "people may choose how a node ends"),
    ];
    this.parameters = made("fieldset", {}, made("legend", { textContent: "parameters" }), ...parameters);
    this.options = made("fieldset", {}, made("legend", { textContent: "run" }), ...run);
    this.form.replaceChildren(made("h2", { textContent: task.name }), made("p", { textContent: task.description }),
      ...(parameters.length ? [this.parameters] : []), this.options,
      made("button", { name: "start", className: "start", textContent: "Start" }), " ",
      made("button", { name: "check", textContent: "Check" }));
    this.form.hidden = false;
    this.form.scrollIntoView({ block: "nearest" });
    this.said.replaceChildren();
    if (task.bad) this.send("/check");
  }

  order() {
    const values = (place) => Object.fromEntries([...place.querySelectorAll("[name]")].map(
      (one) => [one.name, one.type === "checkbox" ? one.checked : one.value]));
    const { seed, ...options } = values(this.options);
    return { task: this.task, ...options, seed: Number(seed), parameters: values(this.parameters) };
  }

  async send(path) {
    this.tell([{ text: path === "/again" ? "starting again" : "checking", severity: "" }]);
    const body = path === "/again" ? "" : JSON.stringify(this.order());
    try {
      const reply = await fetch(path, { method: "POST", body });
      if (!reply.ok) throw new Error(reply.statusText);
      const told = await reply.json();
      const mistakes = told.refused ? [{ text: told.refused, severity: "error" }] : told.mistakes;
      this.tell(mistakes.length || told.started ? mistakes : [{ text: "good: no mistakes", severity: "" }]);
      if (told.started) this.started();
      else if (path === "/again") show("tasks");
    } catch (error) {
      this.tell([{ text: `${path.slice(1)} was not heard (${error.message}); try again`, severity: "error" }]);
    }
  }

  tell(mistakes) {
    this.said.replaceChildren(...mistakes.map(({ text, severity, source }) => made("li", { className: severity }, text,
      ...(source ? [made("code", { textContent: source, tabIndex: 0 })] : []))));
    this.said.scrollIntoView({ block: "nearest" });
  }

  async loadRuns() {
    const all = await json("/runs");
    const link = (href, textContent) => made("a", { href, textContent, target: "_blank" });
    this.runs.replaceChildren(...all.map((run) => made("li", {}, made("b", { textContent: run.task }),
      ` ${run.outcome}${run.time && ` after ${run.time}`} `, made("small", { textContent: run.when }),
      made("p", { textContent: run.cause }), link(run.explanation, "explanation"), " ",
      link(`/?run=${encodeURIComponent(run.name)}`, "tree, log and recording"))));
    if (!all.length) this.runs.textContent = "none yet";
  }
}
