// Tools for the pointer in an arena: one at most is in use, and takes the pointer before robots are inspected.

import { make } from "./elements.js";

/** @import { Arena } from "./arena.js" */

/** @typedef {[number, number]} Point In units. */
/** @typedef {(event: PointerEvent, arena: Arena) => void} Act */
/**
 * What the pointer does while it is pressed; drop forgets what is half done, and returns whether anything was.
 * @typedef {{label: string, help: string, begin?: Act, move?: Act, end: Act, drop: () => boolean}} Tool
 */

/**
 * Return what shows in all arenas a line or polygon that is being drawn; none at all takes it away.
 * @param {{arena: Arena}[]} lanes
 * @param {() => void} redraw
 * @returns {(sketch: Point[]) => void}
 */
export function sketching(lanes, redraw) {
  return (sketch) => {
    for (const { arena } of lanes) arena.sketch = sketch;
    redraw();
  };
}

export class Tools {
  /**
   * @param {HTMLElement} group Gets a button for each tool, and the help of that in use.
   * @param {{frame: HTMLElement, arena: Arena}[]} lanes
   * @param {Record<string, Tool>} tools By name.
   */
  constructor(group, lanes, tools) {
    this.tools = tools;
    this.lanes = lanes;
    this.used = "";
    this.help = make("p", { className: "muted", role: "status" });
    /** @type {Map<string, HTMLElement>} */
    this.buttons = new Map();
    for (const [name, { label }] of Object.entries(tools)) {
      const button = make("button", {
        type: "button",
        className: "quiet",
        textContent: label,
        ariaPressed: "false",
      });
      button.addEventListener("click", () => this.use(this.used === name ? "" : name));
      this.buttons.set(name, button);
    }
    group.append(...this.buttons.values(), this.help);
    for (const { frame, arena } of lanes) this.listen(frame, arena);
  }

  /**
   * Offer only some of the tools.
   * @param {(name: string) => boolean} isOffered
   */
  offer(isOffered) {
    for (const [name, button] of this.buttons) button.hidden = !isOffered(name);
    if (this.buttons.get(this.used)?.hidden) this.use("");
  }

  /** @returns {Tool | undefined} */
  get tool() {
    return this.tools[this.used];
  }

  /** @param {string} name Of the tool to use from now on; empty for none. */
  use(name) {
    this.tool?.drop();
    this.used = name;
    for (const [each, button] of this.buttons) button.ariaPressed = String(each === name);
    this.help.textContent = this.tool?.help ?? "";
    for (const { frame } of this.lanes) frame.dataset.tool = name;
  }

  // Drop what is half done; without it, put the tool away. Return whether there was either.
  leave() {
    const { tool } = this;
    if (tool && !tool.drop()) this.use("");
    return Boolean(tool);
  }

  /**
   * @param {HTMLElement} frame
   * @param {Arena} arena
   */
  listen(frame, arena) {
    /** @type {Record<string, (tool: Tool, event: PointerEvent) => void>} */
    const handlers = {
      pointerdown: (tool, event) => {
        frame.setPointerCapture(event.pointerId); // a drag may end outside
        this.buttons.get(this.used)?.blur(); // so that space plays, and doesn't press it
        frame.focus(); // where it can have the focus
        tool.begin?.(event, arena);
      },
      pointermove: (tool, event) => tool.move?.(event, arena),
      pointerup: (tool, event) => tool.end(event, arena),
      pointercancel: (tool) => tool.drop(),
      mousedown: () => {}, // would select text
      click: () => {},
    };
    for (const [type, act] of Object.entries(handlers))
      frame.addEventListener(
        type,
        (event) => {
          if (!this.tool || !arena.world) return;
          event.preventDefault();
          event.stopImmediatePropagation();
          act(this.tool, /** @type {PointerEvent} */ (event));
        },
        { capture: true },
      );
  }
}
