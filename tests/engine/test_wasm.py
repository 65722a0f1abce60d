"""The engine in WebAssembly, which pages load, gives what it gives on this processor, bit for bit."""

from __future__ import annotations

import gzip
import re
import subprocess
from contextlib import suppress
from functools import cache

import numpy as np
import pytest
from commands import invoke
from in_node import ended_in_node, given_in_node, shown_in_node, told_in_node

from feasibee import STRATEGIES, Scenario, ScenarioError, Swarm
from feasibee.base.outcomes import BITS_SENT, FEASIBLE_AT_END, INFEASIBLE_AT_END, LAST_STEP
from feasibee.engine.build import SOURCES, params_header
from feasibee.engine.compilers import zig
from feasibee.engine.library import ffi
from feasibee.engine.own import module
from feasibee.engine.platforms import WEBASSEMBLY
from feasibee.live.scene import patches, why_fixed
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.flooding import flooded
from tests.places import rectangle
from tests.worlds import fields_of, world

NO_TASK = 2**16 - 1
ROOMS = {"arena.boundary": "walls", "robots.diameter": 0.5, "place.walls": [rectangle(9.9, 0.0, 10.1, 15.0)]}
CROWD = {"robots.count": 300, "tasks.count": 300, "arena.side": 77.0, "run.steps": 40}
WORLDS = [*range(len(fields_of())), *(f"of the paper {number}" for number in range(3)), "crowd"]
"""Worlds of the conformance suite by number, some of the fast path, and one of 300 robots."""


@cache
def world_of(name):
    if isinstance(name, int):
        return flooded(world(name))
    return Scenario().replace(CROWD) if name == "crowd" else world(int(name.split()[-1]), fast=True)


def assert_same(scenario, seed, given=None):
    """Compare each step that a page shows with this processor's."""
    swarm = Swarm(scenario, seed, 3)
    for step, now in enumerate(shown_in_node(scenario, seed, 3, given)):
        swarm.advance(int(step > 0))
        own, where = swarm.snapshot(), f"step {step}"
        for name in ("x", "y", "flags"):
            np.testing.assert_array_equal(now[name], getattr(own, name), f"{name} at {where}")
        turns = (now["heading"].astype(int) - own.heading) % 256  # another arctangent may round otherwise
        assert np.isin(turns, (0, 1, 255)).all(), where
        places = (*swarm.task_places(), swarm.task_numbers)
        for name, found in zip(("task_x", "task_y", "task_numbers"), places, strict=True):
            np.testing.assert_array_equal(now[name], found, where)
        counts = (swarm.feasible_count, swarm.infeasible_count, swarm.counted.sum(), swarm.decision)
        assert [now[name] for name in ("feasible", "infeasible", "counted", "decision")] == [*counts], where
        assert (now["missing"] == 0) == swarm.truth, where
        assert now["bits"] == swarm.bits_sent, where
        if scenario.acts:
            aims = swarm.acting.aims
            np.testing.assert_array_equal(now["aims"], np.where(aims < 0, NO_TASK, aims), where)
            np.testing.assert_array_equal(now["looks"], swarm.acting.looks, where)


@pytest.mark.quick(10)
@pytest.mark.parametrize("name", WORLDS)
def test_a_page_shows_and_counts_the_runs_of_any_world(name):
    given = given_in_node(world_of(name))
    assert_same(world_of(name), 2**63 + 5, given)
    assert_same_ends(world_of(name), 3, given)


@pytest.mark.quick(3)
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_page_shows_and_counts_the_runs_of_any_strategy(strategy):
    changes = {"decision.strategy": strategy, "robots.know_count": True, "run.steps": 150}
    assert_same(Scenario().replace(changes), 7)
    for robots in (13, 60):
        counts = {"know_count": True, "count": robots}
        assert_same_ends(Scenario(decision={"strategy": strategy}, robots=counts), 10)


NAMED = {"decision.strategy": "quiet-census", "robots.know_count": True}
ZONE = {"place.zones": {"dock": rectangle(0.0, 0.0, 4.0, 20.0)}, "robots.zone": "dock", "radio.walls": 0.5}
APART = {"arena.side": [12.0, 6.0], "place.walls": [rectangle(3.9, 0.0, 4.1, 6.0)]}
SLID = [
    {},
    {"radio.delay": 3, "decision.strategy": "tally", "robots.know_count": True},
    {**NAMED, "sensing.position_error": 0.4},
    {**ROOMS, **APART},
    {**ROOMS, **ZONE, "decision.strategy": "dc"},
    {**ROOMS, "decision.strategy": "map", "robots.know_count": True},
    {"arena.boundary": "walls", "arena.side": [20.0, 9.3], "sensing.miss": 0.2},
    {"tasks.arrival_rate": 0.1, "tasks.lifetime": 60.0, "robots.failure_rate": 0.005},
]
"""Worlds in which a page can change the numbers of robots and tasks."""
COUNTS = [(1, 1), (33, 15), (129, 130), (7, 40), (2, 7)]


