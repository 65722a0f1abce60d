"""What is read from a swarm at a step: its robots in few bytes, all that one knows, a copy to return to."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from feasibee.base.codes import FLAGS

if TYPE_CHECKING:
    from feasibee.engine.params import Params
    from feasibee.engine.state import State

LINE = 8
"""Slots that each robot has for senders, before its inbox takes a table."""

SETS = tuple("FOR_FEASIBLE" if each == "feasible" else each.upper() for each in FLAGS)
"""The set of the engine whose members have each of them."""


class Snapshot(NamedTuple):
    """The robots of a step in few bytes, as a page draws them; an entry for each number of a robot."""

    x: NDArray[np.uint16]
    """Position of each robot, in 65,536ths of the arena's longer side."""
    y: NDArray[np.uint16]
    """Position of each robot, in the same unit."""
    flags: NDArray[np.uint16]
    """Properties of each robot: a bit for each of `FLAGS`, the lowest first."""
    heading: NDArray[np.uint8]
    """Direction of each robot, in 256ths of a turn, counterclockwise from the x axis."""


def snapshot_of(state: State, side: int, count: int) -> Snapshot:
    """Return the robots of a state; ``side`` is the longer side of the arena, in units of fixed point."""
    x, y, step_x, step_y = (state.robots[row][:count] for row in ("X", "Y", "STEP_X", "STEP_Y"))
    turns = np.arctan2(step_y.astype(np.float32), step_x.astype(np.float32)) * np.float32(128 / np.pi)
    flags = np.zeros(count, np.uint16)
    for bit, kind in enumerate(SETS):
        flags |= members(state.sets[kind])[:count].astype(np.uint16) << np.uint16(bit)
    return Snapshot(
        coarse(x, side), coarse(y, side), flags, np.round(turns).astype(np.int16).astype(np.uint8)
    )


def members(words: NDArray[np.uint32]) -> NDArray[np.int8]:
    """Return whether each number is a member of a set of the engine, as 1 or 0: int8, shape (numbers,)."""
    return np.unpackbits(words.view(np.uint8), bitorder="little").view(np.int8)


def coarse(fixed: NDArray[np.int32], side: int) -> NDArray[np.uint16]:
    """Convert fixed-point positions to 65,536ths of the arena's longer side, which has ``side`` units."""
    parts = (fixed.view(np.uint32).astype(np.uint64) << np.uint64(16)) // np.uint64(side)
    places: NDArray[np.uint16] = np.minimum(parts, 65535).astype(np.uint16)
    return places


class RobotState(NamedTuple):
    """One robot at one step: all that its controller knows and will use."""

    id: int
    """Id that it sends; two robots have the same if random ids collide."""
    hash: int
    """32 random bits of this id, if its strategy passes on knowledge."""
    place: tuple[float, float]
    """Its position in the frame that all robots share, in units."""
    kind: int
    """Number of its class, from 0; 0 without classes."""
    flags: int
    """Bits of `FLAGS`, the lowest first."""
    phase_left: int
    """Number of steps until its phase ends; of a stopped robot a large number."""
    broadcasts: int
    """Opinion in its messages: 1 feasible, 0 infeasible, -1 if it sends none."""
    robots_seen: tuple[int, ...]
    """Number of robots counted in this exploration, or in its life; with classes, for each class."""
    tasks_seen: tuple[int, ...]
    """Number of tasks counted, likewise."""
    feasible_quality: float
    """Quality of *feasible* when it was last rated; 0.5 before."""
    votes: tuple[int, int]
    """Number of messages in its inbox for feasible, and for infeasible."""
    heard: tuple[tuple[int, int, int], ...]
    """Id, latest opinion and value of each sender in its inbox, by id.

    None if the inbox keeps every message, or if robots pass on knowledge and don't declare by votes.
    """
    first_sight: bool
    """Whether it adopts, when this exploration ends, what its counts favour (model.md 6.10)."""
    agreed: int
    """Number of successive decisions with which its inbox agreed."""
    memory: tuple[float, ...]
    """Floats that its strategy keeps."""
    knowledge: tuple[int, ...]
    """Words that it knows, if its strategy passes on knowledge; at step 0 still zeros."""


