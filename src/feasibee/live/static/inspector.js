// The inspector: one robot, chosen by pointer or keyboard, and why it thinks so.

import { $, announce, make } from "./elements.js";

/** @import { Arena } from "./arena.js" */
/** @import { Lane } from "./lane.js" */

/**
 * What a robot knows at a step, from the server; see reasons.py.
 * @typedef {object} Words
 * @property {number} lane
 * @property {number} step
 * @property {number} robot
 * @property {[string, string][]} reasons
 */

/** @type {Record<string, [number, number]>} */
const DIRECTIONS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/**
 * Return the nearest robot in a direction, within 45 degrees of it; the same number if there is none.
 * @param {Arena} arena
 * @param {number} from
 * @param {string} key Of an arrow.
 */
export function neighbour(arena, from, key) {
  const { px, py } = arena;
  const [right, down] = DIRECTIONS[key];
  let found = from,
    nearest = Infinity;
  for (let i = 0; i < px.length; i++) {
    const dx = px[i] - px[from],
      dy = py[i] - py[from],
      along = dx * right + dy * down,
      across = Math.abs(dx * down) + Math.abs(dy * right),
      squared = dx * dx + dy * dy;
    if (i !== from && along > 0 && across <= along && squared < nearest && arena.has(i))
      [nearest, found] = [squared, i];
  }
  return found;
}

/**
 * Return the first number from one on that a robot has, in steps of 1 or -1; the same if there is no other.
 * @param {Arena} arena
 * @param {number} from
 * @param {number} by
 * @param {number} robots
 */
function following(arena, from, by, robots) {
  for (let k = 0; k < robots; k++) {
    const robot = (from + k * by + robots * robots) % robots;
    if (arena.has(robot)) return robot;
  }
  return from;
}

export class Inspector {
  /** @param {(robot: number) => void} choose Another robot is chosen; -1 for none. */
  constructor(choose) {
    this.choose = choose;
    this.robot = -1;
    this.robots = 0;
    this.focus = 0; // the robot from which arrow keys start when none is chosen
    /** @type {Words[][]} */
    this.words = [[], []]; // of each swarm, by step
    this.input = /** @type {HTMLInputElement} */ ($("robot"));
    this.input.addEventListener("change", () => this.pick(this.input.valueAsNumber));
    $("robot-none").addEventListener("click", () => this.pick(-1));
  }

  /** @param {number} robots */
  open(robots) {
    this.robots = robots;
    this.input.max = String(robots - 1);
    if (this.robot >= robots) this.robot = -1;
    this.focus = Math.min(this.focus, robots - 1);
    this.words = [[], []];
    this.reflect();
  }

  /**
   * Choose a robot; another number than that of a robot chooses none.
   * @param {number} robot
   */
  pick(robot) {
    const chosen = Number.isInteger(robot) && robot >= 0 && robot < this.robots ? robot : -1;
    if (chosen === this.robot) return this.reflect();
    this.robot = chosen;
    if (chosen >= 0) this.focus = chosen;
    this.words = [[], []];
    this.reflect();
    announce(chosen < 0 ? "No robot is inspected" : `Robot ${chosen}`);
    this.choose(chosen);
  }

  /**
   * Answer a key in an arena; return whether it was one of the inspector's.
   * @param {string} key
   * @param {Arena} arena
   */
  press(key, arena) {
    if (!this.robots) return false; // no run is open yet
    const { robot, robots } = this,
      focus = following(arena, this.focus, 1, robots);
    if (key in DIRECTIONS) this.pick(robot < 0 ? focus : neighbour(arena, robot, key));
    else if (key === "PageDown") this.pick(robot < 0 ? focus : following(arena, robot + 1, 1, robots));
    else if (key === "PageUp") this.pick(robot < 0 ? focus : following(arena, robot - 1, -1, robots));
    else if (key === "Enter") this.pick(robot < 0 ? focus : robot);
    else if (key === "Escape" && robot >= 0) this.pick(-1);
    else return false;
    return true;
  }

  /** @param {Words} words */
  hear(words) {
    const kept = this.words[words.lane];
    while (kept.length && kept[kept.length - 1].step >= words.step) kept.pop(); // a jump back
    if (words.robot === this.robot) kept.push(words);
  }

  /**
   * Show what the robot knows at a step, and that in the swarm beside it.
   * @param {number} step
   * @param {string[]} strategies
   */
  show(step, strategies) {
    for (const [lane, kept] of this.words.entries()) {
      while (kept.length > 1 && kept[1].step <= step) kept.shift();
      const box = $(`reasons-${lane}`),
        [words] = kept;
      box.hidden = this.robot < 0 || lane >= strategies.length;
      if (box.hidden || !words || words.step > step || box.dataset.step === String(words.step)) continue;
      box.dataset.step = String(words.step);
      const title = /** @type {HTMLElement} */ (box.querySelector("h3"));
      title.textContent = strategies.length > 1 ? `${["Left", "Right"][lane]}: ${strategies[lane]}` : "";
      title.hidden = strategies.length < 2;
      const rows = words.reasons.map(([term, text]) =>
        make("div", {}, make("dt", {}, term), make("dd", {}, text)),
      );
      box.querySelector("dl")?.replaceChildren(...rows);
    }
  }

  reflect() {
    this.input.value = this.robot < 0 ? "" : String(this.robot);
    $("robot-none").hidden = this.robot < 0;
    $("robot-hint").hidden = this.robot >= 0;
    for (const lane of [0, 1]) {
      delete $(`reasons-${lane}`).dataset.step;
      $(`reasons-${lane}`).hidden = true;
    }
  }
}

/**
 * Let the pointer show and choose robots of an arena, and keys choose them while it has the focus.
 * @param {Lane} lane
 * @param {Inspector} inspector
 * @param {() => void} redraw
 */
export function listenToArena({ canvas, arena, frame }, inspector, redraw) {
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !inspector.press(event.key, arena)) return;
    event.preventDefault();
    event.stopPropagation();
  });
  arena.followPointer(frame, redraw);
  frame.addEventListener("click", (event) => inspector.pick(arena.at(event.clientX, event.clientY)));
}
