// The form of the page: first fields with sliders, all others where a server checks them, and runs of a sweep.

import { $, capital, make } from "./elements.js";
import { firstFields, numberOf, settingOf, SETTINGS } from "./fields.js";
import { Replays } from "./replays.js";
import { Row } from "./row.js";
import { copy, eventsIn, inToml } from "./touching.js";

/** @import { State } from "./fields.js" */
/** @import { Field } from "./row.js" */
/** @import { Opened, Page, Settings } from "./world.js" */

/** @typedef {{path: string, text: string}} Problem */

export class Form {
  /**
   * @param {HTMLElement} root
   * @param {Page} page
   * @param {(path: string, value: any, isLive: boolean) => void} change The user changed a field; undefined: back to
   *   what it was. isLive: a slider still moves. Also "reset", and "replay" for a run of a sweep.
   */
  constructor(root, page, change) {
    this.page = page;
    this.isServed = page.server;
    this.change = change;
    this.opened = page.opened;
    /** @type {State} */
    this.state = { settings: page.opened.settings, against: "", own: {}, changes: {} };
    /** @type {Map<string, Row>} */
    this.rows = new Map();
    this.replays = page.replays && new Replays(page.replays, (which) => this.take("replay", which));
    this.finder = make("input", { type: "search", id: "find", oninput: () => this.find() });
    this.found = make("small", { role: "status" });
    this.frame = 0; // before which a slider tells where it is
    this.problems = make("div", { className: "problems", role: "alert", hidden: true });
    this.density = make("input", { type: "checkbox", role: "switch", id: "density" });
    this.density.onchange = () => {
      const side = JSON.parse(String(this.opened.fields["arena.side"])); // or two
      this.start = { sides: [side].flat(), robots: this.state.settings.robots };
    };
    const form = make("form", { className: "form", noValidate: true, autocomplete: "off" }, this.problems);
    form.onsubmit = () => false;
    for (const each of firstFields(page.opened, page.form)) form.append(this.add(each).element);
    const label = make("label", { htmlFor: "density" }, "Keep the density of robots");
    this.dense = make("div", { className: "setting boolean" }, label, this.density);
    this.row("tasks.count").element.before(this.dense);
    form.append(this.buttons(), ...(this.replays ? [this.replays.element] : []));
    this.sections = (page.form ?? []).map((part) => this.section(part)).filter(({ rows }) => rows.length);
    if (page.form) form.append(this.search(), ...this.sections.map(({ details }) => details));
    root.append(form);
    this.open(page.opened);
  }

  /** @param {string} path */
  row(path) {
    return /** @type {Row} */ (this.rows.get(path));
  }

  /** @param {Field} field */
  add(field) {
    const { path } = field,
      take = (/** @type {any} */ value, /** @type {boolean} */ isLive) => this.take(path, value, isLive),
      row = new Row(field, this.isServed, take, () => this.takeBack(path));
    this.rows.set(path, row);
    return row;
  }

  /**
   * Build a folded section of fields; its title says how many aren't the default.
   * @param {{name: string, fields: Field[]}} part
   */
  section({ name, fields }) {
    const rows = fields.filter(({ path }) => !this.rows.has(path)).map((field) => this.add(field)),
      mark = make("span", { className: "mark" }),
      title = make("summary", {}, capital(name), " ", mark);
    const details = make("details", {}, title, ...rows.map(({ element }) => element));
    return { rows, mark, details, wasOpen: false };
  }

  buttons() {
    const button = (/** @type {string} */ text, /** @type {Partial<HTMLButtonElement>} */ own) =>
        make("button", { type: "button", ...own }, text),
      title = "Show the next run (n)",
      next = button("Next run", { id: "another", title, ariaKeyShortcuts: "n" }),
      scenario = button("Copy as scenario", { id: "copy-scenario" }),
      reset = button("Undo all", { id: "reset", ariaLabel: "Undo all changes" });
    next.onclick = () => this.take("run", (this.state.settings.run + 1) % 2 ** 32);
    scenario.onclick = () => copy(scenario, $("toml"));
    reset.onclick = () => {
      for (const row of this.rows.values()) row.tell("");
      this.take("reset", undefined);
    };
    return make("div", { className: "buttons" }, next, scenario, reset);
  }

