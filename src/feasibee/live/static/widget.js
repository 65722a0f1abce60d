// The arena in a notebook: canvas and clock of the page, few controls, the kernel in place of the server; see widget.py.

import { Arena } from "./arena.js";
import { Controls } from "./controls.js";
import { decode } from "./frames.js";
import { Hands } from "./hands.js";
import { Player, SPEEDS } from "./player.js";
import { explainTerms } from "./terms.js";
import { coloursOf } from "./theme.js";
import { showTooltip } from "./tooltip.js";
import { sketching, Tools } from "./tools.js";
import { copy, EVENTS, handled, touched } from "./touching.js";

/** @import { Opened } from "./arena.js" */
/** @import { Problem } from "./controls.js" */
/** @import { Frame, Tasks } from "./frames.js" */
/** @import { Change } from "./touching.js" */

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

/**
 * Message of the kernel; world: with the first step of a run; why: a robot, and why it holds its opinion.
 * @typedef {{problem?: string, problems?: Problem[], swarm?: string, world?: Opened, why?: [number, string]}} Answer
 */
/** @typedef {(DataView | ArrayBuffer)[]} Buffers */

const PATIENCE = 2000; // milliseconds after which a waiting view says so
const AGAIN = 500; // milliseconds between two questions about one robot
const FIELDS = [
  ["robots.count", "Robots", 'min="1" max="100"'],
  ["tasks.count", "Tasks", 'min="0" max="100"'],
  ["sensing.range", "Sensing range", 'min="0.1" max="10" step="0.1"'],
  ["radio.range", "Radio range", 'min="0.1" max="10" step="0.1"'],
  ["robots.speed", "Speed of robots", 'min="0" max="2" step="0.05"'],
].map(
  ([path, label, limits]) =>
    `<label>${label} <input type="number" step="any" data-path="${path}"><input type="range" data-slides="${path}" ${limits} aria-label="${label}, slider"></label>`,
);
/** @type {Record<number, string>} */
const OUTCOMES = { 1: "feasible", 0: "infeasible", [-1]: "nothing" };
const SHAPE = `<style>
  .arena {
    --ground: var(--jp-layout-color0, light-dark(#fdfdfc, #0c0f11));
    --ink: var(--jp-ui-font-color1, light-dark(#1d2125, #e6e9eb));
    --line: light-dark(#ebe9e4, #20262b); --border: light-dark(#c6c2ba, #454e56);
    --feasible: light-dark(#0072b2, #3d9fdc); --infeasible: light-dark(#d55e00, #ee7d2b);
    --undecided: light-dark(#7f7f7f, #8f9499); --task: #e69f00; --zone: light-dark(#009e73, #22c595);
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
  form label { margin: 4px 0; flex-wrap: wrap; justify-content: end; } .note { color: var(--infeasible); }
  input { width: 84px; accent-color: var(--feasible); }
  output { min-width: 6.6em; white-space: nowrap; }
  i { display: inline-block; box-sizing: border-box; width: 11px; height: 11px; margin-right: 5px; border-radius: 50%; background: currentColor; }
  .infeasible i { border: 3px solid currentColor; background: none; }
  .feasible i { color: var(--feasible); } .infeasible i { color: var(--infeasible); }
  .undecided i { color: var(--undecided); transform: scale(0.7); }
  p, dl, dd { margin: 2px 0 0; }
  summary { cursor: pointer; margin-top: 6px; } dt { font-weight: 600; }
  .tip { box-sizing: border-box; z-index: 1; position: absolute; left: 0; top: 0; width: max-content; max-width: 100%; padding: 4px 10px; border-radius: 8px; white-space: pre-line; background: var(--ink); color: var(--ground); pointer-events: none; }
  .tools { display: flex; flex-wrap: wrap; gap: 6px; } [aria-pressed="true"] { border-color: var(--feasible); }
  [data-tool]:not([data-tool=""]) { touch-action: none; cursor: crosshair; }
  [hidden] { display: none; }
</style>
<div class="arena" role="group" aria-label="Swarm">
  <div class="frame" tabindex="0" role="img"><canvas></canvas><div class="tip" hidden></div></div>
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
    <span><b data-count="disseminating"></b> broadcasting</span>
    <span class="declared" hidden>declared: <b data-count="declaredFeasible"></b> feasible, <b data-count="declaredInfeasible"></b> infeasible</span>
  </div>
  <details><summary>Change the swarm</summary><form>
    ${FIELDS.join("")}
    <div class="tools" role="group" aria-label="Tools for the pointer"></div>
    <label>Strategy <select data-path="decision.strategy"></select></label>
    <p id="problem" hidden></p>
    <button type="button" data-does="copy">Copy as scenario</button><details><summary>Scenario</summary><pre></pre></details>
  </form></details>
  <details><summary>What am I looking at?</summary><dl></dl></details>
  <p class="outcome" role="status"></p>
  <p class="kernel" role="status"></p>
</div>`;
/** @type {Record<string, string>} */
const KEYS = { " ": "play", ".": "step", ArrowRight: "step", r: "restart", Escape: "leave" };

