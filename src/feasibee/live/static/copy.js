// Copying the scenario.

import { $ } from "./elements.js";

export async function copyScenario() {
  try {
    await navigator.clipboard.writeText($("toml").textContent);
    $("copy").textContent = "Copied";
  } catch {
    getSelection()?.selectAllChildren($("toml")); // a page by http from another machine has no clipboard
    $("copy").textContent = "Selected: press Ctrl-C";
  }
  setTimeout(() => ($("copy").textContent = "Copy"), 2000);
}
