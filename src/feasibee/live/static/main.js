// The page: show what the server sends, send what the user does.

import { Connection } from "./connection.js";
import { Controls, RateOfChange, readAddress, writeAddress } from "./controls.js";
import { $, announce, formatted } from "./elements.js";
import { Hands } from "./hands.js";
import { Inspector, listenToArena } from "./inspector.js";
import { listenToKeys } from "./keys.js";
import { Lane } from "./lane.js";
import { buildMore } from "./more.js";
import { openField, showBanner, showConnection, showField, Veil } from "./notices.js";
import { Player } from "./player.js";
import { Readings } from "./readings.js";
import { listReplays, markReplay } from "./replays.js";
import { SeekBar } from "./seekbar.js";
import { Seeker } from "./seeker.js";
import { explainTerms } from "./terms.js";
import { startTheme } from "./theme.js";
import { sketching, Tools } from "./tools.js";
import { EVENTS, handled, listenToCopy, sayTouching, touched } from "./touching.js";
import { Walls } from "./walls.js";

/** @import { Opened, View } from "./arena.js" */
/** @import { Input, Which } from "./controls.js" */
/** @import { Frame } from "./frames.js" */
/** @import { Goal } from "./seeker.js" */
/** @import { Change } from "./touching.js" */

const help = /** @type {HTMLDialogElement} */ ($("help"));
const LOOK = 1000; // milliseconds between two looks whether another field has begun
const AGAIN = 30; // milliseconds between two looks ahead

/** @type {Opened | null} */
let world = null; // the run that the page shows
/** @type {number | null} */
let point = null; // of a sweep, or null
/** @type {{step: number, which: Which, request: number, then?: Goal} | null} */
let wanted = null; // requested, and not shown yet; then: where to go in it
let requests = 0; // for runs, so far
/** @type {(() => void)[]} */
const later = []; // what sliders and hands change as soon as the wanted run is shown
let startAfter = false; // whether to play as soon as the first frame is there
let looking = 0; // timer
let full = false; // whether the server has too many pages already
/** @type {Frame | null} */
let beside = null; // the frame of the second swarm, which comes before that of the first

startTheme(repaint);
const player = new Player($("arena"), (steps) => connection.send({ type: "advance", steps }), draw);
const seeker = new Seeker((message) => {
  player.asked = true; // no more frames of other steps
  sendInspected();
  connection.send(message);
});
const lanes = [0, 1].map(
  (lane) =>
    new Lane(
      lane,
      () => player.wake(),
      (robot) => {
        if (isOnTheWay() || world?.field) return false;
        connection.send({ type: "why", robot, lane });
        return true;
      },
    ),
);
const readings = new Readings(lanes);
const controls = new Controls(
  /** @type {HTMLFormElement} */ ($("controls")),
  () => begin(0),
  (path, value) => touch(path, value),
);
const seekBar = new SeekBar((step) => seek(step));
const inspector = new Inspector(inspect);
const change = new RateOfChange(controls, (stream) => {
  startAfter = player.playing || stream;
  begin(0);
});
const sketch = sketching(lanes, () => player.wake());
const walls = new Walls(drawWalls, sketch);
const hands = new Hands(happen, sketch, announce);
const tools = new Tools($("tools"), lanes, { ...hands.tools, ...walls.tools });
/** @type {Record<string, unknown> | null} */
let accepted = null; // the changes before walls that the server has not accepted yet
const veil = new Veil();

// The swarms that the page shows: one, or two side by side.
function shownLanes() {
  return lanes.slice(0, world?.swarms ?? 1);
}

/**
 * Take point and changes from the address.
 * @returns {Which}
 */
function followAddress() {
  const kept = readAddress();
  controls.changes = kept.changes;
  controls.against = kept.against;
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
  const { changes } = controls,
    against = controls.against || null,
    request = ++requests;
  wanted = { step, which, request };
  seeker.next = null;
  veil.prepare();
  connection.send({ type: "open", request, point, changes, against, ...which, step });
}

/**
 * Go to a step of this run, or to the decision of one of its swarms.
 * @param {number | "decision"} to
 * @param {number} lane
 */
function seek(to, lane = 0) {
  if (wanted) wanted.then = { to, lane };
  if (!world || wanted) return;
  inspector.words = [[], []]; // what is known at other steps
  seeker.seek({ to: to === "decision" ? to : Math.max(0, Math.min(to, world.last)), lane });
}