/**
 * Return a copy, since a buffer from Jupyter is part of a message.
 * @param {DataView | ArrayBuffer} view
 * @returns {ArrayBuffer}
 */
function bytesOf(view) {
  if (!ArrayBuffer.isView(view)) return view.slice(0);
  return new Uint8Array(view.buffer, view.byteOffset, view.byteLength).slice().buffer;
}

class WidgetView {
  /**
   * @param {Model} model
   * @param {HTMLElement} el
   */
  constructor(model, el) {
    this.model = model;
    this.shadow = el.attachShadow({ mode: "open" });
    this.shadow.append(document.createRange().createContextualFragment(SHAPE)); // a constant: no other text is markup
    this.root = this.find(".arena");
    this.slider = /** @type {HTMLInputElement} */ (this.find(".time input"));
    this.controls = new Controls(
      /** @type {HTMLFormElement} */ (this.find("form")),
      () => this.begin(0),
      (path, count) => this.touch(path, count),
    );
    this.controls.changes = model.get("changes");
    /** @type {Opened} */
    this.world = model.get("_world");
    this.before = { swarm: "", step: 0 }; // what is shown if the swarm that is wanted can't be
    /** @type {[number, string]} */
    this.why = [-1, ""];
    this.asked = { robot: -1, step: -1, time: 0 }; // why
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.swarm = ""; // name of the present swarm: a frame with another name is late
    this.late = 0;
    /** @type {Change[]} */
    this.later = []; // by hands, as soon as the wanted swarm is shown
    const canvas = /** @type {HTMLCanvasElement} */ (this.find("canvas"));
    this.player = new Player(
      this.root,
      (steps) => this.request(this.player.latest.step + steps),
      (view, time, rests) => {
        this.show(view.now, rests);
        const moves = this.arena.draw(view, time),
          [robot, why] = this.why;
        showTooltip(this.arena, this.find(".tip"), view.now, robot === this.arena.pointed ? why : "");
        this.wonder(view.now.step, time);
        return moves;
      },
    );
    this.arena = new Arena(canvas, coloursOf(this.root), () => this.player.wake());
    const lanes = [{ frame: this.find(".frame"), arena: this.arena }],
      sketch = sketching(lanes, () => this.player.wake()),
      hands = new Hands(
        (change) => this.happen(change),
        sketch,
        (text) => this.say(".kernel", text),
      );
    this.tools = new Tools(this.find(".tools"), lanes, hands.tools);
  }

  /** @param {string} selector */
  find(selector) {
    return /** @type {HTMLElement} */ (this.shadow.querySelector(selector));
  }

  // Show the world, listen, and request the first frame; return what ends all of it.
  start() {
    const { world, model } = this,
      [width, height] = world.size,
      frame = this.find(".frame");
    frame.style.width = `${480 * Math.min(1, width / height)}px`;
    frame.style.aspectRatio = String(width / height);
    explainTerms(this.find("dl"));
    this.find("select").append(
      ...model.get("_strategies").map((/** @type {string} */ each) => new Option(each)),
    );
    this.setSpeed();
    this.listenToUser();
    const stop = this.listenToSurroundings();
    this.begin(Math.min(model.get("step"), world.last));
    return () => {
      cancelAnimationFrame(this.player.pending);
      clearTimeout(this.late);
      stop();
    };
  }

