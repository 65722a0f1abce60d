// The worker of a page: it simulates whole runs ahead of what is shown, a hundred more of their kind, and tells what a
// robot knows. Each kind of work has a channel with a world of its own; newer work ends the older one of its channel.

import { COLUMNS, NUMBERS } from "./history.js";
import { worldOf } from "./world.js";

const SLICE = 8; // milliseconds of work between two looks for newer messages
const ROOM = 2 ** 28; // bytes of the robots that are kept of a run
const BYTES = 9; // of a robot at a step
const KEPT = 12; // scenarios: the figures of a lesson are as many
const AT_ONCE = 2 ** 18; // robots times steps in one message
const CHUNK = 4000; // robots times steps between two looks at the clock

/** @typedef {{channel: string, gen: number, key: number, settings: Settings}} Work Of which scenario, by its key. */
/**
 * gen: of its newest work; key: of its scenario; run, step: that is inspected.
 * @typedef {{gen: number, key: number, world: Promise<World>, run: string, step: number}} Channel
 */

/** @type {Map<number, {module: WebAssembly.Module, opened: Opened}>} */
const scenarios = new Map();
/** @type {Map<string, Channel>} */
const channels = new Map();

const { port1: here, port2: there } = new MessageChannel();
/** @type {(() => void)[]} */
const waiting = [];
here.onmessage = () => waiting.shift()?.();

// Let messages come in that are waiting. A timer would take 4 ms.
const pause = () =>
  new Promise((/** @type {(value?: any) => void} */ resolve) => {
    waiting.push(resolve);
    there.postMessage(0);
  });

/** @param {Work} work */
const isNewest = ({ channel, gen }) => channels.get(channel)?.gen === gen;

/**
 * Begin work on its channel, in a world of its scenario; return the channel.
 * @param {Work} work
 */
function channelOf({ channel, gen, key }) {
  let own = channels.get(channel);
  if (own?.key !== key) {
    const { opened, module } = /** @type {any} */ (scenarios.get(key));
    own = { gen, key, world: worldOf(opened, module), run: "", step: -1 };
    channels.set(channel, own);
  }
  own.gen = gen;
  return own;
}

/**
 * Return how many steps to simulate between two looks at the clock.
 * @param {Settings} settings
 */
const chunkOf = ({ robots }) => Math.max(1, Math.round(CHUNK / (robots + 1)));

// The steps that are simulated and not sent yet.
class Unsent {
  /**
   * @param {World} world
   * @param {number} last
   * @param {boolean} changes Whether tasks and classes of robots may be other ones later.
   */
  constructor(world, last, changes) {
    world.copyNumbers(new Int32Array(NUMBERS.length), 0);
    const { robots } = world,
      { aims, ...columns } = COLUMNS,
      kinds = Object.entries(world.opened.lengths.acts ? COLUMNS : columns);
    this.world = world;
    this.changes = changes;
    this.every = Math.max(1, Math.ceil((robots * last * BYTES) / ROOM)); // of so many steps, one is kept
    this.room = Math.max(1, Math.min(Math.floor(last / this.every) + 1, Math.floor(AT_ONCE / (robots + 1))));
    this.columns = /** @type {Columns} */ (
      Object.fromEntries(kinds.map(([name, Kind]) => [name, new Kind(this.room * robots)]))
    );
    this.from = this.count = this.kept = 0;
    this.numbers = new Int32Array(this.room * this.every * NUMBERS.length);
    /** @type {There[]} */
    this.there = [];
    this.add();
  }

  get isFull() {
    return this.kept === this.room;
  }

  // Add the present step.
  add() {
    const { world, every, numbers } = this,
      place = this.count * NUMBERS.length,
      step = this.from + this.count++;
    world.copyNumbers(numbers, place);
    if (step % every) return;
    world.copy(this.columns, this.kept++ * world.robots);
    if (step && !this.changes) return;
    const there = world.there(step, numbers[place + 1]);
    if (!this.last || !isSame(this.last, there)) this.there.push((this.last = there));
  }

