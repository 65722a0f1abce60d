// A swarm of the page: its arena, its run, a hundred more of its kind, and what a robot of it knows.

import { Arena } from "./arena.js";
import { RUNS } from "./engine.js";
import { formatted } from "./elements.js";
import { lookOf, STANDING } from "./frames.js";
import { History } from "./history.js";
import { reasonsOf, sentenceOf } from "./reasons.js";
import { coloursOf } from "./theme.js";
import { doneAmong, OPINIONS } from "./words.js";

/** @typedef {{key: number, opened: Opened, settings: Settings, lasts?: number}} Asked Which scenario, its numbers, and for how many steps. */
/** @typedef {{robot: number, step: number, reasons: [string, string][], sentence: string}} Words */

export class Lane {
  /** @type {History | null} */
  history = null; // that is shown
  /** @type {History | null} */
  coming = null; // that is simulated, and not shown yet
  /** @type {Asked | null} */
  asked = null;
  /** @type {Outcome[]} */
  outcomes = []; // of runs 0, 1, 2, ... of this kind
  kind = ""; // all that these have in common
  /** @type {((frame: Frame, robot: number) => [string, string][]) | null} */
  tell = null; // what is known of a robot, if no engine tells it
  /** @type {Map<string, Words>} */
  words = new Map(); // of the inspected robot, and of the one that is pointed at

  /**
   * @param {string} name
   * @param {Engine} engine
   * @param {HTMLElement} canvas In a frame, perhaps with a tooltip.
   * @param {{redraw: () => void, came: () => void, counted: () => void}} hear What to do when something to draw is another
   *   one, when steps came, and when more swarms did.
   */
  constructor(name, engine, canvas, hear) {
    this.name = name;
    this.engine = engine;
    this.hear = hear;
    this.canvas = /** @type {HTMLCanvasElement} */ (canvas);
    this.frame = /** @type {HTMLElement} */ (canvas.parentElement);
    this.tip = /** @type {HTMLElement | null} */ (this.frame.querySelector(".tip"));
    this.caption = canvas.closest(".lane")?.querySelector(".caption");
    this.arena = new Arena(this.canvas, coloursOf(), hear.redraw);
  }

  get strategy() {
    const { settings, opened } = /** @type {Asked} */ (this.asked);
    return opened.strategies[settings.strategy];
  }

  get isCounted() {
    return this.outcomes.length === RUNS;
  }

  /**
   * Simulate a run.
   * @param {Asked} asked
   */
  begin(asked) {
    const { key, settings, opened, lasts = Infinity } = asked,
      coming = (this.coming = new History(settings, opened, Math.min(lasts, opened.run.steps)));
    this.asked = asked;
    this.engine.ask(`run ${this.name}`, "run", { key, settings, lasts }, ({ steps, problem = "" }) => {
      if (steps) coming.add(steps);
      else Object.assign(coming, { problem, done: true });
      this.hear.came();
    });
  }

  // Simulate a hundred swarms of the run's kind, unless they are known.
  count() {
    const { key, settings } = /** @type {Asked} */ (this.asked),
      kind = JSON.stringify([key, { ...settings, run: 0 }]);
    if (kind === this.kind) return;
    this.kind = kind;
    this.outcomes = [];
    this.engine.ask(
      `many ${this.name}`,
      "many",
      { key, settings, from: 0, to: RUNS },
      ({ outcomes = [] }) => {
        this.outcomes.push(...outcomes);
        this.hear.counted();
      },
    );
  }

  /**
   * Whether a step of the coming run is known, or can't be.
   * @param {number} step
   */
  isReady(step) {
    return !this.coming || this.coming.known >= step || this.coming.done;
  }

  // Show the run that was coming; return whether there is one.
  show() {
    if (!this.coming || this.coming.known < 0) return false;
    this.history = this.coming;
    this.coming = null;
    this.words.clear();
    this.frame.style.aspectRatio = this.history.opened.lengths.size.join(" / ");
    this.arena.open(this.history);
    return true;
  }

