// What the page says in words.

/** @import { Settings } from "./world.js" */

/** @type {Record<number, string>} */
export const OPINIONS = { 1: "feasible", 0: "infeasible", [-1]: "undecided" };
const NORMAL_QUANTILE = 1.959963984540054; // of 0.975: 95 % intervals

/**
 * @param {number} count
 * @param {string} word
 */
export function counted(count, word) {
  return `${count.toLocaleString("en")} ${word}${count === 1 ? "" : "s"}`;
}

/**
 * The question and the truth.
 * @param {Pick<Settings, "robots" | "tasks">} settings
 */
export function questionOf({ robots, tasks }) {
  const more = tasks - robots;
  const answer =
    more > 0
      ? `No: ${counted(more, more === 1 ? "robot is" : "robot")}${more === 1 ? "" : " are"} missing`
      : `Yes: ${more ? `${counted(-more, "robot")} to spare` : "just enough"}`;
  return { question: `Can ${counted(robots, "robot")} do ${counted(tasks, "task")}?`, answer };
}

/**
 * The swarm's decision and whether it is right.
 * @param {Settings} settings
 * @param {{decision: number, decisionStep: number, last: number}} recording
 * @param {{step: number, feasible: number, infeasible: number}} frame
 * @param {number} needed
 */
export function decisionOf({ robots, tasks }, { decision, decisionStep, last }, frame, needed) {
  if (decision >= 0 && decisionStep <= frame.step) {
    const right = decision === Number(robots >= tasks);
    return {
      right,
      text: `The swarm decided ${OPINIONS[decision]} at step ${decisionStep.toLocaleString("en")}. That is ${right ? "right" : "wrong"}.`,
    };
  }
  const most = Math.max(frame.feasible, frame.infeasible),
    ended =
      frame.step >= last ? `The run ended at step ${last.toLocaleString("en")} without a decision.` : "";
  return { right: null, text: ended || `Not decided yet: ${most} of the ${needed} robots needed agree.` };
}

/**
 * A rate with its Wilson interval of 95 %.
 * @param {number} successes
 * @param {number} trials
 * @returns {[number, number, number]}
 */
export function wilson(successes, trials) {
  const z = NORMAL_QUANTILE,
    rate = successes / trials,
    shrink = 1 + (z * z) / trials;
  const centre = (rate + (z * z) / (2 * trials)) / shrink,
    half = (z / shrink) * Math.sqrt((rate * (1 - rate)) / trials + (z * z) / (4 * trials * trials));
  return [rate, successes ? centre - half : 0, successes === trials ? 1 : centre + half];
}

/**
 * @param {number} successes
 * @param {number} trials
 */
export function shareOf(successes, trials) {
  const [rate, low, high] = wilson(successes, trials).map((each) => each.toFixed(2));
  return `${rate} (${low} to ${high})`;
}
