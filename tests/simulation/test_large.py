"""Large swarms: sorted in space, in cells and inboxes of their own, by any number of threads: the same bytes.

The hashes are those of an engine that kept robots in the order of their numbers and used one thread
(version 0.1.0, commit 6e68fbb8). Those of bodies that deflect are of one that tested bodies pair by pair
(commit 90e53491). Those of first sight are of today's engine with ``in_space_order`` false. The reference
would take minutes here; it meets the engine in smaller swarms of the conformance suite.
"""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path

import numpy as np
import pytest

from feasibee import Scenario, Swarm
from feasibee.base.errors import FeasibeeError
from feasibee.base.record import COLUMNS
from feasibee.engine import runner
from feasibee.engine.state import Room, State
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.lowering import lower

HASHED = tuple(COLUMNS)[: COLUMNS["last_step"]]
"""The outcomes that are hashed; in worlds that don't change, the later ones are 0."""
HASHES = json.loads((Path(__file__).parent / "large_bytes.json").read_text(encoding="utf-8"))
BODIES = {"arena.boundary": "walls", "robots.avoid_collisions": True, "robots.diameter": 0.6}
LIARS = {"faults.byzantine": 0.2, "faults.byzantine_says": "random"}
WORLDS = {
    "paper": {},
    "values": {"decision.strategy": "dc"},
    "bayes": {"decision.strategy": "bayes"},
    "every message": {"decision.inbox": "every-message"},
    "listens late": {"decision.listen": "dissemination"},
    "dense": {"sensing.range": 4.0, "radio.range": 8.0},
    "walls and bodies": BODIES,
    "bodies that deflect": {**BODIES, "robots.contact": "deflect"},
    "loss": {"radio.loss": 0.3},
    "unique": {"sensing.observation": "unique"},
    "unique, with misses": {"sensing.observation": "unique", "sensing.miss": 0.2},
    "short ids": {"radio.id_bits": 6, "decision.inbox_size": 2},
    "faults": {**LIARS, "faults.stopped": 0.1, "faults.stop_step": 11, "faults.stubborn": 0.1},
    "commits": {"decision.declare": {}},
    "false tasks": {"sensing.false_tasks": 0.3},
    "clusters": {"robots.placement": "clusters"},
    "first sight": {"decision.start": "first-sight"},
}


def scenario_of(world, robots, steps):
    """Return a world at the density of the paper's swarm; the rectangle is twice as wide as high."""
    side = math.sqrt(20.0 * robots)
    sides = [side * math.sqrt(2.0), side / math.sqrt(2.0)] if world == "rectangle" else side
    tables = {"robots.count": robots, "tasks.count": robots, "arena.side": sides, "run.steps": steps}
    return Scenario().replace({**tables, **WORLDS.get(world, {})})


def digest(record):
    """Return a hash of all outcomes of runs."""
    hashed = hashlib.sha256()
    for name in ("decision", "decision_step", "feasible_count", "infeasible_count", *HASHED):
        hashed.update(np.ascontiguousarray(getattr(record, name)).astype(np.int64).tobytes())
    return hashed.hexdigest()[:16]


def outcome(world, robots, steps, threads):
    """Return the hash of a run."""
    scenario = scenario_of(world, robots, steps)
    return digest(simulate_record(scenario, Runs(1, 3), curves=True, threads=threads))


@pytest.mark.parametrize("world", HASHES["1100"])
def test_robots_in_the_order_of_space_give_the_same_bytes(world):
    assert outcome(world, 1100, 60, threads=1) == HASHES["1100"][world]


@pytest.mark.quick(6)
@pytest.mark.parametrize("threads", [1, 3, 7])
@pytest.mark.parametrize("world", HASHES["4500"])
def test_any_number_of_threads_gives_the_same_bytes(world, threads, monkeypatch):
    monkeypatch.setattr(runner, "ROBOTS_A_THREAD", 500)
    assert runner.team_size(lower(scenario_of(world, 4500, 40), 3).params, 1, threads) == threads
    assert outcome(world, 4500, 40, threads) == HASHES["4500"][world]


def test_runs_one_after_another_by_several_threads_give_the_same_bytes():
    scenario = scenario_of("short ids", 4500, 15)
    together = simulate_record(scenario, Runs(3, 5), curves=True, threads=2)
    assert runner.team_size(lower(scenario, 5).params, 3, 2) == 2
    assert digest(together) == digest(simulate_record(scenario, Runs(3, 5), curves=True, threads=1))


@pytest.mark.parametrize(
    ("robots", "runs", "threads", "team"),
    [
        (4000, 1, 8, 1),  # too few robots to share
        (4500, 1, 2, 2),
        (4500, 1, 64, 4),  # at least 1,000 robots a thread
        (10_000, 1, 8, 8),
        (10_000, 8, 8, 1),  # runs side by side
        (10_000, 9, 8, 8),  # side by side, the ninth would leave seven threads idle
        (4500, 3, 16, 4),
    ],
)
def test_threads_share_a_swarm_where_that_is_faster(robots, runs, threads, team):
    assert runner.team_size(lower(scenario_of("paper", robots, 10), 3).params, runs, threads) == team


def test_a_swarm_tells_of_its_robots_in_the_order_of_their_numbers():
    scenario = scenario_of("paper", 1025, 20)
    swarm, other = Swarm(scenario, seed=3), Swarm(scenario, seed=3)
    swarm.advance(1)
    start = swarm.positions
    swarm.advance(11)  # past the next sort
    way = np.abs(swarm.positions - start)
    way = np.minimum(way, scenario.arena.size[0] - way)
    assert np.hypot(*way.T).max() <= 11 * scenario.robots.speed + 1e-6
    other.advance(12)
    np.testing.assert_array_equal(swarm.positions, other.positions)
    np.testing.assert_array_equal(swarm.snapshot().flags, other.snapshot().flags)
    assert swarm.opinions.sum() == swarm.feasible_count


@pytest.mark.parametrize("robots", [130, 1100])
def test_a_run_without_room_for_its_inboxes_is_played_again(robots, monkeypatch):
    scenario = scenario_of("dense", robots, 60).replace({"decision.strategy": "dc", "radio.loss": 0.1})
    expected = digest(simulate_record(scenario, Runs(2, 3), curves=True))
    lacked, enlarged = set(), State.enlarged

    def more(state):
        lacked.add(state.struct.clock.full)
        return enlarged(state)

    monkeypatch.setattr(Room, "first", lambda params: Room(8, 1))
    monkeypatch.setattr(State, "enlarged", more)
    assert digest(simulate_record(scenario, Runs(2, 3), curves=True, threads=1)) == expected
    assert lacked == {1, 2}  # slots, and tables


def test_few_tables_suffice_for_a_large_swarm():
    params = lower(scenario_of("paper", 10_000, 10), 0).params
    assert Room.first(params).tables < 2000


FAILING = """
def quality(robots_seen, tasks_seen):
    return 2.0 if robots_seen > 12 else 0.5


def decide(mind, inbox):
    return mind.opinion
"""


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_an_error_in_one_thread_ends_all(tmp_path, threads):
    file = tmp_path / "failing.py"
    file.write_text(FAILING, encoding="utf-8")
    scenario = scenario_of("paper", 4500, 200).replace({"decision.strategy": str(file)})
    with pytest.raises(FeasibeeError, match="quality"):
        simulate_record(scenario, Runs(1, 3), threads=threads)
