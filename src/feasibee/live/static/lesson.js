// The lesson: figures that wait for the reader's prediction, and then show what comes of it.

import { Clock } from "./clock.js";
import { Engine, RUNS } from "./engine.js";
import { $, formatted, make } from "./elements.js";
import { Lane } from "./lane.js";
import { sentencesOf, showRuns } from "./swarms.js";
import { coloursOf, startTheme } from "./theme.js";
import { answerOf, questionOf, shareOf } from "./words.js";

/**
 * A figure, from lesson.py: it asks for a decision, for tasks in sight of robot 0, or for the number of right swarms. Each
 * choice has the highest number for which it is right. With "free" it asks for nothing, and its second strategy has names of tasks.
 * @typedef {Opened & {
 *   question: string, choices: [string, number][], asks: "decision" | "sight" | "share" | "free", lasts: number,
 *   right: number,
 * }} Asked
 */

class Figure {
  key = 0; // of its scenario in the worker
  /** @type {string | null} */
  predicted = null;
  changed = false; // whether the reader has set numbers

  /**
   * @param {HTMLElement} place
   * @param {Asked} asked
   * @param {Engine} engine
   */
  constructor(place, asked, engine) {
    const find = (/** @type {string} */ selector) => /** @type {any} */ (place.querySelector(selector)),
      own = find("form"), // of a figure that asks for nothing
      template = /** @type {HTMLTemplateElement} */ ($("figure"));
    find(".figure").append(template.content.cloneNode(true));
    if (own) find(".figure form").replaceWith(own);
    this.place = place;
    this.asked = asked;
    this.engine = engine;
    this.form = find(".figure form");
    this.runs = find(".runs");
    this.play = find(".play");
    this.now = find(".now");
    this.result = find(".result");
    this.knobs = /** @type {HTMLInputElement[]} */ ([
      ...place.querySelectorAll("input[name]:not([name=prediction])"),
    ]);
    for (const each of this.knobs) each.addEventListener("input", () => this.change());
    if (!own) this.fill(find("fieldset"));
    this.lane = new Lane(place.id, engine, find("canvas"), {
      redraw: () => this.clock.wake(),
      came: () => this.came(),
      counted: () => this.showShare(),
    });
    this.clock = new Clock((step, _, rests) => {
      this.show(this.history.frame(step), rests);
      this.lane.draw(step, this.clock.between);
    });
    this.form.addEventListener("submit", (/** @type {Event} */ event) => this.submit(event));
    this.play.addEventListener("click", () => this.clock.toggle());
    find(".again").addEventListener("click", () => this.clock.goTo(0));
  }

  get history() {
    return /** @type {RunHistory} */ (this.lane.history);
  }

  /** @param {HTMLFieldSetElement} fields Gets the question, and its choices in place of the slider if it has some. */
  fill(fields) {
    const { question, choices, asks } = this.asked,
      [legend, label] = fields.children,
      slider = /** @type {HTMLInputElement} */ (label.querySelector("input"));
    legend.textContent = slider.ariaLabel = question;
    slider.addEventListener("input", () => tellValue(slider));
    if (asks === "share") return;
    const radio = (/** @type {string} */ value) =>
      make("input", { type: "radio", name: slider.name, value, required: true });
    label.replaceWith(...choices.map(([value]) => make("label", {}, radio(value), ` ${value}`)));
  }

  /** @param {Event} event The reader predicts, or asks for what they have set. */
  submit(event) {
    const { form, asked, lane, clock } = this,
      prediction = new FormData(form).get("prediction");
    event.preventDefault();
    form.querySelector(".primary").remove();
    if (asked.asks === "free") {
      this.change();
      return this.play.focus();
    }
    form.querySelector("fieldset").disabled = true;
    this.predicted = String(prediction);
    (this.history ? this.play : this.result).focus();
    if (this.history) clock.play(true);
    if (asked.asks === "share") lane.count();
  }

  // Simulate with the numbers that the reader has set, in the text or among the sliders.
  change() {
    const { asked, knobs, form, lane } = this;
    if (!this.history || knobs.some((each) => !each.checkValidity())) return;
    const read = (/** @type {HTMLInputElement} */ { type, checked, valueAsNumber }) =>
        type === "checkbox" ? Number(checked) : valueAsNumber,
      set = Object.fromEntries(knobs.map((each) => [each.name, read(each)])),
      heard = set.sight ? { radio: set.sight } : {}; // robots hear as far as they see
    knobs.forEach(tellValue);
    asked.settings = { ...asked.settings, ...set, ...heard };
    if (form.querySelector(".primary")) return; // it waits for that
    this.changed = true;
    this.begin();
    lane.count();
    this.showShare();
  }

