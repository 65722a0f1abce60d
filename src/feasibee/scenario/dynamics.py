"""Worlds that change: how many robots and tasks there may be, and conflicts (model.md 6.17)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from feasibee.errors import Problem
from feasibee.strategies.contract import Manifest

TASKS_LIMIT = 10_000_000
"""Tasks that may appear in one run."""
TWICE = 2
"""Largest number of robots, in units of those at the start, if robots join by rate or call."""

Explicit = Mapping[str, Any]


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
    if fit("decision.commit") and sections["decision"]["commit"] is not None:
        yield Problem("decision.commit", "a rule", why, "leave it out, or leave out events and rates")
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
