// The clock: which of the received steps to show, and when to request more.
// The page requests each frame when it needs it, so that nothing queues up and a hidden page costs nothing.

/** @import { View } from "./arena.js" */
/** @import { Frame } from "./frames.js" */

export const SPEEDS = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 3000];
const RATE = 60; // frames per second of a usual screen

export class Player {
  /**
   * @param {HTMLElement} canvas While it is hidden, time stands still; a change of its size must wake the player.
   * @param {(steps: number) => void} ask
   * @param {(view: View, time: number, rests: boolean) => boolean} draw Returns whether something else moves.
   */
  constructor(canvas, ask, draw) {
    this.canvas = canvas;
    this.ask = ask;
    this.draw = draw;
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
    this.speed = 20;
    this.playing = false;
    this.pending = this.past = 0;
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
    this.wake();
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
    this.wake();
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
    this.wake();
  }

  // Stop here: the server sends no more frames.
  halt() {
    this.playing = this.asked = false;
    this.target = this.head;
    this.wake();
  }

  step() {
    const from = Math.floor(this.head + 1e-9);
    this.target = Math.min((this.playing ? from : Math.max(from, this.target)) + 1, this.last);
    this.playing = false;
    this.wake();
  }

  // Draw soon, and as long as time passes or something moves.
  wake() {
    this.pending ||= requestAnimationFrame((time) => {
      this.pending = 0;
      if (!this.canvas.offsetWidth) return;
      const view = this.tick(this.past ? Math.min(0.1, (time - this.past) / 1000) : 0),
        rests = !this.playing && this.head >= this.target,
        waits = this.asked && this.head >= this.latest?.step; // for a frame, which wakes it
      if (!view) return;
      this.past = rests ? 0 : time;
      if (this.draw(view, time, rests) || !(rests || waits)) this.wake();
    });
  }

  /**
   * Let time pass; return what to draw.
   * @param {number} seconds
   * @returns {View | null}
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
    const calm = this.calm.matches,
      between = !calm && next?.step === now.step + 1 ? this.head - now.step : 0;
    return { now, next: between > 0 ? next : null, between, calm: calm || this.speed > 60 };
  }
}
