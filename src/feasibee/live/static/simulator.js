// The page: a swarm that is simulated here, its curve, and a hundred more of its kind.

import { Arena } from "./arena.js";
import { $, announce, formatted } from "./elements.js";
import { Hands } from "./hands.js";
import { listenToKeys } from "./keys.js";
import { Player } from "./player.js";
import { coloursOf, startTheme } from "./theme.js";
import { drawCurve, sayPrediction } from "./curve.js";
import { explainTerms } from "./terms.js";
import { showTooltip } from "./tooltip.js";
import { Recording } from "./recording.js";
import { Controls } from "./settings.js";
import { drawHistogram, drawRuns, runAt, RUNS, Swarms } from "./swarms.js";
import { sketching, Tools } from "./tools.js";
import { handled, listenToCopy, scenarioOf } from "./touching.js";
import { decisionOf, questionOf } from "./words.js";
import { worldsOf } from "./world.js";

/** @import { Prediction } from "./curve.js" */
/** @import { Frame } from "./frames.js" */
/** @import { Change } from "./touching.js" */
/** @import { Given, Settings, World } from "./world.js" */

const CURVE_PAUSE = 50; // milliseconds between two drawings of the curve

/** @param {string} id */
const canvasOf = (id) => /** @type {HTMLCanvasElement} */ ($(id));

class Page {
  /** @type {Recording} */
  recording; // from begin() on
  /** @type {Prediction | null} */
  prediction = null;

  /**
   * @param {Given} given
   * @param {World[]} worlds Two.
   */
  constructor(given, [world, other]) {
    this.given = given;
    this.world = world;
    this.shades = coloursOf();
    this.arena = new Arena(canvasOf("arena"), this.shades, () => this.player.wake());
    this.seek = /** @type {HTMLInputElement} */ ($("seek"));
    this.player = new Player(
      canvasOf("arena"),
      (steps) => this.player.add(this.frameAt(this.player.latest.step + steps)),
      (view, time, rests) => {
        this.show(view.now, time, rests);
        const moves = this.arena.draw(view, time),
          { pointed } = this.arena;
        showTooltip(this.arena, $("tip"), view.now, this.recording.since(pointed, view.now.step));
        return moves;
      },
    );
    this.swarms = new Swarms(other, () => this.showSwarms());
    this.curved = 0;
    this.shown = -1;
    this.said = "";
    this.controls = new Controls(
      given,
      (settings, step) => this.begin(settings, step),
      () => (this.present?.step || given.counted ? this.present : null),
    );
    const lanes = [{ frame: $("frame"), arena: this.arena }],
      sketch = sketching(lanes, () => this.player.wake()),
      hands = new Hands(this.happen.bind(this), sketch, announce);
    this.tools = new Tools($("tools"), lanes, hands.tools);
    for (const [name, isNeeded] of Object.entries(given.legend)) $(`legend-${name}`).hidden = !isNeeded;
    this.player.play(!this.player.calm.matches);
    this.setSpeed(this.player.speed);
    this.listen();
  }

  // The step that is shown, if events can change the world after it.
  get present() {
    const [now] = this.player.frames,
      { last, settings } = this.recording,
      isFixed = this.given.strategies[settings.strategy].fixed;
    return now && now.step < last && !isFixed ? { ...now, playing: this.player.playing } : null;
  }

  /**
   * Let what a hand does be an event of the run.
   * @param {Change} change
   * @param {string} told What it changes.
   */
  happen(change, told) {
    const now = this.present,
      { settings, world } = this.recording;
    if (!now) return announce("The run is over: go back to an earlier step.");
    if (change.at && !world.stands(change.at)) return announce("No robot gets there.");
    const { events, step } = handled(settings.events, now.step, change, now.playing);
    this.controls.amend(events, step, told);
  }

  /**
   * Begin a run, and show it from a step on; time goes on if it did before.
   * Return whether there is memory for it.
   * @param {Settings} settings
   * @param {number} step
   */
  begin(settings, step) {
    const { given, player } = this,
      { declares } = given.strategies[settings.strategy],
      playing = player.playing || player.ended;
    try {
      this.recording = new Recording(this.world, settings);
    } catch (error) {
      if (!(error instanceof RangeError) || !this.recording) throw error;
      this.recording.resume();
      return false;
    }
    this.recording.openIn(this.arena);
    $("legend-declared").hidden = !declares;
    this.restart(step);
    player.play(playing);
    const { seed, run } = settings,
      isFirst = JSON.stringify({ ...given.settings, seed, run }) === JSON.stringify(settings);
    this.prediction = isFirst ? given.prediction : null; // computed for the scenario that the page was made of
    sayPrediction($("theory"), this.prediction, $("tasks-marks"));
    $("toml").textContent = scenarioOf(given, settings);
    this.tools?.offer(() => !given.strategies[settings.strategy].fixed);
    this.swarms?.begin(settings);
    this.said = "";
    this.showSwarms();
    return true;
  }

  restart(step = 0) {
    this.player.clear();
    this.player.add(this.frameAt(step));
    this.shown = -1;
  }

  /** @param {number} step */
  frameAt(step) {
    const frame = this.recording.frame(Math.max(0, step));
    this.player.last = this.recording.last; // it ends where the swarm decides
    return frame;
  }

