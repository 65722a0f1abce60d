// A field of the form: its control, perhaps with a slider, and what is said of it.

import { announce, capital, make, unfold } from "./elements.js";
import { numberOf } from "./fields.js";

const LONGEST_SLIDER = 20_000; // of a slider; greater values have only their number

export class Row {
  /**
   * @param {Field} field
   * @param {boolean} isServed Whether a server checks what is typed.
   * @param {(value: any, isLive: boolean) => void} take The user changed the value; isLive: the slider still moves.
   * @param {() => void} takeBack
   */
  constructor(field, isServed, take, takeBack) {
    const { path, name, note = "", kind, nullable, choices = [], slide } = field,
      id = `field-${path.replace(".", "-")}`;
    this.field = field;
    this.name = capital(name);
    this.isServed = isServed;
    this.take = take;
    this.isEdited = false; // typed into or moved, and not taken yet
    this.isWrong = false; // its text can't be a value
    /** @type {any} */
    this.shown = undefined; // value of the run that is shown
    /** @type {HTMLInputElement} */
    this.input = /** @type {any} */ (make(kind === "choice" ? "select" : "input", { id }));
    this.input.dataset.path = path;
    if (kind === "choice") this.bound(nullable ? { ...field, choices: ["", ...choices] } : field);
    else this.input.type = kind === "boolean" ? "checkbox" : "text";
    if (kind !== "value") this.input.inputMode = kind === "integer" ? "numeric" : "decimal";
    this.slider = slide && make("input", { type: "range", ariaLabel: `${this.name}, slider` });
    this.state = make("span", { className: "unseen" });
    this.unit = make("small", {});
    this.fault = make("p", { className: "fault", hidden: true });
    const about = make("div", { id: `${id}-about` }, this.state, this.unit, this.fault);
    if (note) this.unit.after(make("small", {}, note));
    this.input.setAttribute("aria-describedby", about.id);
    const title = `Take back: ${this.name}`;
    this.back = make("button", { type: "button", className: "quiet", title, ariaLabel: title }, "↺");
    this.back.onclick = takeBack;
    const parts = [make("label", { htmlFor: id }, this.name), ...(this.slider ? [this.slider] : [])];
    this.element = make("div", { className: `setting ${kind}` }, ...parts, this.input, this.back, about);
    this.words = `${name} ${path} ${note}`.toLowerCase();
    this.listen();
  }

  listen() {
    const { input, slider } = this;
    input.oninput = () => (this.isEdited = true);
    input.onblur = () => this.isEdited && this.fill(); // with what came meanwhile
    input.onchange = () => {
      this.isEdited = false;
      this.tell(this.rule);
      this.isWrong = !this.fault.hidden;
      if (this.isWrong) return announce(this.fault.textContent);
      this.slide();
      this.take(this.value, false);
    };
    if (!slider) return;
    slider.dataset.slides = this.field.path;
    slider.oninput = () => {
      this.tell("");
      this.isEdited = true;
      input.value = String(Number(slider.valueAsNumber.toPrecision(6)));
      this.take(this.value, true);
    };
    slider.onchange = () => {
      this.isEdited = false;
      this.take(this.value, false);
    };
  }

  /** @param {Field} field With other bounds or choices. */
  bound(field) {
    const { value } = this.input;
    this.field = field;
    if (field.choices)
      this.input.replaceChildren(...field.choices.map((each) => new Option(each || "none", each)));
    if (field.choices) this.input.value = value;
  }

  // What the control has: a number if it can be one; null for none, undefined for the default. What only a server can
  // check stays text.
  get value() {
    const { kind, nullable, path, slide } = this.field,
      text = this.input.value.trim();
    if (kind === "boolean") return this.input.checked;
    if (!text && path !== "against") return nullable ? null : undefined;
    if (kind === "choice" || kind === "value") return text;
    const number = slide ? numberOf(text, this.field) : Number(text);
    if (number === null || Number.isNaN(number)) return text;
    return path === "seed" ? String(number) : Number(number);
  }

  // Why a field with a slider can't have its text; empty if it can. The server checks all others, such as 6 m.
  get rule() {
    const { kind, min = 0, max = 0, slide } = this.field;
    if (!slide || (this.isServed && kind === "quantity")) return "";
    if (numberOf(this.input.value.trim(), this.field) !== null) return "";
    const what = kind === "integer" ? "a whole number" : "a number";
    return `Not changed: ${this.name.toLowerCase()} must be ${what}; type ${min} to ${max.toLocaleString("en")}.`;
  }

  /** @param {string} fault What is wrong with the value; empty if nothing is. */
  tell(fault) {
    this.isWrong = false;
    this.fault.textContent = fault;
    this.fault.hidden = !fault;
    this.input.setAttribute("aria-invalid", String(Boolean(fault)));
  }

  /**
   * Show a value, unless the user types another just now, or has typed what can't be one.
   * @param {any} value
   * @param {string} unit
   * @param {boolean} isMarked Whether the value isn't the default.
   * @param {boolean} isChanged Whether the user has changed it.
   */
  show(value, unit, isMarked, isChanged) {
    const { input, back } = this;
    this.shown = value;
    if (!this.isWrong && !this.isEdited) this.fill();
    this.unit.textContent = unit;
    this.state.textContent = isChanged ? "Changed. " : isMarked ? "Not the default. " : "";
    this.element.toggleAttribute("data-marked", isMarked || isChanged);
    if (!isChanged && document.activeElement === back) input.focus();
    back.hidden = !isChanged;
  }

  fill() {
    this.isEdited = false;
    if (this.field.kind === "boolean") this.input.checked = this.shown === true;
    else this.input.value = String(this.shown ?? "");
    this.slide();
  }

  // Let the slider be where its number is: it stretches, or goes where it would be too long.
  slide() {
    const { slider, field, input } = this,
      value = Number(input.value);
    if (!slider || !field.slide) return;
    const [least, most, step] = field.slide,
      isOnStep = Math.abs(value / step - Math.round(value / step)) < 1e-6;
    slider.hidden = !(value <= LONGEST_SLIDER);
    slider.min = String(Math.min(least, value));
    slider.max = String(Math.min(Number(field.max), Math.max(most, value, Number(slider.max))));
    slider.step = isOnStep ? String(step) : "any";
    slider.value = String(value);
  }

  /** @param {boolean} isFree Whether the value can be changed. */
  enable(isFree) {
    this.input.disabled = !isFree;
    if (this.slider) this.slider.disabled = !isFree;
  }

  // Go to the control, wherever it is folded.
  reveal() {
    this.element.hidden = false;
    unfold(this.element);
    this.input.focus();
  }
}
