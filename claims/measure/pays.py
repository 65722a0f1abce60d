"""Measure where asking first pays, in worlds that differ from the paper's: docs/ask-first.md.

Run with one of the names of `WORLDS`; prints JSON: the ratios of robots to tasks up to which asking first is
the cheapest, and from which starting at once is, without tags, and the costs at ratio 1.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

from feasibee import Scenario
from feasibee.studies.pays import Costs, Pays, pays

RUNS, SEED = 40, 1
STEP = 0.02
"""Distance of the ratios that are tried."""
LYING = {"faults.byzantine": {"count": 1}, "decision.strategy": "roster"}
BEARING = {"acting.start": 0, "acting.tolerates": 1}
WORLDS: dict[str, dict[str, Any]] = {
    "paper": {},
    "loss": {"radio.loss": 0.3},
    "dense": {"arena.side": 14.14},
    "sparse": {"arena.side": 28.28},
    "fifty": {"robots.count": 50, "arena.side": 31.62},
    "liar": LYING,
    "tolerant": {
        **LYING,
        "decision.parameters": {"tolerates": 1.0},
        "acting.start": 0,
        "acting.tolerates": 1,
    },
}
"""What differs from the paper's world, by name."""
PENALTIES = (0.0, 10.0, 100.0)


def main(world: str) -> None:
    """Print the measures of a world as JSON."""
    found = pays(Scenario().replace(WORLDS[world]), runs=RUNS, seed=SEED)
    print(json.dumps({f"vain_{vain:g}": edges(found, Costs(vain=vain)) for vain in PENALTIES}, indent=2))


def edges(found: Pays, costs: Costs) -> dict[str, Any]:
    """Return the edges of the regions, and what each policy costs at ratio 1."""
    ratios = np.round(np.arange(0.5, 3.0, STEP), 2)
    ask, search, start = (
        [found.cost(name, ratio, costs).estimate for ratio in ratios]
        for name in ("ask first", "search first", "start at once")
    )
    asks = [ratio for ratio, *each in zip(ratios, ask, search, start, strict=True) if each[0] == min(each)]
    starts = [ratio for ratio, *each in zip(ratios, ask, search, start, strict=True) if each[2] == min(each)]
    beats = [ratio for ratio, *each in zip(ratios, ask, search, start, strict=True) if each[0] < each[2]]
    return {
        "ask_to": max(asks, default=None),
        "start_from": min(starts, default=None),
        "beats_to": max(beats, default=None),
        "costs": {name: found.cost(name, 1.0, costs)._asdict() for name in found.missions},
    }


if __name__ == "__main__":
    main(sys.argv[1])
