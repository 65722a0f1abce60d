// The numbers beside the arena: step, decision, counts, and the plot of opinions.

import { $, announce, duration, formatted } from "./elements.js";
import { NEUTRAL } from "./frames.js";
import { doneAmong, doneOf, OPINIONS, questionOf } from "./words.js";

/** @import { Opened } from "./arena.js" */
/** @import { Frame } from "./frames.js" */
/** @import { Lane } from "./lane.js" */

const PLOT_PAUSE = 66; // milliseconds between two drawings of the plot

export class Readings {
  /** @param {Lane[]} lanes */
  constructor(lanes) {
    this.lanes = lanes;
    this.changes = false;
    this.step = -1; // shown
    this.seconds = 0; // per step, if the scenario says it
    /** @type {string | null} */
    this.decision = null; // shown
    this.plotted = 0; // when
    this.last = 0; // step
    this.done = ""; // shown
  }

  /**
   * Show what is known of a run before its first frame.
   * @param {Opened} world
   */
  open(world) {
    const { fields } = world;
    this.changes = world.changes;
    this.seconds = Number(fields["units.seconds"] ?? 0);
    this.step = -1;
    this.decision = null;
    $("toml").textContent = world.toml;
    $("last").textContent = formatted(world.last);
    this.last = world.last;
    $("question").textContent = questionOf(world).question;
    $("done").hidden = $("legend-free").hidden = $("legend-taken").hidden = !world.acts;
    $("legend-done").hidden = !fields["tasks.work"];
    $("legend-task").hidden = Boolean(world.acts);
    $("truth").textContent = `${world.truth ? "feasible" : "infeasible"} (${world.proof})`;
    $("legend-truth").hidden = !world.changes;
    $("stopped-row").hidden = !fields["faults.stopped"];
    $("declared-row").hidden = $("legend-declared").hidden = !world.declares;
    $("legend-stopped").hidden = !fields["faults.stopped"];
    $("legend-liar").hidden = !fields["faults.byzantine"];
  }

  /**
   * Show a frame; the plot follows at once when time stands still, and every `PLOT_PAUSE` otherwise.
   * @param {Frame} frame
   * @param {number} time
   * @param {boolean} playing
   */
  show(frame, time, playing) {
    if (frame.step !== this.step) {
      this.showCounts(frame);
      this.showDecision(frame);
      this.showDone(frame);
      this.step = frame.step;
      this.plotted = Math.min(this.plotted, time - PLOT_PAUSE + 1);
    }
    if (this.isPlotted(frame) || (time - this.plotted < PLOT_PAUSE && playing)) return;
    for (const [lane, shown] of [frame, frame.beside].entries()) if (shown) this.lanes[lane].plot(shown);
    this.plotted = time;
  }

  /** @param {Frame} frame */
  isPlotted(frame) {
    return this.lanes[0].plotted === frame.step;
  }

  /** @param {Frame} frame */
  showCounts(frame) {
    const undecided = frame.counted - frame.feasible - frame.infeasible;
    const values = {
      feasible: frame.feasible,
      infeasible: frame.infeasible,
      undecided,
      exploring: frame.working - frame.disseminating,
      disseminating: frame.disseminating,
      now: frame.step,
      stopped: frame.there - frame.working,
    };
    for (const [id, value] of Object.entries(values)) $(id).textContent = formatted(value);
    $("time").textContent = this.seconds ? `, ${duration(frame.step * this.seconds)}` : "";
    const declared = [frame.declaredFeasible, frame.declaredInfeasible].map(formatted);
    $("declared").textContent =
      `${declared[0]} feasible, ${declared[1]} infeasible, of ${formatted(frame.counted)}`;
    const bits = frame.robotSteps ? frame.bits / frame.robotSteps : 0;
    $("bits").textContent = bits.toPrecision(3).replace(/\.?0+$/, "");
    $("undecided-row").hidden = $("legend-undecided").hidden =
      !undecided && !frame.flags.some((flags) => flags & NEUTRAL);
    const whole = Math.max(1, frame.counted);
    const bars = /** @type {HTMLCollectionOf<HTMLElement>} */ ($("bar").children);
    for (const [place, count] of [frame.feasible, undecided, frame.infeasible].entries())
      bars[place].style.width = `${(100 * count) / whole}%`;
  }

  /**
   * Show whether robots that act did it.
   * @param {Frame} frame
   */
  showDone({ there, tasks, taken, standing, allTakenStep, step }) {
    if (!taken) return;
    const now = { robots: there, tasks, standing, done: doneAmong(taken), allTakenStep, step },
      { question, answer } = doneOf(now, this.last);
    $("question").textContent = question;
    if (this.done.startsWith("Not yet") && !answer.startsWith("Not yet")) announce(answer);
    $("done").textContent = this.done = answer;
  }

  /**
   * Show the swarm's first decision, or in a world that changes, what it holds and what is true at this step.
   * @param {Frame} frame
   */
  showDecision({ step, decision, firstDecision, decisionStep, truth, there, tasks }) {
    const { changes } = this,
      opinion = changes ? decision : firstDecision,
      [held, first, now, isTrue] = [opinion, firstDecision, decision, truth].map((each) => OPINIONS[each]),
      isHeld = opinion >= 0,
      word = opinion === truth ? "right" : "wrong",
      at = formatted(decisionStep),
      key = changes ? `${decision} ${isTrue}` : `${firstDecision} ${decision}`,
      was = this.decision;
    if (changes) {
      $("question").textContent = questionOf({ robots: there, tasks }).question;
      $("truth").textContent = `${isTrue} (${formatted(there)} robots, ${formatted(tasks)} tasks)`;
    }
    if (key === was) return;
    this.decision = key;
    $("decision").textContent = changes || !isHeld ? held : `${first}, since step ${at}`;
    if (!changes && isHeld && now !== first)
      $("decision").textContent = `first ${first}, at step ${at}; now ${now}`;
    $("verdict").dataset.verdict = isHeld ? word : "";
    $("judgement").textContent = isHeld
      ? `The swarm's decision is ${word}${changes ? " at this step" : ""}.`
      : "";
    if (changes && was && !was.endsWith(` ${isTrue}`))
      announce(`From step ${step} on, the tasks are ${isTrue}`);
    if (!changes && isHeld && was?.startsWith("-1"))
      announce(`The swarm has decided at step ${decisionStep}: ${first}. That is ${word}.`);
  }
}
