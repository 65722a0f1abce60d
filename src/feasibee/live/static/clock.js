// The clock: which step of a history to show.

export const SPEEDS = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 3000];
const LEAST = 10; // steps per second of a single step

export class Clock {
  /** @type {RunHistory | null} */
  history = null;

  /** @param {(step: number, time: number, rests: boolean) => void} draw rests: time stands still. */
  constructor(draw) {
    this.draw = draw;
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
    this.speed = 20;
    this.playing = false;
    this.pending = this.past = this.head = this.target = 0;
  }

  /**
   * Show a history from a step on.
   * @param {RunHistory} history
   * @param {number} step
   */
  open(history, step) {
    this.history = history;
    this.head = this.target = Math.min(step, history.last);
    this.wake();
  }

  get step() {
    return Math.floor(this.head + 1e-9);
  }

  get ended() {
    return this.history !== null && this.head >= this.history.last;
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
    if (!this.playing) this.target = Math.ceil(this.head);
    this.wake();
  }

  // Play, from the start if it has ended; or pause.
  toggle() {
    if (!this.playing && this.ended) this.goTo(0);
    this.play(!this.playing);
  }

  // Go one step on, as seen.
  advance() {
    const from = this.playing ? this.step : Math.max(this.step, this.target);
    this.target = Math.min(from + 1, this.history?.last ?? 0);
    this.playing = false;
    this.wake();
  }

  /** @param {number} step */
  goTo(step) {
    this.head = this.target = Math.max(0, Math.min(step, this.history?.last ?? 0));
    if (this.ended) this.playing = false;
    this.wake();
  }

  // Draw soon, and as long as time passes.
  wake() {
    this.pending ||= requestAnimationFrame((time) => {
      this.pending = 0;
      const { history } = this;
      if (!history || history.known < 0) return;
      this.tick(history, this.past ? Math.min(0.1, (time - this.past) / 1000) : 0);
      const rests = !this.playing && this.head >= this.target,
        waits = this.head >= history.known; // for steps, which wake it
      this.past = rests ? 0 : time;
      this.draw(Math.min(this.step, history.known), time, rests);
      if (!(rests || waits)) this.wake();
    });
  }

  /**
   * Let time pass.
   * @param {RunHistory} history
   * @param {number} seconds
   */
  tick(history, seconds) {
    const limit = this.playing ? history.last : this.target,
      speed = this.playing ? this.speed : Math.max(this.speed, LEAST),
      reach = Math.min(limit, Math.max(this.head, history.known)); // a step that was sought may come later
    this.head = Math.max(this.head, Math.min(this.head + speed * seconds, reach));
    if (this.playing && this.ended) this.play(false);
  }

  // How much of the time to the next step has passed, 0 to 1.
  get between() {
    const { history, step, calm } = this;
    return !history || calm.matches || history.every > 1 || step >= history.known ? 0 : this.head - step;
  }
}
