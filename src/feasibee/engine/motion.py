"""How robots move: straight runs of exponential duration, headings uniform (model.md 2)."""

from __future__ import annotations

import math

from numba import int32, int64, uint32, uint64

from feasibee.engine.cells import lowest
from feasibee.engine.compile import kernel
from feasibee.engine.draws import direction, duration, philox
from feasibee.engine.layout import RUN
from feasibee.vocabulary import WALK


@kernel
def move(state):
    """Move all robots one step and note whose heading and whose phase end with it (model.md 3.1, 3.3)."""
    for w in range(state.opinions.size):
        turning = uint32(0)
        ending = uint32(0)
        base = uint64(32 * w)
        for j in range(32):
            i = uint64(base + j)
            state.x[i] += state.step_x[i]
            state.y[i] += state.step_y[i]
            walk_left = int32(state.walk_left[i] - int32(1))
            phase_left = int32(state.phase_left[i] - int32(1))
            state.walk_left[i] = walk_left
            state.phase_left[i] = phase_left
            turning |= uint32((uint32(1) << uint32(j)) if walk_left == int32(0) else uint32(0))
            ending |= uint32((uint32(1) << uint32(j)) if phase_left == int32(0) else uint32(0))
        state.turning[w] = turning
        state.ending[w] = ending


@kernel
def turn(params, state):
    """Give a new heading to each robot whose run has ended."""
    for w in range(state.turning.size):
        left = state.turning[w]
        while left:
            head(params, state, int64(32 * w + lowest(left)))
            left = uint32(left & uint32(left - uint32(1)))


@kernel
def head(params, state, i):
    """Draw a robot's next heading and how long it lasts (model.md 2.1)."""
    words = philox(state.walks[i], i, state.clock[RUN], WALK, params.seed_low, params.seed_high)
    state.walks[i] += uint32(1)
    cosine, sine = direction(words[0])
    state.step_x[i] = int32(int64(math.floor(params.reach * cosine + 0.5)))
    state.step_y[i] = int32(int64(math.floor(params.reach * sine + 0.5)))
    state.walk_left[i] = duration(words[1], params.mean_run)
