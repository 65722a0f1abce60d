// The page: what arrives is shown, what somebody does is sent.

import { Arena } from "./arena.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import {
  COMMITTED,
  COUNTED,
  DISSEMINATING,
  FEASIBLE,
  LIAR,
  NEUTRAL,
  STUBBORN,
  WORKING,
  decode,
} from "./frames.js";
import { Player, SPEEDS } from "./player.js";
import { Plot } from "./plot.js";

/** @import { Colour, Opened } from "./arena.js" */
/** @import { Problem } from "./controls.js" */
/** @import { Frame } from "./frames.js" */

/** @typedef {{seed: string | null, run: string | null}} Which Of a point's runs; null: the server's. */
/** @typedef {(message: any) => void} Answer To a message of the server, which is JSON. */

/**
 * @typedef {object} Replay
 * @property {number} point
 * @property {string} run
 * @property {string} seed
 * @property {Record<string, string>} values
 * @property {string} decision
 * @property {number} decision_step
 */

/**
 * Return an element of this page, index.html.
 * @param {string} id
 */
const $ = (id) => /** @type {HTMLElement} */ (document.getElementById(id));
const canvas = /** @type {HTMLCanvasElement} */ ($("arena"));
const help = /** @type {HTMLDialogElement} */ ($("help"));
/** @type {Record<number, string>} */
const WORDS = { 1: "feasible", 0: "infeasible", [-1]: "undecided" };
/** @typedef {Colour | "muted"} Shade */
/** @type {Shade[]} */
const SHADES = ["ground", "line", "ink", "muted", "feasible", "infeasible", "undecided", "task"];
const PLOT_PAUSE = 66; // milliseconds between two drawings of the plot
const PATIENCE = 400; // milliseconds after which a page that waits says so

/** @type {Opened | null} */
let world = null; // what the server tells of the present swarm
/** @type {number | null} */
let point = null; // of a sweep, or null
/** @type {{step: number, which: Which} | null} */
let wanted = null; // what has been asked for and isn't there yet
let waitingFor = 0;
let dirty = true;
let startAfter = false; // whether to play as soon as the first frame is there
let full = false; // whether the server has no room for this page
/** @type {string | null} */
let shownDecision = null;
let shownStep = -1,
  plotted = 0;
const settings = { theme: "auto" };
const calm = matchMedia("(prefers-reduced-motion: reduce)"),
  dark = matchMedia("(prefers-color-scheme: dark)");

const player = new Player((steps) => connection.send({ type: "advance", steps }));
const arena = new Arena(canvas, colours());
const plot = new Plot($("plot"), colours());
const controls = new Controls(/** @type {HTMLFormElement} */ ($("controls")), () => begin(0));

/**
 * Read what the address keeps: seed, run, point, and changes by path.
 * @returns {Which}
 */
function readAddress() {
  const kept = new URLSearchParams(location.hash.slice(1));
  /** @type {Record<string, unknown>} */
  const changes = {};
  for (const [path, text] of kept) {
    if (!path.includes(".")) continue;
    try {
      changes[path] = JSON.parse(text);
    } catch {
      changes[path] = text;
    }
  }
  controls.changes = changes;
  point = kept.has("point") ? Number(kept.get("point")) : null;
  return { seed: kept.get("seed"), run: kept.get("run") };
}

/** @param {Opened} world */
function writeAddress({ seed, run }) {
  const kept = new URLSearchParams({ seed, run });
  if (point !== null) kept.set("point", String(point));
  for (const [path, value] of Object.entries(controls.changes)) kept.set(path, JSON.stringify(value));
  history.replaceState(null, "", `#${kept}`);
}

/**
 * Ask for a run from a step on; what is shown stays until it comes.
 * @param {number} step
 * @param {Which} which
 */
function begin(step, which = controls.which) {
  player.asked = true; // nothing more of the old one
  wanted = { step, which };
  clearTimeout(waitingFor);
  waitingFor = setTimeout(() => veil("Preparing the swarm"), PATIENCE);
  connection.send({ type: "open", point, changes: controls.changes, ...which, step });
}

/** @param {string} text */
function veil(text) {
  if (!text) clearTimeout(waitingFor);
  $("veil-text").textContent = text;
  $("veil").hidden = !text;
}

/** @param {string} text */
function say(text) {
  $("announcer").textContent = text;
}

/**
 * @param {string} text
 * @param {string} kind
 */
function state(text, kind) {
  $("connection").textContent = text;
  $("connection").dataset.state = kind;
}

