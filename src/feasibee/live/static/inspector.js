// The inspector: one robot, chosen by pointer or keyboard, and why it thinks so.

import { $, announce, list, write } from "./elements.js";

/** @type {Record<string, number>} */
const KEYS = { Enter: 0, ArrowLeft: -1, ArrowUp: -1, PageUp: -1, ArrowRight: 1, ArrowDown: 1, PageDown: 1 };

/**
 * Return the first number from one on that a robot has, in steps of 1 or -1; the same if there is no other.
 * @param {Arena} arena
 * @param {number} from
 * @param {number} by
 */
function following(arena, from, by) {
  const { robots } = arena,
    numbers = Array.from({ length: robots }, (_, k) => (from + k * by + robots * robots) % robots);
  return numbers.find((each) => arena.has(each)) ?? from;
}

export class Inspector {
  robot = -1; // that is inspected; -1 for none
  robots = 0; // numbers that they may have
  focus = 0; // the robot from which arrow keys start when none is chosen
  /** @type {[string, string][][]} */
  told = []; // that is shown, of each swarm

  /** @param {(robot: number) => void} choose Another robot is chosen; -1 for none. */
  constructor(choose) {
    this.choose = choose;
    this.input = /** @type {HTMLInputElement} */ ($("robot"));
    this.input.addEventListener("change", () => this.pick(this.input.valueAsNumber));
    $("robot-none").addEventListener("click", () => this.pick(-1));
  }

  /** @param {number} robots */
  open(robots) {
    this.robots = robots;
    this.input.max = String(robots - 1);
    this.focus = Math.min(this.focus, robots - 1);
    if (this.robot >= robots) this.robot = -1;
    this.reflect();
  }

  /**
   * Choose a robot; another number than that of a robot chooses none.
   * @param {number} robot
   */
  pick(robot) {
    const chosen = Number.isInteger(robot) && robot >= 0 && robot < this.robots ? robot : -1,
      isOther = chosen !== this.robot;
    this.robot = chosen;
    this.reflect();
    if (!isOther) return;
    if (chosen >= 0) this.focus = chosen;
    announce(chosen < 0 ? "No robot is inspected" : `Robot ${chosen}`);
    this.choose(chosen);
  }

  /**
   * Answer a key in an arena; return whether it was one of the inspector's.
   * @param {string} key
   * @param {Arena} arena
   */
  press(key, arena) {
    if (!this.robots) return false; // no run is open yet
    const { robot, focus } = this,
      by = KEYS[key];
    if (key === "Escape" && robot >= 0) this.pick(-1);
    else if (by === undefined) return false;
    else if (robot < 0) this.pick(following(arena, focus, 1));
    else if (by) this.pick(following(arena, robot + by, by));
    return true;
  }

  /**
   * Show what is known of the robot in each swarm.
   * @param {Lane[]} lanes That are shown.
   */
  show(lanes) {
    for (const k of [0, 1]) {
      const box = $(`reasons-${k}`),
        words = lanes[k]?.words.get("inspect"),
        wasHidden = box.hidden;
      box.hidden = this.robot < 0 || words?.robot !== this.robot || !words.reasons.length;
      if (box.hidden || !words || this.told[k] === words.reasons) continue;
      this.told[k] = words.reasons;
      write(
        /** @type {HTMLElement} */ (box.querySelector("h3")),
        lanes.length > 1 ? lanes[k].strategy.name : "",
      );
      list(box, words.reasons);
      if (wasHidden) $("inspector").scrollIntoView({ block: "nearest" });
    }
  }

  reflect() {
    this.input.value = this.robot < 0 ? "" : String(this.robot);
    $("robot-none").hidden = this.robot < 0;
    $("robot-hint").hidden = this.robot >= 0;
  }

  /**
   * Let the pointer show and choose robots of an arena, and keys choose them while it has the focus.
   * @param {Lane} lane
   * @param {() => void} redraw
   */
  listen({ canvas, arena, frame }, redraw) {
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !this.press(event.key, arena)) return;
      event.preventDefault();
      event.stopPropagation();
    });
    for (const type of /** @type {const} */ (["pointermove", "pointerdown", "pointerleave"]))
      frame.addEventListener(type, (event) => {
        const robot = type === "pointerleave" ? -1 : arena.at(event);
        if (robot !== arena.pointed) redraw();
        arena.pointed = robot;
      });
    frame.addEventListener("click", (event) => this.pick(arena.at(event)));
  }
}
