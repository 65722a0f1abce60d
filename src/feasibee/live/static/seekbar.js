// The seek bar: a slider over the steps of a run, and marks above it at what happens there.

import { contextOf } from "./crowd.js";
import { $, capital, formatted } from "./elements.js";
import { DECLARED, FEASIBLE, NEUTRAL, STANDING, THERE, WORKING } from "./frames.js";
import { drawTruth, truthsOf } from "./curve.js";

/** @import { Shades } from "./theme.js" */
/** @import { Change } from "./curve.js" */

const INSET = 8; // half of the slider's thumb, in CSS pixels
const STRIP = 9; // height of a robot's strip
const SIGNS = 9; // height of the signs above the strips
const BAND = 6; // height of the band of the truth
const TICKS = 4; // height of the ticks of a world that changes, below it
const NAMED = 6; // most changes of the truth whose steps are said in words

/**
 * What lies ahead in the run of a swarm; steps are -1 if not found.
 * @typedef {object} Outlook
 * @property {number | null} robot
 * @property {[number, number][]} changes Steps at which the robot changes, and its flags from there on.
 * @property {Change[]} world Steps at which the numbers of robots or tasks, or the truth, change.
 * @property {number} decision
 * @property {number} declaration
 * @property {number} [allTaken] If robots act: from when they stand at all tasks that they can.
 * @property {number} [until] Step up to which it is known.
 * @property {boolean} done
 * @property {string} [problem] Why nothing is found.
 */

export class SeekBar {
  /** @param {(step: number) => void} seek */
  constructor(seek) {
    this.slider = /** @type {HTMLInputElement} */ ($("seek"));
    this.canvas = /** @type {HTMLCanvasElement} */ ($("marks"));
    this.last = 1;
    this.slider.addEventListener("input", () => seek(this.slider.valueAsNumber));
  }

  /** @param {number} last */
  open(last) {
    this.last = Math.max(1, last);
    this.slider.max = String(last);
  }

  /** @param {number} step */
  show(step) {
    if (this.slider.valueAsNumber !== step) this.slider.value = String(step);
    const text = `step ${formatted(step)} of ${formatted(this.last)}`;
    if (this.slider.getAttribute("aria-valuetext") !== text) this.slider.setAttribute("aria-valuetext", text);
  }

  /**
   * Draw the marks of each swarm, and say in words where they are.
   * @param {Outlook[]} outlooks
   * @param {Shades} colours
   */
  mark(outlooks, colours) {
    const ratio = devicePixelRatio || 1,
      strips = outlooks.filter((each) => each.robot !== null).length,
      width = Math.max(2 * INSET + 1, this.slider.clientWidth),
      top = SIGNS + (outlooks[0]?.world.length ? BAND + TICKS + 2 : 0),
      height = top + strips * (STRIP + 1);
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.canvas.style.height = `${height}px`;
    const pen = contextOf(this.canvas);
    pen.scale(ratio, ratio);
    const at = (/** @type {number} */ step) => INSET + ((width - 2 * INSET) * step) / this.last;
    if (outlooks[0]?.world.length) this.band(pen, outlooks[0], at, colours); // both swarms are in one world
    for (const [lane, outlook] of outlooks.entries()) {
      if (outlook.robot !== null) this.strip(pen, outlook, top + lane * (STRIP + 1), at, colours);
      pen.fillStyle = pen.strokeStyle = colours.ink;
      if (outlook.decision >= 0) sign(pen, at(outlook.decision), height, lane > 0);
      if ((outlook.allTaken ?? -1) >= 0) pen.fillRect(at(outlook.allTaken ?? 0) - 3, 1.5, 6, 6);
      if (outlook.declaration < 0) continue;
      const x = at(outlook.declaration);
      pen.fillRect(x - 0.5, 0, 1, SIGNS);
      pen.beginPath();
      pen.arc(x, 4.5, 3, 0, 2 * Math.PI);
      pen.fill();
    }
    $("marks-text").textContent = outlooks
      .map((each, lane) => inWords(each, lane, outlooks.length))
      .join(" ");
  }

