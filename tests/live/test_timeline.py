"""Time in both directions, and what lies ahead: always what the run itself does."""

from __future__ import annotations

import numpy as np
import pytest
from declaring import declaring
from playing import looked, swarm_at

from feasibee import Scenario, Swarm, simulate
from feasibee.live import timeline
from feasibee.live.timeline import CHANGES_LIMIT, SHOWN, Outlook, Timeline, advance_together
from feasibee.simulation.snapshot import FLAGS

WORLDS = {
    "the paper's": {},
    "of knowledge": {"decision.strategy": "census", "faults.stopped": 0.2, "faults.stop_step": 60},
    "of robots that act": {"acting.start": 30, "acting.hold": "tag"},
    "of 1,500 robots": {"robots.count": 1500, "tasks.count": 1400, "arena.side": 170.0},
}


def look(swarm):
    return [
        swarm.step,
        *swarm.first_decision,
        swarm.bits_sent,
        *(each.tobytes() for each in swarm.snapshot()),
    ]


@pytest.mark.parametrize("world", WORLDS)
def test_any_step_is_reached_from_any_other(world, monkeypatch):
    monkeypatch.setattr(timeline, "WORK", 20 * Scenario().replace(WORLDS[world]).robots.count)
    scenario = Scenario().replace(WORLDS[world])
    there = Timeline(Swarm(scenario, 4))
    steps = [150, 149, 20, 19, 0, 77, 121, 40]
    fresh, expected = Swarm(scenario, 4), {}
    for step in sorted(steps):
        fresh.advance(step - fresh.step)
        expected[step] = look(fresh)
    for step in steps:
        there.rewind(step)
        assert step - there.swarm.step < 20 or step == 150
        there.advance(step)
        assert look(there.swarm) == expected[step]
    assert there.saved == [0, 20, 40, 60, 80, 100, 120, 140]


def test_copies_stay_within_their_room(monkeypatch):
    monkeypatch.setattr(timeline, "WORK", 1)
    swarm = Swarm(Scenario(), 4)
    room = 10 * swarm.save().nbytes
    there = Timeline(swarm, room)
    assert there.spacing == timeline.LEAST
    there.advance(1000)
    assert there.saved == list(range(0, 1000, 128))
    assert there.spacing == 128
    there.rewind(999)
    assert swarm.step == 1000 - 1000 % 128
    none = Timeline(Swarm(Scenario(), 4), room=0)
    none.advance(300)
    assert none.saved == [0]
    none.rewind(299)
    assert none.swarm.step == 0


def test_two_runs_stay_in_step():
    both = [Timeline(Swarm(Scenario(decision={"strategy": each}), 4)) for each in ("dmmd", "census")]
    assert not advance_together(both, 200_000, 0.01)
    assert both[0].swarm.step == both[1].swarm.step > 0
    assert advance_together(both, both[0].swarm.step + 3, 10.0)


def changes_of(swarm, robot, last):
    """Return the changes of a robot, found by a look at each step."""
    found = []
    for step in range(last + 1):
        swarm.advance(step - swarm.step)
        flags = swarm.robot(robot).flags & SHOWN
        if not found or found[-1][1] != flags:
            found.append((step, flags))
    return found


@pytest.mark.parametrize("world", [*WORLDS, "that declares"])
def test_the_outlook_is_what_the_run_does(world, tmp_path):
    last = 90
    if world in WORLDS:
        scenario = Scenario(run={"steps": last}).replace(WORLDS[world])
    else:
        scenario = declaring(tmp_path, quiet=20.0, faults={"byzantine": 0.2}, run={"steps": last})
    outlook, expected = Outlook(Swarm(scenario, 1), last), simulate(scenario, 1, 1)
    while not outlook.look(0.02):
        pass
    assert outlook.decision_step == expected.decision_step[0]
    end = swarm_at(last, scenario, 1)
    stopped = [each for each in range(20) if not end.robot(each).flags >> FLAGS.index("working") & 1]
    assert bool(stopped) == bool(scenario.faults.stopped)
    for robot in (3, 11, *stopped[:2]):
        outlook.follow(robot)
        assert not outlook.done
        while not outlook.look(0.02):
            pass
        found = outlook.to_dict(0)
        assert found["changes"] == changes_of(Swarm(scenario, 1), robot, last)
        assert outlook.to_dict(2)["changes"] == found["changes"][2:]
        assert found["decision"] == expected.decision_step[0]
        assert found["allTaken"] == (expected.all_taken_step[0] if scenario.acts else -1)
        assert found["declaration"] == (expected.declare_step[0] if scenario.manifest.declares else -1)
        assert len(found["changes"]) > 2


@pytest.mark.slow
def test_the_outlook_ends_with_the_run_however_many_changes():
    scenario = Scenario(run={"steps": 30_000}, decision={"exploration": 1.0, "gain": 1.0})
    outlook = Outlook(Swarm(scenario, 1), 30_000)
    changes = looked(outlook, 0)["changes"]
    assert len(changes) == CHANGES_LIMIT
    assert outlook.decision_step >= 0
    assert np.all(np.diff([step for step, _ in changes]) > 0)
