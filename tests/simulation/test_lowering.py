"""The numbers of a scenario that the engine takes; that they are right, the conformance suite says."""

from __future__ import annotations

import math

import pytest

from feasibee import Scenario
from feasibee.base.codes import exact
from feasibee.engine.params import PARAMS, Lie, Params, Placement, packed
from feasibee.scenario.fields import Declare, Faults, Placed
from feasibee.simulation.lowering import MOST_ROBOTS, lower


def params_of(seed=0, **sections):
    return lower(Scenario(**sections), seed).params


@pytest.mark.parametrize(("boundary", "bits"), [("torus", 32), ("walls", 31)])
def test_the_longer_side_is_a_power_of_two_units(boundary, bits):
    """Within walls 2**31, so that no difference of coordinates wraps in 32 bits."""
    arena = params_of(arena={"side": [20.0, 10.0], "boundary": boundary}).arena
    assert (arena.width, arena.height) == (2**bits, 2 ** (bits - 1))


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
