// Light or dark, as the system, as chosen, or as the page around, and the colours that canvases need.

import { $ } from "./elements.js";

/** @typedef {"ground" | "line" | "ink" | "muted" | "feasible" | "infeasible" | "undecided" | "task" | "zone"} Shade */
/** @typedef {Record<Shade, string>} Shades */

/** @type {Shade[]} */
const SHADES = ["ground", "line", "ink", "muted", "feasible", "infeasible", "undecided", "task", "zone"];

/** @type {Record<string, [string, string]>} */
const THEMES = { auto: ["as the system", "◐"], light: ["light", "○"], dark: ["dark", "●"] };

/**
 * Return the colours of the theme of an element, from its style sheet.
 * @param {HTMLElement} element
 */
export function coloursOf(element = document.body) {
  const probe = element.appendChild(document.createElement("span"));
  const found = SHADES.map((name) => {
    probe.style.color = `var(--${name})`;
    return [name, getComputedStyle(probe).color];
  });
  probe.remove();
  return /** @type {Shades} */ (Object.fromEntries(found));
}

/** @param {string} theme */
const setTheme = (theme) => (document.documentElement.dataset.theme = theme);

/**
 * Use the theme that this browser keeps, and let the button choose the next. In a frame of another page, such as
 * the front page of the docs, the theme comes from there, and the height goes there.
 * @param {() => void} repaint The colours have changed.
 */
export function startTheme(repaint) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  if (parent !== window) {
    document.body.classList.add("framed");
    addEventListener("message", ({ source, data }) => {
      if (source !== parent || !(data?.theme in THEMES)) return;
      setTheme(data.theme);
      repaint();
    });
    new ResizeObserver(() => parent.postMessage({ height: document.body.scrollHeight }, "*")).observe(
      document.body,
    );
    return;
  }
  const names = Object.keys(THEMES),
    button = $("theme");
  let theme = localStorage.getItem("theme") ?? "auto";
  const use = () => {
    if (!names.includes(theme)) theme = "auto";
    setTheme(theme);
    const [name, sign] = THEMES[theme];
    button.title = button.ariaLabel = `Theme: ${name}`;
    button.textContent = sign;
    localStorage.setItem("theme", theme);
  };
  use();
  button.addEventListener("click", () => {
    theme = names[(names.indexOf(theme) + 1) % names.length];
    use();
    repaint();
  });
}
