// A field of processes: its steps come from the log of its world, as they are written.

import { SPEEDS } from "./clock.js";
import { $, announce, capital, formatted, list, write } from "./elements.js";
import { lookOf, THERE } from "./frames.js";
import { History } from "./history.js";

const POLL = 100; // milliseconds between two looks for steps
const LOOK = 1000; // likewise for another field, after the end
const UNKNOWN = 300; // steps per second that are enough for a field in lockstep

/** @typedef {{problems: string[], silent: boolean, ended: boolean, last: number}} State problems: in words. */
/** @typedef {{which: string, steps: Steps & {lost: number[][]}, state: State}} Answer lost: silent robots of each step. */

/**
 * Show a field, from its newest step on, or from its first one if it has ended.
 * @param {Page} page
 * @param {Given} given
 */
export async function watchField(page, { opened, field }) {
  if (!field) return;
  const history = new History(opened.settings, opened),
    /** @type {number[][]} */
    lost = [];
  document.body.dataset.field = "";
  $("field").hidden = false;
  $("robot-hint").textContent = "Click a robot, or press i and the arrow keys, to see what it last reported.";
  page.clock.speed = SPEEDS.find((each) => each >= (field.hz ?? UNKNOWN)) ?? SPEEDS[SPEEDS.length - 1];
  page.lanes[0].tell = (frame, robot) => reasonsOf(frame, robot, lost[frame.step] ?? []);
  for (let wait = 0; ; await new Promise((resolve) => setTimeout(resolve, wait))) {
    const found = await fetched(history.known + 1);
    wait = !found || history.done ? LOOK : POLL;
    if (!found) showState("not connected", "lost");
    else if (found.which !== field.which)
      return location.reload(); // another field has begun
    else {
      const isFirst = history.known < 0 && found.steps.count > 0;
      if (found.steps.count) history.add(found.steps);
      lost.push(...found.steps.lost);
      reflect(found.state, opened, field);
      if (isFirst) page.openField(history, found.state.ended ? 0 : found.state.last);
      else if (found.steps.count) page.came();
    }
  }
}

/**
 * Ask for the steps from one on; null if nothing answers.
 * @param {number} from
 * @returns {Promise<Answer | null>}
 */
async function fetched(from) {
  try {
    const answer = await fetch(`field?from=${from}`);
    return answer.ok ? await answer.json() : null;
  } catch {
    return null;
  }
}

/**
 * Say how a field is.
 * @param {State} state
 * @param {Given["opened"]} opened
 * @param {NonNullable<Given["field"]>} field
 */
function reflect({ problems, silent, ended, last }, { strategies, settings }, { address, hz }) {
  const now = ended ? `ended at step ${formatted(last)}` : silent ? "silent" : "running";
  write($("banner"), problems.length ? `${capital(problems.join("; "))}.` : "");
  if (!showState(ended ? "ended" : silent ? "field silent" : "live", ended ? "" : silent ? "lost" : "live"))
    return;
  if (ended) announce(`The field has ended at step ${formatted(last)}`);
  list($("field"), [
    ["State", now],
    ["Logs", address],
    ["Strategy", strategies[settings.strategy].name],
    ["Clocks", hz === null ? "lockstep" : `${formatted(hz)} steps / s`],
    ["Seed, run", `${settings.seed}, ${settings.run}`],
  ]);
}

/**
 * Show the state at the top; return whether it is another one.
 * @param {string} text
 * @param {string} kind
 */
function showState(text, kind) {
  const isOther = $("state").textContent !== text;
  write($("state"), text);
  $("state").dataset.state = kind;
  return isOther;
}

/**
 * Return what a robot last reported: its own log has the rest.
 * @param {Frame} frame
 * @param {number} robot
 * @param {number[]} lost
 * @returns {[string, string][]}
 */
function reasonsOf(frame, robot, lost) {
  if (lost.includes(robot))
    return [["Process", "silent: the robot isn't counted, and its body stands still"]];
  if (!(frame.flags[robot] & THERE)) return [["State", "not there"]];
  return [
    ["State", lookOf(frame, robot)],
    ["Knows", "the robot's own log has it"],
  ];
}
