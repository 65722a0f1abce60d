// Light or dark, as the system, as chosen, or as the page around, and the colours that canvases need.

import { $ } from "./elements.js";

/** @typedef {"ground" | "line" | "ink" | "muted" | "feasible" | "infeasible" | "undecided" | "task" | "zone"} Shade */

/** @type {Shade[]} */
const SHADES = ["ground", "line", "ink", "muted", "feasible", "infeasible", "undecided", "task", "zone"];

/** @type {Record<string, [string, string]>} */
const THEMES = { auto: ["as the system", "◐"], light: ["light", "○"], dark: ["dark", "●"] };

// The colours of the theme, from the style sheet.
export function coloursOf() {
  const probe = document.body.appendChild(document.createElement("span"));
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
    button = $("theme"),
    use = (/** @type {number} */ k) => {
      const theme = names[k % names.length],
        [name, sign] = THEMES[theme];
      setTheme(theme);
      button.title = button.ariaLabel = `Theme: ${name}`;
      button.textContent = sign;
      localStorage.setItem("theme", theme);
    };
  use(Math.max(0, names.indexOf(localStorage.getItem("theme") ?? "auto")));
  button.addEventListener("click", () => {
    use(names.indexOf(document.documentElement.dataset.theme ?? "auto") + 1);
    repaint();
  });
}
