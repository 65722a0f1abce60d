// Whether the page has a connection to the server, what it says if not, and the notice while it waits.

import { $, announce } from "./elements.js";

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

// The notice over the arena while the page waits: preparing, compiling, on the way to a step.
export class Veil {
  constructor() {
    this.waiting = 0;
    this.ticking = 0;
  }

  // Show soon that a swarm is prepared, unless something else is shown before.
  prepare() {
    this.hide();
    this.waiting = setTimeout(() => this.show("Preparing the swarm"), PATIENCE);
  }

  /** @param {string} text */
  show(text) {
    clearTimeout(this.waiting);
    clearInterval(this.ticking);
    $("veil-text").textContent = text;
    $("veil-time").textContent = "";
    $("veil").hidden = !text;
  }

  /**
   * Show what takes long, with the time passed since it began.
   * @param {string} text
   * @param {number} seconds Time passed so far.
   */
  showTime(text, seconds) {
    const start = performance.now() - 1000 * seconds;
    const tick = () => {
      $("veil-time").textContent = ` … ${Math.floor((performance.now() - start) / 1000)} s`;
    };
    this.show(text);
    announce(text);
    tick();
    this.ticking = setInterval(tick, 1000);
  }

  hide() {
    this.show("");
  }
}
