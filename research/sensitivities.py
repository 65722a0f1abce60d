"""Find which fields of a scenario matter, by simulation or by theory.

By simulation, all fields vary at once (a Latin hypercube), and each is correlated with the share of right
swarms. By theory, one field after another changes by a tenth up and down, which takes seconds.
"""

from __future__ import annotations

import argparse
import json
import math
from typing import Any

import numpy as np
from scipy.stats import qmc, spearmanr

import feasibee

EXAMPLE = "example: python research/sensitivities.py hall.toml radio.loss=0:0.6 faults.byzantine=0:0.1"


def by_simulation(
    scenario: feasibee.Scenario, ranges: dict[str, tuple[float, float]], points: int, runs: int, seed: int
) -> dict[str, dict[str, float]]:
    """Return the rank correlation of each field with the share of right swarms, and its 95 % interval."""
    shares = qmc.LatinHypercube(len(ranges), seed=seed).random(points)
    places = qmc.scale(shares, *np.array(list(ranges.values())).T)
    whole = {path for path in ranges if isinstance(scenario.get(path), int)}
    right = []
    for point, place in enumerate(places.tolist()):
        values = {
            path: round(each) if path in whole else each for path, each in zip(ranges, place, strict=True)
        }
        here = scenario.replace({**values, "run.stop_at_decision": False})
        swarms, truth = feasibee.simulate(here, runs, seed, first_run=point * runs), feasibee.truth(here)
        held = swarms.feasible_at_end if truth else swarms.infeasible_at_end
        right.append((held > here.decision.threshold * here.counted(here.run.steps)).mean().item())
    rows = np.random.default_rng(seed).integers(0, points, (1000, points))
    found = {}
    if len(set(right)) == 1:
        raise SystemExit("all points have the same share of right swarms: use wider ranges, or more runs")
    for column, path in enumerate(ranges):
        drawn = [spearmanr(places[each, column], np.array(right)[each]).statistic for each in rows]
        low, high = np.nanquantile(drawn, (0.025, 0.975))
        found[path] = {"correlation": spearmanr(places[:, column], right).statistic, "low": low, "high": high}
    return found


def by_theory(scenario: feasibee.Scenario, paths: list[str]) -> dict[str, dict[str, float]]:
    """Return how the share that decides feasible and the log of the median step follow the log of fields."""
    found = {}
    for path in paths:
        now: Any = scenario.get(path)
        ends = [now * math.exp(-0.1), now * math.exp(0.1)]
        if isinstance(now, int):
            ends = [max(1, min(now - 1, round(ends[0]))), max(now + 1, round(ends[1]))]
        less, more = (feasibee.predict(scenario.replace({path: each})) for each in ends)
        distance = math.log(ends[1] / ends[0])
        times = [each.steps["median"] or math.nan for each in (less, more)]
        found[path] = {
            "feasible": (more.feasible - less.feasible) / distance,
            "log_median_step": math.log(times[1] / times[0]) / distance,
        }
    return found


def main() -> None:
    """Print the correlations, or the derivatives if no field has a range."""
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLE)
    parser.add_argument("file", help="scenario in TOML; - for the paper's swarm with 10 tasks")
    parser.add_argument(
        "fields", nargs="+", help="field with its range, such as radio.loss=0:0.5; by theory without"
    )
    parser.add_argument("--points", type=int, default=200)
    parser.add_argument("--runs", type=int, default=20, help="runs of each point")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    paper = feasibee.Scenario(tasks={"count": 10})
    scenario = paper if given.file == "-" else feasibee.Scenario.read(given.file)
    found = {path: ends for path, _, ends in (each.partition("=") for each in given.fields)}
    if any(found.values()):
        ranges = {
            path: (float(ends.split(":")[0]), float(ends.split(":")[1])) for path, ends in found.items()
        }
        print(json.dumps(by_simulation(scenario, ranges, given.points, given.runs, given.seed), indent=1))
    else:
        print(json.dumps(by_theory(scenario, list(found)), indent=1))


if __name__ == "__main__":
    main()
