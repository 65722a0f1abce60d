// The share of robots with each opinion over the steps of a run, on uPlot, and behind it those of a hundred other swarms.

import { contextOf, escaped, formatted, make } from "./elements.js";
import { truthBand } from "./seekbar.js";

/**
 * What to draw: one or two runs, and names of their strategies; clouds: robots for feasible at each step of other swarms,
 * until they stopped.
 * @typedef {{histories: RunHistory[], names: string[], step: number, clouds: Uint16Array[], prediction: Prediction | null,
 *   shades: Shades}} Scene
 */
/** @typedef {{label: string, stroke: string, dash: number[], look: string, share: (at: number) => number | null}} Line look: in the legend. */

const FIRST_SPAN = 100; // steps
const MOST_LATE = 0.1; // share of the other swarms whose last steps may be beyond the right edge
const TRUTH = 7; // height of the band of the truth, above the plot
const GAPS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000]; // between two ticks

/** @type {(form: (value: number) => any) => (chart: any, values: number[]) => any[]} */
const forAll = (form) => (_, values) => values.map(form);
/** @type {(form: (value: number) => string) => (chart: any, value: number | null) => string} */
const ifAny = (form) => (_, value) => (value == null ? "" : form(value));
const percent = (/** @type {number} */ share) => `${Math.round(100 * share)} %`;

export class Plot {
  /** @type {any} */
  chart = null; // of uPlot, which the page loads before its modules
  /** @type {Scene} */
  scene; // from draw() on
  made = ""; // what the chart was made for
  width = 0;
  height = 0;
  span = 0; // steps from the left to the right edge
  /** @type {{key: string, first?: Uint16Array, count: number}} */
  painted = { key: "", count: 0 }; // of the cloud

  /**
   * @param {HTMLElement} place
   * @param {(step: number) => void} seek Called with the step that somebody clicks.
   */
  constructor(place, seek) {
    const redraw = () => this.scene && this.draw(this.scene);
    this.place = place;
    this.cloud = make("canvas", {}); // it takes long to draw, and seldom changes
    this.marks = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    new ResizeObserver(([{ contentRect }]) => {
      [this.width, this.height] = [contentRect.width, contentRect.height].map(Math.floor);
      redraw();
    }).observe(place);
    place.addEventListener("mouseleave", redraw); // so that its numbers are those of the present step again
    place.addEventListener("click", ({ target }) => {
      if (target === this.chart?.over) seek(Math.round(this.chart.posToVal(this.chart.cursor.left, "x")));
    });
  }

  /** @param {Scene} scene */
  draw(scene) {
    const lines = linesOf(scene),
      key = JSON.stringify([this.width, this.height, devicePixelRatio, scene.shades, lines]);
    this.scene = scene;
    if (!this.width || !this.height) return;
    this.span = spanOf(scene);
    const steps = Array.from({ length: this.span + 1 }, (_, at) => at),
      data = [steps, ...lines.map(({ share }) => steps.map(share))];
    if (key === this.made) this.chart.setData(data);
    else this.make(lines, data);
    this.made = key;
    if (this.chart.cursor.idx == null) this.chart.setLegend({ idx: scene.step }, false);
    this.mark();
    this.paintCloud();
  }

  /**
   * Make the chart anew, of another size, with other lines or in other colours.
   * @param {Line[]} lines
   * @param {(number | null)[][]} data
   */
  make(lines, data) {
    const { place, width, height, scene } = this,
      { muted } = scene.shades,
      font = `12px ${getComputedStyle(place).fontFamily}`,
      axis = { stroke: muted, font, ticks: { show: false }, gap: 5, grid: { show: false } },
      dash = (/** @type {any} */ _, /** @type {number} */ k) => lines[k - 1].look,
      usual = { width: 2, points: { show: false }, value: ifAny(percent) };
    this.chart?.destroy();
    this.chart = new /** @type {any} */ (globalThis).uPlot(
      {
        ...{ width, height, padding: [TRUTH + 3, 18, 0, 0], legend: { markers: { dash } } },
        cursor: { y: false, drag: { x: false }, points: { size: 7 }, bind: { dblclick: () => null } },
        scales: { x: { time: false, range: () => [0, this.span] }, y: { range: [0, 1] } },
        axes: [
          {
            ...axis,
            ...{ size: 20, space: 50, incrs: GAPS, values: forAll(formatted) },
            border: { show: true, stroke: muted, width: 1 },
          },
          { ...axis, size: 44, splits: [0, 0.5, thresholdOf(scene)], values: forAll(percent) },
        ],
        series: [{ label: "Step", value: ifAny(formatted) }, ...lines.map((each) => ({ ...usual, ...each }))],
      },
      data,
      place,
    );
    const { root, under, over } = this.chart,
      legend = root.querySelector(".u-legend");
    under.append(this.cloud);
    over.append(this.marks);
    legend.style.width = `${width}px`;
    this.chart.setSize({ width, height: Math.max(60, height - legend.offsetHeight) });
  }

