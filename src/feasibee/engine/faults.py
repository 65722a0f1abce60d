"""Faulty robots: which they are, and how some stop (model.md 6.6)."""

from __future__ import annotations

from numba import int64

from feasibee.engine.bits import lowest_member, set_member, without_lowest
from feasibee.engine.compile import called, inlined
from feasibee.engine.draws import shuffle
from feasibee.engine.layout import Clock, Robot, Set
from feasibee.engine.sensing import label_of
from feasibee.model.purposes import FAULT

NEVER = 2**31 - 1
"""Steps left until a stopped robot turns or ends its phase."""


@called
def draw_faults(params, state):
    """Draw the faulty robots: the first of a shuffle stop, the next lie, the next are stubborn."""
    if params.faults.stopped + params.faults.byzantine + params.faults.stubborn == 0:
        return
    shuffle(params, state.clock[Clock.RUN], state.robots[Robot.ORDER], params.robots.at_start, FAULT)
    for k in range(params.faults.stopped):
        set_member(state.sets, Set.STOPPING, int64(state.robots[Robot.ORDER, k]), True)
    for k in range(params.faults.byzantine):
        i = int64(state.robots[Robot.ORDER, params.faults.stopped + k])
        set_member(state.sets, Set.BYZANTINE, i, True)
        set_member(state.sets, Set.COUNTED, i, False)
    for k in range(params.faults.stubborn):
        i = int64(state.robots[Robot.ORDER, params.faults.stopped + params.faults.byzantine + k])
        set_member(state.sets, Set.STUBBORN, i, True)


@inlined
def stand_still(robots, i):
    """Let a robot neither move nor end a phase again."""
    robots[Robot.WALK_LEFT, i] = robots[Robot.PHASE_LEFT, i] = NEVER
    robots[Robot.STEP_X, i] = robots[Robot.STEP_Y, i] = 0


@called
def stop(params, state, w):
    """Stop the robots of a word with that fault for the rest of the run (model.md 6.6)."""
    stopping = state.sets[Set.STOPPING, w]
    left = stopping
    while left:
        stand_still(state.robots, lowest_member(w, left))
        left = without_lowest(left)
    for kind in (Set.WORKING, Set.COUNTED, Set.DISSEMINATING, Set.SPEAKING, Set.BLOCKED):
        state.sets[kind, w] &= ~stopping
    while stopping:
        i = lowest_member(w, stopping)
        state.robots[Robot.LABEL, i] = label_of(state, i)
        stopping = without_lowest(stopping)
