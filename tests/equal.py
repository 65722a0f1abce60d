"""Engine and reference give the same runs, and the same swarm at each step."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from feasibee import Swarm, reference
from feasibee.base.record import Record
from feasibee.reference.swarm import play
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.snapshot import FLAGS

ARRAYS = tuple(each.name for each in dataclasses.fields(Record) if each.name != "first_run")


def assert_same(record, expected, what=""):
    """See that two records are equal."""
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(record, name), getattr(expected, name), f"{name} {what}")


def assert_equal(scenario, seed, runs=1, first_run=0):
    """See that engine and reference give the same runs; return their record."""
    which = Runs(runs, seed, first_run)
    record = simulate_record(scenario, which, curves=True)
    assert_same(record, reference.simulate(scenario, which, curves=True), scenario.to_toml())
    return record


def assert_same_swarms(scenario, runs):
    """See that swarms are the reference's at each step, also after a run's end; return its record."""
    both = []

    def watched(scenario, seed, run):
        swarm = Swarm(scenario, seed=seed, run=run)
        for plain in play(scenario, seed, run):
            both[:] = swarm, plain
            swarm.advance(int(plain.time > 0))
            assert_same_step(swarm, plain)
            yield plain

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reference.swarm, "play", watched)
        record = reference.simulate(scenario, runs, curves=True)
    swarm, plain = both
    while plain.time < scenario.run.steps:
        swarm.advance()
        plain.step()
        assert_same_step(swarm, plain)
    return record


def assert_same_step(swarm, plain):
    """See that a swarm is the reference's at this step."""
    robots, unit = plain.robots, float(plain.world.unit)
    there = [each.number for each in robots]
    np.testing.assert_array_equal(np.flatnonzero(swarm.present), there)
    np.testing.assert_array_equal(
        swarm.positions[there], np.reshape([each.place for each in robots], (-1, 2)) * unit
    )
    assert np.isnan(swarm.positions[~swarm.present]).all()
    np.testing.assert_array_equal(swarm.task_numbers, list(plain.tasks))
    np.testing.assert_array_equal(swarm.tasks, np.reshape([*plain.tasks.values()], (-1, 2)) * unit)
    own = sorted([*robots, *plain.away], key=lambda each: each.number)
    numbers = [each.number for each in own]
    np.testing.assert_array_equal(swarm.opinions[numbers], [each.mind.opinion for each in own])
    assert (np.delete(swarm.opinions, numbers) == -1).all()
    speaking = {each.number for each in robots if each.mind.disseminating and each.works(plain.time)}
    assert set(np.flatnonzero(swarm.disseminating & swarm.present)) == speaking  # the stopped are silent
    assert set(np.flatnonzero(swarm.counted)) == {each.number for each in plain.counted}
    declared = swarm.declared
    np.testing.assert_array_equal(declared[numbers], [each.mind.declared for each in own])
    np.testing.assert_array_equal(swarm.snapshot().flags >> FLAGS.index("declared") & 1, declared >= 0)
    assert swarm.declared_counts == (plain.declared(1), plain.declared(0))
    assert swarm.truth == swarm.truths[-1] == plain.truth
    counts = swarm.robot_counts[-1], swarm.task_counts[-1], swarm.counted_counts[-1]
    assert counts == (len(plain.present), len(plain.tasks), len(plain.counted))
    assert (swarm.feasible_count, swarm.infeasible_count) == (plain.feasible_count, plain.infeasible_count)
    assert (swarm.bits_sent, swarm.decision) == (plain.bits_sent, plain.decision)
    for robot in plain.robots:
        assert_same_robot(swarm, plain, robot)
    if plain.work:
        np.testing.assert_array_equal(swarm.targets[there], [each.errand.target for each in robots])
        standing = {each.number for each in robots if each.errand.task != -1}
        assert set(np.flatnonzero(swarm.standing)) == standing


def assert_same_robot(swarm, plain, robot):
    """See that what a swarm tells of a robot is what the reference's robot knows."""
    found, mind = swarm.robot(robot.number), robot.mind
    flags = {name for bit, name in enumerate(FLAGS) if found.flags >> bit & 1}
    assert ("working" in flags) == robot.works(plain.time)
    if not robot.works(plain.time):
        return
    inside = {
        "feasible": mind.opinion == 1,
        "neutral": mind.opinion == -1,
        "disseminating": mind.disseminating,
        "declared": mind.declared != -1,
    }
    assert {name: name in flags for name in inside} == inside
    assert found.phase_left == mind.phase_left
    np.testing.assert_array_equal(found.memory, mind._memory)
    assert found.feasible_quality == mind.feasible_quality
    if mind.knowledge:  # the engine keeps what it knows, and no counts; at step 0 zeros
        assert plain.time == 0 or found.knowledge == tuple(mind.knowledge.words)
        return
    messages = [*mind._latest.values(), *mind._messages]
    feasible = sum(each.opinion for each in messages)
    heard = sorted((sender, each.opinion, each.value) for sender, each in mind._latest.items())
    assert found.votes == (feasible, len(messages) - feasible)
    assert found.heard == tuple(heard)
    assert (found.robots_seen, found.tasks_seen) == (tuple(mind.robots_seen), tuple(mind.tasks_seen))
