// All fields of a scenario that the form does not have yet, from the server's list of them; see form.py.

import { $ } from "./elements.js";

/**
 * @typedef {object} Field
 * @property {string} path
 * @property {string} name
 * @property {string} note
 * @property {"number" | "integer" | "boolean" | "choice" | "value"} kind
 * @property {boolean} nullable
 * @property {string[]} [choices]
 * @property {number} [min]
 * @property {number} [max]
 */
/** @typedef {{name: string, fields: Field[]}} Part */
/** @typedef {HTMLInputElement | HTMLSelectElement} Input */

/**
 * Build the controls of all fields that aren't known; return them.
 * @param {Part[]} parts
 * @param {(path: string) => boolean} known
 * @returns {Input[]}
 */
export function buildMore(parts, known) {
  const inputs = [];
  for (const { name, fields } of parts) {
    const missing = fields.filter((each) => !known(each.path));
    if (!missing.length) continue;
    const section = document.createElement("details"),
      title = document.createElement("summary"),
      box = document.createElement("div");
    title.textContent = name[0].toUpperCase() + name.slice(1);
    box.className = "fields";
    for (const field of missing) {
      const input = inputOf(field);
      box.append(boxOf(field, input));
      inputs.push(input);
    }
    section.append(title, box);
    $("more-fields").append(section);
  }
  return inputs;
}

/** @param {Field} field */
function inputOf({ path, kind, nullable, choices, min, max }) {
  const input = document.createElement(kind === "choice" ? "select" : "input");
  input.dataset.path = path;
  input.dataset.empty = nullable ? "null" : "default";
  if (input instanceof HTMLSelectElement) {
    input.append(...(nullable ? [""] : []).concat(choices ?? []).map((each) => new Option(each, each)));
    return input;
  }
  input.type = kind === "boolean" ? "checkbox" : kind === "value" ? "text" : "number";
  if (kind === "number") input.step = "any";
  if (min !== undefined) input.min = String(min);
  if (max !== undefined) input.max = String(max);
  return input;
}

/**
 * Return a control with its name and, below, its description.
 * @param {Field} field
 * @param {Input} input
 */
function boxOf({ path, name, note, kind }, input) {
  const box = document.createElement("div"),
    label = document.createElement("label"),
    hint = document.createElement("small"),
    text = name[0].toUpperCase() + name.slice(1);
  hint.id = `hint-${path.replace(".", "-")}`;
  hint.textContent = note;
  input.setAttribute("aria-describedby", hint.id);
  if (kind === "boolean") label.append(input, text);
  else label.append(text, input);
  label.className = kind === "boolean" ? "check" : "";
  box.className = "wide";
  box.append(label, hint);
  return box;
}
