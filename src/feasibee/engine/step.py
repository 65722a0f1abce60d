"""One swarm: its start, one step, and the transitions of its robots (model.md 3, 4)."""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine.cells import fill, first_bits, lowest, popcount
from feasibee.engine.compile import kernel, subroutine
from feasibee.engine.draws import draw, duration, shuffle
from feasibee.engine.layout import (
    BLOCKED,
    COUNTED,
    DISSEMINATING,
    ENDING,
    FEASIBLE_COUNT,
    FULL,
    LABELS,
    LIARS,
    OPINIONS,
    ORDER,
    PHASE_LEFT,
    PHASES,
    ROBOTS_SEEN,
    RUN,
    STEP,
    STEP_X,
    STEP_Y,
    STUBBORN,
    TASK_LABEL,
    TASKS_SEEN,
    VOTES,
    WALK_LEFT,
    WALKS,
    WORKING,
    X,
    Y,
)
from feasibee.engine.motion import head, move_freely, move_where_clear, tick, turn
from feasibee.engine.placing import place_robots, place_tasks, scatter
from feasibee.engine.sensing import count_votes, fill_robots, forget, has, label, sense_beyond, sense_paper
from feasibee.vocabulary import FAULT, FIRST_OPINION, PHASE

NEVER = 2**31 - 1


@kernel
def start_paper(params, state, run):
    """Put the swarm of a run at step 0, with nothing beyond the paper (model.md 1.2, 1.3, 4.1)."""
    clear(params, state, run)
    scatter(params, state)
    make_ready(params, state)


@kernel
def start_beyond(params, state, run):
    """Put any swarm at step 0 (model.md 6)."""
    clear(params, state, run)
    place_tasks(params, state)
    place_robots(params, state)
    draw_faults(params, state)  # last: `stop` relies on the shuffle that it leaves
    make_ready(params, state)
    if params.unique:
        state.known[:] = uint32(0)
    if params.stop_step == 0:
        stop(params, state)
    fill_robots(params, state)


@subroutine
def clear(params, state, run):
    """Forget the run before."""
    state.clock[RUN] = run
    state.clock[STEP] = 0
    state.clock[FULL] = 0
    for w in range(state.sets.shape[1]):
        for kind in range(state.sets.shape[0]):
            state.sets[kind, w] = uint32(0)
        state.sets[WORKING, w] = first_bits(params.robots - 32 * w)
        state.sets[COUNTED, w] = state.sets[WORKING, w]


@subroutine
def make_ready(params, state):
    """Give the robots that stand in their places a first opinion, heading and phase (model.md 2.1, 4.1)."""
    fill(
        state.task_cells,
        params.task_grid,
        state.tasks[X],
        state.tasks[Y],
        state.tasks[TASK_LABEL],
        params.tasks,
    )
    for i in range(params.robots):
        word = draw(params, state.clock[RUN], i, 0, FIRST_OPINION)
        state.sets[OPINIONS, i >> 5] |= uint32(uint32(word >> uint32(31)) << uint32(i & 31))
        state.robots[WALKS, i] = 0
        head(params, state, i)
        state.robots[PHASES, i] = 0
        enter_phase(params, state, i, params.exploration)
        state.counts[VOTES, i] = 1  # makes sure that an inbox left by another run is emptied
        forget(params, state, i)
    for i in range(params.robots, state.robots.shape[1]):
        state.robots[WALK_LEFT, i] = NEVER
        state.robots[PHASE_LEFT, i] = NEVER
    count_opinions(state)


@subroutine
def draw_faults(params, state):
    """Draw which robots are faulty: the first of a shuffle stop, the next lie, the next are stubborn."""
    if params.stopped + params.byzantine + params.stubborn == 0:
        return
    shuffle(params, state.clock[RUN], state.robots[ORDER], params.robots, FAULT)
    for k in range(params.byzantine):
        i = int64(state.robots[ORDER, params.stopped + k])
        state.sets[LIARS, i >> 5] |= bit(i)
        state.sets[COUNTED, i >> 5] &= ~bit(i)
    for k in range(params.stubborn):
        i = int64(state.robots[ORDER, params.stopped + params.byzantine + k])
        state.sets[STUBBORN, i >> 5] |= bit(i)