@pytest.mark.quick(8)
@pytest.mark.parametrize("changes", SLID, ids=str)
@pytest.mark.parametrize(("robots", "tasks"), COUNTS)
def test_numbers_that_follow_from_those_that_sliders_change_are_those_of_python(changes, robots, tasks):
    """What a page was written for has other numbers of robots and tasks, and no events."""
    written = flooded(Scenario().replace(changes))
    given = given_in_node(written)
    assert not given["counted"]
    counts = {"robots.count": robots, "tasks.count": tasks, "run.steps": 40}
    scenario = written.replace(counts)
    if scenario.waits_for_names:
        scenario = scenario.with_flooding(written.flooding)
    assert_same(scenario, 1, given)
    if not why_fixed(scenario):
        assert_same(scenario.replace({"events": [{"step": 5, "robots": 3, "tasks": 2}]}), 1, given)


RANGES = [(0.3, 1.0, 0.35), (1.0, 0.01, 0.3), (1e-7, 1e-7, 0.0)]
"""Ranges of sight and radio in half sides of the arena, and speeds."""


@pytest.mark.parametrize("part", [0, *(pytest.param(each, marks=pytest.mark.slow) for each in range(1, 5))])
def test_ranges_and_speed_that_a_page_changes_are_those_of_python(part):
    """What a page was written for has other ranges and another speed."""
    changed = 0
    for k, scenario in enumerate(filter(patches, map(world_of, WORLDS[part::5]))):
        (sight, radio, speed), half = RANGES[k % 3], 0.5 * min(scenario.arena.size)
        changes = {"sensing.range": sight * half, "radio.range": radio * half, "robots.speed": speed}
        with suppress(ScenarioError):
            ranges, given = scenario.replace(changes), given_in_node(scenario)
            assert_same(ranges, 1, given)
            assert_same_ends(ranges, 2, given)
            changed += 1
    assert changed > 1


@pytest.mark.parametrize("strategy", [name for name, each in STRATEGIES.items() if each.knowledge])
@pytest.mark.quick(2)
def test_ranges_that_a_page_changes_are_those_of_any_strategy(strategy):
    own = Scenario().replace({"decision.strategy": strategy, "robots.know_count": True, "run.steps": 250})
    changes = {"sensing.range": 3.3, "radio.range": 1.9, "robots.speed": 1.25}
    assert_same(own.replace(changes), 7, given_in_node(own))


def test_a_page_changes_no_ranges_from_which_more_follows():
    fixed = [{"robots.avoid_collisions": True}, {"sensing.view": 120.0}, {"acting.start": 20}, ROOMS]
    fixed += [{"decision.strategy": "census", "sensing.position_error": 0.1}]
    assert not any(patches(Scenario().replace(each)) for each in fixed)


def assert_same_ends(scenario, runs, given=None):
    """Compare decisions and accounts of runs that stop at decisions alone with this processor's."""
    ends = {"run.stop_at_declarations": False, "run.stop_when_taken": False}
    flooding, scenario = scenario.flooding, scenario.replace(ends)
    if not scenario.dynamic:
        scenario = scenario.replace({"run.stop_at_decision": True})
    scenario = scenario.with_flooding(flooding) if flooding is not None else scenario
    decision, step, _, account, courses = ended_in_node(scenario, 7, runs, 17, given)
    record = simulate_record(scenario, Runs(runs, 7, 0), curves=True)
    np.testing.assert_array_equal(decision, record.decision)
    np.testing.assert_array_equal(step[decision >= 0], record.decision_step[decision >= 0])
    kept = [] if scenario.dynamic else [BITS_SENT, FEASIBLE_AT_END, INFEASIBLE_AT_END, LAST_STEP]
    np.testing.assert_array_equal(account[:, kept], record.account[:, kept])
    known = courses >= 0
    np.testing.assert_array_equal(known.sum(axis=1), account[:, LAST_STEP] + 1)
    np.testing.assert_array_equal(courses[known], record.feasible_count[known])


