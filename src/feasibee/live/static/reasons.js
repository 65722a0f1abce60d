// Why a robot holds its opinion, what it knows, and what comes next, in words.

import { duration, formatted } from "./elements.js";
import {
  BYZANTINE,
  DECLARED,
  DISSEMINATING,
  FEASIBLE,
  NEUTRAL,
  STUBBORN,
  THERE,
  WORKING,
  STANDING,
} from "./frames.js";
import { counted } from "./words.js";

const MOST_NAMED = 12; // most senders of one opinion that are listed
const NEVER = 2 ** 30; // stands for no step

/** @typedef {[robot: Robot, opened: Opened, strategy: number, moment: Moment]} About */

/**
 * Return what a robot knows at a step, as pairs of a title and a text.
 * @param {About} about
 */
export const reasonsOf = (...about) => new Account(...about).rows();

/**
 * Return since when a robot holds its opinion, and what it knows, for a tooltip.
 * @param {About} about
 */
export const sentenceOf = (...about) => new Account(...about).sentence();

/** @param {number} opinion */
const opinionWord = (opinion) => (opinion < 0 ? "no opinion" : opinion ? "feasible" : "infeasible");

/** @param {number} flags */
const opinionIn = (flags) => opinionWord(flags & NEUTRAL ? -1 : flags & FEASIBLE);

// A robot at a step, in words; each method has a text of its own, which is empty where there is nothing to say.
class Account {
  /** @param {About} about */
  constructor(...[robot, opened, strategy, moment]) {
    this.robot = robot;
    this.opened = opened;
    this.strategy = opened.strategies[strategy];
    this.moment = moment;
    this.disseminates = Boolean(robot.flags & DISSEMINATING);
    this.robots = robot.counts?.slice(0, robot.robotColumns); // that it has counted, by class
    this.tasks = robot.counts?.slice(robot.robotColumns);
  }

  /** @returns {[string, string][]} */
  rows() {
    const { robot, opened, strategy, disseminates } = this,
      { knowledge, name, decide, quality } = strategy;
    if (robot.problem) return [["Error", robot.problem]];
    if (!(robot.flags & THERE)) return [["Phase", "no robot has this number at this step"]];
    if (!(robot.flags & WORKING)) return [["Phase", "stopped"]];
    /** @type {[string, string | false | 0 | undefined][]} */
    const rows = [
      ["Phase", this.phase()],
      ["Acts", opened.lengths.acts && !(robot.flags & BYZANTINE) && this.deed()],
      ["Saw", !knowledge && this.seen()],
      ["Heard", (!knowledge || robot.declaresByVotes) && this.heard()],
      ["Quality", this.quality()],
      ["Knows", knowledge && this.known()],
      ["Memory", robot.memory.map((each) => String(Number(each.toPrecision(4)))).join(", ")],
      ["Next", this.next()],
      [`Rule of ${name.replace(/^.*[\\/]/, "")}`, disseminates ? decide : quality],
      ["Special", this.special()],
    ];
    return /** @type {[string, string][]} */ (rows.filter(([, text]) => text));
  }

  sentence() {
    const { robot, moment, disseminates } = this;
    if (robot.problem || !(robot.flags & THERE)) return "";
    const { held, begun } = moment.since,
      [since, from] = [held, begun].map((step) => (step ? this.at(step) : "the start")),
      does = disseminates ? "broadcasts" : "explores",
      holds = `Holds ${opinionIn(robot.flags)} since ${since} and ${does} since ${from}.`;
    if (this.strategy.knowledge) return `${holds} Knows ${this.known()}.`;
    const [yes, no] = this.votes(),
      heard = [yes && `${formatted(yes)} feasible`, no && `${formatted(no)} infeasible`];
    return `${holds} Heard ${heard.filter(Boolean).join(", ") || "nobody"} since its last decision.`;
  }

  /** @param {number} steps In brackets: in seconds, if the scenario says how long a step is. */
  inSeconds(steps) {
    const { seconds } = this.opened;
    return seconds ? ` (${duration(steps * seconds)})` : "";
  }

  /** @param {number} step */
  at(step) {
    return `step ${formatted(step)}${this.inSeconds(step)}`;
  }

  /** @param {number} steps */
  lasting(steps) {
    return `${counted(steps, "step")}${this.inSeconds(steps)}`;
  }

  // The number of messages that it has heard for feasible, and for infeasible.
  votes() {
    const { heard, votes, feasibleVotes } = this.robot;
    if (!heard.length) return [feasibleVotes, votes - feasibleVotes];
    const feasible = heard.filter(([, opinion]) => opinion).length;
    return [feasible, heard.length - feasible];
  }

  phase() {
    const { left, said } = this.robot,
      lasting = `${this.lasting(left)} left`;
    if (!this.disseminates) return `exploring, ${lasting}`;
    const what = this.strategy.knowledge ? "what it knows" : said < 0 ? "nothing" : opinionWord(said);
    return `disseminating, ${lasting}; broadcasts ${what}`;
  }

