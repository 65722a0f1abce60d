"""Pools of draws: what is drawn early and together equals what is drawn when it is needed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.engine import draws, pools
from feasibee.engine.layout import POOL, POOLED, Clock, Pool, Robot, empty_state
from feasibee.engine.params import packed
from feasibee.model.purposes import PHASE, WALK
from feasibee.reference import draws as reference
from feasibee.simulation.lowering import lower

SEED, RUN, ROBOT, FIRST = 5, 11, 3, 2 * POOL


def swarm(robots=20, mean_run=10.0):
    """Return parameters and an empty state of a swarm."""
    lowered = lower(Scenario(robots={"count": robots}, walk={"mean_run": mean_run}), SEED)
    state = empty_state(lowered.params, lowered.tables, 64)
    state.clock[Clock.RUN] = RUN
    return packed(lowered.params), state


def doubtful_mean(word, steps):
    """Return a mean of which the exponential of a word is a whole number of steps, but for rounding."""
    return steps / -math.log((word + 1) / 2**32)


@pytest.mark.parametrize("mean_run", [1.0, 10.0, 1e6])
def test_a_pool_holds_the_headings_that_are_drawn_one_by_one(mean_run):
    params, state = swarm(mean_run=mean_run)
    pools.fill_headings(params, state.pools, RUN, ROBOT, FIRST, POOL)
    for k in range(POOL):
        one = pools.compute_heading(params, RUN, ROBOT, FIRST + k)
        assert tuple(state.pools[ROBOT, : Pool.WALK + 1, k]) == one


@pytest.mark.parametrize("steps", [2, 7, 1000])
def test_a_heading_whose_rounding_is_in_doubt_lasts_as_by_the_platforms_logarithm(steps):
    words = [reference.philox(SEED, RUN, ROBOT, FIRST + k, WALK)[1] for k in range(POOL)]
    for word in words:
        mean = doubtful_mean(word, steps)
        for mean_run in (math.nextafter(mean, 0), mean, math.nextafter(mean, math.inf)):
            params, state = swarm(mean_run=mean_run)
            pools.fill_headings(params, state.pools, RUN, ROBOT, FIRST, POOL)
            expected = [reference.duration(each, mean_run) for each in words]
            assert state.pools[ROBOT, Pool.WALK].tolist() == expected


@pytest.mark.parametrize("robots", [20, POOLED, POOLED + 1])
def test_a_phase_is_the_same_with_and_without_a_pool(robots):
    params, state = swarm(robots)
    assert (state.pools.shape[0] == 0) == (robots > POOLED)
    for number in range(2 * POOL):
        state.robots[Robot.PHASES, ROBOT] = number
        words = reference.philox(SEED, RUN, ROBOT, number, PHASE)
        length, chance, tie = pools.draw_phase(params, state, ROBOT)
        assert length == pytest.approx(-math.log((words[0] + 1) / 2**32), rel=1e-13)
        assert (chance, tie) == (words[1] / 2**32, words[2])
        for mean in (0.0, 0.1, 10.0, 1e300, doubtful_mean(words[0], 3)):
            expected = reference.duration(words[0], mean)
            assert pools.phase_duration(params, state, ROBOT, length, mean) == expected


def test_the_exponential_is_the_logarithm_to_twelve_digits():
    near_roots = [round(2.0 ** (k + 0.5)) + d for k in range(31) for d in (-1, 0, 1)]
    words = {2**32 - 2, *near_roots, *(2**k - 1 for k in range(33))}
    words |= set(np.random.default_rng(1).integers(0, 2**32, 20_000).tolist())
    for word in words:
        exact = -math.log((word + 1) / 2**32)
        assert abs(pools.exponential(np.uint32(word)) - exact) <= 1e-13 * exact


def test_a_direction_is_the_same_for_all_quarters():
    for word in range(0, 2**32, 2**32 // 97):
        assert draws.direction(np.uint32(word)) == reference.cos_sin(word)
