// What the page says in words.

import { formatted } from "./elements.js";

/** @type {Record<number, string>} */
export const OPINIONS = { 1: "feasible", 0: "infeasible", [-1]: "undecided" };
const NORMAL_QUANTILE = 1.959963984540054; // of 0.975: 95 % intervals

/**
 * @param {number} count
 * @param {string} word
 */
export function counted(count, word) {
  return `${formatted(count)} ${word}${count === 1 ? "" : "s"}`;
}

/**
 * The question and the truth.
 * @param {{robots: number, tasks: number}} settings
 * @param {number} [missing] Number of robots that are missing, in all pieces of a place together.
 */
export function questionOf({ robots, tasks }, missing = 0) {
  const spare = robots - tasks,
    where = missing + spare > 0 ? " where they are needed" : "";
  const answer = missing
    ? `No: ${counted(missing, "robot")} ${missing === 1 ? "is" : "are"} missing${where}`
    : `Yes: ${spare ? `${counted(spare, "robot")} to spare` : "just enough"}`;
  return { question: `Can ${counted(robots, "robot")} do ${counted(tasks, "task")}?`, answer };
}

/**
 * The number of tasks that are done.
 * @param {Uint16Array} [taken]
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
    more = done ? ` and have done ${formatted(done)}` : "",
    ended = all || allTakenStep >= 0 || step >= last,
    word = all ? "Yes" : ended ? "No" : "Not yet",
    since = ended && allTakenStep >= 0 ? `, from step ${formatted(allTakenStep)} on` : "",
    most = !all && allTakenStep >= 0 ? ", as many as they can" : "";
  return {
    question: `Did ${counted(robots, "robot")} do ${counted(tasks, "task")}?`,
    answer: `${word}: robots stand at ${formatted(standing)} of ${counted(tasks, "task")}${more}${most}${since}.`,
  };
}

/**
 * The swarm's decision and whether it is right, as soon as its run is simulated; in a world that changes, what it holds at
 * the step that is shown.
 * @param {{decision: number, decisionStep: number, last: number, missing: ArrayLike<number>, changes: boolean, done: boolean}} history
 * @param {{step: number, decision: number}} frame
 */
export function answerOf({ decision, decisionStep, last, missing, changes, done }, frame) {
  const [held, at] = changes ? [frame.decision, frame.step] : [decision, decisionStep];
  if (held < 0) {
    const none = changes ? "holds no decision at this step" : `doesn't decide by step ${formatted(last)}`;
    return { right: null, text: changes || done ? `The swarm ${none}.` : "Simulating." };
  }
  const right = held === Number(missing[at] === 0),
    what = changes
      ? `holds ${OPINIONS[held]} at this step`
      : `decides ${OPINIONS[held]} at step ${formatted(at)}`;
  return { right, text: `The swarm ${what}. That is ${right ? "right" : "wrong"}.` };
}

/**
 * How near the swarm is to its decision at a step.
 * @param {{decision: number, decisionStep: number, needed: ArrayLike<number>}} history
 * @param {{step: number, feasible: number, infeasible: number}} frame
 */
export function progressOf({ decision, decisionStep, needed }, { step, feasible, infeasible }) {
  if (decision >= 0 && decisionStep <= step) return "At this step it has decided.";
  const most = Math.max(feasible, infeasible);
  return `At this step: ${most} agree, of the ${needed[step]} robots that it takes.`;
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
 * A share of swarms with its interval, as people say it: 85 % (77 to 91).
 * @param {number} successes
 * @param {number} trials
 */
export function shareOf(successes, trials) {
  const [rate, low, high] = wilson(successes, trials).map((each) => Math.round(100 * each));
  return `${rate} % (${low} to ${high})`;
}
