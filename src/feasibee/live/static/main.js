// The page: show what the server sends, send what the user does.

import { readAddress, writeAddress } from "./address.js";
import { Arena } from "./arena.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { $, announce, formatted } from "./elements.js";
import { decode } from "./frames.js";
import { Player, SPEEDS } from "./player.js";
import { Plot } from "./plot.js";
import { Readings } from "./readings.js";
import { listReplays, markReplay } from "./replays.js";
import { colours, startTheme } from "./theme.js";
import { showTooltip } from "./tooltip.js";
import { Veil } from "./veil.js";

/** @import { Which } from "./address.js" */
/** @import { Opened } from "./arena.js" */

/** @typedef {(message: any) => void} Answer Handler of a JSON message of the server. */

const canvas = /** @type {HTMLCanvasElement} */ ($("arena"));
const help = /** @type {HTMLDialogElement} */ ($("help"));
const calm = matchMedia("(prefers-reduced-motion: reduce)");

/** @type {Opened | null} */
let world = null; // the run that the page shows
/** @type {number | null} */
let point = null; // of a sweep, or null
/** @type {{step: number, which: Which} | null} */
let wanted = null; // requested, and not shown yet
let dirty = true;
let startAfter = false; // whether to play as soon as the first frame is there
let full = false; // whether the server has too many pages already

startTheme(repaint);
const player = new Player((steps) => connection.send({ type: "advance", steps }));
const arena = new Arena(canvas, colours());
const plot = new Plot($("plot"), colours());
const readings = new Readings(plot);
const controls = new Controls(/** @type {HTMLFormElement} */ ($("controls")), () => begin(0));
const veil = new Veil();

/**
 * Take point and changes from the address.
 * @returns {Which}
 */
function followAddress() {
  const kept = readAddress();
  controls.changes = kept.changes;
  point = kept.point;
  return kept.which;
}

/**
 * Request a run from a step on; the present one is shown until it comes.
 * @param {number} step
 * @param {Which} which
 */
function begin(step, which = controls.which) {
  player.asked = true; // no more frames of the present run
  wanted = { step, which };
  veil.prepare();
  connection.send({ type: "open", point, changes: controls.changes, ...which, step });
}

/**
 * @param {string} text
 * @param {string} kind
 */
function showConnection(text, kind) {
  $("connection").textContent = text;
  $("connection").dataset.state = kind;
}

/** @param {string} text */
function showBanner(text) {
  $("banner-text").textContent = text;
  $("banner").hidden = false;
}

/** @type {Record<string, Answer>} */
const answers = {
  welcome(message) {
    $("banner").hidden = true;
    showConnection("live", "live");
    controls.strategies(message.strategies);
    $("title").textContent = message.title;
    document.title = message.title ? `${message.title}: feasibee` : "feasibee: live arena";
    listReplays(message, (replay) => {
      point = replay.point;
      controls.changes = {};
      begin(0, { seed: replay.seed, run: replay.run });
    });
    if (wanted) return begin(wanted.step, wanted.which);
    const { seed, run } = followAddress();
    point ??= seed === null || message.point !== null ? message.point : null;
    begin(0, { seed: seed ?? (point === message.point ? message.seed : null), run: run ?? message.run });
  },
  opened(message) {
    const old = world;
    world = message;
    player.clear();
    player.last = message.last;
    player.asked = true; // the first frame comes without a request
    arena.open(message);
    fit();
    readings.open(message);
    controls.show(message);
    $("controls").inert = false;
    markReplay(point, message.run);
    if (old) announce(`Seed ${message.seed}, run ${message.run}, from the start`);
    writeAddress(message, point, controls.changes);
    dirty = true;
  },
  error(message) {
    veil.hide();
    if (wanted)
      player.asked = false; // the previous run continues
    else player.halt();
    reflectPlay();
    wanted = null;
    controls.showProblems(message.problems);
  },
  compiling: (message) => veil.showTime(message.text, message.seconds),
  going: (message) => veil.show(`Going to step ${formatted(message.to)}: ${formatted(message.step)} so far`),
  full(message) {
    showBanner(message.text);
    showConnection("full", "lost");
    full = true;
  },
};

const connection = new Connection({
  message: (message) => answers[message.type]?.(message),
  binary(buffer) {
    const message = decode(buffer);
    if (!world || message.generation !== world.generation) return;
    if (message.kind === "tasks") {
      arena.setTasks(message);
    } else {
      veil.hide();
      wanted = null;
      plot.add(message);
      player.add(message);
      if (startAfter) player.play(true);
      startAfter = false;
      reflectPlay();
    }
    dirty = true;
  },
  lost(wait) {
    veil.hide();
    showConnection("not connected", "lost");
    if (world && !wanted)
      wanted = { step: player.frames[0].step, which: { seed: world.seed, run: world.run } };
    player.asked = true;
    const seconds = Math.ceil(wait / 1000);
    if (!full)
      showBanner(
        `The server doesn't answer. This page continues where it was when it does; next attempt in ${seconds} s.`,
      );
    full = false;
    $("banner").hidden = false;
  },
});

