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

/**
 * @param {string} text
 * @param {boolean} canRetry Whether another attempt to connect could help.
 */
export function showBanner(text, canRetry = true) {
  $("banner-text").textContent = text;
  $("retry").hidden = !canRetry;
  $("banner").hidden = false;
}
