// The arena on a canvas: ground and tasks on a layer of their own, robots as small pictures drawn once.

import { Comings } from "./comings.js";
import { Crowd, contextOf } from "./crowd.js";
import { DISSEMINATING, NO_TASK, STANDING, THERE, WORKING } from "./frames.js";
import { drawGround, imageOf, tracePolygons } from "./ground.js";
import { LOOKS, drawSprite } from "./sprites.js";

const TURN = 65536; // units of a position along the longer side
const DETAILED = 2000; // with more robots than this, no ticks, no flashes, no copies beyond the edge
const FLASH = 700; // milliseconds
const LEAST = 4; // radius of few robots, in CSS pixels

/** @import { Frame, Shown } from "./frames.js" */
/** @import { Plan } from "./ground.js" */
/** @import { Shades } from "./theme.js" */

/**
 * The world of a swarm, from the server.
 * @typedef {object} World
 * @property {[number, number]} size
 * @property {boolean} walls
 * @property {Plan | null} plan
 * @property {number} diameter
 * @property {number} sight
 * @property {number} view In degrees.
 * @property {number} radio
 * @property {number} robots At the start.
 * @property {number} numbers That robots may have.
 * @property {number} tasks At the start.
 * @property {boolean} truth At the start.
 * @property {boolean} changes Whether robots or tasks may come and go.
 * @property {number} last
 * @property {boolean} declares
 * @property {boolean} [acts] Whether robots go to tasks and do them.
 * @property {string[]} [robotClasses]
 * @property {number[]} [kinds] Class of each robot, by number.
 */

/**
 * A run that has begun, from the server; see opened() in session.py.
 * @typedef {World & {
 *   generation: number, request: number | null, seed: string, run: string, fields: Record<string, string | number | boolean>,
 *   fixed: string, events: ({step: number} & Record<string, any>)[], toml: string, proof: string, threshold: number,
 *   drawn: [number, number][][], cell: number, lane: number, strategy: string, swarms: number, field?: {address: string, hz: number | null},
 * }} Opened
 */

/**
 * What to draw: a frame, the next frame if any, and the time between them, 0 to 1; calm: without flashes.
 * @typedef {{now: Frame, next: Frame | null, between: number, calm: boolean}} View
 */

