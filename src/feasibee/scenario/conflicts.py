"""Validate rules that involve several fields of a scenario: each conflict becomes a problem with a remedy."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, Final, NamedTuple

from feasibee.errors import Problem
from feasibee.model.codes import exact
from feasibee.scenario.setting import excess, setting_from
from feasibee.strategies.contract import Manifest, Strategy

Explicit = Mapping[str, Any]
KINDS: Final = ("stopped", "byzantine", "stubborn")
"""The faults of which a robot has one at most, in the order in which faulty robots are drawn."""


def whole_robots(faulty: float | Mapping[str, int], robots: int) -> int:
    """Return a count, or a share of the swarm as a number of robots, with halves rounded up (model.md 6.6).

    Examples
    --------
    >>> from feasibee.scenario.conflicts import whole_robots
    >>> whole_robots(0.1, 5), whole_robots({"count": 1}, 5)
    (1, 1)
    """
    if isinstance(faulty, Mapping):
        return faulty["count"]
    return math.floor(exact(faulty) * robots + Fraction(1, 2))


def fault_conflicts(faults: Mapping[str, Any], robots: int) -> Iterator[Problem]:
    """Yield a problem if more robots are faulty than there are, or no honest robot works."""
    if not any(faults[kind] for kind in KINDS):
        return  # the usual case: exact fractions take half the time of all rules
    numbers = {kind: whole_robots(faults[kind], robots) for kind in KINDS}
    if _fit(numbers, robots):
        return
    total = sum(numbers.values())
    listed = ", ".join(f"{number} {kind}" for kind, number in numbers.items())
    rule = (
        f"must be at most {robots}, since a robot has one fault at most; there are {listed}"
        if total > robots
        else f"must leave an honest robot that works; of {robots} robots there are {listed}"
    )
    yield Problem("faults", f"{total} robots", rule, _remedy(numbers, robots))


def _fit(numbers: Mapping[str, int], robots: int) -> bool:
    return sum(numbers.values()) <= robots and numbers["stopped"] + numbers["byzantine"] < robots


def _remedy(numbers: Mapping[str, int], robots: int) -> str:
    """Return the largest count of the most frequent fault, or of another, that fits the other faults."""
    room = robots - sum(numbers.values())
    for kind in sorted(numbers, key=numbers.__getitem__, reverse=True):
        for count in (numbers[kind] + room, numbers[kind] + room - 1):
            if 0 <= count <= numbers[kind] and _fit({**numbers, kind: count}, robots):
                return f"use faults.{kind} = {{count = {count}}}"
    return "lower two of them, such as to {count = 1}"


TASKS_LIMIT = 10_000_000
"""Tasks that may appear in one run."""
TWICE = 2
"""Largest number of robots, in units of those at the start, if robots join by rate or call."""


class Most(NamedTuple):
    """How many robots and tasks of a scenario have numbers."""

    robots: int
    """Robots that may be there at a time (model.md 6.17.6)."""
    tasks: int
    """Tasks that may appear in a run (model.md 6.17.4)."""


def is_dynamic(sections: Explicit) -> bool:
    """Return whether the world of a scenario may change; ``sections`` are its raw values."""
    robots, tasks = sections["robots"], sections["tasks"]
    streams = robots["arrival_rate"], robots["failure_rate"], tasks["arrival_rate"], tasks["lifetime"]
    return bool(sections["events"]) or any(streams) or responds(sections)


def responds(sections: Explicit) -> bool:
    """Return whether robots are called or released because of what the swarm holds (model.md 6.19)."""
    return sections["response"]["patience"] is not None


def most_of(sections: Explicit, counts: tuple[int, int]) -> Most:
    """Return how many robots and tasks have numbers, from those at the start (``counts``)."""
    robots, tasks = counts
    if not is_dynamic(sections):
        return Most(robots, tasks)
    events = sections["events"]
    joining = sum(max(0, each["robots"]) for each in events)
    appearing = sum(max(0, each["tasks"]) for each in events)
    most = sections["robots"]["most"]
    if most is None:
        most = robots + joining
        if sections["robots"]["arrival_rate"] or responds(sections):
            most = max(most, TWICE * robots)
    rate, steps = sections["tasks"]["arrival_rate"] or 0.0, sections["run"]["steps"]
    return Most(max(most, robots), tasks + appearing + surely_above(rate * steps))


def surely_above(mean: float) -> int:
    """Return a number that a Poisson number of this mean exceeds with a probability below 1e-12."""
    return math.ceil(mean + 8 * math.sqrt(mean) + 16) if mean > 0 else 0


def dynamic_conflicts(
    sections: Explicit, counts: tuple[int, int], fit: Callable[..., bool], strategy: Manifest | None
) -> Iterator[Problem]:
    """Yield a problem for each rule about worlds that change that a scenario breaks.

    Parameters
    ----------
    sections : mapping
        The raw values with defaults filled in.
    counts : tuple of int
        Numbers of robots and tasks at the start.
    fit : callable
        Returns whether the fields at some paths have valid values.
    strategy : Manifest, optional
        What the strategy declares; None if its name is invalid.
    """
    rates = "robots.arrival_rate", "robots.failure_rate", "tasks.arrival_rate", "tasks.lifetime"
    response = "response.patience", "response.delay", "response.margin"
    if not fit("events", "robots.most", "run.steps", *rates, *response):
        return
    yield from _most(sections, counts, strategy)
    yield from _response(sections, strategy)
    if not is_dynamic(sections):
        return
    yield from _events(sections)
    yield from _numbers(sections, counts)
    yield from _placement(sections)
    yield from _for_good(sections, fit, strategy)
    tasks = most_of(sections, counts).tasks
    if tasks > TASKS_LIMIT:
        rule = f"lets up to {tasks} tasks appear in a run, above {TASKS_LIMIT}"
        yield Problem("tasks.arrival_rate", sections["tasks"]["arrival_rate"], rule, "lower it, or run.steps")


def _most(sections: Explicit, counts: tuple[int, int], strategy: Manifest | None) -> Iterator[Problem]:
    robots, most = sections["robots"], sections["robots"]["most"]
    if most is None:
        return
    if most < counts[0]:
        rule = f"must be at least the number of robots at the start, {counts[0]}"
        yield Problem("robots.most", most, rule, "leave it out, or lower robots.count")
        return
    may_join = robots["arrival_rate"] or responds(sections)
    if may_join and most == counts[0] and not _robots_leave(sections, strategy):
        rule = f"lets none join: {most} robots are there, and none leaves"
        remedy = f"set it to {most + 1} or more, or set robots.failure_rate"
        yield Problem("robots.most", most, rule, remedy)


def _response(sections: Explicit, strategy: Manifest | None) -> Iterator[Problem]:
    """Find values of a response that can't have an effect (model.md 6.19)."""
    response, defaults = sections["response"], {"delay": 100, "margin": 2}
    if not responds(sections):
        for name, default in defaults.items():
            if response[name] != default:
                rule = "needs response.patience: without it, nobody responds"
                yield Problem(f"response.{name}", response[name], rule, "set response.patience = 100")
        return
    steps = sections["run"]["steps"]
    if response["patience"] > steps:
        rule = f"is longer than a run, run.steps = {steps}: nobody would be called"
        remedy = f"lower it to {steps} or less, or raise run.steps"
        yield Problem("response.patience", response["patience"], rule, remedy)