TRUSTING = '''"""Trusting: adopt an opinion that was heard, the more likely the more was heard in life."""

import math

PARAMETERS = {"trust": 0.3}
MEMORY = 1


def decide(mind, inbox):
    """Return an opinion heard with a probability that grows, or the robot's own."""
    mind.memory[0] += inbox.feasible_votes + inbox.infeasible_votes
    if inbox.heard_opinion >= 0 and inbox.chance > mind.parameters[0] ** math.sqrt(mind.memory[0] / 9):
        return inbox.heard_opinion
    return mind.opinion
'''
EASTERN = '''"""Eastern: the easternmost place where a robot began or saw something, which robots pass on."""


def words(setting):
    return 1


def start(known, me):
    known[0] = int(me.x * 1000.0)


def observe(known, thing, me):
    known[0] = max(known[0], int(thing.x * 998.0 + me.y))


def merge(known, message, sender, me):
    known[0] = max(known[0], message[0])


def count(known, counts, me):
    counts[0], counts[1] = known[0], 19_500


def bits(message, me):
    return 32


def decide(mind, inbox):
    return int(mind.feasible_quality > 0.5)
'''


@pytest.mark.parametrize(
    "text",
    [TRUSTING, pytest.param(EASTERN, marks=pytest.mark.slow), pytest.param("", marks=pytest.mark.slow)],
    ids=["opinions", "positions", "skeleton"],
)
def test_a_page_shows_the_run_of_a_users_own_strategy(tmp_path, text):
    """Catches a translation, or mathematics of WebAssembly, that gives other bits in pages than here."""
    file = tmp_path / "dmmd.py"
    if text:
        file.write_text(text, encoding="utf-8")
    else:
        assert invoke("new", str(file), "--knowledge").exit_code == 0
    own = Scenario(decision={"strategy": str(file)}, tasks={"count": 14}, run={"steps": 150})
    given = given_in_node(own)
    for tasks in (14, 26):
        assert_same(own.replace({"tasks.count": tasks}), 5, given)


FAILING = """import math

PARAMETERS = {"how": 0.0}


def decide(mind, inbox):
    votes = inbox.feasible_votes + inbox.infeasible_votes
    if votes < 5 or votes > 19:
        return 1
    if mind.parameters[0] == 0.0:
        return int(mind.parameters[votes])
    return int(math.sqrt(1.5 - votes)) if mind.parameters[0] == 1.0 else votes
"""
WHY = [
    "place {} in a row of 1; take one",
    "math.sqrt(-{}.5): math domain error; test",
    "decide returns {}; must be 1",
]


@pytest.mark.parametrize("how", range(len(WHY)))
def test_a_page_says_why_a_users_strategy_fails(tmp_path, how):
    file = tmp_path / "mine.py"
    file.write_text(FAILING)
    with pytest.raises(AssertionError) as failed:
        told_in_node(Scenario(decision={"strategy": str(file), "parameters": {"how": how}}), 1, [200])
    before, after = WHY[how].split("{}")
    found = r"Line \d+ of the strategy fails here: " + re.escape(before) + r"\d+" + re.escape(after)
    assert re.search(found, str(failed.value))


def test_inboxes_that_lack_room_get_more():
    changes = {"robots.count": 400, "tasks.count": 10, "arena.side": 20.0, "run.steps": 60}
    assert_same(Scenario().replace(changes), 1)


def test_the_module_is_small():
    data = module(STRATEGIES["dmmd"])
    assert len(data) <= 141_000
    assert len(gzip.compress(data)) <= 60_400


def names(struct):
    """Yield the names of the numbers of a struct in C, those of its structs in addition."""
    for name, field in struct.fields:
        yield name
        if field.type.kind == "struct":
            yield from (f"{name}.{below}" for below in names(field.type))


def test_structs_that_python_writes_are_the_same_with_short_pointers(tmp_path):
    """Bytes of params and settings are handed to pages as they are."""
    if zig() is None:
        pytest.skip("ziglang isn't installed")
    lines = ["#include <stddef.h>", '#include "engine.h"']
    for struct in ("struct params", "struct setting"):
        for name in names(ffi().typeof(struct)):
            offset = ffi().offsetof(struct, *name.split("."))
            lines.append(f'_Static_assert(offsetof({struct}, {name}) == {offset}, "{name}");')
        lines.append(f'_Static_assert(sizeof({struct}) == {ffi().sizeof(struct)}, "{struct}");')
    source = tmp_path / "places.c"
    source.write_text("\n".join(lines))
    (tmp_path / "params.h").write_text(params_header())
    includes = ["-I", str(tmp_path), "-I", str(SOURCES)]
    options = ["-target", WEBASSEMBLY.target, "-c", "-o", str(tmp_path / "places.o"), *includes]
    command = [*zig().command, *options, str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len(lines) > 200
