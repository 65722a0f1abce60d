"""The rules between fields of a scenario: each conflict becomes a problem with a remedy.

A rule reads the typed sections. If a field that it reads is wrong itself, the rule has nothing to say.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, Final

from feasibee.base.codes import exact
from feasibee.base.errors import Problem
from feasibee.scenario.fields import Acting, Event, Point
from feasibee.scenario.paths import value_at
from feasibee.scenario.placing import PLACES, standing
from feasibee.scenario.rules import AS_GIVEN, BOTH, Breaks, Conflict, Rule, after, both, broken, rows
from feasibee.scenario.sections import KINDS, Sections
from feasibee.scenario.setting import excess
from feasibee.scenario.tables import FilePoints
from feasibee.strategies.contract import Strategy

WHO: Final = (*BOTH, "task", "robot")
"""What an event brings, or names."""
TASKS_LIMIT = 10_000_000
"""Tasks that may appear in one run."""
SKILLS = 8
MEMORY = 4 * 2**30
"""Largest memory of unique observations, of messages, or of news of tasks, of all robots, in bytes."""


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
        if section.classes:
            remedy = f"give {section.count} points, or classes with {points} {name} together"
        yield Conflict(path, f"must be as many as {name}, {section.count}", remedy, f"{points} points")


def _skills(scenario: Sections) -> int:
    """Return the number of different skills of robots and tasks."""
    robots, tasks = scenario.robots.classes, scenario.tasks.classes
    return len(
        {*(skill for each in robots for skill in each.skills), *(s for each in tasks for s in each.needs)}
    )


OF_SKILLS: Final[Mapping[str, Breaks]] = {
    "robots.classes = {0} skills: must be at most {1} skills of robots and tasks together"
    "; use {1} names of skills or fewer": lambda s: _skills(s) > SKILLS and (_skills(s), SKILLS),
}


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
    strategy, given = scenario.manifest, scenario.decision.parameters
    known = strategy.parameters
    for name in sorted(set(given) - set(known)):
        rule = f"{strategy.name} has no such parameter"
        yield Conflict(f"decision.parameters.{name}", rule, f"it has {', '.join(known) or 'none'}")
    for name in strategy.positive:
        if given[name] <= 0:
            yield Conflict(f"decision.parameters.{name}", "must be > 0", f"leave it out for {known[name]:g}")


def _classes(scenario: Sections, name: str) -> tuple[int] | None:
    """Return the number of classes, if there are some and the strategy compares one number of each kind."""
    classes = len(getattr(scenario, name).classes)
    return (classes,) if classes and scenario.manifest.one_class else None


UNSEEN: Final = (
    "{strategy} counts things by name, and what isn't there has none; leave it out, or choose tally"
)
OF_INBOX: Final[Mapping[str, Breaks]] = {
    'decision.inbox_size: limits the number of robots, but inbox = "every-message" keeps no robots apart'
    '; leave it out, or set inbox = "latest-per-robot"': lambda s: (
        s.decision.inbox == "every-message" and s.decision.inbox_size is not None
    ),
}
OF_STRATEGY: Final[Mapping[str, Breaks]] = {
    "decision.inbox: {strategy} broadcasts a value, and the inbox keeps only the latest of each robot"
    '; set inbox = "latest-per-robot"': lambda s: (
        s.manifest.value_bits and s.decision.inbox == "every-message"
    ),
    "decision.quality_floor: {strategy} rates what the swarm knows, not the counts of one exploration"
    "; leave it out": lambda s: s.manifest.knowledge and s.decision.quality_floor,
    "decision.start: needs robots that begin with a coin and pass on opinions; those of {strategy} don't"
    '; set start = "coin", or choose dmmd': lambda s: (
        (s.manifest.knowledge or s.manifest.starts_neutral) and s.decision.start != "coin"
    ),
    f"sensing.false_robots: {UNSEEN}": lambda s: s.sensing.false_robots and s.manifest.by_name,
    f"sensing.false_tasks: {UNSEEN}": lambda s: s.sensing.false_tasks and s.manifest.by_name,
    "sensing.misname: needs a strategy that counts tasks by name; {strategy} doesn't"
    "; leave it out, or choose quiet-census": lambda s: s.sensing.misname and not s.manifest.needs_names,
    "sensing.position_error: must be 0 for {strategy}, whose robots can't compare tasks' positions with a "
    "gate; set it to 0, or choose quiet-census": lambda s: (
        s.sensing.position_error and s.manifest.needs_names and not s.manifest.sends_positions
    ),
    "sensing.position_error: must be 0 in a world that changes"
    "; set it to 0, or leave out what changes the world": lambda s: s.sensing.position_error and s.dynamic,
    "sensing.position_error: makes tasks one name that are farther apart than sensing.range"
    "; use a smaller error, or a smaller sensing.gate": lambda s: s.sensing.merged > s.sensing.range,
    "sensing.view: must be 360 for {strategy}, which concludes from what it doesn't see in range"
    "; leave it out, or choose census": lambda s: s.sensing.view < 360 and s.manifest.all_round,
    "sensing.view: must be 360 for robots that never move, and so have no heading"
    "; leave it out, or raise robots.speed": lambda s: s.sensing.view < 360 and s.robots.speed == 0,
    "sensing.observation: {strategy} must see again what is still there, to notice what isn't"
    '; set observation = "repeated"': lambda s: s.manifest.judges and s.sensing.observation == "unique",
    "robots.know_count: {strategy} needs the number of robots"
    "; set it to true, or choose a strategy that doesn't need it": lambda s: (
        s.manifest.needs_count and not s.robots.know_count
    ),
    **{
        f"{name}.classes = {{0}} classes: {{strategy}} compares one number of robots with one number of tasks"
        f"; leave it out and set {name}.count, or choose census": partial(_classes, name=name)
        for name in BOTH
    },
    "place.walls = walls: {strategy} concludes from what it doesn't see in range, but walls hide things"
    "; choose quiet-census or turns, or give the obstacles as place.keepout": lambda s: (
        s.place.hides and not s.manifest.reads_plan and s.manifest.all_round
    ),
    "decision.declare: {strategy} declares by its own word, and its messages have no opinion to agree with"
    "; leave it out": lambda s: s.manifest.declares and s.decision.declare is not None,
    "faults.byzantine: {strategy} has encode, but no function for a Byzantine robot's message"
    "; write def lie(message, feasible, me) in its file": lambda s: (
        {"encode", "lie"} & s.manifest.functions == {"encode"} and s.faulty[1] > 0
    ),
}


# --- A world that changes ---


def _robots_leave(scenario: Sections) -> bool:
    return bool(scenario.robots.failure_rate) or any(each.more("robots") < 0 for each in scenario.events)


OF_ROBOTS: Final[Mapping[str, Breaks]] = {
    "robots.most: must be at least the number of robots at the start, {0}"
    "; leave it out, or lower robots.count": lambda s: (
        s.robots.most is not None and s.robots.most < s.robots.count and (s.robots.count,)
    ),
    "robots.most: lets none join: {0} robots are there, and none leaves"
    "; set it to {1} or more, or set robots.failure_rate": lambda s: (
        s.robots.arrival_rate
        and s.robots.most == s.robots.count
        and not _robots_leave(s)
        and (s.robots.count, s.robots.count + 1)
    ),
    "robots.work: needs robots.charge: for how many steps a robot is away"
    "; set robots.charge = 600, or leave it out": lambda s: (
        s.robots.work is not None and s.robots.charge is None
    ),
    "robots.charge: needs robots.work: after how many steps a robot charges"
    "; set robots.work = 3000, or leave it out": lambda s: (
        s.robots.work is None and s.robots.charge is not None
    ),
    "robots.away: needs robots.work: without it, no robot goes to charge"
    "; set robots.work = 3000 and robots.charge = 600, or leave it out": lambda s: (
        s.robots.work is None and s.robots.away != "counted"
    ),
}


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
            another = f"name one from 0 to {most - 1}, or " if most else ""
            yield Conflict(f"{path}.{key}", rule, f"{another}leave the event out")
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
            key = name if getattr(event, name) else name[:-1]
            remedy = f"take away {before - least} at most" if key == name else "leave the event out"
            left = ", so that a robot is left" if least else ""
            yield Conflict(f"events.{number}.{key}", rule, f"{remedy}{left}")
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


STAYS: Final = "leave it out, or leave out events, rates and robots that go missing"
"""The remedy for what needs a world that stays."""
OF_CHANGES: Final[Mapping[str, Breaks]] = {
    f"decision.declare = a rule: is for good, but the world of this scenario changes; {STAYS}": lambda s: (
        s.dynamic and s.decision.declare is not None
    ),
    "decision.strategy: declares, which is for good, but the world of this scenario changes"
    "; choose roster, or leave out events, rates and robots that go missing": lambda s: (
        s.dynamic and s.manifest.declares
    ),
    "run.stop_at_decision: ends a run at its first decision, but the world of this scenario changes"
    f"; {STAYS}": lambda s: s.dynamic and s.run.stop_at_decision,
    "run.stop_at_declarations: ends a run once all robots have declared, but the world of this scenario "
    f"changes; {STAYS}": lambda s: s.dynamic and s.run.stop_at_declarations,
    "tasks.arrival_rate: lets up to {0} tasks appear in a run, above {1}; lower it, or run.steps": lambda s: (
        s.dynamic and s.most.tasks > TASKS_LIMIT and (s.most.tasks, TASKS_LIMIT)
    ),
}


# --- The arena ---


def _range(scenario: Sections, name: str) -> Iterator[Conflict]:
    half, section = min(scenario.arena.size) / 2, getattr(scenario, name)
    reach, implied = section.range, name == "radio" and "range" not in section.model_fields_set
    if scenario.arena.boundary == "torus" and not implied and reach > half:
        rule = f"must be at most half the side of the torus, {half:g} units"
        remedy = f"set arena.side to {2 * reach:g} or more, or shorten the range"
        yield Conflict(f"{name}.range", rule, remedy)


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
    fit = math.prod(math.floor(exact(side) / unit) // step for side in arena.size)
    if robots.placement != "points" and robots.count > fit:
        rule = f"must be at most {fit}, the number of discs that fit on a square grid"
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


def _half(scenario: Sections) -> float:
    """Return half the arena's shorter side."""
    return min(scenario.arena.size) / 2


