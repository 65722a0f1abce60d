// A swarm in the engine's module: packets and numbers in, robots out. Each run equals that of `feasibee run`.

/**
 * What the file holds, from page.py.
 * @typedef {object} Given
 * @property {string} name Of the scenario's file.
 * @property {string} version Of feasibee.
 * @property {string} toml
 * @property {string} wasm Compressed, as all bytes here.
 * @property {{bytes: string, starts: number[]}} packets That of all strategies, then those of each; see pages.c.
 * @property {{columns: number, bits: number, cells: string} | null} reached A bit for each cell that robots reach.
 * @property {{name: string, rule: string, declares: boolean, fixed: string, knows: boolean}[]} strategies
 *   fixed: why events can't change its world.
 * @property {string} counted Why the numbers at the start can't be changed; empty if they can.
 * @property {Record<string, boolean>} legend Which entries it needs, of those that not all need.
 * @property {number} threshold
 * @property {[string, string]} unit Numerator and denominator, of fixed point.
 * @property {{robots: number, tasks: number}} most
 * @property {Settings} settings
 * @property {import("./arena.js").World} lengths
 * @property {import("./curve.js").Prediction} prediction
 * @property {{steps: number, stops: boolean}} run
 */

/**
 * What a reader may change.
 * @typedef {object} Settings
 * @property {number} robots
 * @property {number} tasks
 * @property {number} strategy
 * @property {string} seed
 * @property {number} run
 * @property {import("./touching.js").Event[]} events
 */

/** @typedef {{memory: WebAssembly.Memory} & Record<string, (...given: number[]) => number>} Exports Of pages.c. */

/**
 * A step as the arena draws it; kinds: classes of robots; needed: robots that must hold an opinion for the swarm to have
 * decided; missing: robots without which the tasks aren't feasible.
 * @typedef {import("./frames.js").Frame & {kinds: number[], needed: number, missing: number}} Shown
 */

const SHOWN_ARRAYS = "x y flags aims taskX taskY taskNumbers taken stepX stepY kinds".split(" ");
const SHOWN_NUMBERS = "robots there tasks counted feasible infeasible needed decision missing".split(" ");
const TWO_WORDS = 2n ** 32n;
/** @type {Map<string, Promise<WebAssembly.Module>>} */
const modules = new Map(); // by their bytes, so that each is compiled once

/**
 * Load the engine, and give as many worlds as are needed; each simulates one run at a time.
 * @param {Given} given
 * @param {number} count
 */
export async function worldsOf(given, count) {
  const { wasm, packets, reached } = given,
    compiled = modules.get(wasm) ?? inflated(wasm).then((bytes) => WebAssembly.compile(bytes));
  modules.set(wasm, compiled);
  const bytes = await inflated(packets.bytes),
    cells = reached ? await inflated(reached.cells) : new Uint8Array();
  return Promise.all(
    Array.from({ length: count }, async () => {
      const { exports } = await WebAssembly.instantiate(await compiled);
      return new World(given, /** @type {any} */ (exports), bytes, cells);
    }),
  );
}

