// The arena on a canvas: ground and tasks on a layer of their own, robots as small pictures drawn once.

import { contextOf, make } from "./elements.js";
import {
  BYZANTINE,
  DECLARED,
  DISSEMINATING,
  FEASIBLE,
  NEUTRAL,
  NO_TASK,
  opinionOf,
  shadeOf,
  STANDING,
  THERE,
  WORKING,
} from "./frames.js";
import { drawGround, imageOf, outlineOf } from "./ground.js";

const TURN = 65536; // units of a position along the longer side
const DETAILED = 500; // with more robots than this, no ticks
const CROWD = 2000; // with more, squares: on a processor, 10,000 take 20 milliseconds, and pictures 140
const LEAST = 4; // radius of few robots, in CSS pixels
const LOOKS = FEASIBLE | NEUTRAL | DISSEMINATING | DECLARED | WORKING | BYZANTINE; // flags that a picture shows

export class Arena {
  /** @type {Lengths} */
  world; // from open() on
  /** @type {Frame | null} */
  frame = null; // that is drawn
  /** @type {HTMLCanvasElement} */
  ground; // from draw() on

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
    /** @type {Map<number, HTMLCanvasElement>} */
    this.sprites = new Map();
    this.px = new Float32Array(0);
    this.py = new Float32Array(0);
    this.robots = 1; // numbers that they may have
    this.width = this.height = this.longer = this.scale = this.unit = this.radius = this.ratio = 1;
    this.magnified = 1; // times larger than its frame, which scrolls then
    this.isLaid = false; // whether the canvas fits the world and its frame
    this.ranges = false; // of all robots
    this.pointed = this.chosen = -1;
    /** @type {ImageBitmap | null} */
    this.plan = null; // from the moment when it is decoded
    /** @type {[number, number][]} */
    this.sketch = []; // a wall that is being drawn or erased, in units
    this.drawn = 0;
  }

  /** @param {RunHistory} history */
  open({ opened: { lengths }, settings: { sight, radio }, robots }) {
    const { plan } = lengths;
    if (plan?.image !== this.world?.plan?.image) void this.showPlan(plan);
    this.world = { ...lengths, sight, radio };
    this.robots = robots;
    this.pointed = -1;
    this.frame = null;
    this.isLaid = false;
  }

  /** @param {Shades} colours After the theme or the size of the frame has changed. */
  restyle(colours) {
    this.colours = colours;
    this.isLaid = false;
  }

  /** @param {Plan | null} plan */
  async showPlan(plan) {
    this.plan = null;
    if (!plan) return;
    const image = await imageOf(plan);
    if (this.world.plan?.image !== plan.image) return; // another run has begun meanwhile
    this.plan = image;
    this.isLaid = false;
    this.redraw();
  }

  // Fit the canvas into its frame on the page.
  layout() {
    const { canvas, world, magnified } = this,
      { clientWidth, clientHeight } = canvas.parentElement ?? canvas,
      ratio = devicePixelRatio || 1,
      [width, height] = world.size,
      scale = Math.max(0.001, Math.min(clientWidth / width, clientHeight / height)) * magnified,
      room = 0.13 * magnified * Math.sqrt((clientWidth * clientHeight) / Math.max(1, this.robots)),
      least = Math.max(1.1, Math.min(LEAST, room)); // in a large hall, few robots are drawn larger than they are
    this.ratio = ratio;
    this.scale = scale * ratio;
    this.longer = Math.max(width, height);
    this.unit = (this.longer / TURN) * this.scale; // pixels
    this.radius = Math.max(least * ratio, (world.diameter / 2) * this.scale);
    this.width = Math.max(1, Math.round(width * this.scale));
    this.height = Math.max(1, Math.round(height * this.scale));
    if (canvas.width !== this.width || canvas.height !== this.height)
      Object.assign(canvas, { width: this.width, height: this.height });
    canvas.style.width = `${this.width / ratio}px`;
    canvas.style.height = `${this.height / ratio}px`;
    this.sprites.clear();
    this.isLaid = true;
  }

  /**
   * Show the arena larger than its frame, around the robot that is chosen or around the middle.
   * @param {number} times
   */
  zoom(times) {
    const { parentElement: frame } = this.canvas;
    this.magnified = times;
    this.isLaid = false;
    if (!this.frame || !frame) return;
    this.layout();
    const { x, y } = this.frame,
      [across, up] = this.has(this.chosen)
        ? [(x[this.chosen] * this.unit) / this.width, (y[this.chosen] * this.unit) / this.height]
        : [0.5, 0.5];
    frame.scrollTo(
      across * frame.scrollWidth - frame.clientWidth / 2,
      (1 - up) * frame.scrollHeight - frame.clientHeight / 2,
    );
    this.isLaid = false; // the ground isn't painted yet
  }

  /** @param {Frame} now */
  paintGround(now) {
    const { width, height } = this;
    this.ground = make("canvas", { width, height });
    drawGround(contextOf(this.ground, { alpha: false }), this, now);
  }

  /**
   * Draw between two frames.
   * @param {Frame} now
   * @param {Frame} next
   * @param {number} between 0 to 1.
   */
  draw(now, next, between) {
    const { context, frame } = this;
    if (!this.isLaid || now.taskX !== frame?.taskX || now.taken !== frame.taken) {
      if (!this.isLaid) this.layout();
      this.paintGround(now);
    }
    this.place(now, next, between);
    this.frame = now;
    context.drawImage(this.ground, 0, 0);
    for (const each of this.ranges ? now.flags.keys() : [this.pointed, this.chosen])
      if (this.has(each)) this.shadow(each, now.heading[each]);
    this.aims(now);
    if (now.robots > CROWD) this.squares(now);
    else this.discs(now);
    if (this.radius > 2.5 * this.ratio && now.robots <= DETAILED) this.ticks(now);
    if (this.has(this.chosen)) this.ring(this.chosen);
    if (this.sketch.length) this.outline();
    this.canvas.dataset.drawn = String(++this.drawn); // for tests and benchmarks
  }

  /**
   * Return whether a robot has a number in the frame that is drawn.
   * @param {number} robot
   */
  has(robot) {
    return Boolean(this.frame && this.frame.flags[robot] & THERE);
  }

  /**
   * Compute the pixel of each robot; on a torus it moves the shortest way.
   * @param {Frame} now
   * @param {Frame} next
   * @param {number} between
   */
  place(now, next, between) {
    const { unit, width, height, world } = this,
      count = now.robots;
    if (this.px.length !== count) [this.px, this.py] = [new Float32Array(count), new Float32Array(count)];
    const { px, py } = this;
    for (let i = 0; i < count; i++) {
      px[i] = now.x[i] * unit;
      py[i] = height - now.y[i] * unit;
      if (!between || !(now.flags[i] & next.flags[i] & THERE)) continue;
      let dx = (next.x[i] - now.x[i]) * unit,
        dy = (now.y[i] - next.y[i]) * unit;
      if (!world.walls) {
        dx -= width * Math.round(dx / width);
        dy -= height * Math.round(dy / height);
      }
      const x = px[i] + between * dx,
        y = py[i] + between * dy;
      px[i] = x < 0 ? x + width : x >= width ? x - width : x;
      py[i] = y < 0 ? y + height : y >= height ? y - height : y;
    }
  }

  /** @param {Frame} now */
  discs({ flags, robots }) {
    const { context, px, py, width, height, radius } = this,
      reach = 1.7 * radius;
    for (let i = 0; i < robots; i++) {
      if (!this.has(i)) continue;
      const sprite = this.sprite(flags[i] & LOOKS),
        x = px[i] - sprite.width / 2,
        y = py[i] - sprite.width / 2;
      context.drawImage(sprite, x, y);
      if (this.world.walls) continue;
      const dx = px[i] < reach ? width : px[i] > width - reach ? -width : 0,
        dy = py[i] < reach ? height : py[i] > height - reach ? -height : 0;
      if (dx) context.drawImage(sprite, x + dx, y);
      if (dy) context.drawImage(sprite, x, y + dy);
    }
  }

  /** @param {Frame} now */
  squares({ flags, robots }) {
    const { context, px, py, radius, colours } = this;
    /** @type {(opinion: number, colour: string, half: number) => void} */
    const fill = (opinion, colour, half) => {
      context.fillStyle = colour;
      for (let i = 0; i < robots; i++)
        if (this.has(i) && opinionOf(flags[i]) === opinion)
          context.fillRect(px[i] - half, py[i] - half, 2 * half, 2 * half);
    };
    fill(-1, colours.undecided, 0.7 * radius);
    fill(0, colours.infeasible, radius);
    if (radius > 2) fill(0, colours.ground, 0.48 * radius);
    fill(1, colours.feasible, radius);
  }

  /**
   * Return the picture of robots with these flags, drawn once: the opinion as a disc, or a ring if infeasible; a ring around
   * one that disseminates, a dark rim on one that has declared, a square around a Byzantine one, a cross on one that is stopped.
   * @param {number} flags
   */
  sprite(flags) {
    const { sprites, radius, colours } = this,
      half = Math.ceil(1.75 * radius) + 1,
      found = sprites.get(flags);
    if (found) return found;
    const sprite = make("canvas", { width: 2 * half, height: 2 * half }),
      pen = contextOf(sprite),
      opinion = opinionOf(flags);
    /** @param {number} size */
    const disc = (size) => {
      const path = new Path2D();
      path.arc(0, 0, size * radius, 0, 2 * Math.PI);
      return path;
    };
    const wide = (/** @type {number} */ width) => (pen.lineWidth = Math.max(1, width * radius));
    pen.translate(half, half);
    pen.fillStyle = pen.strokeStyle = colours[shadeOf(flags)];
    if (!(flags & WORKING)) pen.globalAlpha = 0.45;
    pen.fill(disc(opinion < 0 ? 0.7 : 1));
    pen.fillStyle = colours.ground;
    if (opinion === 0 && radius > 2) pen.fill(disc(0.48));
    wide(0.2);
    if (flags & DISSEMINATING && radius > 2) pen.stroke(disc(1.5));
    pen.strokeStyle = colours.ink;
    wide(0.3);
    if (flags & DECLARED) pen.stroke(disc(1));
    pen.globalAlpha = 1;
    wide(0.18);
    if (flags & BYZANTINE) pen.strokeRect(-1.15 * radius, -1.15 * radius, 2.3 * radius, 2.3 * radius);
    const arm = 0.75 * radius;
    if (!(flags & WORKING))
      pen.stroke(new Path2D(`M${-arm} ${-arm}L${arm} ${arm}M${arm} ${-arm}L${-arm} ${arm}`));
    sprites.set(flags, sprite);
    return sprite;
  }

  /**
   * Draw a line from each robot to the task to which it walks, and a thick one if it stands there.
   * @param {Frame} now
   */
  aims({ aims, flags, taskX, taskY }) {
    const { context, px, py, unit, width, height, world, ratio } = this;
    context.strokeStyle = this.colours.ink;
    for (const stands of [false, true]) {
      context.lineWidth = stands ? Math.max(2 * ratio, 0.35 * this.radius) : 0.7 * ratio;
      context.beginPath();
      for (let i = 0; i < aims.length; i++) {
        if (!this.has(i) || aims[i] === NO_TASK || Boolean(flags[i] & STANDING) !== stands) continue;
        const x = taskX[aims[i]] * unit,
          y = height - taskY[aims[i]] * unit,
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
      if (!(now.flags[i] & WORKING) || (now.aims[i] ?? NO_TASK) !== NO_TASK) continue;
      const angle = (now.heading[i] * Math.PI) / 128,
        x = Math.cos(angle),
        y = -Math.sin(angle);
      context.moveTo(px[i] + 0.72 * radius * x, py[i] + 0.72 * radius * y);
      context.lineTo(px[i] + 1.28 * radius * x, py[i] + 1.28 * radius * y);
    }
    context.stroke();
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
    const { context, sketch, scale, height, ratio } = this,
      path = outlineOf([sketch], scale, height);
    context.strokeStyle = context.fillStyle = this.colours.infeasible;
    context.lineWidth = 2 * ratio;
    context.globalAlpha = 0.3;
    context.fill(path);
    context.globalAlpha = 1;
    context.stroke(path);
    for (const [x, y] of sketch)
      context.fillRect(x * scale - 3 * ratio, height - y * scale - 3 * ratio, 6 * ratio, 6 * ratio);
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
   * Return a position of the page in pixels of the canvas.
   * @param {Pointer} pointer
   * @returns {[number, number]}
   */
  pixelAt({ clientX, clientY }) {
    const { left, top } = this.canvas.getBoundingClientRect();
    return [(clientX - left) * this.ratio, (clientY - top) * this.ratio];
  }

  /**
   * Return a position of the page in units.
   * @param {Pointer} pointer
   * @returns {[number, number]}
   */
  unitsAt(pointer) {
    const [x, y] = this.pixelAt(pointer);
    return [x / this.scale, (this.height - y) / this.scale];
  }

  /**
   * Return the robot at a position of the page; -1 if none is near.
   * @param {Pointer} pointer
   */
  at(pointer) {
    return this.thingAt(pointer, false)?.number ?? -1;
  }

  /**
   * Return the robot or task at a position of the page, whichever is nearer; null if none is near.
   * @param {Pointer} pointer
   */
  thingAt(pointer, withTasks = true) {
    if (!this.frame) return null;
    const { px, py, unit, height } = this,
      { taskX, taskY, taskNumbers } = this.frame,
      [x, y] = this.pixelAt(pointer);
    let nearest = Math.max(1.8 * this.radius, 10 * this.ratio) ** 2,
      found = /** @type {{kind: "robot" | "task", number: number} | null} */ (null);
    /** @type {(kind: "robot" | "task", number: number, left: number, top: number) => void} */
    const look = (kind, number, left, top) => {
      const squared = (left - x) ** 2 + (top - y) ** 2;
      if (squared < nearest) [nearest, found] = [squared, { kind, number }];
    };
    for (let i = 0; i < px.length; i++) if (this.has(i)) look("robot", i, px[i], py[i]);
    for (let k = 0; withTasks && k < taskX.length; k++)
      look("task", taskNumbers[k], taskX[k] * unit, height - taskY[k] * unit);
    return found;
  }
}