  // Show the first step.
  async start() {
    const { asked, lane } = this;
    this.key = await this.engine.open(asked);
    if (asked.asks === "sight") lane.arena.chosen = 0;
    this.begin();
    await new Promise((resolve) => (this.isThere = resolve));
    new ResizeObserver(() => this.repaint()).observe(lane.frame);
  }

  begin() {
    const { asked, key, lane } = this;
    lane.begin({ key, opened: asked, settings: asked.settings, lasts: asked.lasts });
  }

  // Steps of a run came: show it as soon as its first ones do.
  came() {
    const { lane, clock } = this;
    if (lane.show()) {
      clock.open(this.history, 0);
      if (this.changed) this.showShare();
    }
    clock.wake();
    this.isThere?.(true);
  }

  /**
   * @param {Frame} frame
   * @param {boolean} rests
   */
  show(frame, rests) {
    const { asked, history, clock } = this,
      { step, feasible, infeasible } = frame;
    this.play.textContent = clock.playing ? "Pause" : clock.ended ? "Play again" : "Play";
    this.now.textContent = `Step ${formatted(step)}: ${feasible} feasible, ${infeasible} infeasible`;
    if (!rests) return;
    this.lane.canvas.ariaLabel = `Arena. ${this.now.textContent}`;
    if (this.predicted === null || !clock.ended || asked.asks === "share") return;
    if (asked.asks === "decision") return this.tell(history.decision, answerOf(history, frame).text);
    const seen = this.seen();
    this.tell(seen, `It had ${seen} of the ${frame.tasks} tasks in sight.`);
  }

  // The number of tasks that robot 0 has had in sight.
  seen() {
    const { size, sight, walls } = this.asked.lengths,
      steps = Array.from({ length: this.asked.lasts + 1 }, (_, step) => this.history.frame(step)),
      { taskX, taskY } = steps[0],
      unit = 65536 / Math.max(...size);
    /** @type {(from: number, to: number, side: number) => number} */
    const way = (from, to, side) => {
      const apart = Math.abs(from - to) / unit;
      return walls ? apart : Math.min(apart, side - apart);
    };
    /** @param {number} k */
    const isSeen = (k) =>
      steps.some(
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
    this.reveal(
      `${text} You predicted: ${this.predicted}${is === this.predicted ? ", and so it came" : ""}.`,
    );
  }

  showShare() {
    const { asked, lane, history } = this,
      { outcomes } = lane,
      right = outcomes.filter((each) => each.decision === asked.right).length;
    showRuns(this.runs, outcomes);
    this.runs.ariaLabel = `A mark for the decision of each of ${outcomes.length} swarms`;
    if (!lane.isCounted) return;
    const { question, answer } = questionOf(asked.settings, history.missing[0]);
    this.reveal(
      this.changed
        ? [question, `${answer}.`, ...sentencesOf(outcomes)].join(" ")
        : `${right} of ${RUNS} swarms decided rightly: a share of ${shareOf(right, RUNS)}. You predicted ${this.predicted}.`,
    );
  }

  /** @param {string} result */
  reveal(result) {
    this.result.textContent = result;
    this.place.dataset.told = "";
  }

  repaint() {
    this.lane.arena.restyle(coloursOf());
    this.clock.wake();
  }
}

/** @param {HTMLInputElement} knob Whose value is said beside it. */
function tellValue({ value, parentElement }) {
  const output = parentElement?.querySelector("output");
  if (output) output.textContent = value;
}

/**
 * Explain a word where it stands, on hover and on focus; Escape closes the note.
 * @param {HTMLElement} word
 * @param {number} k
 */
function explain(word, k) {
  const { content } = /** @type {HTMLTemplateElement} */ ($("terms")),
    { textContent } = /** @type {Element} */ (content.querySelector(`#term-${word.dataset.term}`)),
    note = make("span", { id: `note-${k}`, className: "note card", role: "tooltip", textContent }),
    button = make("button", { type: "button", className: "term", textContent: word.textContent });
  button.setAttribute("aria-describedby", note.id);
  button.addEventListener("keydown", ({ key }) => key === "Escape" && button.blur());
  word.replaceChildren(button, note);
}

document.querySelectorAll("dfn").forEach(explain);
for (const name of ["undecided", "declared", "liar", "free", "taken"]) $(`legend-${name}`).hidden = false;

/** @type {{wasm: string, figures: Record<string, Asked>}} */
const given = JSON.parse($("given").textContent ?? ""),
  engine = new Engine(given.wasm, 1),
  shown = Object.entries(given.figures).map(([id, asked]) => new Figure($(id), asked, engine));
await Promise.all(shown.map((figure) => figure.start()));
document.body.dataset.ready = "true"; // for tests
startTheme(() => shown.forEach((figure) => figure.repaint()));
