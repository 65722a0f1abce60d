// Binary messages of the server; see messages.py, which says what stands where.

export const PROTOCOL = 1;
export const FEASIBLE = 1,
  NEUTRAL = 2,
  DISSEMINATING = 4,
  COMMITTED = 8,
  COUNTED = 16,
  WORKING = 32,
  LIAR = 64,
  STUBBORN = 128;
const FRAME = 1,
  HEADER = 60,
  TASKS_HEADER = 8;

/** @typedef {ReturnType<typeof frame>} Frame A step of a swarm. */
/** @typedef {ReturnType<typeof tasks>} Tasks Where the tasks are. */

/**
 * @param {ArrayBuffer} buffer
 * @returns {Frame | Tasks}
 */
export function decode(buffer) {
  const view = new DataView(buffer);
  if (view.getUint8(0) !== PROTOCOL) throw new Error("the server speaks another protocol; reload the page");
  return view.getUint8(1) === FRAME ? frame(buffer, view) : tasks(buffer, view);
}

/**
 * @param {ArrayBuffer} buffer
 * @param {DataView} view
 */
function frame(buffer, view) {
  const robots = view.getUint32(4, true),
    length = view.getInt32(16, true);
  let at = HEADER;
  /**
   * @template {ArrayBufferView} T
   * @param {new (buffer: ArrayBuffer, at: number, count: number) => T} kind
   * @param {number} count
   */
  const take = (kind, count) => {
    const array = new kind(buffer, at, count);
    at += array.byteLength;
    return array;
  };
  return {
    kind: /** @type {const} */ ("frame"),
    generation: view.getUint16(2, true),
    robots,
    step: view.getUint32(8, true),
    first: view.getUint32(12, true),
    decisionStep: view.getInt32(20, true),
    decision: view.getInt8(24),
    firstDecision: view.getInt8(25),
    feasible: view.getUint32(28, true),
    infeasible: view.getUint32(32, true),
    counted: view.getUint32(36, true),
    disseminating: view.getUint32(40, true),
    working: view.getUint32(44, true),
    committed: view.getUint32(48, true),
    bits: Number(view.getBigUint64(52, true)),
    feasibleCounts: take(Int32Array, length),
    infeasibleCounts: take(Int32Array, length),
    x: take(Uint16Array, robots),
    y: take(Uint16Array, robots),
    heading: take(Uint8Array, robots),
    marks: take(Uint8Array, robots),
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
    x: new Uint16Array(buffer, TASKS_HEADER, count),
    y: new Uint16Array(buffer, TASKS_HEADER + 2 * count, count),
  };
}
