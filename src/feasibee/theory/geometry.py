"""Encounters of walkers on a torus: how often two things are in range, and for how many steps.

The displacement of two robots is a random walk on the torus, uniform at any one step.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.theory.classes import EXPLORING, SENDING, Array

PAIRS = 8_000
"""Number of pairs sampled per geometry."""
UNLIKELY = 1e-3
"""Share of explorations that are longer than the longest one examined."""
SEED = 27


class Space(NamedTuple):
    """The arena and the walk, which encounters depend on."""

    size: tuple[float, float]
    """Width and height of the torus, in units."""
    speed: float
    """Speed of a robot, in units per step."""
    turning: float
    """Probability per step that a robot draws a new heading."""

    def in_range(self, reach: float) -> float:
        """Return the probability that a given thing is within ``reach``, which is at most half a side."""
        return math.pi * reach**2 / (self.size[0] * self.size[1])

    def coming(self, reach: float) -> float:
        """Return the probability per step that a given robot comes within ``reach`` from outside.

        It is the area of a disc outside the disc a step earlier, averaged over both headings.
        """
        angles = (np.arange(2_000) + 0.5) * np.pi / 2_000
        half = np.minimum(1, self.speed * np.sin(angles / 2) / reach)
        overlap = 2 * reach**2 * (np.arccos(half) - half * np.sqrt(1 - half**2))
        return self.in_range(reach) - float(overlap.mean()) / (self.size[0] * self.size[1])


def ending(mean: float) -> float:
    """Return the probability per step that a duration ends (model.md 3.4): ⌈x⌉ is geometric.

    ``mean`` is that of the exponential duration, in steps, before it is rounded up; 0 gives durations of one
    step.
    """
    return 1.0 if mean <= 0 else -math.expm1(-1 / mean)


@lru_cache(maxsize=32)
def sightings(
    space: Space, reach: float, walkers: int, lengths: tuple[int, ...]
) -> tuple[NDArray[np.float64], ...]:
    """Return the distribution of the number of steps in which one thing is in sight, for each length.

    A pair that is in range at a random step is walked both ways. Its weight is 1 over the number of steps in
    range, so that the mean number of steps is exact.

    ``reach`` is the range of sight, in units. ``walkers`` is 1 for a task, which stands still, and 2 for a
    robot. ``lengths`` of the exploration, in steps, ascend. Each law has the probability of 0 to ``length``
    steps.
    """
    random = np.random.default_rng(SEED)
    radius, angle = reach * np.sqrt(random.random(PAIRS)), 2 * np.pi * random.random(PAIRS)
    start = np.stack([radius * np.cos(angle), radius * np.sin(angle)])
    headings = 2 * np.pi * random.random((walkers, PAIRS))
    ahead, behind = (
        _times_in_range(space, reach, start, headings, sign, lengths[-1], random) for sign in (1, -1)
    )
    found, rows = [], np.arange(PAIRS)
    for length in lengths:
        before = (rows + random.random(PAIRS)) * length // PAIRS
        before = random.permutation(before).astype(np.int64)  # steps before the one in range: 0 to length - 1
        steps = 1 + ahead[length - 1 - before, rows] + behind[before, rows]
        law = np.bincount(steps, minlength=length + 1) / np.maximum(np.arange(length + 1), 1)
        law *= length * space.in_range(reach) / PAIRS
        law[0] = 1 - law[1:].sum()
        found.append(law)
    return tuple(found)


def _times_in_range(
    space: Space,
    reach: float,
    start: NDArray[np.float64],
    headings: NDArray[np.float64],
    sign: int,
    steps: int,
    random: np.random.Generator,
) -> NDArray[np.int64]:
    """Return the number of steps in range after each step of a walk in one direction of time.

    Forward, the first step has the heading of the step that led to the start if it hasn't turned.
    """
    place, headings = start.copy(), headings.copy()
    sides, signs = np.array(space.size)[:, None], np.array([1, -1])[: len(headings), None]
    times = np.zeros((steps, PAIRS), np.int64)
    for step in range(1, steps):
        if sign > 0 or step > 1:
            turns = random.random(headings.shape) < space.turning
            headings[turns] = 2 * np.pi * random.random(int(turns.sum()))
        moves = sign * space.speed * signs
        place += np.stack([(moves * np.cos(headings)).sum(0), (moves * np.sin(headings)).sum(0)])
        place -= sides * np.round(place / sides)
        times[step] = times[step - 1] + ((place**2).sum(0) <= reach**2)
    return times


def audible(
    space: Space,
    reach: float,
    delivered: float,
    explored: float,
    ends: Array,
    weights: Array,
    explorers_hear: bool,
) -> Array:
    """Return the probability per step that a sender is heard, for the last time before the hearer decides.

    ``reach`` is the range of the radio, in units; ``delivered`` is the probability that a message arrives,
    and ``explored`` that an exploration ends in a step. Each duration of dissemination has its probability
    per step to end in ``ends``, and its own in ``weights``: shape (opinions, durations).

    The shape is (opinions, 1 + durations, 2): by opinion and phase of the hearer, and by opinion of the
    sender, given that the sender broadcasts.
    """
    opinions, durations = ends.shape
    found = np.zeros((opinions, SENDING + durations, 2))
    for sender in (0, 1):
        moves = _moves(space, reach, explored, ends[sender], weights[sender])
        states = len(moves)
        heard = np.arange(states) > states // 2  # in range and broadcasting
        unheard = moves * np.where(heard, 1 - delivered, 1.0)
        sending = weights[sender] / ends[sender]
        share = delivered * space.in_range(reach) * sending / sending.sum()
        for hearer in range(opinions):
            last = _last(unheard, explored, ends[hearer], weights[hearer])
            found[hearer, :, sender] = last[:, heard] @ share
    if not explorers_hear:
        found[:, EXPLORING] = 0
    return found


def _last(unheard: Array, explored: float, ends: Array, weights: Array) -> Array:
    """Return the chance that nothing more is heard, by the hearer's phase and the sender's state."""
    states = len(unheard)
    last = np.zeros((SENDING + len(ends), states))
    for k, end in enumerate(ends, SENDING):
        last[k] = np.linalg.solve(np.eye(states) - (1 - end) * unheard, np.full(states, end))
    then = explored * unheard @ (weights @ last[SENDING:])
    last[EXPLORING] = np.linalg.solve(np.eye(states) - (1 - explored) * unheard, then)
    return last


def _moves(space: Space, reach: float, explored: float, ends: Array, weights: Array) -> Array:
    """Return the chances of a sender to move: out of range and in range, each by phase."""
    inside, coming = space.in_range(reach), space.coming(reach)
    enter, leave = coming / (1 - inside), coming / inside
    phases = np.diag(1 - np.concatenate([[explored], ends]))
    phases[0, 1:], phases[1:, 0] = explored * weights, ends
    return np.kron(np.array([[1 - enter, enter], [leave, 1 - leave]]), phases)
