// The form of the page: first fields with sliders, all others where a server checks them, and runs of a sweep.

import { $, capital, make } from "./elements.js";
import { firstFields, numberOf, settingOf, SETTINGS } from "./fields.js";
import { Replays } from "./replays.js";
import { Row } from "./row.js";
import { copy, eventsIn, inToml } from "./touching.js";

/** @typedef {{path: string, text: string}} Problem */

export class Form {
  /**
   * @param {HTMLElement} root
   * @param {Given} page
   * @param {Pick<Page, "change" | "restart">} hear
   */
  constructor(root, page, hear) {
    this.page = page;
    this.isServed = page.server;
    this.hear = hear;
    this.opened = page.opened;
    /** @type {FormState} */
    this.state = { settings: page.opened.settings, set: {} };
    /** @type {Map<string, Row>} */
    this.rows = new Map();
    this.replays =
      page.replays && new Replays(page.replays, ({ point, seed, run }) => hear.restart({ seed, run }, point));
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
      this.density.checked = false;
      this.hear.restart();
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
    this.hear.change(path, value, isLive);
    if (path === "arena.side") this.density.checked = false;
    if (path !== "robots.count" || !this.density.checked || !this.start) return;
    const factor = Math.sqrt(Number(value ?? this.page.opened.settings.robots) / this.start.robots),
      [width, height] = this.start.sides.map((each) => Number((each * factor).toFixed(3)));
    this.hear.change("arena.side", height === undefined ? width : [width, height], isLive);
  }

  /** @param {string} path */
  takeBack(path) {
    this.row(path).tell("");
    this.take(path, path === "against" ? "" : undefined); // the second swarm's, the page takes back by itself
  }

  /** @param {string} path */
  valueOf(path) {
    const { settings, set } = this.state,
      key = settingOf(path, this.opened);
    if (path === "against" || path === "preset") return set[path];
    if (path === "events") return settings.events.length ? inToml(settings.events) : "";
    if (path === "decision.strategy") return this.opened.strategies[settings.strategy].name;
    return key ? settings[key] : (this.opened.fields[path] ?? settings[SETTINGS[path]]);
  }

  /**
   * Show what the page shows now.
   * @param {Opened} opened
   * @param {Partial<FormState>} state
   */
  open(opened, { settings = opened.settings, set = {} } = {}) {
    this.opened = opened;
    this.state = { settings, set };
    for (const field of firstFields(opened, this.page.form)) this.row(field.path).bound(field);
    for (const [path, row] of this.rows) {
      row.show(this.valueOf(path), this.noteOf(path), opened.changed.includes(path), path in set);
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
 * @param {Given} page
 * @param {Opened} opened
 * @returns {{set: Record<string, any>, point: number | null}}
 */
export function readAddress({ server, form }, opened) {
  const kept = new URLSearchParams(location.hash.slice(1)),
    { settings, most } = opened,
    point = kept.get("point") ?? "",
    events = kept.get("events");
  /** @type {Record<string, any>} */
  const set = {};
  for (const field of firstFields(opened, form)) {
    const { path, kind, choices } = field,
      text = kept.get(path) ?? kept.get(SETTINGS[path]) ?? "",
      number = kind === "choice" ? null : numberOf(text, field);
    if (!text || !(server || path === "against" || settingOf(path, opened))) continue;
    if (choices?.includes(text)) set[path] = text;
    else if (number !== null) set[path] = path === "seed" ? String(number) : Number(number);
    else if (server && kind === "quantity" && /^\d/.test(text)) set[path] = text; // such as 6 m
  }
  for (const [path, text] of kept)
    if (server && /^([a-z]+\.[a-z_]+|preset)$/.test(path) && !(path in SETTINGS)) set[path] = read(text);
  const { "robots.count": robots = settings.robots, "tasks.count": tasks = settings.tasks } = set,
    found = events && (eventsIn(events, { robots, tasks }, most) ?? (server && events)); // as typed
  if (found) set.events = found;
  for (const name of /** @type {const} */ (["seed", "run"]))
    if (set[name] === settings[name]) delete set[name];
  return { set, point: /^\d{1,9}$/.test(point) ? Number(point) : null };
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
 * Keep what the user has set in the address, without a new entry in the browser's history.
 * @param {Record<string, unknown>} set
 * @param {number | null} point
 * @param {Settings} settings
 */
export function writeAddress(set, point, { seed, run }) {
  const kept = new URLSearchParams();
  for (const [path, value] of Object.entries({ ...set, seed, run, ...(point !== null && { point }) }))
    kept.set(SETTINGS[path] ?? path, typeof value === "object" ? JSON.stringify(value) : String(value));
  try {
    history.replaceState(null, "", `#${kept}`);
  } catch {
    // a frame within another page may have no address of its own
  }
}
