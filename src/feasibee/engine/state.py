"""One swarm at one step, as the engine has it: its memory, and the arrays in it by the names of state.h."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.engine.given import KINDS, Given
from feasibee.engine.params import Params

LINE: Final = 64
"""Bytes to a multiple of which the memory of a swarm begins."""


class Room(NamedTuple):
    """The room for inboxes with more senders than a line has."""

    slots: int  # of a table, a power of two
    tables: int

    @classmethod
    def first(cls, params: Params) -> Room:
        """Return the room that a swarm gets at first: few inboxes of a large swarm need a table."""
        robots = params.robots.count
        return cls(64, 0 if params.decision.inbox_is_set else min(robots, 1024 + robots // 16))


class State:
    """A swarm of a scenario; a copy of `block` is a copy of the swarm.

    Parameters
    ----------
    given : Given
        What the engine is given of the scenario.
    room : Room
        Room of the inboxes.
    threads : int
        Threads that simulate the swarm together.
    """

    def __init__(self, given: Given, room: Room, threads: int = 1) -> None:
        self._ffi, self._engine = given.ffi, given.engine
        self._given, self.room, self._params = given, room, given.params
        self.struct = _struct_of(given, threads)
        self.block = _aligned(self._lay_out(self._ffi.NULL))
        self._lay_out(self._ffi.from_buffer("char[]", self.block))

    def _lay_out(self, block: Any) -> int:
        return int(self._engine.feasibee_lay_out(self.struct, self.room, block))

    def start(self, run: int) -> None:
        """Put the swarm at step 0 of a run."""
        self._engine.feasibee_start(self.struct, run)

    def enlarged(self) -> Room:
        """Return a room with twice as much of what an inbox lacked."""
        if self.struct.clock.full == self._engine.SLOTS_LACK:
            return self.room._replace(slots=2 * self.room.slots)
        return self.room._replace(tables=2 * self.room.tables)

    # --- Arrays: views of the block, which the engine changes ---

    @cached_property
    def robots(self) -> Mapping[str, NDArray[np.int32]]:
        """Numbers of robots, by the names of ``enum robot_row``."""
        return self._rows("robots", "enum robot_row", self.struct.padded)

    @cached_property
    def sets(self) -> Mapping[str, NDArray[np.uint32]]:
        """Sets of robots, by the names of ``enum set``."""
        return self._rows("sets", "enum set", self.struct.words)

    @cached_property
    def counts(self) -> Mapping[str, NDArray[np.int64]]:
        """Counts of robots, by the names of ``enum count_row``."""
        return self._rows("counts", "enum count_row", self.struct.padded)

    @cached_property
    def links(self) -> Mapping[str, NDArray[np.uint32]]:
        """Sets of up to 128 robots for each, by the names of ``enum link``: shape (words, robots)."""
        return self._rows("links", "enum link", self.struct.words, self.struct.padded)

    @cached_property
    def inbox(self) -> Mapping[str, NDArray[np.int32]]:
        """Inboxes, by the names of ``enum slot_row``; those that the world doesn't need are empty."""
        return self._rows("inbox", "enum slot_row", self.struct.slots)

    @cached_property
    def tasks(self) -> Mapping[str, NDArray[np.int32]]:
        """Numbers of tasks, by the names of ``enum point``."""
        return self._rows("tasks", "enum point", self._params.tasks.count)

    def array(self, name: str, *shape: int) -> NDArray[Any]:
        """Return an array of ``struct state``; the last axis of one that the world doesn't need is empty."""
        return self._view(getattr(self.struct, name), *shape)

    def known(self) -> NDArray[np.int32]:
        """Return the words that robots know: shape (robots, words)."""
        words = self._view(
            self.struct.knowledge[self._engine.KNOWN], self._params.robots.count, self.struct.copy_words
        )
        return words[:, : self._params.strategy.knowledge.words]

    def _rows(self, name: str, enum: str, *shape: int) -> dict[str, NDArray[Any]]:
        found, names = getattr(self.struct, name), self._ffi.typeof(enum).elements
        return {names[k]: self._view(each, *shape) for k, each in enumerate(found)}

    def _view(self, found: Any, *shape: int) -> NDArray[Any]:
        kind = KINDS[self._ffi.typeof(found).item.cname]
        if not found:
            return np.zeros((*shape[:-1], 0), kind)
        start = int(self._ffi.cast("uintptr_t", found)) - self.block.ctypes.data
        size = math.prod(shape) * np.dtype(kind).itemsize
        return self.block[start : start + size].view(kind).reshape(shape)


def size_of(given: Given, room: Room) -> int:
    """Return how many bytes a swarm takes that one thread simulates."""
    return int(given.engine.feasibee_lay_out(_struct_of(given, 1), room, given.ffi.NULL))


def _struct_of(given: Given, threads: int) -> Any:
    """Return a ``struct state`` without its arrays."""
    params, rules, setting, memory = given.job
    numbers = {"params": params, "rules": rules, "setting": setting, "tables": given.tables}
    return given.ffi.new("struct state *", numbers | {"memory_length": memory, "threads": threads})


def _aligned(size: int) -> NDArray[np.uint8]:
    """Return zeros that begin at a multiple of `LINE`, so that no vector lies in two lines of the cache."""
    room = np.zeros(size + LINE, np.uint8)
    start = -room.ctypes.data % LINE
    return room[start : start + size]
