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
