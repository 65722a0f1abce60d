// A page in a frame of another page, such as the front page of the docs: its theme comes from there, its height goes there.

import { startTheme } from "./theme.js";

/**
 * Follow the system's theme and the button, or the theme of the page around.
 * @param {() => void} repaint The colours have changed.
 */
export function followTheme(repaint) {
  if (parent === window) return startTheme(repaint);
  document.body.classList.add("framed");
  addEventListener("message", ({ source, data }) => {
    if (source !== parent || !["light", "dark", "auto"].includes(data?.theme)) return;
    if (data.theme === "auto") delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = data.theme;
    repaint();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  const tell = () => parent.postMessage({ height: document.body.scrollHeight }, "*");
  new ResizeObserver(tell).observe(document.body);
}
