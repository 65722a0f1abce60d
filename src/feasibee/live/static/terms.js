// What is seen in an arena, in a sentence each: the same on the live page, in the page of one file and in notebooks.

import { make } from "./elements.js";

/** @type {[string, string][]} */
export const TERMS = [
  ["Exploring", "A robot without a ring. It counts the robots and tasks that it sees."],
  [
    "Broadcasting",
    "A robot with a ring. It sends its opinion, or what it knows, to all robots within its radio range: it disseminates.",
  ],
  [
    "Opinion",
    "What the robot holds. Full blue: feasible, the robots are enough. Hollow vermilion: infeasible, they are too few. Small grey: no opinion.",
  ],
  [
    "Declaration",
    "A robot with a dark rim. It has declared its opinion and keeps it. Few strategies declare.",
  ],
  [
    "Truth",
    "Whether the robots are really enough for the tasks. It is computed from the scenario, and no robot knows it.",
  ],
];

/**
 * Fill a list with the terms.
 * @param {HTMLElement} list A dl.
 */
export function explainTerms(list) {
  list.append(...TERMS.map(([term, text]) => make("div", {}, make("dt", {}, term), make("dd", {}, text))));
}
