// The plot of opinions over time, by uPlot, with the swarm's threshold and the step of its decision.

const FIRST_SPAN = 100;

/** @import { World } from "./arena.js" */
/** @import { Frame } from "./frames.js" */

/** @typedef {Record<"line" | "ink" | "muted" | "feasible" | "infeasible", string>} PlotColours */
/** @typedef {Pick<World, "last"> & {threshold: number, counted: [number, number], stopStep: number}} PlotWorld */

export class Plot {
  /** @type {Chart} */
  chart; // from build() on
  /** @type {PlotWorld} */
  world;
  /** @type {Float64Array<ArrayBuffer>[]} */
  data = [];
  known = 0; // steps
  shown = -1;
  decided = -1;

  /**
   * @param {HTMLElement} element
   * @param {PlotColours} colours
   */
  constructor(element, colours) {
    this.element = element;
    this.colours = colours;
    this.clear({ last: 1, threshold: 1, counted: [1, 1], stopStep: 0 });
  }

  /** @param {PlotWorld} world */
  clear(world) {
    this.world = world;
    this.known = 0;
    this.shown = -1;
    this.decided = -1;
    this.data = [0, 1, 2].map(() => new Float64Array(1024));
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
    }
    const { counted, stopStep } = this.world,
      [steps, feasible, infeasible] = this.data;
    for (let k = 0; k < frame.feasibleCounts.length; k++) {
      const step = frame.first + k,
        whole = Math.max(1, counted[step >= stopStep ? 1 : 0]);
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
        this.data.map((each) => each.subarray(0, length)),
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
        hooks: { draw: [(/** @type {Chart} */ chart) => this.mark(chart)] },
      },
      this.data.map((each) => each.subarray(0, 0)),
      this.element,
    );
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
