// One of the swarms side by side: its arena, its plot, its caption, and what lies ahead in its run.

import { Arena } from "./arena.js";
import { $, formatted } from "./elements.js";
import { Plot } from "./plot.js";
import { colours } from "./theme.js";
import { showTooltip } from "./tooltip.js";

/** @import { Opened, View } from "./arena.js" */
/** @import { Outlook } from "./seekbar.js" */

/** @type {Record<number, string>} */
const WORDS = { 1: "feasible", 0: "infeasible", [-1]: "undecided" };

export class Lane {
  /** @param {number} number 0 on the left, 1 on the right. */
  constructor(number) {
    const id = (/** @type {string} */ name) => $(number ? `${name}-${number}` : name);
    this.number = number;
    this.frame = id("frame");
    this.tip = id("tip");
    this.caption = id("caption");
    this.title = id("plot-title");
    this.canvas = /** @type {HTMLCanvasElement} */ (id("arena"));
    this.arena = new Arena(this.canvas, colours());
    this.plot = new Plot(id("plot"), colours());
    /** @type {Opened | null} */
    this.world = null;
    this.outlook = nothing(null);
  }

  /** @param {Opened} world */
  open(world) {
    this.world = world;
    this.title.textContent = world.strategy;
    this.arena.open(world);
    this.plot.clear(world);
    this.outlook = nothing(null);
  }

  /**
   * Look for the changes of another robot.
   * @param {number | null} robot
   */
  follow(robot) {
    const { decision, declaration } = this.outlook;
    this.outlook = { ...nothing(robot), decision, declaration };
  }

  /**
   * Add what the server has found; return whether it is of the robot that is followed.
   * @param {Outlook & {first: number}} found
   */
  foresee(found) {
    if (found.robot !== this.outlook.robot || found.first !== this.outlook.changes.length) return false;
    this.outlook = { ...found, changes: [...this.outlook.changes, ...found.changes] };
    return true;
  }

  /**
   * Return the step of the last change of the robot before a step, or 0.
   * @param {number} step
   */
  changeBefore(step) {
    return this.outlook.changes.findLast(([each]) => each < step)?.[0] ?? 0;
  }

  /**
   * Return the step of the next change of the robot after a step, or that step.
   * @param {number} step
   */
  changeAfter(step) {
    return this.outlook.changes.find(([each]) => each > step)?.[0] ?? step;
  }

  repaint() {
    this.arena.setColours(colours());
    this.plot.setColours(colours());
  }

  /**
   * Draw; return whether something still moves.
   * @param {View} view
   * @param {number} time
   */
  draw(view, time) {
    if (!this.world) return false;
    const moves = this.arena.draw(view, time);
    showTooltip(this, this.world, view.now);
    const { feasible, infeasible, firstDecision, decisionStep } = view.now;
    const right = (firstDecision === 1) === this.world.truth ? "right" : "wrong";
    const decided =
      firstDecision < 0
        ? "undecided"
        : `${WORDS[firstDecision]} at step ${formatted(decisionStep)}: ${right}`;
    const text = `${formatted(feasible)} feasible, ${formatted(infeasible)} infeasible; ${decided}`;
    const [name, said] = /** @type {HTMLCollectionOf<HTMLElement>} */ (this.caption.children);
    if (said.textContent !== text) said.textContent = text;
    if (name.textContent !== this.world.strategy) name.textContent = this.world.strategy;
    return moves;
  }

  /** @param {string} now What the clock does, in words. */
  describe(now) {
    const { world } = this;
    const label =
      world && `The arena: ${world.robots} robots and ${world.tasks} tasks, ${world.strategy}, ${now}`;
    const text = `${label || "The arena"}. Arrow keys go from robot to robot.`;
    if (this.canvas.getAttribute("aria-label") !== text) this.canvas.setAttribute("aria-label", text);
  }
}

/**
 * Return the outlook before anything is found.
 * @param {number | null} robot
 * @returns {Outlook}
 */
function nothing(robot) {
  return { robot, changes: [], decision: -1, declaration: -1, done: false };
}