  repaint() {
    this.shades = coloursOf();
    this.arena.setColours(this.shades);
    this.shown = -1;
    this.showSwarms();
    this.player.wake();
  }

  /**
   * @param {Frame} frame
   * @param {number} time
   * @param {boolean} rests
   */
  show(frame, time, rests) {
    const { recording, player, seek } = this;
    const label = player.playing ? "Pause" : "Play";
    $("play").dataset.playing = String(player.playing);
    $("play").setAttribute("aria-label", label);
    if (frame.step === this.shown) return;
    if (!rests && time - this.curved < CURVE_PAUSE) return;
    this.curved = time;
    this.shown = frame.step;
    seek.max = String(recording.last);
    seek.value = String(frame.step);
    seek.setAttribute("aria-valuetext", `step ${frame.step} of ${recording.last}`);
    $("now").textContent = formatted(frame.step);
    $("last").textContent = formatted(recording.last);
    const { feasible, infeasible, there, tasks, counted } = frame,
      none = counted - feasible - infeasible,
      { question, answer } = questionOf({ robots: there, tasks }, recording.missing[frame.step]);
    $("question").textContent = question;
    $("truth").textContent = answer;
    this.controls.follow(frame);
    for (const [id, count] of Object.entries({ feasible, infeasible, none }))
      $(id).textContent = formatted(count);
    $("none-row").hidden = $("legend-undecided").hidden = !none;
    const { right, text } = decisionOf(recording, frame);
    $("verdict").dataset.verdict = right === null ? "" : right ? "right" : "wrong";
    $("decision").textContent = (frame.step === recording.last && this.world.problem) || text;
    if (right !== null && this.said !== text) announce((this.said = text));
    drawCurve(canvasOf("curve"), recording, frame.step, this.given.threshold, this.shades, this.prediction);
    if (rests || frame.step % 50 === 0) this.describe(frame);
  }

  /**
   * Describe both drawings to those who don't see them.
   * @param {Frame} frame
   */
  describe({ step, feasible, infeasible, there, tasks }) {
    const now = `At step ${step}, ${feasible} hold feasible and ${infeasible} infeasible.`;
    $("arena").setAttribute("aria-label", `Arena with ${there} robots and ${tasks} tasks. ${now}`);
    $("curve").setAttribute("aria-label", `Share of robots with each opinion over ${step} steps. ${now}`);
  }

  showSwarms() {
    if (!this.swarms) return;
    const { swarms, shades, recording } = this,
      sentences = swarms.sentences();
    for (const [k, id] of ["swarm-counts", "swarm-feasible", "swarm-right", "swarm-median"].entries())
      $(id).textContent = sentences[k] ?? "";
    drawRuns(canvasOf("runs"), swarms, recording.settings.run, shades);
    drawHistogram(canvasOf("histogram"), swarms, shades);
    const done = swarms.outcomes.length === RUNS;
    $("swarms").setAttribute("aria-busy", String(!done));
  }

  /** @param {number} speed */
  setSpeed(speed) {
    this.player.speed = speed;
    $("speed").textContent = this.player.pace;
  }

  /** @param {number} step */
  goTo(step) {
    this.player.arrive(this.frameAt(step));
  }

  /** @type {Record<string, () => void>} */
  actions = {
    play: () => {
      if (this.player.ended) this.restart();
      this.player.play(!this.player.playing);
    },
    step: () => this.player.step(),
    back: () => {
      this.player.play(false);
      this.goTo(Math.ceil(this.player.head) - 1);
    },
    restart: () => this.restart(),
    decision: () => {
      const { recording } = this;
      while (recording.decision < 0 && recording.known < recording.last) recording.until(recording.known + 1);
      this.goTo(recording.decision < 0 ? recording.last : recording.decisionStep);
    },
    slower: () => this.setSpeed(this.player.nextSpeed(-1)),
    faster: () => this.setSpeed(this.player.nextSpeed(1)),
    ranges: () => {
      this.arena.ranges = !this.arena.ranges;
      $("ranges").setAttribute("aria-pressed", String(this.arena.ranges));
      this.player.wake();
    },
    another: () => this.controls.set({ run: String((this.recording.settings.run + 1) % RUNS) }),
  };

  listen() {
    const pressed = Object.keys(this.actions).map((id) => [id, () => this.buttonOf(id).click()]);
    listenToKeys({ ...Object.fromEntries(pressed), leave: () => this.tools.leave() });
    for (const [id, act] of Object.entries(this.actions)) this.buttonOf(id).addEventListener("click", act);
    this.seek.addEventListener("input", () => this.goTo(this.seek.valueAsNumber));
    this.arena.followPointer($("arena"), () => this.player.wake());
    $("runs").addEventListener("click", (event) => {
      const run = runAt(canvasOf("runs"), event);
      if (run >= 0) this.controls.set({ run: String(run) });
    });
    new ResizeObserver(() => this.repaint()).observe($("frame"));
    startTheme(() => this.repaint());
  }

  /** @param {string} id Of an action. */
  buttonOf(id) {
    return $(id === "decision" ? "decision-0" : id);
  }
}

/** @type {Given} */
const given = JSON.parse($("given").textContent ?? "");
$("name").textContent = given.name;
$("version").textContent = given.version;
listenToCopy("copy-scenario");
explainTerms(/** @type {HTMLElement} */ ($("terms").lastElementChild));
new Page(given, await worldsOf(given, 2));
