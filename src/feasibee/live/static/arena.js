// The arena on a canvas: ground and tasks on a layer of their own, robots as small pictures drawn once.

import { Crowd, contextOf } from "./crowd.js";
import { DISSEMINATING, WORKING } from "./frames.js";
import { LOOKS, drawSprite } from "./sprites.js";

const TURN = 65536; // units of a position along the longer side
const DETAILED = 2000; // with more robots than this, no ticks, no flashes, no copies beyond the edge
const FLASH = 700; // milliseconds

/** @import { Frame, Tasks } from "./frames.js" */

/**
 * The world of a swarm, from the server.
 * @typedef {object} World
 * @property {[number, number]} size
 * @property {boolean} walls
 * @property {number} diameter
 * @property {number} sight
 * @property {number} radio
 * @property {number} robots
 * @property {number} tasks
 * @property {boolean} truth
 * @property {number} last
 * @property {boolean} declares
 */

/**
 * A run that has begun, from the server; see opened() in session.py.
 * @typedef {World & {
 *   generation: number, seed: string, run: string, fields: Record<string, string | number | boolean>,
 *   toml: string, proof: string, robotClasses: [string, number][], threshold: number,
 *   counted: [number, number], stopStep: number, commits: boolean, lane: number, strategy: string, swarms: number,
 * }} Opened
 */

/** @typedef {"ground" | "line" | "ink" | "feasible" | "infeasible" | "undecided" | "task"} Colour */
/** @typedef {Record<Colour, string>} Colours */

/**
 * What to draw: a frame, the next frame if any, and the time between them, 0 to 1.
 * @typedef {object} View
 * @property {Frame} now
 * @property {Frame | null} next
 * @property {number} between
 */

