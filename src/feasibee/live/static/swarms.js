// A hundred swarms: runs 0 to 99 of the seed until they decide, simulated while the browser has nothing else to do.

import { drawSteps, fitted } from "./curve.js";
import { counted, OPINIONS, shareOf } from "./words.js";

/** @import { Shades } from "./theme.js" */
/** @import { Settings, World } from "./world.js" */

export const RUNS = 100;
const SLICE = 8; // milliseconds of work between two drawings
const CHUNK = 4000; // robots times steps between two looks at the clock
const BINS = 24;
const COLUMNS = [10, 20, 25, 50]; // of the marks of all runs

/** @typedef {{decision: number, step: number, isRight?: boolean}} Outcome */

export class Swarms {
  /**
   * @param {World} world A world of its own.
   * @param {() => void} changed Called after each slice of work.
   */
  constructor(world, changed) {
    this.world = world;
    this.changed = changed;
    /** @type {Outcome[]} */
    this.outcomes = [];
    /** @type {Settings | null} */
    this.settings = null;
    this.step = 0;
    this.timer = 0;
  }

  /** @param {Settings} settings */
  begin(settings) {
    const kind = { ...settings, run: 0 };
    if (JSON.stringify(this.settings) === JSON.stringify(kind)) return; // another run of the same
    clearTimeout(this.timer);
    this.settings = kind;
    this.outcomes = [];
    this.beginRun();
    this.timer = setTimeout(() => this.work(), 60);
  }

  beginRun() {
    this.step = 0;
    if (this.settings) this.world.begin({ ...this.settings, run: this.outcomes.length }, true);
  }

  work() {
    const { world } = this,
      { steps } = world.given.run,
      { feasibee_decision, feasibee_missing } = world.exports,
      chunk = Math.max(1, Math.round(CHUNK / ((this.settings?.robots ?? 0) + 1))),
      until = performance.now() + SLICE;
    while (this.outcomes.length < RUNS && performance.now() < until) {
      this.step = world.play("feasibee_play_on", chunk);
      if (this.step < 0) return; // the run that is shown says why
      const decision = feasibee_decision();
      if (decision < 0 && this.step < steps) continue;
      const isRight = decision === Number(feasibee_missing() === 0);
      this.outcomes.push({ decision, step: this.step, isRight });
      if (this.outcomes.length < RUNS) this.beginRun();
    }
    this.changed();
    if (this.outcomes.length < RUNS) this.timer = setTimeout(() => this.work());
  }

  /** @param {number} decision */
  count(decision) {
    return this.outcomes.filter((each) => each.decision === decision).length;
  }

  // The outcomes in sentences.
  sentences() {
    const done = this.outcomes.length;
    if (!done || !this.settings) return ["Simulating ..."];
    const steps = this.outcomes.filter((each) => each.decision >= 0).map((each) => each.step);
    const parts = [1, 0, -1]
      .filter((each) => each >= 0 || this.count(each))
      .map((each) => `${this.count(each)} ${OPINIONS[each]}`);
    const median = steps.sort((a, b) => a - b)[Math.floor((steps.length - 1) / 2)];
    return [
      `${counted(done, "swarm")}: ${parts.join(", ")}.`,
      `Share feasible: ${shareOf(this.count(1), done)}.`,
      `Share right: ${shareOf(this.outcomes.filter((each) => each.isRight).length, done)}.`,
      steps.length ? `Median step of the decisions: ${median.toLocaleString("en")}.` : "",
    ];
  }
}

/**
 * Draw a mark per run, as the robots of the arena.
 * @param {HTMLCanvasElement} canvas
 * @param {Pick<Swarms, "outcomes">} swarms
 * @param {number} chosen
 * @param {Shades} shades
 */
export function drawRuns(canvas, swarms, chosen, shades) {
  const { pen } = fitted(canvas),
    { columns, cell } = gridOf(canvas);
  for (let run = 0; run < RUNS; run++) {
    const x = ((run % columns) + 0.5) * cell,
      y = (Math.floor(run / columns) + 0.5) * cell,
      outcome = swarms.outcomes[run];
    if (run === chosen) {
      pen.fillStyle = shades.line;
      pen.strokeStyle = shades.ink;
      pen.lineWidth = 1.5;
      pen.beginPath();
      pen.roundRect(x - cell / 2 + 1, y - cell / 2 + 1, cell - 2, cell - 2, 4);
      pen.fill();
      pen.stroke();
    }
    pen.beginPath();
    const decision = outcome?.decision ?? -1,
      radius = cell * (outcome ? (decision < 0 ? 0.18 : 0.28) : 0.06);
    pen.arc(x, y, Math.max(0, decision === 0 ? radius - 1 : radius), 0, 2 * Math.PI);
    pen.fillStyle = pen.strokeStyle = [shades.infeasible, shades.feasible][decision] ?? shades.undecided;
    pen.lineWidth = Math.max(2, 0.14 * cell);
    if (decision === 0) pen.stroke();
    else pen.fill();
  }
}

/**
 * Return the grid of marks that fills a canvas best.
 * @param {HTMLCanvasElement} canvas
 */
function gridOf({ clientWidth, clientHeight }) {
  const grids = COLUMNS.map((columns) => ({
    columns,
    cell: Math.min(clientWidth / columns, (clientHeight * columns) / RUNS),
  }));
  return grids.reduce((best, grid) => (grid.cell > best.cell ? grid : best));
}

/**
 * Return the run whose mark is at a position; -1 if there is none.
 * @param {HTMLCanvasElement} canvas
 * @param {MouseEvent} event
 */
export function runAt(canvas, { offsetX, offsetY }) {
  const { columns, cell } = gridOf(canvas),
    column = Math.floor(offsetX / cell),
    run = columns * Math.floor(offsetY / cell) + column;
  return column < columns && run >= 0 && run < RUNS ? run : -1;
}

/**
 * Draw how many swarms decided when: feasible full, infeasible hollow and on top.
 * @param {HTMLCanvasElement} canvas
 * @param {Swarms} swarms
 * @param {Shades} shades
 */
export function drawHistogram(canvas, swarms, shades) {
  const { pen, box } = fitted(canvas),
    decided = swarms.outcomes.filter((each) => each.decision >= 0),
    longest = Math.max(48, ...decided.map((each) => each.step)),
    width = Math.ceil((longest + 1) / BINS),
    span = width * BINS;
  /** @param {number} decision */
  const bins = (decision) =>
    Array.from(
      { length: BINS },
      (_, k) =>
        decided.filter((each) => each.decision === decision && Math.floor(each.step / width) === k).length,
    );
  const [infeasible, feasible] = [bins(0), bins(1)],
    highest = Math.max(4, ...feasible.map((each, k) => each + infeasible[k]));
  drawSteps(pen, box, span, shades);
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  pen.fillText(String(highest), box.left - 6, box.top + 5);
  pen.fillText("0", box.left - 6, box.top + box.height);
  const bar = box.width / BINS,
    unit = box.height / highest;
  for (let k = 0; k < BINS; k++) {
    const x = box.left + k * bar + 1,
      low = box.top + box.height - feasible[k] * unit,
      high = low - infeasible[k] * unit;
    pen.fillStyle = shades.feasible;
    pen.fillRect(x, low, bar - 2, feasible[k] * unit);
    pen.strokeStyle = shades.infeasible;
    pen.lineWidth = 2;
    if (infeasible[k]) pen.strokeRect(x + 1, high + 1, bar - 4, Math.max(0, infeasible[k] * unit - 2));
  }
}
