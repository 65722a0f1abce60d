// The page: it simulates the run that the form asks for, shows it, and says what a hundred swarms of its kind decide.

import { film, fillScreen } from "./clip.js";
import { Clock } from "./clock.js";
import { Engine } from "./engine.js";
import { $, announce, formatted } from "./elements.js";
import { watchField } from "./field.js";
import { isPythons, othersOf, SETTINGS, settingOf } from "./fields.js";
import { Form, readAddress, writeAddress } from "./form.js";
import { handTools } from "./hands.js";
import { Inspector } from "./inspector.js";
import { listenToKeys } from "./keys.js";
import { Lane } from "./lane.js";
import { Plot } from "./plot.js";
import { showMany, showReadings } from "./readings.js";
import { SeekBar } from "./seekbar.js";
import { showRuns } from "./swarms.js";
import { coloursOf, startTheme } from "./theme.js";
import { Tools } from "./tools.js";
import { canHappen, handled, scenarioOf } from "./touching.js";
import { wallTools } from "./walls.js";
import { reachOf } from "./world.js";

const PAUSE = 50; // milliseconds between two drawings of the plot
const MARKS = 250; // likewise of the seek bar's marks, while a run is simulated
const PATIENCE = 400; // milliseconds after which the page says that it simulates
const SHOWN = 5000; // milliseconds for which a notice stays

export class Page {
  /** @type {Settings} */
  settings; // of the run that was asked for last, from begin() on
  key = 0; // of the scenario that the workers have
  /** @type {Record<string, unknown>} */
  set = {}; // fields that the user has set, by path; "against" names the second swarm's strategy
  accepted = {}; // of these, when a run was last begun
  /** @type {number | null} */
  point = null; // of a sweep
  wanted = 0; // the step from which the coming run shall be shown
  begun = 0; // when it was asked for
  requests = 0;
  plotted = 0; // when the plot was drawn; 0 if it is to be drawn anew
  marked = 0; // likewise of the marks
  late = 0;
  said = ""; // below the arena
  forgets = 0;
  /** @type {Prediction | null} */
  prediction = null;
  /** @type {(at: [number, number]) => boolean} */
  reaches = () => true; // whether robots get to a point

  /** @param {Given} given */
  constructor(given) {
    this.given = given;
    this.opened = given.opened;
    const engine = (this.engine = new Engine(given.wasm, 2)),
      hear = { redraw: () => this.clock.wake(), came: () => this.came(), counted: () => this.counted() };
    this.clock = new Clock((step, time, rests) => this.draw(step, time, rests));
    this.lanes = ["arena", "arena-1"].map((id) => new Lane(id, engine, $(id), hear));
    this.plot = new Plot($("plot"), (step) => this.stopAt(step));
    this.seekBar = new SeekBar((step) => this.clock.goTo(step));
    this.inspector = new Inspector((robot) => this.inspect(robot));
    this.form = new Form($("form"), given, this);
    this.tools = new Tools($("tools"), this.lanes, hear.redraw);
    this.hands = handTools(this);
    this.tools.add(this.hands);
    if (given.server) this.tools.add(wallTools(this));
  }

  // The swarms that are shown: one, or two side by side.
  get shown() {
    return this.lanes.filter((each) => each.history);
  }

  /** @returns {RunHistory[]} */
  get histories() {
    return this.lanes.flatMap(({ history }) => history ?? []);
  }

  get history() {
    return this.histories[0];
  }

  async start() {
    const { given } = this;
    for (const id of /** @type {const} */ (["name", "version"])) $(id).textContent = given[id];
    /** @type {HTMLDetailsElement} */ ($("settings-fold")).open = matchMedia("(min-width: 1100px)").matches;
    this.setSpeed(this.clock.speed);
    this.listen();
    if (given.field) return watchField(this, given);
    await this.take(given.opened);
    await this.follow();
    if (!this.clock.calm.matches) this.clock.play(true);
  }

