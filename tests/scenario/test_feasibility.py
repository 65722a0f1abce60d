"""Exact truth: cases by hand, and thousands of random ones against scipy's matching of single robots."""

from __future__ import annotations

from collections import Counter
from itertools import combinations

import numpy as np
import pytest
from commands import json_of, output_of
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from feasibee import Scenario, truth
from feasibee.scenario.feasibility import Violator, explain
from feasibee.scenario.fields import RobotClass, TaskClass

SKILLS = ("lift", "scan", "dig", "any")


def scenario(robots, tasks):
    """Make a scenario of (count, skills) and (count, needs) by name of class, or of plain counts."""
    return Scenario(robots=section(robots, "skills"), tasks=section(tasks, "needs"))


def section(classes, key):
    if isinstance(classes, int):
        return {"count": classes}
    return {"classes": [{"name": name, "count": n, key: value} for name, (n, value) in classes.items()]}


def expand(robots, tasks):
    """Return class and skills of each single robot, and of each single place its class and the skill."""
    robots = {"robots": (robots, ())} if isinstance(robots, int) else robots
    if isinstance(tasks, int):
        tasks = {"tasks": (tasks, {"any": 1})}
        robots = {name: (count, ["any"]) for name, (count, _) in robots.items()}
    able = [(name, set(skills)) for name, (count, skills) in robots.items() for _ in range(count)]
    asked = [
        (name, skill)
        for name, (count, needs) in tasks.items()
        for _ in range(count)
        for skill, needed in needs.items()
        for _ in range(needed)
    ]
    return able, asked


def matching(able, asked):
    """Return how many places can be filled at once, from scipy."""
    edges = np.array([[skill in skills for _, skill in asked] for _, skills in able], dtype=np.int8)
    if edges.size == 0:
        return 0
    return int((maximum_bipartite_matching(csr_array(edges)) >= 0).sum())


def check_assignment(assignment, able, asked):
    """Every place is filled, by robots that there are and that can."""
    skills_of = dict(able)
    filled, busy = Counter(), Counter()
    for (robots, tasks, skill), count in assignment.items():
        assert count > 0
        assert skill in skills_of[robots]
        filled[tasks, skill] += count
        busy[robots] += count
    assert filled == Counter(asked)
    assert busy <= Counter(name for name, _ in able)


def check_violator(violator, able, asked, unfilled):
    """The set is in excess as much as any, and no other set of so few skills is."""

    def count(skills):
        demand = sum(skill in skills for _, skill in asked)
        return demand, sum(not skills.isdisjoint(has) for _, has in able)

    assert count(set(violator.skills)) == (violator.demand, violator.robots)
    assert violator.demand - violator.robots == unfilled > 0
    as_short = combinations(sorted({skill for _, skill in asked}), len(violator.skills))
    most = [skills for skills in as_short if np.subtract(*count(set(skills))) == unfilled]
    assert most == [violator.skills]
    for size in range(1, len(violator.skills)):
        shorter = combinations(violator.skills, size)
        assert all(np.subtract(*count(set(skills))) < unfilled for skills in shorter)


def random_world(draw):
    """Draw a small world in which neither verdict is rare, odd ones included."""
    skills = list(SKILLS[: draw.integers(1, 5)])

    def some(least):
        return draw.permutation(skills)[: draw.integers(least, len(skills) + 1)].tolist()

    robots = {f"r{k}": (int(draw.integers(0, 9)), some(0)) for k in range(draw.integers(1, 6))}
    robots["r0"] = (robots["r0"][0] + 1, robots["r0"][1])
    tasks = {
        f"t{k}": (int(draw.integers(0, 3)), {skill: int(draw.integers(1, 4)) for skill in some(1)})
        for k in range(draw.integers(1, 5))
    }
    kind = draw.integers(0, 20)
    if kind == 0:
        return robots, int(draw.integers(0, 40))
    if kind == 1:
        return int(draw.integers(1, 20)), tasks
    if kind == 2:
        return int(draw.integers(1, 9)), int(draw.integers(0, 9))
    return robots, tasks