  /**
   * Show another world from now on.
   * @param {Opened} world
   * @param {Tasks} tasks
   */
  open(world, tasks) {
    this.world = world;
    this.player.last = world.last;
    this.find(".declared").hidden = !world.declares;
    this.find("pre").textContent = world.toml;
    this.arena.open(world);
    this.arena.setTasks(tasks);
    this.controls.show(world);
    this.tools.offer(() => !world.fixed);
    this.model.set("changes", this.controls.changes);
    this.model.save_changes();
  }

  /**
   * Change the world from the next step on; return whether it can be.
   * @param {string} path
   * @param {number} count
   */
  touch(path, count) {
    const { world, player } = this,
      [now] = player.frames;
    if (!(path in EVENTS) || world.fixed || !now?.step || now.step >= world.last) return false;
    this.amend(touched(world.events, now, EVENTS[path], count, player.playing));
    return true;
  }

  /** @param {Change} change By a hand. */
  happen(change) {
    const { world, player } = this,
      [now] = player.frames;
    if (!now) {
      this.later.push(change);
      return;
    }
    if (now.step >= world.last) return this.say(".kernel", "The run is over: restart it.");
    this.amend(handled(world.events, now.step, change, player.playing));
  }

  /** @param {{step: number, events: Opened["events"]}} touched */
  amend({ step, events }) {
    this.controls.changes = { ...this.controls.changes, events };
    this.begin(step);
  }