  // Show what the address keeps.
  async follow() {
    const kept = readAddress(this.given, this.opened);
    if (kept.set.events?.some?.((/** @type {Change} */ { at }) => at && !this.reaches(at)))
      delete kept.set.events;
    Object.assign(this, kept);
    if (kept.point === null && Object.keys(kept.set).every((path) => this.isOwn(path))) this.begin(0);
    else await this.ask(0);
  }

  /**
   * Whether the page makes a change by itself; all else needs Python.
   * @param {string} path
   */
  isOwn(path) {
    const { [path]: value } = this.set;
    if (isPythons(path, value)) return false;
    if (path === "decision.strategy" && othersOf(this.given.form).includes(String(value))) return false;
    return path === "against" || settingOf(path, this.opened) !== undefined;
  }

  /**
   * Take another scenario.
   * @param {Opened} opened
   */
  async take(opened) {
    this.opened = opened;
    this.reaches = await reachOf(opened);
    this.key = await this.engine.open(opened);
    for (const [name, isNeeded] of Object.entries(opened.legend)) $(`legend-${name}`).hidden = !isNeeded;
    $("legend-truth").hidden = !opened.lengths.changes;
    this.tools.drop();
    $("arena").dataset.ready = "true"; // for tests
  }

  /**
   * Somebody changed a field.
   * @param {string} path
   * @param {any} value Undefined or empty takes the change back.
   * @param {boolean} isLive Whether its slider still moves.
   */
  change(path, value, isLive) {
    const { step } = this.clock;
    if (value === undefined || value === "") delete this.set[path];
    else this.set[path] = value;
    if (this.isOwn(path) && value !== undefined) this.begin(step, isLive);
    else if (!isLive) void this.ask(step);
  }

  /**
   * Show a scenario anew, with other changes than those made so far.
   * @param {Record<string, unknown>} set
   * @param {number | null} [point]
   */
  restart(set = {}, point = this.point) {
    Object.assign(this, { set, point });
    void this.ask(0);
  }

  // All changes for Python, by path.
  get paths() {
    const { seed, run, against, ...paths } = this.set;
    // The radio stays, as where the page changes sight.
    if ("sensing.range" in paths) paths["radio.range"] ??= (this.settings ?? this.opened.settings).radio;
    return paths;
  }

  /**
   * Ask Python for the scenario with all changes, and show it from a step on; without Python, the page's own.
   * @param {number} step
   */
  async ask(step) {
    const request = ++this.requests,
      { point, set } = this;
    if (!this.given.server) return this.begin(step);
    const { "decision.strategy": _, ...rest } = this.paths,
      changes = this.isOwn("decision.strategy") ? rest : this.paths,
      { settings } = this.opened,
      which = { seed: String(set.seed ?? settings.seed), run: String(set.run ?? settings.run) },
      found = await fetched("open", { point, changes, ...which });
    if (request !== this.requests) return; // another one is on its way
    if (found.problems) return this.refuse(found.problems);
    await this.take(found);
    this.begin(step);
  }

  /**
   * Say why the scenario can't be; the run that is shown stays.
   * @param {{path: string, text: string}[]} problems
   */
  refuse(problems) {
    this.set = { ...this.accepted };
    if (!this.begun) {
      this.point = null;
      this.begin(0); // of what the address keeps, nothing can be
    }
    this.form.showProblems(problems);
    this.say(problems[0].text);
  }

  /**
   * Simulate the run of the changes, and show it from a step on.
   * @param {number} step
   * @param {boolean} [isLive]
   */
  begin(step, isLive = false) {
    const { key, opened, lanes } = this,
      numberOf = (/** @type {unknown} */ name) => opened.strategies.findIndex((each) => each.name === name),
      settings = (this.settings = { ...opened.settings }),
      other = numberOf(this.set.against);
    for (const [path, value] of Object.entries(this.set)) {
      const found = path === "decision.strategy" ? numberOf(value) : value,
        name = path === "events" ? path : SETTINGS[path];
      if (name && found !== -1 && !isPythons(path, value)) Object.assign(settings, { [name]: found });
    }
    this.wanted = step;
    this.begun = performance.now();
    this.accepted = { ...this.set };
    this.form.clearProblems();
    lanes[0].begin({ key, opened, settings });
    if (other >= 0) lanes[1].begin({ key, opened, settings: { ...settings, strategy: other } });
    else lanes[1].history = lanes[1].coming = null;
    for (const each of lanes) if (each.coming) each.count();
    this.prediction = null;
    clearTimeout(this.late);
    if (!isLive) this.late = setTimeout(() => this.settle(), PATIENCE);
  }

