// The workers of a page: they are given scenarios and asked for runs, and answer while the page stays free.

import { compiled } from "./world.js";
import { $ } from "./elements.js";

/** @typedef {{steps?: Steps, outcomes?: Outcome[], robot?: number, step?: number, state?: any, problem?: string}} Answer */

export const RUNS = 100;

let scenarios = 0; // opened by this page

export class Engine {
  /**
   * @param {string} wasm The engine of all scenarios that have none of their own.
   * @param {number} count Of workers; channels are shared out among them.
   */
  constructor(wasm, count) {
    const source = new Blob([$("worker").textContent ?? ""], { type: "text/javascript" }),
      url = URL.createObjectURL(source);
    this.wasm = wasm;
    this.workers = Array.from({ length: count }, () => new Worker(url));
    /** @type {Map<string, {gen: number, hear: (answer: Answer) => void}>} */
    this.channels = new Map();
    for (const each of this.workers)
      each.addEventListener("message", ({ data }) => {
        const own = this.channels.get(data.channel);
        if (own && own.gen === data.gen) own.hear(data);
      });
  }

  /**
   * Take a scenario; return its key.
   * @param {Opened} opened
   */
  async open(opened) {
    const module = await compiled(opened.wasm ?? this.wasm),
      key = ++scenarios;
    for (const each of this.workers)
      each.postMessage({ type: "open", channel: "", gen: 0, key, module, opened });
    return key;
  }

  /**
   * Ask for work on a channel; what was asked of it before ends.
   * @param {string} channel Those of one letter share a worker.
   * @param {"run" | "many" | "inspect"} type
   * @param {{key: number, settings: Settings} & Record<string, any>} asked
   * @param {(answer: Answer) => void} hear
   */
  ask(channel, type, asked, hear) {
    const gen = (this.channels.get(channel)?.gen ?? 0) + 1,
      worker = this.workers[channel.charCodeAt(0) % this.workers.length];
    this.channels.set(channel, { gen, hear });
    worker.postMessage({ type, channel, gen, ...asked });
  }
}