/** @param {string} base64 */
async function inflated(base64) {
  const bytes = Uint8Array.from(atob(base64), (each) => each.charCodeAt(0)),
    stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/**
 * Return events as the engine takes them, by step.
 * @param {import("./touching.js").Event[]} events
 * @param {Given["unit"]} unit
 */
export function rowsOf(events, unit) {
  const ordered = [...events].sort((one, other) => one.step - other.step);
  return ordered.flatMap(({ step, tasks = 0, robots = 0, sensing, radio, task = -1, robot = -1, at }) => {
    const chances = [sensing?.miss, radio?.loss].map((each) => (each == null ? -1n : chanceOf(each))),
      [x, y] = at ? at.map((each) => fixedOf(each, unit)) : [-1, -1];
    return [step, tasks, robots, ...chances, task, robot, x, y].map(BigInt);
  });
}

/**
 * Return a probability times 2**32, rounded up.
 * @param {number} share
 */
function chanceOf(share) {
  const whole = 10n ** 30n; // more decimals than a number has here
  return (fixedOf(share, ["1", String(whole)]) * TWO_WORDS + whole - 1n) / whole;
}

/**
 * Return a coordinate in fixed point, rounded down from its decimals.
 * @param {number} place
 * @param {Given["unit"]} unit
 */
function fixedOf(place, [part, whole]) {
  const [, digits, decimals = "", shift = "0"] = /^(\d+)\.?(\d*)(?:e(-\d+))?$/.exec(String(place)) ?? [
    "",
    "0",
  ];
  return (
    (BigInt(digits + decimals) * BigInt(whole)) /
    (BigInt(part) * 10n ** BigInt(decimals.length - Number(shift)))
  );
}

export class World {
  /**
   * @param {Given} given
   * @param {Exports} exports
   * @param {Uint8Array} packets
   * @param {Uint8Array} reached
   */
  constructor(given, exports, packets, reached) {
    this.given = given;
    this.exports = exports;
    this.reached = reached;
    this.problem = "";
    this.packets = exports.feasibee_room(packets.length);
    new Uint8Array(exports.memory.buffer, this.packets).set(packets);
  }

  /**
   * Begin a run; it may end with its decision. Return whether there is memory for it.
   * @param {Settings} settings
   * @param {boolean} stops
   */
  begin({ robots, tasks, strategy, seed, run, events }, stops = false) {
    const { given, exports, packets } = this,
      { starts } = given.packets,
      rows = rowsOf(events, given.unit),
      words = BigInt(seed);
    exports.feasibee_open(packets, packets + starts[1 + strategy]);
    const place = exports.feasibee_events(events.length);
    new BigInt64Array(exports.memory.buffer, place, rows.length).set(rows);
    return Boolean(
      exports.feasibee_begin(
        robots,
        tasks,
        Number(words % TWO_WORDS),
        Number(words / TWO_WORDS),
        run,
        Number(stops),
      ),
    );
  }

  /**
   * Simulate a run, up to a step or for so many; return the step, or -1 and say why in `problem`.
   * @param {"feasibee_to" | "feasibee_play_on"} how
   * @param {number} steps
   */
  play(how, steps) {
    let step = -1;
    this.problem = "This page has no memory for what robots hear.";
    try {
      step = this.exports[how](steps);
    } catch {
      this.problem = `Line ${this.exports.feasibee_failed()} of the strategy fails here.`;
    }
    if (step >= 0) this.problem = "";
    return step;
  }

  /**
   * Return whether robots get to a point.
   * @param {[number, number]} at
   */
  stands(at) {
    const { reached, unit } = this.given;
    if (!reached) return true;
    const [column, row] = at.map((each) => Number(fixedOf(each, unit) >> BigInt(reached.bits))),
      cell = row * reached.columns + column;
    return Boolean((this.reached[cell >> 3] >> (cell & 7)) & 1);
  }

  /**
   * Return the present step.
   * @returns {Shown}
   */
  shown() {
    const { exports, given } = this,
      { buffer } = exports.memory,
      found = new Int32Array(buffer, exports.feasibee_show(), SHOWN_NUMBERS.length),
      now = Object.fromEntries(SHOWN_NUMBERS.map((name, k) => [name, found[k]]));
    /** @type {(name: string) => any} */
    const read = (name) => {
      const kind = name.startsWith("step") || name === "kinds" ? Int32Array : Uint16Array;
      return new kind(
        buffer,
        exports.feasibee_array(SHOWN_ARRAYS.indexOf(name)),
        /^ta(sk|ken)/.test(name) ? now.tasks : now.robots,
      );
    };
    const [stepX, stepY] = [read("stepX"), read("stepY")],
      names = given.lengths.acts
        ? SHOWN_ARRAYS.slice(0, 8)
        : ["x", "y", "flags", "taskX", "taskY", "taskNumbers"];
    return /** @type {any} */ ({
      ...now,
      ...Object.fromEntries(names.map((name) => [name, read(name).slice()])),
      kinds: [...read("kinds")],
      heading: Uint8Array.from(stepX, (x, i) => Math.round((Math.atan2(stepY[i], x) * 128) / Math.PI)),
    });
  }
}
