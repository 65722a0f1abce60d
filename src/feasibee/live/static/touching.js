// Robots and tasks that come and go during a run: as events of its scenario, which can be copied.

import { $, unfold } from "./elements.js";

/** @import { Given, Settings } from "./world.js" */

/** @type {Record<string, "robots" | "tasks">} */
export const EVENTS = { "robots.count": "robots", "tasks.count": "tasks" }; // what an event can change, by its field

/**
 * How many come at a step, or go; or where; or which one goes or is put there. A scenario's may also change its errors.
 * @typedef {{robots?: number, tasks?: number, robot?: number, task?: number, at?: [number, number]}} Change
 * @typedef {{step: number, sensing?: {miss?: number}, radio?: {loss?: number}} & Change} Event
 */

/**
 * Return the events of a run with a number of robots or tasks from the next step on, and that step. What was changed at
 * the present step, while time stands still, is amended.
 * @param {Event[]} events
 * @param {{step: number, there: number, tasks: number}} now
 * @param {"robots" | "tasks"} name
 * @param {number} count
 * @param {boolean} playing
 * @returns {{step: number, events: Event[]}}
 */
export function touched(events, now, name, count, playing) {
  const all = events.map((each) => ({ ...each })),
    counts = all.filter((each) => !["at", "task", "robot"].some((key) => key in each)),
    last = playing ? undefined : counts.find((each) => each.step === now.step && each[name]),
    step = last ? now.step : now.step + 1,
    next = last ?? counts.find((each) => each.step === step) ?? { step };
  next[name] = (next[name] ?? 0) + count - (name === "robots" ? now.there : now.tasks);
  const isIdle = Object.entries(next).every(([key, value]) => key === "step" || !value),
    kept = [...all.filter((each) => each !== next), ...(isIdle ? [] : [next])];
  return { step, events: kept.sort((one, other) => one.step - other.step) };
}

/**
 * Return the events of a run with one more at the next step, and that step; while time stands still, at the present one
 * if that has events, or is the start.
 * @param {Event[]} events
 * @param {number} now
 * @param {Change} change
 * @param {boolean} playing
 * @returns {{step: number, events: Event[]}}
 */
export function handled(events, now, change, playing) {
  const still = !playing && (!now || events.some((each) => each.step === now)),
    step = still ? now : now + 1;
  return { step, events: [...events, { step, ...change }].sort((one, other) => one.step - other.step) };
}

/**
 * Return the scenario of settings as TOML: that of the page, with these values.
 * @param {Given} given
 * @param {Settings} settings
 */
export function scenarioOf({ toml, strategies, settings: first }, { robots, tasks, strategy, events }) {
  const { name, knows } = strategies[strategy],
    rows = events.map((each) => `    ${inToml(each)},\n`);
  let text = toml.replace(/^events = \[\n[^]*?\n\]\n+/, "");
  text = withValue(withValue(text, "robots", "count", robots), "tasks", "count", tasks);
  if (strategy !== first.strategy) {
    text = withValue(text, "robots", "know_count", knows);
    text = withValue(text, "decision", "strategy", JSON.stringify(name));
    text = text.replace(/^\[decision\.parameters\]\n(.+\n)*\n/m, ""); // they have the new one's defaults
  }
  return rows.length ? `events = [\n${rows.join("")}]\n\n${text}` : text;
}

/**
 * Return a value as TOML has it.
 * @param {any} value
 * @returns {string}
 */
function inToml(value) {
  if (Array.isArray(value) || typeof value !== "object") return JSON.stringify(value);
  return `{ ${Object.entries(value)
    .map(([name, each]) => `${name} = ${inToml(each)}`)
    .join(", ")} }`;
}

/**
 * Return a scenario with another value of a field that it has.
 * @param {string} toml
 * @param {string} section
 * @param {string} key
 * @param {number | boolean | string} value
 */
function withValue(toml, section, key, value) {
  const found = new RegExp(`(^\\[${section}\\]\\n(?:(?!\\[).*\\n)*?${key} = ).*`, "m");
  return toml.replace(found, (_, before) => `${before}${value}`);
}

/**
 * @param {string} fixed Why events can't change the world; empty if they can.
 * @param {string} [counted] Why the numbers at the start can't be changed; likewise.
 */
export function sayTouching(fixed, counted = "") {
  const start = counted && `${counted}. `;
  $("touching").textContent = fixed
    ? `${start}Each change starts this run again. ${fixed}.`
    : `${start}During a run, the sliders of robots and tasks change the world from the next step on.`;
}

/** @param {string} id Of a button that copies the scenario that the page shows. */
export function listenToCopy(id) {
  $(id).addEventListener("click", () => copy($(id), $("toml")));
}

/**
 * Copy a scenario that is shown.
 * @param {HTMLElement} button It says what has been done.
 * @param {HTMLElement} shown
 */
export async function copy(button, shown) {
  const text = button.textContent;
  try {
    await navigator.clipboard.writeText(shown.textContent);
    button.textContent = "Copied";
  } catch {
    unfold(shown);
    getSelection()?.selectAllChildren(shown); // a page by http from another machine has no clipboard
    button.textContent = "Selected: press Ctrl-C";
  }
  setTimeout(() => (button.textContent = text), 2000);
}
