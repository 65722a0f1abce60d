"""The arrays that compiled code works on: the names of their axes, their rows and their units.

Positions and velocities are fixed-point numbers in int32. Their unit is the torus's longer side / 2**32. So
sums and differences on a square torus wrap by themselves, and a difference is the shortest way round. Within
walls the unit is twice that, and no difference wraps. Sets of robots are words of 32 bits: see
`feasibee.engine.bits`. Arrays over robots are padded to whole words.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.engine.params import Params
from feasibee.strategies.contract import Strategy

WORD = 32
"""Robots per word of a set."""
PENDING_ROOM = 256
"""Entries of `State.pending`."""
POOL = 8
"""Draws of each kind that a robot's pool holds."""
POOLED = 1024
"""Robots of the largest swarm with pools; a pool takes 384 bytes."""

Int8s = NDArray[np.int8]
Int32s = NDArray[np.int32]
Int64s = NDArray[np.int64]
Words = NDArray[np.uint32]
Floats = NDArray[np.float64]


class Robot(IntEnum):
    """Rows of `State.robots`."""

    X = 0
    Y = 1
    STEP_X = 2  # velocity per step
    STEP_Y = 3
    WALK_LEFT = 4  # steps until the next heading
    PHASE_LEFT = 5  # steps until the next phase
    WALKS = 6  # headings drawn so far
    PHASES = 7  # phases drawn so far
    LABEL = 8  # see `feasibee.engine.bits.pack_label`
    ORDER = 9  # a shuffle of the robots
    SENT_VALUE = 10  # the value in its messages
    AGREED = 11  # successive decisions with which its inbox agreed
    MESSAGES = 12  # heard since the inbox was emptied
    IDENTITY = 13  # the first robot with the same id


class Set(IntEnum):
    """Rows of `State.sets`: sets of robots."""

    FEASIBLE = 0  # opinion 1
    DISSEMINATING = 1
    TURNING = 2  # heading ends with this step
    ENDING = 3  # phase ends with this step
    WORKING = 4  # not stopped
    COUNTED = 5  # the decision is taken over these
    BYZANTINE = 6
    STUBBORN = 7
    BLOCKED = 8  # stays in place in this step
    SPEAKING = 9  # disseminating, and not silent
    SAYS_FEASIBLE = 10
    NEUTRAL = 11  # no opinion
    COMMITTED = 12
    LISTENING = 13  # hears in this step (general engine)
    DECLARED = 14
    DECLARED_FEASIBLE = 15


class Count(IntEnum):
    """Rows of `State.counts`."""

    ROBOTS_SEEN = 0  # n_obs of this exploration
    TASKS_SEEN = 1  # m_obs
    VOTES = 2  # messages in the inbox
    FEASIBLE_VOTES = 3  # messages with opinion 1
    SENT_BITS = 4  # length of its message, if that is still a copy of what it knows; else -1


class Link(IntEnum):
    """Rows of `State.links`: for each robot a set of up to 32 robots."""

    SIGHT = 0  # robots in sight
    HEARD = 1  # senders in the inbox
    HEARD_FEASIBLE = 2  # senders in the inbox with opinion 1


class Slot(IntEnum):
    """Tables of `State.inbox`."""

    SENDER = 0  # label of the sender with its latest opinion, or -1
    VALUE = 1  # in that message
    WHEN = 2  # number of the message among all heard


class Copy(IntEnum):
    """Versions of a robot's knowledge in `State.knowledge`."""

    KNOWN = 0
    SENT = 1  # in the messages of this step


class Pending(IntEnum):
    """Rows of `State.pending`; the second has a meaning for each action."""

    WHO = 0  # the robot for which a function is called
    NUMBER = 1  # of the robot or task that it sees; negative for a false sighting
    FALSE_OPINION = 1  # opinion that its message must support if it is Byzantine, else -1
    SPEAKER = 1  # number of the robot that it hears
    COLUMN = 2  # class of the robot or task that it sees: classes of robots, then of tasks
    MARK = 3  # hash of a false sighting


class Pool(IntEnum):
    """Rows of a robot's pool in `State.pools`; see `feasibee.engine.pools`."""

    STEP_X = 0  # of a heading: velocity per step
    STEP_Y = 1
    WALK = 2  # of a heading: steps
    LENGTH = 3  # of a phase: its exponential of mean 1, to 12 digits
    CHANCE = 4  # of a phase: the second word of its draw as a share of 2**32
    TIE = 5  # of a phase: the third word of its draw


