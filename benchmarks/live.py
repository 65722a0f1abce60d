"""Speed of the page in headless Chromium: how soon the answer moves with a slider; frames of a large swarm.

    python benchmarks/live.py [--seconds 10] [--json live.json]

Medians over moves of the slider of tasks, with the paper's 20 robots; then 10,000 robots at the paper's
density, one step per frame. It needs a browser and playwright.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import tempfile
from pathlib import Path
from typing import Any

from measure import machine

from feasibee import Scenario
from feasibee.live.page import write_page

SIDE = 20.0
"""Side of the paper's arena, for 20 robots."""
MOVES = 30
LARGE = 10_000
MOVE = """tasks => new Promise(resolve => {
  const begun = performance.now(), page = feasibee, [lane] = page.lanes, found = {};
  page.change("tasks.count", tasks, true);
  const look = () => {
    const now = performance.now() - begun;
    if (!lane.coming && lane.history.done) found.run ??= now;
    if (lane.isCounted) found.many ??= now;
    if (found.run && found.many) resolve(found);
    else setTimeout(look, 1);
  };
  look();
})"""
"""Move a slider; return after how many milliseconds the run is known, and the hundred swarms are."""


def moved(page: Any) -> dict[str, float]:
    """Return the median times until the answer has moved with a slider."""
    found = [page.evaluate(MOVE, 10 + k % 25) for k in range(MOVES + 3)][3:]
    return {name: statistics.median(each[name] for each in found) for name in ("run", "many")}


def drawn(page: Any, seconds: float) -> float:
    """Return how many frames per second a page draws while it plays a step per frame."""
    page.wait_for_function("feasibee.history?.known >= 400", timeout=120_000)
    page.evaluate("feasibee.setSpeed(30); feasibee.clock.play(true)")
    count = "Number(document.querySelector('#arena').dataset.drawn)"
    before = page.evaluate(count)
    page.wait_for_timeout(1000 * seconds)
    return float(page.evaluate(count) - before) / seconds


def measure(browser: str, seconds: float) -> dict[str, float]:
    from playwright.sync_api import sync_playwright

    side = SIDE * (LARGE / 20) ** 0.5
    large = Scenario(robots={"count": LARGE}, tasks={"count": LARGE}, arena={"side": side})
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        options = ["--no-sandbox", "--disable-gpu"]
        chromium = playwright.chromium.launch(executable_path=browser, args=options)
        pages = []
        for name, scenario in (("few", Scenario(tasks={"count": 22})), ("large", large)):
            write_page(scenario, Path(folder, f"{name}.html"))
            pages.append(chromium.new_page(viewport={"width": 1440, "height": 900}, bypass_csp=True))
        few, many = pages
        few.goto(f"file://{folder}/few.html")
        few.wait_for_function("feasibee.lanes[0].isCounted")
        found = moved(few)
        few.close()
        many.goto(f"file://{folder}/large.html")
        found["frames"] = drawn(many, seconds)
        chromium.close()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--browser", default=shutil.which("chromium") or shutil.which("google-chrome"))
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the figures to FILE")
    options = parser.parse_args()
    if options.browser is None:
        print("the page isn't measured: it needs chromium in PATH")
        return
    print(f"load of the machine before: {os.getloadavg()[0]:.1f} of {os.cpu_count()} cores")
    found = measure(options.browser, options.seconds)
    print(
        f"20 robots, slider moved: run after {found['run']:.0f} ms, 100 swarms after {found['many']:.0f} ms"
    )
    print(f"{LARGE:,} robots: {found['frames']:.1f} frames/s drawn")
    if options.json:
        figures = {"machine": machine(), **found}
        options.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
