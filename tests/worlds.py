"""Worlds drawn at random for the conformance suite: every field of a scenario, and its edges."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from feasibee import STRATEGIES, Scenario, ScenarioError
from feasibee.scenario.supported import FAST_PATH, takes_fast_path
from tests.places import bitmap, random_cells, rectangle

FEW = (1, 2, 3, 5, 8, 8, 12, 12, 16, 20, 20, 31, 32, 33, 33, 40, 64, 65, 97, 128)
CROWDS = (129, 160, 161, 193, 256, 257)
OWN = [str(each) for each in sorted((Path(__file__).parents[1] / "examples" / "strategies").glob("*.py"))]
"""Strategies of users: each is compiled once, for 1 s."""
PARAMETERS = (-1.0, 0.0, 0.6, 1.0, 2.5, 12.0, 30.0, 1e300)
"""Values of any parameter of a strategy."""
LEAST = {"cell": 1.7}  # smaller cells of a map would take minutes
BY_NAME = [name for name, each in STRATEGIES.items() if each.by_name]
BY_VOTES = [name for name, each in STRATEGIES.items() if not each.knowledge]
RULE = {"quorum": 0.6, "rounds": 2, "heard": 2}
SKILLS = ("lift", "scan", "push")
PARTS: dict[str, dict[str, tuple[Any, ...]]] = {
    "decisions": {
        "walk.mean_run": (0.3, 1.0, 3.3, 50.0),
        "decision.dissemination_floor": (1, 2, 7),
        "decision.quality_floor": (1, 4),
        "decision.listen": ("dissemination", {"last": 1}, {"last": 3}),
        "decision.inbox": ("every-message",),
        "decision.inbox_size": (1, 2, 6),
        "decision.own_vote": (False,),
        "decision.ties": ("random-message",),
        "decision.start": ("first-sight",),
        "decision.threshold": (0.5, 0.6, 0.77, 0.666666667, 1.0),
        "decision.declare": (RULE, {**RULE, "quorum": 0.0}, {**RULE, "rounds": 1}),
    },
    "sight": {
        "sensing.count_self": (True,),
        "sensing.observation": ("unique",),
        "sensing.miss": (0.1, 0.5, 1.0),
        "sensing.false_robots": (0.3, 2.0, 20.0),
        "sensing.false_tasks": (0.3, 2.0, 20.0),
        "sensing.misname": (0.1, 0.8),
        "sensing.position_error": (0.02, 0.1),  # in ranges of sight, as the gate
        "sensing.gate": (0.02, 0.5),
        "sensing.view": (1e-9, 90.0, 180.0, 300.0),
    },
    "radio": {
        "radio.range": (0.05, 0.2, 0.5),  # in shorter sides of the arena
        "radio.loss": (0.1, 0.5, 1.0),
        "radio.delay": (1, 3, 20),
        "radio.id_bits": (1, 4, 8, 32),
        "radio.walls": (0.3, 1.0),
    },
    "bodies": {"robots.avoid_collisions": (True,), "robots.contact": ("deflect",)},
    "faults": {
        "faults.stopped": (0.1, 0.3, {"count": 1}),
        "faults.stop_step": (0, 5, 20),
        "faults.byzantine": (0.1, 0.3, {"count": 1}),
        "faults.byzantine_says": ("feasible", "infeasible", "random", "colluding"),
        "faults.stubborn": (0.2, {"count": 1}),
    },
    "placing": {
        **{f"{each}.placement": ("clusters", "points") for each in ("robots", "tasks")},
        **{f"{each}.clusters": (1, 2, 5) for each in ("robots", "tasks")},
        **{f"{each}.spread": (0.05, 0.5) for each in ("robots", "tasks")},
        **{f"{each}.zone": ("dock",) for each in ("robots", "tasks")},
    },
    "change": {
        "robots.arrival_rate": (0.05, 0.5),
        "robots.failure_rate": (0.01, 0.1),
        "robots.most": (0, 1, 12),  # more than there are
        "tasks.arrival_rate": (0.05, 0.5),
        "tasks.lifetime": (3.0, 20.0, 80.0),
        "events": (1, 2, 4),
    },
    "batteries": {"robots.work": (2, 9), "robots.charge": (1, 5), "robots.away": ("missing",)},
    "acting": {
        "acting.start": (0, 0, 0, 5, "declared", "search", "safe"),
        "acting.choose": ("rank",),
        "acting.hold": ("tag",),
        "acting.reach": (1.0, 2.0, 4.0),  # in least reaches
        "tasks.work": (1, 7),
        "run.stop_when_taken": (True,),
    },
    "ends": {"run.stop_at_decision": (True,), "run.stop_at_declarations": (True,)},
    "units": {"units.metres": (0.5,), "units.seconds": (0.1,)},
}
"""Values of fields: each part of them is drawn for some worlds; the fields that aren't here, for all."""
ALWAYS = {"acting.start", "robots.work", "robots.charge", "robots.avoid_collisions"}
"""Fields without which the others of their part mean nothing."""
EDGES = {
    "robots.placement",
    "sensing.count_self",
    "sensing.observation",
    "radio.id_bits",
    "decision.own_vote",
}
"""Fields in whose worlds all stand on a lattice, so that many are apart by exactly a range."""
BY_ONE_THREAD, OF_KNOWLEDGE = ("change", "batteries", "acting"), "sensing.misname"
"""Parts of which one thread plays a run, however many robots there are; and a field that needs knowledge."""


