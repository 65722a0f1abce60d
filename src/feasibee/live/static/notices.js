// How the server or the field is: the connection, the banner, the state of a field, and the notice while the page waits.

import { $, announce, capital, formatted } from "./elements.js";
import { SPEEDS } from "./player.js";

/** @import { Opened } from "./arena.js" */

const PATIENCE = 400; // milliseconds after which a waiting page shows that it prepares a swarm

/**
 * @param {string} text
 * @param {string} kind
 */
export function showConnection(text, kind) {
  $("connection").textContent = text;
  $("connection").dataset.state = kind;
}

/**
 * @param {string} text
 * @param {boolean} canRetry Whether another attempt to connect could help.
 */
export function showBanner(text, canRetry = true) {
  $("banner-text").textContent = text;
  $("retry").hidden = !canRetry;
  $("banner").hidden = false;
}

// The notice over the arena while the page waits: preparing, on the way to a step.
export class Veil {
  constructor() {
    this.waiting = 0;
  }

  // Show soon that a swarm is prepared, unless something else is shown before.
  prepare() {
    this.hide();
    this.waiting = setTimeout(() => this.show("Preparing the swarm"), PATIENCE);
  }

  /** @param {string} text */
  show(text) {
    clearTimeout(this.waiting);
    $("veil-text").textContent = text;
    $("veil").hidden = !text;
  }

  hide() {
    this.show("");
  }
}

/**
 * How a field is, from the server; see fieldsession.py.
 * @typedef {object} FieldState
 * @property {string[]} problems In words.
 * @property {boolean} silent Whether the field itself is silent.
 * @property {number | null} end The last step, if it has ended.
 */

const UNKNOWN = 300; // steps per second that are enough for a field in lockstep

/**
 * Show what is known of a field before its first frame; return the speed that keeps up with it.
 * @param {Opened} world
 */
export function openField(world) {
  const { address = "", hz = null } = world.field ?? {};
  document.body.dataset.field = "";
  $("field-strategy").textContent = world.strategy;
  $("field-address").textContent = address;
  $("field-clock").textContent = hz === null ? "lockstep" : `${formatted(hz)} steps / s`;
  $("field-which").textContent = `${world.seed}, ${world.run}`;
  $("field-state").textContent = "running";
  $("robot-hint").textContent = "Click a robot, or press i and the arrow keys, to see what it last reported.";
  $("stopped-row").hidden = $("legend-stopped").hidden = false;
  for (const each of [$("stopped-row").querySelector("dt"), $("legend-stopped").lastChild])
    if (each) each.textContent = "stopped or silent";
  return SPEEDS.find((speed) => speed >= (hz ?? UNKNOWN)) ?? SPEEDS[SPEEDS.length - 1];
}

/**
 * Show how the field is; return its last step.
 * @param {FieldState} state
 * @param {number} last The last step, if the field doesn't end before.
 */
export function showField({ problems, silent, end }, last) {
  const text = problems.join("; ");
  if (text) showBanner(`${capital(text)}.`, false);
  else $("banner").hidden = true;
  const now = end !== null ? `ended at step ${formatted(end)}` : silent ? "silent" : "running";
  if (end !== null) announce(`The field has ended at step ${formatted(end)}`);
  $("field-state").textContent = now;
  showConnection(end !== null ? "ended" : silent ? "field silent" : "live", silent ? "lost" : "live");
  return end ?? last;
}