  // Nothing has changed for a while: keep it in the address, and ask what the theory says.
  async settle() {
    const { point, set, settings, given, requests } = this;
    writeAddress(set, point, settings);
    $("theory").textContent = "";
    if (!given.server) {
      if (JSON.stringify(settings) === JSON.stringify(given.opened.settings)) this.foretell(given.prediction);
      return;
    }
    const which = { seed: settings.seed, run: String(settings.run) },
      found = await fetched("predict", { point, changes: this.paths, ...which });
    if (requests === this.requests && settings === this.settings && !found.problems) this.foretell(found);
  }

  /** @param {Prediction | null} prediction */
  foretell(prediction) {
    this.prediction = prediction;
    $("theory").textContent = prediction?.text ?? "";
    this.renew();
  }

  // Steps of a run came.
  came() {
    const coming = this.lanes.filter((each) => each.coming);
    if (coming.length && coming.every((each) => each.isReady(this.wanted))) this.show();
    else if (coming.length && performance.now() - this.begun > PATIENCE)
      $("notice").textContent =
        `Simulating: step ${formatted(Math.min(...coming.map((each) => each.coming?.known ?? 0)))}`;
    if (!this.history) return;
    if (this.history.done || performance.now() - this.marked > MARKS) this.marked = 0;
    this.renew();
  }

  // More swarms came: show them soon, but don't draw for each message.
  counted() {
    const isDone = this.lanes.every((each) => each.isCounted || !each.asked);
    if (isDone || performance.now() - this.plotted > PAUSE) this.renew();
  }

  // Show the run that was coming, or say why there is none.
  show() {
    const { clock, lanes, opened, settings } = this,
      playing = clock.playing || (clock.history !== null && clock.ended && this.wanted === 0);
    for (const each of lanes) each.show();
    if (!lanes[0].history) return this.say(lanes[0].coming?.problem ?? "");
    $("notice").textContent = this.said; // no longer that it simulates
    document.body.dataset.swarms = String(this.shown.length);
    const { declares, fixed, name } = opened.strategies[settings.strategy];
    $("legend-declared").hidden = !declares;
    this.tools.offer(Object.keys(this.hands), !fixed);
    clock.open(this.history, this.wanted);
    clock.play(playing);
    this.inspector.open(this.history.robots);
    for (const each of lanes) each.arena.chosen = this.inspector.robot;
    this.marked = 0;
    if (this.given.field) return;
    $("toml").textContent = scenarioOf(opened, settings);
    this.form.open(opened, { settings, set: this.set });
    document.title = `feasibee: ${settings.robots} robots, ${settings.tasks} tasks, ${name}`;
  }

  /**
   * Show a field from a step on.
   * @param {RunHistory} history
   * @param {number} step
   */
  openField(history, step) {
    const { opened } = this,
      [lane] = this.lanes;
    this.settings = opened.settings;
    this.wanted = step;
    lane.asked = { key: 0, opened, settings: opened.settings };
    lane.coming = history;
    this.show();
    this.setSpeed(this.clock.speed);
    this.clock.play(true);
  }