  // Mark the truth, the threshold, and where the swarms decide.
  mark() {
    const { scene, span } = this,
      { histories, names } = scene,
      across = `${100 * (1 - thresholdOf(scene))}%`;
    const decisions = histories.map(({ decisionStep: at }, k) => {
      if (at < 0 || at > span) return "";
      const isLate = at > 0.7 * span,
        x = `${(100 * at) / span}%`,
        name = histories.length > 1 ? names[k] : "decision";
      return `<line x1="${x}" x2="${x}" y2="100%" stroke-dasharray="${k ? "4 3" : ""}"/>
        <text x="${x}" dx="${isLate ? -5 : 5}" y="35%" dy="${15 * k}" text-anchor="${isLate ? "end" : "start"}">${escaped(name)}</text>`;
    });
    this.marks.innerHTML = `${histories[0].changes ? truthBand(histories[0], span, -TRUTH) : ""}
      <line x2="100%" y1="${across}" y2="${across}" stroke-dasharray="2 3"/>${decisions.join("")}`;
  }

  // Draw the curves of other swarms that aren't drawn yet, thinner from where they stopped, below the lines.
  paintCloud() {
    const { cloud, span, made, painted, chart, scene } = this,
      { clouds, histories, shades } = scene,
      [{ numbers, known, changes }] = histories,
      { counted } = numbers,
      { width, height } = chart.bbox,
      key = [made, width, height, span, counted[0], changes && known].join();
    if (key !== painted.key || clouds[0] !== painted.first) {
      [cloud.width, cloud.height] = [width, height]; // which empties it
      this.painted = { key, first: clouds[0], count: 0 };
    }
    const pen = contextOf(cloud),
      gap = Math.max(1, Math.floor(span / width)),
      x = (/** @type {number} */ at) => (width * at) / span;
    pen.strokeStyle = shades.muted;
    pen.lineWidth = devicePixelRatio;
    for (const course of clouds.slice(this.painted.count)) {
      const stop = Math.min(span, course.length - 1),
        y = (/** @type {number} */ at) => height * (1 - course[at] / (counted[Math.min(at, known)] || 1));
      pen.globalAlpha = 0.25;
      pen.beginPath();
      for (let at = 0; at < stop; at += gap) pen.lineTo(x(at), y(at));
      pen.lineTo(x(stop), y(stop));
      pen.stroke();
      pen.globalAlpha = 0.03;
      pen.stroke(new Path2D(`M${x(stop)} ${y(stop)}H${width}`));
    }
    this.painted.count = clouds.length;
  }
}

/** @param {Scene} scene */
const thresholdOf = ({ histories }) => histories[0].opened.threshold;

/**
 * Return the lines of a plot.
 * @param {Scene} scene
 * @returns {Line[]}
 */
function linesOf({ histories, names, step, prediction, shades }) {
  const [run, beside] = histories,
    [own, other] = names.map((name) => (beside ? `, ${name}` : "")),
    opinions = prediction?.opinions;
  /** @type {(run: RunHistory, opinion: "feasible" | "infeasible") => Line["share"]} */
  const until =
    ({ numbers, known }, opinion) =>
    (at) =>
      at > step || at > known ? null : numbers[opinion][at] / Math.max(1, numbers.counted[at]);
  /** @type {(label: string, stroke: string, dash: number[], look: string, share: Line["share"]) => Line} */
  const line = (label, stroke, dash, look, share) => ({ label, stroke, dash, look, share });
  const lines = [
    line(`infeasible${own}`, shades.infeasible, [6, 4], "dashed", until(run, "infeasible")),
    line(`feasible${own}`, shades.feasible, [], "solid", until(run, "feasible")),
  ];
  if (beside) lines.push(line(`feasible${other}`, shades.ink, [12, 4], "dashed", until(beside, "feasible")));
  if (opinions)
    lines.push(
      line("mean by theory", shades.muted, [2, 4], "dotted", (at) => (opinions[at] ?? opinions.at(-1))[0]),
    );
  return lines;
}

/**
 * Return the last step to show: a round number after the present step and the decisions, those of most other swarms, too.
 * @param {Scene} scene
 */
function spanOf({ histories, step, clouds }) {
  const ends = clouds.map(({ length }) => length - 1).sort((a, b) => a - b),
    late = ends[Math.ceil((1 - MOST_LATE) * ends.length) - 1] ?? 0,
    needed = Math.max(FIRST_SPAN, step, late, ...histories.map((each) => each.decisionStep)),
    power = 10 ** Math.floor(Math.log10(needed)),
    round = power * ([1, 2, 5].find((each) => each * power >= needed) ?? 10);
  return Math.max(1, Math.min(round, Math.max(...histories.map((each) => each.last), ends.at(-1) ?? 0)));
}
