// Tools for the pointer in an arena: one at most is in use, and takes the pointer before robots are inspected.

import { make } from "./elements.js";

export class Tools {
  used = ""; // name of the tool in use
  /** @type {any} */
  held = null;
  /** @type {Record<string, Tool>} */
  tools = {};
  /** @type {Map<string, HTMLElement>} */
  buttons = new Map(); // by name

  /**
   * @param {HTMLElement} group Gets a button for each tool, and the help of that in use.
   * @param {{frame: HTMLElement, arena: Arena}[]} lanes
   * @param {() => void} redraw
   */
  constructor(group, lanes, redraw) {
    this.group = group;
    this.lanes = lanes;
    this.redraw = redraw;
    this.help = group.appendChild(make("p", { className: "muted", role: "status" }));
    for (const each of lanes) this.listen(each);
  }

  /** @param {Record<string, Tool>} tools More of them, by name. */
  add(tools) {
    Object.assign(this.tools, tools);
    for (const [name, { label: textContent }] of Object.entries(tools)) {
      const button = make("button", {
        type: "button",
        className: "quiet",
        textContent,
        ariaPressed: "false",
      });
      button.addEventListener("click", () => this.use(this.used === name ? "" : name));
      this.buttons.set(name, button);
      this.help.before(button);
    }
  }

  /**
   * Offer tools, or don't.
   * @param {string[]} names
   * @param {boolean} isOffered
   */
  offer(names, isOffered) {
    for (const name of names) /** @type {HTMLElement} */ (this.buttons.get(name)).hidden = !isOffered;
    if (this.buttons.get(this.used)?.hidden) this.use("");
  }

  /** @returns {Tool | undefined} */
  get tool() {
    return this.tools[this.used];
  }

  /** @param {string} name Of the tool to use from now on; empty for none. */
  use(name) {
    this.drop();
    this.used = name;
    for (const [each, button] of this.buttons) button.ariaPressed = String(each === name);
    this.help.textContent = this.tool?.help ?? "";
    for (const { frame } of this.lanes) frame.dataset.tool = name;
  }

  // Drop what is half done; return whether anything was.
  drop() {
    const { held } = this;
    this.held = null;
    this.sketch([]);
    return held !== null;
  }

  // Drop what is half done; without it, put the tool away. Return whether there was either.
  leave() {
    const { tool } = this;
    if (tool && !this.drop()) this.use("");
    return Boolean(tool);
  }

  /**
   * Show in all arenas a line or polygon that is being drawn.
   * @param {Point[]} points None takes it away.
   */
  sketch(points) {
    for (const { arena } of this.lanes) arena.sketch = points;
    this.redraw();
  }

  /** @param {{frame: HTMLElement, arena: Arena}} lane */
  listen({ frame, arena }) {
    /** @type {Record<string, (tool: Tool, place: Place, pointer: number) => void>} */
    const handlers = {
      pointerdown: (tool, place, pointer) => {
        frame.setPointerCapture(pointer); // a drag may end outside
        this.buttons.get(this.used)?.blur(); // so that space plays, and doesn't press it
        this.held = tool.begin?.(place) ?? null;
      },
      pointermove: (tool, place) => tool.move?.(place, this.held),
      pointerup: (tool, place) => {
        const { held } = this;
        this.drop();
        tool.end(place, held);
      },
      pointercancel: () => this.drop(),
      mousedown: () => {}, // would select text
      click: () => {},
    };
    for (const [type, act] of Object.entries(handlers))
      frame.addEventListener(
        type,
        (event) => {
          if (!this.tool || !arena.frame) return;
          const { clientX, clientY, pointerId } = /** @type {PointerEvent} */ (event);
          event.preventDefault();
          event.stopImmediatePropagation();
          act(this.tool, { arena, clientX, clientY }, pointerId);
        },
        { capture: true },
      );
  }
}
