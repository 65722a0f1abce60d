"""The arrays that compiled code works on: the names of their axes, rows, units and allocation.

Positions and velocities are fixed-point numbers in int32. Their unit is the torus's longer side / 2**32. So
sums and differences on a square torus wrap by themselves, and a difference is the shortest way round. Within
walls the unit is twice that, and no difference wraps. Sets of robots are words of 32 bits: see
`feasibee.engine.intrinsics`. Arrays over robots are padded to whole words.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.engine.params import Grid, Params, Struct, fields_of
from feasibee.model.outcomes import ACCOUNT
from feasibee.model.record import Record
from feasibee.strategies.contract import Setting, Strategy

WORD = 32
"""Robots per word of a set."""
FEW = 128
"""Robots of the largest swarm that senses together: see `feasibee.engine.few`."""
LINE = 8
"""Slots for senders that each robot has, before its inbox takes a table."""
TILE = 4
"""Cells per side of a tile: see `feasibee.engine.crowd`."""
BATCH = 128
"""Draws of each kind that a thread makes together in a larger swarm."""
HEARD_ROOM = 512
"""Entries of `State.heard` from which on they are worked off."""
APART = 160
"""Entries by which rows of `State.heard` are longer than a power of two.

Rows that begin 4 KiB apart hinder each other in the cache: a third of the processes took 1.6 times as long.
"""
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
Bytes = NDArray[np.uint8]
Limits = NDArray[np.uint64]


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
    LABEL = 8  # see `feasibee.engine.intrinsics.pack_label`
    ORDER = 9  # a shuffle of the robots; while they are sorted, which of them comes where
    SENT_VALUE = 10  # the value in its messages
    AGREED = 11  # successive decisions with which its inbox agreed
    MESSAGES = 12  # heard since the inbox was emptied
    IDENTITY = 13  # the first robot with the same id
    TABLE = 14  # number of the table that its inbox takes, from 1 on, or 0
    LEAVES_AT = 15  # step at which it fails, in a world that changes
    JOINED = 16  # robots that had its number before it
    SWITCHES_AT = 17  # step at which it goes to charge, or comes back
    TARGET = 18  # number of the task to which it goes
    DETOUR = 19  # steps that it still goes another way
    BEGAN = 20  # step at which it began to act
    HEADING_X = 21  # of the run that waits while it goes to a task
    HEADING_Y = 22
    DONE_AT = 23  # step at whose beginning its task is done, if tasks take time
    SPARE = 24  # room: the tiles or cells of the robots, or sets while they are sorted


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
    LISTENING = 12  # hears in this step (general engine)
    DECLARED = 13
    DECLARED_FEASIBLE = 14  # those of them that declared feasible
    STOPPING = 15  # robots that stop at `FaultParams.stop_step`
    THERE = 16  # in the arena, whether they work or not
    JOINING = 17  # those that don't know yet what robots know when they begin, or in their first exploration
    TURNING_LEFT = 18  # blocked robots that deflect to the left
    CLEARED = 19  # those of them whose new step is clear, in larger swarms
    MET = 20  # robots in the way of which another one is
    MET_LEFT = 21  # on the left
    MET_RIGHT = 22
    LOOKING = 23  # observes in this step (general engine)
    AWAY = 24  # charge, out of the arena (model.md 6.23)
    PRESENT = 25  # for the truth and events: those there, and those away that count
    SPEAKING_AGAIN = 26  # those away that will speak when they are back
    ACTING = 27
    BOUND = 28  # those that have a target
    COURSED = 29  # those whose run waits in this step
    STANDING = 30  # at their tasks
    MARKED = 31  # those that have marked a task


class Count(IntEnum):
    """Rows of `State.counts`."""

    ROBOTS_SEEN = 0  # n_obs of this exploration
    TASKS_SEEN = 1  # m_obs
    VOTES = 2  # messages in the inbox
    FEASIBLE_VOTES = 3  # messages with opinion 1
    SENT_BITS = 4  # length of its message, if that is still a copy of what it knows; else -1
    SPARE = 5  # room to sort the others in


class Sense(IntEnum):
    """Parts of `Ground.limits`, each with a limit for each number of walls in between."""

    SIGHT = 0
    RADIO = 1


class Link(IntEnum):
    """Rows of `State.links`: for each robot a set of up to `FEW` robots."""

    SIGHT = 0  # robots in sight
    HEARD = 1  # senders in the inbox
    HEARD_FEASIBLE = 2  # senders in the inbox with opinion 1
    CLOSE = 3  # robots that it may meet within a step


class Slot(IntEnum):
    """Rows of `State.inbox`."""

    SENDER = 0  # label of the sender with its latest opinion, or -1
    VALUE = 1  # in that message
    WHEN = 2  # number of that message among all heard


class Heard(IntEnum):
    """Rows of `State.heard`: messages to be received, things to be observed, or draws to be made."""

    RECEIVER = 0  # place in the arrays of who receives, observes or draws
    SENDER = 1  # or what is observed: the number that it has in the cells
    NUMBER = 1  # of the robot that draws
    COUNTER = 2  # of the draw
    MEETING = 2  # of two robots: see `feasibee.engine.few.meeting_of`
    UNLUCKY = 2  # whether the sender isn't received or observed


class Copy(IntEnum):
    """Versions of a robot's knowledge in `State.knowledge`."""

    KNOWN = 0
    SENT = 1  # in the messages of this step


