// The share of robots with each opinion over time, with the threshold of the decision.

import { contextOf } from "./crowd.js";

/** @import { Shade } from "./theme.js" */
/** @import { Recording } from "./recording.js" */

/** @typedef {Record<Shade, string>} Shades */
/** @typedef {{left: number, top: number, width: number, height: number}} Box */

const FIRST_SPAN = 100; // steps
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

export class Curve {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
  }

  /**
   * @param {Recording} recording
   * @param {number} step
   * @param {number} threshold
   * @param {Shades} shades
   */
  draw(recording, step, threshold, shades) {
    const { pen, box } = fitted(this.canvas),
      span = Math.min(recording.last, Math.max(FIRST_SPAN, Math.ceil(step / 50) * 50));
    /** @param {number} at */
    const x = (at) => box.left + (box.width * at) / Math.max(1, span);
    /** @param {number} share */
    const y = (share) => box.top + box.height * (1 - share);
    drawSteps(pen, box, Math.max(1, span), shades);
    this.drawShares(pen, box, y, threshold, shades);
    const { robots } = recording.settings;
    pen.lineJoin = "round";
    for (const [counts, colour, dash] of /** @type {const} */ ([
      [recording.infeasible, shades.infeasible, [5, 3]],
      [recording.feasible, shades.feasible, []],
    ])) {
      pen.strokeStyle = colour;
      pen.lineWidth = 2;
      pen.setLineDash([...dash]);
      pen.beginPath();
      for (let at = 0; at <= step; at++) pen.lineTo(x(at), y(counts[at] / robots));
      pen.stroke();
    }
    pen.setLineDash([]);
    if (recording.decision < 0 || recording.decisionStep > step) return;
    pen.strokeStyle = shades.ink;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(x(recording.decisionStep), box.top);
    pen.lineTo(x(recording.decisionStep), box.top + box.height);
    pen.stroke();
  }

  /**
   * Draw the axis of shares, and the threshold.
   * @param {CanvasRenderingContext2D} pen
   * @param {Box} box
   * @param {(share: number) => number} y
   * @param {number} threshold
   * @param {Shades} shades
   */
  drawShares(pen, box, y, threshold, shades) {
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
  }
}
