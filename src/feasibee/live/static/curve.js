// The share of robots with each opinion over time, with the threshold of the decision, and the band of the truth.

import { contextOf } from "./crowd.js";

/** @import { Shades } from "./theme.js" */

/**
 * What is known of a run, by step: a recording of this page, or what the server has sent.
 * @typedef {object} Course
 * @property {number} last
 * @property {ArrayLike<number>} feasible
 * @property {ArrayLike<number>} infeasible
 * @property {ArrayLike<number>} counted
 * @property {number} decisionStep -1 for none.
 * @property {ArrayLike<number>} [truths] In a world that changes.
 */
/** @typedef {{left: number, top: number, width: number, height: number}} Box */
/**
 * What theory says, by prediction.py; opinions by step: mean share for feasible, and its 5 and 95 % quantiles.
 * @typedef {{text: string, opinions?: number[][], tips?: number | null, tasks?: number | null}} Prediction
 */

const FIRST_SPAN = 100; // steps
const POINTS = 10_000; // most points of a line: more take long to draw, and no screen is so wide
const EXPECTED = [8, 3, 1.5, 3]; // dashes, as in the legend below
const TIPPING = [10, 6];
const BAND = 6; // height of the band of the truth
const MARGIN = { left: 40, top: 8, right: 18, bottom: 20 };

/**
 * Fit a canvas to its place on the page; return its pen, in CSS pixels, and the box within the axes.
 * @param {HTMLCanvasElement} canvas
 * @returns {{pen: CanvasRenderingContext2D, box: Box}}
 */
export function fitted(canvas) {
  const ratio = devicePixelRatio || 1,
    { clientWidth, clientHeight } = canvas;
  canvas.width = Math.round(clientWidth * ratio);
  canvas.height = Math.round(clientHeight * ratio);
  const pen = contextOf(canvas);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.font = `12px ${getComputedStyle(canvas).fontFamily}`;
  const { left, top, right, bottom } = MARGIN;
  return {
    pen,
    box: { left, top, width: clientWidth - left - right, height: clientHeight - top - bottom },
  };
}

/**
 * Draw the axis of steps: a tick every 1, 2 or 5 times a power of ten.
 * @param {CanvasRenderingContext2D} pen
 * @param {Box} box
 * @param {number} span
 * @param {Shades} shades
 */
export function drawSteps(pen, box, span, shades) {
  const rough = (span * 60) / Math.max(60, box.width),
    power = 10 ** Math.floor(Math.log10(rough));
  const gap = Math.max(1, power * (rough > 5 * power ? 10 : rough > 2 * power ? 5 : rough > power ? 2 : 1));
  pen.fillStyle = shades.muted;
  pen.textAlign = "center";
  pen.textBaseline = "alphabetic";
  for (let step = 0; step <= span; step += gap) {
    const x = box.left + (box.width * step) / span;
    if (x < box.left + box.width - 8 || step < span - gap / 2 || step === span)
      pen.fillText(step.toLocaleString("en"), x, box.top + box.height + 15);
  }
  pen.strokeStyle = shades.muted;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(box.left, box.top + box.height + 0.5);
  pen.lineTo(box.left + box.width, box.top + box.height + 0.5);
  pen.stroke();
}

/**
 * Draw the shares of robots with each opinion until a step, the threshold, and behind them what theory says.
 * @param {HTMLCanvasElement} canvas
 * @param {Course} course
 * @param {number} step
 * @param {number} threshold
 * @param {Shades} shades
 * @param {Prediction | null} prediction
 */
export function drawCurve(canvas, course, step, threshold, shades, prediction) {
  const { pen, box } = fitted(canvas),
    { last, decisionStep, counted, truths } = course,
    span = Math.max(1, Math.min(last, Math.max(FIRST_SPAN, Math.ceil(step / 50) * 50))),
    gap = Math.ceil(span / POINTS); // steps between two points of a line
  /** @param {number} at */
  const x = (at) => box.left + (box.width * at) / span;
  /** @param {number} share */
  const y = (share) => box.top + box.height * (1 - share);
  drawSteps(pen, box, span, shades);
  if (truths) drawTruths(pen, box, truths, step, x, shades);
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  pen.lineWidth = 1;
  for (const share of [0, 0.5, threshold]) {
    pen.fillStyle = share === threshold ? shades.ink : shades.muted;
    pen.fillText(`${Math.round(1000 * share) / 10} %`, box.left - 6, y(share));
    if (!share) continue;
    pen.strokeStyle = share === threshold ? shades.ink : shades.line;
    pen.setLineDash(share === threshold ? [2, 3] : []);
    pen.beginPath();
    pen.moveTo(box.left, Math.round(y(share)) + 0.5);
    pen.lineTo(box.left + box.width, Math.round(y(share)) + 0.5);
    pen.stroke();
  }
  pen.setLineDash([]);
  if (prediction?.opinions) drawPrediction(pen, box, prediction, span, { x, y }, shades);
  pen.lineJoin = "round";
  for (const [counts, colour, dash] of /** @type {const} */ ([
    [course.infeasible, shades.infeasible, [5, 3]],
    [course.feasible, shades.feasible, []],
  ])) {
    pen.strokeStyle = colour;
    pen.lineWidth = 2;
    pen.setLineDash([...dash]);
    pen.beginPath();
    for (let at = 0; at < step + gap; at += gap) {
      const shown = Math.min(at, step);
      pen.lineTo(x(shown), y(counts[shown] / Math.max(1, counted[shown])));
    }
    pen.stroke();
  }
  pen.setLineDash([]);
  if (decisionStep < 0 || decisionStep > step) return;
  pen.strokeStyle = shades.ink;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(x(decisionStep), box.top);
  pen.lineTo(x(decisionStep), box.top + box.height);
  pen.stroke();
}