class Delayed(IntEnum):
    """Numbers of a message in `State.delayed`."""

    SAYS = 0  # the lowest bits of its label: opinion, and whether it is broadcast
    VALUE = 1
    LENGTH = 2  # of its knowledge, in bits
    TOLD = 3  # words of its knowledge from here on


class Pending(IntEnum):
    """Rows of `State.pending`; the second has a meaning for each action."""

    WHO = 0  # the robot for which a function is called
    NUMBER = 1  # of what it sees: robots, then tasks; negative for a false sighting
    FALSE_OPINION = 1  # opinion that its message must support if it is Byzantine, else -1
    SPEAKER = 1  # number of the robot that it hears
    COLUMN = 2  # class of a false sighting: classes of robots, then of tasks
    MARK = 3  # hash of a false sighting


class Pool(IntEnum):
    """Rows of a pool in `State.pools`; see `feasibee.engine.draws`."""

    STEP_X = 0  # of a heading: velocity per step
    STEP_Y = 1
    WALK = 2  # of a heading: the exponential of mean 1 of its duration, to 12 digits
    LENGTH = 3  # of a phase likewise
    CHANCE = 4  # of a phase: the second word of its draw as a share of 2**32
    TIE = 5  # of a phase: the third word of its draw


class Point(IntEnum):
    """Rows of `State.tasks` and of `Cells.points`."""

    X = 0
    Y = 1
    NUMBER = 2  # of the task; for a robot see `feasibee.engine.crowd.numbered`


class Clock(IntEnum):
    """Places in `State.clock`."""

    RUN = 0  # number of the run
    STEP = 1  # steps done
    FULL = 2  # why an inbox had no room: see `Lack`
    PENDING = 3  # entries of `State.pending`
    TABLE_SLOTS = 4  # slots of a table for an inbox
    COUNTED = 5  # robots over which the decision is taken
    QUORUM = 6  # least number of them with one opinion for a decision
    TRUTH = 7  # whether the tasks are feasible
    ROBOTS = 8  # in the arena
    TASKS = 9
    APPEARED = 10  # tasks so far
    EVENTS = 11  # events so far
    MISS = 12  # probabilities times 2**32
    LOSS = 13
    INVENTED_ROBOTS = 14  # in a message of a Byzantine robot that speaks for feasible
    INVENTED_TASKS = 15
    VANISHED = 16  # tasks by events of this step so far
    LEFT = 17  # robots likewise
    CHANGED = 18  # whether robots or tasks came or went at the beginning of this step
    MOST = 19  # tasks that the counted robots can take at once, in a world that stays


