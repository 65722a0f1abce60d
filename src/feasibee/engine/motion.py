"""Motion: straight runs of exponential duration, and uniform headings (model.md 2)."""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.compile import inlined
from feasibee.engine.draws import draw_headings, list_members, next_heading
from feasibee.engine.intrinsics import bit_if
from feasibee.engine.layout import Heard, Robot, Set
from feasibee.model.codes import COS_EIGHTH


@inlined
def move_freely(state, part):
    """Move all robots one step on a square torus, through each other (model.md 3.1)."""
    xs, ys = state.robots[Robot.X], state.robots[Robot.Y]
    steps_x, steps_y = state.robots[Robot.STEP_X], state.robots[Robot.STEP_Y]
    for w in range(part.first, part.last):
        base = uint64(32 * w)
        for j in range(32):
            i = uint64(base + j)
            xs[i] += steps_x[i]
            ys[i] += steps_y[i]


@inlined
def shortened(length):
    """Return a length times the cosine of an eighth of a turn, rounded towards 0."""
    return (length * int64(COS_EIGHTH) + ((length >> 63) & 0xFFFFFFFF)) >> 32


@inlined
def tick(state, part):
    """Advance the timers; store whose heading and whose phase end with this step (model.md 3.3)."""
    walks_left, phases_left = state.robots[Robot.WALK_LEFT], state.robots[Robot.PHASE_LEFT]
    for w in range(part.first, part.last):
        turning = uint32(0)
        ending = uint32(0)
        base = uint64(32 * w)
        for j in range(32):
            i = uint64(base + j)
            walk_left = int32(walks_left[i] - int32(1))
            phase_left = int32(phases_left[i] - int32(1))
            walks_left[i] = walk_left
            phases_left[i] = phase_left
            turning |= bit_if(walk_left == int32(0), j)
            ending |= bit_if(phase_left == int32(0), j)
        state.sets[Set.TURNING, w] = turning | state.sets[Set.BLOCKED, w]
        state.sets[Set.ENDING, w] = ending


@inlined
def turn(params, state, part):
    """Draw a new heading for each robot whose straight run has ended."""
    w = part.first
    while w < part.last:
        w, count = list_members(state, part.thread, state.sets[Set.TURNING], w, part.last)
        draw_headings(params, state, part.thread, count)
        for k in range(count):
            head(params, state, part.thread, uint64(state.heard[part.thread, Heard.RECEIVER, k]), k)


@inlined
def head(params, state, thread, i, k):
    """Let a robot, entry ``k`` of those that draw, take its next heading (model.md 2.1)."""
    step_x, step_y, lasts = next_heading(params, state, thread, i, k)
    state.robots[Robot.WALKS, i] += int32(1)
    state.robots[Robot.STEP_X, i] = step_x
    state.robots[Robot.STEP_Y, i] = step_y
    state.robots[Robot.WALK_LEFT, i] = lasts