  /**
   * Let what a hand does be an event of the run.
   * @param {Change} change
   * @param {string} told What it changes.
   */
  happen(change, told) {
    const { clock, settings, opened } = this,
      found = handled(settings.events, clock.step, change, clock.playing);
    if (clock.step >= opened.run.steps) return this.say("The run is over: go back to an earlier step.");
    if (!canHappen({ ...settings, events: found.events }, opened.most))
      return this.say("Not changed: a run has 1 robot or more, and not more than a page shows.");
    if (change.at && !this.reaches(change.at)) return this.say("Not changed: no robot gets there.");
    this.set.events = found.events;
    this.begin(found.step);
    this.say(`From step ${formatted(found.step)} on: ${told}`);
  }

  /** @param {[number, number][][]} polygons The walls of the place from now on. */
  drawWalls(polygons) {
    Object.assign(this.set, { "place.walls": polygons, "arena.boundary": "walls" });
    this.say("The walls are other ones: this run begins again.");
    void this.ask(0);
  }

  /**
   * Say something below the arena, for a while.
   * @param {string} text
   */
  say(text) {
    clearTimeout(this.forgets);
    this.said = $("notice").textContent = text;
    if (text) this.forgets = setTimeout(() => this.say(""), SHOWN);
  }

  /** @param {number} robot */
  inspect(robot) {
    for (const each of this.lanes) each.arena.chosen = robot;
    if (robot < 0) delete document.body.dataset.robot;
    else document.body.dataset.robot = String(robot);
    this.marked = 0;
    this.clock.wake();
  }

  // Draw the plot and say what is known at the next frame.
  renew() {
    this.plotted = 0;
    this.clock.wake();
  }

  /**
   * Show a step: first in words, then where sizes are read.
   * @param {number} step
   * @param {number} time
   * @param {boolean} rests
   */
  draw(step, time, rests) {
    const { shown, inspector, clock } = this,
      frames = this.histories.map((each) => each.frame(step)),
      isDue = rests || !this.plotted || time - this.plotted > PAUSE;
    $("play").ariaLabel = clock.playing ? "Pause" : "Play";
    $("play").dataset.playing = String(clock.playing);
    if (inspector.robot >= 0)
      for (const [k, each] of shown.entries()) each.wonder("inspect", inspector.robot, frames[k]);
    inspector.show(shown);
    if (isDue) showReadings(shown, frames);
    if (!this.plotted) this.countRuns();
    if (!this.marked) this.seekBar.mark(this.histories, inspector.robot);
    this.marked ||= performance.now();
    this.seekBar.show(step);
    for (const each of shown) {
      each.draw(step, clock.between);
      each.describe(clock.playing ? "playing" : `at step ${step}`);
    }
    if (!isDue) return;
    this.drawPlot(step);
    this.plotted = time;
  }

  // Show what a hundred swarms decide.
  countRuns() {
    const { shown } = this;
    showMany(shown);
    if (/** @type {HTMLDetailsElement} */ ($("swarms")).open)
      showRuns($("runs"), shown[0].outcomes, this.settings.run);
  }

  /** @param {number} step */
  drawPlot(step) {
    const { shown, histories, prediction } = this,
      clouds = shown[0].outcomes.map(({ course }) => course),
      names = shown.map(({ strategy }) => strategy.name);
    this.plot.draw({ histories, names, step, clouds, prediction, shades: shown[0].arena.colours });
  }

  // Draw all anew, as sizes or colours are other ones.
  repaint() {
    for (const { arena } of this.lanes) arena.restyle(coloursOf());
    this.marked = 0;
    this.renew();
  }

  /** @param {number} speed */
  setSpeed(speed) {
    this.clock.speed = speed;
    $("speed").textContent = this.clock.pace;
  }

  /** @param {number} step */
  stopAt(step) {
    this.clock.play(false);
    this.clock.goTo(step);
  }

  /** @param {number} lane */
  toDecision(lane) {
    const { history, strategy } = this.lanes[lane];
    if (!history) return;
    if (history.decision >= 0) return this.stopAt(history.decisionStep);
    this.say(`${strategy.name}: no decision by step ${formatted(history.known)}`);
  }