let past = 0;
/** @param {number} time */
function tick(time) {
  const seconds = Math.min(0.1, (time - past) / 1000);
  past = time;
  const head = player.head,
    was = player.playing;
  const view = player.tick(seconds);
  if (was && !player.playing) reflectPlay();
  if (view && world && (dirty || head !== player.head)) {
    dirty = arena.draw(view, time);
    if (!readings.isPlotted(view.now)) dirty = true;
    readings.show(view.now, time, player.playing);
    showTooltip(arena, world, view.now);
  }
  requestAnimationFrame(tick);
}

function reflectPlay() {
  const now = player.playing ? "playing" : `at step ${player.frames[0]?.step ?? 0}`;
  $("play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
  $("play").dataset.playing = String(player.playing);
  canvas.setAttribute(
    "aria-label",
    world ? `The arena: ${world.robots} robots and ${world.tasks} tasks, ${now}` : "The arena",
  );
}

function reflectSpeed() {
  reflectMotion();
  $("speed").textContent = `${formatted(player.speed)} ${player.speed === 1 ? "step" : "steps"} / s`;
}

function reflectMotion() {
  player.smooth = !calm.matches;
  arena.calm = calm.matches || player.speed > 60; // faster, flashes would only flicker
}

function repaint() {
  arena.setColours(colours());
  plot.setColours(colours());
  dirty = true;
}

function fit() {
  if (!world) return;
  arena.layout();
  for (const id of ["transport", "legend"]) $(id).style.maxWidth = canvas.style.width;
  dirty = true;
}

/** @param {boolean} playing */
function restart(playing) {
  startAfter = playing;
  begin(0);
}

/** @param {number} by */
function changeSpeed(by) {
  const place = SPEEDS.indexOf(player.speed) + by;
  player.speed = SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, place))];
  reflectSpeed();
}

async function copyScenario() {
  try {
    await navigator.clipboard.writeText($("toml").textContent);
    $("copy").textContent = "Copied";
  } catch {
    getSelection()?.selectAllChildren($("toml")); // a page by http from another machine has no clipboard
    $("copy").textContent = "Selected: press Ctrl-C";
  }
  setTimeout(() => ($("copy").textContent = "Copy"), 2000);
}

/** @type {Record<string, () => void>} */
const actions = {
  play() {
    if (!player.playing && player.ended) return restart(true);
    player.play(!player.playing);
    reflectPlay();
  },
  step() {
    player.step();
    reflectPlay();
  },
  restart: () => restart(player.playing),
  faster: () => changeSpeed(1),
  slower: () => changeSpeed(-1),
  another() {
    const run = controls.input("run");
    run.value = String(BigInt(/^\d+$/.test(run.value) ? run.value : "-1") + 1n);
    begin(0);
  },
  help: () => (help.open ? help.close() : help.showModal()),
};

/** @type {Record<string, string>} */
const KEYS = {
  " ": "play",
  ".": "step",
  ArrowRight: "step",
  "+": "faster",
  "=": "faster",
  "-": "slower",
  r: "restart",
  n: "another",
  "?": "help",
};

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || help.open) return;
  const at = /** @type {Element} */ (event.target);
  if (at.closest("input, select, textarea, pre")) return;
  if (event.key === " " && at.closest("button, summary")) return; // the browser presses it
  const action = KEYS[event.key];
  if (!action) return;
  event.preventDefault();
  actions[action]();
});
for (const id of ["play", "step", "restart", "faster", "slower", "another"])
  $(id).addEventListener("click", () => actions[id]());
$("skip").addEventListener("click", () => $("play").focus()); // not a link: the address keeps the run
$("help-open").addEventListener("click", actions.help);
$("retry").addEventListener("click", () => connection.open());
$("reset").addEventListener("click", () => {
  controls.changes = {};
  begin(0);
});
$("copy").addEventListener("click", copyScenario);

/** @param {PointerEvent} event */
function pointAt(event) {
  const robot = event.type === "pointerleave" ? -1 : arena.at(event.clientX, event.clientY);
  if (robot !== arena.pointed) dirty = true;
  arena.pointed = robot;
}
for (const type of /** @type {const} */ (["pointermove", "pointerdown", "pointerleave"]))
  $("frame").addEventListener(type, pointAt);
addEventListener("hashchange", () => begin(0, followAddress()));
calm.addEventListener("change", reflectMotion);
new ResizeObserver(fit).observe($("frame"));
new ResizeObserver(() => plot.resize()).observe($("plot"));

reflectPlay();
reflectSpeed();
requestAnimationFrame(tick);
