"""Measure wrong proofs of infeasibility if robots give tasks wrong names: docs/worlds.md."""

from __future__ import annotations

import json

import numpy as np

from feasibee import Scenario, simulate
from feasibee.results.statistics import wilson

RATES = (1e-5, 1e-4, 1e-3, 1e-2)
RUNS, ROBOTS = 1000, 20
DECLARING = {
    "quiet_census": {"decision.strategy": "quiet-census"},
    "turns": {"decision.strategy": "turns"},
    "fewer": {"decision.strategy": "quiet-census", "tasks.count": 18},
}


def main() -> None:
    """Print the share of swarms with a wrong proof by rate and strategy, and how often roster is right."""
    found = [{"rate": f"{rate:.5f}".rstrip("0"), **shares_at(rate)} for rate in RATES]
    print(json.dumps({"rates": found}, indent=2))


def shares_at(rate: float) -> dict[str, dict[str, float]]:
    """Return shares of the swarms, with 95 % intervals, for feasible tasks."""
    base = Scenario().replace({"robots.count": ROBOTS, "tasks.count": ROBOTS, "robots.know_count": True})
    misnamed = {"sensing.misname": rate}
    shares = {}
    for name, changes in DECLARING.items():
        results = simulate(base.replace({**changes, **misnamed}), runs=RUNS, seed=1)
        shares[name] = share(results.declared_infeasible.values > 0)
    results = simulate(base.replace({"decision.strategy": "roster", **misnamed}), runs=RUNS, seed=1)
    return {**shares, "roster": share(results.feasible_at_end.values > 0.9 * ROBOTS)}


def share(happened: np.ndarray) -> dict[str, float]:
    """Return the share of the swarms in which it happened, with its 95 % interval."""
    return wilson(int(happened.sum()), RUNS)._asdict()


if __name__ == "__main__":
    main()
