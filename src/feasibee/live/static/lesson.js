// The lesson: figures that wait for the reader's prediction, and then show what comes of it.

import { Arena } from "./arena.js";
import { $, formatted, make } from "./elements.js";
import { Player } from "./player.js";
import { Recording } from "./recording.js";
import { drawRuns, RUNS, Swarms } from "./swarms.js";
import { TERMS } from "./terms.js";
import { coloursOf, startTheme } from "./theme.js";
import { decisionOf, questionOf, shareOf } from "./words.js";
import { worldsOf } from "./world.js";

/** @import { Frame } from "./frames.js" */
/** @import { Given } from "./world.js" */

/**
 * A figure, from lesson.py: it asks for a decision, for tasks in sight of robot 0, or for the number of right swarms. Each
 * choice has the highest number for which it is right. With "free" it asks for nothing: its strategies are the ranges of sight 1 to SIGHTS, first without names of tasks.
 * @typedef {Given & {
 *   question: string, choices: [string, number][], asks: "decision" | "sight" | "share" | "free", lasts: number,
 *   right: number,
 * }} Asked
 */

const SPEED = 20; // steps per second
const SIGHTS = 6;
const DRAG = 8; // pixels that a pointer moves for a step of a number
let figures = 0;

class Figure {
  /** @type {Recording | null} */
  recording = null; // from start() on, if it simulates
  /** @type {string | null} */
  predicted = null;
  changed = false; // whether the reader has set numbers

  /**
   * @param {HTMLElement} place
   * @param {Asked} asked
   */
  constructor(place, asked) {
    this.asked = asked;
    this.shades = coloursOf();
    this.canvas = make("canvas", { role: "img", ariaLabel: "Arena at step 0" });
    this.runs = make("canvas", { className: "runs", role: "img", hidden: true });
    this.play = make("button", { type: "button", hidden: true, textContent: "Pause" });
    this.again = make("button", { type: "button", hidden: true, textContent: "Restart" });
    this.now = make("p", { className: "muted now" });
    this.result = make("p", { className: "result", role: "status", tabIndex: -1 });
    this.knobs = /** @type {HTMLInputElement[]} */ ([...place.querySelectorAll("input[name]")]);
    for (const each of this.knobs) each.addEventListener("input", () => this.change());
    this.form = asked.asks === "free" ? this.freeFormOf(place) : this.formOf(asked);
    this.after = place.querySelectorAll(".after");
    for (const each of this.after) /** @type {HTMLElement} */ (each).hidden = true;
    const stage = make("div", { className: "stage" }, this.canvas),
      told = make("div", { className: "told" }, this.form, this.result, this.runs),
      row = make("div", { className: "row" }, this.now, this.again, this.play);
    place.querySelector(".figure")?.append(make("div", {}, stage, row), told);
    this.arena = new Arena(this.canvas, this.shades, () => this.player.wake());
    this.player = new Player(
      this.canvas,
      (steps) => this.player.add(this.frameAt(this.player.latest.step + steps)),
      (view, time, rests) => {
        this.show(view.now, rests);
        return this.arena.draw(view, time);
      },
    );
    this.player.speed = SPEED;
    this.play.addEventListener("click", () => {
      if (this.player.ended) this.restart();
      this.player.play(!this.player.playing);
    });
    this.again.addEventListener("click", () => this.restart());
  }

