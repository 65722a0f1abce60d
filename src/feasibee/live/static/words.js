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
 * @param {number} [missing] Number of robots that are missing, in all pieces of a place together.
 */
export function questionOf({ robots, tasks }, missing = 0) {
  const spare = robots - tasks,
    where = missing + spare > 0 ? " where they are needed" : "";
  const answer = missing
    ? `No: ${counted(missing, missing === 1 ? "robot is" : "robot")}${missing === 1 ? "" : " are"} missing${where}`
    : `Yes: ${spare ? `${counted(spare, "robot")} to spare` : "just enough"}`;
  return { question: `Can ${counted(robots, "robot")} do ${counted(tasks, "task")}?`, answer };
}

/**
 * The number of tasks that are done.
 * @param {Uint8Array} [taken]
 */
export function doneAmong(taken) {
  return taken?.filter((each) => each === 2).length ?? 0;
}

/**
 * Whether robots that act did the tasks, so far.
 * @param {{robots: number, tasks: number, standing: number, done: number, allTakenStep: number, step: number}} now
 * @param {number} last
 */
export function doneOf({ robots, tasks, standing, done, allTakenStep, step }, last) {
  const all = standing + done === tasks,
    more = done ? ` and have done ${done.toLocaleString("en")}` : "",
    ended = all || allTakenStep >= 0 || step >= last,
    word = all ? "Yes" : ended ? "No" : "Not yet",
    since = ended && allTakenStep >= 0 ? `, from step ${allTakenStep.toLocaleString("en")} on` : "",
    most = !all && allTakenStep >= 0 ? ", as many as they can" : "";
  return {
    question: `Did ${counted(robots, "robot")} do ${counted(tasks, "task")}?`,
    answer: `${word}: robots stand at ${standing.toLocaleString("en")} of ${counted(tasks, "task")}${more}${most}${since}.`,
  };
}

/**
 * The swarm's decision and whether it is right; in a world that changes, that of this step.
 * @param {{decision: number, decisionStep: number, last: number, missing: number[], needed: number[], changes: boolean}} recording
 * @param {{step: number, feasible: number, infeasible: number, decision: number}} frame
 */
export function decisionOf({ decision, decisionStep, last, missing, needed, changes }, frame) {
  const [held, at] = changes ? [frame.decision, frame.step] : [decision, decisionStep];
  if (held >= 0 && at <= frame.step) {
    const right = held === Number(missing[at] === 0),
      what = changes ? "holds" : "decided",
      when = changes ? "at this step" : `at step ${at.toLocaleString("en")}`;
    return {
      right,
      text: `The swarm ${what} ${OPINIONS[held]} ${when}. That is ${right ? "right" : "wrong"}.`,
    };
  }
  const most = Math.max(frame.feasible, frame.infeasible),
    ended =
      frame.step >= last ? `The run ended at step ${last.toLocaleString("en")} without a decision.` : "";
  return {
    right: null,
    text: ended || `Not decided yet: ${most} of the ${needed[frame.step]} robots needed agree.`,
  };
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