  search() {
    const label = make("label", { htmlFor: "find" }, "Find a setting");
    return make("div", { className: "setting find" }, label, this.finder, this.found);
  }

  // Show the fields that have all words that are searched for, and how many they are; without words, as before.
  find() {
    const words = this.finder.value.toLowerCase().split(/\s+/).filter(Boolean),
      has = (/** @type {Row} */ row) => words.every((each) => row.words.includes(each)),
      hits = [...this.rows.values()].filter(has);
    for (const section of this.sections) {
      if (!this.isFinding) section.wasOpen = section.details.open;
      for (const row of section.rows) row.element.hidden = !has(row);
      section.details.hidden = !section.rows.some(has);
      section.details.open = words.length ? true : section.wasOpen;
    }
    this.isFinding = words.length > 0;
    for (const row of this.rows.values())
      row.element.toggleAttribute("data-found", this.isFinding && has(row));
    this.found.textContent = this.isFinding ? `${hits.length} of ${this.rows.size} settings` : "";
  }

  /**
   * Tell a change, and the arena's side if it goes with it; while a slider moves, once before each repaint.
   * @param {string} path
   * @param {any} value
   * @param {boolean} [isLive]
   */
  take(path, value, isLive = false) {
    cancelAnimationFrame(this.frame);
    if (isLive) this.frame = requestAnimationFrame(() => this.tell(path, value, true));
    else this.tell(path, value, false);
  }

  /**
   * @param {string} path
   * @param {any} value
   * @param {boolean} isLive
   */
  tell(path, value, isLive) {
    this.change(path, value, isLive);
    if (path === "arena.side" || path === "reset") this.density.checked = false;
    if (path !== "robots.count" || !this.density.checked || !this.start) return;
    const factor = Math.sqrt(Number(value ?? this.page.opened.settings.robots) / this.start.robots),
      [width, height] = this.start.sides.map((each) => Number((each * factor).toFixed(3)));
    this.change("arena.side", height === undefined ? width : [width, height], isLive);
  }

  /** @param {string} path */
  takeBack(path) {
    this.row(path).tell("");
    this.take(path, path === "against" ? "" : undefined);
  }

  /** @param {string} path */
  valueOf(path) {
    const { settings, against, changes } = this.state,
      key = settingOf(path, this.opened);
    if (path === "against") return against;
    if (path === "preset") return changes.preset;
    if (path === "events") return settings.events.length ? inToml(settings.events) : "";
    if (path === "decision.strategy") return this.opened.strategies[settings.strategy].name;
    return key ? settings[key] : (this.opened.fields[path] ?? settings[SETTINGS[path]]);
  }

  /**
   * Show what the page shows now.
   * @param {Opened} opened
   * @param {Partial<State>} state
   */
  open(opened, { settings = opened.settings, against = "", own = {}, changes = {} } = {}) {
    this.opened = opened;
    this.state = { settings, against, own, changes };
    for (const field of firstFields(opened, this.page.form)) this.row(field.path).bound(field);
    for (const [path, row] of this.rows) {
      const isChanged = path === "against" ? against !== "" : path in own || path in changes;
      row.show(this.valueOf(path), this.noteOf(path), opened.changed.includes(path), isChanged);
      if (path.endsWith(".count")) row.enable(this.isServed || !opened.counted);
    }
    for (const { rows, mark } of this.sections) {
      const count = rows.filter(({ element }) => "marked" in element.dataset).length;
      mark.textContent = count ? `${count} changed` : "";
    }
    this.dense.hidden =
      !this.isServed || opened.fields["place.map"] != null || opened.fields["arena.side"] == null;
    this.replays?.mark(opened.point, settings);
  }

  /** @param {string} path */
  noteOf(path) {
    const { units, strategies, counted, settings, fields, changed } = this.opened,
      unit = units[path] ?? "",
      key = SETTINGS[path];
    if (path === "decision.strategy") return capital(strategies[this.state.settings.strategy].rule || " ");
    if (path.endsWith(".count") && counted && !this.isServed) return `${counted}.`;
    if (!key)
      return changed.includes(path) && fields[path] === undefined ? "Too long to be shown here." : unit;
    return unit.includes("(") && this.state.settings[key] === settings[key] ? unit : "";
  }

