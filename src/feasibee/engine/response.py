"""An operator who calls for robots, or releases them, by the opinion held (model.md 6.19)."""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import int64, uint32

from feasibee.engine.bits import lowest_member, without_lowest
from feasibee.engine.compile import called, inlined
from feasibee.engine.intrinsics import popcount
from feasibee.engine.knowledge import defer, update_pending
from feasibee.engine.layout import Clock, Set
from feasibee.engine.params import Action
from feasibee.model.codes import COUNT_LIMIT, FEASIBLE, INFEASIBLE, UNDECIDED


class Asking(NamedTuple):
    """The one function of a strategy that the operator needs."""

    update: Any


@called
def begin_response(clock):
    """Let the operator begin: nothing was held, and nobody is on the way."""
    clock[Clock.WAS_HELD], clock[Clock.HELD_FOR] = UNDECIDED, 0
    clock[Clock.ARRIVES_AT], clock[Clock.AWAITED] = -1, 0
    clock[Clock.CALLS] = clock[Clock.ROBOTS_CALLED] = clock[Clock.ROBOTS_RELEASED] = 0


@called
def look(params, state, update, now):
    """Look at the opinion held after the step before; call robots, or return how many are to spare."""
    clock, held = state.clock, state.clock[Clock.HELD]
    if now <= clock[Clock.ARRIVES_AT]:
        clock[Clock.HELD_FOR] = 0
        return int64(0)
    if held != clock[Clock.WAS_HELD]:
        clock[Clock.HELD_FOR] = 0
    clock[Clock.HELD_FOR] += 1
    clock[Clock.WAS_HELD] = held
    if held == UNDECIDED or clock[Clock.HELD_FOR] < params.response.patience:
        return int64(0)
    clock[Clock.HELD_FOR] = 0
    asked = ask(params, state, Asking(update), held) if params.response.asks else int64(0)
    gap = lower_median(state, held, asked) if asked > 0 else int64(0)
    if held == INFEASIBLE:
        wanted = gap + params.response.margin if asked > 0 else int64(1)
        clock[Clock.AWAITED] = min(max(wanted, 1), params.robots.count)
        clock[Clock.ARRIVES_AT] = now + params.response.delay
        clock[Clock.CALLS] += 1
        clock[Clock.ROBOTS_CALLED] += clock[Clock.AWAITED]
        return int64(0)
    return max(int64(0), -gap - params.response.margin)


@inlined
def word_of(state, w, held):
    """Return the counted robots of a word that hold an opinion."""
    counted = state.sets[Set.COUNTED, w]
    if held == FEASIBLE:
        return uint32(counted & state.sets[Set.FEASIBLE, w])
    return uint32(counted & ~state.sets[Set.FEASIBLE, w] & ~state.sets[Set.NEUTRAL, w])


@inlined
def ask(params, state, functions, held):
    """Let the counted robots of an opinion write their gaps as their first counts; return their number."""
    asked = int64(0)
    for w in range(state.sets.shape[1]):
        left = word_of(state, w, held)
        asked += popcount(left)
        while left:
            defer(params, state, functions, Action.GAP, lowest_member(w, left), int64(0), int64(0))
            left = without_lowest(left)
    update_pending(params, state, functions, Action.GAP)
    return asked


@inlined
def lower_median(state, held, asked):
    """Return the least gap that at least half of those asked don't exceed, by halving its range."""
    low, high = int64(-COUNT_LIMIT), int64(COUNT_LIMIT)
    while low < high:
        middle = low + (high - low) // 2
        below = int64(0)
        for w in range(state.sets.shape[1]):
            left = word_of(state, w, held)
            while left:
                below += int64(state.seen[lowest_member(w, left), 0] <= middle)
                left = without_lowest(left)
        if 2 * below >= asked:
            high = middle
        else:
            low = middle + 1
    return low
