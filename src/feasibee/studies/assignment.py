"""Who takes which task if robots know all of them: no swarm is sooner than the best assignments.

The way to a task is straight, less the reach, and the short way round on a torus. Walls and other robots make
it only longer. One robot may take one task, and only one that it can do (model.md 6.7, 6.25).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.scenario.scenario import Scenario

Ways = NDArray[np.float64]
SLACK = 1e-6
"""Part of a step by which a robot arrives sooner than the lengths say: steps are rounded (model.md 6.25)."""


class Least(NamedTuple):
    """The best assignments of robots at some places to tasks: as many as can be taken at once are."""

    sum_steps: int
    """Steps until the last task is taken, with the fewest steps of all robots together."""
    maximum_steps: int
    """Steps until the last task is taken, as few as possible."""
    moves: int
    """Steps of all robots together, as few as possible."""


def ways_between(
    scenario: Scenario, robots: Ways, tasks: Ways, able: NDArray[np.bool_] | None = None
) -> Ways:
    """Return how far each robot is from having arrived at each task, in steps: shape (robots, tasks).

    Parameters
    ----------
    scenario : Scenario
        The arena, speed and reach.
    robots, tasks : float64 array, shape (robots, 2) and (tasks, 2)
        Places in units.
    able : bool array, shape (robots, tasks), optional
        Whether a robot can do a task; by default it can. If not, the result is infinite.
    """
    apart = np.abs(robots[:, None] - tasks[None])
    if scenario.arena.boundary == "torus":
        apart = np.minimum(apart, np.array(scenario.arena.size) - apart)
    ways = np.hypot(apart[..., 0], apart[..., 1]) - scenario.acting.reach
    ways = ways / scenario.robots.speed
    return ways if able is None else np.where(able, ways, np.inf)


def least(ways: Ways) -> Least:
    """Return the best assignments; among equal ones of fewest steps, one with the shortest ways.

    Parameters
    ----------
    ways : float64 array, shape (robots, tasks)
        How far each robot is from each task, in steps; infinite if it can't do it.

    Examples
    --------
    >>> import numpy as np
    >>> least(np.array([[1.0, 2.0], [2.0, 8.0]]))
    Least(sum_steps=2, maximum_steps=2, moves=4)
    """
    steps = np.maximum(1.0, np.ceil(ways - SLACK))  # nobody arrives before step 1
    possible, taken = np.isfinite(ways), min(ways.shape)
    lengths = np.unique(steps[possible])
    if lengths.size == 0:
        return Least(0, 0, 0)
    shortest = ways[possible].min()
    costs = steps + (ways - shortest) / (1.0 + taken * (ways[possible].max() - shortest))
    never = 2.0 + taken * (1.0 + lengths[-1])  # a task more is worth more than all steps of the others
    chosen = _cheapest(np.where(possible, costs, never))
    moves = np.floor(chosen[chosen < never])
    first, last = 0, lengths.size - 1
    while first < last:
        middle = (first + last) // 2
        if np.sum(_cheapest(np.where(steps <= lengths[middle], 0.0, 1.0)) == 0.0) < moves.size:
            first = middle + 1
        else:
            last = middle
    return Least(int(moves.max()), int(lengths[first]), int(moves.sum()))


def done_between(ways: Ways, apart: Ways, work: int) -> tuple[int, int]:
    """Return a step before which nobody has done all tasks, and one at whose beginning a schedule has.

    Any step from the second on is a deadline by which the tasks are feasible, and the schedule proves it; any
    before the first is one by which they aren't (model.md 6.26.6).

    Parameters
    ----------
    ways : float64 array, shape (robots, tasks)
        How far each robot is from having arrived at each task, in steps; infinite if it can't do it.
    apart : float64 array, shape (tasks, tasks)
        How far a robot that has reached one task is from having arrived at another, in steps, at most.
    work : int
        Steps that a task takes.
    """
    robots = ways.shape[0]
    possible = np.flatnonzero(np.isfinite(ways).any(axis=0))
    if possible.size == 0:
        return 0, 0
    arrives = np.maximum(1.0, np.ceil(ways[:, possible] - SLACK))
    rounds = -(-possible.size // robots)
    bound = max(arrives.min(axis=0).max() + work, arrives.min() + rounds * work)
    ends, left, able = np.zeros(robots), possible.tolist(), np.isfinite(ways)
    starts = np.where(able, np.maximum(1.0, np.ceil(ways)), np.inf)
    while left:
        robot, place = np.unravel_index(np.argmin(starts[:, left]), (robots, len(left)))
        task = left.pop(int(place))
        ends[robot] = starts[robot, task] + work
        # It walks on for the step at whose end it chooses the next task, a step of it farther away at most.
        starts[robot] = np.where(
            able[robot], ends[robot] + 1 + np.maximum(1.0, np.ceil(apart[task] + 1)), np.inf
        )
    return int(bound), int(ends.max())


def _cheapest(costs: Ways) -> Ways:
    """Return the costs of the pairs of which their sum is least, by the Hungarian method.

    Each row, or each column if there are fewer, is in one pair. One after another is added along the shortest
    path of pairs that change: Crouse, "On implementing 2D rectangular assignment algorithms", 2016.
    """
    costs = costs if costs.shape[0] <= costs.shape[1] else costs.T
    rows, columns = costs.shape
    of_row, of_column = np.zeros(rows), np.zeros(columns)  # what the method subtracts from costs
    row_at, column_at = np.full(columns, -1), np.full(rows, -1)
    for row in range(rows):
        nearest, before, done = np.full(columns, np.inf), np.full(columns, -1), np.zeros(columns, np.bool_)
        i, far = row, 0.0
        while True:
            ways = far + costs[i] - of_row[i] - of_column
            shorter = ~done & (ways < nearest)
            nearest[shorter], before[shorter] = ways[shorter], i
            j = int(np.argmin(np.where(done, np.inf, nearest)))
            far = nearest[j]
            if row_at[j] < 0:
                break
            done[j], i = True, row_at[j]
        of_row[row] += far
        of_row[row_at[done]] += far - nearest[done]
        of_column[done] -= far - nearest[done]
        while j >= 0:
            i = before[j]
            row_at[j], column_at[i], j = i, j, (-1 if i == row else column_at[i])
    pairs: Ways = costs[np.arange(rows), column_at]
    return pairs