class Event(IntEnum):
    """Columns of `Tables.events`."""

    STEP = 0
    TASKS = 1  # that appear, or vanish if negative
    ROBOTS = 2  # that join, or leave
    MISS = 3  # new probability times 2**32, or -1
    LOSS = 4
    TASK = 5  # number of the one that vanishes or is put elsewhere, or -1
    ROBOT = 6
    X = 7  # where, or -1
    Y = 8


class Lack(IntEnum):
    """What an inbox lacked, which the runner then doubles."""

    SLOTS = 1  # in a table
    TABLES = 2


class Share(IntEnum):
    """Columns of `Part.shared`: what threads exchange. The last row belongs to all."""

    ROW = 0  # first row of cells that it sorts
    LEAVING = 1  # number of its robots that other threads sort
    POINTS = 2  # places that its cells take
    FEASIBLE_COUNT = 3  # sums over its robots
    NEUTRAL_COUNT = 4  # robots without an opinion
    BITS = 5
    DECLARED_FEASIBLE = 6
    DECLARED_INFEASIBLE = 7
    FULL = 8
    ENDED = 9  # whether this thread wants the run to end here
    ARRIVED = 0  # threads that wait, in the last row
    TURN = 8  # number of the times that all have waited: a cache line of its own


@dataclass(frozen=True, eq=False)
class Part(Struct):
    """A thread's part of the work on a swarm; see `feasibee.engine.team`."""

    thread: int
    threads: int
    first: int  # first word of its robots
    last: int  # the word after its last one
    give_way: int  # address of the system's function that lets other threads run, or 0
    shared: Annotated[Int64s, "thread", "Share"]


Alone = namedtuple("Alone", fields_of(Part))  # type: ignore[misc]  # mypy reads only lists written out
"""The part of one thread with up to 32 robots: compiled code knows all of it but the array."""


class Cells(NamedTuple):
    """Points sorted into a square grid of cells; see `feasibee.engine.cells`."""

    points: Annotated[Int32s, "Point", "place"]
    start: Annotated[Int32s, "cell"]  # first place of each cell, and the place after the last


class Ground(NamedTuple):
    """The cells of a place, row by row (model.md 6.20); see `feasibee.engine.place`."""

    walls: Annotated[Limits, "word of cells"]  # rows begin at whole words
    passable: Annotated[Limits, "word of cells"]
    open_around: Annotated[Bytes, "block"]  # cells in each direction to the nearest wall; 0 with one inside
    sketch: Annotated[Bytes, "cell"]  # the plan that robots know: see `feasibee.strategies.sight`
    limits: Annotated[Limits, "Sense, walls"]  # squared distances that are too far, behind so many walls
    stands: Annotated[Int32s, "cell"]  # where things are placed, piece by piece
    stand_of: Annotated[Int32s, "robot, then task", "first, number"]  # of its cells in `stands`
    lattice: Annotated[Int32s, "robot", "x, y"]


class Tables(NamedTuple):
    """The arrays of a scenario: classes, skills (model.md 6.7), given points, parameters, events, place."""

    class_of: Annotated[Int32s, "robot, then task"]
    adds: Annotated[Int64s, "set of skills", "class of robots, then of tasks"]  # per member of the class
    points: Annotated[Int32s, "robot, then task of the start", "x, y"]  # zeros unless they are given
    parameters: Annotated[Floats, "parameter"]
    ranks: Annotated[Int64s, "class of robots"]  # 1 for the most skilled (model.md 6.25.1)
    able: Annotated[Int64s, "class of robots", "class of tasks"]  # 1 if they can do them
    events: Annotated[Int64s, "event", "Event"]  # in their order (model.md 6.17)
    ground: Ground