/**
 * Change the world from the next step on, as an event of the scenario; what was changed at this step, while time stands
 * still, is amended. Return whether it can be: otherwise the run starts again.
 * @param {string} path
 * @param {number} count
 */
function touch(path, count) {
  const name = EVENTS[path],
    now = player.frames[0];
  if (!name || !world || world.fixed || !now?.step || now.step >= world.last) return false;
  if (wanted) {
    later.push(() => touch(path, count));
    return wanted.step > 0; // a run that starts anyway takes it from its start
  }
  const { events, step } = touched(world.events, now, name, count, player.playing);
  controls.input(path).value = String(world.fields[path]);
  amend(events, step);
  announce(`From step ${formatted(step)} on: ${formatted(count)} ${name}`);
  return true;
}

/**
 * Let what a hand does be an event of the run.
 * @param {Change} event
 * @param {string} told What it changes.
 */
function happen(event, told) {
  const now = player.frames[0];
  if (!world || !now || now.step >= world.last)
    return announce("The run is over: go back to an earlier step.");
  if (wanted) {
    later.push(() => happen(event, told));
    return;
  }
  const { events, step } = handled(world.events, now.step, event, player.playing);
  amend(events, step);
  announce(`From step ${formatted(step)} on: ${told}`);
}

/**
 * Begin the run with these events from a step on.
 * @param {Opened["events"]} events
 * @param {number} step
 */
function amend(events, step) {
  accepted ??= controls.changes;
  controls.changes = { ...controls.changes, events };
  begin(step);
}

/** @param {[number, number][][]} polygons The walls of the place from now on. */
function drawWalls(polygons) {
  accepted ??= controls.changes;
  controls.changes = { ...controls.changes, "place.walls": polygons, "arena.boundary": "walls" };
  begin(0);
}

// The step that is shown.
const shownStep = () => player.frames[0]?.step ?? 0;

/** @param {number} robot */
function inspect(robot) {
  for (const each of lanes) each.follow(robot);
  player.wake();
  mark();
  if (!world || wanted) return;
  if (player.playing && !seeker.goal) sendInspected();
  else seeker.again(shownStep()); // it brings what the robot knows
  look();
}

// Show what is found of what lies ahead.
function mark() {
  seekBar.mark(
    shownLanes().map((each) => each.outlook),
    lanes[0].shades,
  );
}

// Ask the server for what lies ahead, a little at a time, until all marks of the seek bar are found.
function look() {
  clearTimeout(looking);
  const lane = shownLanes().find((each) => each.world && !each.outlook.done);
  if (!lane) return;
  if (isOnTheWay()) return lookSoon();
  const { robot, changes, world } = lane.outlook;
  connection.send({ type: "look", robot, lane: lane.number, first: changes.length, seen: world.length });
}

function lookSoon() {
  clearTimeout(looking);
  looking = setTimeout(look, AGAIN);
}

// Whether the server is on the way to a step: another message would make it stop there.
function isOnTheWay() {
  return !world || wanted !== null || seeker.goal !== null;
}

function sendInspected() {
  connection.send({ type: "inspect", robot: inspector.robot < 0 ? null : inspector.robot });
}

