"""What the kernels work on: every array with its shape and unit.

Positions and velocities are fixed-point fractions of the side, in units of side / 2**32, held in int32: sums
and differences wrap as the torus does, and a difference is the shortest way round. Sets of robots are words
of 32 bits, robot i being bit i % 32 of word i // 32. Arrays over robots are padded to whole words.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.scenario import Scenario
from feasibee.vocabulary import exact

WORD = 32
TURN = 2**32

Int32s = NDArray[np.int32]
Int64s = NDArray[np.int64]
Words = NDArray[np.uint32]


class Params(NamedTuple):
    """The numbers of a scenario and seed, as the kernels want them."""

    robots: int
    tasks: int
    seed_low: np.uint32
    seed_high: np.uint32
    sight_limit: np.uint64  # in sight if the squared distance is below this
    radio_limit: np.uint64  # in radio range likewise
    reach: float  # length of a step
    mean_run: float  # steps
    exploration: float  # steps
    gain: float  # steps
    count_self: int  # 0 or 1
    own_vote: int  # 0 or 1
    listen_always: bool  # else only while disseminating
    every_message: bool  # else the latest of each robot
    quorum: int  # a decision is at least this many robots of one opinion
    steps: int
    stop_at_decision: bool
    robot_bits: int  # the robots' grid is 2**robot_bits cells a side
    task_bits: int


class Cells(NamedTuple):
    """Points sorted into a square grid of cells; see `feasibee.engine.cells`."""

    x: Int32s  # (room,)
    y: Int32s  # likewise
    label: Int32s  # likewise: who it is, and what else a search wants to know
    start: Int64s  # (cells + 2,): where each cell begins


class State(NamedTuple):
    """One swarm at one step. Axis 0 is the robot, padded, unless it says otherwise."""

    x: Int32s
    y: Int32s
    step_x: Int32s  # velocity, per step
    step_y: Int32s
    walk_left: Int32s  # steps until the next heading
    phase_left: Int32s  # steps until the next phase
    walks: Words  # headings drawn so far
    phases: Words  # phases drawn so far
    opinions: Words  # set of robots with opinion 1, by word
    disseminating: Words  # set of robots, by word
    turning: Words  # set of robots whose heading ends with this step, by word
    ending: Words  # set of robots whose phase ends with this step, by word
    robots_seen: Int64s  # n_obs of this exploration
    tasks_seen: Int64s  # m_obs
    votes: Int64s  # messages in the inbox
    feasible_votes: Int64s  # those with opinion 1
    sight: Words  # up to 32 robots: who is in sight of each
    heard: Words  # up to 32 robots: who is in the inbox of each
    heard_feasible: Words  # those with opinion 1
    labels: Int32s  # more than 32 robots: see `feasibee.engine.sensing.label`
    inbox: Int32s  # (robot, slot), more than 32 robots: hash tables of the senders' labels, or -1
    task_x: Int32s  # (task,)
    task_y: Int32s
    task_labels: Int32s  # the tasks' numbers
    task_cells: Cells
    robot_cells: Cells
    clock: Int64s  # (4,): see below


# The places in State.clock.
RUN, STEP, FEASIBLE_COUNT, FULL = range(4)
"""Number of the run; steps done; robots with opinion 1; 1 when an inbox table ran full."""


def params_of(scenario: Scenario, seed: int) -> Params:
    """Translate a scenario into the kernels' numbers."""
    arena, sensing, decision = scenario.arena, scenario.sensing, scenario.decision
    widest = max(sensing.range, scenario.radio.range)
    return Params(
        robots=scenario.robots.count,
        tasks=scenario.tasks.count,
        seed_low=np.uint32(seed & 0xFFFFFFFF),
        seed_high=np.uint32(seed >> 32),
        sight_limit=squared_limit(sensing.range, arena.side),
        radio_limit=squared_limit(scenario.radio.range, arena.side),
        reach=scenario.robots.speed / arena.side * TURN,
        mean_run=scenario.walk.mean_run,
        exploration=decision.exploration,
        gain=decision.gain,
        count_self=int(sensing.count_self),
        own_vote=int(decision.own_vote),
        listen_always=decision.listen == "always",
        every_message=decision.inbox == "every-message",
        quorum=math.floor(exact(decision.threshold) * scenario.robots.count) + 1,
        steps=scenario.run.steps,
        stop_at_decision=scenario.run.stop_at_decision,
        robot_bits=grid_bits(scenario.robots.count, widest, arena.side),
        task_bits=grid_bits(scenario.tasks.count, sensing.range, arena.side),
    )


def squared_limit(reach: float, side: float) -> np.uint64:
    """Return the least squared distance, in fixed point, that is farther than ``reach``."""
    return np.uint64(math.floor((exact(reach) / exact(side)) ** 2 * TURN**2) + 1)


def grid_bits(points: int, reach: float, side: float) -> int:
    """Return the finest grid whose half cells are no shorter than ``reach`` and not more cells than points.

    Up to 32 points need no grid: they are looked at together.
    """
    if points <= WORD:
        return 0
    by_range = math.floor(exact(side) / (2 * exact(reach))).bit_length() - 1
    by_number = (points.bit_length() - 1) // 2
    return max(0, min(by_range, by_number))


def empty_state(params: Params, slots: int) -> State:
    """Allocate a swarm; ``slots`` is the room for senders in each inbox table, a power of two."""
    words = -(-params.robots // WORD)
    padded = words * WORD
    small = words == 1

    def int32s(size: int = padded) -> Int32s:
        return np.zeros(size, np.int32)

    def int64s(size: int = padded) -> Int64s:
        return np.zeros(size, np.int64)

    def sets(size: int) -> Words:
        return np.zeros(size, np.uint32)

    return State(
        x=int32s(),
        y=int32s(),
        step_x=int32s(),
        step_y=int32s(),
        walk_left=int32s(),
        phase_left=int32s(),
        walks=sets(padded),
        phases=sets(padded),
        opinions=sets(words),
        disseminating=sets(words),
        turning=sets(words),
        ending=sets(words),
        robots_seen=int64s(),
        tasks_seen=int64s(),
        votes=int64s(),
        feasible_votes=int64s(),
        sight=sets(WORD),
        heard=sets(WORD),
        heard_feasible=sets(WORD),
        labels=int32s(),
        inbox=np.full((0 if small else padded, slots), -1, np.int32),
        task_x=int32s(params.tasks),
        task_y=int32s(params.tasks),
        task_labels=np.arange(params.tasks, dtype=np.int32),
        task_cells=empty_cells(params.tasks, params.task_bits),
        robot_cells=empty_cells(0 if small else params.robots, params.robot_bits),
        clock=int64s(4),
    )


def empty_cells(points: int, bits: int) -> Cells:
    """Allocate a grid with room for every point to stand in two strips and in their first column."""
    room = 4 * points + WORD
    cells = (2**bits + 1) * 2**bits
    return Cells(
        x=np.zeros(room, np.int32),
        y=np.zeros(room, np.int32),
        label=np.zeros(room, np.int32),
        start=np.zeros(cells + 2, np.int64),
    )
