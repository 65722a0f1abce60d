"""The distribution of how long robots disseminate, which follows from what they saw while they explored."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.theory.geometry import UNLIKELY, Space, sightings

GRID = 1_000
"""Number of intervals of the qualities, 0 to 1."""
LENGTHS = 14
"""Number of lengths of an exploration that are examined."""
DURATIONS = 3
"""Number of geometric durations that stand for the distribution of dissemination."""


class Sight(NamedTuple):
    """What a robot sees while it explores."""

    space: Space
    """The arena and the walk."""
    reach: float
    """Range of sight, in units."""
    hearing: float
    """Range of the radio, in units."""
    seen: float
    """Probability that a thing in range is seen, per step."""
    robots: int
    """Number of other robots."""
    tasks: int
    """Number of tasks."""
    itself: bool
    """Whether a robot counts itself."""
    floor: int
    """Least value of each of the two counts when they are rated."""
    ending: float
    """Probability per step that an exploration ends."""


@lru_cache(maxsize=256)
def qualities(sight: Sight) -> NDArray[np.float64]:
    """Return the probabilities of the qualities of *feasible* 0, 1 / `GRID`, ... 1 after exploration.

    The second row is of the robots that have heard a given other one, for robots that see others hear them,
    too. Each counts as often as it met that robot.
    """
    lengths, weights = _lengths(sight.ending)
    robots, tasks = (sightings(sight.space, sight.reach, walkers, lengths) for walkers in (2, 1))
    apart = sight.space.in_range(sight.hearing) / sight.space.coming(sight.hearing) - 1
    found = np.zeros((2, GRID + 1))
    for length, weight, by_robot, by_task in zip(lengths, weights, robots, tasks, strict=True):
        by_step = by_robot * np.arange(length + 1)
        others, tasks_seen = (
            _total(law, count, sight.seen)
            for law, count in ((by_robot, sight.robots - 1), (by_task, sight.tasks))
        )
        found[0] += weight * _rated(sight, length, by_robot, others, tasks_seen)
        heard = length + apart  # as many as come into range of the radio
        found[1] += weight * heard * _rated(sight, length, by_step / by_step.sum(), others, tasks_seen)
    together: NDArray[np.float64] = found / found.sum(1, keepdims=True)
    return together


def _rated(
    sight: Sight,
    length: int,
    law: NDArray[np.float64],
    others: tuple[int, NDArray[np.float64]],
    tasks: tuple[int, NDArray[np.float64]],
) -> NDArray[np.float64]:
    """Return the probabilities of the qualities, by the laws of one robot, of all others and of the tasks."""
    least, chances = _total(law, 1, sight.seen)
    chances = np.convolve(others[1], chances)
    counts = others[0] + least + np.arange(len(chances)) + sight.itself * length
    counts = np.maximum(counts, sight.floor)[:, None]
    every = counts + np.maximum(tasks[0] + np.arange(len(tasks[1])), sight.floor)
    rho = np.where(every > 0, counts / np.maximum(every, 1), 0.5)
    nearest = np.rint(GRID * rho).astype(np.int64).ravel()
    return np.bincount(nearest, np.outer(chances, tasks[1]).ravel(), GRID + 1).astype(np.float64)


def _lengths(ending: float) -> tuple[tuple[int, ...], NDArray[np.float64]]:
    """Return lengths of an exploration, and the probability that each stands for."""
    longest = max(1, int(np.ceil(np.log(UNLIKELY) / np.log1p(-ending)))) if ending < 1 else 1
    steps = np.arange(1, longest + 1)
    chances = ending * (1 - ending) ** (steps - 1)
    edges = np.unique(np.rint(np.geomspace(1, longest + 1, LENGTHS + 1)).astype(int))
    weights = np.add.reduceat(chances, edges[:-1] - 1)
    means = np.add.reduceat(chances * steps, edges[:-1] - 1) / weights
    return tuple(np.rint(means).astype(int).tolist()), weights / weights.sum()


def _total(law: NDArray[np.float64], number: int, seen: float) -> tuple[int, NDArray[np.float64]]:
    """Return the distribution of a sum of independent counts: its least value, and chances from there."""
    if not number:
        return 0, np.ones(1)
    steps = np.arange(len(law))
    mean = float(law @ steps) * seen
    spread = float(law @ steps**2) * seen
    most = int(min(number * (len(law) - 1), number * mean + 10 * np.sqrt(number * spread) + len(law)))
    size = 1 << most.bit_length()
    waves = np.exp(-2j * np.pi * np.arange(size // 2 + 1) / size)
    one = (
        np.polyval(law[::-1], 1 - seen + seen * waves)
        if size < 2 * len(law) or seen < 1
        else np.fft.rfft(law, size)
    )
    chances = np.maximum(np.fft.irfft(one**number, size), 0)
    likely = np.flatnonzero(chances > 1e-7)
    return int(likely[0]), chances[likely[0] : likely[-1] + 1]


def durations(
    chances: NDArray[np.float64], steps: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return ends per step of `DURATIONS` geometric durations, and their probabilities: Gauss's quadrature.

    ``chances`` has the probability of each quality, and ``steps`` the mean number of steps, rounded up, of a
    dissemination of each: shape (GRID + 1,).
    """
    points, diagonal, beside = np.zeros(GRID + 1), [], [0.0]
    now = np.sqrt(chances)  # Lanczos: the Jacobi matrix of the orthogonal polynomials
    for _ in range(DURATIONS):
        diagonal.append(float(now @ (steps * now)))
        ahead = (steps - diagonal[-1]) * now - beside[-1] * points
        size = float(np.linalg.norm(ahead))
        if size < 1e-6 * max(1.0, diagonal[0]):
            break
        beside.append(size)
        points, now = now, ahead / size
    several = len(diagonal)
    matrix = np.diag(diagonal) + np.diag(beside[1:several], 1) + np.diag(beside[1:several], -1)
    nodes, vectors = np.linalg.eigh(matrix)
    weights = np.zeros(DURATIONS)
    ends = np.ones(DURATIONS)
    weights[:several], ends[:several] = vectors[0] ** 2, 1 / np.maximum(nodes, 1)
    return ends, weights


def company(
    rated: NDArray[np.float64],
    steps: NDArray[np.float64],
    ends: NDArray[np.float64],
    weights: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return how often robots of each duration met another one before, relative to the mean: (durations,).

    ``rated`` has the rows of `qualities`, and ``steps`` the mean steps of a dissemination of each quality.
    Means of quadratic functions of the geometric durations ``ends`` and ``weights`` are kept.
    """
    found = np.ones(len(ends))
    used = np.flatnonzero(weights)
    for each in used:
        others = 1 / ends[used[used != each]]
        polynomial = np.prod((steps[:, None] - others) / (1 / ends[each] - others), axis=1)
        found[each] += (rated[1] - rated[0]) @ polynomial / weights[each]
    return found