  /** @param {Asked} asked */
  formOf({ question, choices, asks }) {
    const name = `prediction-${++figures}`,
      button = make("button", { className: "primary", textContent: "Predict, then look" }),
      fields = make("fieldset", {}, make("legend", { textContent: question }));
    if (asks === "share") {
      const value = make("output", { ariaHidden: "true", textContent: "50" }),
        slider = make("input", { type: "range", name, min: "0", max: String(RUNS), value: "50" });
      slider.ariaLabel = question;
      slider.addEventListener("input", () => (value.textContent = slider.value));
      fields.append(make("label", { className: "row" }, slider, make("span", {}, value, ` of ${RUNS}`)));
    } else
      for (const [value] of choices)
        fields.append(
          make("label", {}, make("input", { type: "radio", name, value, required: true }), ` ${value}`),
        );
    const form = make("form", {}, fields, button);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.predict(String(new FormData(form).get(name)));
      fields.disabled = true;
      button.remove();
    });
    return form;
  }

  /** @param {HTMLElement} place */
  freeFormOf(place) {
    const form = /** @type {HTMLFormElement} */ (place.querySelector("form")),
      button = /** @type {HTMLButtonElement} */ (form.querySelector("button"));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      button.remove();
      this.change();
      this.play.focus();
    });
    return form;
  }

  // Simulate with the numbers that the reader has set, in the text or among the sliders.
  change() {
    const { asked, knobs, world, form } = this;
    if (!world || knobs.some((each) => !each.checkValidity())) return;
    /** @type {Record<string, number>} */
    const set = {};
    for (const each of knobs) {
      set[each.name] = each.type === "checkbox" ? Number(each.checked) : each.valueAsNumber;
      if (each.nextElementSibling instanceof HTMLOutputElement)
        each.nextElementSibling.textContent = each.value;
    }
    const { sight, names, ...numbers } = set,
      strategy = sight ? SIGHTS * names + sight - 1 : asked.settings.strategy;
    asked.settings = { ...asked.settings, ...numbers, strategy };
    if (form.querySelector("button")) return; // it waits for that
    this.changed = true;
    this.play.hidden = this.again.hidden = this.runs.hidden = false;
    this.recording = new Recording(world, asked.settings);
    this.recording.openIn(this.arena);
    this.restart();
    this.swarms?.begin(asked.settings);
    this.showShare();
  }

  // Make the worlds, and show the first step.
  async start() {
    const { asked, arena } = this;
    const [world, other] = await worldsOf(asked, 2);
    this.world = world;
    this.recording = new Recording(world, asked.settings);
    this.swarms = new Swarms(other, () => this.showShare());
    this.recording.openIn(arena);
    if (asked.asks === "sight") arena.chosen = 0;
    this.restart();
    new ResizeObserver(() => this.repaint()).observe(/** @type {HTMLElement} */ (this.canvas.parentElement));
  }

  restart() {
    const { player } = this,
      playing = player.playing;
    player.clear();
    player.add(this.frameAt(0));
    player.play(playing);
  }

  /** @param {number} step */
  frameAt(step) {
    const recording = /** @type {Recording} */ (this.recording),
      frame = recording.frame(Math.min(step, this.asked.lasts));
    this.player.last = Math.min(recording.last, this.asked.lasts);
    return frame;
  }

  /** @param {string} value */
  predict(value) {
    this.predicted = value;
    this.play.hidden = this.again.hidden = false;
    (this.recording ? this.play : this.result).focus();
    if (this.recording) this.player.play(true);
    if (this.asked.asks !== "share") return;
    this.runs.hidden = false;
    this.swarms?.begin(this.asked.settings);
    this.showShare();
  }

  /**
   * @param {Frame} frame
   * @param {boolean} rests
   */
  show(frame, rests) {
    const { asked, recording, player } = this,
      { step, feasible, infeasible } = frame;
    if (!recording) return;
    this.play.textContent = player.playing ? "Pause" : player.ended ? "Play again" : "Play";
    this.now.textContent = `Step ${formatted(step)}: ${feasible} feasible, ${infeasible} infeasible`;
    if (!rests) return;
    this.canvas.ariaLabel = `Arena. ${this.now.textContent}`;
    if (this.predicted === null || !player.ended || asked.asks === "share") return;
    if (asked.asks === "decision") this.tell(recording.decision, decisionOf(recording, frame).text);
    else {
      const seen = this.seen(recording);
      this.tell(seen, `It had ${seen} of the ${recording.taskX.length} tasks in sight.`);
    }
  }

  /**
   * The number of tasks that robot 0 has had in sight.
   * @param {Recording} recording
   */
  seen({ steps, taskX, taskY }) {
    const { lengths, lasts } = this.asked,
      { size, sight, walls } = lengths,
      unit = 65536 / Math.max(...size),
      shown = steps.slice(0, lasts + 1);
    /** @type {(from: number, to: number, side: number) => number} */
    const way = (from, to, side) => {
      const apart = Math.abs(from - to) / unit;
      return walls ? apart : Math.min(apart, side - apart);
    };
    /** @param {number} k */
    const isSeen = (k) =>
      shown.some(
        ({ x, y }) => Math.hypot(way(x[0], taskX[k], size[0]), way(y[0], taskY[k], size[1])) <= sight,
      );
    return [...taskX.keys()].filter(isSeen).length;
  }

  /**
   * @param {number} outcome
   * @param {string} text
   */
  tell(outcome, text) {
    const [is] =
      this.asked.choices.toSorted(([, a], [, b]) => a - b).find(([, most]) => outcome <= most) ?? [];
    this.result.textContent = `${text} You predicted: ${this.predicted}${is === this.predicted ? ", and so it came" : ""}.`;
    this.reveal();
  }

  showShare() {
    const { asked, swarms, recording } = this,
      outcomes = swarms?.outcomes ?? [],
      right = outcomes.filter((each) => each.decision === asked.right).length;
    drawRuns(this.runs, { outcomes }, -1, this.shades);
    this.runs.ariaLabel = `A mark for the decision of each of ${outcomes.length} swarms`;
    if (outcomes.length < RUNS) return;
    if (this.changed && swarms && recording) {
      const { question, answer } = questionOf(asked.settings, recording.missing[0]);
      this.result.textContent = [question, `${answer}.`, ...swarms.sentences()].join(" ");
    } else
      this.result.textContent = `${right} of ${RUNS} swarms decided rightly: a share of ${shareOf(right, RUNS)}. You predicted ${this.predicted}.`;
    this.reveal();
  }

  reveal() {
    for (const each of this.after) /** @type {HTMLElement} */ (each).hidden = false;
  }

  repaint() {
    this.shades = coloursOf();
    this.arena.setColours(this.shades);
    if (!this.runs.hidden) this.showShare();
    this.player.wake();
  }
}