export class Arena {
  /** @type {World} */
  world; // from open() on
  /** @type {HTMLCanvasElement} */
  ground; // from layout() on

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Shades} colours
   * @param {() => void} redraw The ground is another one.
   */
  constructor(canvas, colours, redraw) {
    this.canvas = canvas;
    this.context = contextOf(canvas, { alpha: false });
    this.colours = colours;
    this.redraw = redraw;
    /** @type {Shown | null} */
    this.tasks = null;
    this.crowd = new Crowd();
    this.comings = new Comings();
    /** @type {Map<number, number>} */
    this.flashes = new Map(); // start time, by robot
    /** @type {Map<number, HTMLCanvasElement>} */
    this.sprites = new Map();
    /** @type {Frame | null} */
    this.before = null;
    this.px = new Float32Array(0);
    this.py = new Float32Array(0);
    /** @type {Uint16Array} */
    this.flags = new Uint16Array(0); // of the frame that is drawn
    this.width = this.height = this.longer = this.scale = this.unit = this.radius = this.ratio = 1;
    this.ranges = false; // of all robots
    this.pointed = this.chosen = -1;
    /** @type {ImageBitmap | null} */
    this.plan = null; // from the moment when it is decoded
    /** @type {[number, number][]} */
    this.sketch = []; // a wall that is being drawn or erased, in units
    this.drawn = 0;
  }

  /** @param {World} world */
  open(world) {
    this.longer = Math.max(...world.size);
    this.tasks = null;
    this.pointed = -1;
    this.flashes.clear();
    this.comings = new Comings();
    this.before = null;
    if (world.plan?.image !== this.world?.plan?.image) this.showPlan(world.plan);
    this.world = world;
    this.layout();
  }

  /** @param {Plan | null} plan */
  async showPlan(plan) {
    this.plan = null;
    if (!plan) return;
    const image = await imageOf(plan);
    if (this.world.plan?.image !== plan.image) return; // another run has begun meanwhile
    this.plan = image;
    this.paintGround();
    this.redraw();
  }

  /** @param {Shown} tasks */
  setTasks(tasks) {
    this.tasks = tasks;
    this.paintGround();
  }

  /** @param {Shades} colours */
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
    const room = 0.13 * Math.sqrt((clientWidth * clientHeight) / Math.max(1, this.world.numbers)),
      least = Math.max(1.1, Math.min(LEAST, room)); // in a large hall, few robots are drawn larger than they are
    this.radius = Math.max(least * ratio, (this.world.diameter / 2) * this.scale);
    this.ratio = ratio;
    this.sprites = new Map();
    this.paintGround();
  }

  paintGround() {
    const { width, height } = this;
    const ground = (this.ground = document.createElement("canvas"));
    ground.width = width;
    ground.height = height;
    const crowded = this.world.numbers > DETAILED;
    const context = contextOf(ground, { alpha: false, willReadFrequently: crowded });
    drawGround(context, this);
    if (crowded) this.crowd.reset(ground);
  }

  /**
   * Draw between two frames; return whether a flash still moves.
   * @param {View} view
   * @param {number} time
   */
  draw({ now, next, between, calm }, time) {
    const { context } = this;
    this.place(now, next, between);
    this.flags = now.flags;
    if (now !== this.before) this.notice(now, calm ? Infinity : time);
    const shadowed = (this.ranges ? [...this.flags.keys()] : [this.pointed, this.chosen]).filter((each) =>
      this.has(each),
    );
    if (now.robots > DETAILED) {
      this.crowd.draw(context, this.px, this.py, now.flags, LOOKS, (looks) => this.sprite(looks));
      for (const each of shadowed) this.shadow(each, now.heading[each]);
    } else {
      context.drawImage(this.ground, 0, 0);
      for (const each of shadowed) this.shadow(each, now.heading[each]);
      this.aims(now);
      this.flash(time);
      this.robots(now);
      if (this.radius > 2.5 * this.ratio) this.ticks(now);
    }
    if (this.has(this.chosen)) this.ring(this.chosen);
    if (this.sketch.length) this.outline();
    context.strokeStyle = this.colours.ink;
    this.comings.draw(context, this, time);
    this.canvas.dataset.drawn = String(++this.drawn); // for tests and benchmarks
    return this.flashes.size > 0 || this.comings.rings.length > 0;
  }

  /**
   * Return whether a robot has a number in the frame that is drawn.
   * @param {number} robot
   */
  has(robot) {
    return Boolean(this.flags[robot] & THERE);
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
      if (!(now.flags[i] & next.flags[i] & THERE)) continue;
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
   * Start a flash for each robot that has begun to disseminate, and rings around what has come or gone.
   * @param {Frame} now
   * @param {number} time Infinity for no flashes: faster, they would only flicker.
   */
  notice(now, time) {
    const old = this.before;
    if (old && time < Infinity && now.step > old.step && now.robots <= DETAILED / 4) {
      for (let i = 0; i < now.robots; i++)
        if (now.flags[i] & ~old.flags[i] & DISSEMINATING) this.flashes.set(i, time);
      if (this.world.changes) this.comings.notice(old, now, time);
    }
    const { taken, taskX: x, taskY: y } = now,
      shown = this.tasks,
      places = this.world.changes ? { x, y, numbers: now.taskNumbers } : shown,
      isShown = shown && places && isSame(shown.x, places.x) && isSame(shown.y, places.y);
    if (places && !(isShown && (!taken || (shown.taken && isSame(shown.taken, taken)))))
      this.setTasks({ ...places, taken });
    this.before = now;
  }

  /** @param {Frame} now */
  robots(now) {
    const { context, px, py, width, height, radius } = this,
      { flags, robots } = now;
    const reach = 1.7 * radius;
    for (let i = 0; i < robots; i++) {
      if (!this.has(i)) continue;
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

  /**
   * Draw a line from each robot to the task to which it walks, and a thick one if it stands there.
   * @param {Frame} now
   */
  aims({ aims, flags }) {
    const { context, px, py, unit, width, height, world, tasks, ratio } = this;
    if (!aims || !tasks) return;
    context.strokeStyle = this.colours.ink;
    for (const stands of [false, true]) {
      context.lineWidth = stands ? Math.max(2 * ratio, 0.35 * this.radius) : 0.7 * ratio;
      context.beginPath();
      for (let i = 0; i < aims.length; i++) {
        if (!this.has(i) || aims[i] === NO_TASK || Boolean(flags[i] & STANDING) !== stands) continue;
        const x = tasks.x[aims[i]] * unit,
          y = height - tasks.y[aims[i]] * unit,
          across = world.walls ? 0 : width * Math.round((x - px[i]) / width),
          along = world.walls ? 0 : height * Math.round((y - py[i]) / height);
        context.moveTo(px[i], py[i]);
        context.lineTo(x - across, y - along);
        if (!across && !along) continue;
        context.moveTo(px[i] + across, py[i] + along);
        context.lineTo(x, y);
      }
      context.stroke();
    }
  }

  /** @param {Frame} now */
  ticks(now) {
    const { context, px, py, radius } = this;
    context.strokeStyle = this.colours.ink;
    context.lineWidth = Math.max(this.ratio, 0.16 * radius);
    context.beginPath();
    for (let i = 0; i < now.robots; i++) {
      if (!(now.flags[i] & WORKING) || (now.aims?.[i] ?? NO_TASK) !== NO_TASK) continue;
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
      if (age >= 1 || !this.has(i)) {
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
   * Draw what a robot sees of its surroundings, and its radio range if it differs.
   * @param {number} i
   * @param {number} heading Of 256 directions.
   */
  shadow(i, heading) {
    const { context, world } = this;
    context.fillStyle = context.strokeStyle = this.colours.ink;
    context.globalAlpha = 0.1;
    const towards = (-heading * Math.PI) / 128,
      half = (world.view * Math.PI) / 360;
    this.circles(this.px[i], this.py[i], world.sight * this.scale, towards - half, towards + half);
    context.fill();
    context.globalAlpha = 0.45;
    context.lineWidth = this.ratio;
    if (world.radio !== world.sight || world.view < 360) {
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

  // Draw the wall that is being drawn or erased, with its corners.
  outline() {
    const { context, sketch, scale, height, ratio } = this;
    context.strokeStyle = context.fillStyle = this.colours.infeasible;
    context.lineWidth = 2 * ratio;
    context.beginPath();
    tracePolygons(context, [sketch], scale, height);
    context.globalAlpha = 0.3;
    context.fill();
    context.globalAlpha = 1;
    context.stroke();
    for (const [x, y] of sketch)
      context.fillRect(x * scale - 3 * ratio, height - y * scale - 3 * ratio, 6 * ratio, 6 * ratio);
  }

  /**
   * Return the place in units at a position of the page.
   * @param {number} clientX
   * @param {number} clientY
   * @returns {[number, number]}
   */
  unitsAt(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect(),
      [width, height] = this.world.size;
    return [((clientX - box.left) / box.width) * width, (1 - (clientY - box.top) / box.height) * height];
  }

  /**
   * Begin a path of a circle, or a sector of it, and of its copies across the edges of a torus.
   * @param {number} x
   * @param {number} y
   * @param {number} radius
   */
  circles(x, y, radius, from = 0, to = 2 * Math.PI) {
    const { context, width, height } = this;
    context.beginPath();
    const around = this.world.walls || radius > Math.min(width, height) / 2 ? [0] : [-1, 0, 1];
    for (const across of around)
      for (const along of around) {
        const left = x + across * width,
          top = y + along * height;
        if (left < -radius || left > width + radius || top < -radius || top > height + radius) continue;
        if (to - from < 2 * Math.PI - 1e-9) context.moveTo(left, top);
        else context.moveTo(left + radius * Math.cos(from), top + radius * Math.sin(from));
        context.arc(left, top, radius, from, to);
        context.closePath();
      }
  }

  /**
   * Return the robot at a position of the page; -1 if none is near.
   * @param {number} clientX
   * @param {number} clientY
   */
  at(clientX, clientY) {
    if (!this.world) return -1;
    return this.nearestRobot(clientX, clientY)[1];
  }

  /**
   * Return the robot or task at a position of the page, whichever is nearer; null if none is near.
   * @param {number} clientX
   * @param {number} clientY
   * @returns {{kind: "robot" | "task", number: number} | null}
   */
  thingAt(clientX, clientY) {
    const { x = [], y = [], numbers } = this.tasks ?? {},
      [far, robot] = this.nearestRobot(clientX, clientY),
      [near, task] = this.nearest(
        clientX,
        clientY,
        Float32Array.from(x, (each) => each * this.unit),
        Float32Array.from(y, (each) => this.height - each * this.unit),
      );
    if (task >= 0 && near < far) return { kind: "task", number: numbers?.length ? numbers[task] : task };
    return robot < 0 ? null : { kind: "robot", number: robot };
  }

  /**
   * @param {number} clientX
   * @param {number} clientY
   */
  nearestRobot(clientX, clientY) {
    return this.nearest(clientX, clientY, this.px, this.py, (i) => this.has(i));
  }

  /**
   * Return the square of the distance of the pixel nearest to a position of the page, and which it is; -1 if none is near.
   * @param {number} clientX
   * @param {number} clientY
   * @param {Float32Array} px
   * @param {Float32Array} py
   */
  nearest(clientX, clientY, px, py, isThere = (/** @type {number} */ _) => true) {
    const box = this.canvas.getBoundingClientRect(),
      x = (clientX - box.left) * this.ratio,
      y = (clientY - box.top) * this.ratio;
    let found = -1,
      nearest = Math.max(1.8 * this.radius, 10 * this.ratio) ** 2;
    for (let i = 0; i < px.length; i++) {
      const squared = (px[i] - x) ** 2 + (py[i] - y) ** 2;
      if (squared < nearest && isThere(i)) [nearest, found] = [squared, i];
    }
    return [nearest, found];
  }

  /**
   * Let the pointer show what a robot senses.
   * @param {HTMLElement} frame
   * @param {() => void} redraw
   */
  followPointer(frame, redraw) {
    for (const type of /** @type {const} */ (["pointermove", "pointerdown", "pointerleave"]))
      frame.addEventListener(type, ({ clientX, clientY }) => {
        const robot = type === "pointerleave" ? -1 : this.at(clientX, clientY);
        if (robot !== this.pointed) redraw();
        this.pointed = robot;
      });
  }
}

/**
 * @param {Uint16Array | Uint8Array} one
 * @param {Uint16Array | Uint8Array} other
 */
function isSame(one, other) {
  return one.length === other.length && one.every((each, k) => each === other[k]);
}
