// Play runs in the module that pages load: node wasm.mjs, with what a page is given and its settings in standard input.
//
// Each run gives, for each step, its numbers and arrays as the page reads them; one that stops its decision, step, missing
// robots, account and curve; one with steps to tell of, the words for all its robots. They are written to standard output.
import { readFileSync, writeSync } from "node:fs";
import { COLUMNS, NUMBERS } from "../../src/feasibee/live/static/history.js";
import { reasonsOf, sentenceOf } from "../../src/feasibee/live/static/reasons.js";
import { compiled, worldOf } from "../../src/feasibee/live/static/world.js";

const { given, runs, numbers } = JSON.parse(readFileSync(0, "utf8"));
const world = await worldOf(given, await compiled(given.wasm));

function write(array) {
  const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
  for (let at = 0; at < bytes.length;) at += writeSync(1, bytes, at);
}

// Return the words for each robot at the present step.
function told(step, strategy, moment) {
  world.copyNumbers([], 0);
  const { robots } = world,
    at = { step, next: null, since: { held: 0, begun: 0 }, ...moment };
  return Array.from({ length: robots }, (_, k) => {
    const robot = world.robot(k);
    return {
      reasons: reasonsOf(robot, given, strategy, at),
      sentence: sentenceOf(robot, given, strategy, at),
    };
  });
}

for (const { settings, steps, stops, chunk, tellAt, moment } of runs) {
  if (!world.begin(settings, { stops, curves: stops })) throw new Error(world.problem);
  if (stops) {
    let step = 0;
    while (step >= 0 && world.decision() < 0 && step < steps) step = world.play("feasibee_play_on", chunk);
    if (step < 0) throw new Error(world.problem);
    const course = new Int32Array(given.run.steps + 1).fill(-1);
    course.set(world.course());
    write(Int32Array.of(world.decision(), step, world.exports.feasibee_missing(), 0));
    write(world.account().slice());
    write(course);
    continue;
  }
  if (tellAt) {
    const found = tellAt.map((step) => {
      if (world.play("feasibee_to", step) !== step) throw new Error(world.problem);
      return told(step, settings.strategy, moment);
    });
    write(new TextEncoder().encode(JSON.stringify(found)));
    continue;
  }
  for (let step = 0; step <= steps; step++) {
    if (world.play("feasibee_to", step) !== step) throw new Error(world.problem);
    const shown = [];
    world.copyNumbers(shown, 0);
    const { robots } = world,
      now = { robots, ...Object.fromEntries(NUMBERS.map((name, k) => [name, shown[k]])) },
      columns = Object.entries(COLUMNS).map(([name, Kind]) => [name, new Kind(robots)]),
      { x, y, flags, heading, aims } = Object.fromEntries(columns),
      { acts } = given.lengths;
    world.copy({ x, y, flags, heading, ...(acts && { aims }) }, 0);
    const { taskX, taskY, taskNumbers, taken = [], kinds } = world.there(step, now.tasks);
    write(Int32Array.from([...numbers.map((name) => now[name]), acts ? 1 : 0]));
    for (const each of [x, y, flags, taskX, taskY, taskNumbers, acts ? aims : [], taken])
      write(Uint16Array.from(each));
    write(heading);
    write(Int32Array.from(kinds));
  }
}
