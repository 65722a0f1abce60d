// The arena in a notebook: canvas and clock of the page, few controls, the kernel in place of the server; see widget.py.

import { Arena } from "./arena.js";
import { decode } from "./frames.js";
import { Player, SPEEDS } from "./player.js";

/** @import { Colours, World } from "./arena.js" */
/** @import { Frame, Tasks } from "./frames.js" */

/**
 * The Python side, from anywidget; traits by name.
 * @typedef {object} Model
 * @property {(name: string) => any} get
 * @property {(name: string, value: unknown) => void} set
 * @property {() => void} save_changes
 * @property {(content: object) => void} send
 * @property {(event: string, hear: (...given: any[]) => void) => void} on
 * @property {(event: string, hear: (...given: any[]) => void) => void} off
 */

/** @type {(keyof Colours)[]} */
const PAINTS = ["ground", "line", "ink", "feasible", "infeasible", "undecided", "task"];
const PATIENCE = 2000; // milliseconds after which a waiting view says so
/** @type {Record<number, string>} */
const OUTCOMES = { 1: "feasible", 0: "infeasible", [-1]: "nothing" };
const SHAPE = `<style>
  .arena {
    --ground: var(--jp-layout-color0, light-dark(#fdfdfc, #0c0f11));
    --ink: var(--jp-ui-font-color1, light-dark(#1d2125, #e6e9eb));
    --line: light-dark(#ebe9e4, #20262b); --border: light-dark(#c6c2ba, #454e56);
    --feasible: light-dark(#0072b2, #3d9fdc); --infeasible: light-dark(#d55e00, #ee7d2b);
    --undecided: light-dark(#7f7f7f, #8f9499); --task: #e69f00;
    max-width: 480px; padding: 6px; color: var(--ink); background: var(--ground);
    font: 14px/1.5 var(--jp-ui-font-family, system-ui, sans-serif); font-variant-numeric: tabular-nums;
  }
  .frame { position: relative; max-width: 100%; margin: 1px; outline: 1px solid var(--border); }
  .frame:focus-visible, button:focus-visible, input:focus-visible { outline: 2px solid var(--feasible); outline-offset: 2px; }
  canvas { position: absolute; }
  canvas:not([data-drawn]) { visibility: hidden; }
  .time, .counts { display: flex; flex-wrap: wrap; align-items: center; gap: 2px 9px; margin-top: 6px; }
  .time { gap: 6px; }
  button { min-width: 4.7em; padding: 3px 10px; border: 1px solid var(--border); border-radius: 6px; font: inherit; color: inherit; background: none; cursor: pointer; }
  label { display: flex; align-items: center; gap: 6px; margin-left: auto; }
  input { width: 84px; accent-color: var(--feasible); }
  output { min-width: 6.6em; white-space: nowrap; }
  i { display: inline-block; box-sizing: border-box; width: 11px; height: 11px; margin-right: 5px; border-radius: 50%; background: currentColor; }
  .infeasible i { border: 3px solid currentColor; background: none; }
  .feasible i { color: var(--feasible); } .infeasible i { color: var(--infeasible); }
  .undecided i { color: var(--undecided); transform: scale(0.7); }
  p { margin: 2px 0 0; }
</style>
<div class="arena" role="group" aria-label="Swarm">
  <div class="frame" tabindex="0" role="img"><canvas></canvas></div>
  <div class="time">
    <button data-does="play" aria-keyshortcuts="Space">Play</button>
    <button data-does="step" aria-keyshortcuts=". ArrowRight">Step</button>
    <button data-does="restart" aria-keyshortcuts="r">Restart</button>
    <label>Speed <input type="range" min="0" max="${SPEEDS.length - 1}"></label><output></output>
  </div>
  <div class="counts">
    <span>step <b data-count="step"></b></span>
    <span class="feasible"><i></i><b data-count="feasible"></b> feasible</span>
    <span class="infeasible"><i></i><b data-count="infeasible"></b> infeasible</span>
    <span class="undecided"><i></i><b data-count="none"></b> none</span>
    <span><b data-count="disseminating"></b> disseminating</span>
  </div>
  <p class="outcome" role="status"></p>
  <p class="note" role="status"></p>
</div>`;
/** @type {Record<string, string>} */
const KEYS = { " ": "play", ".": "step", ArrowRight: "step", r: "restart" };

