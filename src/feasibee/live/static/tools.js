// Tools for the pointer in an arena: one at most is in use, and takes the pointer before robots are inspected.

import { $ } from "./elements.js";

/** @import { Arena } from "./arena.js" */
/** @import { Lane } from "./lane.js" */

/** @typedef {[number, number]} Point In units. */
/** @typedef {(event: PointerEvent, arena: Arena) => void} Act */
/**
 * What the pointer does while it is pressed; drop forgets what is half done, and returns whether anything was.
 * @typedef {{help: string, begin?: Act, move?: Act, end: Act, drop: () => boolean}} Tool
 */

export class Tools {
  /**
   * @param {Lane[]} lanes
   * @param {Record<string, Tool>} tools By name; each has a button.
   */
  constructor(lanes, tools) {
    this.tools = tools;
    this.used = "";
    for (const name of Object.keys(tools))
      $(`tool-${name}`).addEventListener("click", () => this.use(this.used === name ? "" : name));
    for (const { frame, arena } of lanes) this.listen(frame, arena);
  }

  /** @returns {Tool | undefined} */
  get tool() {
    return this.tools[this.used];
  }

  /** @param {string} name Of the tool to use from now on; empty for none. */
  use(name) {
    this.tool?.drop();
    this.used = name;
    for (const each of Object.keys(this.tools))
      $(`tool-${each}`).setAttribute("aria-pressed", String(each === name));
    $("tool-help").textContent = this.tool?.help ?? "";
    document.body.dataset.tool = name;
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
        arena.canvas.focus(); // so that space plays, and doesn't press the tool's button
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