/** @type {Record<string, (message: any) => void>} Handlers of the messages of the server. */
const answers = {
  welcome(message) {
    $("banner").hidden = true;
    showConnection("live", "live");
    if (!$("more-fields").childElementCount) {
      buildMore(message.form, (path) => controls.inputs.has(path));
      for (const input of /** @type {NodeListOf<Input>} */ ($("more-fields").querySelectorAll("[data-path]")))
        controls.add(input);
    }
    controls.strategies(message.strategies);
    change.stream = message.stream;
    $("title").textContent = message.title;
    document.title = message.title ? `${message.title}: feasibee` : "feasibee: live arena";
    listReplays(message, (replay) => {
      point = replay.point;
      controls.changes = {};
      startAfter = true;
      begin(0, { seed: replay.seed, run: replay.run });
    });
    if (wanted) return begin(wanted.step, wanted.which);
    const { seed, run } = followAddress();
    point ??= seed === null || message.point !== null ? message.point : null;
    begin(0, { seed: seed ?? (point === message.point ? message.seed : null), run: run ?? message.run });
  },
  opened(message) {
    lanes[message.lane].open(message);
    if (message.lane) return;
    const old = world,
      isLate = wanted !== null && wanted.request !== message.request;
    world = /** @type {Opened} */ (message);
    player.clear();
    player.last = message.last;
    player.asked = true; // the first frame comes without a request
    seeker.reset();
    seekBar.open(message.last);
    inspector.open(message.numbers);
    if (!isLate) change.open(message);
    if (!message.field) walls.open(message);
    accepted = null;
    document.body.dataset.swarms = message.swarms;
    readings.open(message);
    for (const each of document.querySelectorAll(".which")) each.textContent = `Left: ${message.strategy}`;
    startAfter ||= Boolean(message.field);
    if (message.field) return reflectSpeed(openField(message));
    $("controls").inert = false;
    if (isLate) return; // the controls, and the address, are those of a newer request
    controls.show(message);
    sayTouching(message.fixed);
    tools.offer((name) => !message.fixed || !(name in hands.tools));
    markReplay(point, message.run);
    if (old) announce(`Seed ${message.seed}, run ${message.run}, from the start`);
    writeAddress(message, point, controls.against, controls.changes);
  },
  frame: receive,
  tasks(message) {
    if (message.generation !== world?.generation) return;
    fit();
    for (const each of shownLanes()) each.arena.setTasks(message);
  },
  field: (message) => (player.last = showField(message, player.last)),
  another() {
    announce("Another field has begun");
    begin(0);
  },
  robot(message) {
    if (message.generation !== world?.generation || message.jump !== seeker.jump) return;
    inspector.hear(message);
    player.wake();
  },
  why(message) {
    if (message.generation !== world?.generation || message.jump !== seeker.jump) return;
    lanes[message.lane].why = message;
    player.wake();
  },
  predicted(message) {
    if (message.generation !== world?.generation) return;
    lanes[message.lane].foretell(message);
    player.wake();
  },
  outlook(message) {
    if (message.generation === world?.generation && lanes[message.lane].foresee(message)) mark();
    lookSoon();
  },
  undecided({ lane, last }) {
    const which = world?.swarms === 2 ? ` (${lanes[lane].world?.strategy})` : "";
    announce(`The swarm${which} has not decided by step ${formatted(last)}`);
  },
  error(message) {
    if (wanted && message.request && message.request !== wanted.request) return; // of an earlier request
    veil.hide();
    if (wanted)
      player.asked = false; // the previous run continues
    else player.halt();
    seeker.goal = seeker.next = null;
    startAfter = false;
    later.length = 0;
    player.wake();
    wanted = null;
    controls.changes = accepted ?? controls.changes; // without the walls that can't be
    accepted = null;
    controls.showProblems(message.problems);
  },
  going: (message) => veil.show(`Going to step ${formatted(message.to)}: ${formatted(message.step)} so far`),
  full(message) {
    showBanner(message.text);
    showConnection("full", "lost");
    full = true;
  },
};

/** @param {Frame} frame */
function receive(frame) {
  if (frame.generation !== world?.generation) return;
  lanes[frame.lane].keep(frame);
  if (frame.jump !== seeker.jump) return;
  lanes[frame.lane].there = { robots: frame.there, tasks: frame.tasks };
  if (frame.lane) {
    beside = frame;
    return;
  }
  if (world.swarms === 2 && beside?.step === frame.step) frame.beside = beside;
  if (!seeker.goal) player.add(frame);
  else {
    player.arrive(frame);
    if (!seeker.arrive()) player.asked = true; // on to the next goal
  }
  if (wanted && wanted.request !== world.request) {
    player.asked = true; // no more frames of this run
    return;
  }
  veil.hide();
  const first = wanted;
  wanted = null;
  if (startAfter) player.play(true);
  startAfter = false;
  if (!first) return;
  for (const each of lanes) each.follow(inspector.robot);
  if (inspector.robot >= 0) {
    if (player.playing) sendInspected();
    else seek(frame.step);
  }
  if (first.then) seek(first.then.to, first.then.lane);
  mark();
  look();
  if (!world.field) for (const { number } of shownLanes()) connection.send({ type: "predict", lane: number });
  later.shift()?.();
}

const connection = new Connection(
  (message) => answers[message.type]?.(message),
  (wait) => {
    veil.hide();
    showConnection("not connected", "lost");
    if (world && !wanted)
      wanted = { step: shownStep(), which: { seed: world.seed, run: world.run }, request: requests };
    player.asked = true;
    seeker.reset();
    const seconds = Math.ceil(wait / 1000);
    if (!full)
      showBanner(
        `The server doesn't answer. This page continues where it was when it does; next attempt in ${seconds} s.`,
      );
    full = false;
    $("banner").hidden = false;
  },
);