  /**
   * Return what has come since the last time.
   * @param {boolean} done
   * @returns {Steps}
   */
  take(done) {
    const { world, from, count, every, kept, columns, there } = this,
      { robots, problem } = world,
      numbers = this.numbers.slice(0, count * NUMBERS.length),
      own = Object.entries(columns).map(([name, all]) => [name, all.slice(0, kept * robots)]);
    this.from += count;
    this.count = this.kept = 0;
    this.there = [];
    return { ...Object.fromEntries(own), from, count, every, robots, numbers, there, done, problem };
  }
}

/**
 * Whether the same tasks are there, and are taken.
 * @param {There} one
 * @param {There} other
 */
function isSame(one, other) {
  return /** @type {const} */ (["taskX", "taskY", "taskNumbers", "taken", "kinds"]).every((name) => {
    const [a, b] = [one[name] ?? [], other[name] ?? []];
    return (
      a.length === b.length && a.every((/** @type {number} */ each, /** @type {number} */ k) => each === b[k])
    );
  });
}

/** @type {Record<string, (work: any) => Promise<void>>} */
const answers = {
  async open({ key, module, opened }) {
    for (const each of scenarios.keys()) if (each <= key - KEPT) scenarios.delete(each); // its work is over
    scenarios.set(key, { module, opened });
  },

  /** @param {Work & {lasts: number}} work A whole run, or its first steps. */
  async run(work) {
    const world = await channelOf(work).world,
      { steps, stops } = world.opened.run;
    if (!isNewest(work)) return;
    if (!world.begin(work.settings)) return send(work, { problem: world.problem });
    const { changes, acts } = world.opened.lengths,
      last = Math.min(steps, work.lasts),
      unsent = new Unsent(world, last, changes || Boolean(acts) || work.settings.events.length > 0);
    for (let step = 0, done = last === 0; ;) {
      const until = performance.now() + SLICE;
      while (!done && !unsent.isFull && performance.now() < until) {
        step = world.play("feasibee_to", step + 1);
        if (step >= 0) unsent.add();
        done = step < 0 || step >= last || (stops && world.decision() >= 0);
      }
      send(work, { steps: unsent.take(done) });
      if (done) return;
      await pause();
      if (!isNewest(work)) return;
    }
  },

  /** @param {Work & {from: number, to: number}} work Runs until they decide, with their curves. */
  async many(work) {
    const world = await channelOf(work).world,
      { settings } = work,
      { steps } = world.opened.run,
      chunk = chunkOf(settings);
    let outcomes = [],
      until = performance.now() + SLICE;
    for (let run = work.from; run < work.to && isNewest(work); run++) {
      if (!world.begin({ ...settings, run }, { stops: true, curves: true })) return;
      for (let step = 0, going = true; going && isNewest(work);) {
        step = world.play("feasibee_play_on", chunk);
        const decision = world.decision();
        going = step >= 0 && decision < 0 && step < steps;
        if (step < 0) return; // the run that is shown says why
        if (!going)
          outcomes.push({
            decision,
            step,
            isRight: decision === Number(world.exports.feasibee_missing() === 0),
            course: world.course(),
          });
        if (performance.now() < until) continue;
        send(work, { outcomes });
        outcomes = [];
        await pause();
        until = performance.now() + SLICE;
      }
    }
    if (isNewest(work)) send(work, { outcomes });
  },

  /** @param {Work & {robot: number, step: number}} work What a robot knows at a step: on from the last such step, or anew. */
  async inspect(work) {
    const own = channelOf(work),
      world = await own.world,
      run = JSON.stringify(work.settings);
    if (!isNewest(work)) return;
    if (own.run !== run || own.step > work.step || own.step < 0) {
      if (!world.begin(work.settings)) return;
      Object.assign(own, { run, step: 0 });
    }
    while (own.step < work.step) {
      own.step = world.play("feasibee_to", Math.min(work.step, own.step + chunkOf(work.settings)));
      if (own.step < 0) return;
      await pause();
      if (!isNewest(work)) return;
    }
    send(work, { robot: work.robot, step: work.step, state: world.robot(work.robot) });
  },
};

/**
 * @param {Work} work
 * @param {object} found
 */
function send({ channel, gen }, found) {
  postMessage({ channel, gen, ...found });
}

addEventListener("message", ({ data }) => answers[data.type](data));