def _robots_leave(sections: Explicit, strategy: Manifest | None) -> bool:
    released = responds(sections) and (strategy is None or strategy.knows_gap)
    by_event = any(each["robots"] < 0 for each in sections["events"])
    return bool(sections["robots"]["failure_rate"]) or by_event or released


def _events(sections: Explicit) -> Iterator[Problem]:
    """Find events after the end of a run, and events that change nothing."""
    steps = sections["run"]["steps"]
    for number, event in enumerate(sections["events"]):
        if event["step"] > steps:
            rule = f"is after the end of a run, run.steps = {steps}"
            remedy = f"set run.steps to {event['step']} or more, or an earlier step"
            yield Problem(f"events.{number}.step", event["step"], rule, remedy)
        values = event["tasks"], event["robots"], event["sensing"]["miss"], event["radio"]["loss"]
        if values == (0, 0, None, None):
            remedy = "set tasks, robots, sensing.miss or radio.loss, or leave it out"
            yield Problem(f"events.{number}", f"step = {event['step']}", "changes nothing", remedy)


def _numbers(sections: Explicit, counts: tuple[int, int]) -> Iterator[Problem]:
    """Find events in which more vanish or leave than there are, where streams leave no doubt."""
    robots, tasks = sections["robots"], sections["tasks"]
    known = {
        "robots": not (robots["arrival_rate"] or robots["failure_rate"] or responds(sections)),
        "tasks": not (tasks["arrival_rate"] or tasks["lifetime"]),
    }
    there = dict(zip(("robots", "tasks"), counts, strict=True))
    least = {"robots": 1, "tasks": 0}
    for number, event in in_order(sections["events"]):
        for kind, certain in known.items():
            before = there[kind]
            there[kind] += event[kind]
            if certain and there[kind] < least[kind]:
                most = before - least[kind]
                rule = f"takes away more than there are at step {event['step']}: {before} {kind}"
                remedy = f"take away {most} at most" + (
                    ", so that a robot is left" if kind == "robots" else ""
                )
                yield Problem(f"events.{number}.{kind}", event[kind], rule, remedy)
                known = {**known, kind: False}  # one error is enough
    if sections["robots"]["most"] is not None and known["robots"]:
        yield from _joining(sections, counts[0])


