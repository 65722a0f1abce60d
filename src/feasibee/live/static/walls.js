// Draw and erase walls with the pointer; they become the polygons of place.walls.

import { announce } from "./elements.js";
import { tracePolygons } from "./ground.js";

/** @import { Arena, Opened } from "./arena.js" */
/** @import { Point, Tool } from "./tools.js" */

const DRAG = 6; // pixels: less is a click
const NEAR = 10; // pixels from its first corner, or from a wall's edge
const LONGEST = 12_000; // characters that fit into a message with other changes

export class Walls {
  /**
   * @param {(walls: Point[][]) => void} change
   * @param {(sketch: Point[]) => void} sketch
   */
  constructor(change, sketch) {
    this.change = change;
    this.sketch = sketch;
    /** @type {Point[][]} */
    this.walls = []; // of the run that is shown
    /** @type {Point[]} */
    this.corners = [];
    /** @type {Point | null} */
    this.start = null; // of a drag
    this.cell = 0.1;
    const drop = () => this.drop();
    /** @type {Record<string, Tool>} */
    this.tools = {
      draw: {
        label: "Draw walls",
        help: "Drag for a rectangle. Or click the corners of a polygon, and its first corner again. Esc drops it.",
        begin: (event, arena) => (this.start = this.pointAt(event, arena)),
        move: (event, arena) => this.preview(event, arena),
        end: (event, arena) => this.add(event, arena),
        drop,
      },
      erase: {
        label: "Erase walls",
        help: "Click a wall to erase it. Walls of a map stay.",
        move: (event, arena) => this.sketch(this.walls[this.wallAt(event, arena)] ?? []),
        end: (event, arena) => this.erase(event, arena),
        drop,
      },
    };
  }

  /** @param {Opened} world */
  open({ drawn, cell }) {
    this.walls = drawn;
    this.cell = cell;
    this.drop();
  }

  // Drop what is half drawn; return whether anything was.
  drop() {
    const some = this.corners.length > 0;
    this.corners = [];
    this.start = null;
    this.sketch([]);
    return some;
  }

  /**
   * Return the corner of cells that is nearest to the pointer, within the arena.
   * @param {MouseEvent} event
   * @param {Arena} arena
   * @returns {Point}
   */
  pointAt(event, arena) {
    const { size } = arena.world,
      place = arena.unitsAt(event.clientX, event.clientY),
      [x, y] = place.map((each, k) =>
        Number(Math.max(0, Math.min(size[k], Math.round(each / this.cell) * this.cell)).toPrecision(9)),
      );
    return [x, y];
  }

  /**
   * Return a rectangle from the start of the drag, at least a cell wide; null if the pointer was hardly moved.
   * @param {Point} end
   * @param {Arena} arena
   * @returns {Point[] | null}
   */
  rectangle([endX, endY], { scale, ratio }) {
    if (!this.start || this.corners.length) return null;
    const [x, y] = this.start;
    if (Math.hypot(endX - x, endY - y) * scale < DRAG * ratio) return null;
    const right = endX === x ? x + this.cell : endX,
      top = endY === y ? y + this.cell : endY;
    return [
      [x, y],
      [right, y],
      [right, top],
      [x, top],
    ];
  }

  /**
   * @param {MouseEvent} event
   * @param {Arena} arena
   */
  preview(event, arena) {
    const at = this.pointAt(event, arena);
    this.sketch(this.rectangle(at, arena) ?? (this.corners.length ? [...this.corners, at] : []));
  }

  /**
   * Add a rectangle or a corner; the first corner again ends a polygon.
   * @param {MouseEvent} event
   * @param {Arena} arena
   */
  add(event, arena) {
    const at = this.pointAt(event, arena),
      rectangle = this.rectangle(at, arena),
      { corners } = this;
    this.start = null;
    if (rectangle) return this.set([...this.walls, rectangle]);
    const [first] = corners,
      closes = first && Math.hypot(at[0] - first[0], at[1] - first[1]) * arena.scale < NEAR * arena.ratio;
    if (closes && corners.length > 2) return this.set([...this.walls, corners]);
    if (!closes) corners.push(at);
    this.sketch([...corners, at]);
  }

  /**
   * @param {MouseEvent} event
   * @param {Arena} arena
   */
  erase(event, arena) {
    const found = this.wallAt(event, arena);
    if (found < 0) return announce("There is no wall to erase.");
    this.set(this.walls.filter((_, k) => k !== found));
  }

  /**
   * Return the number of the wall at the pointer, or near to it; -1 for none.
   * @param {MouseEvent} event
   * @param {Arena} arena
   */
  wallAt(event, { context, scale, height, ratio, canvas }) {
    const box = canvas.getBoundingClientRect(),
      place = /** @type {const} */ ([(event.clientX - box.left) * ratio, (event.clientY - box.top) * ratio]);
    context.lineWidth = 2 * NEAR * ratio;
    return this.walls.findLastIndex((each) => {
      context.beginPath();
      tracePolygons(context, [each], scale, height);
      return context.isPointInPath(...place) || context.isPointInStroke(...place);
    });
  }

  /** @param {Point[][]} walls */
  set(walls) {
    this.drop();
    if (JSON.stringify(walls).length > LONGEST)
      return announce("There are too many walls for this page: write them into the scenario's file.");
    this.change(walls);
  }
}