/** @type {Record<string, Answer>} */
const answers = {
  welcome(message) {
    $("banner").hidden = true;
    state("live", "live");
    controls.strategies(message.strategies);
    $("title").textContent = message.title;
    document.title = message.title ? `${message.title}: feasibee` : "feasibee: live arena";
    listReplays(message);
    if (wanted) return begin(wanted.step, wanted.which);
    const { seed, run } = readAddress();
    point ??= seed === null || message.point !== null ? message.point : null;
    begin(0, { seed: seed ?? (point === message.point ? message.seed : null), run: run ?? message.run });
  },
  opened(message) {
    const old = world;
    world = message;
    player.clear();
    player.last = message.last;
    player.asked = true; // the first frame comes by itself
    shownStep = -1;
    shownDecision = null;
    arena.open(message);
    fit();
    plot.clear(message);
    controls.show(message);
    $("controls").inert = false;
    $("toml").textContent = message.toml;
    $("last").textContent = number(message.last);
    $("truth").textContent = `${message.truth ? "feasible" : "infeasible"} (${message.proof})`;
    $("stopped-row").hidden = message.counted[0] === message.counted[1] && !message.fields["faults.stopped"];
    $("committed-row").hidden = $("legend-committed").hidden = !message.commits;
    $("legend-stopped").hidden = !message.fields["faults.stopped"];
    $("legend-liar").hidden = !message.fields["faults.byzantine"];
    for (const item of /** @type {HTMLCollectionOf<HTMLElement>} */ ($("replay-list").children)) {
      const shown = item.dataset.key === replayKey(point, message.run);
      item.firstElementChild?.setAttribute("aria-current", String(shown));
    }
    if (old) say(`Seed ${message.seed}, run ${message.run}, from the start`);
    writeAddress(message);
    dirty = true;
  },
  error(message) {
    veil("");
    if (wanted)
      player.asked = false; // the swarm before goes on
    else player.halt();
    reflectPlay();
    wanted = null;
    controls.refuse(message.problems);
  },
  compiling(message) {
    clearTimeout(waitingFor);
    veil(message.text);
  },
  going(message) {
    clearTimeout(waitingFor);
    veil(`Going to step ${number(message.to)}: ${number(message.step)} so far`);
  },
  full(message) {
    $("banner-text").textContent = message.text;
    $("banner").hidden = false;
    state("full", "lost");
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
      veil("");
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
    veil("");
    state("not connected", "lost");
    if (world && !wanted)
      wanted = { step: player.frames[0].step, which: { seed: world.seed, run: world.run } };
    player.asked = true;
    if (!full)
      $("banner-text").textContent =
        `The server doesn't answer. This page goes on where it was as soon as it does; next attempt in ${Math.ceil(wait / 1000)} s.`;
    full = false;
    $("banner").hidden = false;
  },
});

/** @param {number} value */
function number(value) {
  return value.toLocaleString("en");
}

/**
 * @param {number | null} point
 * @param {string} run
 */
const replayKey = (point, run) => `${point} ${run}`;

/** @param {{replays: Replay[], pick: string, found: number}} message */
function listReplays({ replays, pick, found }) {
  $("replays").hidden = !replays.length;
  /** @type {Record<string, string>} */
  const kinds = {
    wrong: "decided wrong",
    right: "decided right",
    undecided: "didn't decide",
    all: "there are",
  };
  $("replays-title").textContent =
    `${number(found)} runs that ${kinds[pick] ?? `decided ${pick}`}${found > replays.length ? `; ${replays.length} of them` : ""}`;
  $("replay-list").replaceChildren(
    ...replays.map((replay) => {
      const item = document.createElement("li"),
        button = document.createElement("button");
      const main = document.createElement("span"),
        more = document.createElement("small");
      const values = Object.entries(replay.values).map(([path, value]) => `${path} ${value}`);
      main.textContent = values.join(", ") || `point ${replay.point}`;
      more.textContent = `run ${replay.run}: ${replay.decision}${replay.decision_step >= 0 ? ` at ${replay.decision_step}` : ""}`;
      button.type = "button";
      button.append(main, more);
      button.addEventListener("click", () => {
        point = replay.point;
        controls.changes = {};
        begin(0, { seed: replay.seed, run: replay.run });
      });
      item.dataset.key = replayKey(replay.point, replay.run);
      item.append(button);
      return item;
    }),
  );
}

