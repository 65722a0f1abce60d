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
    this.changes = settings.events.length > 0;
    this.taskX = world.places("world_task_x"); // at the start
    this.taskY = world.places("world_task_y");
    /** @type {Pick<Frame, "x" | "y" | "flags" | "heading" | "taskX" | "taskY" | "taskNumbers" | "decision">[]} */
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
      shown = { robots, numbers: world.robots, tasks, last, changes, truth: missing[0] === 0, declares };
    arena.open({ ...lengths, ...shown });
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
      this.world.exports.world_step();
      this.record();
    }
    return Math.min(step, this.last);
  }

  record() {
    const { world, known, steps } = this,
      { world_feasible, world_infeasible, world_decision, world_missing, world_needed, world_there } =
        world.exports,
      isSame = known >= 0 && !this.settings.events.some((each) => each.step === known + 1);
    this.steps.push({
      x: world.places("world_x"),
      y: world.places("world_y"),
      flags: world.flags.slice(),
      heading: world.headings.slice(),
      taskX: isSame ? steps[known].taskX : world.places("world_task_x"),
      taskY: isSame ? steps[known].taskY : world.places("world_task_y"),
      taskNumbers: isSame ? steps[known].taskNumbers : world.taskNumbers,
      decision: world_decision(),
    });
    this.missing.push(world_missing());
    this.needed.push(world_needed());
    this.feasible.push(world_feasible());
    this.infeasible.push(world_infeasible());
    this.counted.push(world_there());
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
    const at = this.until(step),
      shown = this.steps[at];
    return /** @type {Frame} */ ({
      ...shown,
      step: at,
      robots: shown.x.length,
      there: this.counted[at],
      tasks: shown.taskX.length,
      feasible: this.feasible[at],
      infeasible: this.infeasible[at],
    });
  }
}
