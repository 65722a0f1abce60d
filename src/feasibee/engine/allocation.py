"""The arrays of a swarm, allocated; see `feasibee.engine.layout` for what they hold."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from feasibee.engine.layout import (
    BATCH,
    HEARD_ROOM,
    LINE,
    PENDING_ROOM,
    POOL,
    POOLED,
    TILE,
    WORD,
    Bound,
    Cells,
    Clock,
    Copy,
    Count,
    Heard,
    Int64s,
    Link,
    Pending,
    Point,
    Pool,
    Robot,
    Set,
    State,
    Tables,
    TaskLists,
)
from feasibee.engine.params import Grid, Params


def empty_state(params: Params, tables: Tables, room: Room, memory: int = 0, threads: int = 1) -> State:
    """Allocate a swarm, of whose robots the strategy keeps ``memory`` floats each."""
    words = -(-params.robots.count // WORD)
    padded = words * WORD
    classes = tables.adds.shape[1]
    remembered = words + -(-params.tasks.count // WORD)
    knowledge = params.strategy.knowledge
    return State(
        robots=aligned((len(Robot), padded), np.int32),
        sets=np.zeros((len(Set), words), np.uint32),
        counts=aligned((len(Count), padded), np.int64),
        links=aligned((len(Link), WORD), np.uint32),
        seen=np.zeros((padded if params.sensing.by_class or knowledge.enabled else 0, classes), np.int64),
        remembered=np.zeros((padded if params.sensing.unique else 0, remembered), np.uint32),
        inbox=np.full(_inbox_shape(params, room), -1, np.int32),
        free_tables=np.zeros((threads, 1 + room.tables), np.int32),
        heard=aligned((threads, Heard.COUNTER + 1, _heard_room(params)), np.int32),
        tiles=np.zeros((threads if params.in_space_order else 0, _tile_count(params.robots.grid)), np.int32),
        memory=np.zeros((padded, 1 + memory), np.float64),
        knowledge=np.zeros((len(Copy), padded, copy_length(params)), np.int32),
        pending=np.zeros((Pending.MARK + 1, PENDING_ROOM if knowledge.enabled else 0), np.int32),
        hashes=np.zeros(knowledge.robot_ids + knowledge.task_ids if knowledge.enabled else 0, np.uint32),
        pools=aligned(_pool_shape(params, threads), np.float64),
        tasks=np.zeros((len(Point), params.tasks.count), np.int32),
        tasks_there=np.zeros(-(-params.tasks.count // WORD), np.uint32),
        vanish_at=np.zeros(params.tasks.count if params.tasks.lifetime > 0 else 0, np.int32),
        task_cells=empty_cells(params.tasks.count, params.tasks.grid),
        task_lists=empty_lists(params.tasks.count, params.tasks.lists.bits),
        robot_cells=empty_cells(0 if params.together else params.robots.count, params.robots.grid),
        tables=tables._replace(class_of=tables.class_of.copy()) if params.changes else tables,
        clock=_clock(room),
    )


def _clock(room: Room) -> Int64s:
    clock = np.zeros(len(Clock), np.int64)
    clock[Clock.TABLE_SLOTS] = room.slots
    return clock


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
    return 4 * (math.prod(_inbox_shape(params, room)) + padded * (remembered + 2 * copy_length(params)))


def _inbox_shape(params: Params, room: Room) -> tuple[int, int]:
    padded = -(-params.robots.count // WORD) * WORD
    values = params.strategy.value_scale > 0
    if params.decision.inbox_is_set:
        return (2, padded * WORD) if values else (1, 0)
    rows = 3 if params.decision.inbox_size else 2 if values else 1
    return rows + params.in_space_order, padded * LINE + room.tables * room.slots


def _pool_shape(params: Params, threads: int) -> tuple[int, int, int]:
    pooled = params.robots.count <= POOLED
    return (params.robots.count, len(Pool), POOL) if pooled else (threads, len(Pool), BATCH)


def _heard_room(params: Params) -> int:
    return HEARD_ROOM + max(params.robots.count, params.tasks.count) + WORD  # so much one robot may add


def _tile_count(grid: Grid) -> int:
    return -(-grid.columns // TILE) * -(-grid.rows // TILE)


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


def empty_lists(tasks: int, bits: int) -> TaskLists:
    """Allocate lists where every task may be in nine, each padded to 16 places; or one list of all."""
    cells = 4**bits if bits else 0
    room = 9 * tasks + 16 * cells + 1 if bits else tasks + WORD
    return TaskLists(aligned((room,), np.uint32), aligned((len(Bound), cells), np.int64))