def _joining(sections: Explicit, robots: int) -> Iterator[Problem]:
    most = sections["robots"]["most"]
    for number, event in in_order(sections["events"]):
        robots += event["robots"]
        if event["robots"] > 0 and robots > most:
            rule = f"lets {robots} robots be there at step {event['step']}, above robots.most = {most}"
            yield Problem(f"events.{number}.robots", event["robots"], rule, "lower it, or raise robots.most")
            return


def _placement(sections: Explicit) -> Iterator[Problem]:
    for name in ("robots", "tasks"):
        section = sections[name]
        more = section["arrival_rate"] or any(each[name] > 0 for each in sections["events"])
        more = more or (name == "robots" and responds(sections))
        if more and section["placement"] == "points" and not section["points"]:
            rule = f"must have a point at which {name} may appear"
            yield Problem(f"{name}.points", "", rule, f'add a point, or set {name}.placement = "uniform"')


def _for_good(sections: Explicit, fit: Callable[..., bool], strategy: Manifest | None) -> Iterator[Problem]:
    """Find what is for good, in a world that changes (model.md 6.17.10)."""
    why = "is for good, but the world of this scenario changes"
    if fit("decision.declare") and sections["decision"]["declare"] is not None:
        yield Problem("decision.declare", "a rule", why, "leave it out, or leave out events and rates")
    if strategy is not None and strategy.declares:
        rule = f"declares, which {why}"
        remedy = "choose roster, or leave out events and rates"
        yield Problem("decision.strategy", strategy.name, rule, remedy)
    if fit("run.stop_at_decision") and sections["run"]["stop_at_decision"]:
        rule = "ends a run at its first decision, but the world of this scenario changes"
        yield Problem("run.stop_at_decision", True, rule, "leave it out, or leave out events and rates")


def in_order(events: Sequence[Mapping[str, Any]]) -> list[tuple[int, Mapping[str, Any]]]:
    """Return events with their numbers in the order in which they happen: by step, then as in the file."""
    return sorted(enumerate(events), key=lambda numbered: numbered[1]["step"])


Places = Mapping[str, tuple[str, Sequence[int]]]
Fit = Callable[..., bool]
"""Returns whether the fields at some paths have valid values."""
SKILLS = 8
PHASES = ("decision.exploration", "decision.gain", "decision.dissemination_floor")
UNIQUE_LIMIT = 4 * 2**30
"""Largest memory of unique observations of all robots of a swarm, in bytes."""


