// The clock: which of the received steps to show, and when to request more.
// The page requests each frame when it needs it, so that nothing queues up and a hidden page costs nothing.

/** @import { Frame } from "./frames.js" */

export const SPEEDS = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 3000];
const RATE = 60; // frames per second of a usual screen

export class Player {
  /** @param {(steps: number) => void} ask */
  constructor(ask) {
    this.ask = ask;
    this.speed = 20;
    this.playing = false;
    this.smooth = true;
    /** @type {Frame[]} */
    this.frames = [];
    this.head = this.target = this.last = 0;
    this.asked = false;
  }

  clear() {
    this.frames = [];
    this.head = 0;
    this.target = 0;
    this.last = 0;
    this.asked = false;
  }

  /** @param {Frame} frame */
  add(frame) {
    this.asked = false;
    if (!this.frames.length) {
      this.head = frame.step;
      this.target = Math.max(this.target, frame.step); // the user may have requested a step already
    }
    this.frames.push(frame);
  }

  /**
   * Show this frame at once, and go on from its step.
   * @param {Frame} frame
   */
  arrive(frame) {
    this.asked = false;
    this.frames = [frame];
    this.head = this.target = frame.step;
    if (this.ended) this.playing = false;
  }

  get latest() {
    return this.frames[this.frames.length - 1];
  }

  get ended() {
    return this.frames.length > 0 && this.head >= this.last;
  }

  // The speed in words.
  get pace() {
    return `${this.speed.toLocaleString("en")} ${this.speed === 1 ? "step" : "steps"} / s`;
  }

  /** @param {number} by */
  nextSpeed(by) {
    return SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, SPEEDS.indexOf(this.speed) + by))];
  }

  /** @param {boolean} on */
  play(on) {
    this.playing = on && !this.ended;
    if (!this.playing) this.target = Math.min(Math.ceil(this.head), this.last);
  }

  // Stop here: the server sends no more frames.
  halt() {
    this.playing = this.asked = false;
    this.target = this.head;
  }

  step() {
    const from = Math.floor(this.head + 1e-9);
    this.target = Math.min((this.playing ? from : Math.max(from, this.target)) + 1, this.last);
    this.playing = false;
  }

  /**
   * Let time pass; return the frame to show, the next, and the time between them, 0 to 1.
   * @param {number} seconds
   */
  tick(seconds) {
    if (!this.frames.length) return null;
    const limit = this.playing ? this.last : this.target;
    const speed = this.playing ? this.speed : Math.max(this.speed, 10);
    const ahead = this.playing ? Math.max(1, Math.ceil(this.speed / RATE)) : limit - this.head;
    this.head = Math.max(this.head, Math.min(this.head + speed * seconds, limit, this.latest.step));
    if (this.playing && this.ended) this.play(false);
    const wanted = Math.min(limit, Math.ceil(this.head + ahead));
    if (!this.asked && this.latest.step < wanted) {
      this.asked = true;
      this.ask(wanted - this.latest.step);
    }
    while (this.frames.length > 1 && this.frames[1].step <= this.head) this.frames.shift();
    const [now, next] = this.frames;
    const between = this.smooth && next && next.step === now.step + 1 ? this.head - now.step : 0;
    return { now, next: between > 0 ? next : null, between };
  }
}
