"""Test whether swarms in ARGoS3 and in feasibee are equivalent within margins: docs/argos.md.

Those of ARGoS are in argos.csv, as footbots.py measured them. CI has no ARGoS, so only those of feasibee are
computed again. Plan and margins (equivalence.py) were committed before either was computed.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import feasibee
from claims.measure.equivalence import (
    RATE,
    RATIO,
    Mean,
    difference,
    mean_difference,
    mean_of,
    overall,
    power,
    ratio,
    tested,
)
from claims.measure.rooms import PLACES, eight, wall
from feasibee.results.statistics import Interval
from feasibee.studies.rooms import split_of

FIGURES = Path(__file__).with_suffix(".csv")
WALLS = {"arena.boundary": "walls"}
BODIES = {**WALLS, "robots.avoid_collisions": True}
CONTACTS = {"stand": BODIES, "deflect": {**BODIES, "robots.contact": "deflect"}}
ROOMS, NARROW = ("2 rooms, door 2", "8 rooms on a corridor, doors 2"), 1.6
WORLDS = {
    "torus": {"": {}},
    "walls": {"": WALLS},
    "bodies": CONTACTS,
    **{
        place: {rule: {**changes, "place.walls": PLACES[place][0]} for rule, changes in CONTACTS.items()}
        for place in ROOMS
    },
}
"""Changes of the paper's scenario by world and rule of contact."""
RUNS, ROOM_RUNS, MOVING_RUNS, SIGHT = 20_000, 4_000, 40, 2.0
MEANS = ("steps", "way", "contacts", "robots_seen", "tasks_seen")
"""Means that are compared by their ratio: steps until the decision, or of the run if it stays undecided; the
others per robot-step until then. A contact is a robot that comes into a robot's sight."""


class Row(NamedTuple):
    """A swarm that both simulate."""

    world: str
    side: int
    robots: int
    tasks: int

    def scenario(self, contact: str = "") -> feasibee.Scenario:
        """Return the row's scenario with a rule of contact; the default is the world's first."""
        changes = WORLDS[self.world][contact or next(iter(WORLDS[self.world]))]
        own = {"arena.side": self.side, "robots.count": self.robots, "tasks.count": self.tasks}
        return feasibee.Scenario().replace({**changes, **own, "run.stop_at_decision": True})


USUAL, CROWDED, SPARSE = (20, 20, 20), (14, 20, 20), (20, 10, 10)
"""Side, robots and tasks. The rule "deflect" was chosen with the usual side and robots only."""
PLAN = {
    **{
        Row(world, *swarm): 1200
        for world in ("torus", "walls")
        for swarm in ((20, 20, 10), USUAL, (20, 20, 40), CROWDED, SPARSE)
    },
    **{Row("bodies", *swarm): 800 for swarm in (USUAL, CROWDED, SPARSE)},
    **{Row(place, *USUAL): 800 for place in ROOMS},
}
"""Number of runs in ARGoS. Robots with bodies take 40 times as long there as points."""
BLOCK = 100
"""Runs of a row before the next row's. Blocks complete at 09:25 count, in rooms those at 01:45: the clock
decides, not the results."""


def first_seed(row: Row) -> int:
    """Return the random_seed of a row's first run in ARGoS; earlier checks had seeds below 10,000."""
    return 1_000_001 + 10_000 * list(PLAN).index(row)


def our_seeds(row: Row) -> tuple[int, int]:
    """Return feasibee's seeds of a row for decisions, and for motion; earlier checks had seed 1."""
    return 100 + list(PLAN).index(row), 200 + list(PLAN).index(row)


def main() -> None:
    """Print each row of ARGoS with those of feasibee, and whether they are equivalent, as JSON."""
    argos = dict(read(FIGURES))
    swarms = [row for row in PLAN if (row.world in ROOMS) == ("rooms" in sys.argv)]
    rows = [compared(row, contact, argos[row]) for row in swarms for contact in WORLDS[row.world]]
    if "rooms" in sys.argv:
        over = [over_rows([row for row in rows if row["contact"] == contact]) for contact in CONTACTS]
        print(json.dumps({"rows": rows, "over": over, "doors": doors()}, indent=2))
        return
    worlds = [
        over_rows([row for row in rows if (row["world"], row["contact"]) == (world, contact)])
        for world in dict.fromkeys(row.world for row in swarms)
        for contact in WORLDS[world]
    ]
    print(json.dumps({"rows": rows, "worlds": worlds}, indent=2))


def doors() -> list[dict[str, Any]]:
    """Return how often a robot of feasibee changes rooms, with the doors of ARGoS and narrower ones.

    A change counts when a robot comes into another room, or into the corridor; per 1,000 steps.
    """
    found = []
    for place, narrower in ((ROOMS[0], wall(10, (0, 20), [10], NARROW, True)), (ROOMS[1], eight(NARROW))):
        row, narrow = Row(place, *USUAL), {"place.walls": narrower}
        for contact, width, changes in (("stand", 2, {}), ("deflect", 2, {}), ("deflect", NARROW, narrow)):
            scenario = row.scenario(contact).replace(changes)
            swarms = feasibee.simulate(scenario, runs=1000, seed=300)
            undecided = float((swarms.decision == -1).mean())
            split = split_of(scenario, 300, MOVING_RUNS)
            assert split is not None
            shown = {"place": place, "contact": contact, "width": width}
            found.append({**shown, "undecided": undecided, "passages": split.passages})
    return found


def read(path: Path) -> Iterator[tuple[Row, dict[str, float]]]:
    """Yield the rows that ARGoS has simulated, with their figures."""
    with path.open(newline="", encoding="utf-8") as file:
        for line in csv.DictReader(file):
            row = Row(line.pop("world"), *(int(line.pop(name)) for name in Row._fields[1:]))
            yield row, {name: float(value) for name, value in line.items()}


