// Access to the elements of index.html, and how numbers are written in them.

/**
 * Return an element of the page by its id.
 * @param {string} id
 */
export const $ = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

/**
 * Write a number with commas between thousands.
 * @param {number} value
 */
export function formatted(value) {
  return value.toLocaleString("en");
}

/**
 * Announce a text to screen readers.
 * @param {string} text
 */
export function announce(text) {
  $("announcer").textContent = text;
}
