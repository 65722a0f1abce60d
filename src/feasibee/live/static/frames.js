// Made by `python -m feasibee.live.layout`. A test compares it with that module.
export const PROTOCOL = 4;
export const FEASIBLE = 1,
  NEUTRAL = 2,
  DISSEMINATING = 4,
  DECLARED = 8,
  WORKING = 16,
  BYZANTINE = 32,
  STUBBORN = 64,
  THERE = 128;
const FRAME = 1;

/**
 * @param {ArrayBuffer} buffer
 * @param {DataView} view
 */
function frame(buffer, view) {
  const length = view.getInt32(16, true),
    robots = view.getUint32(4, true),
    placed = view.getUint32(64, true);
  return {
    kind: /** @type {const} */ ("frame"),
    generation: view.getUint16(2, true),
    robots,
    step: view.getUint32(8, true),
    first: view.getUint32(12, true),
    decisionStep: view.getInt32(20, true),
    decision: view.getInt8(24),
    firstDecision: view.getInt8(25),
    lane: view.getUint8(26),
    jump: view.getUint8(27),
    feasible: view.getUint32(28, true),
    infeasible: view.getUint32(32, true),
    counted: view.getUint32(36, true),
    disseminating: view.getUint32(40, true),
    working: view.getUint32(44, true),
    declaredFeasible: view.getUint32(48, true),
    declaredInfeasible: view.getUint32(52, true),
    there: view.getUint32(56, true),
    tasks: view.getUint32(60, true),
    placed,
    truth: view.getUint32(68, true),
    bits: Number(view.getBigUint64(72, true)),
    robotSteps: Number(view.getBigUint64(80, true)),
    feasibleCounts: new Int32Array(buffer, 88, length),
    infeasibleCounts: new Int32Array(buffer, 88 + 4 * length, length),
    countedCounts: new Int32Array(buffer, 88 + 8 * length, length),
    x: new Uint16Array(buffer, 88 + 12 * length, robots),
    y: new Uint16Array(buffer, 88 + 12 * length + 2 * robots, robots),
    flags: new Uint16Array(buffer, 88 + 12 * length + 4 * robots, robots),
    taskX: new Uint16Array(buffer, 88 + 12 * length + 6 * robots, placed),
    taskY: new Uint16Array(buffer, 88 + 12 * length + 6 * robots + 2 * placed, placed),
    heading: new Uint8Array(buffer, 88 + 12 * length + 6 * robots + 4 * placed, robots),
    truths: new Uint8Array(buffer, 88 + 12 * length + 7 * robots + 4 * placed, length),
  };
}

/**
 * @param {ArrayBuffer} buffer
 * @param {DataView} view
 */
function tasks(buffer, view) {
  const count = view.getUint32(4, true);
  return {
    kind: /** @type {const} */ ("tasks"),
    generation: view.getUint16(2, true),
    x: new Uint16Array(buffer, 8, count),
    y: new Uint16Array(buffer, 8 + 2 * count, count),
  };
}

// End of the generated part.

/** @typedef {ReturnType<typeof frame> & {beside?: Frame}} Frame One step of a swarm, and of that beside it. */
/** @typedef {ReturnType<typeof tasks>} Tasks Positions of the tasks at the start. */
/** @typedef {{x: Uint16Array, y: Uint16Array}} Places Of tasks. */

/**
 * @param {ArrayBuffer} buffer
 * @returns {Frame | Tasks}
 */
export function decode(buffer) {
  const view = new DataView(buffer);
  if (view.getUint8(0) !== PROTOCOL) throw new Error("the server has another version; reload the page");
  return view.getUint8(1) === FRAME ? frame(buffer, view) : tasks(buffer, view);
}
