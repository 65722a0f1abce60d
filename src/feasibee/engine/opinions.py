"""Opinions that robots hold, as sets and labels, and how many hold which."""

from __future__ import annotations

from numba import int64

from feasibee.engine.compile import inlined
from feasibee.engine.intrinsics import contains, popcount, set_member
from feasibee.engine.layout import Clock, Set, Share
from feasibee.engine.team import total
from feasibee.model.codes import NO_OPINION
from feasibee.model.outcomes import (
    BITS_SENT,
    DECLARED_FEASIBLE,
    DECLARED_INFEASIBLE,
    FEASIBLE_AT_END,
    INFEASIBLE_AT_END,
)


@inlined
def opinion_of(sets, i):
    """Return a robot's opinion."""
    if contains(sets[Set.NEUTRAL], i):
        return int64(NO_OPINION)
    return int64(contains(sets[Set.FEASIBLE], i))


@inlined
def set_opinion(sets, i, opinion):
    """Set a robot's opinion; any value but 1 and 0 means none."""
    set_member(sets, Set.FEASIBLE, i, opinion == 1)
    set_member(sets, Set.NEUTRAL, i, not 0 <= opinion <= 1)


@inlined
def adopt(sets, i, opinion):
    """Set a robot's opinion, unless it never changes it again: it is stubborn, or has declared."""
    if not (contains(sets[Set.STUBBORN], i) or contains(sets[Set.DECLARED], i)):
        set_opinion(sets, i, opinion)


@inlined
def set_declared(sets, i, opinion):
    """Let a robot declare an opinion, which is 1 or 0; it declares once only (model.md 6.15)."""
    if not contains(sets[Set.DECLARED], i):
        set_member(sets, Set.DECLARED, i, True)
        set_member(sets, Set.DECLARED_FEASIBLE, i, opinion == 1)


@inlined
def may_declare(params):
    """Return whether robots declare, by their strategy or by votes (model.md 6.14, 6.15)."""
    return params.strategy.declares or params.decision.declare.enabled


@inlined
def count_opinions(params, state, part):
    """Count a thread's robots with opinion 1, without one, and that have declared, of the counted ones."""
    own = part.shared[part.thread]
    feasible = neutral = int64(0)
    for w in range(part.first, part.last):
        feasible += popcount(state.sets[Set.FEASIBLE, w] & state.sets[Set.COUNTED, w])
        neutral += popcount(state.sets[Set.NEUTRAL, w] & state.sets[Set.COUNTED, w])
    own[Share.FEASIBLE_COUNT], own[Share.NEUTRAL_COUNT] = feasible, neutral
    if may_declare(params):
        own[Share.DECLARED_FEASIBLE] = own[Share.DECLARED_INFEASIBLE] = 0
        for w in range(part.first, part.last):
            counted = state.sets[Set.DECLARED, w] & state.sets[Set.COUNTED, w]
            own[Share.DECLARED_FEASIBLE] += popcount(counted & state.sets[Set.DECLARED_FEASIBLE, w])
            own[Share.DECLARED_INFEASIBLE] += popcount(counted & ~state.sets[Set.DECLARED_FEASIBLE, w])


@inlined
def sum_counts(params, state, part):
    """Sum what all threads have counted, for the whole swarm."""
    account = state.account
    feasible, neutral = total(part, Share.FEASIBLE_COUNT), total(part, Share.NEUTRAL_COUNT)
    account[FEASIBLE_AT_END] = feasible
    account[INFEASIBLE_AT_END] = state.clock[Clock.COUNTED] - feasible - neutral
    account[BITS_SENT] += total(part, Share.BITS)
    if may_declare(params):
        account[DECLARED_FEASIBLE] = total(part, Share.DECLARED_FEASIBLE)
        account[DECLARED_INFEASIBLE] = total(part, Share.DECLARED_INFEASIBLE)


@inlined
def have_all_declared(params, state):
    """Return whether all counted robots have declared, and none of them stops later (model.md 6.15.8)."""
    declared = state.account[DECLARED_FEASIBLE] + state.account[DECLARED_INFEASIBLE]
    return declared == state.clock[Clock.COUNTED] and state.clock[Clock.STEP] >= params.faults.stop_step
