// All steps of a run, as a worker or the log of a field gives them: what is shown, sought and marked is looked up here.

import { DECLARED, DISSEMINATING, FEASIBLE, NEUTRAL, STANDING, THERE, WORKING } from "./frames.js";

/** Numbers of a step; declaration, allTaken: steps, or -1; missing: robots without which the tasks aren't feasible. */
export const NUMBERS = /** @type {const} */ ([
  ...["there", "tasks", "counted", "feasible", "infeasible", "needed", "decision", "missing"],
  ...["bits", "declaration", "allTaken"],
]);
/** Columns of robots; one step's robots stand after those of another. */
export const COLUMNS = {
  x: Uint16Array,
  y: Uint16Array,
  flags: Uint16Array,
  heading: Uint8Array,
  aims: Uint16Array, // if robots act
};
const SHOWN = FEASIBLE | NEUTRAL | DISSEMINATING | DECLARED | WORKING | THERE | STANDING; // changes of a robot

export class History {
  /**
   * @param {Settings} settings
   * @param {Opened} opened
   * @param {number} last
   */
  constructor(settings, opened, last = opened.run.steps) {
    this.settings = settings;
    this.opened = opened;
    this.last = last;
    this.changes = settings.events.length > 0 || opened.lengths.changes;
    this.done = false;
    this.problem = "";
    this.every = 1;
    this.robots = 0; // numbers that robots may have
    this.columns = /** @type {Columns} */ ({});
    /** @type {There[]} */
    this.there = [];
    /** @type {Record<Count, number[]>} */
    this.numbers = /** @type {any} */ (Object.fromEntries(NUMBERS.map((name) => [name, []])));
    this.missing = this.numbers.missing;
    this.needed = this.numbers.needed;
    this.decision = this.decisionStep = -1;
  }

  get known() {
    return this.missing.length - 1;
  }

  /** @param {"declaration" | "allTaken"} what Whose step is returned; -1 if the swarm didn't come so far. */
  reached(what) {
    return this.numbers[what].at(-1) ?? -1;
  }

  /** @param {Steps} steps */
  add({ from, count, every, robots, numbers, there, done, problem, ...more }) {
    Object.assign(this, { every, robots, done, problem });
    for (let at = from, k = 0; at < from + count; at++)
      for (const name of NUMBERS) this.numbers[name][at] = numbers[k++];
    const place = Math.ceil(from / every) * robots,
      most = (Math.floor(this.last / every) + 1) * robots,
      own = /** @type {any} */ (this.columns);
    for (const [name, Kind] of Object.entries(COLUMNS)) {
      const added = more[/** @type {keyof Columns} */ (name)] ?? [],
        kept = own[name] ?? new Kind(0),
        length = added.length && place + added.length;
      own[name] = kept.length < length ? enlarged(kept, Math.max(length, Math.min(2 * length, most))) : kept;
      if (length) own[name].set(added, place);
    }
    this.there.push(...there);
    if (this.decision < 0) {
      this.decisionStep = this.numbers.decision.findIndex((each) => each >= 0);
      this.decision = this.numbers.decision[this.decisionStep] ?? -1;
    }
    if (done) this.last = Math.max(0, this.known);
  }

  /**
   * Return a step as the arena draws it: with the robots of the last one that is kept, if those of this one aren't.
   * @param {number} wanted
   * @returns {Frame}
   */
  frame(wanted) {
    const { every, robots, columns, numbers } = this,
      step = Math.max(0, Math.min(wanted, this.known)),
      kept = Math.floor(step / every),
      own = Object.entries(columns).map(([name, all]) => [
        name,
        all.subarray(kept * robots, (kept + 1) * robots),
      ]),
      counts = NUMBERS.map((name) => [name, numbers[name][step]]);
    return {
      .../** @type {There} */ (this.there.findLast((each) => each.step <= kept * every)),
      ...Object.fromEntries(own),
      ...Object.fromEntries(counts),
      robots,
      step,
    };
  }

  /**
   * Return the steps at which what is seen of a robot changes, and its flags from there on.
   * @param {number} robot
   */
  changesOf(robot) {
    const { every, robots, known } = this,
      { flags } = this.columns;
    /** @type {[number, number][]} */
    const found = [];
    for (let step = 0; step <= known; step += every) {
      const now = flags[(step / every) * robots + robot] & SHOWN;
      if (found.at(-1)?.[1] !== now) found.push([step, now]);
    }
    return found;
  }

  // The steps at which the world changes, each with its numbers of robots and tasks and the truth from there on.
  changesOfWorld() {
    const { there, tasks, missing } = this.numbers;
    /** @type {[number, number, number, number][]} */
    const found = [];
    for (let at = 0; this.changes && at <= this.known; at++) {
      const [, ...before] = found.at(-1) ?? [];
      if (String(before) !== String([there[at], tasks[at], Number(missing[at] === 0)]))
        found.push([at, there[at], tasks[at], Number(missing[at] === 0)]);
    }
    return found;
  }

  // The steps at which the truth changes, with the truth from there on; the first is that at the start.
  changesOfTruth() {
    return this.changesOfWorld()
      .filter(([, , , truth], k, all) => truth !== all[k - 1]?.[3])
      .map(([step, , , truth]) => [step, truth]);
  }

  /**
   * Return since when a robot holds its opinion, since when its phase lasts, and its next phase; null if that isn't known.
   * @param {number} robot
   * @param {number} step
   * @returns {Moment}
   */
  moment(robot, step) {
    const changes = this.changesOf(robot),
      [held, begun] = [FEASIBLE | NEUTRAL, DISSEMINATING].map((bits) =>
        changes.filter(([at, flags], k) => !k || (changes[k - 1][1] ^ flags) & bits),
      ),
      sinceIn = (/** @type {[number, number][]} */ all) => all.findLast(([at]) => at <= step)?.[0] ?? 0,
      next = begun.findIndex(([at]) => at > step),
      [at, flags] = begun[next] ?? [];
    return {
      step,
      since: { held: sinceIn(held), begun: sinceIn(begun) },
      next: next < 0 ? null : { step: at, flags, lasts: begun[next + 1] ? begun[next + 1][0] - at : null },
    };
  }
}

/**
 * Return an array with the same numbers and more room.
 * @template {Uint16Array | Uint8Array} Kind
 * @param {Kind} array
 * @param {number} length
 */
function enlarged(array, length) {
  const Kind = /** @type {any} */ (array.constructor),
    larger = new Kind(length);
  larger.set(array);
  return /** @type {Kind} */ (larger);
}
