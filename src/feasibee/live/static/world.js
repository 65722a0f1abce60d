// A swarm in the engine's module: packets and numbers in, robots out. Each run equals that of `feasibee run`. This runs
// in a worker, too: without a document.

/** @typedef {{memory: WebAssembly.Memory} & Record<string, (...given: number[]) => number>} Exports Of pages.c. */

const ARRAYS = "x y flags aims taskX taskY taskNumbers taken stepX stepY kinds".split(" ");
const NUMBERS = 9; // of a step: how many robots may be there, and the first of history.js
const ROBOT_NUMBERS = `flags left said kind quality votes feasibleVotes messages inboxSize
  aim aimIsThere aimHolder aimAway marked tasksKnown tasksFree
  robotColumns columns memoryKept atStart knowsCount declaresByVotes seesOnce randomIds actsFrom
  actsByWord tasksStay`.split(/\s+/);
const ACCOUNT_LENGTH = 15; // columns of struct account in state.h
const SHOWN = [0, 1, 9]; // columns with bits, declaration and allTaken: the last numbers of a step, of 32 bits
const LAST_STEP = 6;
const TWO_WORDS = 2n ** 32n;
const LIMIT = 2n ** 63n + 1n; // no squared distance is as large
/** @type {Map<string, Promise<WebAssembly.Module>>} */
const modules = new Map(); // by their bytes, so that each is compiled once

/**
 * Compile the engine.
 * @param {string} wasm
 */
export function compiled(wasm) {
  const found = modules.get(wasm) ?? inflated(wasm).then((bytes) => WebAssembly.compile(bytes));
  modules.set(wasm, found);
  return found;
}

/**
 * Return a world of a scenario, which simulates one run at a time.
 * @param {Opened} opened
 * @param {WebAssembly.Module} module
 */
export async function worldOf(opened, module) {
  const bytes = await inflated(opened.packets.bytes),
    { exports } = await WebAssembly.instantiate(module);
  return new World(opened, /** @type {any} */ (exports), bytes);
}

/**
 * Return what says whether robots get to a point of a scenario's place.
 * @param {Opened} opened
 * @returns {Promise<(at: [number, number]) => boolean>}
 */
export async function reachOf({ reached, unit }) {
  if (!reached) return () => true;
  const cells = await inflated(reached.cells);
  return (at) => {
    const [column, row] = at.map((each) => Number(fixedOf(each, unit) >> BigInt(reached.bits))),
      cell = row * reached.columns + column;
    return Boolean((cells[cell >> 3] >> (cell & 7)) & 1);
  };
}

