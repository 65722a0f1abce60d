// The list of a sweep's runs under their points, each a button that replays its run.

import { $, formatted, make } from "./elements.js";

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
const UNFOLDED = 12; // with more points than this, only that of the run that is shown is unfolded

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
  /** @type {Map<number, Replay[]>} */
  const points = new Map();
  for (const replay of replays) points.set(replay.point, [...(points.get(replay.point) ?? []), replay]);
  const unfolded = points.size <= UNFOLDED;
  $("replay-list").replaceChildren(...[...points.values()].map((runs) => pointOf(runs, unfolded, choose)));
}

/**
 * Return a point of the sweep with its runs.
 * @param {Replay[]} runs
 * @param {boolean} open
 * @param {(replay: Replay) => void} choose
 */
function pointOf(runs, open, choose) {
  const values = Object.entries(runs[0].values).map(([path, value]) => `${path} ${value}`),
    title = values.join(", ") || `point ${runs[0].point}`,
    count = make("small", {}, runs.length === 1 ? " 1 run" : ` ${runs.length} runs`);
  const items = runs.map((replay) => {
    const step = replay.decision_step >= 0 ? ` at step ${replay.decision_step}` : "",
      text = `run ${replay.run}: ${replay.decision}${step}`,
      button = make("button", { type: "button", onclick: () => choose(replay) }, text);
    button.dataset.key = keyOf(replay.point, replay.run);
    return make("li", {}, button);
  });
  return make(
    "li",
    {},
    make("details", { open }, make("summary", {}, title, count), make("ol", {}, ...items)),
  );
}

/**
 * Mark the listed run that the page shows, and unfold its point.
 * @param {number | null} point
 * @param {string} run
 */
export function markReplay(point, run) {
  for (const button of /** @type {NodeListOf<HTMLElement>} */ ($("replay-list").querySelectorAll("button"))) {
    const shown = button.dataset.key === keyOf(point, run),
      group = button.closest("details");
    button.setAttribute("aria-current", String(shown));
    if (shown && group) group.open = true;
  }
}
