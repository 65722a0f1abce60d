"""The engine in WebAssembly, which pages load, gives what it gives on this processor, bit for bit."""

from __future__ import annotations

import gzip
import subprocess

import numpy as np
import pytest
from commands import invoke
from in_node import ended_in_node, given_in_node, shown_in_node

from feasibee import STRATEGIES, Scenario, Swarm
from feasibee.engine.build import SOURCES
from feasibee.engine.compilers import zig
from feasibee.engine.library import ffi
from feasibee.engine.own import module
from feasibee.engine.platforms import WEBASSEMBLY
from feasibee.live.lane import why_fixed
from feasibee.live.messages import NO_TASK
from feasibee.model.outcomes import BITS_SENT, FEASIBLE_AT_END, INFEASIBLE_AT_END, LAST_STEP
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.flooding import flooded
from tests.places import rectangle

EYES = [{"name": "eye", "count": 6, "skills": ["see"]}, {"name": "arm", "count": 9, "skills": ["grip"]}]
JOBS = [{"name": "look", "count": 5, "needs": {"see": 1}}, {"name": "lift", "count": 4, "needs": {"grip": 2}}]
ROOMS = {"arena.boundary": "walls", "robots.diameter": 0.5, "place.walls": [rectangle(9.9, 0.0, 10.1, 15.0)]}
APART = ROOMS | {"arena.side": [12.0, 6.0], "place.walls": [rectangle(3.9, 0.0, 4.1, 6.0)]}
ZONES = {"place.zones": {"dock": rectangle(0.0, 0.0, 4.0, 20.0)}, "robots.zone": "dock"}
EVENTS = [
    {"step": 0, "robots": 3},
    {"step": 9, "tasks": -8, "robots": -2, "sensing": {"miss": 0.125}, "radio": {"loss": 0.3}},
    {"step": 20, "tasks": 7, "at": [3.25, 7.5]},
    {"step": 20, "robot": 4, "at": [19.99, 0.01]},
    {"step": 31, "task": 2},
    {"step": 33, "robots": 30},
]
WORLDS = {
    "paper": {},
    "one": {"robots.count": 1, "tasks.count": 0},
    "crowd": {"robots.count": 300, "tasks.count": 300, "arena.side": 77.0, "run.steps": 40},
    "walls": {"arena.boundary": "walls", "arena.side": [20.0, 9.3], "robots.count": 50, "sensing.miss": 0.2},
    "errors": {
        "radio.loss": 0.2,
        "radio.id_bits": 4,
        "decision.inbox_size": 2,
        "decision.listen": {"last": 3},
    },
    "late": {"radio.delay": 3, "decision.strategy": "tally", "robots.know_count": True},
    "liars": {"decision.strategy": "census", "robots.know_count": True, "faults.byzantine": {"count": 2}},
    "faults": {"faults.stopped": 0.2, "faults.stubborn": 0.1, "faults.stop_step": 25},
    "classes": {"robots.classes": EYES, "tasks.classes": JOBS},
    "bodies": {"robots.avoid_collisions": True, "robots.contact": "deflect"},
    "clusters": {"robots.placement": "clusters", "tasks.placement": "clusters", "sensing.view": 120.0},
    "names": {"decision.strategy": "quiet-census", "robots.know_count": True, "sensing.position_error": 0.4},
    "rooms": ROOMS | ZONES | {"radio.walls": 0.5, "decision.strategy": "dc"},
    "apart": APART,
    "plan": ROOMS | {"decision.strategy": "map", "robots.know_count": True},
    "events": {"events": EVENTS, "decision.strategy": "census"},
    "streams": {"tasks.arrival_rate": 0.1, "tasks.lifetime": 60.0, "robots.failure_rate": 0.005},
    "batteries": {"robots.work": 30, "robots.charge": 10},
    "acting": {"acting.start": 20, "tasks.work": 30, "tasks.count": 15},
    "acting in rooms": ROOMS | {"acting.start": 20, "acting.hold": "tag", "robots.speed": 0.8},
}