function colours() {
  const probe = document.createElement("span");
  document.body.append(probe);
  const found = /** @type {Record<Shade, string>} */ ({});
  for (const name of SHADES) {
    probe.style.color = `var(--${name})`;
    found[name] = getComputedStyle(probe).color;
  }
  probe.remove();
  return found;
}

/**
 * @param {Frame} frame
 * @param {number} time
 */
function show(frame, time) {
  const exploring = frame.working - frame.disseminating;
  if (frame.step !== shownStep) {
    const undecided = frame.counted - frame.feasible - frame.infeasible;
    /** @type {Record<string, number>} */
    const values = { feasible: frame.feasible, infeasible: frame.infeasible, undecided, exploring };
    Object.assign(values, {
      disseminating: frame.disseminating,
      committed: frame.committed,
      now: frame.step,
    });
    values.stopped = frame.robots - frame.working;
    for (const [id, value] of Object.entries(values)) $(id).textContent = number(value);
    const bits = frame.step ? frame.bits / frame.robots / frame.step : 0;
    $("bits").textContent = bits.toPrecision(3).replace(/\.?0+$/, "");
    $("undecided-row").hidden = $("legend-undecided").hidden =
      !undecided && !frame.marks.some((marks) => marks & NEUTRAL);
    const whole = Math.max(1, frame.counted);
    const [left, middle, right] = /** @type {HTMLCollectionOf<HTMLElement>} */ ($("bar").children);
    left.style.width = `${(100 * frame.feasible) / whole}%`;
    middle.style.width = `${(100 * undecided) / whole}%`;
    right.style.width = `${(100 * frame.infeasible) / whole}%`;
    decide(frame);
    shownStep = frame.step;
    plotted = Math.min(plotted, time - PLOT_PAUSE + 1);
  }
  if (plot.shown !== frame.step && (time - plotted >= PLOT_PAUSE || !player.playing)) {
    plot.show(
      frame.step,
      frame.decisionStep >= 0 && frame.decisionStep <= frame.step ? frame.decisionStep : -1,
    );
    plotted = time;
  }
}

/**
 * Say what the swarm decided first, and whether it is right.
 * @param {Frame} frame
 */
function decide(frame) {
  const key = `${frame.firstDecision} ${frame.decision}`;
  if (key === shownDecision) return;
  const first = WORDS[frame.firstDecision],
    now = WORDS[frame.decision],
    decided = frame.firstDecision >= 0;
  const right = decided && (frame.firstDecision === 1) === world?.truth;
  $("decision").textContent = decided ? `${first}, since step ${number(frame.decisionStep)}` : "undecided";
  if (decided && now !== first)
    $("decision").textContent = `first ${first}, at step ${number(frame.decisionStep)}; now ${now}`;
  $("verdict").dataset.verdict = decided ? (right ? "right" : "wrong") : "";
  $("judgement").textContent = decided ? `The swarm's decision is ${right ? "right" : "wrong"}.` : "";
  if (decided && shownDecision !== null && shownDecision.startsWith("-1"))
    say(
      `The swarm has decided at step ${frame.decisionStep}: ${first}. That is ${right ? "right" : "wrong"}.`,
    );
  shownDecision = key;
}

/** @param {PointerEvent} event */
function point_at(event) {
  const robot = arena.at(event.clientX, event.clientY);
  if (robot !== arena.pointed) dirty = true;
  arena.pointed = robot;
}

/** @param {number} robot */
function className(robot) {
  for (const [name, count] of world?.robotClasses ?? []) {
    if (robot < count) return name;
    robot -= count;
  }
  return "";
}

/** @param {Frame} frame */
function tip(frame) {
  const robot = arena.pointed,
    box = $("tip");
  box.hidden = robot < 0 || robot >= frame.robots;
  if (box.hidden) return;
  const marks = frame.marks[robot];
  const words = [
    marks & NEUTRAL ? "no opinion" : marks & FEASIBLE ? "feasible" : "infeasible",
    !(marks & WORKING) ? "stopped" : marks & DISSEMINATING ? "disseminating" : "exploring",
    className(robot) && `class ${className(robot)}`,
    marks & LIAR && "liar",
    marks & STUBBORN && "stubborn",
    marks & COMMITTED && "committed",
    !(marks & COUNTED) && "not counted",
  ];
  const text = `Robot ${robot}: ${words.filter(Boolean).join(", ")}`;
  if (box.textContent !== text) box.textContent = text;
  const [x, y] = arena.placeOf(robot);
  const left = Math.max(0, Math.min(canvas.offsetLeft + x + 14, $("frame").clientWidth - box.offsetWidth));
  const top = canvas.offsetTop + y + (y > 60 ? -14 - box.offsetHeight : 18);
  box.style.transform = `translate(${left}px, ${top}px)`;
}

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
    if (plot.shown !== view.now.step) dirty = true;
    show(view.now, time);
    tip(view.now);
  }
  requestAnimationFrame(tick);
}