  listenToUser() {
    const { root, model, slider } = this;
    root.addEventListener("click", (event) => {
      const { does } = /** @type {HTMLElement} */ (event.target).dataset;
      if (does) this.act(does);
    });
    root.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
      event.stopPropagation(); // in a notebook, letters and Enter are commands
      const at = /** @type {Element} */ (event.target);
      if (at.matches("form *, summary") || (at.matches("input") && event.key === "ArrowRight")) return;
      if (!KEYS[event.key] || (at.matches("button") && event.key === " ")) return;
      event.preventDefault();
      this.act(KEYS[event.key]);
    });
    slider.addEventListener("input", () => {
      model.set("speed", SPEEDS[slider.valueAsNumber]);
      model.save_changes();
    });
    this.arena.followPointer(this.find(".frame"), () => this.player.wake());
  }

  // Follow the kernel, the size, and the theme; return what ends it.
  listenToSurroundings() {
    const { model } = this;
    const refresh = () => this.repaint();
    const setSpeed = () => this.setSpeed();
    const hear = (/** @type {Answer} */ message, /** @type {Buffers} */ buffers) =>
      this.hear(message, buffers);
    const ended = new AbortController(),
      size = new ResizeObserver(refresh),
      theme = new MutationObserver(refresh);
    size.observe(this.find(".frame"));
    theme.observe(document.body, { attributeFilter: ["data-jp-theme-light", "data-jp-theme-name"] });
    this.dark.addEventListener("change", refresh, { signal: ended.signal });
    model.on("msg:custom", hear);
    model.on("change:speed", setSpeed);
    return () => {
      size.disconnect();
      theme.disconnect();
      ended.abort();
      model.off("msg:custom", hear);
      model.off("change:speed", setSpeed);
    };
  }

  /** @param {number} step */
  begin(step) {
    const [shown] = this.player.frames;
    if (shown) this.before = { swarm: this.swarm, step: shown.step };
    this.swarm = Math.random().toString(36).slice(2);
    this.player.clear();
    this.player.last = this.world.last;
    this.request(step);
  }

  /**
   * @param {number} step
   * @param {number} [robot] Of which the answer shall say why it holds its opinion.
   */
  request(step, robot = -1) {
    this.player.asked = true;
    clearTimeout(this.late);
    this.late = setTimeout(() => this.showWaiting(), PATIENCE);
    try {
      this.model.send({ swarm: this.swarm, step, changes: this.controls.changes, robot });
    } catch {
      this.showWaiting(); // JupyterLab throws if the kernel is gone
    }
  }

  showWaiting() {
    this.say(".kernel", "Waiting for the kernel. If it was restarted, run this cell again.");
  }

  /**
   * @param {Answer} message
   * @param {Buffers} buffers
   */
  hear(message, buffers) {
    const { swarm, problems, world, why } = message,
      { player, controls, before } = this;
    if (message.problem) return this.say(".kernel", message.problem);
    if (swarm !== this.swarm) return;
    clearTimeout(this.late);
    this.say(".kernel", "");
    if (problems) {
      this.later = [];
      controls.changes = this.model.get("changes");
      controls.showProblems(problems);
      this.swarm = before.swarm;
      return this.request(before.step);
    }
    const frame = /** @type {Frame} */ (decode(bytesOf(buffers[0])));
    if (world) this.open(world, /** @type {Tasks} */ (decode(bytesOf(buffers[1]))));
    this.why = why ?? this.why;
    if (player.latest?.step !== frame.step) player.add(frame);
    player.asked = false;
    player.wake();
    const next = this.later.shift();
    if (next) this.happen(next);
  }

  /**
   * Ask why the robot that is pointed at holds its opinion, if that isn't known of this step.
   * @param {number} step
   * @param {number} time
   */
  wonder(step, time) {
    const { asked, arena, player } = this,
      robot = arena.pointed;
    if (
      player.asked ||
      robot < 0 ||
      (asked.robot === robot && (asked.step === step || time - asked.time < AGAIN))
    )
      return;
    this.asked = { robot, step, time };
    this.request(player.latest.step, robot);
  }

  /**
   * @param {string} where
   * @param {string} text
   */
  say(where, text) {
    const place = this.find(where);
    if (place.textContent !== text) place.textContent = text; // screen readers read each change
  }

  /**
   * @param {Frame} frame
   * @param {boolean} rests
   */
  show(frame, rests) {
    this.controls.follow({ "robots.count": frame.there, "tasks.count": frame.tasks });
    this.find(".frame").setAttribute("aria-label", `${frame.there} robots and ${frame.tasks} tasks`);
    const none = frame.counted - frame.feasible - frame.infeasible;
    for (const [name, value] of Object.entries({ ...frame, none })) {
      const place = this.find(`[data-count="${name}"]`);
      if (place) place.textContent = value.toLocaleString("en");
    }
    const first = OUTCOMES[frame.firstDecision],
      now = OUTCOMES[frame.decision],
      truth = OUTCOMES[frame.truth];
    const word = first === truth ? "right" : "wrong",
      since = `decided ${first} at step ${frame.decisionStep}: ${word}${now === first ? "" : `; now ${now}`}`;
    const held = `decided ${now} (truth at this step: ${truth}; ${frame.there} robots, ${frame.tasks} tasks)`;
    const outcome = frame.firstDecision < 0 ? `not decided (truth: ${truth})` : since;
    this.say(".outcome", this.world.changes ? held : outcome);
    this.say("[data-does=play]", this.player.playing ? "Pause" : "Play");
    if (!rests || this.model.get("step") === frame.step) return;
    this.model.set("step", frame.step);
    this.model.save_changes();
  }

  setSpeed() {
    const { player, slider } = this;
    player.speed = this.model.get("speed");
    slider.valueAsNumber = SPEEDS.findLastIndex((each) => each <= player.speed);
    slider.setAttribute("aria-valuetext", player.pace);
    this.say("output", player.pace);
  }

  repaint() {
    const light = document.body.dataset.jpThemeLight; // set by JupyterLab; others follow the system
    this.root.style.colorScheme = light === undefined ? "light dark" : light === "true" ? "light" : "dark";
    this.arena.setColours(coloursOf(this.root));
    this.player.wake();
  }

  /** @param {string} action */
  act(action) {
    const { player } = this;
    if (action === "copy") copy(this.find("[data-does=copy]"), this.find("pre"));
    if (action === "restart" || (action === "play" && player.ended)) this.begin(0);
    if (action === "play") player.play(!player.playing);
    if (action === "step") player.step();
    if (action === "leave") this.tools.leave();
  }
}

/** @param {{model: Model, el: HTMLElement}} view */
function render({ model, el }) {
  return new WidgetView(model, el).start();
}

export default { render };