OF_SPEED: Final[Mapping[str, Breaks]] = {
    "robots.speed: must be at most half the side of the arena per step, {0:g} units"
    "; lower it, or set arena.side to {1:g} or more": lambda s: (
        s.robots.speed > _half(s) and (_half(s), 2 * s.robots.speed)
    ),
}
OF_BODIES: Final[Mapping[str, Breaks]] = {
    "robots.contact: needs robots.avoid_collisions = true: without it, robots pass through each other"
    '; set robots.avoid_collisions to true, or leave contact at "stand"': lambda s: (
        s.robots.contact != "stand" and not s.robots.avoid_collisions
    ),
}


# --- Robots that act ---


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


def _news_memory(scenario: Sections) -> Iterator[Conflict]:
    robots, tasks = scenario.most
    needed = 4 * robots * tasks * (2 + scenario.radio.delay)
    if scenario.acts and scenario.plan:
        needed += 4 * (tasks + 2) * scenario.plan.walls.size
    if scenario.acts and needed > MEMORY:
        rule = f"needs {needed / 2**30:.1f} GiB for what robots know, above {MEMORY // 2**30} GiB"
        remedy = "use fewer robots or tasks, or larger cells, or leave it out"
        yield Conflict("acting.start", rule, remedy, "acting robots")