def conflicts(
    explicit: Explicit,
    given: Mapping[str, Any],
    places: Places,
    wrong: set[str],
    manifest_of: Callable[[str], Manifest],
) -> Iterator[Problem]:
    """Yield a problem for each rule about several fields that a scenario breaks.

    Parameters
    ----------
    explicit : mapping of sections
        The raw values with defaults filled in.
    given : mapping
        The raw values alone.
    places : mapping
        For each section whose points are from a file: the file, and the line of each point.
    wrong : set of str
        Paths with an invalid value; rules that need one of them are skipped.
    manifest_of : callable
        Returns what the strategy of a name declares.
    """
    broken = {".".join(path.split(".")[:2]) for path in wrong}
    sections = {path.split(".")[0] for path in wrong}

    def fit(*paths: str) -> bool:
        return not broken or not any(
            path in broken or path.split(".")[0] in broken or path in sections for path in paths
        )

    yield from _swarm_conflicts(explicit, given, fit)
    if fit("decision.inbox", "decision.inbox_size"):
        yield from _inbox(explicit["decision"])
    strategy = manifest_of(explicit["decision"]["strategy"]) if fit("decision.strategy") else None
    if strategy is not None:
        yield from _strategy(explicit, fit, strategy)
    if fit("robots.count", "robots.classes", "tasks.count", "tasks.classes"):
        yield from dynamic_conflicts(explicit, _counts_of(explicit), fit, strategy)
    if not fit("arena.side", "arena.boundary"):
        return
    yield from _arena_conflicts(explicit, places, fit)
    if fit("robots.count", "robots.classes", "tasks.count", "tasks.classes", "sensing.observation"):
        yield from _memory(explicit)
        used = ("radio", "sensing.range", "sensing.misname", "robots.speed", "robots.know_count", *PHASES)
        if strategy is not None and fit("decision.parameters", "events", "run.steps", *used):
            yield from _knowledge_memory(explicit, strategy)


def _swarm_conflicts(explicit: Explicit, given: Mapping[str, Any], fit: Fit) -> Iterator[Problem]:
    """Find conflicts about numbers and classes of robots and tasks."""
    for section in ("robots", "tasks"):
        yield from _counts(section, given, explicit, fit)
    if fit("robots.classes", "tasks.classes"):
        yield from _skills(explicit)
    if fit("robots.count", "robots.classes", *(f"faults.{kind}" for kind in KINDS)):
        yield from fault_conflicts(explicit["faults"], total(explicit["robots"]))


def _arena_conflicts(explicit: Explicit, places: Places, fit: Fit) -> Iterator[Problem]:
    """Find conflicts with the size and the boundary of the arena."""
    yield from _reaches(explicit, fit)
    if fit("robots.diameter"):
        yield from _discs(explicit, fit)
    if fit("robots.contact", "robots.avoid_collisions"):
        yield from _contact(explicit["robots"])
    for section in ("robots", "tasks"):
        if fit(f"{section}.spread", f"{section}.placement"):
            yield from _spread(section, explicit)
        if fit(f"{section}.points", f"{section}.placement", "robots.diameter"):
            yield from _points(section, explicit, places)


def size_of(explicit: Explicit) -> tuple[float, float]:
    """Return the width and height of the arena."""
    side = explicit["arena"]["side"]
    return tuple(side) if isinstance(side, list | tuple) else (side, side)


def total(section: Mapping[str, Any]) -> int:
    """Return the number of robots or tasks, whether given as a count or by classes."""
    classes = section["classes"]
    return sum(_get(each, "count") for each in classes) if classes else section["count"]


def _counts_of(explicit: Explicit) -> tuple[int, int]:
    """Return the numbers of robots and tasks at the start."""
    return total(explicit["robots"]), total(explicit["tasks"])


def _get(table: Any, key: str) -> Any:
    return table.get(key, ()) if isinstance(table, Mapping) else getattr(table, key)


