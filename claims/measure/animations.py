"""Measure sizes of animations, and the time per frame of 10,000 robots relative to 20: docs/watch.md."""

from __future__ import annotations

import json
import tempfile
import time
from datetime import date
from pathlib import Path

import feasibee
from feasibee.figures.animation import animate

FRAMES = 300
LARGE = {"robots.count": 10_000, "tasks.count": 9_000, "arena.side": 450.0}


def main() -> None:
    """Print sizes in millions of bytes, and the ratio of CPU times, as JSON."""
    with tempfile.TemporaryDirectory() as folder:
        for suffix in ("gif", "webp", "mp4"):
            animate(feasibee.Scenario(), Path(folder, f"run.{suffix}"), seed=1, steps=(1, FRAMES))
        sizes = {path.suffix[1:]: path.stat().st_size / 1e6 for path in Path(folder).iterdir()}
    ratio = frame_seconds(feasibee.Scenario().replace(LARGE), 20) / frame_seconds(feasibee.Scenario(), 200)
    print(json.dumps({"sizes": sizes, "ratio": ratio, "date": date.today().isoformat()}))


def frame_seconds(scenario: feasibee.Scenario, frames: int) -> float:
    """Return the CPU time per frame of a GIF."""
    with tempfile.TemporaryDirectory() as folder:
        animate(scenario, Path(folder, "warm.gif"), seed=1, steps=(1, 2))
        start = time.process_time()
        animate(scenario, Path(folder, "run.gif"), seed=1, steps=(1, frames))
        return (time.process_time() - start) / frames


if __name__ == "__main__":
    main()
