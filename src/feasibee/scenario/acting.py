"""The rules about robots that act (model.md 6.25), and how many tasks they can take."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Final

from feasibee.model.codes import exact
from feasibee.scenario.feasibility import explain_kinds, kinds_of
from feasibee.scenario.fields import Robots, Tasks
from feasibee.scenario.placing import PLACES
from feasibee.scenario.rules import Conflict, Rule, after, default_unless, never
from feasibee.scenario.sections import Sections

NEWS_LIMIT: Final = 4 * 2**30
"""Largest memory of what all robots of a swarm know of tasks, and of the ways to these, in bytes."""


def ranks_of(robots: Robots) -> list[int]:
    """Return the rank of each class of robots: 1 for the most skilled (model.md 6.25.1)."""
    numbers = [len(set(each.skills)) for each in robots.classes] or [0]
    return [1 + len({each for each in numbers if each > own}) for own in numbers]


def can_do(robots: Robots, tasks: Tasks) -> list[list[bool]]:
    """Return for each class of robots whether it can do a task of each class (model.md 6.7)."""
    needs = [set(each.needs) for each in tasks.classes] or [set[str]()]
    skills = [set(each.skills) for each in robots.classes] or [set[str]()]
    return [[need <= own for need in needs] for own in skills]


def most_taken(scenario: Sections, robots: Iterable[int]) -> int:
    """Return how many tasks of the start robots of these classes can take at once.

    It follows from Hall's condition, with its defect.
    """
    violator = explain_kinds(scenario, robots, kinds_of(scenario.tasks)).violator
    return scenario.tasks.count - (violator.demand - violator.robots if violator else 0)


def status_bits(scenario: Sections) -> int:
    """Return the length of what a message says of a task's status (model.md 6.25.7)."""
    return max(ranks_of(scenario.robots)).bit_length() + 8 * scenario.may_come_free


def _alone(key: str) -> Rule:
    return default_unless(
        f"acting.{key}",
        lambda s: s.acts,
        "needs acting.start: without it, no robot acts",
        'set acting.start = "safe", or leave it out',
    )


def _exact(key: str) -> Rule:
    return never(
        f"sensing.{key}",
        lambda s: s.acts and getattr(s.sensing, key),
        "must be 0 for robots that act: they go where they saw a task",
        "set it to 0, or leave out acting.start",
    )


def _reach(scenario: Sections) -> Iterator[Conflict]:
    """Find reaches with which robots never arrive: they walk past, or bodies and walls keep them away."""
    robots, least, why = scenario.robots, scenario.robots.speed, "robots.speed, or robots walk past"
    if robots.avoid_collisions and robots.diameter > least:
        least, why = robots.diameter, "robots.diameter, or a robot keeps others from tasks near its own"
    corner = math.ceil(1000 * robots.diameter / math.sqrt(2)) / 1000
    if scenario.arena.boundary == "walls" and corner > least:
        least, why = corner, "0.71 diameters, or walls keep robots from tasks in corners"
    if scenario.acts and exact(scenario.acting.reach) < exact(least):
        yield Conflict("acting.reach", f"must be at least {why}", f"set it to {least:g} or more")


def _memory(scenario: Sections) -> Iterator[Conflict]:
    robots, tasks = scenario.most
    needed = 4 * robots * tasks * (2 + scenario.radio.delay)
    if scenario.acts and scenario.plan:
        needed += 4 * (tasks + 2) * scenario.plan.walls.size
    if scenario.acts and needed > NEWS_LIMIT:
        rule = f"needs {needed / 2**30:.1f} GiB for what robots know, above {NEWS_LIMIT // 2**30} GiB"
        remedy = "use fewer robots or tasks, or larger cells, or leave it out"
        yield Conflict("acting.start", rule, remedy, "acting robots")


ACTING: Final[tuple[Rule, ...]] = (
    *map(_alone, ("choose", "hold", "reach")),
    _reach,
    never(
        "acting.start",
        lambda s: s.acting.start == "declared" and not (s.manifest.declares or s.decision.declare),
        '"declared" needs robots that declare',
        'set it to a step or "safe", set decision.declare, or choose quiet-census',
    ),
    never(
        "tasks.work",
        lambda s: s.tasks.work is not None and not s.acts,
        "needs acting.start: without it, no robot works at a task",
        'leave it out, or set acting.start = "safe"',
    ),
    never(
        "acting.choose",
        lambda s: s.acting.choose == "rank" and s.radio.id_bits is not None,
        '"rank" needs the numbers of robots, but radio.id_bits makes ids random',
        'set it to "nearest", or leave out radio.id_bits',
    ),
    never(
        "acting.choose",
        lambda s: s.acting.choose == "rank" and s.acting.hold == "tag",
        '"rank" gives each robot its task, so none is marked',
        'set it to "nearest", or set acting.hold = "stand"',
    ),
    *map(_exact, ("misname", "position_error")),
    never(
        "robots.work",
        lambda s: s.acts and s.robots.work is not None,
        "can't be combined with acting.start: nobody would stand at the task of a robot that charges",
        "leave it out, or leave out acting.start",
    ),
    never(
        "tasks.classes",
        lambda s: s.acts and any(sum(each.needs.values()) != 1 for each in s.tasks.classes),
        "must need one robot for each task if robots act",
        "split the tasks into tasks for one robot, or leave out acting.start",
    ),
    never(
        "run.stop_when_taken",
        lambda s: s.run.stop_when_taken and not s.acts,
        "needs acting.start: without it, no task is taken",
        'set it to false, or set acting.start = "safe"',
    ),
    never(
        "run.stop_when_taken",
        lambda s: s.run.stop_when_taken and s.most.tasks > s.tasks.count,
        "ends a run once all tasks are taken, but more appear",
        "leave it out, or leave out tasks.arrival_rate and events with tasks",
    ),
    after(PLACES, _memory),
)
"""The rules about the section ``acting``."""