def fields_of(fast: bool = False, shared: bool = False) -> list[str]:
    """Return the fields that worlds of a kind set in turn: the n-th world sets the n-th of them."""
    parts = (fields for name, fields in PARTS.items() if not (shared and name in BY_ONE_THREAD))
    paths = [path for fields in parts for path in fields if not fast or path in FAST_PATH]
    return [path for path in paths if not (shared and path == OF_KNOWLEDGE)]


def world(
    number: int, robots: Sequence[int] = FEW, *, fast: bool = False, own: bool = False, shared: bool = False
) -> Scenario:
    """Return one of endlessly many worlds of the general path, or of the fast path.

    `own` adds strategies of users. Several threads may play a world that is `shared`.
    """
    draw, fields = Random(number), fields_of(fast, shared)
    names = BY_VOTES if fast else [*STRATEGIES, *BY_NAME, *(OWN if own else ())]
    wanted = fields[number % len(fields)]
    for _ in range(200):
        found = settled(draw, drawn(draw, draw.choice(robots), draw.choice(names), wanted, fields))
        if found is None or takes_fast_path(found) != fast or (shared and by_one_thread(found)):
            continue
        if value(found, wanted) != value(Scenario(), wanted):
            return found.with_flooding(draw.choice((3, 25, 60))) if found.waits_for_names else found
    raise AssertionError(f"no world of this kind sets {wanted}")


def value(scenario: Scenario, path: str) -> Any:
    """Return the value of a field."""
    section, name = path.split(".") if "." in path else ("", path)
    return getattr(getattr(scenario, section) if section else scenario, name)


def by_one_thread(scenario: Scenario) -> bool:
    """Return whether one thread plays a run, however many robots there are."""
    return scenario.strategy.knowledge or scenario.in_motion or scenario.acts


