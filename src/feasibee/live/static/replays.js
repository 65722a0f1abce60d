// The list of a sweep's runs, each a button that replays its run.

import { $, formatted } from "./elements.js";

/**
 * @typedef {object} Replay
 * @property {number} point
 * @property {string} run
 * @property {string} seed
 * @property {Record<string, string>} values
 * @property {string} decision
 * @property {number} decision_step
 */

/** @type {Record<string, string>} */
const KINDS = {
  wrong: "that decided wrong",
  right: "that decided right",
  undecided: "that didn't decide",
  all: "in the sweep",
};

/**
 * @param {number | null} point
 * @param {string} run
 */
const keyOf = (point, run) => `${point} ${run}`;

/**
 * Fill the list; it stays hidden without replays.
 * @param {{replays: Replay[], pick: string, found: number}} message
 * @param {(replay: Replay) => void} choose Somebody chose a run.
 */
export function listReplays({ replays, pick, found }, choose) {
  $("replays").hidden = !replays.length;
  const kind = KINDS[pick] ?? `that decided ${pick}`,
    listed = found > replays.length ? `; ${replays.length} listed` : "";
  $("replays-title").textContent = `${formatted(found)} runs ${kind}${listed}`;
  $("replay-list").replaceChildren(...replays.map((replay) => itemOf(replay, choose)));
}

/**
 * @param {Replay} replay
 * @param {(replay: Replay) => void} choose
 */
function itemOf(replay, choose) {
  const item = document.createElement("li"),
    button = document.createElement("button"),
    main = document.createElement("span"),
    more = document.createElement("small");
  const values = Object.entries(replay.values).map(([path, value]) => `${path} ${value}`);
  const step = replay.decision_step >= 0 ? ` at step ${replay.decision_step}` : "";
  main.textContent = values.join(", ") || `point ${replay.point}`;
  more.textContent = `run ${replay.run}: ${replay.decision}${step}`;
  button.type = "button";
  button.append(main, more);
  button.addEventListener("click", () => choose(replay));
  item.dataset.key = keyOf(replay.point, replay.run);
  item.append(button);
  return item;
}

/**
 * Mark the listed run that the page shows.
 * @param {number | null} point
 * @param {string} run
 */
export function markReplay(point, run) {
  for (const item of /** @type {HTMLCollectionOf<HTMLElement>} */ ($("replay-list").children)) {
    const shown = item.dataset.key === keyOf(point, run);
    item.firstElementChild?.setAttribute("aria-current", String(shown));
  }
}
