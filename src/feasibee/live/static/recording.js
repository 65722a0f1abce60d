// All steps of a run that have been simulated, so that any of them can be shown again at once.

import { formatted } from "./elements.js";
import { DISSEMINATING, FEASIBLE, NEUTRAL } from "./frames.js";

const MOST_KEPT = 2 ** 25; // robots times steps that are kept

/** @import { Arena } from "./arena.js" */
/** @import { Frame } from "./frames.js" */
/** @import { Settings, Shown, World } from "./world.js" */

export class Recording {
  /**
   * Begin a run.
   * @param {World} world
   * @param {Settings} settings
   */
  constructor(world, settings) {
    const { steps, stops } = world.given.run;
    this.world = world;
    this.settings = settings;
    this.stops = stops;
    if (!world.begin(settings)) throw new RangeError("no memory");
    this.last = Math.min(steps, Math.floor(MOST_KEPT / (settings.robots + 1)));
    this.changes = settings.events.length > 0 || world.given.lengths.changes;
    /** @type {Shown[]} */
    this.steps = [];
    /** @type {number[]} */
    this.missing = []; // robots without which the tasks aren't feasible, at each step
    /** @type {number[]} */
    this.needed = []; // robots that must hold an opinion for the swarm to have decided, likewise
    /** @type {number[]} */
    this.feasible = [];
    /** @type {number[]} */
    this.infeasible = [];
    /** @type {number[]} */
    this.counted = [];
    this.decision = -1;
    this.decisionStep = -1;
    this.record();
    this.taskX = this.steps[0].taskX; // at the start
    this.taskY = this.steps[0].taskY;
  }

  // Let the world go on with this run after another one.
  resume() {
    this.world.begin(this.settings);
    this.world.play("feasibee_to", this.known);
  }

  /**
   * Let an arena show the world of this run.
   * @param {Arena} arena
   */
  openIn(arena) {
    const { last, missing, taskX, taskY, settings, changes, world } = this,
      { robots, tasks, strategy } = settings,
      { lengths, strategies } = world.given,
      { declares } = strategies[strategy],
      [{ robots: numbers, kinds }] = this.steps,
      shown = { robots, numbers, tasks, last, changes, truth: missing[0] === 0, declares };
    arena.open({ ...lengths, ...shown, kinds });
    arena.setTasks({ x: taskX, y: taskY });
  }

  // The truth at each step, in a world that changes.
  get truths() {
    return this.changes ? this.missing.map((each) => Number(each === 0)) : undefined;
  }

  get known() {
    return this.steps.length - 1;
  }

  /**
   * Simulate until a step; return the last one that there is.
   * @param {number} step
   */
  until(step) {
    while (this.known < Math.min(step, this.last)) {
      if (this.world.play("feasibee_to", this.known + 1) < 0) this.last = this.known;
      else this.record();
    }
    return Math.min(step, this.last);
  }

  record() {
    const shown = this.world.shown(),
      before = this.steps.at(-1);
    if (before && !this.changes)
      Object.assign(shown, { taskX: before.taskX, taskY: before.taskY, kinds: before.kinds });
    this.steps.push(shown);
    this.missing.push(shown.missing);
    this.needed.push(shown.needed);
    this.feasible.push(shown.feasible);
    this.infeasible.push(shown.infeasible);
    this.counted.push(shown.counted);
    if (this.decision < 0 && (this.decision = shown.decision) >= 0) {
      this.decisionStep = this.known;
      if (this.stops) this.last = this.known;
    }
  }

  /**
   * Return since when a robot holds its opinion, and since when it explores or broadcasts, in words.
   * @param {number} robot -1 for none.
   * @param {number} step
   */
  since(robot, step) {
    if (robot < 0) return "";
    const flags = this.steps[step].flags[robot],
      [held, begun] = [FEASIBLE | NEUTRAL, DISSEMINATING].map((bits) => {
        let at = step;
        while (at && !((this.steps[at - 1].flags[robot] ^ flags) & bits)) at--;
        return at ? `step ${formatted(at)}` : "the start";
      }),
      opinion = flags & NEUTRAL ? "no opinion" : flags & FEASIBLE ? "feasible" : "infeasible",
      phase = flags & DISSEMINATING ? "Broadcasts" : "Explores";
    return `Holds ${opinion} since ${held}. ${phase} since ${begun}.`;
  }

  /**
   * Return a step as the arena draws it.
   * @param {number} step
   * @returns {Frame}
   */
  frame(step) {
    const at = this.until(step);
    return { ...this.steps[at], step: at };
  }
}
