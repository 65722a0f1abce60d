// The keys of the whole page, which its help lists. Those of an arena with the focus are in inspector.js.

import { $ } from "./elements.js";

/**
 * Let keys act that the page has an action for, unless they are meant for a control or for an open dialog.
 * @param {Record<string, () => void>} actions
 */
export function listenToKeys(actions) {
  const shown = /** @type {NodeListOf<HTMLElement>} */ ($("keys").querySelectorAll("[data-does]")),
    named = [...shown].flatMap(({ dataset: { keys, does }, textContent }) =>
      (keys ?? textContent).split(" ").map((key) => [key, does]),
    ),
    found = /** @type {Record<string, string>} */ ({ ...Object.fromEntries(named), " ": "play" });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const at = /** @type {Element} */ (event.target);
    if (at.closest("input:not([type=range]), select, textarea, pre")) return;
    if (event.key.startsWith("Arrow") && at.closest("input")) return; // the slider moves
    if (event.key === " " && at.closest("button, summary, a")) return; // the browser presses it
    const act = actions[found[event.key]];
    if (!act) return;
    event.preventDefault();
    act();
  });
}
