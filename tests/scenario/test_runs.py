"""Runs: validated where they are made, and built-in ints from there on."""

from __future__ import annotations

import pickle
from itertools import pairwise

import numpy as np
import pytest

from feasibee import FeasibeeError
from feasibee.scenario.runs import RUNS_APART, Runs, check_integer


def test_integers_of_any_library_become_built_in_ints():
    runs = Runs(np.int64(3), np.uint64(2**64 - 1), np.int8(5))
    assert runs == Runs(3, 2**64 - 1, 5)
    assert {type(value) for value in (runs.count, runs.seed, runs.first)} == {int}
    assert pickle.loads(pickle.dumps(runs)) == runs


WRONG = {
    (0,): "runs = 0: must be a whole number from 1 to 4294967296; such as 1",
    (2**32 + 1,): "runs = 4294967297: must be a whole number from 1 to",
    (True,): "runs = True: must be a whole number",
    ("3",): "runs = '3': must be a whole number",
    (1, -1): "seed = -1: must be a whole number from 0 to 18446744073709551615; such as 1",
    (1, 2**64): "seed = 18446744073709551616: must be",
    (1, None): "seed = None: must be",
    (1, 0, -1): "first_run = -1: must be a whole number from 0 to 4294967295",
    (2, 0, 2**32 - 1): "first_run = 4294967295: must be a whole number from 0 to 4294967294",
}


@pytest.mark.parametrize("values", WRONG)
def test_an_invalid_value_is_named_and_the_limits_are_valid(values):
    with pytest.raises(FeasibeeError) as caught:
        Runs(*values)
    assert str(caught.value).startswith(WRONG[values])
    assert Runs(1, 0, 2**32 - 1).first == 2**32 - 1
    assert Runs(2**32, 2**64 - 1).count == 2**32


def test_the_one_run_of_a_seed_is_called_run():
    assert Runs.single(7, 3) == Runs(1, 7, 3)
    with pytest.raises(FeasibeeError, match=r"^run = -1: must be a whole number from 0 to 4294967295"):
        Runs.single(7, -1)


def test_two_points_of_a_study_share_no_run():
    points = [Runs.of_point(point, RUNS_APART, 5) for point in (0, 1, 4293)]
    for one, other in pairwise(points):
        assert one.first + one.count <= other.first
    with pytest.raises(FeasibeeError, match=r"^runs = 1000001: must be at most 1000000 per point"):
        Runs.of_point(0, RUNS_APART + 1, 5)


def test_the_remedy_is_a_valid_value():
    for low, high in ((240, 4096), (0, 0), (0, 9)):
        with pytest.raises(FeasibeeError) as caught:
            check_integer("size", high + 1, low, high)
        assert check_integer("size", int(str(caught.value).rpartition(" ")[2]), low, high) in range(
            low, high + 1
        )
