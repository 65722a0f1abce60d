"""What remedies say, done: the tables of a scenario after each way out of a problem that a program can go."""

from __future__ import annotations

import copy
import re

from feasibee import Scenario, ScenarioError
from feasibee.scenario.fields import SECTIONS
from feasibee.scenario.paths import place, read_value, with_changes
from feasibee.strategies import STRATEGIES

FIELD, VALUE = r"(?:events|[a-z_]+(?:\.[a-z_]+)*)", r'(\[[^\]]*\]|\{[^}]*\}|"[^"]*"|true|false|-?\d[\d.e+-]*)'
SETS = (
    rf"set ({FIELD})(?: = | to ){VALUE}",
    rf"(the paper uses|use) {VALUE}(?= for one|$)",
    rf"use (faults\.\w+) = {VALUE}",
    r"(take away) (\d+) at most",
    r"(use one of|did you mean) (\w+)(?:, |\?|$)",
    r'(write) .*such as ("\d[^"]*")',
)
RATES = ("robots.arrival_rate", "robots.failure_rate", "tasks.arrival_rate", "tasks.lifetime")
CHANGING = ("events", *RATES, "robots.away")
"""What changes the world of a scenario."""


def problems_of(tables):
    """Return the problems of a scenario; none if it is valid."""
    try:
        Scenario(**tables)
    except ScenarioError as error:
        return error.problems
    return ()


def check_remedies(problem, tables):
    """See that a problem has a rule and a remedy, and is gone after each thing that the remedy offers."""
    assert problem.rule
    assert problem.remedy
    offered = [*ways(problem, tables)]
    assert offered or not problem.remedy.startswith(("the paper uses", "leave", "use faults")), str(problem)
    for other in offered:
        left = [each for each in problems_of(other) if (each.path, each.rule) == (problem.path, problem.rule)]
        assert not left or other == tables, (str(problem), other)


def ways(problem, tables):
    """Yield the tables of a scenario, each after one of the things that a problem's remedy offers."""
    for pattern in SETS:
        for found in re.finditer(pattern, problem.remedy):
            name, value = found.groups()
            new = -int(value) if name == "take away" else read_value(value)
            yield with_changes(tables, {whole(name, problem.path): new})[0]
    remedy = re.sub(r"(?<=leave out )(events, rates|what changes).*", " and ".join(CHANGING), problem.remedy)
    for found in re.finditer(rf"leave (?:out ({FIELD}(?: and {FIELD})*)|({FIELD}) out)", remedy):
        yield without(tables, [whole(name, problem.path) for name in re.findall(FIELD, found[1] or found[2])])
    for name in re.findall(r"(?<=choose )[a-z-]+|(?<= or )[a-z-]+(?=, or)", problem.remedy):
        if name in STRATEGIES:
            yield with_changes(tables, {"decision.strategy": name})[0]
    if "leave the event out" in problem.remedy:
        yield without(tables, [".".join(problem.path.split(".")[:2])])
    if "lower it" in problem.remedy and isinstance(problem.value, int | float):
        yield with_changes(tables, {problem.path: 0 * problem.value})[0]
    for better in re.findall(r"did you mean ([a-z]+(?:\.\w+)+)\?", problem.remedy):
        yield with_changes(without(tables, [problem.path]), {better: problem.value})[0]


def whole(name, path):
    """Return the path of a field as a remedy names it: whole, by its key, or not at all."""
    if name == "events" or "." in name:
        return name
    section = path.partition(".")[0]
    return f"{section}.{name}" if name in getattr(SECTIONS.get(section), "model_fields", ()) else path


def without(tables, paths):
    """Return tables without what stands at some paths, as far as it is there."""
    left = copy.deepcopy(tables)
    for path in paths:
        *way, last = path.split(".")
        table = left
        for part in way:
            table = table[place(part)] if isinstance(table, list) else table.get(part, {})
        if isinstance(table, list):
            del table[place(last)]
        else:
            table.pop(last, None)
    return left
