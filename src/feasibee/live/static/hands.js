// Add tasks and robots at points, move them and take them away, with the pointer: each is an event of the scenario.

/** @import { Arena } from "./arena.js" */
/** @import { Change } from "./touching.js" */
/** @import { Point, Tool } from "./tools.js" */

/** @typedef {{kind: "robot" | "task", number: number, from: Point}} Thing */

export class Hands {
  /**
   * @param {(change: Change, told: string) => void} happen Let an event happen.
   * @param {(sketch: Point[]) => void} sketch
   * @param {(text: string) => void} say
   */
  constructor(happen, sketch, say) {
    this.say = say;
    this.happen = happen;
    this.sketch = sketch;
    /** @type {Thing | null} */
    this.held = null;
    const drop = () => this.drop();
    /** @type {Record<string, Tool>} */
    this.tools = {
      task: {
        label: "Add tasks",
        help: "Click where a task is to appear.",
        end: (...at) => this.add("task", ...at),
        drop,
      },
      robot: {
        label: "Add robots",
        help: "Click where a robot is to join.",
        end: (...at) => this.add("robot", ...at),
        drop,
      },
      move: {
        label: "Move",
        help: "Drag a robot or a task to another place.",
        begin: (event, arena) => (this.held = this.thingAt(event, arena)),
        move: (event, arena) => this.carry(event, arena),
        end: (event, arena) => this.put(event, arena),
        drop,
      },
      remove: {
        label: "Remove",
        help: "Click a robot or a task to take it away.",
        end: (...at) => this.take(this.thingAt(...at)),
        drop,
      },
    };
  }

  // Let go of what is held; return whether anything was.
  drop() {
    const { held } = this;
    this.held = null;
    this.sketch([]);
    return Boolean(held);
  }

  /**
   * Return the robot or task nearest to the pointer, if any is near.
   * @param {PointerEvent} event
   * @param {Arena} arena
   * @returns {Thing | null}
   */
  thingAt({ clientX, clientY }, arena) {
    const found = arena.thingAt(clientX, clientY);
    if (!found) this.say("There is no robot or task.");
    return found && { ...found, from: arena.unitsAt(clientX, clientY) };
  }

  /**
   * Return the place of the pointer, within what the scenario allows.
   * @param {PointerEvent} event
   * @param {Arena} arena
   * @param {"robot" | "task"} kind
   * @returns {Point}
   */
  placeAt({ clientX, clientY }, arena, kind) {
    const { size, walls, diameter } = arena.world,
      margin = walls && kind === "robot" ? diameter / 2 : 0,
      edge = walls ? margin : arena.longer / 1e4; // on a torus, the far edge is the near one
    const [x, y] = arena
      .unitsAt(clientX, clientY)
      .map((each, k) => Math.max(margin, Math.min(size[k] - edge, Number(each.toPrecision(4)))));
    return [x, y];
  }

  /**
   * @param {"robot" | "task"} kind
   * @param {PointerEvent} event
   * @param {Arena} arena
   */
  add(kind, event, arena) {
    this.happen({ [`${kind}s`]: 1, at: this.placeAt(event, arena, kind) }, `one more ${kind}`);
  }

  /**
   * @param {PointerEvent} event
   * @param {Arena} arena
   */
  carry(event, arena) {
    if (this.held) this.sketch([this.held.from, this.placeAt(event, arena, this.held.kind)]);
  }

  /**
   * @param {PointerEvent} event
   * @param {Arena} arena
   */
  put(event, arena) {
    const { held } = this;
    this.drop();
    if (!held) return;
    const { kind, number } = held;
    this.happen({ [kind]: number, at: this.placeAt(event, arena, kind) }, `${kind} ${number} is elsewhere`);
  }

  /** @param {Pick<Thing, "kind" | "number"> | null} thing */
  take(thing) {
    if (thing) this.happen({ [thing.kind]: thing.number }, `${thing.kind} ${thing.number} is gone`);
  }
}