/**
 * Return a copy, since a buffer from Jupyter is part of a message.
 * @param {DataView | ArrayBuffer} view
 * @returns {ArrayBuffer}
 */
function bytesOf(view) {
  if (!ArrayBuffer.isView(view)) return view.slice(0);
  return new Uint8Array(view.buffer, view.byteOffset, view.byteLength).slice().buffer;
}

/** @param {{model: Model, el: HTMLElement}} view */
function render({ model, el }) {
  const shadow = el.attachShadow({ mode: "open" });
  shadow.append(document.createRange().createContextualFragment(SHAPE)); // a constant: no other text is read as markup
  /** @param {string} selector */
  const $ = (selector) => /** @type {HTMLElement} */ (shadow.querySelector(selector));
  const root = $(".arena"),
    speed = /** @type {HTMLInputElement} */ ($("input"));
  /** @type {World} */
  const world = model.get("_world");
  const [width, height] = world.size;
  const calm = matchMedia("(prefers-reduced-motion: reduce)"),
    dark = matchMedia("(prefers-color-scheme: dark)");
  const ended = new AbortController();
  let swarm = "",
    pending = 0,
    past = 0,
    late = 0,
    stale = true;

  const wait = () => say(".note", "Waiting for the kernel. If it was restarted, run this cell again.");
  /** @param {number} step */
  const want = (step) => {
    player.asked = true;
    clearTimeout(late);
    late = setTimeout(wait, PATIENCE);
    try {
      model.send({ swarm, step });
    } catch {
      wait(); // JupyterLab throws if the kernel is gone
    }
  };
  const player = new Player((steps) => want(player.latest.step + steps));
  const arena = new Arena(
    /** @type {HTMLCanvasElement} */ ($("canvas")),
    /** @type {Colours} */ ({}), // until the first repaint
  );
  const wake = () => (pending ||= requestAnimationFrame(tick));
  const refresh = () => ((stale = true), wake());

  /** @param {number} step */
  function begin(step) {
    swarm = Math.random().toString(36).slice(2); // a frame with another name is late
    player.clear();
    player.last = world.last;
    want(step);
  }

  /**
   * @param {{problem?: string, swarm?: string}} message
   * @param {(DataView | ArrayBuffer)[]} buffers
   */
  function hear(message, buffers) {
    if (message.problem) return say(".note", message.problem);
    if (message.swarm !== swarm) return;
    clearTimeout(late);
    say(".note", "");
    player.add(/** @type {Frame} */ (decode(bytesOf(buffers[0]))));
    wake();
  }

  /** @param {number} time */
  function tick(time) {
    pending = 0;
    if (!root.offsetWidth) return; // not on the page yet, or hidden: a change of size calls tick again
    if (stale) repaint();
    const view = player.tick(past ? Math.min(0.1, (time - past) / 1000) : 0);
    if (!view) return;
    const flashing = arena.draw(view, time),
      rests = !player.playing && player.head >= player.target;
    show(view.now);
    past = rests ? 0 : time;
    if (flashing || (!rests && !(player.asked && player.head >= player.latest.step))) wake(); // otherwise the next frame does
    if (!rests || model.get("step") === view.now.step) return;
    model.set("step", view.now.step);
    model.save_changes();
  }

  /**
   * @param {string} where
   * @param {string} text
   */
  function say(where, text) {
    if ($(where).textContent !== text) $(where).textContent = text; // screen readers read each change
  }

  /** @param {Frame} frame */
  function show(frame) {
    const none = frame.counted - frame.feasible - frame.infeasible;
    for (const [name, value] of Object.entries({ ...frame, none })) {
      const place = $(`[data-count="${name}"]`);
      if (place) place.textContent = value.toLocaleString("en");
    }
    const first = OUTCOMES[frame.firstDecision],
      now = OUTCOMES[frame.decision],
      truth = OUTCOMES[Number(world.truth)];
    const since = `decided ${first} at step ${frame.decisionStep}: ${first === truth ? "right" : "wrong"}${now === first ? "" : `; now ${now}`}`;
    say(".outcome", frame.firstDecision < 0 ? `not decided (truth: ${truth})` : since);
    say("[data-does=play]", player.playing ? "Pause" : "Play");
  }

  function setSpeed() {
    player.speed = model.get("speed");
    player.smooth = !calm.matches;
    arena.calm = calm.matches || player.speed > 60; // faster, flashes would only flicker
    speed.valueAsNumber = SPEEDS.findLastIndex((each) => each <= player.speed);
    const text = `${player.speed.toLocaleString("en")} ${player.speed === 1 ? "step" : "steps"} / s`;
    speed.setAttribute("aria-valuetext", text);
    say("output", text);
  }

  function repaint() {
    stale = false;
    const light = document.body.dataset.jpThemeLight; // set by JupyterLab; others follow the system
    root.style.colorScheme = light === undefined ? "light dark" : light === "true" ? "light" : "dark";
    const probe = root.appendChild(document.createElement("span"));
    /** @param {keyof Colours} name */
    const colour = (name) => ((probe.style.color = `var(--${name})`), getComputedStyle(probe).color);
    arena.setColours(/** @type {Colours} */ (Object.fromEntries(PAINTS.map((name) => [name, colour(name)]))));
    probe.remove();
  }

  /** @type {Record<string, () => void>} */
  const actions = {
    play() {
      if (player.ended) begin(0);
      player.play(!player.playing);
    },
    step: () => player.step(),
    restart: () => begin(0),
  };
  /** @param {string} name */
  function act(name) {
    actions[name]();
    wake();
  }
  root.addEventListener("click", (event) => {
    const { does } = /** @type {HTMLElement} */ (event.target).dataset;
    if (does) act(does);
  });
  root.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
    event.stopPropagation(); // in a notebook, letters and Enter are commands
    const at = /** @type {Element} */ (event.target);
    if (at.matches("input") && event.key === "ArrowRight") return;
    if (!KEYS[event.key] || (at.matches("button") && event.key === " ")) return;
    event.preventDefault();
    act(KEYS[event.key]);
  });
  speed.addEventListener("input", () => {
    model.set("speed", SPEEDS[speed.valueAsNumber]);
    model.save_changes();
  });
  /** @param {PointerEvent} event */
  const point = (event) => {
    arena.pointed = event.type === "pointerleave" ? -1 : arena.at(event.clientX, event.clientY);
    wake();
  };
  for (const type of /** @type {const} */ (["pointermove", "pointerleave"]))
    $(".frame").addEventListener(type, point);

  $(".frame").style.width = `${480 * Math.min(1, width / height)}px`;
  $(".frame").style.aspectRatio = String(width / height);
  $(".frame").setAttribute("aria-label", `${world.robots} robots and ${world.tasks} tasks`);
  arena.open(world);
  arena.setTasks(/** @type {Tasks} */ (decode(bytesOf(model.get("_tasks")))));
  setSpeed();
  const size = new ResizeObserver(refresh),
    theme = new MutationObserver(refresh);
  size.observe($(".frame"));
  theme.observe(document.body, { attributeFilter: ["data-jp-theme-light", "data-jp-theme-name"] });
  dark.addEventListener("change", refresh, { signal: ended.signal });
  calm.addEventListener("change", setSpeed, { signal: ended.signal });
  model.on("msg:custom", hear);
  model.on("change:speed", setSpeed);
  begin(Math.min(model.get("step"), world.last));

  return () => {
    cancelAnimationFrame(pending);
    clearTimeout(late);
    size.disconnect();
    theme.disconnect();
    ended.abort();
    model.off("msg:custom", hear);
    model.off("change:speed", setSpeed);
  };
}

export default { render };