@pytest.mark.parametrize("seed", range(20))
def test_as_scipys_matching_of_single_robots_with_proofs_that_hold(seed):
    draw = np.random.default_rng(seed)
    verdicts = Counter()
    for _ in range(100):
        world = random_world(draw)
        able, asked = expand(*world)
        verdict = explain(scenario(*world))
        unfilled = len(asked) - matching(able, asked)
        assert verdict.feasible == (unfilled == 0), world
        assert truth(scenario(*world)) is verdict.feasible
        if verdict.feasible:
            check_assignment(verdict.assignment, able, asked)
        else:
            assert verdict.assignment == {}
            check_violator(verdict.violator, able, asked, unfilled)
        verdicts[verdict.feasible] += 1
    assert min(verdicts[True], verdicts[False]) >= 20


def test_places_of_one_skill_are_shared_out_over_the_classes():
    robots = {"a": (3, ["lift"]), "b": (4, ["lift", "lift"]), "c": (5, ["lift"])}
    verdict = explain(scenario(robots, {"one": (5, {"lift": 1}), "two": (3, {"lift": 2})}))
    shared = {("a", "one"): 3, ("b", "one"): 2, ("b", "two"): 2, ("c", "two"): 4}
    assert verdict.assignment == {(*pair, "lift"): count for pair, count in shared.items()}


def test_a_class_named_as_a_skill_or_as_the_others():
    robots = {"lift": (2, ["scan"]), "scan": (1, ["lift"])}
    verdict = explain(scenario(robots, {"lift": (1, {"lift": 1, "scan": 2})}))
    assert verdict.assignment == {("scan", "lift", "lift"): 1, ("lift", "lift", "scan"): 2}


def ring(count, missing=0):
    """Return sixteen classes in a ring of eight skills, in which each robot is needed."""
    names = [f"s{k}" for k in range(8)]
    robots = {f"r{k}": (4 * count, [names[k % 8], names[(k + 3) % 8]]) for k in range(16)}
    robots["r0"] = (4 * count - missing, robots["r0"][1])
    return robots, {f"t{k}": (count, {names[k % 8]: 1, names[(k + 1) % 8]: 3}) for k in range(16)}


@pytest.mark.parametrize("missing", [0, 1])
def test_a_million_robots_are_matched_by_their_classes(missing):
    """Robot by robot, this would take hours."""
    verdict = explain(scenario(*ring(15_625, missing)))
    if missing:
        assert verdict.violator == Violator(tuple(f"s{k}" for k in range(8)), 10**6, 10**6 - 1)
    else:
        assert sum(verdict.assignment.values()) == 10**6


TEAMS = """
[[robots.classes]]
name = "arm [/]"
count = 3
skills = ["lift"]
[[robots.classes]]
name = "drone"
count = 2
skills = ["lift", "scan"]
[[tasks.classes]]
name = "search"
count = 2
needs = { lift = 1, scan = 1 }
"""
BOTH = "lift or scan"
MORE = 'tasks.classes=[{name="search", count=3, needs={lift=%d, scan=1}}]'


def test_the_command_says_why(tmp_path):
    (path := tmp_path / "teams.toml").write_text(TEAMS)
    first, *table = output_of("show", "truth", path).splitlines()
    assert first == "Feasible: each task can have its own robots; robots left over: 1."
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in table if "│" in line]
    assert rows == [["arm [/]", "search", "lift", "2"], ["drone", "search", "scan", "2"]]
    assert json_of("show", "truth", path)["assignment"] == [
        {"robots": "arm [/]", "tasks": "search", "skill": "lift", "count": 2},
        {"robots": "drone", "tasks": "search", "skill": "scan", "count": 2},
    ]
    violator = {"skills": ["scan"], "demand": 3, "robots": 2}
    assert json_of("show", "truth", path, "--set", MORE % 1) == {"feasible": False, "violator": violator}
    for words, said in {
        (path, "--set", MORE % 1): "Infeasible: places that ask for scan: 3; robots that can scan: 2.",
        (
            path,
            "--set",
            MORE % 2,
        ): "Infeasible: places that ask for lift or scan: 9; robots that can lift or scan: 5.",
        ("--set", "tasks.count=0"): "Feasible: each task can have its own robots; robots left over: 20.",
        ("--set", "tasks.count=21"): "Infeasible: tasks, each for any one robot: 21; robots: 20.",
    }.items():
        assert output_of("show", "truth", *words) == f"{said}\n"


def test_threads_need_nothing_of_pydantic(monkeypatch):
    """It builds a class at its first use; meanwhile other threads have the validator of its base class."""
    for each in (RobotClass, TaskClass):
        monkeypatch.setattr(each, "__pydantic_validator__", None)
    assert truth(Scenario(robots={"count": 17}, tasks={"count": 16}))
