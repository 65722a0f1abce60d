"""Functions of knowledge in C whose limits no run of a test reaches: large totals, and ids misread."""

from __future__ import annotations

import ctypes
import random

import pytest

from feasibee.robot.knowledge import Knowledge
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Me, Thing
from tests.robot.driving import compiled

NAMES = ["tally", "estimate", "census", "quiet-census"]
"""Strategies in the order of numbers.c."""
GENERATOR_SEED = 17


@pytest.fixture(scope="module", params=["double", "whole"])
def library(request, tmp_path_factory):
    """Return the functions of numbers.c."""
    options = *(["-DFEASIBEE_DOUBLE"] if request.param == "double" else []), "-shared", "-fPIC"
    return ctypes.CDLL(str(compiled(tmp_path_factory.mktemp("numbers"), "numbers.c", *options)))


def number_of(draw, bits):
    """Return a random number of a random length, often just below a power of two."""
    length = draw.randrange(bits + 1)
    return max(0, draw.choice([draw.getrandbits(bits) >> (bits - length), 2**length - draw.randrange(4)]))


@pytest.mark.parametrize("name", NAMES[:2])
def test_totals_that_fill_their_word_are_kept_as_in_python(name, library):
    draw = random.Random(GENERATOR_SEED)
    setting = setting_from((20, 5), (0, 0), True, None, STRATEGIES[name].parameters.values())
    counts = (ctypes.c_double * 4)()
    for _ in range(2_000):
        robot = Knowledge(STRATEGIES[name], Me(0, 0, 1, 0, [], setting))
        robot.words[:2] = [min(number_of(draw, 31), 2**31 - 1) for _ in range(2)]
        is_robot = draw.random() < 0.5
        library.seen(NAMES.index(name), *robot.words[:2], is_robot, counts)
        robot.observe([Thing(is_robot, 0, 0, 0)])
        assert counts[:2] == robot.words[:2]
        exact = [sum(each) for each in robot.counted()]
        assert counts[2] * sum(exact) == pytest.approx(exact[0] * sum(counts[2:]), rel=1e-8)


@pytest.mark.parametrize("name", NAMES[2:])
@pytest.mark.parametrize("is_robot", [True, False])
def test_a_thing_whose_id_was_misread_is_not_kept(name, is_robot, library):
    number, limit = NAMES.index(name), 20 if is_robot else 40
    assert library.changed(number, is_robot, limit - 1) > 0
    for id_ in [*range(limit, limit + 100), -1, 2**31 - 1, -(2**31)]:
        assert library.changed(number, is_robot, id_) == 0
