"""Places at random, most with something wrong: each loads, or gives problems with remedies."""

from __future__ import annotations

import numpy as np
import pytest
from places import bitmap, random_cells, rectangle

from feasibee import Scenario, ScenarioError, truth

STRATEGIES = ("map", "roster", "quiet-census", "turns", "census", "dmmd")
SKILLED = ({"skills": ["x"]}, {"needs": {"x": 1}})
HIGH = {
    "arena": {"boundary": "walls", "side": 6.0},
    "robots": {"count": 1, "placement": "points", "points": [[3.5, 1.3]]},
    "place": {"cell": 1.0, "walls": [rectangle(3.0, 0.0, 3.3, 3.6)]},
}
"""A robot at a point too near a wall."""


def box(random, side, large):
    """Return a rectangle: a wall, a zone, or, one time in four, nearly the whole arena."""
    if random.random() < 0.08:
        return rectangle(0.0, 0.0, side, side - random.choice([0.0, 0.5]))
    corner = random.uniform(0, side, 2).round(1)
    return rectangle(*corner.tolist(), *(corner + random.uniform(0.1, side * large, 2)).tolist())


def placed(random, zones, side, skilled):
    """Return where robots or tasks are: at points anywhere, in a zone that may be missing, or anywhere."""
    count = int(random.choice([0, 1, 3, 7], p=[0.05, 0.3, 0.35, 0.3]))
    kind = random.choice(["points", "zone", "uniform", "clusters", "classes"], p=[0.12, 0.3, 0.5, 0.02, 0.06])
    if kind == "points":
        points = random.uniform(0, 1.02 * side, (count, 2)).round(1).tolist()
        return {"placement": "points", "points": points} | ({"count": 3} if random.random() < 0.1 else {})
    if kind == "zone":
        return {"count": count, "zone": str(random.choice([*zones, *zones, *zones, "nowhere"]))}
    if kind == "classes":
        return {"classes": [{"name": "a", "count": count, **skilled}]}
    return {"count": count, "placement": str(kind)} if kind == "clusters" else {"count": count}


def place_of(random, side, cell):
    """Return the table of a place, some of whose masks and maps don't fit the arena."""
    zones = {name: box(random, side, 1.0) for name in ("a", "b")[: random.integers(1, 3)]}
    walls = [box(random, side, 0.4) for _ in range(random.integers(0, 4))]
    place = {"cell": cell, "walls": walls, "zones": zones}
    rows = round(side / cell) + int(random.random() < 0.2)
    if random.random() < 0.15:
        place["keepout"] = bitmap(random_cells(random, rows, rows, 3), cell)
    if random.random() < 0.15:
        place["map"] = bitmap(random_cells(random, rows, rows, 5), cell)
    return place


def tables_at_random(seed):
    """Return the tables of a scenario with a place; most of them have something wrong."""
    random = np.random.default_rng(seed)
    side = float(random.choice([4.0, 6.0, 10.0]))
    cell = float(random.choice([0.3, 0.25, 0.5, 1.0], p=[0.02, 0.3, 0.4, 0.28]))
    place = place_of(random, side, cell)
    robots, tasks = (placed(random, place["zones"], side, each) for each in SKILLED)
    robots |= {"diameter": float(random.choice([0.2, 0.5, 1.5, 7.0], p=[0.6, 0.3, 0.08, 0.02]))}
    robots |= {"speed": float(random.choice([0.1, 1.0, 3.0, 1e5], p=[0.5, 0.44, 0.03, 0.03]))}
    robots |= {"know_count": bool(random.random() < 0.97), "avoid_collisions": bool(random.random() < 0.4)}
    strategy = str(random.choice(STRATEGIES))
    tables = {
        "arena": {"boundary": "walls", "side": side},
        "place": place,
        "robots": robots,
        "tasks": tasks,
        "decision": {"strategy": strategy},
    }
    wrong = random.random()
    if wrong < 0.08:
        tables["events"] = [{"step": 5, "tasks": 1, "at": random.uniform(0, side, 2).round(1).tolist()}]
    elif wrong < 0.16:
        tables["acting"] = {"start": "search"}
    elif wrong < 0.2:
        tables["place"]["cell"] = float(random.choice([-1.0, 1e-9]))
    elif wrong < 0.24:
        tables[str(random.choice(["robots", "tasks", "arena"]))]["side"] = "wide"
    elif wrong < 0.28:
        tables["sensing"] = {"range": float(random.choice([0.01, 1e6]))}
    return tables


def problems_of(tables):
    """Return the paths of a scenario's problems; without any, whether its tasks are feasible."""
    try:
        return [], truth(Scenario(**tables))
    except ScenarioError as error:
        return [each.path if each.rule and each.remedy else "" for each in error.problems], None


def test_places_at_random_load_or_give_problems_with_remedies():
    found = [problems_of(tables_at_random(seed)) for seed in range(50)]
    assert {True, False, None} == {feasible for _, feasible in found}
    paths = {path for paths, _ in found for path in paths}
    assert len(paths) > 10
    assert all(paths)


MASK = bitmap(np.zeros((5, 5), bool), 1.0)
FINE = {"cell": 1e-3, "walls": [rectangle(3.0, 0.0, 3.3, 3.6)]}


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize(
    ("changes", "path"),
    [
        ({}, "robots.points"),
        ({"robots": {"count": 3, "speed": 1e6}}, "robots.speed"),
        ({"robots": {"classes": [{"name": "a", "count": 0}]}}, "robots.classes"),
        ({"place": {**HIGH["place"], "keepout": MASK}, "acting": {"start": "search"}}, "place.keepout"),
        ({"place": FINE, "acting": {"start": "search"}}, "place.cell"),
    ],
)
def test_a_wrong_place_is_a_problem_whatever_the_strategy_computes_from_it(strategy, changes, path):
    assert path in problems_of({**HIGH, "decision": {"strategy": strategy}, **changes})[0]
