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

/** @import { Opened } from "./arena.js" */
/** @import { Lane } from "./lane.js" */
/** @import { Frame } from "./frames.js" */

/**
 * Show the tooltip beside the robot that is pointed at, or hide it.
 * @param {Lane} lane
 * @param {Opened} world
 * @param {Frame} frame
 */
export function showTooltip({ arena, tip: box, canvas, frame: around }, world, frame) {
  const robot = arena.pointed;
  box.hidden = !(frame.flags[robot] & THERE);
  if (box.hidden) return;
  const flags = frame.flags[robot],
    name = world.robotClasses[world.kinds[robot]];
  const words = [
    flags & NEUTRAL ? "no opinion" : flags & FEASIBLE ? "feasible" : "infeasible",
    !(flags & WORKING) ? "stopped" : flags & DISSEMINATING ? "disseminating" : "exploring",
    name && `class ${name}`,
    flags & BYZANTINE && "Byzantine",
    flags & STUBBORN && "stubborn",
    flags & DECLARED && "has declared",
    (frame.aims?.[robot] ?? NO_TASK) !== NO_TASK &&
      (flags & STANDING ? "stands at a task" : "walks to a task"),
    (!(flags & WORKING) || flags & BYZANTINE) && "not counted",
  ];
  const text = `Robot ${robot}: ${words.filter(Boolean).join(", ")}`;
  if (box.textContent !== text) box.textContent = text;
  const [x, y] = [arena.px[robot] / arena.ratio, arena.py[robot] / arena.ratio]; // in CSS pixels
  const left = Math.max(0, Math.min(canvas.offsetLeft + x + 14, around.clientWidth - box.offsetWidth));
  const top = canvas.offsetTop + y + (y > 60 ? -14 - box.offsetHeight : 18);
  box.style.transform = `translate(${left}px, ${top}px)`;
}