export class Arena {
  /** @type {World} */
  world; // from open() on
  /** @type {HTMLCanvasElement} */
  ground; // from layout() on

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Colours} colours
   */
  constructor(canvas, colours) {
    this.canvas = canvas;
    this.context = contextOf(canvas, { alpha: false });
    this.colours = colours;
    /** @type {Tasks | null} */
    this.tasks = null;
    this.crowd = new Crowd();
    /** @type {Map<number, number>} */
    this.flashes = new Map(); // start time, by robot
    /** @type {Map<number, HTMLCanvasElement>} */
    this.sprites = new Map();
    /** @type {Frame | null} */
    this.before = null;
    this.px = new Float32Array(0);
    this.py = new Float32Array(0);
    this.width = this.height = this.longer = this.scale = this.unit = this.radius = this.ratio = 1;
    this.calm = false;
    this.pointed = this.chosen = -1;
    this.drawn = 0;
  }

  /** @param {World} world */
  open(world) {
    this.world = world;
    this.longer = Math.max(...world.size);
    this.tasks = null;
    this.pointed = -1;
    this.flashes.clear();
    this.before = null;
    this.layout();
  }

  /** @param {Tasks} tasks */
  setTasks(tasks) {
    this.tasks = tasks;
    this.paintGround();
  }

  /** @param {Colours} colours */
  setColours(colours) {
    this.colours = colours;
    if (this.world) this.layout();
  }

  // Fit the canvas into its frame on the page.
  layout() {
    const { clientWidth, clientHeight } = this.canvas.parentElement ?? this.canvas,
      ratio = devicePixelRatio || 1;
    const [width, height] = this.world.size;
    const scale = Math.max(0.001, Math.min(clientWidth / width, clientHeight / height));
    this.scale = scale * ratio;
    this.width = Math.max(1, Math.round(width * this.scale));
    this.height = Math.max(1, Math.round(height * this.scale));
    if (this.canvas.width !== this.width || this.canvas.height !== this.height) {
      this.canvas.width = this.width;
      this.canvas.height = this.height;
    }
    this.canvas.style.width = `${this.width / ratio}px`;
    this.canvas.style.height = `${this.height / ratio}px`;
    this.unit = (this.longer / TURN) * this.scale; // pixels
    this.radius = Math.max(1.1 * ratio, (this.world.diameter / 2) * this.scale);
    this.ratio = ratio;
    this.sprites = new Map();
    this.paintGround();
  }

  paintGround() {
    const { width, height, colours, scale, ratio } = this;
    const ground = (this.ground = document.createElement("canvas"));
    ground.width = width;
    ground.height = height;
    const crowded = this.world.robots > DETAILED;
    const context = contextOf(ground, { alpha: false, willReadFrequently: crowded });
    context.fillStyle = colours.ground;
    context.fillRect(0, 0, width, height);
    context.strokeStyle = colours.line;
    context.lineWidth = ratio;
    context.beginPath();
    const gap =
      10 ** Math.ceil(Math.log10(this.longer / 15)) /
      (this.longer / 10 ** Math.floor(Math.log10(this.longer)) < 3 ? 2 : 1);
    for (let at = gap; at * scale < Math.max(width, height) - 1; at += gap) {
      const x = Math.round(at * scale) + 0.5,
        y = Math.round(height - at * scale) + 0.5;
      context.moveTo(x, 0);
      context.lineTo(x, height);
      context.moveTo(0, y);
      context.lineTo(width, y);
    }
    context.stroke();
    if (this.tasks) this.paintTasks(context, this.tasks);
    if (this.world.walls) {
      context.strokeStyle = colours.ink;
      context.lineWidth = 6 * ratio; // half of it is outside
      context.strokeRect(0, 0, width, height);
    }
    if (crowded) this.crowd.reset(ground);
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {Tasks} tasks
   */
  paintTasks(context, { x, y }) {
    const size = Math.max(1.5 * this.ratio, Math.min(0.42 * this.scale, 9 * this.ratio));
    context.fillStyle = this.colours.task;
    if (size < 4 * this.ratio) context.globalAlpha = 0.5; // many tasks would hide the robots
    context.beginPath();
    for (let i = 0; i < x.length; i++) {
      const left = x[i] * this.unit,
        top = this.height - y[i] * this.unit;
      context.moveTo(left, top - size);
      context.lineTo(left + 0.92 * size, top + 0.66 * size);
      context.lineTo(left - 0.92 * size, top + 0.66 * size);
      context.closePath();
    }
    context.fill();
    context.globalAlpha = 1;
    if (size > 4 * this.ratio) {
      context.strokeStyle = this.colours.ground;
      context.lineWidth = 0.8 * this.ratio;
      context.stroke();
    }
  }

  /**
   * Draw between two frames; return whether a flash still moves.
   * @param {View} view
   * @param {number} time
   */
  draw({ now, next, between }, time) {
    const { context } = this;
    this.place(now, next, between);
    if (now !== this.before) this.notice(now, time);
    const shadowed = [this.pointed, this.chosen].filter((each) => each >= 0 && each < now.robots);
    if (now.robots > DETAILED) {
      this.crowd.draw(context, this.px, this.py, now.flags, LOOKS, (looks) => this.sprite(looks));
      for (const each of shadowed) this.shadow(each);
    } else {
      context.drawImage(this.ground, 0, 0);
      for (const each of shadowed) this.shadow(each);
      this.flash(time);
      this.robots(now);
      if (this.radius > 2.5 * this.ratio) this.ticks(now);
    }
    if (this.chosen >= 0 && this.chosen < now.robots) this.ring(this.chosen);
    this.canvas.dataset.drawn = String(++this.drawn); // for tests and benchmarks
    return this.flashes.size > 0;
  }

  /**
   * Compute the pixel of each robot; on a torus it moves the shortest way.
   * @param {Frame} now
   * @param {Frame | null} next
   * @param {number} between
   */
  place(now, next, between) {
    const count = now.robots;
    if (this.px.length !== count) {
      this.px = new Float32Array(count);
      this.py = new Float32Array(count);
    }
    const { px, py, unit, width, height, world } = this;
    for (let i = 0; i < count; i++) {
      px[i] = now.x[i] * unit;
      py[i] = height - now.y[i] * unit;
    }
    if (!next) return;
    const wraps = !world.walls,
      halfX = width / 2,
      halfY = height / 2;
    for (let i = 0; i < count; i++) {
      let dx = (next.x[i] - now.x[i]) * unit,
        dy = (now.y[i] - next.y[i]) * unit;
      if (wraps) {
        dx -= dx > halfX ? width : dx < -halfX ? -width : 0;
        dy -= dy > halfY ? height : dy < -halfY ? -height : 0;
      }
      const x = px[i] + between * dx,
        y = py[i] + between * dy;
      px[i] = x < 0 ? x + width : x >= width ? x - width : x;
      py[i] = y < 0 ? y + height : y >= height ? y - height : y;
    }
  }

  /**
   * Start a flash for each robot that has begun to disseminate.
   * @param {Frame} now
   * @param {number} time
   */
  notice(now, time) {
    const old = this.before;
    if (old && !this.calm && now.step > old.step && now.robots <= DETAILED / 4) {
      for (let i = 0; i < now.robots; i++)
        if (now.flags[i] & ~old.flags[i] & DISSEMINATING) this.flashes.set(i, time);
    }
    this.before = now;
  }

  /** @param {Frame} now */
  robots(now) {
    const { context, px, py, width, height, radius } = this,
      { flags, robots } = now;
    const reach = 1.7 * radius;
    for (let i = 0; i < robots; i++) {
      const sprite = this.sprite(flags[i] & LOOKS);
      const half = sprite.width / 2,
        x = px[i],
        y = py[i];
      context.drawImage(sprite, x - half, y - half);
      if (this.world.walls) continue;
      const dx = x < reach ? width : x > width - reach ? -width : 0;
      const dy = y < reach ? height : y > height - reach ? -height : 0;
      if (dx) context.drawImage(sprite, x + dx - half, y - half);
      if (dy) context.drawImage(sprite, x - half, y + dy - half);
    }
  }

  /**
   * Return the picture of robots with these flags, drawn once.
   * @param {number} flags
   */
  sprite(flags) {
    let sprite = this.sprites.get(flags);
    if (!sprite) this.sprites.set(flags, (sprite = drawSprite(flags, this.radius, this.colours)));
    return sprite;
  }

  /** @param {Frame} now */
  ticks(now) {
    const { context, px, py, radius } = this;
    context.strokeStyle = this.colours.ink;
    context.lineWidth = Math.max(this.ratio, 0.16 * radius);
    context.beginPath();
    for (let i = 0; i < now.robots; i++) {
      if (!(now.flags[i] & WORKING)) continue;
      const angle = (now.heading[i] * Math.PI) / 128,
        x = Math.cos(angle),
        y = -Math.sin(angle);
      context.moveTo(px[i] + 0.72 * radius * x, py[i] + 0.72 * radius * y);
      context.lineTo(px[i] + 1.28 * radius * x, py[i] + 1.28 * radius * y);
    }
    context.stroke();
  }

  /** @param {number} time */
  flash(time) {
    const { context } = this,
      reach = this.world.radio * this.scale;
    context.strokeStyle = this.colours.ink;
    context.lineWidth = this.ratio;
    for (const [i, begun] of this.flashes) {
      const age = (time - begun) / FLASH;
      if (age >= 1) {
        this.flashes.delete(i);
        continue;
      }
      context.globalAlpha = 0.35 * (1 - age);
      this.circles(this.px[i], this.py[i], this.radius + (reach - this.radius) * Math.sqrt(Math.max(0, age)));
      context.stroke();
    }
    context.globalAlpha = 1;
  }

  /**
   * Draw the sensing range of a robot, and its radio range if it differs.
   * @param {number} i
   */
  shadow(i) {
    const { context, world } = this;
    context.fillStyle = context.strokeStyle = this.colours.ink;
    context.globalAlpha = 0.1;
    this.circles(this.px[i], this.py[i], world.sight * this.scale);
    context.fill();
    context.globalAlpha = 0.45;
    context.lineWidth = this.ratio;
    if (world.radio !== world.sight) {
      context.setLineDash([4 * this.ratio, 4 * this.ratio]);
      this.circles(this.px[i], this.py[i], world.radio * this.scale);
    }
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  /** @param {number} i The robot that is inspected. */
  ring(i) {
    this.context.strokeStyle = this.colours.ink;
    this.context.lineWidth = 2 * this.ratio;
    this.circles(this.px[i], this.py[i], 2.1 * this.radius);
    this.context.stroke();
  }

  /**
   * Begin a path of a circle and of its copies across the edges of a torus.
   * @param {number} x
   * @param {number} y
   * @param {number} radius
   */
  circles(x, y, radius) {
    const { context, width, height } = this;
    context.beginPath();
    const around = this.world.walls || radius > Math.min(width, height) / 2 ? [0] : [-1, 0, 1];
    for (const across of around)
      for (const along of around) {
        const left = x + across * width,
          top = y + along * height;
        if (left < -radius || left > width + radius || top < -radius || top > height + radius) continue;
        context.moveTo(left + radius, top);
        context.arc(left, top, radius, 0, 2 * Math.PI);
      }
  }

  /**
   * Return the robot at a position of the page; -1 if none is near.
   * @param {number} clientX
   * @param {number} clientY
   */
  at(clientX, clientY) {
    if (!this.world) return -1;
    const box = this.canvas.getBoundingClientRect();
    const x = (clientX - box.left) * this.ratio,
      y = (clientY - box.top) * this.ratio;
    let found = -1,
      nearest = Math.max(1.8 * this.radius, 10 * this.ratio) ** 2;
    for (let i = 0; i < this.px.length; i++) {
      const squared = (this.px[i] - x) ** 2 + (this.py[i] - y) ** 2;
      if (squared < nearest) [nearest, found] = [squared, i];
    }
    return found;
  }

  /**
   * Return a robot's position on the canvas, in CSS pixels.
   * @param {number} i
   * @returns {[number, number]}
   */
  placeOf(i) {
    return [this.px[i] / this.ratio, this.py[i] / this.ratio];
  }
}