/**
 * Let a pointer drag a number to the right and to the left.
 * @param {HTMLInputElement} input
 */
function letDrag(input) {
  let from = 0,
    value = 0;
  input.addEventListener("pointerdown", ({ pointerId, clientX }) => {
    input.setPointerCapture(pointerId);
    [from, value] = [clientX, input.valueAsNumber];
  });
  input.addEventListener("pointermove", ({ pointerId, clientX }) => {
    const moved = value + Math.round((clientX - from) / DRAG),
      to = Math.min(Number(input.max), Math.max(Number(input.min), moved));
    if (!input.hasPointerCapture(pointerId) || to === input.valueAsNumber) return;
    input.valueAsNumber = to;
    input.dispatchEvent(new Event("input"));
  });
}

/**
 * Explain a word where it stands, on hover and on focus; Escape closes the note.
 * @param {HTMLElement} word
 * @param {number} k
 */
function explain(word, k) {
  const [, text] = TERMS.find(([term]) => term === word.dataset.term) ?? [],
    note = make("span", { id: `note-${k}`, className: "note card", role: "tooltip", textContent: text }),
    button = make("button", { type: "button", className: "term", textContent: word.textContent });
  button.setAttribute("aria-describedby", note.id);
  button.addEventListener("keydown", ({ key }) => key === "Escape" && button.blur());
  word.replaceChildren(button, note);
}

document.querySelectorAll("dfn").forEach(explain);
for (const name of ["undecided", "declared", "liar", "free", "taken"]) $(`legend-${name}`).hidden = false;
/** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll(".number")).forEach(letDrag);

/** @type {{wasm: string, figures: Record<string, Asked>}} */
const given = JSON.parse($("given").textContent ?? "");
const shown = Object.entries(given.figures).map(
  ([id, asked]) => new Figure($(id), { ...asked, wasm: given.wasm }),
);
await Promise.all(shown.map((figure) => figure.start()));
document.body.dataset.ready = "true"; // for tests
startTheme(() => shown.forEach((figure) => figure.repaint()));
