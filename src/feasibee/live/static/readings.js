// The numbers beside the arena: step, decision, counts, and the plot of opinions.

import { $, announce, duration, formatted } from "./elements.js";
import { NEUTRAL } from "./frames.js";
import { OPINIONS, questionOf } from "./words.js";

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
    $("question").textContent = questionOf(world).question;
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
   * Show the swarm's first decision, and whether it is right.
   * @param {Frame} frame
   */
  showDecision(frame) {
    if (this.changes) return this.showHeld(frame);
    const key = `${frame.firstDecision} ${frame.decision}`;
    if (key === this.decision) return;
    const first = OPINIONS[frame.firstDecision],
      now = OPINIONS[frame.decision],
      decided = frame.firstDecision >= 0,
      step = formatted(frame.decisionStep);
    const word = decided && frame.firstDecision === frame.truth ? "right" : "wrong";
    $("decision").textContent = decided ? `${first}, since step ${step}` : "undecided";
    if (decided && now !== first) $("decision").textContent = `first ${first}, at step ${step}; now ${now}`;
    $("verdict").dataset.verdict = decided ? word : "";
    $("judgement").textContent = decided ? `The swarm's decision is ${word}.` : "";
    if (decided && this.decision?.startsWith("-1"))
      announce(`The swarm has decided at step ${frame.decisionStep}: ${first}. That is ${word}.`);
    this.decision = key;
  }

  /**
   * Show, in a world that changes, what the swarm holds and what is true at this step.
   * @param {Frame} frame
   */
  showHeld(frame) {
    const truth = OPINIONS[frame.truth],
      held = frame.decision >= 0,
      word = frame.decision === frame.truth ? "right" : "wrong",
      key = `${frame.decision} ${truth}`;
    $("question").textContent = questionOf({ robots: frame.there, tasks: frame.tasks }).question;
    $("truth").textContent = `${truth} (${formatted(frame.there)} robots, ${formatted(frame.tasks)} tasks)`;
    if (key === this.decision) return;
    $("decision").textContent = OPINIONS[frame.decision];
    $("verdict").dataset.verdict = held ? word : "";
    $("judgement").textContent = held ? `The swarm's decision is ${word} at this step.` : "";
    if (this.decision && !this.decision.endsWith(` ${truth}`))
      announce(`From step ${frame.step} on, the tasks are ${truth}`);
    this.decision = key;
  }
}
