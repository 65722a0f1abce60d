// Play runs in the module that pages load: node wasm.mjs, with a page's Given and its settings in standard input.
//
// Each run gives, for each step, its numbers and arrays as the page reads them; one that stops its decision, step, missing
// robots and account. They are written to standard output.
import { readFileSync, writeSync } from "node:fs";
import { worldsOf } from "../../src/feasibee/live/static/world.js";

const { given, runs, columns } = JSON.parse(readFileSync(0, "utf8"));
const [world] = await worldsOf(given, 1);
const { memory, feasibee_to, feasibee_play_on, feasibee_decision, feasibee_missing, feasibee_account } =
  world.exports;

function write(array) {
  const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
  for (let at = 0; at < bytes.length;) at += writeSync(1, bytes, at);
}

for (const { settings, steps, stops, chunk } of runs) {
  if (!world.begin(settings, stops)) throw new Error("no memory");
  if (stops) {
    let step = 0;
    while (feasibee_decision() < 0 && step < steps) step = feasibee_play_on(chunk);
    write(Int32Array.of(feasibee_decision(), step, feasibee_missing(), 0));
    write(new BigInt64Array(memory.buffer, feasibee_account(), columns).slice());
    continue;
  }
  for (let step = 0; step <= steps; step++) {
    if (feasibee_to(step) !== step) throw new Error("no memory");
    const { x, y, flags, aims, taken, taskX, taskY, taskNumbers, kinds, heading, ...now } = world.shown();
    write(Int32Array.from([...Object.values(now), aims ? 1 : 0]));
    for (const each of [x, y, flags, taskX, taskY, taskNumbers, aims ?? [], taken ?? []])
      write(Uint16Array.from(each));
    write(Uint8Array.from(heading));
    write(Int32Array.from(kinds));
  }
}
