// Robots and tasks that hands put, move and remove during a run: as events of its scenario, which can be copied.

import { unfold } from "./elements.js";

const PLACE = "\\d{1,7}(\\.\\d{1,9})?",
  CHANCE = `,"(sensing":\\{"miss|radio":\\{"loss)":${PLACE}\\}`,
  CHANGE = `,"((robots|tasks)":-?|(robot|task)":)\\d{1,5}|,"at":\\[${PLACE},${PLACE}\\]|${CHANCE}`,
  IN_ADDRESS = new RegExp(`^\\[(\\{"step":\\d{1,5}(${CHANGE})*\\}(,(?!\\])|(?=\\])))*\\]$`);

/**
 * Return the events of a run with one more at the next step, and that step; while time stands still, at the present one
 * if that has events, or is the start.
 * @param {WorldEvent[]} events
 * @param {number} now
 * @param {Change} change
 * @param {boolean} playing
 * @returns {{step: number, events: WorldEvent[]}}
 */
export function handled(events, now, change, playing) {
  const still = !playing && (!now || events.some((each) => each.step === now)),
    step = still ? now : now + 1;
  return { step, events: [...events, { step, ...change }].sort((one, other) => one.step - other.step) };
}

/**
 * Whether a page can simulate events from a start on: there are enough to go, and not too many that come.
 * @param {Pick<Settings, "events" | "robots" | "tasks">} start
 * @param {{robots: number, tasks: number}} most
 */
export function canHappen({ events, ...start }, most) {
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

/**
 * Return the events that an address keeps, in their order; null if they are none, or can't be.
 * @param {string} text
 * @param {{robots: number, tasks: number}} start
 * @param {{robots: number, tasks: number}} most
 */
export function eventsIn(text, start, most) {
  if (!IN_ADDRESS.test(text)) return null;
  const events = /** @type {WorldEvent[]} */ (JSON.parse(text)).sort((one, other) => one.step - other.step);
  return canHappen({ ...start, events }, most) ? events : null;
}

/**
 * Return the scenario of settings as TOML: that of the page, with these values.
 * @param {Opened} opened
 * @param {Settings} settings
 */
export function scenarioOf({ toml, strategies, settings: first, patches }, settings) {
  const { robots, tasks, strategy, events, sight, radio, speed } = settings,
    { name, knows } = strategies[strategy],
    rows = events.map((each) => `    ${inToml(each)},\n`);
  let text = toml
    .replace(/^events = \[\n[^]*?\n\]\n+/, "")
    .replace(/^\[(\[events\]|events\.\w+)\]\n([^[\n].*\n|\n)*/gm, ""); // as Python writes long ones
  /** @param {string} section @param {string} key @param {any} value */
  const set = (section, key, value) => {
    const found = new RegExp(`(^\\[${section}\\]\\n(?:(?!\\[).*\\n)*?${key} = ).*`, "m");
    text = text.replace(found, (_, before) => `${before}${inToml(value)}`);
  };
  set("robots", "count", robots);
  set("tasks", "count", tasks);
  if (patches) {
    set("sensing", "range", sight);
    set("radio", "range", radio);
    set("robots", "speed", speed);
  }
  if (strategy !== first.strategy) {
    set("robots", "know_count", knows);
    set("decision", "strategy", name);
    text = text.replace(/^\[decision\.parameters\]\n(.+\n)*\n/m, ""); // they have the new one's defaults
  }
  return rows.length ? `events = [\n${rows.join("")}]\n\n${text}` : text;
}

/**
 * Return a value as TOML has it, in one line.
 * @param {any} value
 * @returns {string}
 */
export function inToml(value) {
  if (Array.isArray(value)) return `[${value.map(inToml).join(", ")}]`;
  if (typeof value !== "object") return JSON.stringify(value);
  return `{ ${Object.entries(value)
    .map(([name, each]) => `${name} = ${inToml(each)}`)
    .join(", ")} }`;
}

/**
 * Copy a scenario that is shown, or select it where the browser gives the page no clipboard.
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
    getSelection()?.selectAllChildren(shown); // in a frame, or by http from another machine
    button.textContent = "Selected: press Ctrl-C";
  }
  setTimeout(() => (button.textContent = text), 2000);
}