def _unacting(key: str) -> Breaks:
    default = Acting.model_fields[key].default
    return lambda s: not s.acts and getattr(s.acting, key) != default


ALONE: Final = 'needs acting.start: without it, no robot acts; set acting.start = "safe", or leave it out'
BY_SIGHT: Final = (
    "must be 0 for robots that act: they go where they saw a task; set it to 0, or leave out acting.start"
)
OF_ACTING: Final[Mapping[str, Breaks]] = {
    'acting.start: "declared" needs robots that declare'
    '; set it to a step or "safe", set decision.declare, or choose quiet-census': lambda s: (
        s.acting.start == "declared" and not (s.manifest.declares or s.decision.declare)
    ),
    "tasks.work: needs acting.start: without it, no robot works at a task"
    '; leave it out, or set acting.start = "safe"': lambda s: s.tasks.work is not None and not s.acts,
    'acting.choose: "rank" needs the numbers of robots, but radio.id_bits makes ids random'
    '; set it to "nearest", or leave out radio.id_bits': lambda s: (
        s.acting.choose == "rank" and s.radio.id_bits is not None
    ),
    'acting.choose: "rank" gives each robot its task, so none is marked'
    '; set it to "nearest", or set acting.hold = "stand"': lambda s: (
        s.acting.choose == "rank" and s.acting.hold == "tag"
    ),
    f"sensing.misname: {BY_SIGHT}": lambda s: s.acts and s.sensing.misname,
    f"sensing.position_error: {BY_SIGHT}": lambda s: s.acts and s.sensing.position_error,
    "robots.work: can't be combined with acting.start: nobody would stand at the task of a robot that charges"
    "; leave it out, or leave out acting.start": lambda s: s.acts and s.robots.work is not None,
    "tasks.classes: must need one robot for each task if robots act"
    "; split the tasks into tasks for one robot, or leave out acting.start": lambda s: (
        s.acts and any(sum(each.needs.values()) != 1 for each in s.tasks.classes)
    ),
    "run.stop_when_taken: needs acting.start: without it, no task is taken"
    '; set it to false, or set acting.start = "safe"': lambda s: s.run.stop_when_taken and not s.acts,
    "run.stop_when_taken: ends a run once all tasks are taken, but more appear"
    "; leave it out, or leave out tasks.arrival_rate and events with tasks": lambda s: (
        s.run.stop_when_taken and s.most.tasks > s.tasks.count
    ),
}
ACTING: Final[tuple[Rule, ...]] = (
    *rows({f"acting.{key}: {ALONE}": _unacting(key) for key in ("choose", "hold", "reach")}),
    _reach,
    *rows(OF_ACTING),
    after(PLACES, _news_memory),
)
"""The rules about the section ``acting``."""


