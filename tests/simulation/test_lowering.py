"""The numbers of a scenario that the engine takes."""

from __future__ import annotations

import math

import pytest

from feasibee import Scenario
from feasibee.engine.params import ALWAYS, PARAMS, WHILE_DISSEMINATING, Lie, Params, Placement, packed
from feasibee.model.codes import exact
from feasibee.scenario.fields import Declare, Faults, Placed
from feasibee.simulation.lowering import MOST_ROBOTS, lower, unit_of


def params_of(seed=0, **sections):
    return lower(Scenario(**sections), seed).params


def test_the_longer_side_is_2_to_32_units_on_a_torus():
    arena = params_of(arena={"side": [20.0, 10.0]}).arena
    assert (arena.width, arena.height) == (2**32, 2**31)
    assert not arena.wraps
    assert params_of().arena.wraps


def test_the_longer_side_is_2_to_31_units_within_walls():
    """So that no difference of coordinates wraps in 32 bits."""
    arena = params_of(arena={"side": [20.0, 10.0], "boundary": "walls"}).arena
    assert (arena.width, arena.height) == (2**31, 2**30)
    assert arena.wraps


@pytest.mark.parametrize("boundary", ["torus", "walls"])
def test_lengths_are_in_these_units(boundary):
    scenario = Scenario(arena={"boundary": boundary}, robots={"diameter": 2.5, "speed": 0.625, "spread": 5.0})
    robots, unit = lower(scenario, 0).params.robots, unit_of(scenario)
    assert robots.radius == 1.25 / unit
    assert robots.reach == 0.625 / unit
    assert robots.apart_limit == (2.5 / unit) ** 2
    assert robots.placement.spread == 5.0 / unit


def test_each_range_has_a_limit_of_its_own():
    params, unit = params_of(sensing={"range": 2.5}, radio={"range": 5.0}), 20.0 / 2**32
    assert params.sensing.limit == (2.5 / unit) ** 2 + 1
    assert params.radio.limit == (5.0 / unit) ** 2 + 1


def test_a_seed_is_two_words():
    seed = params_of(seed=2**63 + 5).seed
    assert (seed.low, seed.high) == (5, 2**31)


def test_a_probability_is_a_number_of_2_to_32():
    params = params_of(sensing={"miss": 0.25}, radio={"loss": 1.0})
    assert (params.sensing.miss, params.radio.loss) == (2**30, 2**32)


def test_listening_is_a_number_of_steps_or_a_code():
    for listen, number in (("always", ALWAYS), ("dissemination", WHILE_DISSEMINATING), ({"last": 7}, 7)):
        assert params_of(decision={"listen": listen}).decision.listens_for == number


def test_every_word_of_a_scenario_has_its_code():
    for word in Faults.model_fields["byzantine_says"].annotation.__args__:
        assert Lie(params_of(faults={"byzantine_says": word}).faults.byzantine_says).name == word.upper()
    words = Placed.model_fields["placement"].annotation.__args__
    assert [each.name for each in Placement] == [word.upper() for word in words]


@pytest.mark.parametrize("most", [20, 33, 100, 1_000_000])
@pytest.mark.parametrize("threshold", [0.5, 0.9, 2 / 3, 0.5666666666666667, 0.9000000000000001, 1 - 2**-53])
def test_the_quorums_fraction_rounds_down_as_the_threshold_for_every_number_of_robots(threshold, most):
    share, whole = params_of(robots={"count": most}, decision={"threshold": threshold}).decision.quorum
    assert whole <= MOST_ROBOTS
    for counted in {*range(min(most, 300)), most // 2, most - 1, most}:
        assert counted * share // whole == math.floor(exact(threshold) * counted), counted


def test_a_rule_to_declare_is_a_ratio_of_whole_numbers():
    commit = params_of(decision={"declare": Declare(quorum=0.7, rounds=2, heard=4)}).decision.declare
    assert tuple(commit) == (True, 7, 10, 2, 4)
    assert not params_of().decision.declare.enabled


def test_packing_keeps_every_number_at_its_name():
    params = params_of(seed=7, faults={"byzantine": 0.2}, decision={"declare": Declare()})
    record = packed(params)

    def compare(record, numbers):
        for name in numbers._fields:
            number = getattr(numbers, name)
            if hasattr(number, "_fields"):
                compare(record[name], number)
            else:
                assert record[name] == number, name

    compare(record, params)
    assert PARAMS.names == Params._fields
