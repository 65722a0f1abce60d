// One of the swarms side by side: its arena, its plot, its caption, and what lies ahead in its run.

import { Arena } from "./arena.js";
import { drawCurve, sayPrediction, truthsOf } from "./curve.js";
import { $, formatted } from "./elements.js";
import { coloursOf } from "./theme.js";
import { showTooltip } from "./tooltip.js";
import { doneAmong, OPINIONS } from "./words.js";

/** @import { Opened, View } from "./arena.js" */
/** @import { Prediction } from "./curve.js" */
/** @import { Frame } from "./frames.js" */
/** @import { Outlook } from "./seekbar.js" */

const AGAIN = 500; // milliseconds between two questions about one robot

/** @typedef {{robot: number, text: string}} Why Why a robot holds its opinion, from the server. */

export class Lane {
  /**
   * @param {number} number 0 on the left, 1 on the right.
   * @param {() => void} redraw
   * @param {(robot: number) => boolean} ask Ask why a robot holds its opinion; returns whether it was possible.
   */
  constructor(number, redraw, ask) {
    this.ask = ask;
    const id = (/** @type {string} */ name) => $(number ? `${name}-${number}` : name);
    this.number = number;
    this.frame = id("frame");
    this.tip = id("tip");
    this.caption = id("caption");
    this.title = id("plot-title");
    this.canvas = /** @type {HTMLCanvasElement} */ (id("arena"));
    this.shades = coloursOf();
    this.arena = new Arena(this.canvas, this.shades, redraw);
    this.plotCanvas = /** @type {HTMLCanvasElement} */ (id("plot"));
    this.course = begun(0, false);
    this.plotted = -1; // step of the curve
    /** @type {Opened | null} */
    this.world = null;
    this.theory = id("theory");
    if (number) this.theory.append(...$("theory").cloneNode(true).childNodes); // the same words and lines
    /** @type {Prediction | null} */
    this.prediction = null;
    this.outlook = nothing(null);
    this.there = { robots: 0, tasks: 0 }; // in the last frame
    /** @type {Why | null} */
    this.why = null; // of the robot that is pointed at
    this.asked = { robot: -1, step: -1, time: 0 }; // why
  }

  /** @param {Opened} world */
  open(world) {
    this.world = world;
    this.title.textContent = `${this.number ? "Right" : "Left"}: ${world.strategy}`;
    this.arena.open(world);
    this.course = begun(world.last, world.changes);
    this.outlook = nothing(null);
    this.foretell(null);
    this.why = null;
    this.asked = { robot: -1, step: -1, time: 0 };
    this.there = { robots: world.robots, tasks: world.tasks };
  }

  /**
   * Mark another robot, and look for its changes; -1 for none.
   * @param {number} robot
   */
  follow(robot) {
    this.arena.chosen = robot;
    const { world, decision, declaration, allTaken } = this.outlook;
    this.outlook = { ...nothing(robot < 0 ? null : robot), world, decision, declaration, allTaken };
  }

  /**
   * Add what the server has found; return whether it is of the robot that is followed.
   * @param {Partial<Outlook> & {first: number, seen: number}} found Only a problem, if nothing can be found.
   */
  foresee(found) {
    const { robot, changes, world } = this.outlook;
    if (found.robot !== robot || found.first !== changes.length || found.seen !== world.length) return false;
    const more = {
      changes: [...changes, ...(found.changes ?? [])],
      world: [...world, ...(found.world ?? [])],
    };
    this.outlook = { ...this.outlook, ...found, ...more };
    return true;
  }

  /** @param {Prediction | null} prediction */
  foretell(prediction) {
    this.prediction = prediction;
    this.plotted = -1;
    sayPrediction(this.theory, prediction, this.number ? null : $("tasks-marks"));
  }

  // Steps at which the inspected robot changes; without a robot, those at which the truth does.
  get changes() {
    const { robot, changes, world } = this.outlook;
    return robot === null ? truthsOf(world).map(([step]) => step) : changes.map(([step]) => step);
  }

