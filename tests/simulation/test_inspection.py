"""What `Swarm.robot` says is what the reference's robot knows; `restore` returns to the very step."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import FeasibeeError, Scenario, Swarm
from feasibee.reference.swarm import play
from feasibee.simulation.snapshot import FLAGS

WORLDS = {
    "the paper's": {},
    "many messages": {"decision.inbox": "every-message", "radio.loss": 0.2},
    "with values": {"decision.strategy": "dc"},
    "of 50 robots": {"robots.count": 40, "tasks.count": 30, "decision.gain": 40.0, "radio.range": 8.0},
    "with memory": {"decision.strategy": "bayes", "decision.inbox_size": 2, "faults.byzantine": 0.2},
    "of knowledge": {
        "robots.count": 8,
        "tasks.count": 5,
        "decision.strategy": "census",
        "faults.stopped": 0.2,
        "faults.stop_step": 20,
    },
    "that declares": {"decision.strategy": "quiet-census", "robots.know_count": True},
    "with classes": {
        "robots.classes": [{"name": "arm", "count": 9, "skills": ["lift"]}, {"name": "eye", "count": 4}],
        "tasks.classes": [{"name": "carry", "count": 3, "needs": {"lift": 2}}],
    },
}


def known_to(robot):
    """Return what a robot of the reference knows, in the words of `RobotState`."""
    mind = robot.mind
    flags = {
        "feasible": mind.opinion == 1,
        "neutral": mind.opinion == -1,
        "disseminating": mind.disseminating,
        "declared": mind.declared != -1,
    }
    messages = [*mind._latest.values(), *mind._messages]
    feasible = sum(each.opinion for each in messages)
    return {
        "flags": flags,
        "phase_left": mind.phase_left,
        "robots_seen": tuple(mind.robots_seen),
        "tasks_seen": tuple(mind.tasks_seen),
        "feasible_quality": mind.feasible_quality,
        "votes": (feasible, len(messages) - feasible),
        "heard": tuple(sorted((sender, each.opinion, each.value) for sender, each in mind._latest.items())),
        "memory": tuple(mind._memory),
        "knowledge": tuple(mind.knowledge.words) if mind.knowledge else (),
    }


@pytest.mark.parametrize("world", WORLDS)
def test_a_robot_of_the_engine_knows_what_one_of_the_reference_knows(world):
    scenario = Scenario(run={"steps": 40}).replace(WORLDS[world])
    swarm = Swarm(scenario, 3, 2)
    for step, reference in enumerate(play(scenario, 3, 2)):
        if step:
            swarm.advance()
        for number, robot in enumerate(reference.robots):
            found, expected = swarm.robot(number), known_to(robot)
            if not robot.works(step):
                assert not found.flags >> FLAGS.index("working") & 1
                continue
            for name, value in expected.pop("flags").items():
                assert bool(found.flags >> FLAGS.index(name) & 1) == value, (step, number, name)
            if scenario.manifest.knowledge:
                for name in ("robots_seen", "tasks_seen", "votes", "heard", *["knowledge"] * (not step)):
                    del expected[name]  # the engine keeps its knowledge only
            assert {name: getattr(found, name) for name in expected} == expected, (step, number)
        assert swarm.step == step
    assert swarm.step == 40


SCENARIO = Scenario(
    robots={"arrival_rate": 0.05, "failure_rate": 0.005},
    tasks={"arrival_rate": 0.3, "lifetime": 60.0},
    events=[{"step": 0, "tasks": 2}, {"step": 30, "robots": -6}, {"step": 50, "tasks": -9}],
    decision={"strategy": "census"},
    run={"steps": 200},
)
FAULTY = SCENARIO.replace({"faults.byzantine": 0.2, "faults.stopped": 0.2, "faults.stop_step": 20})
EVENTS = Scenario(
    events=[{"step": 30, "tasks": 60}, {"step": 60, "tasks": -70}], decision={"strategy": "census"}
)
RESTORED = {name: Scenario(run={"steps": 130}).replace(changes) for name, changes in WORLDS.items()} | {
    "of 1,500 robots": Scenario(
        robots={"count": 1500}, tasks={"count": 1400}, arena={"side": 170.0}, run={"steps": 130}
    ),
    "that changes": SCENARIO,
    "that changes, with faults": FAULTY,
    "that changes, with a roster": SCENARIO.replace({"decision.strategy": "roster"}),
    "with events": EVENTS,
    "with events, of 40 robots": EVENTS.replace({"robots.count": 40}),
}


@pytest.mark.parametrize("world", RESTORED)
def test_restore_returns_to_the_step_that_was_saved(world):
    """Catches what isn't saved, be it shown or only used to go on: what robots see after a restored step."""
    swarm, kept = Swarm(RESTORED[world], 3, 2), []
    for step in (0, 29, 40, 51, 120):
        swarm.advance(step - swarm.step)
        saved, there = swarm.save(), look(swarm)
        assert saved.step == step
        assert saved.nbytes > 100 * swarm.present.sum()
        swarm.advance(10)
        kept.append((saved, there, look(swarm)))
    for saved, there, later in reversed(kept):
        swarm.restore(saved)
        assert_same(look(swarm), there)
        swarm.advance(0)
        assert_same(look(swarm), there)
        swarm.advance(10)
        assert_same(look(swarm), later)


def look(swarm):
    """Return all that a swarm shows at its step."""
    arrays = (
        *("positions", "headings", "present", "tasks", "task_numbers", "opinions", "counted", "knowledge"),
        *("truths", "robot_counts", "task_counts", "counted_counts", "feasible_counts"),
    )
    outcomes = [swarm.step, swarm.truth, swarm.decision, swarm.bits_sent, swarm.declaration_step]
    return [
        *(np.array(getattr(swarm, name)) for name in arrays),
        *swarm.snapshot(),
        *swarm.task_places(),
        [*outcomes, *swarm.first_decision, *swarm.declared_counts],
        [swarm.robot(int(each)) for each in np.flatnonzero(swarm.present)[::7]],
    ]


def assert_same(one, other):
    for mine, yours in zip(one, other, strict=True):
        if isinstance(mine, np.ndarray):
            np.testing.assert_array_equal(mine, yours)
        else:
            assert mine == yours


@pytest.mark.parametrize("number", [-1, 20, 0.5, True, None])
def test_a_robot_that_is_not_there_is_an_error(number):
    with pytest.raises(FeasibeeError, match=r"robot = .* must be a whole number from 0 to 19|robot"):
        Swarm().robot(number)
