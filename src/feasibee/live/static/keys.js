// The keys of the whole page. Those of an arena with the focus are in inspector.js.

/** @type {Record<string, string>} */
const KEYS = {
  " ": "play",
  ".": "step",
  ArrowRight: "step",
  ",": "back",
  ArrowLeft: "back",
  d: "decision",
  D: "decision-1",
  "[": "before",
  "]": "after",
  i: "inspect",
  Escape: "leave",
  Delete: "remove",
  "+": "faster",
  "=": "faster",
  "-": "slower",
  r: "restart",
  n: "another",
  g: "ranges",
  "?": "help",
};

/**
 * Let keys act that the page has an action for, unless they are meant for a control or for an open dialog.
 * @param {Record<string, () => void>} actions
 */
export function listenToKeys(actions) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const at = /** @type {Element} */ (event.target);
    if (at.closest("input:not([type=range]), select, textarea, pre")) return;
    if (event.key.startsWith("Arrow") && at.closest("input")) return; // the slider moves
    if (event.key === " " && at.closest("button, summary, a")) return; // the browser presses it
    const act = actions[KEYS[event.key]];
    if (!act) return;
    event.preventDefault();
    act();
  });
}