  // What it does if it may act, why, and what it knows of tasks (model.md 6.25).
  deed() {
    const { opened, robot } = this,
      { flags, aim, aimIsThere, aimHolder, aimAway, marked, tasksKnown, tasksFree } = robot,
      knows = `knows ${counted(tasksKnown, "task")}, ${tasksFree} of them as free`;
    if (flags & STANDING) return `stands at task ${aim}; ${knows}`;
    if (aim < 0) return `${this.idleness()}; ${knows}`;
    if (!aimIsThere) return `walks to task ${aim}, but it has vanished; ${knows}`;
    const metres = Number(opened.fields["units.metres"]) || 0,
      length = metres ? ` (${Number((aimAway * metres).toPrecision(4))} m)` : "",
      how = aimAway <= opened.lengths.sight ? "sees" : "saw or heard",
      but = aimHolder === -1 ? "" : aimHolder < 0 ? ", but it is done" : `, but robot ${aimHolder} has it`,
      why = marked === aim ? "it has marked it" : `it ${how} that it is free${but}`;
    return `walks to task ${aim}, ${aimAway.toFixed(1)} units${length} away: ${why}; ${knows}`;
  }

  // Why it goes to no task.
  idleness() {
    const { flags, marked, tasksKnown, tasksStay, knowsCount, atStart, actsFrom, actsByWord } = this.robot,
      declared = flags & DECLARED;
    if (declared && !(flags & (FEASIBLE | NEUTRAL))) return "doesn't act: it has declared infeasible";
    if (tasksStay && knowsCount && tasksKnown > atStart)
      return "doesn't act: it knows more tasks than there are robots";
    if (this.moment.step >= actsFrom || (actsByWord && declared)) return "knows no free task that it can do";
    const begins = actsFrom >= NEVER ? "once it declares feasible" : `from ${this.at(actsFrom)} on`;
    return `${marked < 0 ? "" : `has marked task ${marked}, and `}acts ${begins}`;
  }

  seen() {
    const { lengths } = this.opened,
      now = this.disseminates ? "in its last exploration" : "so far in this exploration",
      robots = sumOf(this.robots, lengths.robotClasses, "robot"),
      tasks = sumOf(this.tasks, lengths.taskClasses, "task"),
      each = this.robot.seesOnce ? "" : ", each counted in every step";
    return `${robots} and ${tasks} ${this.strategy.forgets ? now : "in its life"}${each}`;
  }

  // How many messages say what, and who they are from.
  heard() {
    const { heard, randomIds } = this.robot,
      votes = this.votes();
    if (!(votes[0] + votes[1])) return "nobody since its last decision";
    const parts = [1, 0].map((opinion, k) => {
      const senders = heard.filter(([, said]) => said === opinion).map(([sender]) => sender),
        more = senders.length > MOST_NAMED ? ` and ${senders.length - MOST_NAMED} more` : "",
        called = `${randomIds ? "id" : "robot"}${senders.length > 1 ? "s" : ""}`,
        names = `${called} ${senders.slice(0, MOST_NAMED).join(", ")}${more}`;
      return `${formatted(votes[k])} ${opinionWord(opinion)}${senders.length ? ` (${names})` : ""}`;
    });
    return parts.join(", ");
  }

  quality() {
    const { flags, quality } = this.robot,
      own = flags & (FEASIBLE | NEUTRAL) ? "" : `, so ${(1 - quality).toFixed(2)} for its opinion`;
    return `${quality.toFixed(2)} for feasible${own}, as it last rated it`;
  }

  // What it knows if it passes on knowledge: without names, some strategies count in parts of robots and tasks.
  known() {
    const [robots, tasks] = [this.robots, this.tasks].map(sum),
      { byName } = this.strategy;
    if (byName) return `${counted(robots, "robot")} and ${counted(tasks, "task")}, by name`;
    return `robots to tasks as ${formatted(robots)} to ${formatted(tasks)}`;
  }

  // What comes next, as the run really goes on.
  next() {
    const { step, next } = this.moment,
      { flags, left } = this.robot,
      when = `at ${this.at(next?.step ?? step + left)}`;
    if (next && !(next.flags & THERE)) return `${when} it leaves`;
    if (next && !(next.flags & WORKING)) return `${when} it stops`;
    const lasting = next?.lasts ? ` for ${this.lasting(next.lasts)}` : "",
      opinion = next && opinionIn(next.flags),
      declared = next && next.flags & DECLARED & ~flags ? `; by then it has declared ${opinion}` : "";
    if (!this.disseminates)
      return `${when} it begins to broadcast${lasting}${opinion ? `, and holds ${opinion}` : ""}${declared}`;
    if (this.strategy.judges)
      return `${when} it explores again${lasting}; its opinion follows what it knows in any step${declared}`;
    return `${when} it decides${opinion ? `: ${opinion},` : ""} and explores again${lasting}${declared}`;
  }

  special() {
    const { flags } = this.robot,
      liar = flags & BYZANTINE && "Byzantine: it broadcasts what is false",
      stubborn = flags & STUBBORN && "stubborn",
      declared = flags & DECLARED && "has declared",
      found = [liar, stubborn, declared].filter(Boolean).join(", ");
    return found && `${found}${stubborn || declared ? "; it keeps its opinion" : ""}`;
  }
}

/** @param {number[]} numbers */
const sum = (numbers) => numbers.reduce((one, other) => one + other, 0);

/**
 * @param {number[]} counts
 * @param {string[]} names
 * @param {string} word
 */
function sumOf(counts, names, word) {
  const classes = names.map((name, k) => `${name} ${formatted(counts[k])}`);
  return `${counted(sum(counts), word)}${names.length ? ` (${classes.join(", ")})` : ""}`;
}
