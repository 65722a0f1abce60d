// The ground of an arena: grid, tasks and walls, drawn once until something of it changes.

/** @import { Arena } from "./arena.js" */
/** @import { Places } from "./frames.js" */

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Arena} arena
 */
export function drawGround(context, arena) {
  const { width, height, longer, colours, scale, ratio, tasks, world } = arena;
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, width, height);
  context.strokeStyle = colours.line;
  context.lineWidth = ratio;
  context.beginPath();
  const gap =
    10 ** Math.ceil(Math.log10(longer / 15)) / (longer / 10 ** Math.floor(Math.log10(longer)) < 3 ? 2 : 1);
  for (let at = gap; at * scale < Math.max(width, height) - 1; at += gap) {
    const x = Math.round(at * scale) + 0.5,
      y = Math.round(height - at * scale) + 0.5;
    context.moveTo(x, 0);
    context.lineTo(x, height);
    context.moveTo(0, y);
    context.lineTo(width, y);
  }
  context.stroke();
  if (tasks) drawTasks(context, arena, tasks);
  if (world.walls) {
    context.strokeStyle = colours.ink;
    context.lineWidth = 6 * ratio; // half of it is outside
    context.strokeRect(0, 0, width, height);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Arena} arena
 * @param {Places} tasks
 */
function drawTasks(context, { ratio, scale, unit, height, colours }, { x, y }) {
  const size = Math.max(1.5 * ratio, Math.min(0.42 * scale, 9 * ratio));
  context.fillStyle = colours.task;
  if (size < 4 * ratio) context.globalAlpha = 0.5; // many tasks would hide the robots
  context.beginPath();
  for (let i = 0; i < x.length; i++) {
    const left = x[i] * unit,
      top = height - y[i] * unit;
    context.moveTo(left, top - size);
    context.lineTo(left + 0.92 * size, top + 0.66 * size);
    context.lineTo(left - 0.92 * size, top + 0.66 * size);
    context.closePath();
  }
  context.fill();
  context.globalAlpha = 1;
  if (size > 4 * ratio) {
    context.strokeStyle = colours.ground;
    context.lineWidth = 0.8 * ratio;
    context.stroke();
  }
}
