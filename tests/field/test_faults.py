"""Faults on purpose: a field ends cleanly, says what happened, and its logs replay to the bit."""

from __future__ import annotations

import json

import pytest
from fields import NEEDS_GROUPS, a_plan, run, small

from feasibee.base.errors import FeasibeeError
from feasibee.field.node import replay
from feasibee.field.plan import Fault, parse_fault, parse_length, schedule

pytestmark = NEEDS_GROUPS
BUSY = 3.0
"""Seconds of silence after which a robot is lost: none that only waits for a busy machine."""


def planned(scenario, **options):
    faults = [parse_fault(kind, text, 10.0) for kind, text in options.items()]
    return tuple(schedule(faults, scenario.robots.count, scenario.run.steps))


@pytest.mark.slow
def test_killed_and_stopped_robots_are_lost_and_their_logs_replay(tmp_path):
    scenario = small(robots=6)
    faults = planned(scenario, kill="2@10", pause="1@20")
    result, events, steps = run(a_plan(scenario, faults=faults, patience=BUSY), tmp_path)
    assert result["lost"] == [3, 4, 5]
    ends = [(each["event"], each["robot"], each["step"]) for each in events if "robot" in each]
    assert sorted(ends) == [("died", 4, 10), ("died", 5, 10), ("lost", 3, 20)]
    assert len(steps) == 41
    replays = [replay(tmp_path / f"robot-{number}.jsonl") for number in range(6)]
    assert [each.steps for each in replays] == [40, 40, 40, 19, 9, 9]
    held = [mind[0] for mind in steps[-1]["minds"]]
    assert [{"feasible": 1, "infeasible": 0}[each.opinion] for each in replays[:3]] == held[:3]


@pytest.mark.slow
def test_a_stopped_robot_that_goes_on_takes_part_again(tmp_path):
    scenario = small(robots=5, steps=500)
    faults = (Fault(20, "pause", 1, (4,)), Fault(300, "resume", 1, (4,)))
    plan = a_plan(scenario, lockstep=False, faults=faults, patience=BUSY, hz=50.0)
    result, events, _ = run(plan, tmp_path)
    assert [event["robot"] for event in events if event["event"] in ("lost", "back")] == [4, 4]
    assert result["lost"] == []
    assert replay(tmp_path / "robot-4.jsonl").steps > 100


def test_a_partition_cuts_the_radio_between_the_halves(tmp_path):
    scenario = small(robots=4, steps=30, **{"arena.side": 4.0})
    run(a_plan(scenario, faults=planned(scenario, partition="2s@1")), tmp_path)
    for number in range(4):
        lines = (tmp_path / f"robot-{number}.jsonl").read_text().splitlines()[1:]
        senders = [{each[0] for each in json.loads(line)["heard"]} for line in lines]
        assert not any(sender // 2 != number // 2 for heard in senders[:20] for sender in heard)
        assert any(sender // 2 != number // 2 for heard in senders[20:] for sender in heard)


@pytest.mark.slow
def test_a_field_of_all_faults_ends_and_its_logs_replay(tmp_path):
    scenario = small(robots=8, steps=200)  # 10 s: robots are lost after 1.5 and 2 s, and 3 s more
    faults = planned(scenario, kill="3@30", pause="1@40", partition="2s@50")
    clocks = {"hz": 20.0, "delay": 2.0, "drift": 0.05, "jitter": 0.2}
    plan = a_plan(scenario, False, faults=faults, patience=BUSY, **clocks)
    result, events, _ = run(plan, tmp_path)
    assert result["lost"] == [4, 5, 6, 7]
    happened = [event["kind"] for event in events if event["event"] == "fault"]
    assert happened == [fault.kind for fault in faults]
    assert all(replay(tmp_path / f"robot-{number}.jsonl").steps > 0 for number in range(8))


def test_robots_that_dont_join_are_named(tmp_path):
    with pytest.raises(FeasibeeError, match=r"robots 0, 1, 2, 3: did not join within 0\.3 s"):
        run(a_plan(small(), wait=0.3), tmp_path, starts_robots=False)


@pytest.mark.parametrize(
    "option", ["kill 3", "kill @5", "kill 0@5", "kill 3@5:2s", "partition 5x@1", "pause 1@x"]
)
def test_an_invalid_fault_is_an_error(option):
    kind, text = option.split()
    with pytest.raises(FeasibeeError, match=f"^--{kind} .*(must|such)"):
        parse_fault(kind, text, 10.0)


def test_a_time_is_in_steps_seconds_or_milliseconds():
    assert [parse_length("--delay", text, 10.0) for text in ("3", "2s", "250ms")] == [3.0, 20.0, 2.5]


def test_a_pause_ends_after_its_time_unless_the_field_ends_before():
    faults = [parse_fault("pause", text, 10.0) for text in ("1@5:2500ms", "2@6:100", "1@7")]
    assert [each[:4] for each in schedule(faults, 5, 30)] == [
        (5, "pause", 1, (4,)),
        (6, "pause", 2, (2, 3)),
        (7, "pause", 1, (1,)),
        (30, "resume", 1, (4,)),
    ]


def test_faults_that_leave_no_robot_or_come_too_late_are_errors():
    with pytest.raises(FeasibeeError, match="use at most 3"):
        schedule([Fault(1, "kill", 4)], 4, 10)
    for step in (0, 11):
        with pytest.raises(FeasibeeError, match="from 1 to 10"):
            schedule([Fault(step, "kill", 1)], 4, 10)
