// The binary messages of the server, from messages.py, and the bits of a robot's flags.

export const PROTOCOL = 6;
export const FEASIBLE = 1,
  NEUTRAL = 2,
  DISSEMINATING = 4,
  DECLARED = 8,
  WORKING = 16,
  BYZANTINE = 32,
  STUBBORN = 64,
  THERE = 128,
  STANDING = 256;
export const NO_TASK = 65535; // as aim of a robot
const ARRAYS = { i4: Int32Array, u2: Uint16Array, u1: Uint8Array };

/** @typedef {{x: Uint16Array, y: Uint16Array}} Places In 65,536ths of the arena's longer side. */
/**
 * Tasks; their numbers, if they come and go; and if robots act, 0 for a free one, 1 taken, 2 done.
 * @typedef {Places & {numbers?: Uint16Array, taken?: Uint8Array}} Shown
 */
/** @typedef {{aims?: Uint16Array, taken?: Uint8Array}} Acting The task of each robot, as its place among those shown. */
/** @typedef {Places & {type: "tasks", generation: number}} Tasks Positions of the tasks at the start. */
/** @typedef {"feasible" | "infeasible" | "counted" | "disseminating" | "working" | "there" | "standing"} Count Robots at this step. */
/** @typedef {"declaredFeasible" | "declaredInfeasible"} Declared Counted robots only. */
/** @typedef {"tasks" | "truth" | "decision"} Now At this step; decision: 1, 0, or -1 for none. */
/** @typedef {"firstDecision" | "decisionStep" | "allTakenStep"} Decided The first decision, and that they did it; or -1. */
/** @typedef {"bits" | "robotSteps"} Total Bits sent, and robots summed over the steps, so far. */
/** @typedef {"feasibleCounts" | "infeasibleCounts" | "countedCounts"} Curve Counts of the steps from `first` on. */
/**
 * One step of a swarm, and of that beside it; robots: number of numbers that robots may have; lane: 0, or 1 for the
 * second swarm; jump: number of the page's last jump.
 * @typedef {Places & Acting & {type: "frame", beside?: Frame} & Record<"flags" | "taskX" | "taskY" | "taskNumbers", Uint16Array>
 *   & Record<"heading" | "truths", Uint8Array> & Record<Curve, Int32Array>
 *   & Record<"generation" | "lane" | "jump" | "robots" | "step" | "first", number>
 *   & Record<Count | Declared | Now | Decided | Total, number>} Frame
 */

/**
 * @param {ArrayBuffer} buffer
 * @returns {Frame | Tasks}
 */
export function decode(buffer) {
  let at = 4 + new DataView(buffer).getUint32(0, true);
  const message = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, at - 4)));
  if (message.protocol !== PROTOCOL) throw new Error("the server has another version; reload the page");
  for (const [name, kind, length] of message.arrays) {
    message[name] = new ARRAYS[/** @type {keyof typeof ARRAYS} */ (kind)](buffer, at, length);
    at += message[name].byteLength;
  }
  return message;
}