  /**
   * Show problems, each at its field; those that can't be seen there also above the form, with a way to the field.
   * @param {Problem[]} problems
   */
  showProblems(problems) {
    this.clearProblems();
    const items = problems.map(({ path, text }) => {
      const row = this.nearest(path);
      row?.tell(text);
      if (row && !row.element.closest("details:not([open]), [hidden]")) return [];
      const go = make("button", { type: "button" }, `Go to ${row?.field.path}`);
      go.onclick = () => this.goTo(row);
      return [make("li", {}, text, " ", ...(row ? [go] : []))];
    });
    const first = make("p", {}, "Not changed: the previous run continues.");
    this.problems.replaceChildren(first, make("ul", {}, ...items.flat()));
    this.problems.hidden = false;
  }

  clearProblems() {
    for (const row of this.rows.values()) if (!row.isWrong) row.tell("");
    this.problems.hidden = true;
  }

  /** @param {Row | undefined} row */
  goTo(row) {
    this.finder.value = "";
    this.find();
    row?.reveal();
  }

  /**
   * Return the field of a path, or the field that it is a part of.
   * @param {string} path
   * @returns {Row | undefined}
   */
  nearest(path) {
    const end = path.lastIndexOf(".");
    return this.rows.get(path) ?? (end < 0 ? undefined : this.nearest(path.slice(0, end)));
  }
}

/**
 * Read what the address keeps; what can't be is left out.
 * @param {Page} page
 * @param {Opened} opened
 * @returns {{own: Record<string, any>, changes: Record<string, any>, against: string, point: number | null}}
 */
export function readAddress({ server, form }, opened) {
  const kept = new URLSearchParams(location.hash.slice(1)),
    { settings, most } = opened,
    point = kept.get("point") ?? "";
  let against = "";
  /** @type {Record<string, any>[]} */
  const [own, changes] = [{}, {}];
  for (const field of firstFields(opened, form)) {
    const { path, kind, choices } = field,
      text = kept.get(path) ?? kept.get(SETTINGS[path]) ?? "",
      number = kind === "choice" ? null : numberOf(text, field);
    if (path === "against" && choices?.includes(text)) against = text;
    if (!server && !settingOf(path, opened)) continue;
    if (path === "decision.strategy" && choices?.includes(read(text))) own[path] = read(text);
    else if (number !== null) own[path] = path === "seed" ? String(number) : Number(number);
    else if (server && kind === "quantity" && /^\d/.test(text)) own[path] = text; // such as 6 m
  }
  for (const [path, text] of kept)
    if (server && /^([a-z]+\.[a-z_]+|preset)$/.test(path) && !(path in SETTINGS)) changes[path] = read(text);
  const robots = own["robots.count"] ?? settings.robots,
    tasks = own["tasks.count"] ?? settings.tasks,
    text = kept.get("events") ?? "",
    events = eventsIn(text, { robots, tasks }, most) ?? (server && text.startsWith('"') && read(text)); // typed
  if (events) own.events = events;
  for (const name of /** @type {const} */ (["seed", "run"]))
    if (own[name] === settings[name]) delete own[name];
  return { own, changes, against, point: /^\d{1,9}$/.test(point) ? Number(point) : null };
}

/**
 * Return a value that the address has as JSON, or as text.
 * @param {string} text
 */
function read(text) {
  try {
    return JSON.parse(text);
  } catch {
    return text;
  }
}

/**
 * Keep what the user has chosen in the address, without a new entry in the browser's history.
 * @param {{own: Record<string, any>, changes: Record<string, any>, against: string, point: number | null, settings: Settings}} state
 */
export function writeAddress({ own, changes, against, point, settings: { seed, run } }) {
  const kept = new URLSearchParams(),
    named = { ...own, seed, run };
  for (const [path, value] of Object.entries(named))
    kept.set(SETTINGS[path] ?? path, typeof value === "object" ? JSON.stringify(value) : String(value));
  if (against) kept.set("against", against);
  if (point !== null) kept.set("point", String(point));
  for (const [path, value] of Object.entries(changes)) kept.set(path, JSON.stringify(value));
  try {
    history.replaceState(null, "", `#${kept}`);
  } catch {
    // a frame within another page may have no address of its own
  }
}
