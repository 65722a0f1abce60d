"""One swarm: its start, one step, and the transitions of its robots (model.md 3, 4)."""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine.cells import fill, lowest, popcount
from feasibee.engine.compile import kernel
from feasibee.engine.draws import duration, philox
from feasibee.engine.layout import FEASIBLE_COUNT, FULL, RUN, STEP
from feasibee.engine.motion import head, move, turn
from feasibee.engine.sensing import count_votes, forget, has, label, sense
from feasibee.vocabulary import FIRST_OPINION, PHASE, PLACE_ROBOT, PLACE_TASK

NEVER = 2**31 - 1


@kernel
def start(params, state, run):
    """Put the swarm of a run at step 0 (model.md 1.2, 1.3, 4.1)."""
    state.clock[RUN] = run
    state.clock[STEP] = 0
    state.clock[FULL] = 0
    for t in range(params.tasks):
        words = philox(0, t, run, PLACE_TASK, params.seed_low, params.seed_high)
        state.task_x[t] = int32(words[0])
        state.task_y[t] = int32(words[1])
    fill(state.task_cells, params.task_bits, state.task_x, state.task_y, state.task_labels, params.tasks)
    for w in range(state.opinions.size):
        state.opinions[w] = uint32(0)
        state.disseminating[w] = uint32(0)
    for i in range(params.robots):
        words = philox(0, i, run, PLACE_ROBOT, params.seed_low, params.seed_high)
        state.x[i] = int32(words[0])
        state.y[i] = int32(words[1])
        words = philox(0, i, run, FIRST_OPINION, params.seed_low, params.seed_high)
        state.opinions[i >> 5] |= uint32(uint32(words[0] >> uint32(31)) << uint32(i & 31))
        state.walks[i] = uint32(0)
        head(params, state, i)
        state.phases[i] = uint32(0)
        enter_phase(params, state, i, params.exploration)
        state.votes[i] = 1  # makes sure that an inbox left by another run is emptied
        forget(params, state, i)
    for i in range(params.robots, state.x.size):
        state.walk_left[i] = NEVER
        state.phase_left[i] = NEVER
    count_opinions(state)


@kernel
def advance(params, state, quality, dissemination, decide):
    """Do one step (model.md 3.1 to 3.3)."""
    move(state)
    sense(params, state)
    turn(params, state)
    for w in range(state.ending.size):
        left = state.ending[w]
        while left:
            i = int64(32 * w + lowest(left))
            if has(state.disseminating, i):
                end_dissemination(params, state, i, decide)
            else:
                end_exploration(params, state, i, quality, dissemination)
            left = uint32(left & uint32(left - uint32(1)))
    state.clock[STEP] += 1
    count_opinions(state)


@kernel
def end_exploration(params, state, i, quality, dissemination):
    """Rate the own opinion, and broadcast it for as long as that warrants (model.md 4.3, 4.4)."""
    rho = quality(state.robots_seen[i], state.tasks_seen[i])
    if not has(state.opinions, i):
        rho = 1.0 - rho
    state.disseminating[i >> 5] |= bit(i)
    enter_phase(params, state, i, dissemination(rho, params.gain))


@kernel
def end_dissemination(params, state, i, decide):
    """Follow the inbox, and explore again (model.md 4.6)."""
    opinion = int64(has(state.opinions, i))
    feasible, infeasible = count_votes(params, state, i)
    feasible += params.own_vote * opinion
    infeasible += params.own_vote * (1 - opinion)
    if decide(opinion, feasible, infeasible) == 1:
        state.opinions[i >> 5] |= bit(i)
    else:
        state.opinions[i >> 5] &= ~bit(i)
    forget(params, state, i)
    state.disseminating[i >> 5] &= ~bit(i)
    enter_phase(params, state, i, params.exploration)


@kernel
def enter_phase(params, state, i, mean):
    """Draw how long a robot's new phase lasts."""
    words = philox(state.phases[i], i, state.clock[RUN], PHASE, params.seed_low, params.seed_high)
    state.phases[i] += uint32(1)
    state.phase_left[i] = duration(words[0], mean)
    state.labels[i] = label(state, i)


@kernel
def bit(i):
    """Return robot i's bit in its word."""
    return uint32(uint32(1) << uint32(i & 31))


@kernel
def count_opinions(state):
    """Note how many robots hold opinion 1."""
    total = 0
    for w in range(state.opinions.size):
        total += popcount(state.opinions[w])
    state.clock[FEASIBLE_COUNT] = total
