// Draw and erase walls with the pointer; they become the polygons of place.walls.

import { announce } from "./elements.js";
import { outlineOf } from "./ground.js";

const DRAG = 6; // pixels: less is a click
const NEAR = 10; // pixels from a wall's edge
const LONGEST = 12_000; // characters that fit into a message with other changes

/**
 * Return the tools that draw and erase walls.
 * @param {Page} page
 * @returns {Record<string, Tool>}
 */
export function wallTools(page) {
  const set = (/** @type {Point[][]} */ walls) => {
    if (JSON.stringify(walls).length <= LONGEST) return page.drawWalls(walls);
    announce("There are too many walls for this page: write them into the scenario's file.");
  };
  return {
    draw: {
      label: "Draw walls",
      help: "Drag for a rectangle.",
      begin: (place) => cornerAt(place, page.opened),
      move: (place, held) => held && page.tools.sketch(rectangle(held, place, page.opened)),
      end: (place, held) => {
        const wall = held ? rectangle(held, place, page.opened) : [];
        if (wall.length) set([...page.opened.drawn, wall]);
      },
    },
    erase: {
      label: "Erase walls",
      help: "Click a wall to erase it. Walls of a map stay.",
      move: (place) => page.tools.sketch(page.opened.drawn[wallAt(place, page.opened)] ?? []),
      end: (place) => {
        const found = wallAt(place, page.opened);
        if (found < 0) announce("There is no wall to erase.");
        else set(page.opened.drawn.toSpliced(found, 1));
      },
    },
  };
}

/**
 * Return the corner of cells that is nearest to a place, within the arena.
 * @param {Place} place
 * @param {Opened} opened
 * @returns {Point}
 */
function cornerAt(place, { cell, lengths: { size } }) {
  const [x, y] = place.arena
    .unitsAt(place)
    .map((each, k) => Math.max(0, Math.min(size[k], Math.round(each / cell) * cell)));
  return [Number(x.toPrecision(9)), Number(y.toPrecision(9))];
}

/**
 * Return a rectangle from a corner to a place, at least a cell wide; no points if the pointer was hardly moved.
 * @param {Point} start
 * @param {Place} place
 * @param {Opened} opened
 * @returns {Point[]}
 */
function rectangle([x, y], place, opened) {
  const { cell } = opened,
    { scale, ratio } = place.arena,
    [endX, endY] = cornerAt(place, opened),
    [right, top] = [endX === x ? x + cell : endX, endY === y ? y + cell : endY];
  if (Math.hypot(endX - x, endY - y) * scale < DRAG * ratio) return [];
  return [
    [x, y],
    [right, y],
    [right, top],
    [x, top],
  ];
}

/**
 * Return the number of the wall at a place, or near to it; -1 for none.
 * @param {Place} place
 * @param {Opened} opened
 */
function wallAt(place, { drawn }) {
  const { context, scale, height, ratio } = place.arena,
    pixel = place.arena.pixelAt(place);
  context.lineWidth = 2 * NEAR * ratio;
  return drawn.findLastIndex((/** @type {Point[]} */ each) => {
    const path = outlineOf([each], scale, height);
    return context.isPointInPath(path, ...pixel) || context.isPointInStroke(path, ...pixel);
  });
}