class Point(IntEnum):
    """Rows of `State.tasks` and of `Cells.points`."""

    X = 0
    Y = 1
    LABEL = 2  # number of the task, or label of the robot: see `feasibee.engine.bits.pack_label`


class Clock(IntEnum):
    """Places in `State.clock`."""

    RUN = 0  # number of the run
    STEP = 1  # steps done
    FULL = 2  # 1 when an inbox table ran full
    FEASIBLE_COUNT = 3  # counted robots with opinion 1
    NEUTRAL_COUNT = 4  # counted robots without an opinion
    BITS = 5  # sent so far
    COMMITTED_FEASIBLE = 6  # counted robots committed to opinion 1
    COMMITTED_INFEASIBLE = 7
    DECLARED_FEASIBLE = 8  # counted robots that have declared feasible
    DECLARED_INFEASIBLE = 9
    PENDING = 10  # entries of `State.pending`


class Cells(NamedTuple):
    """Points sorted into a square grid of cells; see `feasibee.engine.cells`."""

    points: Annotated[Int32s, "Point", "place"]
    start: Annotated[Int64s, "cell"]  # first place of each cell; two more than there are cells


class Tables(NamedTuple):
    """The arrays of a scenario: classes, skills (model.md 6.7), given points, strategy parameters."""

    class_of: Annotated[Int32s, "robot, then task"]
    adds: Annotated[Int64s, "set of skills", "class of robots, then of tasks"]  # per member of the class
    points: Annotated[Int32s, "robot, then task", "x, y"]  # zeros unless placement is "points"
    parameters: Annotated[Floats, "parameter"]


class State(NamedTuple):
    """One swarm at one step; robots are padded to whole words.

    The arrays are few and wide: each kernel that is passed the state takes longer to compile for each field.
    """

    robots: Annotated[Int32s, "Robot", "robot"]
    sets: Annotated[Words, "Set", "word of robots"]
    counts: Annotated[Int64s, "Count", "robot"]
    links: Annotated[Words, "Link", "robot"]  # up to 32 robots
    seen: Annotated[Int64s, "robot", "class of robots, then of tasks"]  # no rows unless there are several
    remembered: Annotated[Words, "robot", "word of robots, then of tasks"]  # for unique observation
    inbox: Annotated[Int32s, "Slot", "robot", "slot"]  # hash tables; if together, VALUE by sender
    memory: Annotated[Floats, "robot", "rated quality of *feasible*, then the strategy's own"]
    knowledge: Annotated[Int32s, "Copy", "robot", "word"]  # see `feasibee.engine.knowledge`
    pending: Annotated[Int32s, "Pending", "entry"]  # calls of the functions of a strategy's knowledge
    hashes: Annotated[Words, "robot, then task, then invention"]  # if robots pass on knowledge
    pools: Annotated[Floats, "robot", "Pool", "draw"]  # no rows in large swarms
    tasks: Annotated[Int32s, "Point", "task"]
    task_cells: Cells
    robot_cells: Cells
    tables: Tables
    clock: Annotated[Int64s, "Clock"]


class Passing(NamedTuple):
    """The arrays of `State` that the functions of a strategy's knowledge work on."""

    words: Annotated[Int32s, "Copy", "robot", "word"]
    pending: Annotated[Int32s, "Pending", "entry"]
    robots: Annotated[Int32s, "Robot", "robot"]
    sets: Annotated[Words, "Set", "word of robots"]
    tasks: Annotated[Int32s, "Point", "task"]
    class_of: Annotated[Int32s, "robot, then task"]
    hashes: Annotated[Words, "robot, then task, then invention"]
    counts: Annotated[Int64s, "robot", "class of robots, then of tasks"]
    sent_bits: Annotated[Int64s, "robot"]  # of `State.counts`
    memory: Annotated[Floats, "robot", "rated quality of *feasible*, then the strategy's own"]
    parameters: Annotated[Floats, "parameter"]


class Functions(NamedTuple):
    """The compiled functions of a strategy; see `feasibee.strategies.contract.Strategy`."""

    quality: Any
    dissemination: Any
    decide: Any
    say: Any
    value: Any
    update: Any  # see `feasibee.engine.knowledge`


