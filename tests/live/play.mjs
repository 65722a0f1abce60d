// Play runs in the compiled world of feasibee.live.page: for tests, by node.
//
//   node play.mjs world.wasm < runs.json > flags
//
// Each run gives the flags of its robots at step 0 and after each step, and at the end its positions, and how many robots
// are missing.

import { readFileSync, writeSync } from "node:fs";
import { givePlace, rowsOf } from "../../src/feasibee/live/static/world.js";

const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]));
const world = instance.exports,
  { memory } = world;

function copy(at, length) {
  return new Uint8Array(memory.buffer, at, length).slice();
}

function write(bytes) {
  for (let at = 0; at < bytes.length;) at += writeSync(1, bytes, at);
}

for (const { named, events, unit, place, seed, run, steps } of JSON.parse(readFileSync(0, "utf8"))) {
  const words = BigInt(seed),
    numbers = Object.values(named),
    rows = rowsOf(events, named, unit, Boolean(place));
  new Float64Array(memory.buffer, world.world_numbers(), numbers.length).set(numbers);
  new Int32Array(memory.buffer, world.world_events(), rows.length).set(rows);
  new Float64Array(memory.buffer, world.world_place(), 1)[0] = 0; // without a place
  if (place) await givePlace(world, place);
  world.world_begin(Number(words & 0xffffffffn), Number(words >> 32n), run);
  const robots = world.world_robots(),
    flags = [copy(world.world_flags(), 2 * robots)];
  for (let step = 0; step < steps; step++) {
    world.world_step();
    flags.push(copy(world.world_flags(), 2 * robots));
  }
  flags.push(copy(world.world_x(), 4 * robots), copy(world.world_y(), 4 * robots));
  flags.push(new Uint8Array(Uint32Array.of(world.world_missing()).buffer));
  write(Buffer.concat(flags));
}