  /**
   * Draw the truth as a band, and a tick at each change of the numbers of robots or tasks.
   * @param {CanvasRenderingContext2D} pen
   * @param {Outlook} outlook
   * @param {(step: number) => number} at
   * @param {Shades} colours
   */
  band(pen, { world, done }, at, colours) {
    const truths = truthsOf(world),
      known = done ? this.last : world[world.length - 1][0];
    for (const [k, [step, truth]] of truths.entries()) {
      const end = k + 1 < truths.length ? truths[k + 1][0] : known,
        box = { x: at(step), y: SIGNS, width: Math.max(0.5, at(end) - at(step)), height: BAND };
      drawTruth(pen, box, truth === 1, colours);
    }
    pen.fillStyle = colours.muted;
    for (const [step] of world.slice(1)) pen.fillRect(Math.round(at(step)), SIGNS + BAND + 1, 1, TICKS);
  }

  /**
   * Draw the opinions of a robot: full for feasible, hollow for infeasible, a thin line for none.
   * @param {CanvasRenderingContext2D} pen
   * @param {Outlook} outlook
   * @param {number} top
   * @param {(step: number) => number} at
   * @param {Shades} colours
   */
  strip(pen, { changes, until = 0 }, top, at, colours) {
    for (const [k, [step, flags]] of changes.entries()) {
      const end = k + 1 < changes.length ? changes[k + 1][0] : until;
      if (!(flags & THERE)) continue;
      const wide = Math.max(0.5, at(end) - at(step));
      pen.fillStyle =
        flags & NEUTRAL ? colours.undecided : flags & FEASIBLE ? colours.feasible : colours.infeasible;
      pen.globalAlpha = flags & WORKING ? 1 : 0.3;
      if (flags & NEUTRAL) pen.fillRect(at(step), top + STRIP / 2 - 1, wide, 2);
      else if (flags & FEASIBLE) pen.fillRect(at(step), top, wide, STRIP);
      else for (const edge of [0, STRIP - 2]) pen.fillRect(at(step), top + edge, wide, 2);
      if (flags & STANDING) {
        pen.fillStyle = colours.task;
        pen.fillRect(at(step), top, Math.max(0.5, at(end) - at(step)), 2);
      }
      if (flags & DECLARED && !(k && changes[k - 1][1] & DECLARED)) {
        pen.fillStyle = colours.ink;
        pen.fillRect(at(step) - 1, top, 2, STRIP);
      }
    }
    pen.globalAlpha = 1;
  }
}

/**
 * Draw the sign of a decision: a triangle and a line down to the slider; hollow for the swarm beside it.
 * @param {CanvasRenderingContext2D} pen
 * @param {number} x
 * @param {number} height
 * @param {boolean} hollow
 */
function sign(pen, x, height, hollow) {
  pen.beginPath();
  pen.moveTo(x - 4.5, 0.5);
  pen.lineTo(x + 4.5, 0.5);
  pen.lineTo(x, 7.5);
  pen.closePath();
  if (hollow) pen.stroke();
  else pen.fill();
  pen.fillRect(x - 0.5, 7, 1, height - 7);
}

/**
 * Return the marks in words.
 * @param {Outlook} outlook
 * @param {number} lane
 * @param {number} swarms
 */
function inWords(
  { robot, changes, world, decision, declaration, allTaken = -1, done, problem },
  lane,
  swarms,
) {
  if (problem) return `No look ahead: ${problem}.`;
  const side = swarms === 1 ? "" : lane ? "Right: " : "Left: ",
    none = done ? "no decision" : "looking for the decision";
  const words = [decision < 0 ? none : `decision at step ${formatted(decision)}`];
  if (declaration >= 0) words.push(`declaration at step ${formatted(declaration)}`);
  if (allTaken >= 0) words.push(`robots stand at all tasks that they can, at step ${formatted(allTaken)}`);
  if (robot !== null) {
    const more = done ? "" : " so far";
    words.push(
      `robot ${robot} changes opinion or phase ${formatted(Math.max(0, changes.length - 1))} times${more}`,
    );
  }
  if (world.length && !lane) words.push(...worldInWords(world, done));
  const text = words.join(", ");
  return `${side ? side + text : capital(text)}.`;
}

/**
 * Return in words how often the truth and the numbers of robots and tasks change.
 * @param {Change[]} world
 * @param {boolean} done
 */
function worldInWords(world, done) {
  const more = done ? "" : " so far",
    steps = truthsOf(world)
      .slice(1)
      .map(([step]) => formatted(step));
  const listed = steps.length && steps.length <= NAMED ? `, at ${steps.join(", ")}` : "";
  return [`the world changes ${times(world.length - 1)}${more}`, `the truth ${times(steps.length)}${listed}`];
}

/** @param {number} count */
function times(count) {
  return count === 1 ? "once" : `${formatted(count)} times`;
}