@dataclass(frozen=True, eq=False)
class State(Struct):
    """One swarm at one step; robots are padded to whole words."""

    robots: Annotated[Int32s, "Robot", "robot"]
    sets: Annotated[Words, "Set", "word of robots"]
    counts: Annotated[Int64s, "Count", "robot"]
    links: Annotated[Words, "Link", "word of others", "robot"]  # up to `FEW` robots
    seen: Annotated[Int64s, "robot", "class of robots, then of tasks"]  # no rows unless there are several
    remembered: Annotated[Words, "robot", "word of robots, then of tasks"]  # for unique observation
    inbox: Annotated[Int32s, "Slot", "slot"]  # see `feasibee.engine.inbox`
    free_tables: Annotated[Int32s, "thread", "place"]  # their number, and their numbers
    heard: Annotated[Int32s, "thread", "Heard", "entry"]  # messages to be received
    tiles: Annotated[Int32s, "thread", "tile"]  # where its robots are sorted to
    memory: Annotated[Floats, "robot", "rated quality of *feasible*, then the strategy's own"]
    knowledge: Annotated[Int32s, "Copy", "robot", "word"]  # see `feasibee.engine.knowledge`
    delayed: Annotated[Int64s, "step", "robot", "Delayed"]  # messages of the last steps, if they are delayed
    pending: Annotated[Int32s, "Pending", "entry"]  # calls of the functions of a strategy's knowledge
    hashes: Annotated[Words, "robot, then task, then invention"]  # if robots pass on knowledge
    pools: Annotated[Floats, "robot", "Pool", "draw"]  # in large swarms of each thread
    tasks: Annotated[Int32s, "Point", "task"]
    names: Annotated[Int32s, "task"]  # the task whose name each has, if positions have errors
    tasks_there: Annotated[Words, "word of tasks"]
    vanish_at: Annotated[Int32s, "task"]  # steps at which lifetimes end, if tasks have any
    holders: Annotated[
        Int32s, "task"
    ]  # who has each, -1 for none, -2 if it is done; this and what follows if robots act
    news: Annotated[Int32s, "robot", "task"]  # versions that robots know: see `feasibee.engine.acting`
    told: Annotated[Int32s, "step", "robot", "task"]  # versions in messages of this and the last steps
    ways: Annotated[Int32s, "task, then queue", "cell"]  # if robots act in a place: see `feasibee.engine.way`
    task_cells: Cells
    task_places: Annotated[Words, "task"]  # packed, if few robots look through them by number
    robot_cells: Cells
    tables: Tables
    clock: Annotated[Int64s, "Clock"]
    account: Annotated[Int64s, "column of the account"]  # of the run so far


class Functions(NamedTuple):
    """The compiled functions that a scenario chooses: of its strategy, and of its world."""

    quality: Any
    dissemination: Any
    decide: Any
    say: Any
    value: Any
    lasting: Any
    probability: Any
    update: Any  # see `feasibee.engine.knowledge`
    change: Any  # see `feasibee.engine.dynamics`
    act: Any  # see `feasibee.engine.acting`


@dataclass(frozen=True, eq=False)
class Outcome(Struct):
    """The arrays of a `Record` that the engine fills in."""

    decision: Annotated[Int8s, "run"]
    decision_step: Annotated[Int32s, "run"]
    feasible_count: Annotated[Int32s, "run", "step"]  # no columns unless curves are asked for
    infeasible_count: Annotated[Int32s, "run", "step"]
    account: Annotated[Int64s, "run", "column of the account"]
    truth: Annotated[Int8s, "run", "step"]  # no columns unless the world changes
    held: Annotated[Int8s, "run", "step"]
    robots_present: Annotated[Int32s, "run", "step"]
    tasks_present: Annotated[Int32s, "run", "step"]


