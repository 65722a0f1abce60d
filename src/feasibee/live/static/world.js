// The world of world.c: numbers in, robots out. Each run equals that of `feasibee run`.

/**
 * What the file holds, from page.py.
 * @typedef {object} Given
 * @property {string} name Of the scenario's file.
 * @property {string} version Of feasibee.
 * @property {string} toml
 * @property {string} wasm In base64.
 * @property {CompressedPlace | null} place
 * @property {{name: string, rule: string, declares: boolean, fixed: string, numbers: Record<string, number>}[]} strategies
 *   fixed: why events can't change its world; numbers: in the order of world.c.
 * @property {number} threshold
 * @property {[string, string]} unit Numerator and denominator, of fixed point.
 * @property {{robots: number, tasks: number}} most
 * @property {Settings} settings
 * @property {import("./arena.js").World & {units: number}} lengths
 * @property {import("./curve.js").Prediction} prediction
 * @property {{steps: number, stops: boolean}} run
 */

/**
 * A place from lowering.py: numbers as in place.h, of which the first two are columns and rows; in base64 and compressed
 * a bit of each cell for each kind of cells, then a byte for the piece of each.
 * @typedef {{numbers: number[], cells: string}} CompressedPlace
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

/**
 * What world.c exports; world_decision: 1 feasible, 0 infeasible, -1 neither; world_play: simulate until the swarm has
 * decided, but at most so many steps, and return how many.
 * @typedef {{memory: WebAssembly.Memory} & Record<string, (...given: number[]) => number>} Exports
 */

/**
 * Compile the world, and give as many as are needed; each simulates one run at a time.
 * @param {Given} given
 * @param {number} count
 */
export async function worldsOf(given, count) {
  const code = await WebAssembly.compile(bytesOf(given.wasm));
  return Promise.all(
    Array.from({ length: count }, async () => {
      const world = new World(given, await WebAssembly.instantiate(code));
      if (given.place) await givePlace(world.exports, given.place);
      return world;
    }),
  );
}

/** @param {string} base64 */
function bytesOf(base64) {
  return Uint8Array.from(atob(base64), (each) => each.charCodeAt(0));
}

/**
 * Give a world its place.
 * @param {Exports} exports
 * @param {CompressedPlace} place
 */
export async function givePlace({ memory, world_place, world_cells }, { numbers, cells }) {
  const stream = new Blob([bytesOf(cells)]).stream().pipeThrough(new DecompressionStream("deflate")),
    bytes = new Uint8Array(await new Response(stream).arrayBuffer()),
    count = numbers[0] * numbers[1],
    plane = Math.ceil(count / 8),
    kinds = (bytes.length - count) / plane,
    kept = new Uint8Array(memory.buffer, world_cells(), 2 * count);
  new Float64Array(memory.buffer, world_place()).set(numbers);
  kept.fill(0);
  for (let kind = 0; kind < kinds; kind++)
    for (let k = 0; k < count; k++) kept[k] |= ((bytes[kind * plane + (k >> 3)] >> (k & 7)) & 1) << kind;
  kept.set(bytes.subarray(kinds * plane), count);
}

/**
 * Return events as world.c takes them, by step; points in fixed point as _place_at in simulation/lowering.py has them.
 * @param {import("./touching.js").Event[]} events
 * @param {Record<string, number>} numbers
 * @param {Given["unit"]} unit
 * @param {boolean} isPlace
 */
export function rowsOf(events, { radius, span_x, span_y }, unit, isPlace) {
  const ordered = [...events].sort((one, other) => one.step - other.step);
  return ordered.flatMap(({ step, tasks = 0, robots = 0, task = -1, robot = -1, at }) => {
    const margin = tasks > 0 || task >= 0 ? 0 : radius,
      [x, y] = at ?? [0, 0],
      held = (/** @type {number} */ place, /** @type {number} */ side) =>
        Math.min(Math.max(fixedOf(place, unit), margin), side - Math.max(margin, Number(isPlace)));
    return [step, tasks, robots, task, robot, Number(Boolean(at)), held(x, span_x), held(y, span_y)];
  });
}

/**
 * Return a coordinate in fixed point, rounded down from its decimals.
 * @param {number} place
 * @param {Given["unit"]} unit
 */
export function fixedOf(place, [part, whole]) {
  const [, digits, decimals = "", shift = "0"] = /^(\d+)\.?(\d*)(?:e(-\d+))?$/.exec(String(place)) ?? [
    "",
    "0",
  ];
  return Number(
    (BigInt(digits + decimals) * BigInt(whole)) /
      (BigInt(part) * 10n ** BigInt(decimals.length - Number(shift))),
  );
}

export class World {
  /**
   * @param {Given} given
   * @param {WebAssembly.Instance} instance
   */
  constructor(given, instance) {
    this.given = given;
    this.exports = /** @type {Exports} */ (/** @type {unknown} */ (instance.exports));
  }

  /** @param {Settings} settings */
  begin({ robots, tasks, strategy, seed, run, events }) {
    const { given, exports } = this,
      rows = rowsOf(events, given.strategies[strategy].numbers, given.unit, Boolean(given.place)),
      changed = { robots, tasks, events: events.length },
      numbers = Object.values({ ...given.strategies[strategy].numbers, ...changed });
    new Float64Array(exports.memory.buffer, exports.world_numbers(), numbers.length).set(numbers);
    new Int32Array(exports.memory.buffer, exports.world_events(), rows.length).set(rows);
    const words = BigInt(seed);
    exports.world_begin(Number(words & 0xffffffffn), Number(words >> 32n), run);
  }

  /**
   * Return whether robots get to a point.
   * @param {[number, number]} at
   */
  stands([x, y]) {
    return Boolean(this.exports.world_stands(fixedOf(x, this.given.unit), fixedOf(y, this.given.unit)));
  }

  // How many numbers robots may have.
  get robots() {
    return this.exports.world_robots();
  }

  /**
   * Return a coordinate of all robots or tasks in 65,536ths of the longer side.
   * @param {"world_x" | "world_y" | "world_task_x" | "world_task_y"} name
   */
  places(name) {
    const { memory } = this.exports,
      count = name.includes("task") ? this.exports.world_tasks() : this.robots,
      part = 65536 / this.given.lengths.units;
    return Uint16Array.from(new Uint32Array(memory.buffer, this.exports[name](), count), (each) =>
      Math.min(65535, each * part),
    );
  }

  get taskNumbers() {
    const { world_tasks, world_task_number } = this.exports;
    return Uint16Array.from({ length: world_tasks() }, (_, k) => world_task_number(k));
  }

  get flags() {
    return new Uint16Array(this.exports.memory.buffer, this.exports.world_flags(), this.robots);
  }

  get headings() {
    return new Uint8Array(this.exports.memory.buffer, this.exports.world_headings(), this.robots);
  }
}
