// Light or dark, as the system or as chosen, and the colours that canvases need.

import { $ } from "./elements.js";

/** @import { Colour } from "./arena.js" */
/** @typedef {Colour | "muted"} Shade */

/** @type {Shade[]} */
const SHADES = ["ground", "line", "ink", "muted", "feasible", "infeasible", "undecided", "task"];
/** @type {Record<string, string>} */
const THEMES = { auto: "as the system", light: "light", dark: "dark" };
/** @type {Record<string, string>} */
const SIGNS = { auto: "◐", light: "○", dark: "●" };

/**
 * Return the colours of the present theme, from base.css.
 * @returns {Record<Shade, string>}
 */
export function colours() {
  const probe = document.createElement("span");
  document.body.append(probe);
  const found = /** @type {Record<Shade, string>} */ ({});
  for (const name of SHADES) {
    probe.style.color = `var(--${name})`;
    found[name] = getComputedStyle(probe).color;
  }
  probe.remove();
  return found;
}

/** @param {string} chosen */
function setTheme(chosen) {
  const theme = chosen in THEMES ? chosen : "auto",
    button = $("theme"),
    label = `Theme: ${THEMES[theme]}`;
  if (theme === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  button.setAttribute("aria-label", label);
  button.title = label;
  button.textContent = SIGNS[theme];
  localStorage.setItem("theme", theme);
  return theme;
}

/**
 * Use the theme that this browser keeps, and let the button choose the next.
 * @param {() => void} repaint The colours have changed.
 */
export function startTheme(repaint) {
  let theme = setTheme(localStorage.getItem("theme") ?? "auto");
  $("theme").addEventListener("click", () => {
    const names = Object.keys(THEMES);
    theme = setTheme(names[(names.indexOf(theme) + 1) % names.length]);
    repaint();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
}