@dataclass(frozen=True, eq=False)
class Control(Struct):
    """The numbers that a simulating thread shares with the thread that waits for it."""

    steps_done: Annotated[Int64s, "one"]
    cancelled: Annotated[NDArray[np.bool_], "one"]


Player = Callable[[Record, Control], None]
"""What plays a chunk of runs, and fills in its part of the record."""


class RunError(Exception):
    """A strategy has raised an error in a run: the number of that run, and the error."""

    def __init__(self, run: int, error: Exception) -> None:
        super().__init__(run, error)
        self.run = run
        self.error = error


class Lowered(NamedTuple):
    """A scenario and a seed in the form that the engines take."""

    params: Params
    tables: Tables
    strategy: Strategy
    setting: Setting
    fast: bool  # whether the engine in C plays it, else the general one

    @property
    def form(self) -> tuple[Strategy, int, bool, bool]:
        """What the code of the general engine depends on; see `feasibee.engine.compiled.engine_functions`."""
        params = self.params
        return (
            self.strategy,
            words_together(params.robots.count),
            params.changes,
            params.acting.acts,
        )


def words_together(robots: int) -> int:
    """Return 1 if robots sense together in one word, 2 in several; 0 if they are too many for that."""
    return 0 if robots > FEW else 1 if robots <= WORD else 2


