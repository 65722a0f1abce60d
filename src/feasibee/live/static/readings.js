// What the page says beside the arena: the question, the answer of this run and of a hundred, and counts of the step.

import { $, announce, duration, formatted, list, write } from "./elements.js";
import { BYZANTINE, DECLARED, DISSEMINATING, opinionOf, STANDING, THERE, WORKING } from "./frames.js";
import { sentencesOf } from "./swarms.js";
import { answerOf, doneAmong, doneOf, progressOf, questionOf } from "./words.js";

let said = ""; // of the decision

/**
 * Show what is known of the runs, and of the present step.
 * @param {Lane[]} lanes That are shown.
 * @param {Frame[]} frames Of each.
 */
export function showReadings(lanes, frames) {
  const [{ history, asked }] = lanes,
    [frame] = frames;
  if (!history || !asked) return;
  const { step, feasible, infeasible, counted } = frame,
    none = counted - feasible - infeasible,
    { seconds } = asked.opened;
  showQuestion(lanes[0], frame);
  write($("now-held"), lanes.length > 1 || history.changes ? "" : progressOf(history, frame));
  for (const [k, id] of ["decision", "decision-second"].entries())
    showDecision($(id), lanes[k], frames[k], lanes.length > 1);
  for (const [id, count] of Object.entries({ now: step, last: history.last, feasible, infeasible, none }))
    write($(id), formatted(count));
  write($("time"), seconds ? `, ${duration(step * seconds)}` : "");
  $("none-row").hidden = !none;
  const shares = `At step ${step}, ${feasible} hold feasible and ${infeasible} infeasible.`;
  $("plot").ariaLabel = `Share of robots with each opinion over ${step} steps. ${shares}`;
  if (/** @type {HTMLDetailsElement} */ ($("counts")).open) list($("counts"), countsOf(history, frame));
}

/**
 * @param {Lane} lane
 * @param {Frame} frame
 */
function showQuestion({ history, asked }, { there, tasks, taken, step, allTaken, flags }) {
  if (!history || !asked) return;
  const { question, answer } = questionOf({ robots: there, tasks }, history.missing[step]),
    { proof } = asked.opened,
    isFirst = !history.changes && JSON.stringify(asked.settings) === JSON.stringify(asked.opened.settings);
  write($("question"), question);
  write($("truth"), `Truth: ${answer}${isFirst && proof ? ` (${proof})` : ""}`);
  if (!taken) return write($("done"), "");
  const standing = flags.filter((each) => each & STANDING).length,
    now = { robots: there, tasks, standing, done: doneAmong(taken), allTakenStep: allTaken, step },
    done = doneOf(now, history.last);
  write($("done"), `${done.question} ${done.answer}`);
}

/**
 * Say what a swarm decides: as soon as it is simulated, before time has come there.
 * @param {HTMLElement} place
 * @param {Lane | undefined} lane
 * @param {Frame | undefined} frame
 * @param {boolean} isOneOfTwo
 */
function showDecision(place, lane, frame, isOneOfTwo) {
  if (!lane?.history || !frame) return write(place, "");
  const { right, text } = answerOf(lane.history, frame),
    whole = lane.history.problem || text,
    verdict = right === null ? "" : right ? "right" : "wrong";
  write(place, isOneOfTwo ? `${lane.strategy.name}: ${whole}` : whole);
  place.dataset.verdict = verdict;
  if (place.id !== "decision") return;
  $("verdict").dataset.verdict = verdict;
  if (verdict && said !== whole) announce((said = whole));
}

/**
 * Return the numbers of a step that aren't on the first screen.
 * @param {RunHistory} history
 * @param {Frame} frame
 */
function countsOf({ numbers }, { step, flags, there, tasks, bits, counted }) {
  const having = (/** @type {number} */ bits) =>
      flags.filter((each) => each & THERE && (each & bits) === bits),
    working = having(WORKING).length,
    sending = having(DISSEMINATING).length,
    declared = having(DECLARED | WORKING).filter((each) => !(each & BYZANTINE)),
    yes = declared.filter((each) => opinionOf(each) > 0).length,
    steps = numbers.there.slice(1, step + 1).reduce((sum, each) => sum + each, 0); // of all robots
  /** @type {[string, string][]} */
  const rows = [
    ["robots, tasks", `${formatted(there)}, ${formatted(tasks)}`],
    ["exploring", formatted(working - sending)],
    ["broadcasting", formatted(sending)],
    ["stopped", working < there ? formatted(there - working) : ""],
    [
      "have declared",
      declared.length
        ? `${formatted(yes)} feasible, ${formatted(declared.length - yes)} infeasible, of ${formatted(counted)}`
        : "",
    ],
    ["bits sent per robot and step", ((steps && bits / steps) || 0).toPrecision(3).replace(/\.?0+$/, "")],
  ];
  return rows.filter(([, text]) => text);
}

/**
 * Say what a hundred swarms of each kind decide.
 * @param {Lane[]} lanes
 */
export function showMany(lanes) {
  const sentences = lanes.map(({ outcomes }) => sentencesOf(outcomes));
  for (const [k, id] of ["many", "many-second"].entries()) {
    const [first = ""] = sentences[k] ?? [];
    write($(id), lanes[k] && lanes.length > 1 ? `${lanes[k].strategy.name}: ${first}` : first);
  }
  write($("sentences"), sentences[0].join(" "));
  $("swarms").ariaBusy = String(lanes.some((each) => !each.isCounted));
}
