"""Speed of `feasibee watch`: frames that headless Chromium draws, and the server's share of a core.

    python benchmarks/live.py [--seconds 20] [--json live.json]

With 20 and 10,000 robots at the paper's density, one step per frame. It needs a browser and playwright.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from measure import machine

SIDE = 20.0
"""Side of the paper's arena, for 20 robots."""
TICKS = os.sysconf("SC_CLK_TCK")


def cpu_seconds(process: int) -> float:
    """Return the CPU time of a process so far (Linux)."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def measure(robots: int, seconds: float, browser: str) -> dict[str, float]:
    from playwright.sync_api import expect, sync_playwright

    side = SIDE * (robots / 20) ** 0.5
    changes = (f"robots.count={robots}", f"tasks.count={robots}", f"arena.side={side}", "run.steps=100000")
    command = [sys.executable, "-m", "feasibee", "watch", "--no-open", "--port", "0"]
    command += [part for change in changes for part in ("--set", change)]
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server,
        sync_playwright() as playwright,
    ):
        assert server.stdout is not None
        address = server.stdout.readline().split()[-1]
        options = ["--no-sandbox", "--disable-gpu"]
        chromium = playwright.chromium.launch(executable_path=browser, args=options)
        page = chromium.new_page(viewport={"width": 1440, "height": 900})
        page.goto(address)
        expect(page.locator("#last")).not_to_have_text("0", timeout=120_000)
        while page.locator("#speed").inner_text() != "60 steps / s":
            page.keyboard.press("+")
        page.keyboard.press(" ")
        page.wait_for_timeout(2000)

        def now() -> tuple[float, float, int, int]:
            drawn = int(page.locator("#arena").get_attribute("data-drawn") or 0)
            step = int(page.locator("#now").inner_text().replace(",", ""))
            return time.perf_counter(), cpu_seconds(server.pid), drawn, step

        first = now()
        page.wait_for_timeout(1000 * seconds)
        wall, cpu, drawn, steps = (after - before for before, after in zip(first, now(), strict=True))
        chromium.close()
        server.terminate()
    return {"robots": robots, "frames": drawn / wall, "steps": steps / wall, "server": cpu / wall}


def row_of_text(row: dict[str, float]) -> str:
    rates = f"{row['frames']:5.1f} frames/s drawn, {row['steps']:5.1f} steps/s"
    return f"{row['robots']:6} robots: {rates}, server {100 * row['server']:4.1f} % of a core"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--browser", default=shutil.which("chromium") or shutil.which("google-chrome"))
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the figures to FILE")
    options = parser.parse_args()
    if options.browser is None or not Path("/proc/self/stat").exists():
        print("the live arena isn't measured: it needs Linux, and chromium in PATH")
        return
    print(f"load of the machine before: {os.getloadavg()[0]:.1f} of {os.cpu_count()} cores")
    rows = []
    for robots in (20, 10_000):
        rows.append(measure(robots, options.seconds, options.browser))
        print(row_of_text(rows[-1]))
    if options.json:
        figures = {"machine": machine(), "rows": rows}
        options.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
