// Access to the elements of the page, and how texts and numbers are written in them.

/**
 * Return an element of the page by its id.
 * @param {string} id
 */
export const $ = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

/**
 * Make an element.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Partial<HTMLElementTagNameMap[Tag]>} properties
 * @param {(Node | string)[]} children
 */
export function make(tag, properties, ...children) {
  const element = document.createElement(tag);
  Object.assign(element, properties).append(...children);
  return element;
}

/**
 * Write a text where it isn't yet, or hide its place if it is empty: screen readers read each change.
 * @param {HTMLElement} place
 * @param {string} text
 */
export function write(place, text) {
  if (place.textContent !== text) place.textContent = text;
  place.hidden = !text;
}

/**
 * Fill the list in an element with terms and their texts.
 * @param {HTMLElement} place
 * @param {[string, string][]} rows
 */
export function list(place, rows) {
  const items = rows.map(([term, text]) => make("div", {}, make("dt", {}, term), make("dd", {}, text)));
  place.querySelector("dl")?.replaceChildren(...items);
}

/**
 * Return a text as markup that shows it.
 * @param {string} text
 */
export const escaped = (text) => text.replace(/[&<]/g, (each) => `&#${each.charCodeAt(0)};`);

/**
 * Return the 2D context of a canvas.
 * @param {HTMLCanvasElement} canvas
 * @param {CanvasRenderingContext2DSettings} [settings]
 */
export function contextOf(canvas, settings) {
  const context = canvas.getContext("2d", settings);
  if (!context) throw new Error("this browser gives no canvas to draw on");
  return context;
}

/**
 * Write a text with a capital at its start.
 * @param {string} text
 */
export const capital = (text) => text[0].toUpperCase() + text.slice(1);

/**
 * Write a number with commas between thousands.
 * @param {number} value
 */
export function formatted(value) {
  return value.toLocaleString("en");
}

/**
 * Write a time in two of its largest parts, such as 8 min 20 s.
 * @param {number} seconds
 */
export function duration(seconds) {
  const whole = Math.round(seconds);
  if (whole < 60) return `${Number(seconds.toPrecision(3))} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  const minutes = Math.round(seconds / 60);
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/**
 * Announce a text to screen readers.
 * @param {string} text
 */
export function announce(text) {
  $("announcer").textContent = text;
}

/**
 * Open all that is folded around an element.
 * @param {Element} element
 */
export function unfold(element) {
  for (let at = element.closest("details"); at; at = at.parentElement?.closest("details") ?? null)
    at.open = true;
}
