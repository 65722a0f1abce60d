"""The random numbers: published vectors, two writings of the same, laws of what is drawn from them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from feasibee.engine.compile import entry
from hypothesis import given
from hypothesis import strategies as st
from numba import float64, int32, types, uint32

from feasibee.engine import draws
from feasibee.model import purposes
from feasibee.reference import draws as reference

words = st.integers(0, 2**32 - 1)


@entry(types.UniTuple(uint32, 4)(*[uint32] * 6))
def engine_philox(c0, c1, c2, c3, k0, k1):
    return draws.philox(c0, c1, c2, c3, k0, k1)


@entry(int32(uint32, float64))
def engine_duration(word, mean):
    return draws.duration(word, mean)


@entry(types.UniTuple(float64, 2)(uint32))
def engine_direction(word):
    return draws.direction(word)


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
    assert engine_philox(*counter, *key) == expected
    draw, robot, run, purpose = counter
    assert reference.philox(key[0] + (key[1] << 32), run, robot, draw, purpose) == expected


@given(st.tuples(*[words] * 6))
def test_both_minds_draw_the_same_words(numbers):
    draw, robot, run, purpose, low, high = numbers
    assert engine_philox(*numbers) == reference.philox(low + (high << 32), run, robot, draw, purpose)


@given(words, st.floats(1e-3, 1e6) | st.floats(-1e300, 1e300))
def test_both_minds_draw_the_same_durations(word, mean):
    assert engine_duration(word, mean) == reference.duration(word, mean)


@given(words)
def test_both_minds_draw_the_same_headings(word):
    assert engine_direction(word) == reference.cos_sin(word)


def test_headings_are_exact_at_the_quarter_turns():
    quarters = [engine_direction(quarter * 2**30) for quarter in range(4)]
    assert quarters == [(1, 0), (0, 1), (-1, 0), (0, -1)]


@given(words)
def test_headings_are_cosine_and_sine_to_the_last_bits(word):
    angle = 2 * math.pi * word / 2**32
    assert engine_direction(word) == pytest.approx((math.cos(angle), math.sin(angle)), rel=0, abs=1e-15)


@given(words, st.floats(1e-3, 1e6))
def test_a_duration_is_the_exponential_rounded_up_and_at_least_one(word, mean):
    exponential = -mean * math.log((word + 1) / 2**32)
    steps = engine_duration(word, mean)
    assert steps >= 1
    assert steps == 1 or steps - 1 < exponential <= steps


def test_rounding_up_hides_the_last_bit_of_the_logarithm():
    """At no word does the mean of 10 come within 1e-12 of a whole step, so every libm gives the same."""
    steps = np.arange(1, 222)
    boundary = np.exp(-steps / 10) * 2.0**32 - 1
    nearest = np.round(boundary)
    inside = nearest >= 0
    exponential = -10 * np.log((nearest[inside] + 1) / 2.0**32)
    assert np.abs(exponential - steps[inside]).min() > 1e-12


def test_no_purpose_is_used_twice():
    numbers = [number for name, number in vars(purposes).items() if name.isupper() and name != "PAIR"]
    assert numbers == [number for number in range(numbers[-1] + 1) if number != 29]
    assert numbers[-1] < purposes.PAIR