def _counts(section: str, given: Mapping[str, Any], explicit: Explicit, fit: Any) -> Iterator[Problem]:
    table = given.get(section, {})
    if not isinstance(table, Mapping) or not fit(f"{section}.count", f"{section}.classes"):
        return
    if table.get("classes") and "count" in table:
        rule = f"can't be combined with [[{section}.classes]]"
        remedy = f"leave {section}.count out: the classes have counts"
        yield Problem(f"{section}.count", table["count"], rule, remedy)
        return
    names = [_get(each, "name") for each in explicit[section]["classes"]]
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield Problem(
            f"{section}.classes", name, "is the name of two classes", "give each class its own name"
        )
    if section == "robots" and table.get("classes") and total(explicit["robots"]) < 1:
        yield Problem("robots.classes", 0, "must have at least 1 robot together", "set a count to 1 or more")
    points = explicit[section]["points"]
    if explicit[section]["placement"] == "points" and fit(f"{section}.points"):
        count = total(explicit[section])
        counted = "count" in table or table.get("classes")
        if not points:
            rule = f'is missing, but {section}.placement is "points"'
            yield Problem(f"{section}.points", "", rule, "name a CSV file of x and y")
        elif counted and count != len(points):
            rule = f"must be as many as {section}, {count}"
            remedy = f"leave {section}.count out, or give {count} points"
            yield Problem(f"{section}.points", f"{len(points)} points", rule, remedy)


def _skills(explicit: Explicit) -> Iterator[Problem]:
    skills = {skill for each in explicit["robots"]["classes"] for skill in _get(each, "skills")}
    skills |= {skill for each in explicit["tasks"]["classes"] for skill in _get(each, "needs")}
    if len(skills) > SKILLS:
        rule = f"must be at most {SKILLS} skills of robots and tasks together"
        yield Problem(
            "robots.classes", f"{len(skills)} skills", rule, f"use {SKILLS} names of skills or fewer"
        )


def _inbox(decision: Mapping[str, Any]) -> Iterator[Problem]:
    if decision["inbox"] == "every-message" and decision["inbox_size"] is not None:
        rule = 'limits the number of robots, but inbox = "every-message" keeps no robots apart'
        remedy = 'leave it out, or set inbox = "latest-per-robot"'
        yield Problem("decision.inbox_size", decision["inbox_size"], rule, remedy)


def _strategy(explicit: Explicit, fit: Any, strategy: Manifest) -> Iterator[Problem]:
    """Find settings that the strategy doesn't support."""
    decision, sensing = explicit["decision"], explicit["sensing"]
    if fit("decision.parameters"):
        for name in sorted(set(decision["parameters"]) - set(strategy.parameters)):
            rule = f"{strategy.name} has no such parameter"
            remedy = f"it has {', '.join(strategy.parameters) or 'none'}"
            yield Problem(f"decision.parameters.{name}", decision["parameters"][name], rule, remedy)
    if strategy.value_bits and fit("decision.inbox") and decision["inbox"] == "every-message":
        rule = f"{strategy.name} broadcasts a value, and the inbox keeps only the latest of each robot"
        remedy = 'set inbox = "latest-per-robot"'
        yield Problem("decision.inbox", decision["inbox"], rule, remedy)
    if strategy.knowledge:
        yield from _counts_of_one(decision, fit, strategy.name)
    yield from _sensing(sensing, fit, strategy)
    if strategy.needs_count and fit("robots.know_count") and not explicit["robots"]["know_count"]:
        rule = f"{strategy.name} needs the number of robots"
        yield Problem("robots.know_count", False, rule, "set it to true, or choose a strategy without n")
    for section in ("robots", "tasks") if strategy.one_class else ():
        if fit(f"{section}.classes") and explicit[section]["classes"]:
            rule = f"{strategy.name} compares one number of robots with one number of tasks"
            remedy = f"leave it out and set {section}.count, or choose census"
            yield Problem(f"{section}.classes", f"{len(explicit[section]['classes'])} classes", rule, remedy)
    if strategy.declares and fit("decision.declare") and decision["declare"] is not None:
        rule = f"{strategy.name} declares by its own word, and its messages have no opinion to agree with"
        yield Problem("decision.declare", decision["declare"], rule, "leave it out")
    says_no_lie = "encode" in strategy.functions and "lie" not in strategy.functions
    if says_no_lie and fit("faults.byzantine") and explicit["faults"]["byzantine"] not in (0, {"count": 0}):
        rule = f"{strategy.name} has encode, but no function for a Byzantine robot's message"
        remedy = "write def lie(message, feasible, me) in its file"
        yield Problem("faults.byzantine", explicit["faults"]["byzantine"], rule, remedy)


