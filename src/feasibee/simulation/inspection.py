"""What one robot of a swarm knows at a step, read from the engine's arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

from feasibee.engine.layout import LINE, WORD, Clock, Copy, Count, Link, Robot, Set, Slot, State
from feasibee.engine.params import Params
from feasibee.simulation.snapshot import sets_of_flags


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

    None if the inbox keeps every message, or if robots pass on knowledge and have no rule to commit.
    """
    agreed: int
    """Number of successive decisions with which its inbox agreed."""
    memory: tuple[float, ...]
    """Floats that its strategy keeps."""
    knowledge: tuple[int, ...]
    """Words that it knows, if its strategy passes on knowledge; at step 0 still zeros."""


def state_of(
    params: Params, state: State, i: int, number: int, place: tuple[float, float], kinds: int
) -> RobotState:
    """Return what the robot at a place of the arrays knows.

    Parameters
    ----------
    params, state : Params, State
        The swarm.
    i, number : int
        Place of the robot in the arrays, and its number.
    place : tuple of float
        Its position in units.
    kinds : int
        Number of classes of robots, at least 1.
    """
    inside = [bool(words[i >> 5] >> (i & 31) & 1) for words in state.sets]
    rows, counts = state.robots[:, i], state.counts[:, i]
    seen, first = counts[[Count.ROBOTS_SEEN, Count.TASKS_SEEN]], 1
    if params.sensing.by_class:
        seen, first = state.seen[i], kinds
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
        feasible_quality=float(state.memory[i, 0]) if rows[Robot.PHASES] > 1 else 0.5,
        votes=(feasible, votes - feasible),
        heard=heard,
        agreed=int(rows[Robot.AGREED]),
        memory=tuple(map(float, state.memory[i, 1:])),
        knowledge=tuple(map(int, state.knowledge[Copy.KNOWN, i, : params.strategy.knowledge.words])),
    )


def _heard_by(params: Params, state: State, i: int) -> tuple[tuple[int, int, int], ...]:
    """Return id, opinion and value of each sender in an inbox; see `feasibee.engine.inbox`."""
    decision = params.decision
    if decision.every_message:
        return ()
    values = state.inbox[Slot.VALUE] if params.strategy.value_scale > 0 else None
    if decision.inbox_is_set:
        heard, feasible = int(state.links[Link.HEARD, i]), int(state.links[Link.HEARD_FEASIBLE, i])
        senders = [j for j in range(WORD) if heard >> j & 1]
        return tuple((j, feasible >> j & 1, _value(values, WORD * i + j)) for j in senders)
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
