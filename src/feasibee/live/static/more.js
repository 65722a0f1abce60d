// All fields of a scenario that the form does not have yet, from the server's list of them; see form.py.

import { $, capital, make } from "./elements.js";

/**
 * @typedef {object} Field
 * @property {string} path
 * @property {string} name
 * @property {string} note
 * @property {"number" | "integer" | "boolean" | "choice" | "quantity" | "value"} kind
 * @property {boolean} nullable
 * @property {string[]} [choices]
 * @property {number} [min]
 * @property {number} [max]
 */
/** @typedef {{name: string, fields: Field[]}} Part */

/**
 * Build the controls of all fields that aren't known.
 * @param {Part[]} parts
 * @param {(path: string) => boolean} known
 */
export function buildMore(parts, known) {
  for (const { name, fields } of parts) {
    const boxes = fields.filter((each) => !known(each.path)).map(boxOf);
    if (!boxes.length) continue;
    const title = make("summary", {}, capital(name));
    $("more-fields").append(make("details", {}, title, make("div", { className: "fields" }, ...boxes)));
  }
}

/**
 * Return the control of a field with its name and, below, its description.
 * @param {Field} field
 */
function boxOf({ path, name, note, kind, nullable, choices = [], min, max }) {
  const input = kind === "choice" ? make("select", {}) : make("input", {}),
    isBox = kind === "boolean";
  input.dataset.path = path;
  input.dataset.empty = nullable ? "null" : "default";
  if (input instanceof HTMLSelectElement)
    input.append(...[...(nullable ? [""] : []), ...choices].map((each) => new Option(each, each)));
  else {
    const isText = kind === "value" || kind === "quantity";
    input.type = isBox ? "checkbox" : isText ? "text" : "number";
    if (kind === "quantity") input.inputMode = "decimal";
    if (kind === "number") input.step = "any";
    if (min !== undefined) input.min = String(min);
    if (max !== undefined) input.max = String(max);
  }
  const hint = make("small", { id: `hint-${path.replace(".", "-")}` }, note),
    parts = isBox ? [input, capital(name)] : [capital(name), input];
  input.setAttribute("aria-describedby", hint.id);
  const label = make("label", { className: isBox ? "check" : "" }, ...parts);
  return make("div", { className: "wide" }, label, hint);
}