def _sensing(sensing: Mapping[str, Any], fit: Any, strategy: Manifest) -> Iterator[Problem]:
    """Find what is seen otherwise than the strategy needs."""
    for name in ("false_robots", "false_tasks") if strategy.by_name else ():
        if fit(f"sensing.{name}") and sensing[name] != 0:
            rule = f"{strategy.name} counts things by name, and what isn't there has none"
            yield Problem(f"sensing.{name}", sensing[name], rule, "leave it out, or choose tally")
    if fit("sensing.misname") and sensing["misname"] != 0 and strategy.needs_names is not True:
        rule = f"needs a strategy that counts tasks by name; {strategy.name} doesn't"
        yield Problem("sensing.misname", sensing["misname"], rule, "leave it out, or choose quiet-census")
    if strategy.judges and fit("sensing.observation") and sensing["observation"] == "unique":
        rule = f"{strategy.name} must see again what is still there, to notice what isn't"
        yield Problem("sensing.observation", "unique", rule, 'set observation = "repeated"')


def _counts_of_one(decision: Mapping[str, Any], fit: Any, name: str) -> Iterator[Problem]:
    """Find fields about the counts of one exploration, which a strategy of this name doesn't use."""
    if fit("decision.quality_floor") and decision["quality_floor"] != 0:
        rule = f"{name} rates what the swarm knows, not the counts of one exploration"
        yield Problem("decision.quality_floor", decision["quality_floor"], rule, "leave it out")
    if fit("decision.switching") and decision["switching"] is not None:
        rule = f"{name} decides by what the swarm knows, not by the counts of one exploration"
        yield Problem("decision.switching", decision["switching"], rule, "leave it out, or choose dc")


def _knowledge_memory(explicit: Explicit, strategy: Manifest) -> Iterator[Problem]:
    """Find built-in strategies whose robots together know more than fits; a user's file isn't run here."""
    if not isinstance(strategy, Strategy) or not strategy.knowledge or strategy.source:
        return
    decision = explicit["decision"]
    counts = _counts_of(explicit)
    setting = setting_from(
        most_of(explicit, counts),
        (len(explicit["robots"]["classes"]), len(explicit["tasks"]["classes"])),
        whole_robots(explicit["faults"]["byzantine"], counts[0]) > 0,
        explicit["radio"]["id_bits"],
        {**strategy.parameters, **explicit["decision"]["parameters"]}.values(),
        misnames=explicit["sensing"]["misname"] > 0,
        count=counts[0],
        knows_count=explicit["robots"]["know_count"],
        size=size_of(explicit),
        walled=explicit["arena"]["boundary"] == "walls",
        sight=explicit["sensing"]["range"],
        radio=explicit["radio"]["range"],
        speed=explicit["robots"]["speed"],
        phases=(decision["exploration"], decision["gain"] + decision["dissemination_floor"]),
        mean_run=explicit["walk"]["mean_run"],
    )
    problem = excess(setting, *strategy.row_lengths(setting))
    if problem:
        remedy = "choose sketch or average, or fewer robots"
        yield Problem("decision.strategy", strategy.name, problem, remedy)


def _reaches(explicit: Explicit, fit: Any) -> Iterator[Problem]:
    half = min(size_of(explicit)) / 2
    for path in ("sensing.range", "radio.range"):
        section = path.split(".")[0]
        value = explicit[section]["range"]
        implied = path == "radio.range" and value == explicit["sensing"]["range"]
        on_torus = explicit["arena"]["boundary"] == "torus"
        if on_torus and fit(path) and not implied and value > half:
            rule = f"must be at most half the side of the torus, {half:g} units"
            yield Problem(path, value, rule, f"set arena.side to {2 * value:g} or more, or shorten the range")
    speed = explicit["robots"]["speed"]
    if fit("robots.speed") and speed > half:
        rule = f"must be at most half the side of the arena per step, {half:g} units"
        yield Problem("robots.speed", speed, rule, f"lower it, or set arena.side to {2 * speed:g} or more")


