// The list of a sweep's runs under their points, each a button that replays its run.

import { formatted, make } from "./elements.js";

const UNFOLDED = 12; // points of a sweep; if it has more, each is folded at first
/** @type {Record<string, string>} */
const PICKED = {
  wrong: "that decided wrong",
  right: "that decided right",
  undecided: "that didn't decide",
  all: "in the sweep",
};

export class Replays {
  /**
   * @param {{replays: Replay[], pick: string, found: number}} sweep
   * @param {(which: {point: number, seed: string, run: number}) => void} choose Somebody chose a run.
   */
  constructor({ replays, pick, found }, choose) {
    const listed = found > replays.length ? `; ${formatted(replays.length)} listed` : "",
      title = `${formatted(found)} runs ${PICKED[pick] ?? `that decided ${pick}`}${listed}`,
      points = [...new Set(replays.map(({ point }) => point))];
    this.items = replays.map((replay) => {
      const step = replay.decision_step >= 0 ? ` at step ${formatted(replay.decision_step)}` : "",
        text = `run ${replay.run}: ${replay.decision}${step}`,
        button = make("button", { type: "button", className: "quiet" }, text);
      button.onclick = () => choose({ ...replay, run: Number(replay.run) });
      return { replay, button };
    });
    const groups = points.map((point) => {
      const items = this.items.filter(({ replay }) => replay.point === point),
        values = Object.entries(items[0].replay.values).map(([path, value]) => `${path} ${value}`),
        count = make("small", {}, items.length === 1 ? " 1 run" : ` ${items.length} runs`),
        summary = make("summary", {}, values.join(", ") || `point ${point}`, count),
        open = points.length <= UNFOLDED;
      return make("details", { open }, summary, ...items.map(({ button }) => button));
    });
    this.element = make("div", { className: "replays", role: "group" }, make("h3", {}, title), ...groups);
    this.element.setAttribute("aria-label", title);
  }

  /**
   * Mark the run that the page shows.
   * @param {number | null} point
   * @param {{seed: string, run: number}} settings
   */
  mark(point, { seed, run }) {
    for (const { replay, button } of this.items) {
      const isShown = replay.point === point && replay.run === String(run) && replay.seed === String(seed);
      button.setAttribute("aria-current", String(isShown));
    }
  }
}
