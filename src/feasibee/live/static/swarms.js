// What a hundred swarms decide, in marks and in sentences.

import { RUNS } from "./engine.js";
import { make } from "./elements.js";
import { counted, OPINIONS, wilson } from "./words.js";

/** @type {Record<number, string>} */
const MARKS = { 1: "dot feasible", 0: "dot hollow infeasible", [-1]: "dot undecided" };

/**
 * Return the outcomes of runs 0, 1, 2, ... in sentences: the first is the answer.
 * @param {Outcome[]} outcomes
 */
export function sentencesOf(outcomes) {
  const done = outcomes.length;
  if (!done) return ["Simulating 100 swarms ..."];
  const right = outcomes.filter((each) => each.isRight).length,
    [low, high] = wilson(right, done).slice(1),
    number = (/** @type {number} */ decision) => outcomes.filter((each) => each.decision === decision).length,
    parts = [1, 0, -1]
      .filter((each) => each >= 0 || number(each))
      .map((each) => `${number(each)} ${OPINIONS[each]}`),
    steps = outcomes.filter((each) => each.decision >= 0).map((each) => each.step),
    median = steps.sort((a, b) => a - b)[(steps.length - 1) >> 1];
  return [
    `Right in ${right} of ${done} swarms${done < RUNS ? " so far" : ""} (${Math.round(100 * low)} to ${Math.round(100 * high)} % of all such swarms).`,
    `${counted(done, "swarm")}: ${parts.join(", ")}.`,
    ...(steps.length ? [`Median step of the decisions: ${median.toLocaleString("en")}.`] : []),
  ];
}

/**
 * Show a mark per run, as the robots of the arena.
 * @param {HTMLElement} place
 * @param {Outcome[]} outcomes
 * @param {number} [chosen]
 */
export function showRuns(place, outcomes, chosen) {
  if (!place.childElementCount)
    place.append(...Array.from({ length: RUNS }, () => make("span", {}, make("i", {}))));
  for (const [run, { firstElementChild: mark, classList }] of [...place.children].entries()) {
    classList.toggle("chosen", run === chosen);
    if (mark) mark.className = MARKS[outcomes[run]?.decision] ?? "";
  }
}
