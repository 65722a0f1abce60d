// The seek bar: a slider over the steps of a run, and marks above it at what happens there.

import { $, capital, formatted } from "./elements.js";
import { DECLARED, shadeOf, STANDING, THERE, WORKING } from "./frames.js";

const STRIP = 9; // height of a robot's strip, in CSS pixels
const SIGNS = 9; // height of the signs above the strips
const BAND = 6; // height of the band of the truth
const TICKS = 4; // height of the ticks of a world that changes, below it
const NAMED = 6; // most changes of the truth whose steps are said in words
const LINES = { infeasible: [0, STRIP - 2], undecided: [STRIP / 2 - 1] }; // tops of the lines of a strip, 2 pixels high

/** @typedef {(from: number, to: number, top: number, height: number, look: string) => string} Box */

/**
 * Return what draws boxes over steps.
 * @param {number} last Step at the right edge.
 * @returns {Box}
 */
const boxes = (last) => (from, to, top, height, look) =>
  `<rect x="${(100 * from) / last}%" width="${(100 * (to - from)) / last}%" y="${top}" height="${height}" class="${look}"/>`;

/**
 * Return the band of the truth: full where it is feasible, hatched where not.
 * @param {RunHistory} history
 * @param {number} last Step at the right edge.
 * @param {number} top
 */
export function truthBand(history, last, top) {
  const truths = history.changesOfTruth().filter(([step]) => step < last),
    end = Math.min(last, history.known);
  return truths
    .map(([step, truth], k) =>
      boxes(last)(step, truths[k + 1]?.[0] ?? end, top, BAND, truth ? "feasible" : "hatched"),
    )
    .join("");
}

export class SeekBar {
  /** @param {(step: number) => void} seek */
  constructor(seek) {
    this.slider = /** @type {HTMLInputElement} */ ($("seek"));
    this.slider.addEventListener("input", () => seek(this.slider.valueAsNumber));
  }

  /** @param {number} step */
  show(step) {
    const { slider } = this,
      text = `step ${formatted(step)} of ${formatted(Number(slider.max))}`;
    if (slider.valueAsNumber !== step) slider.value = String(step);
    if (slider.ariaValueText !== text) slider.ariaValueText = text;
  }

  /**
   * Draw the marks of each swarm, and say in words where they are.
   * @param {RunHistory[]} histories
   * @param {number} robot -1 for none.
   */
  mark(histories, robot) {
    const [{ last, changes }] = histories, // both swarms are in one world
      world = histories[0].changesOfWorld(),
      box = boxes(Math.max(1, last)),
      top = SIGNS + (changes ? BAND + TICKS + 2 : 0),
      strips = robot < 0 ? [] : histories.map((each) => each.changesOf(robot)),
      height = top + strips.length * (STRIP + 1),
      tick = `<rect y="${SIGNS + BAND + 1}" width="1" height="${TICKS}" class="muted"/>`,
      at = (/** @type {number} */ step, /** @type {string} */ sign) =>
        step < 0 ? "" : `<svg x="${(100 * step) / Math.max(1, last)}%" overflow="visible">${sign}</svg>`,
      signs = histories.map((each, lane) => [
        at(each.decisionStep, `<path d="M-4.5 .5h9L0 7.5z" class="${lane ? "hollow" : ""}"/>`),
        at(each.decisionStep, `<path d="M-.5 7h1V${height}h-1z"/>`),
        at(each.reached("allTaken"), '<path d="M-3 1.5h6v6h-6z"/>'),
        at(each.reached("declaration"), `<path d="M-.5 0h1V${SIGNS}h-1z"/><circle cy="4.5" r="3"/>`),
      ]);
    this.slider.max = String(last);
    const marks = $("marks");
    marks.style.height = `${height}px`;
    marks.innerHTML = [
      changes ? truthBand(histories[0], Math.max(1, last), SIGNS) : "",
      ...world.slice(1).map(([step]) => at(step, tick)),
      ...strips.map((each, lane) => strip(each, top + lane * (STRIP + 1), histories[lane].known, box)),
      ...signs.flat(),
    ].join("");
    $("marks-text").textContent = histories
      .map((each, lane) => inWords(each, lane, histories.length, robot, strips[lane]))
      .join(" ");
  }
}

/**
 * Return the opinions of a robot: full for feasible, hollow for infeasible, a thin line for none.
 * @param {[number, number][]} changes Steps at which the robot changes, and its flags from there on.
 * @param {number} top
 * @param {number} known Last step that is known.
 * @param {Box} box
 */
function strip(changes, top, known, box) {
  return changes
    .map(([step, flags], k) => {
      if (!(flags & THERE)) return "";
      const end = changes[k + 1]?.[0] ?? known,
        shade = shadeOf(flags),
        look = `${shade} ${flags & WORKING ? "" : "stopped"}`,
        declares = flags & DECLARED && !(k && changes[k - 1][1] & DECLARED);
      return [
        ...(shade === "feasible"
          ? [box(step, end, top, STRIP, look)]
          : LINES[shade].map((from) => box(step, end, top + from, 2, look))),
        flags & STANDING ? box(step, end, top, 2, "task") : "",
        declares ? box(step, step + 1, top, STRIP, "") : "",
      ].join("");
    })
    .join("");
}

/**
 * Return the marks in words.
 * @param {RunHistory} history
 * @param {number} lane
 * @param {number} swarms
 * @param {number} robot
 * @param {[number, number][] | undefined} changes
 */
function inWords(history, lane, swarms, robot, changes) {
  const { decisionStep, done } = history,
    more = done ? "" : " so far",
    [declaration, taken] = [history.reached("declaration"), history.reached("allTaken")],
    side = swarms === 1 ? "" : lane ? "Right: " : "Left: ",
    none = done ? "no decision" : "looking for the decision",
    words = [decisionStep < 0 ? none : `decision at step ${formatted(decisionStep)}`];
  if (declaration >= 0) words.push(`declaration at step ${formatted(declaration)}`);
  if (taken >= 0) words.push(`robots stand at all tasks that they can, at step ${formatted(taken)}`);
  if (changes)
    words.push(`robot ${robot} changes opinion or phase ${formatted(changes.length - 1)} times${more}`);
  if (history.changes && !lane) {
    const truths = history.changesOfTruth().slice(1),
      steps = truths.map(([step]) => formatted(step)).join(", "),
      listed = truths.length && truths.length <= NAMED ? `, at ${steps}` : "";
    words.push(`the world changes ${times(history.changesOfWorld().length - 1)}${more}`);
    words.push(`the truth ${times(truths.length)}${listed}`);
  }
  const text = words.join(", ");
  return `${side ? side + text : capital(text)}.`;
}

/** @param {number} count */
const times = (count) => (count === 1 ? "once" : `${formatted(count)} times`);
