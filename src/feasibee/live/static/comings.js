// Rings around what has just come or gone in a world that changes.

import { THERE } from "./frames.js";

/** @import { Frame } from "./frames.js" */

const LASTS = 900; // milliseconds
/** @typedef {{x: number, y: number, came: boolean, since: number}} Coming */

export class Comings {
  constructor() {
    /** @type {Coming[]} */
    this.rings = [];
  }

  /**
   * Add what has come or gone from one frame to a later one.
   * @param {Frame} old
   * @param {Frame} now
   * @param {number} time
   */
  notice(old, now, time) {
    for (let i = 0; i < now.robots; i++) {
      if (!((old.flags[i] ^ now.flags[i]) & THERE)) continue;
      const came = Boolean(now.flags[i] & THERE),
        { x, y } = came ? now : old;
      this.rings.push({ x: x[i], y: y[i], came, since: time });
    }
    const tasks = [tasksOf(old), tasksOf(now)];
    for (const came of [true, false])
      for (const [key, [x, y]] of tasks[Number(came)])
        if (!tasks[Number(!came)].has(key)) this.rings.push({ x, y, came, since: time });
  }

  /**
   * Draw: rings close around what came, and open around what went.
   * @param {CanvasRenderingContext2D} context
   * @param {{unit: number, height: number, radius: number, ratio: number}} arena
   * @param {number} time
   */
  draw(context, { unit, height, radius, ratio }, time) {
    this.rings = this.rings.filter(({ since }) => time - since < LASTS);
    context.lineWidth = 1.5 * ratio;
    for (const { x, y, came, since } of this.rings) {
      const age = Math.max(0, (time - since) / LASTS),
        size = Math.max(6 * ratio, 2 * radius) * (came ? 2.4 - age : 1 + 1.4 * age);
      context.globalAlpha = 1 - age;
      context.beginPath();
      context.arc(x * unit, height - y * unit, size, 0, 2 * Math.PI);
      context.stroke();
    }
    context.globalAlpha = 1;
  }
}

/**
 * Return the places of the tasks of a frame, by a key for each.
 * @param {Frame} frame
 * @returns {Map<number, [number, number]>}
 */
function tasksOf({ taskX, taskY }) {
  return new Map([...taskX].map((x, k) => [65536 * x + taskY[k], [x, taskY[k]]]));
}