def world(name):
    return flooded(Scenario().replace({"run.steps": 90, **WORLDS[name]}))


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
        if scenario.acts:
            aims = swarm.acting.aims
            np.testing.assert_array_equal(now["aims"], np.where(aims < 0, NO_TASK, aims), where)
            np.testing.assert_array_equal(now["looks"], swarm.acting.looks, where)


@pytest.mark.parametrize("name", WORLDS)
def test_a_page_shows_the_run_of_any_world(name):
    assert_same(world(name), 2**63 + 5)


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.quick(3)
def test_a_page_shows_the_run_of_any_strategy(strategy):
    changes = {"decision.strategy": strategy, "robots.know_count": True, "run.steps": 150}
    assert_same(Scenario().replace(changes), 7)


@pytest.mark.parametrize(
    ("name", "robots", "tasks"),
    [
        *(("paper", *each) for each in [(1, 0), (33, 15), (129, 130), (700, 16)]),
        *(
            (name, *each)
            for name in ("liars", "late", "names")
            for each in [(7, 40), (34, 33)]
            if name != "liars"
        ),
        *(("apart", *each) for each in [(1, 1), (2, 7), (30, 30), (13, 6)]),
        *(("rooms", 12, 30), ("plan", 5, 9), ("walls", 140, 3), ("streams", 60, 40)),
    ],
)
def test_numbers_that_follow_from_those_that_sliders_change_are_those_of_python(name, robots, tasks):
    """What a page was written for has other numbers of robots and tasks, and no events."""
    given = given_in_node(world(name))
    counts = {"robots.count": robots, "tasks.count": tasks, "run.steps": 40}
    scenario = world(name).replace(counts)
    if scenario.waits_for_names:
        scenario = scenario.with_flooding(world(name).flooding)
    assert_same(scenario, 1, given)
    if not why_fixed(scenario):
        assert_same(scenario.replace({"events": [{"step": 5, "robots": 3, "tasks": 2}]}), 1, given)


@pytest.mark.parametrize("name", WORLDS)
def test_the_hundred_swarms_are_those_of_any_world(name):
    assert_same_ends(world(name), 3 if name == "crowd" else 10)


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.quick(3)
def test_the_hundred_swarms_are_those_of_any_strategy(strategy):
    for robots in (13, 19, 60):
        counts = {"know_count": True, "count": robots}
        assert_same_ends(Scenario(decision={"strategy": strategy}, robots=counts), 10)


def assert_same_ends(scenario, runs):
    """Compare decisions and accounts of runs that stop with this processor's."""
    if not scenario.dynamic:
        scenario = scenario.replace({"run.stop_at_decision": True})
    decision, step, _, account = ended_in_node(scenario, 7, runs, 17)
    record = simulate_record(scenario, Runs(runs, 7, 0))
    np.testing.assert_array_equal(decision, record.decision)
    np.testing.assert_array_equal(step[decision >= 0], record.decision_step[decision >= 0])
    kept = [] if scenario.dynamic else [BITS_SENT, FEASIBLE_AT_END, INFEASIBLE_AT_END, LAST_STEP]
    np.testing.assert_array_equal(account[:, kept], record.account[:, kept])


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
    file = tmp_path / "dmmd.py"
    if text:
        file.write_text(text, encoding="utf-8")
    else:
        assert invoke("new", "strategy", str(file), "--knowledge").exit_code == 0
    own = Scenario(decision={"strategy": str(file)}, tasks={"count": 14}, run={"steps": 150})
    given = given_in_node(own)
    for tasks in (14, 26):
        assert_same(own.replace({"tasks.count": tasks}), 5, given)


def test_inboxes_that_lack_room_get_more():
    changes = {"robots.count": 400, "tasks.count": 10, "arena.side": 20.0, "run.steps": 60}
    assert_same(Scenario().replace(changes), 1)


def test_the_module_is_small():
    data = module(STRATEGIES["dmmd"])
    assert len(data) <= 145_000
    assert len(gzip.compress(data)) <= 61_000


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
    options = ["-target", WEBASSEMBLY.target, "-c", "-o", str(tmp_path / "places.o"), "-I", str(SOURCES)]
    command = [*zig().command, *options, str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len(lines) > 200