def compared(row: Row, contact: str, argos: dict[str, float]) -> dict[str, Any]:
    """Return what ARGoS and feasibee find for a row, and the verdicts: ARGoS minus, or over, feasibee."""
    ours = in_feasibee(row, contact)
    shares, undecided = (
        [(int(each[name]), int(each["runs"])) for each in (argos, ours)] for name in ("feasible", "undecided")
    )
    means = {
        name: ratio(*(Mean(each[name], each[f"{name}_error"]) for each in (argos, ours))) for name in MEANS
    }
    tests = {"feasible": tested(difference(*shares), RATE)}
    if row.world in ROOMS:
        tests["undecided"] = tested(difference(*undecided), RATE)
    tests |= {name: tested(found, RATIO) for name, found in means.items()}
    return {
        **row._asdict(),
        "contact": contact,
        "argos": argos | {"feasible": feasibee.wilson(*shares[0])._asdict()},
        "feasibee": ours | {"feasible": feasibee.wilson(*shares[1])._asdict()},
        "tests": tests,
        "power": power([equal(argos, ours, shares[1][0] / shares[1][1])]),
    }


def over_rows(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return what holds for all rows of a world and rule: verdicts, and the mean difference of shares."""
    tests = {name: [row["tests"][name] for row in rows] for name in rows[0]["tests"]}
    feasible = mean_difference(
        [Interval(*(each[name] for name in Interval._fields)) for each in tests["feasible"]]
    )
    return {
        "world": rows[0]["world"],
        "contact": rows[0]["contact"],
        "feasible": tested(feasible, RATE),
        "power": power(
            [equal(row["argos"], row["feasibee"], row["feasibee"]["feasible"]["estimate"]) for row in rows]
        ),
        "verdicts": {name: overall([each["verdict"] for each in found]) for name, found in tests.items()},
    }


def equal(argos: dict[str, float], ours: dict[str, float], share: float) -> tuple[float, tuple[int, int]]:
    """Return what the power of a row depends on, if ARGoS has feasibee's share."""
    return share, (int(argos["runs"]), int(ours["runs"]))


def in_feasibee(row: Row, contact: str) -> dict[str, float]:
    """Return a row's figures in feasibee, with the names of argos.csv."""
    scenario, (seed, moving_seed) = row.scenario(contact), our_seeds(row)
    swarms = feasibee.simulate(scenario, runs=ROOM_RUNS if row.world in ROOMS else RUNS, seed=seed)
    decision, steps = swarms.decision.to_numpy(), swarms.decision_step.to_numpy()
    moving = np.array([motion(feasibee.Swarm(scenario, moving_seed, run)) for run in range(MOVING_RUNS)])
    return figures(decision, np.where(steps < 0, scenario.run.steps, steps), moving[:, 0], moving[:, 1:].T)


def figures(decision: Any, steps: Any, lengths: Any, moving: Any) -> dict[str, float]:
    """Return counts of decisions, and means with their errors; those of moving are weighted by lengths."""
    means = [mean_of(steps), *(mean_of(each, lengths) for each in moving)]
    return {
        "runs": len(decision),
        "feasible": int((decision == 1).sum()),
        "undecided": int((decision == -1).sum()),
        **{name: each.mean for name, each in zip(MEANS, means, strict=True)},
        **{f"{name}_error": each.error for name, each in zip(MEANS, means, strict=True)},
    }


def motion(swarm: feasibee.Swarm) -> tuple[float, ...]:
    """Simulate until the decision; return the steps, and way, contacts, and sightings per robot-step."""
    side, _ = swarm.scenario.arena.size
    around = side if swarm.scenario.arena.boundary == "torus" else np.inf
    boxes = np.array([(each[0], each[2]) for each in swarm.scenario.place.walls])
    sums = np.zeros(4)
    before, seen = swarm.positions, in_sight(swarm.positions, swarm.positions, around, boxes)
    while swarm.decision < 0 and swarm.step < swarm.scenario.run.steps:
        swarm.advance()
        now = swarm.positions
        sees = in_sight(now, now, around, boxes)
        ways = np.linalg.norm(shortest(now - before, around), axis=-1)
        others = sees.sum() - len(now)
        sums += ways.sum(), (sees & ~seen).sum(), others, in_sight(now, swarm.tasks, around, boxes).sum()
        before, seen = now, sees
    return swarm.step, *(sums / (max(1, swarm.step) * len(before)))


def in_sight(places: np.ndarray, others: np.ndarray, around: float, boxes: np.ndarray) -> np.ndarray:
    """Return which places see which others; each sees itself. Boxes hide what is behind: (boxes, 2, 2)."""
    sees = np.linalg.norm(shortest(places[:, None] - others[None], around), axis=-1) <= SIGHT
    one, other = sees.nonzero()
    if boxes.size:
        sees[one, other] = ~hidden(places[one], others[other], boxes)
    return sees


def hidden(starts: np.ndarray, ends: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """Return whether the straight way of each start to its end meets a box, given by two corners."""
    with np.errstate(divide="ignore"):
        edges = (boxes[:, :, None] - starts) / (
            ends - starts
        )  # parts of the ways: boxes, corners, ways, axes
    first, last = edges.min(axis=1).max(axis=-1), edges.max(axis=1).min(axis=-1)
    return np.asarray((np.maximum(first, 0) <= np.minimum(last, 1)).any(axis=0))


def shortest(difference: np.ndarray, around: float) -> np.ndarray:
    """Return differences of places, the short way round on a torus; ``around`` is inf within walls."""
    return difference if np.isinf(around) else (difference + around / 2) % around - around / 2


if __name__ == "__main__":
    main()
