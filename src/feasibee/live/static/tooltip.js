// The tooltip of the robot under the pointer.

import {
  BYZANTINE,
  DECLARED,
  DISSEMINATING,
  FEASIBLE,
  NEUTRAL,
  NO_TASK,
  STANDING,
  STUBBORN,
  THERE,
  WORKING,
} from "./frames.js";

/** @import { Arena } from "./arena.js" */
/** @import { Frame } from "./frames.js" */

/**
 * Show the tooltip of the robot that is pointed at, or hide it.
 * @param {Arena} arena
 * @param {HTMLElement} box In the same frame as the arena's canvas.
 * @param {Frame} frame
 * @param {string} [why] Why it holds its opinion, in a sentence.
 */
export function showTooltip(arena, box, frame, why = "") {
  const { world, canvas } = arena,
    around = canvas.parentElement ?? canvas;
  const robot = arena.pointed;
  box.hidden = !(frame.flags[robot] & THERE);
  if (box.hidden) return;
  const flags = frame.flags[robot],
    name = world.robotClasses?.[world.kinds?.[robot] ?? 0];
  const words = [
    flags & NEUTRAL ? "no opinion" : flags & FEASIBLE ? "feasible" : "infeasible",
    !(flags & WORKING) ? "stopped" : flags & DISSEMINATING ? "broadcasting" : "exploring",
    name && `class ${name}`,
    flags & BYZANTINE && "Byzantine",
    flags & STUBBORN && "stubborn",
    flags & DECLARED && "has declared",
    (frame.aims?.[robot] ?? NO_TASK) !== NO_TASK &&
      (flags & STANDING ? "stands at a task" : "walks to a task"),
    (!(flags & WORKING) || flags & BYZANTINE) && "not counted",
  ];
  const text = `Robot ${robot}: ${words.filter(Boolean).join(", ")}${why && `\n${why}`}`;
  if (box.textContent !== text) box.textContent = text;
  const [x, y] = [arena.px[robot] / arena.ratio, arena.py[robot] / arena.ratio]; // in CSS pixels
  const left = Math.max(0, Math.min(canvas.offsetLeft + x + 14, around.clientWidth - box.offsetWidth));
  const top = canvas.offsetTop + y + (y > 60 ? -14 - box.offsetHeight : 18);
  box.style.transform = `translate(${left}px, ${top}px)`;
}