class Outcome(NamedTuple):
    """The arrays of a `Record` that the engine fills in."""

    decision: Annotated[Int8s, "run"]
    decision_step: Annotated[Int32s, "run"]
    feasible_count: Annotated[Int32s, "run", "step"]  # no columns unless curves are asked for
    infeasible_count: Annotated[Int32s, "run", "step"]
    account: Annotated[Int64s, "run", "column of the account"]


class Control(NamedTuple):
    """The numbers that a simulating thread shares with the thread that waits for it."""

    steps_done: Annotated[Int64s, "one"]
    cancelled: Annotated[NDArray[np.bool_], "one"]


class Lowered(NamedTuple):
    """A scenario and a seed in the form that the engine takes."""

    params: Params
    tables: Tables
    strategy: Strategy
    fast: bool  # whether the fast path simulates it, else the general engine


def empty_state(params: Params, tables: Tables, slots: int, memory: int = 0) -> State:
    """Allocate a swarm.

    ``slots`` is the number of senders that each inbox table has room for, a power of two. ``memory`` is the
    number of floats that the strategy keeps per robot.
    """
    words = -(-params.robots.count // WORD)
    padded = words * WORD
    classes = tables.adds.shape[1]
    remembered = words + -(-params.tasks.count // WORD)
    knowledge = params.strategy.knowledge
    values = params.strategy.value_scale > 0
    state = State(
        robots=np.zeros((len(Robot), padded), np.int32),
        sets=np.zeros((len(Set), words), np.uint32),
        counts=np.zeros((len(Count), padded), np.int64),
        links=np.zeros((len(Link), WORD), np.uint32),
        seen=np.zeros((padded if params.sensing.by_class or knowledge.enabled else 0, classes), np.int64),
        remembered=np.zeros((padded if params.sensing.unique else 0, remembered), np.uint32),
        inbox=np.full(_inbox_shape(params, padded, slots, values), -1, np.int32),
        memory=np.zeros((padded, 1 + memory), np.float64),
        knowledge=np.zeros((len(Copy), padded, copy_length(params)), np.int32),
        pending=np.zeros((Pending.MARK + 1, PENDING_ROOM if knowledge.enabled else 0), np.int32),
        hashes=np.zeros(knowledge.robot_ids + knowledge.task_ids if knowledge.enabled else 0, np.uint32),
        pools=np.zeros((padded if params.robots.count <= POOLED else 0, len(Pool), POOL), np.float64),
        tasks=np.zeros((len(Point), params.tasks.count), np.int32),
        task_cells=empty_cells(params.tasks.count, params.tasks.grid.bits),
        robot_cells=empty_cells(0 if params.together else params.robots.count, params.robots.grid.bits),
        tables=tables,
        clock=np.zeros(len(Clock), np.int64),
    )
    state.tasks[Point.LABEL] = np.arange(params.tasks.count)
    return state


def size_of(params: Params, tables: Tables, slots: int) -> int:
    """Return about how many bytes a swarm takes, without arrays of fixed size per robot or task."""
    words = -(-params.robots.count // WORD)
    padded = words * WORD
    remembered = words + -(-params.tasks.count // WORD) if params.sensing.unique else 0
    inbox = math.prod(_inbox_shape(params, padded, slots, params.strategy.value_scale > 0))
    return 4 * (inbox + padded * (remembered + 2 * copy_length(params)))


def _inbox_shape(params: Params, padded: int, slots: int, values: bool) -> tuple[int, int, int]:
    if params.together:
        return (2, padded, WORD) if values else (1, 0, 1)
    if params.decision.inbox_size:
        return (3, padded, slots)
    return (2 if values else 1, padded, slots)


def copy_length(params: Params) -> int:
    """Return the number of words of each `Copy`: of what a robot knows, and of its message."""
    return max(params.strategy.knowledge.words, params.strategy.knowledge.message_words)


def empty_cells(points: int, bits: int) -> Cells:
    """Allocate a grid where every point may be stored in two strips, and in their first column."""
    room = 4 * points + WORD
    cells = (2**bits + 1) * 2**bits
    return Cells(np.zeros((len(Point), room), np.int32), np.zeros(cells + 2, np.int64))
