"""Map where the robots of a swarm are, and which opinions they hold there.

Rooms whose doors split a swarm have different colours. White squares were never visited.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import feasibee

EXAMPLE = "example: python research/heat.py examples/hall/hall.toml --runs 20 --out heat.png"
SQUARES = 50  # along the longer side of the arena


def maps_of(scenario: feasibee.Scenario, runs: int, every: int, seed: int) -> tuple[Any, Any]:
    """Return the mean number of robots per square, and the share of feasible opinions there.

    Both have the shape (rows, columns); row 0 has the lowest y. The share is NaN where no opinion was held.
    """
    width, height = scenario.arena.size
    side = max(width, height) / SQUARES
    edges = [np.arange(0, each + side, side) for each in (height, width)]
    counts = {name: np.zeros([len(each) - 1 for each in edges]) for name in ("robots", "held", "feasible")}
    looks = range(0, scenario.run.steps + 1, every)
    for run in range(runs):
        swarm = feasibee.Swarm(scenario, seed, run)
        for step in looks:
            swarm.advance(step - swarm.step)
            y_x, opinions = swarm.positions[:, ::-1], swarm.opinions
            kept = {"robots": swarm.present, "held": opinions >= 0, "feasible": opinions == 1}
            for name, which in kept.items():
                counts[name] += np.histogramdd(y_x[which & swarm.present], edges)[0]
    held = counts["held"]
    feasible = np.divide(counts["feasible"], held, out=np.full(held.shape, np.nan), where=held > 0)
    return counts["robots"] / (runs * len(looks)), feasible


def main() -> None:
    """Draw the maps, and print how much of the arena was visited."""
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLE)
    parser.add_argument("file", nargs="?", help="scenario in TOML; by default the paper's swarm")
    parser.add_argument("--runs", type=int, default=20, help="number of runs")
    parser.add_argument("--every", type=int, default=5, help="steps between two looks at the robots")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("heat.png"), help="figure to write")
    given = parser.parse_args()
    scenario = feasibee.Scenario.read(given.file) if given.file else feasibee.Scenario()
    robots, feasible = maps_of(scenario, given.runs, given.every, given.seed)
    width, height = scenario.arena.size
    figure = Figure(figsize=(9, 1 + 4 * height / width), layout="constrained")
    axes = figure.subplots(1, 2)
    for ax, values, label in (
        (axes[0], np.where(robots > 0, robots, np.nan), "robots per square"),
        (axes[1], 100 * feasible, "opinions feasible (%)"),
    ):
        image = ax.imshow(values, extent=(0, width, 0, height), origin="lower", zorder=0.4)
        figure.colorbar(image, ax=ax, label=label)
    figure.savefig(given.out, dpi=150)
    print(f"{(robots > 0).mean():.1%} of the squares were visited; {given.out} has the maps")


if __name__ == "__main__":
    main()
