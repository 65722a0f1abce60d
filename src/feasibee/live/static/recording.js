// All steps of a run that have been simulated, so that any of them can be shown again at once.

import { formatted } from "./elements.js";
import { DISSEMINATING, FEASIBLE, NEUTRAL } from "./frames.js";

/** @import { Arena } from "./arena.js" */
/** @import { Frame } from "./frames.js" */
/** @import { Settings, World } from "./world.js" */

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
    this.last = steps;
    this.stops = stops;
    world.begin(settings);
    this.missing = world.missing;
    this.taskX = world.places("world_task_x");
    this.taskY = world.places("world_task_y");
    /** @type {Pick<Frame, "x" | "y" | "flags" | "heading">[]} */
    this.steps = [];
    /** @type {number[]} */
    this.feasible = [];
    /** @type {number[]} */
    this.infeasible = [];
    /** @type {number[]} */
    this.counted = [];
    this.decision = -1;
    this.decisionStep = -1;
    this.record();
  }

  /**
   * Let an arena show the world of this run.
   * @param {Arena} arena
   */
  openIn(arena) {
    const { last, missing, taskX, taskY, settings } = this,
      { robots, tasks, strategy } = settings,
      { lengths, strategies } = this.world.given,
      { declares } = strategies[strategy];
    arena.open({ ...lengths, robots, numbers: robots, tasks, last, truth: missing === 0, declares });
    arena.setTasks({ x: taskX, y: taskY });
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
      this.world.exports.world_step();
      this.record();
    }
    return Math.min(step, this.last);
  }

  record() {
    const { world } = this,
      { world_feasible, world_infeasible, world_decision } = world.exports;
    this.steps.push({
      x: world.places("world_x"),
      y: world.places("world_y"),
      flags: world.flags.slice(),
      heading: world.headings.slice(),
    });
    this.feasible.push(world_feasible());
    this.infeasible.push(world_infeasible());
    this.counted.push(world.robots);
    if (this.decision < 0 && (this.decision = world_decision()) >= 0) {
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
    const { robots } = this.settings,
      at = this.until(step);
    return /** @type {Frame} */ ({
      ...this.steps[at],
      step: at,
      robots,
      feasible: this.feasible[at],
      infeasible: this.infeasible[at],
      taskX: this.taskX,
      taskY: this.taskY,
    });
  }
}