  repaint() {
    this.shades = coloursOf();
    this.arena.setColours(this.shades);
    this.plotted = -1;
  }

  /**
   * Keep the counts that a frame brings: those of all steps that the server has not sent before.
   * @param {Frame} frame
   */
  keep({ first, feasibleCounts, infeasibleCounts, countedCounts, truths }) {
    const { course } = this;
    for (const [k, truth] of truths.entries()) {
      course.feasible[first + k] = feasibleCounts[k];
      course.infeasible[first + k] = infeasibleCounts[k];
      course.counted[first + k] = countedCounts[k];
      if (course.truths) course.truths[first + k] = truth;
    }
  }

  /** @param {Frame} frame */
  plot({ step, decisionStep }) {
    this.plotted = step;
    this.course.decisionStep = decisionStep;
    const { plotCanvas, course, world, shades, prediction } = this;
    drawCurve(plotCanvas, course, step, world?.threshold ?? 1, shades, prediction);
  }

  /**
   * Draw; return whether something still moves.
   * @param {View} view
   * @param {number} time
   */
  draw(view, time) {
    if (!this.world) return false;
    const moves = this.arena.draw(view, time);
    const { pointed } = this.arena;
    showTooltip(this.arena, this.tip, view.now, this.why?.robot === pointed ? this.why.text : "");
    if (this.arena.has(pointed)) this.wonder(pointed, view.now.step, time);
    const { feasible, infeasible } = view.now;
    const { standing, tasks, taken } = view.now,
      all = standing + doneAmong(taken),
      done = !taken ? "" : `; ${formatted(all)} of ${formatted(tasks)} tasks taken`,
      text = `${formatted(feasible)} feasible, ${formatted(infeasible)} infeasible; ${decided(view.now, this.world)}${done}`;
    const [name, said] = /** @type {HTMLCollectionOf<HTMLElement>} */ (this.caption.children);
    if (said.textContent !== text) said.textContent = text;
    if (name.textContent !== this.world.strategy) name.textContent = this.world.strategy;
    return moves;
  }

  /**
   * Ask why a robot holds its opinion, if that isn't known of this step.
   * @param {number} robot
   * @param {number} step
   * @param {number} time
   */
  wonder(robot, step, time) {
    const { asked } = this;
    if (asked.robot === robot && (asked.step === step || time - asked.time < AGAIN)) return;
    if (this.ask(robot)) this.asked = { robot, step, time };
  }

  /** @param {string} now What the clock does, in words. */
  describe(now) {
    const { world, there } = this;
    const label =
      world && `The arena: ${there.robots} robots and ${there.tasks} tasks, ${world.strategy}, ${now}`;
    const text = `${label || "The arena"}. Arrow keys go from robot to robot.`;
    if (this.canvas.getAttribute("aria-label") !== text) this.canvas.setAttribute("aria-label", text);
  }
}

/**
 * Return what is known of a run before its first step.
 * @param {number} last
 * @param {boolean} changes
 */
function begun(last, changes) {
  /** @type {number[][]} */
  const [feasible, infeasible, counted, truths] = [[], [], [], []];
  return { last, feasible, infeasible, counted, truths: changes ? truths : undefined, decisionStep: -1 };
}

/**
 * Return the outlook before anything is found.
 * @param {number | null} robot
 * @returns {Outlook}
 */
function nothing(robot) {
  return { robot, changes: [], world: [], decision: -1, declaration: -1, allTaken: -1, done: false };
}

/**
 * Return in words what a swarm has decided: first, or in a world that changes, at this step.
 * @param {Frame} frame
 * @param {Opened} world
 */
function decided({ decision, firstDecision, decisionStep, truth }, { changes }) {
  const opinion = changes ? decision : firstDecision;
  if (opinion < 0) return "undecided";
  const when = changes ? "" : ` at step ${formatted(decisionStep)}`;
  return `${OPINIONS[opinion]}${when}: ${opinion === truth ? "right" : "wrong"}`;
}
