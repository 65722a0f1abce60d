// Sliders and fields for what a reader may change, kept in the address.

import { $, capital } from "./elements.js";
import { RUNS } from "./swarms.js";

/** @import { Given, Settings } from "./world.js" */

const PAUSE = 200; // milliseconds: browsers limit how often a page may write its address
/** @type {("robots" | "tasks" | "seed" | "run")[]} */
const FIELDS = ["robots", "tasks", "seed", "run"]; // each with a slider
const SLIDER = 100; // most robots or tasks on a slider, unless the file has more

/**
 * Return the element of a field.
 * @param {string} id
 */
const input = (id) => /** @type {HTMLInputElement} */ ($(id));

export class Controls {
  /**
   * @param {Given} given
   * @param {(settings: Settings) => void} changed
   */
  constructor(given, changed) {
    this.given = given;
    this.changed = changed;
    this.settings = { ...given.settings };
    this.late = 0;
    /** @type {Record<string, [number, number | bigint]>} */
    this.limits = {
      robots: [1, given.most.robots],
      tasks: [0, given.most.tasks],
      strategy: [0, given.strategies.length - 1],
      seed: [0, 2n ** 64n - 1n],
      run: [0, 2 ** 32 - 1],
    };
    for (const name of FIELDS) {
      const slider = input(`${name}-slider`);
      slider.max = String(name in given.most ? Math.max(SLIDER, Number(given.settings[name])) : RUNS - 1);
      slider.addEventListener("input", () => this.set({ [name]: slider.value }));
      input(name).addEventListener("input", () => this.set({ [name]: input(name).value }, name));
      input(name).addEventListener("change", () => this.show());
    }
    for (const [number, { name }] of given.strategies.entries())
      input("strategy").append(new Option(name, String(number)));
    input("strategy").addEventListener("input", () => this.set({ strategy: input("strategy").value }));
    addEventListener("hashchange", () => this.readAddress());
    this.readAddress();
  }

  /**
   * Change settings, given as texts; an invalid one is marked at its field and changes nothing.
   * @param {Record<string, string>} texts
   * @param {string} [typed] Name of the field that the reader types in, which isn't written over.
   */
  set(texts, typed) {
    for (const [name, text] of Object.entries(texts)) {
      const value = this.parse(name, text);
      if (typed) input(typed).setAttribute("aria-invalid", String(value === null));
      if (value === null) return;
      this.settings = { ...this.settings, [name]: value };
    }
    this.show(typed);
    clearTimeout(this.late);
    this.late = setTimeout(() => this.writeAddress(), PAUSE);
    this.changed(this.settings);
  }

  /**
   * Parse a whole number within its limits; null if it is none.
   * @param {string} name
   * @param {string} text
   */
  parse(name, text) {
    const [least, most] = this.limits[name];
    if (!/^\d+$/.test(text) || BigInt(text) < least || BigInt(text) > most) return null;
    return name === "seed" ? String(BigInt(text)) : Number(text);
  }

  /** @param {string} [typed] */
  show(typed) {
    for (const name of FIELDS) {
      const text = String(this.settings[name]);
      input(`${name}-slider`).value = text;
      if (name === typed) continue;
      input(name).value = text;
      input(name).removeAttribute("aria-invalid");
    }
    const { name, rule } = this.given.strategies[this.settings.strategy];
    input("strategy").value = String(this.settings.strategy);
    $("rule").textContent = rule && capital(rule);
    document.title = `feasibee: ${this.settings.robots} robots, ${this.settings.tasks} tasks, ${name}`;
  }

  readAddress() {
    const kept = new URLSearchParams(location.hash.slice(1)),
      { strategies } = this.given;
    const number = strategies.findIndex((each) => each.name === kept.get("strategy"));
    if (number >= 0) kept.set("strategy", String(number));
    for (const name of Object.keys(this.settings)) {
      const value = this.parse(name, kept.get(name) ?? "");
      if (value !== null) this.settings = { ...this.settings, [name]: value };
    }
    this.show();
    this.changed(this.settings);
  }

  writeAddress() {
    const strategy = this.given.strategies[this.settings.strategy].name,
      kept = /** @type {Record<string, any>} */ ({ ...this.settings, strategy });
    history.replaceState(null, "", `#${new URLSearchParams(kept)}`);
  }
}
