// Play runs in the compiled world of feasibee.live.page: for tests, by node.
//
//   node play.mjs world.wasm < runs.json > flags
//
// Each run gives the flags of its robots at step 0 and after each step, and at the end its positions.

import { readFileSync, writeSync } from "node:fs";

const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]));
const world = instance.exports,
  { memory } = world;

function copy(at, length) {
  return new Uint8Array(memory.buffer, at, length).slice();
}

function write(bytes) {
  for (let at = 0; at < bytes.length;) at += writeSync(1, bytes, at);
}

for (const { numbers, seed, run, steps } of JSON.parse(readFileSync(0, "utf8"))) {
  const [robots] = numbers,
    words = BigInt(seed);
  new Float64Array(memory.buffer, world.world_numbers(), numbers.length).set(numbers);
  world.world_begin(Number(words & 0xffffffffn), Number(words >> 32n), run);
  const flags = [copy(world.world_flags(), 2 * robots)];
  for (let step = 0; step < steps; step++) {
    world.world_step();
    flags.push(copy(world.world_flags(), 2 * robots));
  }
  flags.push(copy(world.world_x(), 4 * robots), copy(world.world_y(), 4 * robots));
  write(Buffer.concat(flags));
}