/**
 * Draw the share for feasible that the theory expects: its mean, between what most swarms are, and where it tips.
 * @param {CanvasRenderingContext2D} pen
 * @param {Box} box
 * @param {Prediction} prediction
 * @param {number} span
 * @param {{x: (at: number) => number, y: (share: number) => number}} at
 * @param {Shades} shades
 */
function drawPrediction(pen, { left, width }, { opinions = [], tips }, span, { x, y }, shades) {
  const gap = Math.ceil(span / POINTS),
    steps = Array.from({ length: Math.floor(span / gap) + 1 }, (_, k) => k * gap);
  const [mean, low, high] = [0, 1, 2].map((which) =>
    steps.map((at) => [x(at), y(opinions[Math.min(at, opinions.length - 1)][which])]),
  );
  pen.fillStyle = pen.strokeStyle = shades.muted;
  pen.beginPath();
  for (const [across, down] of [...low, ...high.reverse()]) pen.lineTo(across, down);
  pen.globalAlpha = 0.13;
  pen.fill();
  pen.globalAlpha = 1;
  const level = [left, left + width].map((across) => [across, y(tips ?? 0)]);
  for (const [line, dash, thick] of /** @type {const} */ ([
    [mean, EXPECTED, 1.5],
    [tips == null ? [] : level, TIPPING, 1],
  ])) {
    pen.lineWidth = thick;
    pen.setLineDash(dash);
    pen.beginPath();
    for (const [across, down] of line) pen.lineTo(across, down);
    pen.stroke();
  }
  pen.setLineDash([]);
}

/**
 * Say what the theory says below a plot, explain its lines, and mark up to how many tasks most swarms decide feasible.
 * @param {HTMLElement} place With the text, and the lines.
 * @param {Prediction | null} prediction Null if it isn't known.
 * @param {HTMLElement | null} marks Of the slider for tasks.
 */
export function sayPrediction(place, prediction, marks) {
  place.style.visibility = prediction ? "" : "hidden"; // it keeps its room
  if (!prediction) return;
  const { text, opinions, tips, tasks } = prediction,
    [said, lines] = /** @type {HTMLCollectionOf<HTMLElement>} */ (place.children);
  place.hidden = false;
  said.textContent = text;
  lines.hidden = !opinions;
  /** @type {HTMLElement} */ (lines.lastElementChild).hidden = tips == null;
  marks?.replaceChildren(...(tasks == null ? [] : [new Option("half decide feasible", String(tasks))]));
}

/**
 * Draw the truth of each step behind the opinions: a band, and a shade below it.
 * @param {CanvasRenderingContext2D} pen
 * @param {Box} box
 * @param {ArrayLike<number>} truths
 * @param {number} step
 * @param {(at: number) => number} x
 * @param {Shades} shades
 */
function drawTruths(pen, { top, height }, truths, step, x, shades) {
  for (let from = 0, at = 1; at <= step + 1; at++) {
    if (at <= step && truths[at] === truths[from]) continue;
    const left = x(from),
      width = x(Math.min(at, step)) - left,
      truth = truths[from] === 1;
    drawTruth(pen, { x: left, y: top - BAND, width, height: BAND }, truth, shades);
    pen.globalAlpha = 0.1;
    pen.fillStyle = truth ? shades.feasible : shades.infeasible;
    pen.fillRect(left, top, width, height);
    pen.globalAlpha = 1;
    from = at;
  }
}

/** @typedef {[number, number, number, number]} Change Step, robots, tasks, truth from there on. */

/**
 * Return the changes of the truth among those of the world, with the truth at the start.
 * @param {Change[]} world
 * @returns {[number, number][]} Step and truth.
 */
export function truthsOf(world) {
  return world
    .filter(([, , , truth], k) => !k || truth !== world[k - 1][3])
    .map(([step, , , truth]) => [step, truth]);
}

/**
 * Draw one stretch of the band.
 * @param {CanvasRenderingContext2D} pen
 * @param {{x: number, y: number, width: number, height: number}} box
 * @param {boolean} truth
 * @param {Record<"feasible" | "infeasible", string>} colours
 */
export function drawTruth(pen, { x, y, width, height }, truth, colours) {
  if (truth) {
    pen.fillStyle = colours.feasible;
    pen.fillRect(x, y, width, height);
    return;
  }
  pen.save();
  pen.beginPath();
  pen.rect(x, y, width, height);
  pen.clip();
  pen.strokeStyle = colours.infeasible;
  pen.lineWidth = 1.6;
  pen.beginPath();
  for (let at = 4 * Math.floor((x - height) / 4); at < x + width; at += 4) {
    pen.moveTo(at, y + height);
    pen.lineTo(at + height, y);
  }
  pen.stroke();
  pen.restore();
}
