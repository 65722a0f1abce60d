// Sliders and fields for what a reader may change, kept in the address.

import { $, announce, capital, formatted } from "./elements.js";
import { RUNS } from "./swarms.js";
import { sayTouching, touched } from "./touching.js";

/** @import { Frame } from "./frames.js" */
/** @import { Event } from "./touching.js" */
/** @import { Given, Settings } from "./world.js" */

const PAUSE = 200; // milliseconds: browsers limit how often a page may write its address
/** @type {("robots" | "tasks" | "seed" | "run")[]} */
const FIELDS = ["robots", "tasks", "seed", "run"]; // each with a slider
const PLACE = "\\d{1,7}(\\.\\d{1,9})?",
  CHANCE = `,"(sensing":\\{"miss|radio":\\{"loss)":${PLACE}\\}`,
  CHANGE = `,"((robots|tasks)":-?|(robot|task)":)\\d{1,5}|,"at":\\[${PLACE},${PLACE}\\]|${CHANCE}`,
  LISTED = new RegExp(`^\\[(\\{"step":\\d{1,5}(${CHANGE})*\\}(,(?!\\])|(?=\\])))*\\]$`); // in the address
const SLIDER = 100; // most robots or tasks on a slider, unless the file has more

/**
 * Return the element of a field.
 * @param {string} id
 */
const input = (id) => /** @type {HTMLInputElement} */ ($(id));

export class Controls {
  /**
   * @param {Given} given
   * @param {(settings: Settings, step: number) => boolean} changed The page shall show a run from a step on; false if it
   *   has no memory for it.
   * @param {() => (Frame & {playing: boolean}) | null} present The step after which sliders change the world; null if
   *   they start the run again.
   */
  constructor(given, changed, present) {
    this.given = given;
    this.changed = changed;
    this.present = present;
    const first = given.settings;
    this.settings = { ...first };
    /** @type {HTMLInputElement | null} */
    this.moved = null; // the slider that the reader moves
    this.late = 0;
    /** @type {Record<string, [number, number | bigint]>} */
    this.limits = {
      robots: given.counted ? [first.robots, first.robots] : [1, given.most.robots],
      tasks: given.counted ? [first.tasks, first.tasks] : [0, given.most.tasks],
      strategy: [0, given.strategies.length - 1],
      seed: [0, 2n ** 64n - 1n],
      run: [0, 2 ** 32 - 1],
    };
    for (const name of FIELDS) {
      const slider = input(`${name}-slider`);
      slider.max = String(name in given.most ? Math.max(SLIDER, Number(given.settings[name])) : RUNS - 1);
      slider.addEventListener("input", () => {
        this.moved = slider;
        if (name in given.most && present()) input(name).value = slider.value;
        else this.set({ [name]: slider.value });
      });
      slider.addEventListener("change", () => {
        this.moved = null;
        if (name === "robots" || name === "tasks") this.touch(name, slider.valueAsNumber);
      });
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
    const values = Object.entries(texts).map(([name, text]) => [name, this.parse(name, text)]),
      isFine =
        values.every(([, value]) => value !== null) &&
        this.take({ ...this.settings, ...Object.fromEntries(values) }, 0, typed);
    if (typed) input(typed).setAttribute("aria-invalid", String(!isFine));
  }

  /**
   * Change a number from the next step on, if the run can be.
   * @param {"robots" | "tasks"} name
   * @param {number} count
   */
  touch(name, count) {
    const now = this.present();
    if (!now || count === (name === "robots" ? now.there : now.tasks)) return;
    const { events, step } = touched(this.settings.events, now, name, count, now.playing);
    if (!this.amend(events, step, `${formatted(count)} ${name}`)) this.follow(now);
  }

  /**
   * Begin the run with these events from a step on, if it can be; return whether it can.
   * @param {Event[]} events
   * @param {number} step
   * @param {string} told What they change.
   */
  amend(events, step, told) {
    const { robots, tasks } = this.given.most,
      isFine = this.take({ ...this.settings, events }, step),
      most = `${formatted(robots)} robots and ${formatted(tasks)} tasks`;
    this.show();
    announce(
      isFine
        ? `From step ${formatted(step)} on: ${told}`
        : `Not changed: a run has 1 robot or more, and at most ${most}.`,
    );
    return isFine;
  }

  /**
   * Take settings, without events where none can be; return whether these can be.
   * @param {Settings} settings
   * @param {number} step
   * @param {string} [typed]
   */
  take(settings, step, typed) {
    const { strategies, most } = this.given,
      taken = strategies[settings.strategy].fixed ? { ...settings, events: [] } : settings;
    if (!canHappen(taken, most) || !this.changed(taken, step)) return false;
    this.settings = taken;
    this.show(typed);
    clearTimeout(this.late);
    this.late = setTimeout(() => this.writeAddress(), PAUSE);
    return true;
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

  /**
   * Let the sliders show the numbers of a step, unless the reader moves them.
   * @param {Frame} now
   */
  follow({ there, tasks }) {
    for (const [name, count] of Object.entries({ robots: there, tasks })) {
      const slider = input(`${name}-slider`);
      if (count > Number(slider.max)) slider.max = String(count);
      if (slider !== this.moved) slider.value = String(count);
    }
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
    const { name, rule, fixed } = this.given.strategies[this.settings.strategy];
    input("strategy").value = String(this.settings.strategy);
    $("rule").textContent = rule && capital(rule);
    sayTouching(fixed, this.given.counted);
    document.title = `feasibee: ${this.settings.robots} robots, ${this.settings.tasks} tasks, ${name}`;
  }

  readAddress() {
    const kept = new URLSearchParams(location.hash.slice(1)),
      { strategies } = this.given;
    const number = strategies.findIndex((each) => each.name === kept.get("strategy"));
    if (number >= 0) kept.set("strategy", String(number));
    for (const name of Object.keys(this.limits)) {
      const value = this.parse(name, kept.get(name) ?? "");
      if (value !== null) this.settings = { ...this.settings, [name]: value };
    }
    const given = kept.get("events")?.match(LISTED)?.[0],
      events = /** @type {Event[]} */ (given ? JSON.parse(given) : this.given.settings.events);
    events.sort((one, other) => one.step - other.step);
    if (!this.take({ ...this.settings, events }, 0)) this.take({ ...this.settings, events: [] }, 0);
    clearTimeout(this.late); // the address has them
  }

  writeAddress() {
    const strategy = this.given.strategies[this.settings.strategy].name,
      events = JSON.stringify(this.settings.events),
      kept = /** @type {Record<string, any>} */ ({ ...this.settings, strategy, events });
    if (events === JSON.stringify(this.given.settings.events)) delete kept.events;
    history.replaceState(null, "", `#${new URLSearchParams(kept)}`);
  }
}

/**
 * Whether a page can simulate the events of settings: there are enough to go, and not too many that come.
 * @param {Settings} settings
 * @param {Given["most"]} most
 */
function canHappen({ events, ...start }, most) {
  return /** @type {const} */ (["robots", "tasks"]).every((name) => {
    let [there, all] = [start[name], start[name]];
    const named = name === "robots" ? "robot" : "task";
    return events.every(({ step, at, [named]: which, [name]: more = 0 }) => {
      there += more - Number(which !== undefined && !at);
      all += Math.max(0, more);
      return step >= 0 && there >= Number(name === "robots") && all <= most[name];
    });
  });
}
