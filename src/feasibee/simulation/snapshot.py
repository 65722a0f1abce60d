"""What is read from a swarm at a step: its robots in few bytes, all that one knows, a copy to return to."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from feasibee.model.record import Record

if TYPE_CHECKING:
    from feasibee.engine.layout import State
    from feasibee.engine.params import Params

CONSTANT = frozenset(("robot_cells", "tasks", "task_cells", "task_places", "tables", "ways"))
"""Fields of the state that stay the same in a run, or that are tuples of arrays."""

FLAGS = (
    "feasible",
    "neutral",
    "disseminating",
    "declared",
    "working",
    "byzantine",
    "stubborn",
    "there",
    "standing",
)
"""Properties of robots, each a set of the engine; ``there`` is false where no robot has the number."""


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


def snapshot_of(state: Any, side: int, places: Any) -> Snapshot:
    """Return the robots of a state, of which ``places`` says where the state has each.

    ``side`` is the longer side of the arena, in units of fixed point.
    """
    from feasibee.engine.layout import Robot

    x, y, step_x, step_y = state.robots[[Robot.X, Robot.Y, Robot.STEP_X, Robot.STEP_Y]][:, places]
    turns = np.arctan2(step_y.astype(np.float32), step_x.astype(np.float32)) * np.float32(128 / np.pi)
    flags = np.zeros(x.size, np.uint16)
    for bit, kind in enumerate(sets_of_flags()):
        flags |= members(state.sets[kind])[places].astype(np.uint16) << np.uint16(bit)
    return Snapshot(
        coarse(x, side), coarse(y, side), flags, np.round(turns).astype(np.int16).astype(np.uint8)
    )


def sets_of_flags() -> list[int]:
    """Return the set of the engine whose members have each of `FLAGS`."""
    from feasibee.engine.layout import Set

    return [Set[name.upper()] for name in FLAGS]


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


def state_of(
    params: Params, state: State, i: int, number: int, place: tuple[float, float], kinds: int
) -> RobotState:
    """Return what the robot at place ``i`` of the arrays, of the given number, knows.

    ``place`` is its position in units, ``kinds`` the number of classes of robots, at least 1.
    """
    from feasibee.engine.layout import Copy, Count, Robot, Set

    inside = [bool(words[i >> 5] >> (i & 31) & 1) for words in state.sets]
    rows, counts = state.robots[:, i], state.counts[:, i]
    by_class = params.sensing.by_class
    seen, first = (state.seen[i], kinds) if by_class else (counts[[Count.ROBOTS_SEEN, Count.TASKS_SEEN]], 1)
    heard = _heard_by(params, state, i)
    votes, feasible = len(heard), sum(opinion for _, opinion, _ in heard)
    if params.decision.every_message:
        votes, feasible = int(counts[Count.VOTES]), int(counts[Count.FEASIBLE_VOTES])
    return RobotState(
        id=int(rows[Robot.IDENTITY]),
        hash=int(state.hashes[i]) if state.hashes.size else 0,
        place=place,
        kind=int(state.tables.class_of[number]),
        flags=sum(inside[each] << bit for bit, each in enumerate(sets_of_flags())),
        phase_left=int(rows[Robot.PHASE_LEFT]),
        broadcasts=int(inside[Set.SAYS_FEASIBLE]) if inside[Set.SPEAKING] else -1,
        robots_seen=tuple(map(int, seen[:first])),
        tasks_seen=tuple(map(int, seen[first:])),
        feasible_quality=float(state.memory[i, 0]),
        votes=(feasible, votes - feasible),
        heard=heard,
        first_sight=params.decision.first_sight and inside[Set.JOINING],
        agreed=int(rows[Robot.AGREED]),
        memory=tuple(map(float, state.memory[i, 1:])),
        knowledge=tuple(map(int, state.knowledge[Copy.KNOWN, i, : params.strategy.knowledge.words])),
    )


def _heard_by(params: Params, state: State, i: int) -> tuple[tuple[int, int, int], ...]:
    """Return id, opinion and value of each sender in an inbox; see `feasibee.engine.inbox`."""
    from feasibee.engine.layout import LINE, Clock, Link, Robot, Slot

    decision = params.decision
    if decision.every_message:
        return ()
    values = state.inbox[Slot.VALUE] if params.strategy.value_scale > 0 else None
    if decision.inbox_is_set:
        padded = state.links.shape[2]
        heard, feasible = (
            members(state.links[row, :, i].copy()) for row in (Link.HEARD, Link.HEARD_FEASIBLE)
        )
        senders = [j for j in range(padded) if heard[j]]
        return tuple((j, int(feasible[j]), _value(values, padded * i + j)) for j in senders)
    table, first, slots = int(state.robots[Robot.TABLE, i]), LINE * i, LINE
    if table:
        slots = int(state.clock[Clock.TABLE_SLOTS])
        first = LINE * state.robots.shape[1] + (table - 1) * slots
    labels = state.inbox[Slot.SENDER, first : first + slots].tolist()
    taken = [k for k, label in enumerate(labels, first) if label >= 0]
    if decision.inbox_size > 0:
        taken = sorted(taken, key=lambda k: int(state.inbox[Slot.WHEN, k]))[-decision.inbox_size :]
    found = [(labels[k - first] >> 2, labels[k - first] >> 1 & 1, _value(values, k)) for k in taken]
    return tuple(sorted(found))


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


def changing_arrays(state: Any, record: Record, changes: bool) -> list[NDArray[Any]]:
    """Return the arrays that a step may change, without the curves: they are written again.

    Parameters
    ----------
    state : State
        The swarm.
    record : Record
        Its outcomes.
    changes : bool
        Whether the world changes (model.md 6.17), and tasks with it.
    """
    arrays = [getattr(state, each.name) for each in fields(state) if each.name not in CONSTANT]
    if changes:  # places and classes belong to numbers: the next task of a number has the same again
        arrays += [*state.task_cells, state.task_places]
    return [*arrays, *state.robot_cells, record.decision, record.decision_step, record.account]
