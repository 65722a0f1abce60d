// Small pictures of robots, one for each look.

import { contextOf } from "./crowd.js";
import { COMMITTED, DISSEMINATING, FEASIBLE, LIAR, NEUTRAL, WORKING } from "./frames.js";

/** @import { Colours } from "./arena.js" */

export const LOOKS = FEASIBLE | NEUTRAL | DISSEMINATING | COMMITTED | WORKING | LIAR; // marks that show

/**
 * Draw a robot: its opinion as a disc, or a ring if infeasible; what else it is around or upon it.
 * @param {number} marks
 * @param {number} radius In pixels.
 * @param {Colours} colours
 * @returns {HTMLCanvasElement}
 */
export function drawSprite(marks, radius, colours) {
  const half = Math.ceil(1.75 * radius) + 1,
    sprite = document.createElement("canvas"),
    pen = contextOf(sprite);
  sprite.width = sprite.height = 2 * half;
  pen.translate(half, half);
  drawOpinion(pen, marks, radius, colours);
  pen.strokeStyle = colours.ink;
  pen.lineWidth = Math.max(1, 0.18 * radius);
  pen.globalAlpha = 1;
  if (marks & LIAR) pen.strokeRect(-1.15 * radius, -1.15 * radius, 2.3 * radius, 2.3 * radius);
  if (!(marks & WORKING)) {
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
 * Draw the disc of the opinion, the ring of a robot that disseminates, and the dot of one that is committed.
 * @param {CanvasRenderingContext2D} pen
 * @param {number} marks
 * @param {number} radius
 * @param {Colours} colours
 */
function drawOpinion(pen, marks, radius, colours) {
  /** @param {number} size */
  const disc = (size) => {
    pen.beginPath();
    pen.arc(0, 0, size, 0, 2 * Math.PI);
  };
  const colour =
    marks & NEUTRAL ? colours.undecided : marks & FEASIBLE ? colours.feasible : colours.infeasible;
  pen.fillStyle = pen.strokeStyle = colour;
  if (!(marks & WORKING)) pen.globalAlpha = 0.45;
  disc(marks & NEUTRAL ? 0.7 * radius : radius);
  pen.fill();
  if (!(marks & (FEASIBLE | NEUTRAL)) && radius > 2) {
    pen.fillStyle = colours.ground;
    disc(0.48 * radius);
    pen.fill();
  }
  if (marks & DISSEMINATING && radius > 2) {
    pen.lineWidth = Math.max(1, 0.2 * radius);
    disc(1.5 * radius);
    pen.stroke();
  }
  if (marks & COMMITTED) {
    pen.fillStyle = marks & FEASIBLE ? colours.ground : colour;
    disc(0.25 * radius);
    pen.fill();
  }
}