def drawn(draw: Random, robots: int, strategy: str, wanted: str, fields: Sequence[str]) -> dict[str, Any]:
    """Return changes of the paper's scenario, which may not go together; one of them is of a wanted field."""
    tasks = draw.choice((0, 1, robots, robots + 1, 2 * robots, draw.randint(1, 90)))
    side = round(max(3.0, draw.uniform(1.0, 6.0) * robots**0.5), 2)
    general = "sensing.view" in fields  # and not the fast path alone
    edges = general and wanted in EDGES
    sides, changes = arena(draw, side) if general and not edges else ((side, side), {"arena.side": side})
    shorter = min(sides)
    sight = draw.choice((0.03, 0.1, 0.2, 0.3, 0.5)) * shorter
    changes |= {
        "run.steps": min(  # the reference takes its time
            draw.choice((1, 40, 70, 100)),
            max(5 if robots < 1000 else 3, 80_000 // (robots * (robots + tasks))),
        ),
        "decision.strategy": strategy,
        "decision.exploration": draw.choice((0.4, 1.0, 4.0, 8.0, 40.0)),
        "decision.gain": draw.choice((0.5, 3.0, 8.0, 30.0, 60.0)),
        "sensing.range": sight,
        "robots.speed": draw.choice((0.0, 0.05, 0.3, 0.7, 1.0)),
        "robots.diameter": draw.choice((0.2, 0.5, 1.0)),
        "robots.know_count": draw.random() < 0.5,
        **parts_of(draw, wanted, fields),
    }
    if strategy in STRATEGIES:
        own = [each for each in STRATEGIES[strategy].parameters if draw.random() < 0.5]
        changes["decision.parameters"] = {
            each: max(draw.choice(PARAMETERS), LEAST.get(each, -1.0)) for each in own
        }
    for kind, count in (("robots", robots), ("tasks", tasks)):
        if draw.random() < 0.3 and general:
            changes[f"{kind}.classes"] = classes(draw, kind, count, "acting.start" in changes)
        else:
            changes[f"{kind}.count"] = count
        if changes.get(f"{kind}.placement") == "points":
            spots = [[draw.uniform(0.05, 0.95) * each for each in sides] for _ in range(count)]
            changes[f"{kind}.points"] = spots
    least = max(changes["robots.speed"], changes["robots.diameter"])
    sizes = {"spread": shorter, "range": shorter, "position_error": sight, "gate": sight, "reach": least}
    for path in set(changes) - {"sensing.range"}:
        changes[path] = changes[path] * sizes[end] if (end := path.split(".")[-1]) in sizes else changes[path]
    if "robots.most" in changes:
        changes["robots.most"] += robots
    if "events" in changes:
        changes["events"] = [event(draw, changes["run.steps"], sides) for _ in range(changes["events"])]
    return changes | (on_a_lattice(draw, robots, tasks) if edges else {})


def parts_of(draw: Random, wanted: str, fields: Sequence[str]) -> dict[str, Any]:
    """Return values of some parts' fields, a wanted one's in any case."""
    changes = {}
    for part in PARTS.values():
        if wanted in part or draw.random() < 0.4:
            changes |= {
                path: draw.choice(part[path])
                for path in part
                if path in fields and (path in ALWAYS or path == wanted or draw.random() < 0.5)
            }
    return changes


def on_a_lattice(draw: Random, robots: int, tasks: int) -> dict[str, Any]:
    """Return changes that let all stand on a lattice, at places that are exact in fixed point."""
    changes: dict[str, Any] = {"arena.side": [16.0, 16.0], "robots.speed": 0.0, "run.steps": 20}
    for kind, count in (("robots", robots), ("tasks", tasks)):
        spots = [[float(draw.randint(1, 15)) for _ in "xy"] for _ in range(count)]
        changes |= {f"{kind}.placement": "points", f"{kind}.points": spots}
    ranges = {"sensing.range": draw.choice((1.0, 2.0, 5.0)), "radio.range": draw.choice((1.0, 4.0, 5.0))}
    return changes | ranges | {"arena.boundary": draw.choice(("torus", "walls"))}


def arena(draw: Random, side: float) -> tuple[tuple[float, float], dict[str, Any]]:
    """Return the sides of an arena, and its fields."""
    how, ratio = draw.choice(("torus", "walls", "walls", "place", "place")), draw.choice((15, 24, 24, 32))
    cell = round(side / 24, 2)
    sides = round(24 * cell, 2), round(ratio * cell, 2)
    changes: dict[str, Any] = {"arena.side": list(sides)}
    if how != "torus":
        changes["arena.boundary"] = "walls"
    if how == "place":
        random = np.random.default_rng(draw.randint(0, 2**32))
        closed, kept_out = (bitmap(random_cells(random, ratio, 24, number), cell) for number in (5, 2))
        x, y = draw.uniform(0.1, 0.8) * sides[0], draw.uniform(0.1, 0.6) * sides[1]
        walls = [rectangle(x, y, x + 0.3, y + sides[1] / 3)]
        changes |= (
            {"place.map": closed} if draw.random() < 0.5 else {"place.walls": walls, "place.cell": cell}
        )
        changes |= {"place.keepout": kept_out} if draw.random() < 0.3 else {}
        changes["place.zones"] = {"dock": [rectangle(0.0, 0.0, 0.7 * sides[0], 0.9 * sides[1])]}
    return sides, changes


def classes(draw: Random, kind: str, count: int, acts: bool) -> list[dict[str, Any]]:
    """Return classes, of which some may be empty; where robots act, each task needs one of them."""
    first, made = draw.randint(0, count), []
    for name, size in (("a", first), ("b", count - first)):
        skills = draw.sample(SKILLS, 1 if acts and kind == "tasks" else draw.randint(1, 2))
        needs = {each: 1 if acts else draw.randint(1, 3) for each in skills}
        made.append(
            {"name": name, "count": size, **({"skills": skills} if kind == "robots" else {"needs": needs})}
        )
    return made


def event(draw: Random, steps: int, sides: tuple[float, float]) -> dict[str, Any]:
    """Return what happens at a step."""
    kind = draw.choice(("both", "both", "robots", "tasks", "robot", "task"))
    found = {
        "step": draw.randint(0, steps),
        "tasks": draw.choice((-9, -2, 3, 12)),
        "robots": draw.choice((-3, 0, 5)),
    }
    if kind != "both":
        at = [round(draw.uniform(0.1, 0.9) * each, 3) for each in sides]
        found = {"step": found["step"], kind: draw.randint(1, 5), "at": at}
    more = {"sensing": {"miss": draw.choice((0.0, 0.4))}, "radio": {"loss": draw.choice((0.0, 0.4))}}
    return found | {each: more[each] for each in more if draw.random() < 0.3}


def settled(draw: Random, changes: dict[str, Any]) -> Scenario | None:
    """Return a scenario with changes, less those that don't go together; None if that takes too long."""
    for _ in range(20):
        try:
            return Scenario().replace(changes)
        except ScenarioError as error:
            path = draw.choice(error.problems).path
        if path in ("robots.count", "robots.diameter") and "robots.avoid_collisions" in changes:
            path = draw.choice(("robots.avoid_collisions", path))
        if path == "robots.know_count":
            changes[path] = True
        elif path == "acting.start":  # nobody declares
            changes["decision.declare"] = RULE
        elif path == "decision.strategy":  # it declares, and the world changes
            changes = {
                each: changes[each] for each in changes if each not in {*PARTS["change"], "robots.away"}
            }
        elif path.startswith("events."):
            with suppress(IndexError):
                del changes["events"][int(path.split(".")[1])]
        else:
            ends = [
                each for each in changes if f"{each}.".startswith(f"{path}.") or path.startswith(f"{each}.")
            ]
            if not ends:
                return None
            for each in ends:
                del changes[each]
    return None
