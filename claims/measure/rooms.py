"""Measure how often robots declare wrongly in rooms, and how soon names flood them, for docs/places.md."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import numpy as np

from feasibee import Scenario, simulate
from feasibee.results.measures import declarations
from feasibee.simulation.flooding import flooding

Polygon = list[list[float]]
RUNS, MORE_RUNS = 1000, 3000
SEED, FRESH_SEED = 5, 77
WORST = "40 obstacles"
CHANGES = {
    "unknown": {"robots.know_count": False},
    "dock": {"place.zones": {"dock": [[[0, 0], [4, 0], [4, 4], [0, 4]]]}, "robots.zone": "dock"},
    "colluding": {"faults.byzantine": {"count": 1}, "faults.byzantine_says": "colluding"},
}
CHANGED = ("2 rooms, door 1", "8 rooms on a corridor, doors 1", "12 shelves")
LATE_RUNS, LATE_STEPS = 100, 1500


def box(left: float, low: float, right: float, top: float) -> Polygon:
    """Return a rectangle."""
    return [[left, low], [right, low], [right, top], [left, top]]


def wall(
    at: float, ends: tuple[float, float], doors: list[float], width: float, upright: bool
) -> list[Polygon]:
    """Return a wall 0.2 thick with doors around some centres."""
    edges = [ends[0], *(each + half for each in doors for half in (-width / 2, width / 2)), ends[1]]
    parts = zip(edges[::2], edges[1::2], strict=True)
    found = [box(at - 0.1, low, at + 0.1, top) for low, top in parts]
    return found if upright else [[[y, x] for x, y in each] for each in found]


def eight(width: float) -> list[Polygon]:
    """Return eight rooms on a corridor 3 units wide."""
    found = [part for y in (8.5, 11.5) for part in wall(y, (0, 20), [2.5, 7.5, 12.5, 17.5], width, False)]
    return found + [box(x - 0.1, low, x + 0.1, low + 8.5) for x in (5, 10, 15) for low in (0, 11.5)]


def obstacles(seed: int, number: int, least: float, most: float) -> list[Polygon]:
    """Return obstacles of random sizes at random places."""
    random, found = np.random.default_rng(seed), []
    for _ in range(number):
        width, height = (round(float(each), 2) for each in random.uniform(least, most, 2))
        x, y = (round(float(random.uniform(0, 20 - side)), 2) for side in (width, height))
        found.append(box(x, y, round(x + width, 2), round(y + height, 2)))
    return found


SHELVES = [
    box(2.5 + 4.2 * j, 2.5 + 5.8 * i, 3.5 + 4.2 * j, 5.9 + 5.8 * i) for i in range(3) for j in range(4)
]
PLACES: dict[str, tuple[list[Polygon], tuple[float, float]]] = {
    "hall": ([], (20, 20)),
    **{f"2 rooms, door {width:g}": (wall(10, (0, 20), [10], width, True), (20, 20)) for width in (2, 1)},
    **{f"8 rooms on a corridor, doors {width:g}": (eight(width), (20, 20)) for width in (2, 1)},
    "corridor of 100 by 4": ([], (100, 4)),
    "12 shelves": (SHELVES, (20, 20)),
    "40 obstacles": (obstacles(1, 40, 0.5, 2), (20, 20)),
}


def scenario_in(walls: list[Polygon], size: tuple[float, float]) -> Scenario:
    """Return 20 robots and 21 tasks in a place."""
    return Scenario(
        arena={"side": list(map(float, size)), "boundary": "walls"},
        place={"walls": walls} if walls else {"zones": {"all": [box(0, 0, *size)]}},
        robots={"diameter": 0.5, "avoid_collisions": True, "contact": "deflect", "know_count": True},
        tasks={"count": 21},
        run={"stop_at_declarations": True},
    )


flooding_in = cache(flooding)


def wrong_in(
    scenario: Scenario, strategy: str, runs: int = RUNS, seed: int = SEED, **parameters: float
) -> dict[str, Any]:
    """Return how soon names flood, how many swarms declare wrongly, and when they declare."""
    times = flooding_in(scenario)
    changes = {"decision.strategy": strategy, "decision.parameters": parameters}
    one = scenario.replace({**changes, "run.steps": 10 * times.slowest})
    told = declarations(simulate(one, runs, seed=seed), one)
    assert told is not None
    steps = {"step": told.step_90.median, "step_95": told.step_90.p95}
    return {**times._asdict(), "wrong": told.wrong.estimate, "high": told.wrong.high, **steps}


def plans() -> list[dict[str, Any]]:
    """Return by place how often map declares wrongly, and how many robots are right by others."""
    found: list[dict[str, Any]] = []
    for name, place in PLACES.items():
        scenario = scenario_in(*place)
        one = scenario.replace({"decision.strategy": "map", "run.steps": 4000})
        told = declarations(simulate(one, RUNS, seed=SEED), one)
        assert told is not None
        said = {"wrong": told.wrong.estimate, "high": told.wrong.high}
        row: dict[str, Any] = {
            "place": name,
            **said,
            "median": told.step_90.median,
            "p95": told.step_90.p95,
        }
        late = {"run.steps": LATE_STEPS}
        for tasks, side in ((16, "feasible_at_end"), (24, "infeasible_at_end")):
            changes = {"decision.strategy": "roster", "tasks.count": tasks, "run.stop_at_declarations": False}
            right = simulate(scenario.replace({**changes, **late}), LATE_RUNS, seed=SEED)[side].values / 20
            row[f"roster_{tasks}"] = float(right.mean())
        found.append(row)
    return found


def changed() -> list[dict[str, Any]]:
    """Return how often swarms of a place declare wrongly with n unknown, from a dock, and lied to."""
    found = []
    for place in CHANGED:
        row: dict[str, Any] = {"place": place}
        for name, changes in CHANGES.items():
            scenario = scenario_in(*PLACES[place]).replace(changes)
            tolerates = {"tolerates": 1.0} if name == "colluding" else {}
            row[name] = wrong_in(scenario, "quiet-census", **tolerates)
        found.append(row)
    return found


def main() -> None:
    """Print the measures of each place."""
    worlds = {name: scenario_in(*each) for name, each in PLACES.items()}
    rows = [
        {
            "place": name,
            "quiet_census": wrong_in(world, "quiet-census"),
            "turns": wrong_in(world, "turns"),
        }
        for name, world in worlds.items()
    ]
    found = {
        "rows": rows,
        "more": wrong_in(worlds[WORST], "quiet-census", MORE_RUNS, FRESH_SEED),
        "changed": changed(),
        "plans": plans(),
    }
    print(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