def state_of(params: Params, state: State, i: int, place: tuple[float, float]) -> RobotState:
    """Return what a robot knows; ``place`` is its position in units."""
    inside = {kind: bool(words[i >> 5] >> (i & 31) & 1) for kind, words in state.sets.items()}
    kinds = params.robots.classes
    counted = [state.counts[row][i] for row in ("ROBOTS_SEEN", "TASKS_SEEN")]
    if params.sensing.by_class:
        counted = state.array("seen", state.struct.padded, state.struct.tables.classes)[i]
    first = kinds if params.sensing.by_class else 1
    heard = _heard_by(params, state, i)
    votes, feasible = len(heard), sum(opinion for _, opinion, _ in heard)
    if params.decision.every_message:
        votes, feasible = (int(state.counts[row][i]) for row in ("VOTES", "FEASIBLE_VOTES"))
    hashes = state.struct.hashes
    return RobotState(
        id=int(state.robots["IDENTITY"][i]),
        hash=int(hashes[i]) if hashes else 0,
        place=place,
        kind=int(state.struct.class_of[i]),
        flags=sum(inside[each] << bit for bit, each in enumerate(SETS)),
        phase_left=int(state.robots["PHASE_LEFT"][i]),
        broadcasts=int(inside["SAYS_FEASIBLE"]) if inside["SPEAKING"] else -1,
        robots_seen=tuple(map(int, counted[:first])),
        tasks_seen=tuple(map(int, counted[first:])),
        feasible_quality=float(state.struct.quality[i]),
        votes=(feasible, votes - feasible),
        heard=heard,
        first_sight=params.decision.first_sight and inside["JOINING"],
        agreed=int(state.robots["AGREED"][i]),
        memory=tuple(map(float, state.array("memory", state.struct.padded, state.struct.memory_length)[i])),
        knowledge=tuple(map(int, state.known()[i])),
    )


def _heard_by(params: Params, state: State, i: int) -> tuple[tuple[int, int, int], ...]:
    """Return id, opinion and value of each sender in an inbox; see ``messages.h``."""
    decision, padded = params.decision, state.struct.padded
    if decision.every_message:
        return ()
    values = state.inbox["VALUE"] if params.strategy.value_scale > 0 else None
    if decision.inbox_is_set:
        heard, feasible = (members(state.links[row][:, i].copy()) for row in ("HEARD", "HEARD_FEASIBLE"))
        senders = [j for j in range(padded) if heard[j]]
        return tuple((j, int(feasible[j]), _value(values, padded * i + j)) for j in senders)
    table, labels = int(state.robots["TABLE"][i]), state.inbox["SENDER"]
    slots = state.struct.clock.table_slots
    first, slots = (LINE * padded + (table - 1) * slots, slots) if table else (LINE * i, LINE)
    taken = [k for k in range(first, first + slots) if labels[k] >= 0]
    if decision.inbox_size > 0:
        taken = sorted(taken, key=lambda k: int(state.inbox["WHEN"][k]))[-decision.inbox_size :]
    found = [(labels[k] >> 2, labels[k] >> 1 & 1, _value(values, k)) for k in taken]
    return tuple(sorted((int(sender), int(opinion), value) for sender, opinion, value in found))


def _value(values: Any, slot: int) -> int:
    return 0 if values is None else int(values[slot])


class Saved(NamedTuple):
    """The state of a swarm at a step, to return to; see `feasibee.simulation.swarm.Swarm.save`."""

    step: int
    """Number of steps simulated."""
    nbytes: int
    """Memory that it takes, in bytes."""
    room: Any
    """Room of the inboxes."""
    arrays: tuple[NDArray[Any], ...]
    """Copies of the arrays that change in a run."""

    @classmethod
    def of(cls, step: int, room: Any, changing: Iterable[NDArray[Any]]) -> Self:
        """Copy the arrays of a step."""
        arrays = tuple(each.copy() for each in changing)
        return cls(step, sum(each.nbytes for each in arrays), room, arrays)

    def copy_to(self, changing: Iterable[NDArray[Any]]) -> None:
        """Overwrite the arrays of the same run by those of the step."""
        for array, old in zip(changing, self.arrays, strict=True):
            np.copyto(array, old)