  /**
   * Go to the next or the last change of the inspected robot, or without one, of the truth.
   * @param {boolean} isNext
   */
  toChange(isNext) {
    const { robot } = this.inspector,
      { step } = this.clock,
      steps = (robot < 0 ? this.history.changesOfTruth() : this.history.changesOf(robot)).map(([at]) => at),
      found = isNext ? steps.find((at) => at > step) : steps.findLast((at) => at < step);
    if (found !== undefined) this.stopAt(found);
  }

  // What keys and buttons do; a button has the name of its action as id.
  /** @type {Record<string, () => void>} */
  actions = {
    play: () => this.clock.toggle(),
    step: () => this.clock.advance(),
    back: () => this.stopAt(Math.ceil(this.clock.head) - 1),
    "decision-0": () => this.toDecision(0),
    "decision-1": () => this.toDecision(1),
    before: () => this.toChange(false),
    after: () => this.toChange(true),
    restart: () => this.clock.goTo(0),
    faster: () => this.setSpeed(this.clock.nextSpeed(1)),
    slower: () => this.setSpeed(this.clock.nextSpeed(-1)),
    next: () => this.change("run", (this.settings.run + 1) % 2 ** 32, false),
    inspect: () => {
      this.lanes[0].canvas.focus();
      if (this.inspector.robot < 0) this.inspector.pick(this.inspector.focus);
    },
    leave: () => this.tools.leave() || this.inspector.pick(-1),
    remove: () => {
      const { robot } = this.inspector;
      if (robot >= 0 && !this.lanes[0].strategy.fixed) this.happen({ robot }, `robot ${robot} is gone`);
    },
    ranges: () => {
      const ranges = this.switched("ranges");
      for (const { arena } of this.lanes) Object.assign(arena, { ranges });
    },
    closer: () => {
      const times = this.switched("closer") ? 3 : 1;
      for (const { arena } of this.lanes) arena.zoom(times);
    },
    clip: () =>
      film(this.lanes[0].canvas, `feasibee-${this.settings.robots}-robots-${this.settings.tasks}-tasks`),
    full: () => void fillScreen(),
    help: () => {
      const help = /** @type {HTMLDialogElement} */ ($("keys"));
      if (help.open) help.close();
      else help.showModal();
    },
  };

  /**
   * Press or release a button that stays pressed; return whether it is pressed now.
   * @param {string} id
   */
  switched(id) {
    const isOn = $(id).ariaPressed === "false";
    $(id).ariaPressed = String(isOn);
    this.clock.wake();
    return isOn;
  }

  listen() {
    const { actions, lanes } = this;
    listenToKeys(actions);
    for (const [id, act] of Object.entries(actions))
      document.querySelector(`button#${id}`)?.addEventListener("click", act);
    for (const each of lanes) this.inspector.listen(each, () => this.clock.wake());
    const sizes = new ResizeObserver(() => this.repaint());
    for (const each of [...lanes.map(({ frame }) => frame), $("runs"), $("counts")]) sizes.observe(each);
    $("runs").addEventListener("click", ({ target }) => {
      const run = [...$("runs").children].findIndex((each) => each.contains(/** @type {Node} */ (target)));
      if (run >= 0) this.change("run", run, false);
    });
    addEventListener("hashchange", () => void this.follow());
    startTheme(() => this.repaint());
  }
}

/**
 * Ask Python; an answer that isn't one, is a problem.
 * @param {string} what
 * @param {object} asked
 */
async function fetched(what, asked) {
  try {
    const answer = await fetch(what, {
      method: "POST",
      body: JSON.stringify(asked),
      headers: { "Content-Type": "application/json" },
    });
    if (answer.headers.get("Content-Type") === "application/json") return await answer.json();
    return { problems: [{ path: "", text: await answer.text() }] };
  } catch {
    const text =
      "feasibee watch doesn't answer: this page can change only robots, tasks, strategy, seed and run until it runs again.";
    return { problems: [{ path: "", text }] };
  }
}

const page = new Page(JSON.parse($("given").textContent ?? ""));
Object.assign(globalThis, { feasibee: page }); // for tests, benchmarks, and whoever looks with the browser's tools
await page.start();
