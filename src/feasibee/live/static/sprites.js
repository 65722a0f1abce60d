// Small pictures of robots, one for each look.

import { contextOf } from "./crowd.js";
import { BYZANTINE, DECLARED, DISSEMINATING, FEASIBLE, NEUTRAL, WORKING } from "./frames.js";

/** @import { Shades } from "./theme.js" */

export const LOOKS = FEASIBLE | NEUTRAL | DISSEMINATING | DECLARED | WORKING | BYZANTINE; // flags that show

/**
 * Draw a robot: its opinion as a disc, or a ring if infeasible; what else it is around or upon it.
 * @param {number} flags
 * @param {number} radius In pixels.
 * @param {Shades} colours
 * @returns {HTMLCanvasElement}
 */
export function drawSprite(flags, radius, colours) {
  const half = Math.ceil(1.75 * radius) + 1,
    sprite = document.createElement("canvas"),
    pen = contextOf(sprite);
  sprite.width = sprite.height = 2 * half;
  pen.translate(half, half);
  drawOpinion(pen, flags, radius, colours);
  pen.strokeStyle = colours.ink;
  pen.lineWidth = Math.max(1, 0.18 * radius);
  pen.globalAlpha = 1;
  if (flags & BYZANTINE) pen.strokeRect(-1.15 * radius, -1.15 * radius, 2.3 * radius, 2.3 * radius);
  if (!(flags & WORKING)) {
    const arm = 0.75 * radius;
    pen.beginPath();
    pen.moveTo(-arm, -arm);
    pen.lineTo(arm, arm);
    pen.moveTo(arm, -arm);
    pen.lineTo(-arm, arm);
    pen.stroke();
  }
  return sprite;
}

/**
 * Draw the disc of the opinion, the ring of a robot that disseminates, and the dark rim of one that has
 * declared.
 * @param {CanvasRenderingContext2D} pen
 * @param {number} flags
 * @param {number} radius
 * @param {Shades} colours
 */
function drawOpinion(pen, flags, radius, colours) {
  /** @param {number} size */
  const disc = (size) => {
    pen.beginPath();
    pen.arc(0, 0, size, 0, 2 * Math.PI);
  };
  const colour =
    flags & NEUTRAL ? colours.undecided : flags & FEASIBLE ? colours.feasible : colours.infeasible;
  pen.fillStyle = pen.strokeStyle = colour;
  if (!(flags & WORKING)) pen.globalAlpha = 0.45;
  disc(flags & NEUTRAL ? 0.7 * radius : radius);
  pen.fill();
  if (!(flags & (FEASIBLE | NEUTRAL)) && radius > 2) {
    pen.fillStyle = colours.ground;
    disc(0.48 * radius);
    pen.fill();
  }
  if (flags & DISSEMINATING && radius > 2) {
    pen.lineWidth = Math.max(1, 0.2 * radius);
    disc(1.5 * radius);
    pen.stroke();
  }
  if (flags & DECLARED) {
    pen.strokeStyle = colours.ink;
    pen.lineWidth = Math.max(1, 0.3 * radius);
    disc(radius);
    pen.stroke();
  }
}
