// The plot of opinions over time, by uPlot, with the swarm's threshold and the step of its decision.

import { drawTruth } from "./truths.js";

const FIRST_SPAN = 100;
const BAND = 6; // height of the band of the truth, in CSS pixels

/** @import { World } from "./arena.js" */
/** @import { Frame } from "./frames.js" */

/** @typedef {Record<"line" | "ink" | "muted" | "feasible" | "infeasible", string>} PlotColours */
/** @typedef {Pick<World, "last" | "changes"> & {threshold: number}} PlotWorld */

export class Plot {
  /** @type {Chart} */
  chart; // from build() on
  /** @type {PlotWorld} */
  world;
  /** @type {Float64Array<ArrayBuffer>[]} */
  data = [];
  truths = new Uint8Array(0);
  known = 0; // steps
  from = 0; // first step that is known
  shown = -1;
  decided = -1;

  /**
   * @param {HTMLElement} element
   * @param {PlotColours} colours
   */
  constructor(element, colours) {
    this.element = element;
    this.colours = colours;
    this.clear({ last: 1, threshold: 1, changes: false });
  }

  /** @param {PlotWorld} world */
  clear(world) {
    this.world = world;
    this.known = 0;
    this.shown = -1;
    this.decided = -1;
    this.data = [0, 1, 2].map(() => new Float64Array(1024));
    this.truths = new Uint8Array(1024);
    this.build();
  }

  /** @param {PlotColours} colours */
  setColours(colours) {
    this.colours = colours;
    this.build();
    this.show(this.shown, this.decided);
  }

  /** @param {Frame} frame */
  add(frame) {
    const until = frame.first + frame.feasibleCounts.length;
    if (until > this.data[0].length) {
      this.data = this.data.map((old) => {
        const longer = new Float64Array(2 * until);
        longer.set(old);
        return longer;
      });
      const truths = new Uint8Array(2 * until);
      truths.set(this.truths);
      this.truths = truths;
    }
    const [steps, feasible, infeasible] = this.data;
    if (!this.known) this.from = frame.first;
    for (let k = 0; k < frame.feasibleCounts.length; k++) {
      const step = frame.first + k,
        whole = Math.max(1, frame.countedCounts[k]);
      this.truths[step] = frame.truths[k];
      steps[step] = step;
      feasible[step] = (100 * frame.feasibleCounts[k]) / whole;
      infeasible[step] = (100 * frame.infeasibleCounts[k]) / whole;
    }
    this.known = Math.max(this.known, until);
  }

  /**
   * @param {number} step
   * @param {number} decided
   */
  show(step, decided) {
    this.shown = step;
    this.decided = decided;
    const length = Math.min(this.known, step + 1);
    let span = this.world.last;
    while (span / 2 > Math.max(step, FIRST_SPAN)) span /= 2;
    this.chart.batch(() => {
      this.chart.setData(
        this.data.map((each) => each.subarray(Math.min(this.from, length), length)),
        false,
      );
      this.chart.setScale("x", { min: 0, max: Math.max(1, span) });
      this.chart.setScale("y", { min: 0, max: 100 });
      this.chart.redraw(false, true);
    });
  }

  resize() {
    this.chart.setSize(this.size());
  }

  size() {
    return {
      width: Math.max(120, this.element.clientWidth),
      height: Math.max(120, this.element.clientHeight),
    };
  }

  build() {
    this.chart?.destroy();
    const { colours } = this;
    const font = `11px ${getComputedStyle(this.element).fontFamily}`;
    const axis = {
      stroke: colours.muted,
      font,
      grid: { stroke: colours.line, width: 1 },
      ticks: { show: false },
    };
    /**
     * @param {string} colour
     * @param {number[]} [dash]
     */
    const series = (colour, dash) => ({ stroke: colour, width: 1.75, dash, points: { show: false } });
    this.chart = new uPlot(
      {
        ...this.size(),
        padding: [10, 22, 0, 0],
        legend: { show: false },
        cursor: { show: false },
        scales: { x: { time: false }, y: {} },
        axes: [
          { ...axis, size: 26, space: 60 },
          { ...axis, size: 34, splits: () => [0, 25, 50, 75, 100] },
        ],
        series: [{}, series(colours.feasible), series(colours.infeasible, [6, 3])],
        hooks: {
          drawAxes: [(/** @type {Chart} */ chart) => this.band(chart)],
          draw: [(/** @type {Chart} */ chart) => this.mark(chart)],
        },
      },
      this.data.map((each) => each.subarray(0, 0)),
      this.element,
    );
  }

  /**
   * Draw the truth of each step behind the opinions, in a world that changes: a band, and a shade below it.
   * @param {Chart} chart
   */
  band(chart) {
    const length = Math.min(this.known, this.shown + 1);
    if (!this.world.changes || !length) return;
    const pen = chart.ctx,
      { top, height } = chart.bbox,
      ratio = devicePixelRatio || 1;
    for (let from = 0, step = 1; step <= length; step++) {
      if (step < length && this.truths[step] === this.truths[from]) continue;
      const x = chart.valToPos(from, "x", true),
        width = chart.valToPos(step < length ? step : length - 1, "x", true) - x,
        truth = this.truths[from] === 1;
      drawTruth(pen, { x, y: top - BAND * ratio, width, height: BAND * ratio }, truth, this.colours, ratio);
      pen.globalAlpha = 0.1;
      pen.fillStyle = truth ? this.colours.feasible : this.colours.infeasible;
      pen.fillRect(x, top, width, height);
      pen.globalAlpha = 1;
      from = step;
    }
  }

  /** @param {Chart} chart */
  mark(chart) {
    const pen = chart.ctx,
      { left, top, width, height } = chart.bbox,
      ratio = devicePixelRatio || 1;
    const y = chart.valToPos(100 * this.world.threshold, "y", true);
    pen.save();
    pen.strokeStyle = this.colours.muted;
    pen.lineWidth = ratio;
    pen.setLineDash([2 * ratio, 3 * ratio]);
    pen.beginPath();
    pen.moveTo(left, y);
    pen.lineTo(left + width, y);
    pen.stroke();
    if (this.decided >= 0) {
      const x = chart.valToPos(this.decided, "x", true),
        late = x > left + 0.7 * width;
      pen.setLineDash([]);
      pen.strokeStyle = pen.fillStyle = this.colours.ink;
      pen.beginPath();
      pen.moveTo(x, top);
      pen.lineTo(x, top + height);
      pen.stroke();
      pen.font = `${11 * ratio}px ${getComputedStyle(this.element).fontFamily}`;
      pen.textAlign = late ? "right" : "left";
      pen.textBaseline = "middle";
      pen.fillText(`decided at ${this.decided}`, x + (late ? -5 : 5) * ratio, top + height / 2);
    }
    pen.restore();
  }
}
