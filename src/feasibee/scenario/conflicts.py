"""The rules between fields of a scenario: each conflict becomes a problem with a remedy.

A rule reads the typed sections. If a field that it reads is wrong itself, the rule has nothing to say.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, Final

from feasibee.errors import Problem
from feasibee.model.codes import exact
from feasibee.scenario.acting import ACTING
from feasibee.scenario.fields import Event
from feasibee.scenario.paths import value_at
from feasibee.scenario.placing import PLACES
from feasibee.scenario.rules import (
    AS_GIVEN,
    BOTH,
    Conflict,
    Rule,
    after,
    both,
    broken,
    never,
)
from feasibee.scenario.sections import KINDS, Sections
from feasibee.scenario.setting import excess
from feasibee.scenario.standing import standing
from feasibee.scenario.tables import FilePoints
from feasibee.scenario.types import Point
from feasibee.strategies.contract import Strategy

WHO: Final = (*BOTH, "task", "robot")
"""What an event brings, or names."""
TASKS_LIMIT = 10_000_000
"""Tasks that may appear in one run."""
SKILLS = 8
UNIQUE_LIMIT = 4 * 2**30
"""Largest memory of unique observations of all robots of a swarm, in bytes."""


def conflicts(scenario: Sections, given: Mapping[str, Any], partly: bool) -> Iterator[Problem]:
    """Yield a problem for each rule about several fields that a scenario breaks.

    Problems show the values as given. If the scenario is partly wrong, it lacks the fields that are wrong
    themselves, and rules that read one are skipped.
    """
    for rule in (*RULES, *both(partial(_points, given=given))):
        try:
            for found in rule(scenario):
                value = _value(found.path, given, scenario) if found.value is AS_GIVEN else found.value
                yield Problem(found.path, value, found.rule, found.remedy)
        except AttributeError:
            if not partly:
                raise


def _value(path: str, given: Mapping[str, Any], scenario: Sections) -> object:
    """Return the value at a path as the user wrote it, such as 3 for 3.0, or the default."""
    try:
        return value_at(given, path)
    except LookupError:
        return value_at(scenario, path)


# --- Robots, tasks and faults ---


def _counts(scenario: Sections, name: str) -> Iterator[Conflict]:
    section = getattr(scenario, name)
    counted = "count" in section.model_fields_set
    if section.classes and counted:
        rule = f"can't be combined with [[{name}.classes]]"
        yield Conflict(f"{name}.count", rule, f"leave {name}.count out: the classes have counts")
        return
    names = [each.name for each in section.classes]
    for twice in sorted({each for each in names if names.count(each) > 1}):
        yield Conflict(f"{name}.classes", "is the name of two classes", "give each class its own name", twice)
    if name == "robots" and section.classes and section.count < 1:
        rule = "must have at least 1 robot together"
        yield Conflict("robots.classes", rule, "set a count to 1 or more", 0)
    if section.placement != "points":
        return
    path, points = f"{name}.points", len(section.points)
    if not points:
        rule = f'is missing, but {name}.placement is "points"'
        yield Conflict(path, rule, "name a CSV file of x and y", "")
    elif (counted or section.classes) and section.count != points:
        remedy = f"leave {name}.count out, or give {section.count} points"
        yield Conflict(path, f"must be as many as {name}, {section.count}", remedy, f"{points} points")


def _skills(scenario: Sections) -> Iterator[Conflict]:
    skills = {skill for each in scenario.robots.classes for skill in each.skills}
    skills |= {skill for each in scenario.tasks.classes for skill in each.needs}
    if len(skills) > SKILLS:
        rule = f"must be at most {SKILLS} skills of robots and tasks together"
        remedy = f"use {SKILLS} names of skills or fewer"
        yield Conflict("robots.classes", rule, remedy, f"{len(skills)} skills")


def _faults(scenario: Sections) -> Iterator[Conflict]:
    """Find more faulty robots than there are, or no honest robot that works."""
    robots, numbers = scenario.robots.count, dict(zip(KINDS, scenario.faulty, strict=True))
    total = sum(numbers.values())
    if not total or _fit(numbers, robots):
        return
    listed = ", ".join(f"{number} {kind}" for kind, number in numbers.items())
    rule = (
        f"must be at most {robots}, since a robot has one fault at most; there are {listed}"
        if total > robots
        else f"must leave an honest robot that works; of {robots} robots there are {listed}"
    )
    yield Conflict("faults", rule, _fitting(numbers, robots), f"{total} robots")


def _fit(numbers: Mapping[str, int], robots: int) -> bool:
    return sum(numbers.values()) <= robots and numbers["stopped"] + numbers["byzantine"] < robots


def _fitting(numbers: Mapping[str, int], robots: int) -> str:
    """Return the largest count of the most frequent fault, or of another, that fits the other faults."""
    room = robots - sum(numbers.values())
    for kind in sorted(numbers, key=numbers.__getitem__, reverse=True):
        for count in (numbers[kind] + room, numbers[kind] + room - 1):
            if 0 <= count <= numbers[kind] and _fit({**numbers, kind: count}, robots):
                return f"use faults.{kind} = {{count = {count}}}"
    return "lower two of them, such as to {count = 1}"


# --- The strategy ---


def _parameters(scenario: Sections) -> Iterator[Conflict]:
    known = scenario.manifest.parameters
    for name in sorted(set(scenario.decision.parameters) - set(known)):
        rule = f"{scenario.manifest.name} has no such parameter"
        yield Conflict(f"decision.parameters.{name}", rule, f"it has {', '.join(known) or 'none'}")


def _one_class(scenario: Sections, name: str) -> Iterator[Conflict]:
    classes = len(getattr(scenario, name).classes)
    if classes and scenario.manifest.one_class:
        rule = f"{scenario.manifest.name} compares one number of robots with one number of tasks"
        remedy = f"leave it out and set {name}.count, or choose census"
        yield Conflict(f"{name}.classes", rule, remedy, f"{classes} classes")


def _sees_falsely(kind: str) -> Rule:
    return never(
        f"sensing.false_{kind}",
        lambda s: getattr(s.sensing, f"false_{kind}") and s.manifest.by_name,
        "{strategy} counts things by name, and what isn't there has none",
        "leave it out, or choose tally",
    )


# --- A world that changes ---


def _most(scenario: Sections) -> Iterator[Conflict]:
    robots, most = scenario.robots, scenario.robots.most
    if most is None:
        return
    if most < robots.count:
        rule = f"must be at least the number of robots at the start, {robots.count}"
        yield Conflict("robots.most", rule, "leave it out, or lower robots.count")
        return
    if robots.arrival_rate and most == robots.count and not _robots_leave(scenario):
        rule = f"lets none join: {most} robots are there, and none leaves"
        remedy = f"set it to {most + 1} or more, or set robots.failure_rate"
        yield Conflict("robots.most", rule, remedy)


def _robots_leave(scenario: Sections) -> bool:
    return bool(scenario.robots.failure_rate) or any(each.more("robots") < 0 for each in scenario.events)


def _charging(scenario: Sections) -> Iterator[Conflict]:
    robots = scenario.robots
    if robots.work is not None and robots.charge is None:
        rule = "needs robots.charge: for how many steps a robot is away"
        yield Conflict("robots.work", rule, "set robots.charge = 600, or leave it out")
    if robots.work is None and robots.charge is not None:
        rule = "needs robots.work: after how many steps a robot charges"
        yield Conflict("robots.charge", rule, "set robots.work = 3000, or leave it out")
    if robots.work is None and robots.away != "counted":
        rule = "needs robots.work: without it, no robot goes to charge"
        yield Conflict("robots.away", rule, "set robots.work = 3000 and robots.charge = 600, or leave it out")


def _late(scenario: Sections) -> Iterator[Conflict]:
    steps = scenario.run.steps
    for number, event in enumerate(scenario.events):
        if event.step > steps:
            rule = f"is after the end of a run, run.steps = {steps}"
            remedy = f"set run.steps to {event.step} or more, or an earlier step"
            yield Conflict(f"events.{number}.step", rule, remedy)


def _idle(scenario: Sections) -> Iterator[Conflict]:
    for number, event in enumerate(scenario.events):
        if event.model_dump(exclude_defaults=True).keys() <= {"step", "at"}:
            remedy = "set tasks, robots, task, robot, sensing.miss or radio.loss, or leave it out"
            yield Conflict(f"events.{number}", "changes nothing", remedy, f"step = {event.step}")


def _named(scenario: Sections) -> Iterator[Conflict]:
    """Find an event that says where, or which one, and leaves open of what."""
    for number, event in enumerate(scenario.events):
        if (event.at, event.task, event.robot) == (None, None, None):
            continue
        path = f"events.{number}"
        said = [key for key in WHO if getattr(event, key) != Event.model_fields[key].default]
        if len(said) != 1 or (said[0] in BOTH and getattr(event, said[0]) < 0):
            rule = "says where or which one, so it must have one of tasks > 0, robots > 0, task and robot"
            yield Conflict(path, rule, "split it into events of the same step", f"step = {event.step}")
            continue
        key, name = said[0], f"{said[0].removesuffix('s')}s"
        most = getattr(scenario.most, name)
        if key != name and getattr(event, key) >= most:
            rule = f"must be below {most}: no more {name} than that ever come"
            yield Conflict(f"{path}.{key}", rule, "name another, or leave the event out")
        if event.at and (rule := _must_be(scenario, name, event.at)):
            yield Conflict(f"{path}.at", rule, "move the point, or enlarge arena.side")
        if event.at and key != name and scenario.acts:
            rule = f"puts a {key} elsewhere, but robots that act know where it is"
            yield Conflict(f"{path}.at", rule, "leave it out, or leave out acting.start")


def _numbers(scenario: Sections, name: str) -> Iterator[Conflict]:
    """Find an event that takes away more than there are, or brings too many, where streams leave no doubt."""
    if _is_uncertain(scenario, name):
        return
    there, least = getattr(scenario, name).count, int(name == "robots")
    most = scenario.robots.most if name == "robots" else None
    for number, event in sorted(enumerate(scenario.events), key=lambda numbered: numbered[1].step):
        before, change = there, event.more(name)
        there += change
        if there < least:
            rule = f"takes away more than there are at step {event.step}: {before} {name}"
            remedy = f"take away {before - least} at most" + (", so that a robot is left" if least else "")
            key = name if getattr(event, name) else name[:-1]
            yield Conflict(f"events.{number}.{key}", rule, remedy)
            return  # one error is enough
        if most is not None and change > 0 and there > most:
            rule = f"lets {there} robots be there at step {event.step}, above robots.most = {most}"
            yield Conflict(f"events.{number}.robots", rule, "lower it, or raise robots.most")
            most = None


def _is_uncertain(scenario: Sections, name: str) -> object:
    """Return whether robots or tasks come or go at random."""
    robots, tasks = scenario.robots, scenario.tasks
    if name == "tasks":
        return tasks.arrival_rate or tasks.lifetime
    return robots.arrival_rate or robots.failure_rate


def _appearing(scenario: Sections, name: str) -> Iterator[Conflict]:
    section = getattr(scenario, name)
    more = section.arrival_rate or any(getattr(each, name) > 0 for each in scenario.events)
    if more and section.placement == "points" and not section.points:
        rule = f"must have a point at which {name} may appear"
        yield Conflict(f"{name}.points", rule, f'add a point, or set {name}.placement = "uniform"', "")


def _tasks_limit(scenario: Sections) -> Iterator[Conflict]:
    tasks = scenario.most.tasks
    if scenario.dynamic and tasks > TASKS_LIMIT:
        rule = f"lets up to {tasks} tasks appear in a run, above {TASKS_LIMIT}"
        yield Conflict("tasks.arrival_rate", rule, "lower it, or run.steps")


# --- The arena ---


def _reach(scenario: Sections, name: str) -> Iterator[Conflict]:
    half, section = min(scenario.arena.size) / 2, getattr(scenario, name)
    reach, implied = section.range, name == "radio" and "range" not in section.model_fields_set
    if scenario.arena.boundary == "torus" and not implied and reach > half:
        rule = f"must be at most half the side of the torus, {half:g} units"
        remedy = f"set arena.side to {2 * reach:g} or more, or shorten the range"
        yield Conflict(f"{name}.range", rule, remedy)


def _speed(scenario: Sections) -> Iterator[Conflict]:
    half, speed = min(scenario.arena.size) / 2, scenario.robots.speed
    if speed > half:
        rule = f"must be at most half the side of the arena per step, {half:g} units"
        yield Conflict("robots.speed", rule, f"lower it, or set arena.side to {2 * speed:g} or more")


def _discs(scenario: Sections) -> Iterator[Conflict]:
    robots, arena, shorter = scenario.robots, scenario.arena, min(scenario.arena.size)
    if arena.boundary == "walls" and robots.diameter >= shorter:
        rule = f"must be less than the arena's shorter side, {shorter:g} units"
        yield Conflict("robots.diameter", rule, "lower it, or enlarge arena.side")
        return
    if not robots.avoid_collisions:
        return
    reach = robots.diameter + 2 * robots.speed
    if arena.boundary == "torus" and reach > shorter / 2:
        rule = f"diameter + 2 speed must be at most half the side of the torus, {shorter / 2:g} units"
        yield Conflict("robots.diameter", rule, f"set arena.side to {2 * reach:g} or more")
    unit = exact(max(arena.size)) / 2 ** (31 if arena.boundary == "walls" else 32)
    step = 2 * math.ceil(exact(robots.diameter) / unit / 2)  # of the lattice of last resort, in fixed point
    columns, rows = (math.floor(exact(side) / unit) // step for side in arena.size)
    if robots.placement != "points" and robots.count > columns * rows:
        rule = f"must be at most {columns * rows}, the number of discs that fit on a square grid"
        remedy = "use fewer or smaller robots, or enlarge arena.side"
        yield Conflict("robots.count", rule, remedy)


def _spread(scenario: Sections, name: str) -> Iterator[Conflict]:
    placed, longer = getattr(scenario, name), max(scenario.arena.size)
    if placed.placement == "clusters" and placed.spread > longer:
        rule = f"must be at most the arena's longer side, {longer:g} units"
        yield Conflict(f"{name}.spread", rule, f'lower it, or set {name}.placement = "uniform"')


def _must_be(scenario: Sections, name: str, point: Point) -> str:
    """Return where a point for robots or tasks must be, if it isn't there."""
    (x, y), (width, height), walled = point, scenario.arena.size, scenario.arena.boundary == "walls"
    margin = scenario.robots.diameter / 2 if walled and name == "robots" else 0.0
    inside = margin <= x <= width - margin and margin <= y <= height - margin
    if inside and (walled or (x != width and y != height)):
        return ""
    return "must be inside the arena" + (f", {margin:g} units from its walls" if margin else "")