  /**
   * Ask what a robot knows at a step, unless that is known.
   * @param {"inspect" | "point"} why
   * @param {number} robot
   * @param {Frame} frame
   */
  wonder(why, robot, frame) {
    const { asked, history, words, tell } = this,
      { step } = frame,
      known = words.get(why);
    if (!asked || !history || (known?.robot === robot && known.step === step)) return;
    const before = known?.robot === robot ? known : { reasons: [], sentence: "" };
    words.set(why, { ...before, robot, step, ...(tell && { reasons: tell(frame, robot) }) });
    if (tell) return;
    const { key, opened, settings } = asked;
    this.engine.ask(`${why} ${this.name}`, "inspect", { key, settings, robot, step }, ({ state }) => {
      const moment = history.moment(robot, step),
        given = /** @type {const} */ ([state, opened, settings.strategy, moment]);
      words.set(why, { robot, step, reasons: reasonsOf(...given), sentence: sentenceOf(...given) });
      this.hear.redraw();
    });
  }

  /**
   * Draw a step, and the way to the next one.
   * @param {number} step
   * @param {number} between
   */
  draw(step, between) {
    const { arena, tip, caption, strategy } = this,
      history = /** @type {History} */ (this.history),
      now = history.frame(step),
      text = `${strategy.name}: ${inWords(now)}`;
    arena.draw(now, between ? history.frame(step + 1) : now, between);
    if (caption && caption.textContent !== text) caption.textContent = text;
    if (tip) this.point(now, tip);
  }

  /**
   * Say beside the robot that is pointed at what is seen of it, and as soon as it is known, why it holds its opinion.
   * @param {Frame} now
   * @param {HTMLElement} tip
   */
  point(now, tip) {
    const { arena, canvas, frame, words } = this,
      { pointed, ratio } = arena,
      { robotClasses } = /** @type {Asked} */ (this.asked).opened.lengths;
    tip.hidden = !arena.has(pointed);
    if (tip.hidden) return;
    this.wonder("point", pointed, now);
    const { sentence = "" } = words.get("point") ?? {},
      seen = lookOf(now, pointed, robotClasses[now.kinds[pointed] ?? 0]),
      text = `Robot ${pointed}: ${seen}${sentence && `\n${sentence}`}`,
      [x, y] = [arena.px[pointed] / ratio, arena.py[pointed] / ratio]; // in CSS pixels
    if (tip.textContent !== text) tip.textContent = text;
    const left = Math.max(0, Math.min(canvas.offsetLeft + x + 14, frame.clientWidth - tip.offsetWidth)),
      above = canvas.offsetTop + y - 14 - tip.offsetHeight,
      top = above < 0 ? canvas.offsetTop + y + 18 : above;
    tip.style.transform = `translate(${left}px, ${top}px)`;
  }

  /** @param {string} now What the clock does, in words. */
  describe(now) {
    const { there, tasks } = /** @type {Frame} */ (this.arena.frame),
      text = `The arena: ${there} robots and ${tasks} tasks, ${this.strategy.name}, ${now}. Arrow keys go from robot to robot.`;
    if (this.canvas.ariaLabel !== text) this.canvas.ariaLabel = text;
  }
}

/**
 * Return in words what a swarm holds at a step.
 * @param {Frame} frame
 */
function inWords({ feasible, infeasible, decision, tasks, taken, flags }) {
  const held = decision < 0 ? "undecided" : `decided ${OPINIONS[decision]}`,
    count = taken && flags.filter((each) => each & STANDING).length + doneAmong(taken),
    done = taken ? `; ${formatted(count ?? 0)} of ${formatted(tasks)} tasks taken` : "";
  return `${formatted(feasible)} feasible, ${formatted(infeasible)} infeasible; ${held}${done}`;
}
