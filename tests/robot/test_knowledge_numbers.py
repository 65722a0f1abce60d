"""Functions of knowledge in C whose limits no run of a test reaches: large totals and counts."""

from __future__ import annotations

import ctypes
import random

import pytest

from feasibee.robot.firmware import needs_double
from feasibee.robot.knowledge import Knowledge
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES, totals
from feasibee.strategies.contract import Me, Thing
from tests.robot.driving import compiled

NAMES = ["tally", "estimate", "totals", "census", "quiet-census", "roster-turns"]
"""Strategies in the order of numbers.c."""
GENERATOR_SEED = 17


@pytest.fixture(scope="module", params=["double", "whole"])
def library(request, tmp_path_factory):
    """Return the functions of numbers.c."""
    options = *(["-DFEASIBEE_DOUBLE"] if request.param == "double" else []), "-shared", "-fPIC"
    library = ctypes.CDLL(str(compiled(tmp_path_factory.mktemp("numbers"), "numbers.c", *options)))
    library.kept.restype = ctypes.c_double
    library.is_double = request.param == "double"
    return library


def number_of(draw, bits):
    """Return a random number of a random length, often just below a power of two."""
    length = draw.randrange(bits + 1)
    return max(0, draw.choice([draw.getrandbits(bits) >> (bits - length), 2**length - draw.randrange(4)]))


def test_large_totals_are_rounded_as_in_python(library):
    draw = random.Random(GENERATOR_SEED)
    for _ in range(20_000):
        robots, tasks = (min(number_of(draw, 31), 2**31 - 1) for _ in range(2))
        assert library.row_of(robots, tasks) == totals.row_of(robots, tasks)


@pytest.mark.parametrize("name", NAMES[:3])
def test_totals_that_fill_their_word_are_kept_as_in_python(name, library):
    draw = random.Random(GENERATOR_SEED)
    setting = setting_from((20, 5), (0, 0), True, None, STRATEGIES[name].parameters.values())
    counts = (ctypes.c_double * 4)()
    for _ in range(2_000):
        robot = Knowledge(STRATEGIES[name], Me(0, 0, 1, 0, [], setting))
        robot.words[:2] = [min(number_of(draw, 31), 2**31 - 1) for _ in range(2)]
        if name == "totals":  # it never holds a full word
            robot.words[:2] = [min(word, 2**31 - 2) for word in robot.words[:2]]
        is_robot = draw.random() < 0.5
        library.seen(NAMES.index(name), *robot.words[:2], is_robot, counts)
        robot.observe([Thing(is_robot, 0, 0, 0)])
        assert counts[:2] == robot.words[:2]
        exact = [sum(each) for each in robot.counted()]
        near = 1e-8 if library.is_double else 1e-6  # `totals` divides, in 32 bits
        assert counts[2] * sum(exact) == pytest.approx(exact[0] * sum(counts[2:]), rel=near)


def test_counts_of_a_long_life_keep_their_ratio(library):
    for robots, tasks in ((2**31, 2**29), (2**29, 2**29), (2**30, 2**31), (2**29 - 1, 2**29 - 1)):
        assert library.kept(robots, tasks) == pytest.approx(robots / (robots + tasks), abs=1e-3)


@pytest.mark.parametrize("name", NAMES[2:])
@pytest.mark.parametrize("is_robot", [True, False])
def test_a_thing_whose_id_was_misread_is_not_kept(name, is_robot, library):
    """The total of `totals` counts it all the same; a task of `roster-turns` has a place instead of an id."""
    if needs_double(STRATEGIES[name]) and not library.is_double:
        return
    number, limit = NAMES.index(name), 20 if is_robot else 40
    assert library.changed(number, is_robot, limit - 1) > 0
    kept = 1 if name == "totals" else 0
    if name != "roster-turns" or is_robot:
        for id_ in [*range(limit, limit + 100), -1, 2**31 - 1, -(2**31)]:
            assert library.changed(number, is_robot, id_) == kept