@subroutine
def stop(params, state):
    """Let the robots with that fault stop, once and for all (model.md 6.6)."""
    if params.stopped == 0:
        return
    for k in range(params.stopped):
        i = int64(state.robots[ORDER, k])
        state.robots[WALK_LEFT, i] = NEVER
        state.robots[PHASE_LEFT, i] = NEVER
        state.robots[STEP_X, i] = 0
        state.robots[STEP_Y, i] = 0
        state.sets[WORKING, i >> 5] &= ~bit(i)
        state.sets[COUNTED, i >> 5] &= ~bit(i)
        state.sets[DISSEMINATING, i >> 5] &= ~bit(i)
        state.sets[BLOCKED, i >> 5] &= ~bit(i)
        state.robots[LABELS, i] = label(params, state, i)
    count_opinions(state)


@kernel
def advance_paper(params, state, quality, dissemination, decide):
    """Do one step, with nothing beyond the paper (model.md 3.1 to 3.3)."""
    move_freely(state)
    tick(state)
    sense_paper(params, state)
    finish(params, state, quality, dissemination, decide)


@kernel
def advance_beyond(params, state, quality, dissemination, decide):
    """Do one step of any swarm."""
    if params.stopped > 0 and state.clock[STEP] + 1 == params.stop_step:
        stop(params, state)
    move_where_clear(params, state)
    tick(state)
    sense_beyond(params, state)
    finish(params, state, quality, dissemination, decide)


@kernel
def finish(params, state, quality, dissemination, decide):
    """Turn the robots whose heading ends, and let those whose phase ends make their transition."""
    turn(params, state)
    for w in range(state.sets.shape[1]):
        left = state.sets[ENDING, w]
        while left:
            i = int64(32 * w + lowest(left))
            if has(state.sets[DISSEMINATING], i):
                end_dissemination(params, state, i, decide)
            else:
                end_exploration(params, state, i, quality, dissemination)
            left = uint32(left & uint32(left - uint32(1)))
    state.clock[STEP] += 1
    count_opinions(state)


@kernel
def end_exploration(params, state, i, quality, dissemination):
    """Rate the own opinion, and broadcast it for as long as that warrants (model.md 4.3, 4.4)."""
    if state.seen.shape[0] > 0:
        rho = scarcest(params, state, i, quality)
    else:
        rho = quality(state.counts[ROBOTS_SEEN, i], state.counts[TASKS_SEEN, i])
    if not has(state.sets[OPINIONS], i):
        rho = 1.0 - rho
    state.sets[DISSEMINATING, i >> 5] |= bit(i)
    enter_phase(params, state, i, dissemination(rho, params.gain))


@subroutine
def scarcest(params, state, i, quality):
    """Return the least quality over the sets of skills of which anything was seen (model.md 6.7)."""
    least = 2.0
    for s in range(state.kinds.adds.shape[0]):
        robots, tasks = int64(0), int64(0)
        for kind in range(params.robot_classes):
            robots += state.kinds.adds[s, kind] * state.seen[i, kind]
        for kind in range(params.robot_classes, state.kinds.adds.shape[1]):
            tasks += state.kinds.adds[s, kind] * state.seen[i, kind]
        if robots + tasks > 0:
            least = min(least, quality(robots, tasks))
    return quality(int64(0), int64(0)) if least == 2.0 else least


@kernel
def end_dissemination(params, state, i, decide):
    """Follow the inbox, and explore again (model.md 4.6)."""
    opinion = int64(has(state.sets[OPINIONS], i))
    feasible, infeasible = count_votes(params, state, i)
    feasible += params.own_vote * opinion
    infeasible += params.own_vote * (1 - opinion)
    decided = decide(opinion, feasible, infeasible)
    if not has(state.sets[STUBBORN], i):
        if decided == 1:
            state.sets[OPINIONS, i >> 5] |= bit(i)
        else:
            state.sets[OPINIONS, i >> 5] &= ~bit(i)
    forget(params, state, i)
    state.sets[DISSEMINATING, i >> 5] &= ~bit(i)
    enter_phase(params, state, i, params.exploration)


@kernel
def enter_phase(params, state, i, mean):
    """Draw how long a robot's new phase lasts."""
    word = draw(params, state.clock[RUN], i, state.robots[PHASES, i], PHASE)
    state.robots[PHASES, i] += int32(1)
    state.robots[PHASE_LEFT, i] = duration(word, mean)
    state.robots[LABELS, i] = label(params, state, i)


@kernel
def bit(i):
    """Return robot i's bit in its word."""
    return uint32(uint32(1) << uint32(i & 31))


@kernel
def count_opinions(state):
    """Note how many counted robots hold opinion 1."""
    total = 0
    for w in range(state.sets.shape[1]):
        total += popcount(state.sets[OPINIONS, w] & state.sets[COUNTED, w])
    state.clock[FEASIBLE_COUNT] = total
