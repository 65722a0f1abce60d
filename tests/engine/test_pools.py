"""What is drawn early and together equals what is drawn when it is needed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from feasibee.engine.compile import entry
from feasibee.engine.layout import BATCH, POOL, POOLED, Clock, Heard, Robot, empty_state, first_room
from feasibee.engine.signatures import PARAMS, STATE
from numba import float64, int32, int64, types, uint32

from feasibee import Scenario
from feasibee.engine import draws
from feasibee.engine.params import packed
from feasibee.model.purposes import PHASE, WALK
from feasibee.reference import draws as reference
from feasibee.simulation.lowering import lower

SEED, RUN = 5, 11


@entry(types.Tuple((int32, int32, int32))(PARAMS, STATE, int64, int64))
def next_heading(params, state, i, k):
    if k == 0:
        draws.draw_headings(params, state, 0, int64(BATCH))
    return draws.next_heading(params, state, 0, i, k)


@entry(types.Tuple((float64, float64, uint32))(PARAMS, STATE, int64, int64))
def present_phase(params, state, i, k):
    if k == 0:
        draws.draw_phases(params, state, 0, int64(BATCH))
    return draws.present_phase(params, state, 0, i, k)


@entry(int32(PARAMS, STATE, int64, float64, float64))
def phase_duration(params, state, i, length, mean):
    return draws.phase_duration(params, state, i, length, mean)


@entry(float64(uint32))
def exponential(word):
    return draws.exponential(word)


def swarm(robots=20, mean_run=10.0):
    """Return parameters and a state whose first robots are listed, in reversed order, to draw."""
    lowered = lower(Scenario(robots={"count": robots}, walk={"mean_run": mean_run}), SEED)
    state = empty_state(lowered.params, lowered.tables, first_room(lowered.params))
    state.clock[Clock.RUN] = RUN
    state.robots[Robot.LABEL] = 4 * np.arange(state.robots.shape[1])
    state.heard[0, Heard.RECEIVER, :BATCH] = np.arange(BATCH)[::-1]
    return packed(lowered.params), state


def doubtful_mean(word, steps):
    """Return a mean of which the exponential of a word is a whole number of steps, but for rounding."""
    return steps / -math.log((word + 1) / 2**32)


def headings_of(robots, mean_run, counter):
    """Return robots of a swarm with their headings of some number; with pools that of robot 3 only."""
    params, state = swarm(robots, mean_run)
    if robots <= POOLED:
        for number in range(counter + 1):  # fills pools on the way
            state.robots[Robot.WALKS, 3] = number
            heading = next_heading(params, state, 3, 1)
        return {3: heading}
    state.robots[Robot.WALKS] = counter
    return {BATCH - 1 - k: next_heading(params, state, BATCH - 1 - k, k) for k in range(0, BATCH, 5)}


@pytest.mark.parametrize("mean_run", [1.0, 10.0, 1e6])
@pytest.mark.parametrize("robots", [20, POOLED, POOLED + 1])
def test_headings_equal_those_of_the_reference(robots, mean_run):
    params, _ = swarm(robots, mean_run)
    for counter in (0, 1, POOL - 1, POOL, 3 * POOL + 2):
        for robot, heading in headings_of(robots, mean_run, counter).items():
            words = reference.philox(SEED, RUN, robot, counter, WALK)
            steps = [math.floor(params.robots.reach * each + 0.5) for each in reference.cos_sin(words[0])]
            assert heading == (*steps, reference.duration(words[1], mean_run))


@pytest.mark.parametrize("steps", [2, 7, 1000])
@pytest.mark.parametrize("robots", [20, POOLED + 1])
def test_a_heading_whose_rounding_is_in_doubt_lasts_as_by_the_platforms_logarithm(robots, steps):
    for counter in range(POOL):
        robot = 3 if robots <= POOLED else BATCH - 1
        word = reference.philox(SEED, RUN, robot, counter, WALK)[1]
        mean = doubtful_mean(word, steps)
        for mean_run in (math.nextafter(mean, 0), mean, math.nextafter(mean, math.inf)):
            assert headings_of(robots, mean_run, counter)[robot][2] == reference.duration(word, mean_run)


@pytest.mark.parametrize("robots", [20, POOLED, POOLED + 1])
def test_phases_equal_those_of_the_reference(robots):
    params, state = swarm(robots)
    robot = 3 if robots <= POOLED else BATCH - 1
    for number in range(2 * POOL):
        state.robots[Robot.PHASES, robot] = number
        words = reference.philox(SEED, RUN, robot, number, PHASE)
        length, chance, tie = present_phase(params, state, robot, 0)
        assert length == pytest.approx(-math.log((words[0] + 1) / 2**32), rel=1e-13)
        assert (chance, tie) == (words[1] / 2**32, words[2])
        for mean in (0.0, 0.1, 10.0, 1e300, doubtful_mean(words[0], 3)):
            expected = reference.duration(words[0], mean)
            assert phase_duration(params, state, robot, length, mean) == expected


def test_the_exponential_is_the_logarithm_to_twelve_digits():
    near_roots = [round(2.0 ** (k + 0.5)) + d for k in range(31) for d in (-1, 0, 1)]
    words = {2**32 - 2, *near_roots, *(2**k - 1 for k in range(33))}
    words |= set(np.random.default_rng(1).integers(0, 2**32, 20_000).tolist())
    for word in words:
        exact = -math.log((word + 1) / 2**32)
        assert abs(exponential(np.uint32(word)) - exact) <= 1e-13 * exact
