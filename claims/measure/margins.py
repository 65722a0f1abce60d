"""Measure whether `fading` holds the margin by which it chooses tau, in worlds of several sizes."""

from __future__ import annotations

import json
from typing import Any

import feasibee
from feasibee.results.measures import changes_of
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies.fading import tau_of

RUNS, STILL = 300, 1000
WORLDS: tuple[tuple[str, int, float | list[float], tuple[int, int], float], ...] = (
    ("20 robots, side 20", 20, 20.0, (19, 22), 0.073),
    ("20 robots, side 20", 20, 20.0, (18, 23), 0.115),
    ("20 robots, side 20", 20, 20.0, (16, 25), 0.2),
    ("20 robots, side 20", 20, 20.0, (15, 28), 0.3),
    ("20 robots, side 20", 20, 20.0, (13, 32), 0.45),
    ("20 robots, side 14.1", 20, 14.1, (16, 25), 0.2),
    ("20 robots, side 28.3", 20, 28.3, (16, 25), 0.2),
    ("10 robots, side 14.1", 10, 14.1, (8, 13), 0.2),
    ("50 robots, side 31.6", 50, 31.6, (41, 62), 0.2),
    ("100 robots, side 44.7", 100, 44.7, (82, 123), 0.2),
    ("20 robots, 100 by 4", 20, [100.0, 4.0], (16, 25), 0.2),
)
"""Name, number of robots, side, numbers of tasks about as far from n + 1/2 as the margin, and the margin."""


def main() -> None:
    """Print the measures of each world."""
    found = []
    for name, robots, side, tasks, margin in WORLDS:
        scenario = feasibee.Scenario().replace(
            {
                "arena.side": side,
                "robots.count": robots,
                "robots.know_count": True,
                "decision.strategy": "fading",
                "decision.parameters": {"margin": margin},
            }
        )
        tau = tau_of(scenario.setting)
        ways = [measured(scenario, tau, way) for way in (tasks, tasks[::-1])]
        found.append({"world": name, "margin": margin, "tasks": tasks, "tau": tau, "ways": ways})
    print(json.dumps({"worlds": found}, indent=2))


def measured(scenario: feasibee.Scenario, tau: float, tasks: tuple[int, int]) -> dict[str, Any]:
    """Return the share of right steps before a change, and that of the swarms that noticed it in 3 tau."""
    settled = int(5 * tau)
    change, within = settled + STILL, int(3 * tau)
    changing = scenario.replace(
        {
            "tasks.count": tasks[0],
            "run.steps": change + within,
            "events": [{"step": change, "tasks": tasks[1] - tasks[0]}],
        }
    )
    record = simulate_record(changing, Runs(RUNS, 1))
    before = record.held[:, settled:change] == record.truth[:, settled:change]
    delay = changes_of(record.truth, record.held).delay
    return {"right": float(before.mean()), "noticed": float((delay >= 0).mean()), "changes": len(delay)}


if __name__ == "__main__":
    main()