def _points(scenario: Sections, name: str, given: Mapping[str, Any]) -> Iterator[Conflict]:
    placed, arena, diameter = getattr(scenario, name), scenario.arena, scenario.robots.diameter
    if placed.placement != "points" or not placed.points:
        return
    (width, height), walled = arena.size, arena.boundary == "walls"
    points: Any = _value(f"{name}.points", given, scenario)
    for number, (x, y) in enumerate(points, start=1):
        if place := _must_be(scenario, name, (x, y)):
            in_file = isinstance(points, FilePoints)
            where = f"{points.path}, line {points.lines[number - 1]}" if in_file else f"point {number}"
            rule, remedy = f"{where}: {place}", "move the point, or enlarge arena.side"
            yield Conflict(f"{name}.points", rule, remedy, (x, y))
    if name == "robots" and scenario.robots.avoid_collisions:
        for first, second in _overlaps(points, diameter, None if walled else (width, height)):
            rule = f"robots {first + 1} and {second + 1} must be more than {diameter:g} units apart"
            yield Conflict("robots.points", rule, "move one of them", (points[first], points[second]))


def _overlaps(points: Any, diameter: float, torus: tuple[float, float] | None) -> Iterator[tuple[int, int]]:
    """Yield pairs of discs that overlap or touch; cells of a disc's size keep this from being quadratic."""
    cells: dict[tuple[int, int], list[int]] = {}
    shifts = [(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    cell = max(diameter, max(map(max, points), default=0.0) / 2**20)
    wide, high = (max(1, math.floor(side / cell)) for side in torus) if torus else (0, 0)
    for i, (x, y) in enumerate(points):
        column, row = math.floor(x / cell), math.floor(y / cell)
        if torus:
            column, row = min(column, wide - 1), min(row, high - 1)
        around = {(column + dx, row + dy) for dx, dy in shifts}
        if torus:
            around = {(c % wide, r % high) for c, r in around}
        for j in (j for cell in around for j in cells.get(cell, ())):
            dx, dy = abs(x - points[j][0]), abs(y - points[j][1])
            if torus:
                dx, dy = min(dx, torus[0] - dx), min(dy, torus[1] - dy)
            if math.hypot(dx, dy) < diameter * (1 + 1e-6):
                yield j, i
        cells.setdefault((column, row), []).append(i)


# --- Memory ---


def _unique_memory(scenario: Sections) -> Iterator[Conflict]:
    robots, tasks = scenario.robots.count, scenario.tasks.count
    needed = robots * (robots + tasks) / 8
    if scenario.sensing.observation == "unique" and needed > UNIQUE_LIMIT:
        size, limit = f"{needed / 2**30:.1f} GiB", f"{UNIQUE_LIMIT // 2**30} GiB"
        rule = f"needs {size} for {robots} robots and {tasks} tasks, above the limit of {limit}"
        yield Conflict("sensing.observation", rule, 'use fewer robots or tasks, or observation = "repeated"')


def _delay_memory(scenario: Sections) -> Iterator[Conflict]:
    """Find messages under way that don't fit; `_knowledge_memory` counts what they say beyond an opinion."""
    needed = 24 * scenario.radio.delay * scenario.most.robots
    if needed > UNIQUE_LIMIT:
        rule = f"keeps {needed / 2**30:.1f} GiB of messages, above the limit of {UNIQUE_LIMIT // 2**30} GiB"
        yield Conflict("radio.delay", rule, "lower it, or use fewer robots")


def _knowledge_memory(scenario: Sections) -> Iterator[Conflict]:
    """Find built-in strategies whose robots together know more than fits; a user's file isn't run here."""
    strategy = scenario.manifest
    if not isinstance(strategy, Strategy) or not strategy.knowledge or strategy.source:
        return
    if strategy.reads_plan and broken((*SITED, STANDING), scenario):
        return  # the setting has what robots know of the plan, which follows from passable cells
    setting = scenario.setting
    problem = excess(setting, *strategy.row_lengths(setting))
    if problem:
        yield Conflict("decision.strategy", problem, "choose dc or turns, or fewer robots")


SITED: Final[tuple[Rule, ...]] = (*PLACES, *both(_counts), _speed)
"""The rules that a scenario must keep before its passable cells can be computed."""
STANDING: Final = after(SITED, standing)
_FOR_GOOD: Final = "is for good, but the world of this scenario changes"
RULES: Final[tuple[Rule, ...]] = (
    *both(_counts),
    _skills,
    _faults,
    never(
        "decision.inbox_size",
        lambda s: s.decision.inbox == "every-message" and s.decision.inbox_size is not None,
        'limits the number of robots, but inbox = "every-message" keeps no robots apart',
        'leave it out, or set inbox = "latest-per-robot"',
    ),
    _parameters,
    never(
        "decision.inbox",
        lambda s: s.manifest.value_bits and s.decision.inbox == "every-message",
        "{strategy} broadcasts a value, and the inbox keeps only the latest of each robot",
        'set inbox = "latest-per-robot"',
    ),
    never(
        "decision.quality_floor",
        lambda s: s.manifest.knowledge and s.decision.quality_floor,
        "{strategy} rates what the swarm knows, not the counts of one exploration",
        "leave it out",
    ),
    never(
        "decision.start",
        lambda s: (s.manifest.knowledge or s.manifest.starts_neutral) and s.decision.start != "coin",
        "needs robots that begin with a coin and pass on opinions; those of {strategy} don't",
        'set start = "coin", or choose dmmd',
    ),
    *map(_sees_falsely, BOTH),
    never(
        "sensing.misname",
        lambda s: s.sensing.misname and not s.manifest.needs_names,
        "needs a strategy that counts tasks by name; {strategy} doesn't",
        "leave it out, or choose quiet-census",
    ),
    never(
        "sensing.position_error",
        lambda s: s.sensing.position_error and s.manifest.needs_names and not s.manifest.sends_positions,
        "must be 0 for {strategy}, whose robots can't compare tasks' positions with a gate",
        "set it to 0, or choose quiet-census",
    ),
    never(
        "sensing.position_error",
        lambda s: s.sensing.position_error and s.dynamic,
        "must be 0 in a world that changes",
        "set it to 0, or leave out what changes the world",
    ),
    never(
        "sensing.position_error",
        lambda s: s.sensing.merged > s.sensing.range,
        "makes tasks one name that are farther apart than sensing.range",
        "use a smaller error, or a smaller sensing.gate",
    ),
    never(
        "sensing.view",
        lambda s: s.sensing.view < 360 and s.manifest.all_round,
        "must be 360 for {strategy}, which concludes from what it doesn't see in range",
        "leave it out, or choose census",
    ),
    never(
        "sensing.view",
        lambda s: s.sensing.view < 360 and s.robots.speed == 0,
        "must be 360 for robots that never move, and so have no heading",
        "leave it out, or raise robots.speed",
    ),
    never(
        "sensing.observation",
        lambda s: s.manifest.judges and s.sensing.observation == "unique",
        "{strategy} must see again what is still there, to notice what isn't",
        'set observation = "repeated"',
    ),
    never(
        "robots.know_count",
        lambda s: s.manifest.needs_count and not s.robots.know_count,
        "{strategy} needs the number of robots",
        "set it to true, or choose a strategy without n",
    ),
    *both(_one_class),
    never(
        "place.walls",
        lambda s: s.place.hides and not s.manifest.reads_plan and s.manifest.all_round,
        "{strategy} concludes from what it doesn't see in range, but walls hide things",
        "choose quiet-census or turns, or give the obstacles as place.keepout",
        "walls",
    ),
    never(
        "decision.declare",
        lambda s: s.manifest.declares and s.decision.declare is not None,
        "{strategy} declares by its own word, and its messages have no opinion to agree with",
        "leave it out",
    ),
    never(
        "faults.byzantine",
        lambda s: {"encode", "lie"} & s.manifest.functions == {"encode"} and s.faulty[1] > 0,
        "{strategy} has encode, but no function for a Byzantine robot's message",
        "write def lie(message, feasible, me) in its file",
    ),
    _most,
    _charging,
    _late,
    _idle,
    _named,
    *both(_numbers, _appearing),
    never(
        "decision.declare",
        lambda s: s.dynamic and s.decision.declare is not None,
        _FOR_GOOD,
        "leave it out, or leave out events, rates and robots that go missing",
        "a rule",
    ),
    never(
        "decision.strategy",
        lambda s: s.dynamic and s.manifest.declares,
        f"declares, which {_FOR_GOOD}",
        "choose roster, or leave out events, rates and robots that go missing",
    ),
    never(
        "run.stop_at_decision",
        lambda s: s.dynamic and s.run.stop_at_decision,
        "ends a run at its first decision, but the world of this scenario changes",
        "leave it out, or leave out events, rates and robots that go missing",
    ),
    never(
        "run.stop_at_declarations",
        lambda s: s.dynamic and s.run.stop_at_declarations,
        "ends a run once all robots have declared, but the world of this scenario changes",
        "leave it out, or leave out events, rates and robots that go missing",
    ),
    _tasks_limit,
    partial(_reach, name="sensing"),
    partial(_reach, name="radio"),
    _speed,
    _discs,
    never(
        "robots.contact",
        lambda s: s.robots.contact != "stand" and not s.robots.avoid_collisions,
        "needs robots.avoid_collisions = true: without it, robots pass through each other",
        'set robots.avoid_collisions to true, or leave contact at "stand"',
    ),
    *both(_spread),
    *PLACES,
    *ACTING,
    STANDING,
    _unique_memory,
    _delay_memory,
    _knowledge_memory,
)
"""All rules between fields but that about points, which shows them as they were given."""