def _discs(explicit: Explicit, fit: Any) -> Iterator[Problem]:
    robots, (width, height) = explicit["robots"], size_of(explicit)
    diameter = robots["diameter"]
    if explicit["arena"]["boundary"] == "walls" and diameter >= min(width, height):
        rule = f"must be less than the arena's shorter side, {min(width, height):g} units"
        yield Problem("robots.diameter", diameter, rule, "lower it, or enlarge arena.side")
        return
    moving = fit("robots.avoid_collisions", "robots.speed", "robots.count", "robots.classes")
    if not moving or not robots["avoid_collisions"]:
        return
    reach = diameter + 2 * robots["speed"]
    if explicit["arena"]["boundary"] == "torus" and reach > min(width, height) / 2:
        rule = (
            f"diameter + 2 speed must be at most half the side of the torus, {min(width, height) / 2:g} units"
        )
        yield Problem("robots.diameter", diameter, rule, f"set arena.side to {2 * reach:g} or more")
    unit = max(exact(width), exact(height)) / 2 ** (31 if explicit["arena"]["boundary"] == "walls" else 32)
    step = 2 * math.ceil(exact(diameter) / unit / 2)  # of the lattice of last resort, in fixed point
    columns, rows = (math.floor(exact(side) / unit) // step for side in (width, height))
    room = columns * rows
    if robots["placement"] != "points" and total(robots) > room:
        rule = f"must be at most {room}, the number of discs that fit on a square grid"
        yield Problem(
            "robots.count", total(robots), rule, "use fewer or smaller robots, or enlarge arena.side"
        )


def _contact(robots: Mapping[str, Any]) -> Iterator[Problem]:
    """Find a rule of contact for robots that pass through each other."""
    if robots["contact"] != "stand" and not robots["avoid_collisions"]:
        rule = "needs robots.avoid_collisions = true: without it, robots pass through each other"
        remedy = 'set robots.avoid_collisions to true, or leave contact at "stand"'
        yield Problem("robots.contact", robots["contact"], rule, remedy)


def _spread(section: str, explicit: Explicit) -> Iterator[Problem]:
    placed, longer = explicit[section], max(size_of(explicit))
    if placed["placement"] == "clusters" and placed["spread"] > longer:
        rule = f"must be at most the arena's longer side, {longer:g} units"
        yield Problem(
            f"{section}.spread", placed["spread"], rule, f'lower it, or set {section}.placement = "uniform"'
        )


def _points(section: str, explicit: Explicit, places: Places) -> Iterator[Problem]:
    if explicit[section]["placement"] != "points":
        return
    width, height = size_of(explicit)
    walled = explicit["arena"]["boundary"] == "walls"
    diameter = explicit["robots"]["diameter"]
    margin = diameter / 2 if walled and section == "robots" else 0.0
    points = explicit[section]["points"]
    for number, (x, y) in enumerate(points, start=1):
        inside = margin <= x <= width - margin and margin <= y <= height - margin
        if not inside or (not walled and (x == width or y == height)):
            place = (
                "inside the arena" if margin == 0 else f"inside the arena, {margin:g} units from its walls"
            )
            path, lines = places.get(section, ("", ()))
            where = f"{path}, line {lines[number - 1]}" if lines else f"point {number}"
            rule = f"{where}: must be {place}"
            yield Problem(f"{section}.points", (x, y), rule, "move the point, or enlarge arena.side")
    if section == "robots" and explicit["robots"]["avoid_collisions"]:
        for first, second in _overlaps(points, diameter, None if walled else (width, height)):
            rule = f"robots {first + 1} and {second + 1} must be more than {diameter:g} units apart"
            yield Problem("robots.points", (points[first], points[second]), rule, "move one of them")


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


def _memory(explicit: Explicit) -> Iterator[Problem]:
    robots, tasks = total(explicit["robots"]), total(explicit["tasks"])
    needed = robots * (robots + tasks) / 8
    if explicit["sensing"]["observation"] == "unique" and needed > UNIQUE_LIMIT:
        size, limit = f"{needed / 2**30:.1f} GiB", f"{UNIQUE_LIMIT // 2**30} GiB"
        rule = f"needs {size} for {robots} robots and {tasks} tasks, above the limit of {limit}"
        remedy = 'use fewer robots or tasks, or observation = "repeated"'
        yield Problem("sensing.observation", "unique", rule, remedy)