/** @param {string} base64 */
async function inflated(base64) {
  const bytes = Uint8Array.from(atob(base64), (each) => each.charCodeAt(0)),
    stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/**
 * Return events as the engine takes them, by step; a probability is times 2**32, rounded up.
 * @param {WorldEvent[]} events
 * @param {Opened["unit"]} unit
 */
function rowsOf(events, unit) {
  const ordered = [...events].sort((one, other) => one.step - other.step);
  return ordered.flatMap(({ step, tasks = 0, robots = 0, sensing, radio, task = -1, robot = -1, at }) => {
    const chances = [sensing?.miss, radio?.loss].map((each) => {
        const [share, whole] = fractionOf(each ?? 0, ["1", "1"]);
        return each == null ? -1n : (share * TWO_WORDS + whole - 1n) / whole;
      }),
      [x, y] = at ? at.map((each) => fixedOf(each, unit)) : [-1, -1];
    return [step, tasks, robots, ...chances, task, robot, x, y].map(BigInt);
  });
}

/**
 * Return a length in units of fixed point, as a fraction of its decimals.
 * @param {number} length
 * @param {Opened["unit"]} unit
 */
function fractionOf(length, [part, whole]) {
  const [, digits = "0", decimals = "", shift = "0"] =
      /^(\d+)\.?(\d*)(?:e([+-]\d+))?$/.exec(String(length)) ?? [],
    places = decimals.length - Number(shift);
  return [
    BigInt(digits + decimals) * BigInt(whole) * 10n ** BigInt(Math.max(0, -places)),
    BigInt(part) * 10n ** BigInt(Math.max(0, places)),
  ];
}

/**
 * Return a length in fixed point, rounded down from its decimals.
 * @param {number} length
 * @param {Opened["unit"]} unit
 */
function fixedOf(length, unit) {
  const [numerator, denominator] = fractionOf(length, unit);
  return numerator / denominator;
}

export class World {
  /**
   * @param {Opened} opened
   * @param {Exports} exports
   * @param {Uint8Array} packets
   */
  constructor(opened, exports, packets) {
    this.opened = opened;
    this.exports = exports;
    this.problem = "";
    this.robots = 0; // numbers that they may have
    /** @type {Record<string, any>} */
    this.views = {}; // of the engine's memory, by name
    this.packets = exports.feasibee_room(packets.length);
    new Uint8Array(exports.memory.buffer, this.packets).set(packets);
  }

  /**
   * Begin a run; return whether there is memory for it, else say why not in `problem`.
   *
   * One that stops ends with its decision, and one with curves keeps its course; nothing else of them is shown.
   * @param {Settings} settings
   * @param {{stops?: boolean, curves?: boolean}} [kind]
   */
  begin(settings, { stops = false, curves = false } = {}) {
    const { opened, exports, packets } = this,
      { robots, tasks, strategy, seed, run, events } = settings,
      { starts } = opened.packets,
      rows = rowsOf(events, opened.unit),
      words = BigInt(seed);
    exports.feasibee_open(packets, packets + starts[1 + strategy]);
    if (opened.patches) this.patch(settings);
    const place = exports.feasibee_events(events.length);
    new BigInt64Array(exports.memory.buffer, place, rows.length).set(rows);
    const [low, high] = [words % TWO_WORDS, words / TWO_WORDS].map(Number),
      kinds = [stops, curves].map(Number);
    this.problem = "This page has no memory for so many robots and tasks.";
    if (!this.tried(() => exports.feasibee_begin(robots, tasks, low, high, run, ...kinds))) return false;
    this.problem = "";
    return true;
  }

  /** @param {Settings} settings Ranges and speed of the next run, computed as by lowering.py. */
  patch({ sight, radio, speed }) {
    const { exports, opened } = this,
      limits = [sight, radio].map((range) => {
        const [numerator, denominator] = fractionOf(range, opened.unit),
          limit = numerator ** 2n / denominator ** 2n + 1n; // no squared distance within the range is as large
        return limit < LIMIT ? limit : LIMIT;
      }),
      [numerator, denominator] = fractionOf(speed, opened.unit),
      scaled = numerator * 2n ** 128n,
      sticky = BigInt(scaled % denominator > 0n), // what is cut off breaks ties
      reach = Number((scaled / denominator) | sticky) / 2 ** 128; // the number nearest to the fraction
    exports.feasibee_patch(.../** @type {any[]} */ (limits), reach, sight, radio, speed);
  }

  /**
   * Return what work of the engine returns; 0 if a user's strategy fails, and say why in `problem`.
   * @param {() => number} work
   */
  tried(work) {
    try {
      return work();
    } catch {
      const { exports, opened } = this,
        at = exports.feasibee_failed(),
        [what, line] = new Int32Array(exports.memory.buffer, at, 2),
        values = new Float64Array(exports.memory.buffer, at + 8, 2);
      const why = opened.failures?.[what]?.replace(/\{(\d)\}/g, (_, k) => String(values[Number(k)]));
      this.problem = `Line ${line} of the strategy fails here${why ? `: ${why}` : ""}.`;
      return 0;
    }
  }

  /**
   * Simulate a run, up to a step or for so many; return the step, or -1 and say why in `problem`.
   * @param {"feasibee_to" | "feasibee_play_on"} how
   * @param {number} steps
   */
  play(how, steps) {
    this.problem = "This page has no memory for what robots hear.";
    const step = this.tried(() => this.exports[how](steps) + 1) - 1;
    if (step >= 0) this.problem = "";
    return step;
  }

  // The first decision so far: 1, 0, or -1.
  decision() {
    return this.exports.feasibee_decision();
  }

  // What a record keeps of the run.
  account() {
    const { exports } = this;
    return new BigInt64Array(exports.memory.buffer, exports.feasibee_account(), ACCOUNT_LENGTH);
  }

  // How many robots were for feasible at each step of a run with curves, so far.
  course() {
    const { exports } = this,
      steps = Number(this.account()[LAST_STEP]) + 1;
    return Uint16Array.from(new Int32Array(exports.memory.buffer, exports.feasibee_course(), steps));
  }

  /**
   * Return what a robot knows at this step.
   * @param {number} robot
   * @returns {Robot}
   */
  robot(robot) {
    const { exports } = this,
      at = this.tried(() => exports.feasibee_robot(robot));
    if (!at) return /** @type {any} */ ({ problem: this.problem });
    const { buffer } = exports.memory,
      numbers = new Float64Array(buffer, at, ROBOT_NUMBERS.length),
      now = Object.fromEntries(ROBOT_NUMBERS.map((name, k) => [name, numbers[k]])),
      { columns, memoryKept, messages, inboxSize } = now,
      inboxAt = columns + memoryKept,
      more = [...new Float64Array(buffer, at + numbers.byteLength, inboxAt + 3 * messages)],
      inbox = Array.from({ length: messages }, (_, k) => more.slice(inboxAt + 3 * k, inboxAt + 3 * k + 3)),
      newest = inbox.sort(([, , one], [, , other]) => one - other).slice(-inboxSize || undefined);
    return /** @type {any} */ ({
      ...now,
      counts: more.slice(0, columns),
      memory: more.slice(columns, inboxAt),
      heard: newest.map(([sender, opinion]) => [sender, opinion]).sort(([one], [other]) => one - other),
    });
  }

  /**
   * Let the engine write the present step, and copy its numbers, as history.js lists them.
   * @param {Int32Array} numbers
   * @param {number} place From which on they stand there.
   */
  copyNumbers(numbers, place) {
    const { exports } = this,
      at = exports.feasibee_show(),
      found = new Int32Array(exports.memory.buffer, at, NUMBERS),
      account = new Int32Array(exports.memory.buffer, exports.feasibee_account(), 2 * ACCOUNT_LENGTH);
    this.robots = found[0];
    for (let k = 1; k < NUMBERS; k++) numbers[place + k - 1] = found[k];
    for (const [k, column] of SHOWN.entries()) numbers[place + NUMBERS - 1 + k] = account[2 * column];
  }

  /**
   * Return an array of the step that the engine has written: a view of its memory, made anew only if it has moved.
   * @param {string} name
   * @param {number} length
   * @param {any} [Kind]
   */
  array(name, length, Kind = Uint16Array) {
    const { exports, views } = this,
      { buffer } = exports.memory,
      at = exports.feasibee_array(ARRAYS.indexOf(name)),
      view = views[name];
    if (view?.buffer === buffer && view.byteOffset === at && view.length === length) return view;
    return (views[name] = new Kind(buffer, at, length));
  }

  /**
   * Copy the robots of that step.
   * @param {Columns} columns
   * @param {number} place From which on they stand there.
   */
  copy(columns, place) {
    const { robots } = this,
      [along, up] = ["stepX", "stepY"].map((name) => this.array(name, robots, Int32Array));
    for (const name of /** @type {const} */ (["x", "y", "flags", "aims"]))
      columns[name]?.set(this.array(name, robots), place);
    for (let i = 0; i < robots; i++)
      columns.heading[place + i] = Math.round((Math.atan2(up[i], along[i]) * 128) / Math.PI);
  }

  /**
   * Return the tasks and the classes of robots of that step.
   * @param {number} step Its number.
   * @param {number} tasks
   * @returns {There}
   */
  there(step, tasks) {
    const taken = this.opened.lengths.acts ? { taken: this.array("taken", tasks).slice() } : {},
      [taskX, taskY, taskNumbers] = ["taskX", "taskY", "taskNumbers"].map((name) =>
        this.array(name, tasks).slice(),
      );
    return {
      step,
      taskX,
      taskY,
      taskNumbers,
      ...taken,
      kinds: [...this.array("kinds", this.robots, Int32Array)],
    };
  }
}
