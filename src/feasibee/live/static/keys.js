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
  "+": "faster",
  "=": "faster",
  "-": "slower",
  r: "restart",
  n: "another",
  "?": "help",
};

/**
 * Let keys act, unless they are meant for a control or for the help.
 * @param {Record<string, () => void>} actions
 * @param {HTMLDialogElement} help
 */
export function listenToKeys(actions, help) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || help.open) return;
    const at = /** @type {Element} */ (event.target);
    if (at.closest("input:not([type=range]), select, textarea, pre")) return;
    if (event.key.startsWith("Arrow") && at.closest("input")) return; // the slider moves
    if (event.key === " " && at.closest("button, summary")) return; // the browser presses it
    const action = KEYS[event.key];
    if (!action) return;
    event.preventDefault();
    actions[action]();
  });
}
