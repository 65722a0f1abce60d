"""What the kernels work on: every array with its shape and unit.

Positions and velocities are fixed-point numbers in int32, in units of the torus's longer side / 2**32: on a
square torus sums and differences wrap by themselves, and a difference is the shortest way round. Within
walls the unit is twice that, so that no difference wraps. Sets of robots are words of 32 bits, robot i being
bit i % 32 of word i // 32. Arrays over robots are padded to whole words.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

WORD = 32
TURN = 2**32
REGISTERS = 128
"""Of a sketch."""

Int32s = NDArray[np.int32]
Int64s = NDArray[np.int64]
Words = NDArray[np.uint32]
Floats = NDArray[np.float64]


class Grid(NamedTuple):
    """A grid of cells over the arena, 2**bits a side; see `feasibee.engine.cells`."""

    bits: int
    width: int  # of the arena, in units of fixed point
    height: int
    scale_x: np.uint64  # cells per unit, times 2**52
    scale_y: np.uint64


class Placing(NamedTuple):
    """How robots or tasks are placed (model.md 6.4)."""

    how: int  # UNIFORM, CLUSTERS, CORNER or POINTS
    clusters: int
    spread: int  # units of fixed point
    margin: int  # kept from the walls


UNIFORM, CLUSTERS, CORNER, POINTS = range(4)
OPPOSITE, SAYS_FEASIBLE, SAYS_INFEASIBLE, RANDOM = range(4)
NOTHING, TALLY, CENSUS, SKETCH = range(4)
ALWAYS, WHILE_DISSEMINATING = -1, 0


class Params(NamedTuple):
    """The numbers of a scenario and seed, as the kernels want them."""

    robots: int
    tasks: int
    robot_classes: int
    seed_low: np.uint32
    seed_high: np.uint32
    walls: bool
    wraps: bool  # whether differences in 32 bits are right as they are: in a square torus, and within walls
    width: int  # of the arena, in units of fixed point
    height: int
    mixed: bool  # whether robots or tasks have classes
    together: bool  # whether all robots sense at once: up to 32, with nothing beyond the paper
    sight_limit: np.uint64  # in sight if the squared distance is below this
    radio_limit: np.uint64  # in radio range likewise
    reach: float  # length of a step
    radius: int  # of a robot's disc
    avoid_collisions: bool
    apart_limit: np.uint64  # discs overlap if the squared distance is below this
    meet_limit: np.uint64  # discs can't meet within a step unless it is below this
    robot_placing: Placing
    task_placing: Placing
    mean_run: float  # steps
    exploration: float  # steps
    gain: float  # steps
    dissemination_floor: int  # steps
    quality_floor: int
    forgets: bool  # whether each exploration counts afresh
    starts_neutral: bool  # whether robots start without an opinion
    says: bool  # whether the strategy has its own way to say, else a robot tells its opinion
    value_scale: float  # the largest value that a message can hold; 0.0: messages hold none
    inbox_size: int  # senders kept, the newest; 0: all
    commit: bool  # whether robots commit to opinions
    commit_share: int  # of an inbox that must agree, over
    commit_whole: int
    commit_rounds: int
    commit_heard: int
    knowledge: int  # what robots pass on: NOTHING, TALLY, CENSUS or SKETCH
    estimates: bool  # whether a tally allows for what robots can't see: themselves
    message_bits: int  # beside knowledge
    id_bits: int  # length of an id
    random_ids: bool  # whether ids are random, and may collide
    count_self: int  # 0 or 1
    unique: bool  # whether a thing counts once
    for_life: bool  # else once an exploration
    only_counts: bool  # whether robots count what they see and no more: no classes, no knowledge
    counts_all: bool  # whether they count all in sight besides: nothing is missed, or known already
    miss: np.uint64  # a probability, times 2**32
    loss: np.uint64  # likewise
    false_robots: float  # a step
    false_tasks: float
    own_vote: int  # 0 or 1
    listens_for: int  # last steps of dissemination; WHILE_DISSEMINATING: all of them; or ALWAYS
    every_message: bool  # else the latest of each robot
    stopped: int  # robots
    byzantine: int
    stubborn: int
    stop_step: int
    byzantine_says: int
    quorum: int  # a decision is at least this many counted robots of one opinion
    quorum_stopped: int  # the same once the stopped ones don't count
    steps: int
    stop_at_decision: bool
    robot_grid: Grid
    task_grid: Grid


class Cells(NamedTuple):
    """Points sorted into a square grid of cells; see `feasibee.engine.cells`."""

    points: Int32s  # (X, Y and LABEL, place): LABEL is who it is, and what else a search wants to know
    start: Int64s  # (cells + 2,): where each cell begins


class Kinds(NamedTuple):
    """Who is of which class, and what each class adds to each set of skills (model.md 6.7)."""

    of: Int32s  # (robot and then task,)
    adds: Int64s  # (set, class of robots and then of tasks)
    points: Int32s  # (robot and then task, xy): where they are, if it is given
    parameters: Floats  # the strategy's


class State(NamedTuple):
    """One swarm at one step. Axis 0 is a quantity, named below, and axis 1 the robot, padded, if not said.

    Few wide arrays, because every kernel that is passed the state compiles at the cost of its fields.
    """

    robots: Int32s  # (X to IDENTITY, robot)
    sets: Words  # (OPINIONS to LISTENING, word of robots)
    counts: Int64s  # (ROBOTS_SEEN to FEASIBLE_VOTES, robot)
    few: Words  # (SIGHT to HEARD_FEASIBLE, robot), up to 32 robots
    seen: Int64s  # (robot, class of robots and then of tasks), if there are several
    remembered: Words  # (robot, word): the robots and then the tasks that it remembers, if unique
    inbox: Int32s  # (SENDER to WHEN, robot, slot): hash tables; if together, only VALUES, by sender
    memory: Floats  # (robot, rated quality of *feasible* and then the strategy's own)
    knowledge: Words  # (KNOWN and TOLD, robot, word): see `feasibee.engine.knowledge`
    marks: Words  # (thing,): hashes, for sketches
    tasks: Int32s  # (X, Y and TASK_LABEL, task)
    task_cells: Cells
    robot_cells: Cells
    kinds: Kinds
    clock: Int64s  # (RUN to COMMITTED_INFEASIBLE,)


X, Y = 0, 1  # place
STEP_X, STEP_Y = 2, 3  # velocity, per step
WALK_LEFT = 4  # steps until the next heading
PHASE_LEFT = 5  # steps until the next phase
WALKS = 6  # headings drawn so far
PHASES = 7  # phases drawn so far
LABELS = 8  # see `feasibee.engine.sensing.label`
ORDER = 9  # a shuffle of the robots
TOLD_VALUE = 10  # the value in its messages
AGREED = 11  # decisions running with which its inbox agreed
MESSAGES = 12  # heard since the inbox was emptied
IDENTITY = 13  # the first robot that has its id

OPINIONS = 0  # who holds opinion 1
DISSEMINATING = 1
TURNING = 2  # whose heading ends with this step
ENDING = 3  # whose phase ends with this step
WORKING = 4  # who hasn't stopped
COUNTED = 5  # over whom the decision is taken
LIARS = 6  # who is Byzantine
STUBBORN = 7
BLOCKED = 8  # who stays where it is in this step
SPEAKING = 9  # who of those that disseminate has something to say
SAID = 10  # who of these says *feasible*
NEUTRAL = 11  # who has no opinion
COMMITTED = 12  # who has committed to its opinion
LISTENING = 13  # who hears in this step, with what is beyond the paper

ROBOTS_SEEN = 0  # n_obs of this exploration
TASKS_SEEN = 1  # m_obs
VOTES = 2  # messages in the inbox
FEASIBLE_VOTES = 3  # those with opinion 1

SIGHT = 0  # who is in sight of each
HEARD = 1  # who is in the inbox of each
HEARD_FEASIBLE = 2  # those with opinion 1

SENDER = 0  # label of the sender with its latest opinion, or -1
VALUES = 1  # that it sent
WHEN = 2  # the message's number among all heard

KNOWN, TOLD = 0, 1

TASK_LABEL = 2  # the task's number
LABEL = 2  # of a point in a cell

# The places in State.clock.
RUN = 0  # number of the run
STEP = 1  # steps done
FULL = 2  # 1 when an inbox table ran full
FEASIBLE_COUNT = 3  # counted robots with opinion 1
NEUTRAL_COUNT = 4  # those without an opinion
BITS = 5  # sent so far
COMMITTED_FEASIBLE = 6  # counted robots that have committed to opinion 1
COMMITTED_INFEASIBLE = 7


def packed(params: Params) -> Any:
    """Return the numbers as one record, which kernels are passed as a pointer.

    A tuple of sixty numbers is passed one by one: that took a third longer to compile.
    """
    record = np.recarray(1, dtype=_fields(params))
    record[0] = _plain(params)
    return record[0]


def _fields(numbers: Any) -> np.dtype[Any]:
    kinds = {bool: np.bool_, int: np.int64, float: np.float64, np.uint32: np.uint32, np.uint64: np.uint64}
    fields = [
        (name, _fields(each) if hasattr(each, "_fields") else kinds[type(each)])
        for name, each in zip(numbers._fields, numbers, strict=True)
    ]
    return np.dtype(fields, align=True)


def _plain(numbers: Any) -> tuple[Any, ...]:
    return tuple(_plain(each) if hasattr(each, "_fields") else each for each in numbers)


def empty_state(params: Params, kinds: Kinds, slots: int, memory: int = 0) -> State:
    """Allocate a swarm.

    ``slots`` is the room for senders in each inbox table, a power of two; ``memory`` is how many floats the
    strategy keeps for each robot.
    """
    words = -(-params.robots // WORD)
    padded = words * WORD
    classes = kinds.adds.shape[1]
    remembered = words + -(-params.tasks // WORD)
    things = params.robots + params.tasks
    inventions = things + 1 if params.byzantine else 0
    values = params.value_scale > 0
    state = State(
        robots=np.zeros((IDENTITY + 1, padded), np.int32),
        sets=np.zeros((LISTENING + 1, words), np.uint32),
        counts=np.zeros((FEASIBLE_VOTES + 1, padded), np.int64),
        few=np.zeros((HEARD_FEASIBLE + 1, WORD), np.uint32),
        seen=np.zeros((padded if params.mixed or params.knowledge else 0, classes), np.int64),
        remembered=np.zeros((padded if params.unique else 0, remembered), np.uint32),
        inbox=np.full(_inbox_shape(params, padded, slots, values), -1, np.int32),
        memory=np.zeros((padded, 1 + memory), np.float64),
        knowledge=np.zeros((2, padded, knowledge_words(params, classes)), np.uint32),
        marks=np.zeros(things + inventions if params.knowledge == SKETCH else 0, np.uint32),
        tasks=np.zeros((TASK_LABEL + 1, params.tasks), np.int32),
        task_cells=empty_cells(params.tasks, params.task_grid.bits),
        robot_cells=empty_cells(0 if params.together else params.robots, params.robot_grid.bits),
        kinds=kinds,
        clock=np.zeros(COMMITTED_INFEASIBLE + 1, np.int64),
    )
    state.tasks[TASK_LABEL] = np.arange(params.tasks)
    return state


def size_of(params: Params, kinds: Kinds, slots: int) -> int:
    """Return about how many bytes a swarm takes: of the arrays that grow faster than robots and tasks."""
    words = -(-params.robots // WORD)
    padded = words * WORD
    remembered = words + -(-params.tasks // WORD) if params.unique else 0
    inbox = math.prod(_inbox_shape(params, padded, slots, params.value_scale > 0))
    return 4 * (inbox + padded * (remembered + 2 * knowledge_words(params, kinds.adds.shape[1])))


def _inbox_shape(params: Params, padded: int, slots: int, values: bool) -> tuple[int, int, int]:
    if params.together:
        return (2, padded, WORD) if values else (1, 0, 1)
    if params.inbox_size:
        return (3, padded, slots)
    return (2 if values else 1, padded, slots)


def knowledge_words(params: Params, classes: int) -> int:
    """Return how many words a robot's knowledge takes."""
    if params.knowledge == TALLY:
        return params.robots * classes
    if params.knowledge == CENSUS:
        sides = (params.robots, params.tasks)
        inventions = (params.tasks, params.robots + 1) if params.byzantine else ()
        return sum(-(-things // WORD) for things in (*sides, *inventions))
    return REGISTERS * classes if params.knowledge == SKETCH else 0


def empty_cells(points: int, bits: int) -> Cells:
    """Allocate a grid with room for every point to stand in two strips and in their first column."""
    room = 4 * points + WORD
    cells = (2**bits + 1) * 2**bits
    return Cells(np.zeros((LABEL + 1, room), np.int32), np.zeros(cells + 2, np.int64))
