"""How a swarm begins: its clock, its tasks in cells, its robots' first opinions and phases."""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine.bits import first_bits, pack_label
from feasibee.engine.cells import sort_into_cells
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.draws import coin, draw
from feasibee.engine.faults import stand_still
from feasibee.engine.few import number_tasks
from feasibee.engine.inbox import clear_inbox, free_all_tables
from feasibee.engine.layout import Clock, Heard, Point, Robot, Set
from feasibee.engine.motion import head
from feasibee.engine.opinions import set_opinion
from feasibee.engine.pools import draw_headings, draw_phases, list_members, phase_duration, present_phase
from feasibee.engine.sensing import clear_counts, label_of
from feasibee.engine.tasklists import fill_lists
from feasibee.model.codes import NO_OPINION
from feasibee.model.purposes import FIRST_OPINION


@called
def clear(params, state, run):
    """Clear what the previous run left in the state."""
    state.clock[Clock.RUN] = run
    state.clock[Clock.STEP] = 0
    state.clock[Clock.FULL] = 0
    state.clock[Clock.BITS] = 0
    state.clock[Clock.PENDING] = 0
    for kind in range(Clock.COMMITTED_FEASIBLE, Clock.PENDING):
        state.clock[kind] = 0
    for w in range(state.sets.shape[1]):
        for kind in range(state.sets.shape[0]):
            state.sets[kind, w] = uint32(0)
        state.sets[Set.THERE, w] = first_bits(max(params.robots.at_start - 32 * w, 0))
        for kind in (Set.WORKING, Set.COUNTED, Set.JOINING):
            state.sets[kind, w] = state.sets[Set.THERE, w]
    for w in range(state.tasks_there.size):
        state.tasks_there[w] = first_bits(max(params.tasks.at_start - 32 * w, 0))
    state.clock[Clock.ROBOTS], state.clock[Clock.TASKS] = params.robots.at_start, params.tasks.at_start
    state.clock[Clock.MISS], state.clock[Clock.LOSS] = params.sensing.miss, params.radio.loss
    state.clock[Clock.TRUTH] = int64(params.truth)
    set_inventions(params, state.clock)
    set_quorum(params, state.clock, params.robots.at_start - params.faults.byzantine)


@inlined
def set_quorum(params, clock, counted):
    """Store over how many robots the decision is taken, and how many of them it needs (model.md 4.7)."""
    clock[Clock.COUNTED] = counted
    clock[Clock.QUORUM] = counted * params.decision.quorum.share // params.decision.quorum.whole + 1


@inlined
def set_inventions(params, clock):
    """Store how many robots or tasks Byzantine robots invent (model.md 6.12, 6.16)."""
    robots, tasks, exactly = clock[Clock.ROBOTS], clock[Clock.TASKS], int64(params.faults.exactly)
    clock[Clock.INVENTED_ROBOTS] = tasks - exactly * robots
    clock[Clock.INVENTED_TASKS] = robots + 1 - exactly * tasks


@spliced
def prepare_robots(params, state):
    """Give robots in their places a first opinion, heading and phase (model.md 2.1, 4.1)."""
    sort_tasks(params, state)
    w, working = int64(0), state.sets[Set.WORKING]
    while w < working.size:
        w, count = list_members(state, 0, working, w, working.size)
        for k in range(count):
            i = int64(state.heard[0, Heard.RECEIVER, k])
            state.robots[Robot.LABEL, i] = pack_label(i, False, False)
            state.robots[Robot.WALKS, i] = state.robots[Robot.PHASES, i] = state.robots[Robot.JOINED, i] = 0
        draw_headings(params, state, 0, count)
        for k in range(count):
            head(params, state, 0, int64(state.heard[0, Heard.RECEIVER, k]), k)
        draw_phases(params, state, 0, count)
        for k in range(count):
            prepare_robot(params, state, int64(state.heard[0, Heard.RECEIVER, k]), k)
    for i in range(params.robots.at_start, state.robots.shape[1]):
        stand_still(state.robots, i)
        state.robots[Robot.WALKS, i] = state.robots[Robot.PHASES, i] = state.robots[Robot.JOINED, i] = 0
        state.robots[Robot.LABEL, i] = pack_label(i, False, False)
    free_all_tables(state)


@called
def sort_tasks(params, state):
    """Sort the tasks in their places so that robots find those in sight."""
    xs, ys, lists = state.tasks[Point.X], state.tasks[Point.Y], params.tasks.lists
    for task in range(params.tasks.count):
        state.tasks[Point.NUMBER, task] = task
    points = (xs, ys, state.tasks[Point.NUMBER])
    sort_into_cells(state.task_cells, params.tasks.grid, points, state.tasks_there, params.tasks.count)
    if lists.bits > 0:
        limit = params.sensing.limit
        fill_lists(state.task_lists, lists.bits, lists.shift, limit, xs, ys, params.tasks.count)
    if params.tasks.numbered:
        number_tasks(state.task_lists.places, xs, ys, params.tasks.count)


@spliced
def prepare_robot(params, state, i, k):
    """Give a robot, entry ``k`` of those that draw, its first opinion and phase."""
    word = draw(params, state.clock[Clock.RUN], i, int64(state.robots[Robot.JOINED, i]), FIRST_OPINION)
    set_opinion(state.sets, i, coin(word))
    if params.strategy.starts_neutral:
        set_opinion(state.sets, i, int64(NO_OPINION))
    length, _, _ = present_phase(params, state, 0, i, k)
    enter_phase(state, i, phase_duration(params, state, i, length, params.decision.exploration))
    clear_inbox(params, state, i)
    clear_counts(params, state, i)
    state.robots[Robot.AGREED, i] = 0
    state.memory[i] = 0.0


@inlined
def enter_phase(state, i, lasts):
    """Begin a robot's next phase, of a given duration in steps."""
    state.robots[Robot.PHASES, i] += int32(1)
    state.robots[Robot.PHASE_LEFT, i] = lasts
    state.robots[Robot.LABEL, i] = label_of(state, i)
