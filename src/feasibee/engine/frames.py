"""Own frames: robots whose odometry drifts, and where they believe tasks to be (model.md 6.27)."""

from __future__ import annotations

from numba import int32, int64

from feasibee.engine.compile import called, inlined
from feasibee.engine.draws import normal
from feasibee.engine.layout import Clock, Error, Robot
from feasibee.model.purposes import DRIFT


@called
def begin_frame(params, state, i):
    """Draw the drift of a robot that begins, and let it have seen no task."""
    if params.acting.drift == 0:
        return
    run, counter = state.clock[Clock.RUN], 6 * int64(state.robots[Robot.JOINED, i])
    drift = params.acting.drift
    state.robots[Robot.DRIFT_X, i] = int32(normal(params, run, i, counter, int64(DRIFT), drift))
    state.robots[Robot.DRIFT_Y, i] = int32(normal(params, run, i, counter + 3, int64(DRIFT), drift))
    state.errors[i] = 0


@called
def drift_all(params, state):
    """Add each robot's drift to its errors."""
    for i in range(state.errors.shape[0]):
        for task in range(state.errors.shape[1]):
            state.errors[i, task, Error.X] += state.robots[Robot.DRIFT_X, i]
            state.errors[i, task, Error.Y] += state.robots[Robot.DRIFT_Y, i]


@inlined
def believed(params, state, i, task, x, y):
    """Return the way to where a robot believes a task to be, from the way to the task."""
    if params.acting.drift == 0:
        return x, y
    x, y = x + state.errors[i, task, Error.X], y + state.errors[i, task, Error.Y]
    width, height = params.arena.width, params.arena.height
    if params.arena.walls:
        return min(max(x, -width), width), min(max(y, -height), height)
    return (x + width // 2) % width - width // 2, (y + height // 2) % height - height // 2


@inlined
def see_place(params, state, i, task):
    """Let a robot know where a task is."""
    if params.acting.drift > 0:
        error = state.errors[i, task]
        error[Error.X] = error[Error.Y] = 0
        error[Error.SEEN] = state.clock[Clock.STEP] + 1


@inlined
def tell_places(state, slot, i):
    """Fix where a robot says that tasks are."""
    for task in range(state.errors.shape[1]):
        for k in range(state.errors.shape[2]):
            state.told_errors[slot, i, task, k] = state.errors[i, task, k]


@inlined
def is_late(params, state, i, slot, sender, task):
    """Return whether a robot has forgotten a task later than it was seen by whom it hears of it."""
    if params.acting.drift == 0 or state.news[i, task] != 0:
        return False
    return state.told_errors[slot, sender, task, Error.SEEN] <= state.errors[i, task, Error.SEEN]


@inlined
def hear_place(params, state, i, slot, sender, task):
    """Let a robot take over where a task is that it knows, if it was seen later."""
    if params.acting.drift == 0 or state.news[i, task] == 0 or state.told[slot, sender, task] == 0:
        return
    told, own = state.told_errors[slot, sender, task], state.errors[i, task]
    if told[Error.SEEN] > own[Error.SEEN]:
        for k in range(own.size):
            own[k] = told[k]