def empty_state(params: Params, tables: Tables, room: Room, memory: int = 0, threads: int = 1) -> State:
    """Allocate a swarm, of whose robots the strategy keeps ``memory`` floats each."""
    words = -(-params.robots.count // WORD)
    padded = words * WORD
    classes = tables.adds.shape[1]
    remembered = words + -(-params.tasks.count // WORD)
    knowledge, grid = params.strategy.knowledge, params.robots.grid
    tiles = -(-grid.columns // TILE) * -(-grid.rows // TILE)
    heard_room = HEARD_ROOM + max(params.robots.count, params.tasks.count) + WORD  # so much one robot may add
    if params.together:
        heard_room = max(heard_room, padded * padded // 2 + APART)  # all pairs may meet
    return State(
        robots=aligned((len(Robot), padded), np.int32),
        sets=np.zeros((len(Set), words), np.uint32),
        counts=aligned((len(Count), padded), np.int64),
        links=aligned((len(Link), words if params.together else 0, padded), np.uint32),
        seen=np.zeros((padded if params.sensing.by_class or knowledge.enabled else 0, classes), np.int64),
        remembered=np.zeros((padded if params.sensing.unique else 0, remembered), np.uint32),
        inbox=np.full(_inbox_shape(params, room), -1, np.int32),
        free_tables=np.zeros((threads, 1 + room.tables), np.int32),
        heard=aligned((threads, Heard.COUNTER + 1, heard_room), np.int32),
        tiles=np.zeros((threads if params.in_space_order else 0, tiles), np.int32),
        memory=np.zeros((padded, 1 + memory), np.float64),
        knowledge=np.zeros((len(Copy), padded, copy_length(params)), np.int32),
        delayed=np.zeros(_delayed_shape(params), np.int64),
        pending=np.zeros((Pending.MARK + 1, PENDING_ROOM if knowledge.enabled else 0), np.int32),
        hashes=np.zeros(knowledge.robot_ids + knowledge.task_ids if knowledge.enabled else 0, np.uint32),
        pools=aligned(_pool_shape(params, threads), np.float64),
        tasks=np.zeros((len(Point), params.tasks.count), np.int32),
        names=np.zeros(params.tasks.count if params.sensing.merges else 0, np.int32),
        tasks_there=np.zeros(-(-params.tasks.count // WORD), np.uint32),
        vanish_at=np.zeros(params.tasks.count if params.tasks.lifetime > 0 else 0, np.int32),
        **_empty_news(params, padded),
        ways=np.zeros(_ways_shape(params), np.int32),
        task_cells=empty_cells(params.tasks.count, params.tasks.grid),
        task_places=aligned((params.tasks.count + WORD,), np.uint32),
        robot_cells=empty_cells(0 if params.together else params.robots.count, params.robots.grid),
        tables=tables._replace(class_of=tables.class_of.copy()) if params.changes else tables,
        clock=np.where(np.arange(len(Clock)) == Clock.TABLE_SLOTS, room.slots, 0),
        account=np.zeros(len(ACCOUNT), np.int64),
    )


def _empty_news(params: Params, padded: int) -> dict[str, Any]:
    """Allocate what is of tasks if robots act."""
    tasks = params.tasks.count * params.acting.acts
    return {
        "holders": np.full(tasks, -1, np.int32),
        "news": np.zeros((padded, tasks), np.int32),
        "told": np.zeros((params.radio.delay + 1, padded, tasks), np.int32),
    }


class Room(NamedTuple):
    """The room for inboxes with more senders than a line has: see `feasibee.engine.inbox`."""

    slots: int  # of a table, a power of two
    tables: int


def first_room(params: Params) -> Room:
    """Return the room that a swarm gets at first: few inboxes of a large swarm need a table."""
    robots = params.robots.count
    return Room(64, 0 if params.decision.inbox_is_set else min(robots, 1024 + robots // 16))


def size_of(params: Params, tables: Tables, room: Room) -> int:
    """Return about how many bytes a swarm takes, without arrays of fixed size per robot or task."""
    words = -(-params.robots.count // WORD)
    padded = words * WORD
    remembered = words + -(-params.tasks.count // WORD) if params.sensing.unique else 0
    own = math.prod(_inbox_shape(params, room)) + padded * (remembered + 2 * copy_length(params))
    news = padded * params.tasks.count * params.acting.acts * (2 + params.radio.delay)
    return 4 * (own + news) + 8 * math.prod(_delayed_shape(params))


def _delayed_shape(params: Params) -> tuple[int, int, int]:
    padded = -(-params.robots.count // WORD) * WORD
    delay = params.radio.delay
    return delay + 1 if delay else 0, padded, Delayed.TOLD + params.strategy.knowledge.message_words


def _ways_shape(params: Params) -> tuple[int, int]:
    place = params.arena.place
    return (
        (params.tasks.count + 2, place.columns * place.rows)
        if place.exists and place.arrived >= 0
        else (0, 0)
    )


def _inbox_shape(params: Params, room: Room) -> tuple[int, int]:
    padded = -(-params.robots.count // WORD) * WORD
    values = params.strategy.value_scale > 0
    if params.decision.inbox_is_set:
        return (2, padded * padded) if values else (1, 0)
    rows = 3 if params.decision.inbox_size else 2 if values else 1
    return rows + params.in_space_order, padded * LINE + room.tables * room.slots


def _pool_shape(params: Params, threads: int) -> tuple[int, int, int]:
    pooled = params.robots.count <= POOLED
    return (params.robots.count, len(Pool), POOL) if pooled else (threads, len(Pool), BATCH)


def copy_length(params: Params) -> int:
    """Return the number of words of each `Copy`: of what a robot knows, and of its message."""
    return max(params.strategy.knowledge.words, params.strategy.knowledge.message_words)


def empty_cells(points: int, grid: Grid) -> Cells:
    """Allocate a grid where every point may be in the column that is repeated."""
    cells = (grid.columns + 1) * grid.rows
    return Cells(np.zeros((len(Point), 2 * points + WORD), np.int32), np.zeros(cells + 1, np.int32))


def aligned(shape: tuple[int, ...], kind: Any) -> Any:
    """Return zeros that begin at a multiple of 64 bytes, so that no vector lies in two lines of the cache."""
    size = math.prod(shape) * np.dtype(kind).itemsize
    room = np.zeros(size + 64, np.uint8)
    start = -room.ctypes.data % 64
    return room[start : start + size].view(kind).reshape(shape)
