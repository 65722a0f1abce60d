"""The paper's swarm as one plain numba loop over all pairs: a simple script, as a baseline for the speed.

``python benchmarks/brute_force.py`` simulates some runs and prints the rates of their decisions.
"""

# ruff: noqa: NPY002, PLR0912  numba compiles only the old generators; one long loop is the baseline

from __future__ import annotations

import math

import numba
import numpy as np

REACH, SPEED = 2.0, 1.0
MEAN_RUN = EXPLORATION = GAIN = 10.0
FEASIBLE, INFEASIBLE, UNDECIDED, UNHEARD = 1, 0, -1, -1


@numba.njit
def duration(mean: float) -> int:
    """Draw an exponential duration as a number of steps, at least 1."""
    return max(1, math.ceil(np.random.exponential(mean)))


@numba.njit
def is_near(x1: float, y1: float, x2: float, y2: float, side: float) -> bool:
    """Return whether two points of the torus are in range of each other."""
    dx, dy = abs(x1 - x2), abs(y1 - y2)
    dx, dy = min(dx, side - dx), min(dy, side - dy)
    return dx * dx + dy * dy <= REACH * REACH


@numba.njit
def play(robots: int, tasks: int, steps: int, side: float) -> tuple[int, int]:
    """Simulate all steps of one run; return its first decision and its step."""
    x, y = np.random.uniform(0, side, robots), np.random.uniform(0, side, robots)
    task_x, task_y = np.random.uniform(0, side, tasks), np.random.uniform(0, side, tasks)
    vx, vy = np.empty(robots), np.empty(robots)
    opinion = np.random.randint(0, 2, robots)
    disseminating = np.zeros(robots, np.bool_)
    walk_left, phase_left = np.ones(robots, np.int64), np.empty(robots, np.int64)
    robots_seen, tasks_seen = np.zeros(robots, np.int64), np.zeros(robots, np.int64)
    inbox = np.full((robots, robots), UNHEARD, np.int8)
    for i in range(robots):
        phase_left[i] = duration(EXPLORATION)
        turn(i, vx, vy, walk_left)
    decision, decision_step = first_decision(opinion), 0
    for step in range(1, steps + 1):
        for i in range(robots):
            x[i] = (x[i] + vx[i]) % side
            y[i] = (y[i] + vy[i]) % side
        for i in range(robots):
            for j in range(i):
                if is_near(x[i], y[i], x[j], y[j], side):
                    robots_seen[i] += 1
                    robots_seen[j] += 1
                    if disseminating[i]:
                        inbox[j, i] = opinion[i]
                    if disseminating[j]:
                        inbox[i, j] = opinion[j]
            if not disseminating[i]:
                for k in range(tasks):
                    tasks_seen[i] += is_near(x[i], y[i], task_x[k], task_y[k], side)
        for i in range(robots):
            walk_left[i] -= 1
            if walk_left[i] == 0:
                turn(i, vx, vy, walk_left)
            phase_left[i] -= 1
            if phase_left[i] > 0:
                continue
            if disseminating[i]:
                opinion[i] = majority(opinion[i], inbox[i])
                inbox[i] = UNHEARD
                robots_seen[i] = tasks_seen[i] = 0
                phase_left[i] = duration(EXPLORATION)
            else:
                seen = robots_seen[i] + tasks_seen[i]
                quality = robots_seen[i] / seen if seen > 0 else 0.5
                phase_left[i] = duration(GAIN * (quality if opinion[i] == FEASIBLE else 1 - quality))
            disseminating[i] = not disseminating[i]
        if decision == UNDECIDED:
            decision, decision_step = first_decision(opinion), step
    return decision, (decision_step if decision != UNDECIDED else -1)


@numba.njit
def turn(i: int, vx: np.ndarray, vy: np.ndarray, walk_left: np.ndarray) -> None:
    """Draw a new heading of a robot, and the number of steps until the next."""
    heading = np.random.uniform(0, 2 * math.pi)
    vx[i], vy[i] = SPEED * math.cos(heading), SPEED * math.sin(heading)
    walk_left[i] = duration(MEAN_RUN)


@numba.njit
def majority(opinion: int, heard: np.ndarray) -> int:
    """Return the majority of a robot's inbox and its own opinion; a tie keeps its own."""
    balance = 2 * opinion - 1
    for other in heard:
        if other != UNHEARD:
            balance += 2 * other - 1
    if balance == 0:
        return opinion
    return FEASIBLE if balance > 0 else INFEASIBLE


@numba.njit
def first_decision(opinion: np.ndarray) -> int:
    """Return the opinion of more than 90 % of the robots, or UNDECIDED."""
    feasible = opinion.sum()
    if 10 * feasible > 9 * opinion.size:
        return FEASIBLE
    return INFEASIBLE if 10 * (opinion.size - feasible) > 9 * opinion.size else UNDECIDED


@numba.njit
def simulate(
    runs: int, seed: int, robots: int = 20, tasks: int = 100, steps: int = 1000, side: float = 20.0
) -> tuple[np.ndarray, np.ndarray]:
    """Simulate some runs; return the decision and the decision step of each."""
    np.random.seed(seed)
    decisions, decision_steps = np.empty(runs, np.int64), np.empty(runs, np.int64)
    for run in range(runs):
        decisions[run], decision_steps[run] = play(robots, tasks, steps, side)
    return decisions, decision_steps


def print_rates(tasks: int, runs: int) -> None:
    """Print rates and times of decisions, for comparison with tests/test_laws.py."""
    decisions, steps = simulate(runs, 1, tasks=tasks)
    share = np.mean(decisions == FEASIBLE)
    quartiles = np.quantile(steps[decisions != UNDECIDED], (0.25, 0.5, 0.75)).tolist()
    print(f"{tasks} tasks, {runs} runs: feasible {share:.3f}; decision step, quartiles: {quartiles}")


if __name__ == "__main__":
    print_rates(tasks=10, runs=2000)
    print_rates(tasks=100, runs=2000)
