// Whether the page has a connection to the server, and what it says if not.

import { $ } from "./elements.js";

/**
 * @param {string} text
 * @param {string} kind
 */
export function showConnection(text, kind) {
  $("connection").textContent = text;
  $("connection").dataset.state = kind;
}

/** @param {string} text */
export function showBanner(text) {
  $("banner-text").textContent = text;
  $("banner").hidden = false;
}