# --- Memory ---


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


def _seen_once(scenario: Sections) -> tuple[float, int, int] | None:
    """Return the GiB that unique observations need, of how many robots and tasks, if they are too many."""
    robots, tasks = scenario.robots.count, scenario.tasks.count
    needed = robots * (robots + tasks) / 8 if scenario.sensing.observation == "unique" else 0
    return (needed / 2**30, robots, tasks) if needed > MEMORY else None


OF_MEMORY: Final[Mapping[str, Breaks]] = {
    "sensing.observation: needs {0:.1f} GiB for {1} robots and {2} tasks, above the limit of 4 GiB"
    '; use fewer robots or tasks, or observation = "repeated"': _seen_once,
    # of messages under way; `_knowledge_memory` counts what they say beyond an opinion
    "radio.delay: keeps {0:.1f} GiB of messages, above the limit of 4 GiB"
    "; lower it, or use fewer robots": lambda s: (
        24 * s.radio.delay * s.most.robots > MEMORY and (24 * s.radio.delay * s.most.robots / 2**30,)
    ),
}
SITED: Final[tuple[Rule, ...]] = (*PLACES, *both(_counts), *rows(OF_SPEED))
"""The rules that a scenario must keep before its passable cells can be computed."""
STANDING: Final = after(SITED, standing)
RULES: Final[tuple[Rule, ...]] = (
    *both(_counts),
    *rows(OF_SKILLS),
    _faults,
    *rows(OF_INBOX),
    _parameters,
    *rows(OF_STRATEGY),
    *rows(OF_ROBOTS),
    _late,
    _idle,
    _named,
    *both(_numbers, _appearing),
    *rows(OF_CHANGES),
    partial(_range, name="sensing"),
    partial(_range, name="radio"),
    *rows(OF_SPEED),
    _discs,
    *rows(OF_BODIES),
    *both(_spread),
    *PLACES,
    *ACTING,
    STANDING,
    *rows(OF_MEMORY),
    _knowledge_memory,
)
"""All rules between fields but that about points, which shows them as they were given."""
