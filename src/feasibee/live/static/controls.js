// The form of settings: the user's changes, and the server's problems with them.

import { make, unfold } from "./elements.js";

/** @typedef {HTMLInputElement | HTMLSelectElement} Input */
/** @typedef {{path: string, text: string}} Problem */

export class Controls {
  /**
   * @param {HTMLFormElement} form
   * @param {() => void} change The user changed a control.
   */
  constructor(form, change) {
    this.change = change;
    this.problem = /** @type {HTMLElement} */ (form.querySelector("#problem"));
    /** @type {Record<string, unknown>} */
    this.changes = {};
    /** @type {Map<string, Input>} */
    this.inputs = new Map();
    /** @type {Map<Input, HTMLElement>} */
    this.notes = new Map();
    for (const input of /** @type {NodeListOf<Input>} */ (form.querySelectorAll("[data-path]")))
      this.add(input);
    /** @type {Input | null} */
    this.edited = null; // typed into, and not sent yet
    /** @type {HTMLInputElement[]} */
    this.sliders = [...form.querySelectorAll("[data-slides]")].map((each) => /** @type {any} */ (each));
    form.addEventListener("input", (event) => {
      const input = (this.edited = /** @type {Input} */ (event.target));
      if (input.dataset.slides) this.input(input.dataset.slides).value = input.value;
    });
    form.addEventListener("focusout", () => (this.edited = null));
    form.addEventListener("change", (event) => {
      const { path, slides } = /** @type {Input} */ (event.target).dataset,
        changed = path ?? slides;
      this.edited = null;
      if (changed) this.changed(changed, this.input(changed));
    });
    form.addEventListener("submit", (event) => event.preventDefault());
  }

  /**
   * Take a control into the form.
   * @param {Input} input
   */
  add(input) {
    const path = input.dataset.path ?? "",
      note = make("span", { className: "note", id: `note-${path.replace(".", "-")}`, hidden: true }),
      described = input.getAttribute("aria-describedby");
    input.setAttribute("aria-describedby", described ? `${described} ${note.id}` : note.id);
    input.closest("label")?.append(note);
    this.inputs.set(path, input);
    this.notes.set(input, note);
  }

  // Strategy of the second swarm; empty for none.
  get against() {
    return this.input("against").value;
  }

  set against(name) {
    this.input("against").value = name;
  }

  get which() {
    return { seed: this.input("seed").value.trim(), run: this.input("run").value.trim() };
  }

  /**
   * Return a control that the form has.
   * @param {string} path
   */
  input(path) {
    const input = this.inputs.get(path);
    if (!input) throw new Error(`the form has no control for ${path}`);
    return input;
  }

  /**
   * @param {string} path
   * @param {Input} input
   */
  changed(path, input) {
    const { empty } = input.dataset;
    if (empty === "default" && !input.value) delete this.changes[path];
    else if (empty === "null" && !input.value) this.changes[path] = null;
    else if (path.includes(".") || empty) this.changes[path] = this.valueOf(input);
    this.change();
  }

  /** @param {Input} input */
  valueOf(input) {
    if (!(input instanceof HTMLInputElement)) return input.value;
    if (input.type === "checkbox") return input.checked;
    if (input.type !== "number") return input.value;
    return Number.isNaN(input.valueAsNumber) ? input.value : input.valueAsNumber;
  }

  /** @param {string[]} names */
  strategies(names) {
    const options = () => names.map((name) => new Option(name, name)),
      { against } = this;
    this.input("decision.strategy").replaceChildren(...options());
    this.input("against").replaceChildren(new Option("none", ""), ...options());
    this.input("against").value = names.includes(against) ? against : "";
  }

  /**
   * Show the values of a run that has begun.
   * @param {{fields: Record<string, string | number | boolean>, seed: string, run: string}} swarm
   */
  show({ fields, seed, run }) {
    this.clearProblems();
    /** @type {Record<string, string | number | boolean | undefined>} */
    const values = { seed, run, ...fields, preset: String(this.changes.preset ?? "") };
    for (const [path, input] of this.inputs) {
      const value = values[path] ?? (input.dataset.empty ? "" : undefined);
      if (value === undefined || input === this.edited) continue;
      if (input instanceof HTMLInputElement && input.type === "checkbox") input.checked = Boolean(value);
      else input.value = String(value);
    }
    for (const slider of this.sliders) {
      const { value } = this.input(slider.dataset.slides ?? "");
      if (Number(value) > Number(slider.max)) slider.max = value;
      slider.value = value;
    }
  }

  clearProblems() {
    for (const [input, note] of this.notes) {
      input.removeAttribute("aria-invalid");
      note.hidden = true;
    }
    this.problem.hidden = true;
  }

  /**
   * Return the control of a field, or of the field that it is a part of.
   * @param {string} path
   * @returns {Input | undefined}
   */
  nearest(path) {
    const found = this.inputs.get(path),
      end = path.lastIndexOf(".");
    return found || end < 0 ? found : this.nearest(path.slice(0, end));
  }

  /**
   * Show problems, each at its control if the form has one.
   * @param {Problem[]} problems
   */
  showProblems(problems) {
    this.clearProblems();
    const others = [];
    for (const { path, text } of problems) {
      const input = this.nearest(path),
        note = input && this.notes.get(input);
      if (!input || !note) {
        others.push(text);
        continue;
      }
      input.setAttribute("aria-invalid", "true");
      note.textContent = text;
      note.hidden = false;
      unfold(input);
    }
    const more = problems.length > others.length ? ["Not changed: the previous run continues."] : [];
    this.problem.textContent = [...others, ...more].join("\n");
    this.problem.hidden = !this.problem.textContent;
  }
}
