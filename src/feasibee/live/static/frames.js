// The bits of a robot's flags, and a step as the arena draws it.

import { OPINIONS } from "./words.js";

export const FEASIBLE = 1;
export const NEUTRAL = 2;
export const DISSEMINATING = 4;
export const DECLARED = 8;
export const WORKING = 16;
export const BYZANTINE = 32;
export const STUBBORN = 64;
export const THERE = 128;
export const STANDING = 256;
export const NO_TASK = 65535; // as aim of a robot

/**
 * Tasks, and classes of robots, from a step on; taken, if robots act: 0 for a free task, 1 taken, 2 done.
 * @typedef {{step: number, taskX: Uint16Array, taskY: Uint16Array, taskNumbers: Uint16Array, taken?: Uint16Array,
 *   kinds: number[]}} There
 */
/**
 * A step of a swarm: places in 65,536ths of the arena's longer side; robots: number of numbers that robots may have; aims:
 * the task of each robot, as its place among those shown; decision: 1, 0, or -1.
 * @typedef {There & import("./history.js").Columns & Record<import("./history.js").Count | "robots", number>} Frame
 */

/**
 * Return a robot's opinion: 1 for feasible, 0 for infeasible, -1 for none.
 * @param {number} flags
 */
export const opinionOf = (flags) => (flags & NEUTRAL ? -1 : flags & FEASIBLE);

/**
 * Return the shade in which a robot's opinion is drawn.
 * @param {number} flags
 */
export const shadeOf = (flags) =>
  /** @type {const} */ (["undecided", "infeasible", "feasible"])[1 + opinionOf(flags)];

/**
 * Return in words what is seen of a robot.
 * @param {Frame} frame
 * @param {number} robot
 * @param {string} [name] Of its class.
 */
export function lookOf(frame, robot, name) {
  const flags = frame.flags[robot],
    aim = frame.aims[robot] ?? NO_TASK,
    opinion = opinionOf(flags);
  const words = [
    opinion < 0 ? "no opinion" : OPINIONS[opinion],
    !(flags & WORKING) ? "stopped" : flags & DISSEMINATING ? "broadcasting" : "exploring",
    name && `class ${name}`,
    flags & BYZANTINE && "Byzantine",
    flags & STUBBORN && "stubborn",
    flags & DECLARED && "has declared",
    aim !== NO_TASK && `${flags & STANDING ? "stands at" : "walks to"} task ${frame.taskNumbers[aim]}`,
    (!(flags & WORKING) || flags & BYZANTINE) && "not counted",
  ];
  return words.filter(Boolean).join(", ");
}
