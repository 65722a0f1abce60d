"""Names of tasks at noisy positions, compared with a gate (model.md 6.24)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from feasibee import Scenario, Swarm, reference, simulate
from feasibee.simulation.lowering import lower
from feasibee.studies.needs import noisy_names_in_words

NOISY = {"arena.side": 10.0, "run.steps": 40, "sensing.position_error": 0.1, "decision.strategy": "census"}


ROW = {
    "robots.count": 1,
    "robots.speed": 0.0,
    "robots.placement": "points",
    "robots.points": [[5.0, 5.0]],
    "tasks.placement": "points",
    "tasks.points": [[4.62, 5.0], [5.7, 5.0], [5.0, 5.0], [4.81, 5.0], [5.19, 5.0]],
    "decision.strategy": "census",
    "decision.exploration": 1e6,
}


@pytest.mark.parametrize(
    ("error", "gate", "names"),
    [
        (0.046, None, [0, 1, 0, 0, 0]),  # 8 - 3.75 deviations are 0.1955; the whole chain is longer
        (0.04, 0.3, [0, 1, 2, 3, 4]),
        (0.1, 0.9, [0, 0, 0, 0, 0]),
        (0.1, 0.2, [0, 1, 2, 3, 4]),
    ],
)
def test_tasks_in_a_chain_of_short_gaps_have_the_name_of_the_lowest(error, gate, names):
    scenario = Scenario().replace({**ROW, "sensing.position_error": error, "sensing.gate": gate})
    swarm = reference.Swarm(scenario, 3, 0)
    swarm.step()
    seen = [thing for thing, _ in swarm.sightings(swarm.robots[0])]
    marks = [swarm.names.task(name, 0, 0.0, 0.0).hash for name in names]
    right = [(name, mark, ROW["tasks.points"][name][0]) for name, mark in zip(names, marks, strict=True)]
    found = [(thing.id % 5, thing.hash if thing.id < 5 else None, round(thing.x, 6)) for thing in seen]
    assert [each[0] for each in found] == names
    assert all(each == own for each, own in zip(found, right, strict=True) if each[1] is not None)


def test_on_a_torus_a_chain_may_cross_the_edge_and_the_engine_finds_it_among_many():
    random = np.random.default_rng(5)
    spots = [[0.05, 3.0], [19.95, 3.0], [3.0, 0.02], [3.0, 19.9], *random.uniform(0, 20, (296, 2)).tolist()]
    scenario = Scenario().replace(
        {
            "tasks.placement": "points",
            "tasks.points": spots,
            "decision.strategy": "census",
            "sensing.position_error": 0.06,
        }
    )
    swarm = Swarm(scenario, 1)
    names = swarm._state.array("names", len(spots)).tolist()
    assert names == [*reference.Swarm(scenario, 1, 0)._called.values()]
    assert (names[1], names[3]) == (0, 2)
    assert 100 < len(set(names)) < 298


def test_looks_beyond_the_gate_give_wrong_names_in_addition_to_misname():
    sensing = Scenario().replace({**NOISY, "sensing.gate": 0.3, "sensing.misname": 0.2}).sensing
    assert sensing.wrong == pytest.approx(1 - 0.8 * (1 - math.exp(-(3**2) / 4)), rel=1e-8)
    alone = Scenario().replace({**NOISY, "sensing.gate": 0.3})
    assert lower(alone, 1).params.sensing.misname == pytest.approx(2**32 * math.exp(-9 / 4), rel=1e-8)
    assert alone.setting.task_ids == 40


@pytest.mark.quick(3)
def test_a_census_holds_merged_tasks_for_one_and_so_too_many_for_feasible():
    world = Scenario().replace({"decision.strategy": "census", "tasks.count": 21, "run.steps": 600})
    noisy = (world.replace({"sensing.position_error": error}) for error in (0.0, 0.2))
    shares = [(simulate(each, 60, 1).feasible_at_end.values > 10).mean() for each in noisy]
    assert shares[0] < 0.05
    assert shares[1] > 0.5


def test_without_errors_a_gate_changes_nothing():
    scenario = Scenario().replace({"decision.strategy": "census", "run.steps": 60})
    found = [simulate(each, 3, 1) for each in (scenario, scenario.replace({"sensing.gate": 0.5}))]
    for name in ("decision_step", "bits_sent", "feasible_at_end"):
        np.testing.assert_array_equal(*(getattr(each, name).values for each in found))


@pytest.mark.parametrize(
    ("changes", "lines"),
    [
        ({"sensing.position_error": 0.05}, ["0.067 pairs of tasks on average are at most 0.212 units apart"]),
        ({"sensing.position_error": 0.05, "sensing.gate": 0.3}, ["One look in 8,103"]),
        ({"sensing.position_error": 0.01}, []),
        ({"sensing.gate": 0.3}, []),
        ({"sensing.position_error": 0.2, "decision.strategy": "tally"}, []),
    ],
)
def test_an_assessment_warns_of_names_that_are_merged_or_wrong(changes, lines):
    found = noisy_names_in_words(Scenario().replace({"decision.strategy": "census", **changes}))
    assert [line in each for line, each in zip(lines, found, strict=True)] == [True] * len(lines)
