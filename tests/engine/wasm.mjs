// Play runs with the engine in WebAssembly: node wasm.mjs feasibee.wasm, with a job in standard input.
//
// A job is a line of JSON and then the bytes of its parts: params, setting, plan and parameters, and the arrays of
// a record in the order of struct outcome. These arrays are written to standard output, filled in.
import { readFileSync, writeSync } from "node:fs";

const input = readFileSync(0);
const end = input.indexOf(10);
const job = JSON.parse(input.subarray(0, end).toString());
const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]));
const { memory, feasibee_room, feasibee_play_flat } = instance.exports;

let at = end + 1;
const put = (bytes) => {
  const place = feasibee_room(Math.max(bytes.length, 1));
  if (place === 0) throw new Error("no memory");
  new Uint8Array(memory.buffer, place, bytes.length).set(bytes);
  return place;
};
const take = (size) => put(input.subarray(at, (at += size)));

const name = put(Buffer.from(`${job.strategy}\0`));
const [params, setting, plan, parameters] = job.given.map(take);
const view = new DataView(memory.buffer);
view.setUint32(setting + job.offset_of_plan, plan, true);
view.setUint32(setting + job.offset_of_parameters, parameters, true);
const arrays = job.arrays.map(take);
const sizes = [job.runs, job.curve_length, job.columns];
const begin = process.cpuUsage();
const run = [job.memory, BigInt(job.first_run), ...sizes, ...arrays];
const complete = feasibee_play_flat(params, name, setting, ...run);
if (complete !== BigInt(job.runs)) throw new Error(`${complete} of ${job.runs} runs are complete`);
if (process.argv[3] === "--time") console.error(process.cpuUsage(begin).user, "microseconds of CPU");
for (const [k, place] of arrays.entries())
  for (let done = 0; done < job.arrays[k]; )
    done += writeSync(1, new Uint8Array(memory.buffer, place + done, job.arrays[k] - done));