function reflectPlay() {
  $("play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
  $("play").dataset.playing = String(player.playing);
  $("arena").setAttribute(
    "aria-label",
    world
      ? `The arena: ${world.robots} robots and ${world.tasks} tasks, ${player.playing ? "playing" : `at step ${player.frames[0]?.step ?? 0}`}`
      : "The arena",
  );
}

function reflectSpeed() {
  move();
  $("speed").textContent = `${number(player.speed)} ${player.speed === 1 ? "step" : "steps"} / s`;
}

/** @param {boolean} playing */
function restart(playing) {
  startAfter = playing;
  begin(0);
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
  faster: () => speed(1),
  slower: () => speed(-1),
  another() {
    const run = controls.input("run");
    run.value = String(BigInt(/^\d+$/.test(run.value) ? run.value : "-1") + 1n);
    begin(0);
  },
  help: () => (help.open ? help.close() : help.showModal()),
};

/** @param {number} by */
function speed(by) {
  const place = SPEEDS.indexOf(player.speed) + by;
  player.speed = SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, place))];
  reflectSpeed();
}

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
  if (event.key === " " && at.closest("button, summary")) return; // it presses that
  const action = KEYS[event.key];
  if (!action) return;
  event.preventDefault();
  actions[action]();
});
for (const id of ["play", "step", "restart", "faster", "slower", "another"])
  $(id).addEventListener("click", () => actions[id]());
$("skip").addEventListener("click", () => $("play").focus()); // no link: the address keeps the run
$("help-open").addEventListener("click", actions.help);
$("retry").addEventListener("click", () => connection.open());
$("reset").addEventListener("click", () => {
  controls.changes = {};
  begin(0);
});
$("copy").addEventListener("click", async () => {
  try {
    await navigator.clipboard.writeText($("toml").textContent);
    $("copy").textContent = "Copied";
  } catch {
    getSelection()?.selectAllChildren($("toml")); // a page by http from another machine has no clipboard
    $("copy").textContent = "Selected: press Ctrl-C";
  }
  setTimeout(() => ($("copy").textContent = "Copy"), 2000);
});
$("frame").addEventListener("pointermove", point_at);
$("frame").addEventListener("pointerdown", point_at);
$("frame").addEventListener("pointerleave", () => {
  arena.pointed = -1;
  dirty = true;
});
addEventListener("hashchange", () => begin(0, readAddress()));

/** @type {Record<string, string>} */
const THEMES = { auto: "as the system", light: "light", dark: "dark" };
/** @type {Record<string, string>} */
const THEME_SIGNS = { auto: "◐", light: "○", dark: "●" };
/** @param {string} theme */
function setTheme(theme) {
  settings.theme = theme in THEMES ? theme : "auto";
  if (theme === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = settings.theme;
  $("theme").setAttribute("aria-label", `Theme: ${THEMES[settings.theme]}`);
  $("theme").title = `Theme: ${THEMES[settings.theme]}`;
  $("theme").textContent = THEME_SIGNS[settings.theme];
  localStorage.setItem("theme", settings.theme);
  repaint();
}
function repaint() {
  arena.setColours(colours());
  plot.setColours(colours());
  dirty = true;
}
$("theme").addEventListener("click", () => {
  const names = Object.keys(THEMES);
  setTheme(names[(names.indexOf(settings.theme) + 1) % names.length]);
});
dark.addEventListener("change", repaint);
function move() {
  player.smooth = !calm.matches;
  arena.calm = calm.matches || player.speed > 60; // so many flashes would only flicker
}
calm.addEventListener("change", move);
function fit() {
  if (!world) return;
  arena.layout();
  for (const id of ["transport", "legend"]) $(id).style.maxWidth = $("arena").style.width;
  dirty = true;
}
new ResizeObserver(fit).observe($("frame"));
new ResizeObserver(() => plot.resize()).observe($("plot"));

setTheme(localStorage.getItem("theme") ?? "auto");
reflectPlay();
reflectSpeed();
requestAnimationFrame(tick);
