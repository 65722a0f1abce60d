"""The random numbers: published vectors, laws of what is drawn, and durations in doubt."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from feasibee import Scenario, Swarm
from feasibee.base import purposes
from feasibee.base.purposes import PHASE, WALK
from feasibee.reference import draws

words = st.integers(0, 2**32 - 1)

# Random123's known answers for philox4x32-10 (kat_vectors): counter, key, result.
KNOWN = [
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]


@pytest.mark.parametrize(("counter", "key", "expected"), KNOWN)
def test_philox_gives_the_published_answers(counter, key, expected):
    draw, robot, run, purpose = counter
    assert draws.philox(key[0] + (key[1] << 32), run, robot, draw, purpose) == expected


def test_headings_are_exact_at_the_quarter_turns():
    quarters = [draws.cos_sin(quarter * 2**30) for quarter in range(4)]
    assert quarters == [(1, 0), (0, 1), (-1, 0), (0, -1)]


@given(words)
def test_headings_are_cosine_and_sine_to_the_last_bits(word):
    angle = 2 * math.pi * word / 2**32
    assert draws.cos_sin(word) == pytest.approx((math.cos(angle), math.sin(angle)), rel=0, abs=1e-15)


@given(words, st.floats(1e-3, 1e6))
def test_a_duration_is_the_exponential_rounded_up_and_at_least_one(word, mean):
    exponential = -mean * math.log((word + 1) / 2**32)
    steps = draws.duration(word, mean)
    assert steps >= 1
    assert steps == 1 or steps - 1 < exponential <= steps


def test_what_is_impossible_never_happens_and_what_is_certain_always():
    assert [draws.happens(word, chance) for word, chance in ((0, 0.0), (2**32 - 1, 1.0))] == [False, True]


def test_rounding_up_hides_the_last_bit_of_the_logarithm():
    """At no word does the mean of 10 come within 1e-12 of a whole step, so every libm gives the same."""
    steps = np.arange(1, 222)
    boundary = np.exp(-steps / 10) * 2.0**32 - 1
    nearest = np.round(boundary)
    inside = nearest >= 0
    exponential = -10 * np.log((nearest[inside] + 1) / 2.0**32)
    assert np.abs(exponential - steps[inside]).min() > 1e-12


@pytest.mark.parametrize("steps", [2, 7, 1000])
@pytest.mark.parametrize("robots", [20, 129])
@pytest.mark.parametrize(
    ("field", "purpose", "word", "row"),
    [("walk.mean_run", WALK, 1, "WALK_LEFT"), ("decision.exploration", PHASE, 0, "PHASE_LEFT")],
)
def test_the_engine_draws_durations_that_rounding_leaves_in_doubt_as_the_reference(
    robots, steps, field, purpose, word, row
):
    """The exponential of this mean is a whole number of steps, which a quick logarithm can't tell."""
    for seed in range(5):
        own = draws.philox(seed, 0, 3, 0, purpose)[word]
        exact = steps / -math.log((own + 1) / 2**32)
        for mean in (math.nextafter(exact, 0), exact, math.nextafter(exact, math.inf)):
            swarm = Swarm(Scenario().replace({"robots.count": robots, "arena.side": 60.0, field: mean}), seed)
            assert swarm._state.robots[row][3] == draws.duration(own, mean)


def test_no_purpose_is_used_twice():
    numbers = [number for name, number in vars(purposes).items() if name.isupper() and name != "PAIR"]
    assert numbers == [number for number in range(numbers[-1] + 1) if number != 29]
    assert numbers[-1] < purposes.PAIR
