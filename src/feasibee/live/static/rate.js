// A world that changes, as a preset of the form, and how fast it changes, as a slider.

import { $, unfold } from "./elements.js";

/** @import { Opened } from "./arena.js" */
/** @import { Controls } from "./controls.js" */

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
