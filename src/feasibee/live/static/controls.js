// The form of settings: the user's changes, the server's problems with them, and the address that keeps them.

import { $, make, unfold } from "./elements.js";

/** @import { Opened } from "./arena.js" */

/** @typedef {HTMLInputElement | HTMLSelectElement} Input */
/** @typedef {{path: string, text: string}} Problem */

export class Controls {
  /**
   * @param {HTMLFormElement} form
   * @param {() => void} change The user changed a control.
   * @param {(path: string, value: number) => boolean} touch Change the world during the run, from a slider; false if
   *   the run has to start again instead.
   */
  constructor(form, change, touch) {
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
    this.refill = () => {}; // the field that has the focus, by what came meanwhile
    /** @type {HTMLInputElement[]} */
    this.sliders = [...form.querySelectorAll("[data-slides]")].map((each) => /** @type {any} */ (each));
    form.addEventListener("input", (event) => {
      const input = (this.edited = /** @type {Input} */ (event.target));
      if (input.dataset.slides) this.input(input.dataset.slides).value = input.value;
    });
    form.addEventListener("focusout", () => {
      this.edited = null;
      this.refill();
      this.refill = () => {};
    });
    form.addEventListener("change", (event) => {
      const { path, slides } = /** @type {Input} */ (event.target).dataset,
        changed = path ?? slides;
      this.edited = null;
      this.refill = () => {};
      if (slides && touch(slides, Number(/** @type {Input} */ (event.target).value))) return;
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
    const { type, inputMode, value } = input;
    if (type === "checkbox") return input.checked;
    const isNumber =
      (type === "number" || inputMode === "decimal") && value.trim() && !Number.isNaN(Number(value));
    return isNumber ? Number(value) : value; // a quantity may be "6 m"
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
   * @param {{fields: Record<string, string | number | boolean>, units?: Record<string, string>, seed: string, run: string}} swarm
   */
  show({ fields, units = {}, seed, run }) {
    this.clearProblems();
    /** @type {Record<string, string | number | boolean | undefined>} */
    const values = { seed, run, ...fields, preset: String(this.changes.preset ?? "") };
    for (const [path, input] of this.inputs) {
      const value = values[path] ?? (input.dataset.empty ? "" : undefined);
      if (value === undefined) continue;
      const fill = () => (input.value = String(value));
      if (input instanceof HTMLInputElement && input.type === "checkbox") input.checked = Boolean(value);
      else if (input instanceof HTMLInputElement && input === document.activeElement) this.refill = fill;
      else fill();
      if (units[path]) input.closest("label")?.setAttribute("data-unit", units[path]);
    }
    for (const slider of this.sliders) {
      const { value } = this.input(slider.dataset.slides ?? "");
      if (Number(value) > Number(slider.max)) slider.max = value;
      if (slider !== this.edited) slider.value = value;
    }
  }

  /**
   * Let the sliders show the numbers of a step, unless the user moves them.
   * @param {Record<string, number>} now By path.
   */
  follow(now) {
    for (const slider of this.sliders) {
      const value = now[slider.dataset.slides ?? ""];
      if (value === undefined || slider === this.edited || slider.valueAsNumber === value) continue;
      if (value > Number(slider.max)) slider.max = String(value);
      slider.value = String(value);
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

const ARRIVAL = "tasks.arrival_rate",
  LIFETIME = "tasks.lifetime";
/** @typedef {{arrival: number, lifetime: number}} Stream Tasks per step, and steps per task. */

export class RateOfChange {
  /**
   * @param {Controls} controls
   * @param {(isNew: boolean) => void} begin The changes of the form are other ones; whether the preset is chosen.
   */
  constructor(controls, begin) {
    this.controls = controls;
    this.begin = begin;
    /** @type {Record<string, unknown>} */
    this.stream = {}; // the preset, from the server
    /** @type {Stream | null} */
    this.usual = null; // with the slider in its middle
    /** @type {Stream | null} */
    this.wanted = null; // by the slider
    this.slider = /** @type {HTMLInputElement} */ ($("rate"));
    this.slider.addEventListener("input", () => this.show());
    this.slider.addEventListener("change", () => this.scale());
    $("stream").addEventListener("click", () => {
      controls.changes = { ...controls.changes, ...this.stream };
      begin(true);
    });
  }

  get factor() {
    return 2 ** this.slider.valueAsNumber;
  }

  /**
   * Follow a run that has begun: its rates are the usual ones, unless they come from the slider.
   * @param {Opened} world
   */
  open({ fields, changes }) {
    if (changes) unfold($("changing"));
    const [arrival, lifetime] = [Number(fields[ARRIVAL] ?? 0), Number(fields[LIFETIME] ?? 0)],
      isScaled = this.wanted?.arrival === arrival && this.wanted.lifetime === lifetime;
    if (!isScaled) {
      this.usual = arrival && lifetime ? { arrival, lifetime } : null;
      this.slider.value = "0";
    }
    $("rate-row").hidden = !this.usual;
    this.show();
  }

  // Multiply the rate at which tasks appear, and divide their lifetime: so many are there as before.
  scale() {
    if (!this.usual) return;
    const arrival = Number((this.usual.arrival * this.factor).toPrecision(4)),
      lifetime = Number((this.usual.lifetime / this.factor).toPrecision(4));
    this.wanted = { arrival, lifetime };
    Object.assign(this.controls.changes, { [ARRIVAL]: arrival, [LIFETIME]: lifetime });
    this.begin(false);
  }

  show() {
    const text = this.factor >= 1 ? `× ${this.factor}` : `÷ ${1 / this.factor}`;
    $("rate-shown").textContent = text;
    this.slider.setAttribute("aria-valuetext", text);
  }
}

/** @typedef {{seed: string | null, run: string | null}} Which Run of a point; null: the server's choice. */
/** @typedef {{which: Which, point: number | null, against: string, changes: Record<string, unknown>}} Kept */

/**
 * Read what the address keeps.
 * @returns {Kept}
 */
export function readAddress() {
  const kept = new URLSearchParams(location.hash.slice(1));
  /** @type {Record<string, unknown>} */
  const changes = {};
  for (const [path, text] of kept) {
    if (!path.includes(".") && !["preset", "events"].includes(path)) continue;
    try {
      changes[path] = JSON.parse(text);
    } catch {
      changes[path] = text;
    }
  }
  const point = kept.has("point") ? Number(kept.get("point")) : null;
  const which = { seed: kept.get("seed"), run: kept.get("run") };
  return { which, point, against: kept.get("against") ?? "", changes };
}

/**
 * Keep a run in the address, without a new entry in the browser's history.
 * @param {{seed: string, run: string}} which
 * @param {number | null} point
 * @param {string} against
 * @param {Record<string, unknown>} changes
 */
export function writeAddress({ seed, run }, point, against, changes) {
  const kept = new URLSearchParams({ seed, run });
  if (point !== null) kept.set("point", String(point));
  if (against) kept.set("against", against);
  for (const [path, value] of Object.entries(changes)) kept.set(path, JSON.stringify(value));
  history.replaceState(null, "", `#${kept}`);
}