/**
 * Show a step; return whether something still moves.
 * @param {View} view
 * @param {number} time
 */
function draw({ now, next, between, calm }, time) {
  const right = now.beside && { now: now.beside, next: next?.beside ?? null, between, calm },
    moves = [lanes[0].draw({ now, next, between, calm }, time), right && lanes[1].draw(right, time)];
  readings.show(now, time, player.playing);
  controls.follow({ "robots.count": now.there, "tasks.count": now.tasks });
  if (!seeker.goal) seekBar.show(now.step);
  inspector.show(
    now.step,
    shownLanes().map((each) => each.world?.strategy ?? ""),
  );
  reflectPlay();
  return moves.includes(true) || !readings.isPlotted(now);
}

function reflectPlay() {
  const now = player.playing ? "playing" : `at step ${shownStep()}`;
  $("play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
  $("play").dataset.playing = String(player.playing);
  for (const each of lanes) each.describe(now);
}

function reflectSpeed(speed = player.speed) {
  player.speed = speed;
  $("speed").textContent = player.pace;
}

function repaint() {
  for (const each of lanes) each.repaint();
  mark();
  player.wake();
}

function fit() {
  if (!world) return;
  for (const each of shownLanes()) if (each.world) each.arena.layout();
  mark();
  player.wake();
}

/**
 * Stop, and go to a step.
 * @param {number | "decision"} to
 * @param {number} lane
 */
function stopAt(to, lane = 0) {
  if (to === "decision" && world?.field) {
    to = player.latest.decisionStep;
    if (to < 0) return announce("The field has not decided yet");
  }
  player.play(false);
  seek(to, lane);
}

/** @type {Record<string, () => void>} */
const actions = {
  play() {
    if (!player.playing && player.ended) {
      startAfter = true;
      return seek(0);
    }
    player.play(!player.playing);
  },
  step() {
    if (seeker.goal) return stopAt(seeker.from(shownStep()) + 1); // a frame that comes later would undo it
    player.step();
  },
  back: () => stopAt(seeker.from(Math.ceil(player.head)) - 1),
  decision: () => stopAt("decision"),
  "decision-1": () => stopAt("decision", 1),
  before: () => stopAt(lanes[0].changes.findLast((each) => each < seeker.from(shownStep())) ?? 0),
  after: () =>
    stopAt(lanes[0].changes.find((each) => each > seeker.from(shownStep())) ?? seeker.from(shownStep())),
  restart: () => seek(0),
  faster: () => reflectSpeed(player.nextSpeed(1)),
  slower: () => reflectSpeed(player.nextSpeed(-1)),
  another() {
    if (world?.field) return;
    const run = controls.input("run");
    run.value = String(BigInt(/^\d+$/.test(run.value) ? run.value : "-1") + 1n);
    begin(0);
  },
  inspect() {
    lanes[0].canvas.focus();
    if (inspector.robot < 0) inspector.pick(inspector.focus);
  },
  leave: () => tools.leave() || inspector.pick(-1),
  remove: () => {
    if (inspector.robot >= 0 && world && !world.fixed) hands.take({ kind: "robot", number: inspector.robot });
  },
  help: () => (help.open ? help.close() : help.showModal()),
};

listenToKeys(actions);
for (const id of ["play", "step", "back", "restart", "faster", "slower", "another"])
  $(id).addEventListener("click", () => actions[id]());
$("decision-0").addEventListener("click", actions.decision);
for (const each of lanes) {
  listenToArena(each, inspector, () => player.wake());
  new ResizeObserver(fit).observe(each.frame);
}
$("skip").addEventListener("click", () => $("play").focus()); // not a link: the address keeps the run
$("help-open").addEventListener("click", actions.help);
$("retry").addEventListener("click", () => connection.open());
$("reset").addEventListener("click", () => {
  controls.changes = {};
  controls.against = "";
  begin(0);
});
for (const id of ["copy", "copy-scenario"]) listenToCopy(id);
addEventListener("hashchange", () => begin(0, followAddress()));
new ResizeObserver(() => {
  lanes[0].plotted = -1;
  player.wake();
}).observe($("plot"));

setInterval(() => {
  if (!world?.field || !player.ended || isOnTheWay()) return;
  player.ask(1); // has another field begun?
}, LOOK);
explainTerms(/** @type {HTMLElement} */ ($("terms").lastElementChild));
reflectPlay();
reflectSpeed();
