"""The functions that Python calls: play many runs, or one swarm step by step."""

from __future__ import annotations

from functools import cache

from numba import int64

from feasibee.engine import step
from feasibee.engine.compile import entry, inlined, rebound
from feasibee.engine.layout import Clock, Share
from feasibee.engine.opinions import count_opinions, have_all_declared, may_declare, sum_counts
from feasibee.engine.signatures import ABANDON, ADVANCE, PLAY, START
from feasibee.engine.team import alone, comes_last, let_go, total, wait_for_all
from feasibee.model.codes import FEASIBLE, INFEASIBLE, UNDECIDED
from feasibee.model.outcomes import (
    ALL_DONE_STEP,
    ALL_TAKEN_STEP,
    DECLARE_STEP,
    DECLARED_FEASIBLE,
    DECLARED_INFEASIBLE,
    FEASIBLE_AT_END,
    INFEASIBLE_AT_END,
    LAST_STEP,
    SAID_AT_END,
)


@inlined
def record_step(params, state, outcome, row):
    """Record the counts at a run's present step, and its decision if it is the first (model.md 4.7)."""
    now, quorum = state.clock[Clock.STEP], state.clock[Clock.QUORUM]
    account = state.account
    account[LAST_STEP] = now
    feasible, infeasible = account[FEASIBLE_AT_END], account[INFEASIBLE_AT_END]
    if outcome.feasible_count.shape[1] > 0:
        outcome.feasible_count[row, now] = feasible
        outcome.infeasible_count[row, now] = infeasible
    held = UNDECIDED
    if feasible >= quorum:
        held = FEASIBLE
    elif infeasible >= quorum:
        held = INFEASIBLE
    if outcome.decision[row] == UNDECIDED and held != UNDECIDED:
        outcome.decision[row] = held
        outcome.decision_step[row] = now
    if params.changes and not params.truth_stays:
        outcome.truth[row, now], outcome.held[row, now] = state.clock[Clock.TRUTH], held
        outcome.robots_present[row, now] = state.clock[Clock.ROBOTS]
        outcome.tasks_present[row, now] = state.clock[Clock.TASKS]
    declared = account[DECLARED_FEASIBLE] + account[DECLARED_INFEASIBLE]
    if may_declare(params) and account[DECLARE_STEP] < 0 and declared >= quorum:
        account[DECLARE_STEP] = now


@inlined
def end_step(params, state, outcome, row, steps, control, part):
    """Count a step, or none at the start, and record the swarm once all threads have come here."""
    part.shared[part.thread, Share.ENDED] = int64(control.cancelled[0])
    if comes_last(part):
        state.clock[Clock.STEP] += steps
        control.steps_done[0] += steps
        sum_counts(params, state, part)
        record_step(params, state, outcome, row)
        let_go(part)


@inlined
def has_next_step(params, state, outcome, row, until, part):
    """Return whether a run has a next step, the same for all threads."""
    if state.clock[Clock.STEP] >= until or state.clock[Clock.FULL] or total(part, Share.ENDED) > 0:
        return False
    if params.run.stop_at_declarations and have_all_declared(params, state):
        return False
    if params.run.stop_when_taken:
        ends_with = ALL_DONE_STEP if params.tasks.work > 0 else ALL_TAKEN_STEP
        if state.account[ends_with] >= 0:
            return False
    return not (params.run.stop_at_decision and outcome.decision[row] != UNDECIDED)


@inlined
def shared(part):
    """Return the part of a thread as it is, where several may share a swarm."""
    return part


one_step, of_thread = step.advance_general_few, alone
"""What stands for the step of a world in `advance`, and for a thread's part of it; see `world_functions`."""


def advance(params, state, outcome, row, until, control, functions, part):
    """Simulate a thread's part of a run, up to step ``until`` or to its end.

    ``row`` is the run's row of the outcome. ``control.steps_done`` counts steps. Setting
    ``control.cancelled`` ends the run, as does an inbox without room.
    """
    part = of_thread(part)
    if state.clock[Clock.STEP] == 0:
        step.change_world(params, state, functions, int64(0))
        count_opinions(params, state, part)
        part.shared[part.thread, Share.BITS] = 0  # not those of the run before
        end_step(params, state, outcome, row, int64(0), control, part)
    while has_next_step(params, state, outcome, row, until, part):
        one_step(params, state, functions, part)
        end_step(params, state, outcome, row, int64(1), control, part)
    if part.thread == 0:
        if params.strategy.gives_probability:
            state.account[SAID_AT_END] = step.sum_probabilities(params, state, functions)
        for column in range(state.account.size):
            outcome.account[row, column] = state.account[column]


@entry(PLAY)
def play(params, state, outcome, first_run, control, start, advance, functions, part):
    """Simulate the runs from ``first_run`` on, one for each row of the outcome; return how many are complete.

    Fewer are complete than asked for when an inbox had no room (the caller gives more and goes on), or when
    ``control.cancelled`` was set.
    """
    for row in range(outcome.decision.size):
        start(params, state, first_run + row)
        outcome.decision[row], outcome.decision_step[row] = UNDECIDED, -1
        advance(params, state, outcome, row, params.run.steps, control, functions, part)
        if state.clock[Clock.FULL] or control.cancelled[0]:
            return row
    return outcome.decision.size


def abandon_run(part):
    """Let the other threads end the run, instead of a thread in which a strategy has raised an error."""
    part.shared[part.thread, Share.ENDED] = 1
    wait_for_all(part)


@cache
def abandon():
    """Compile `abandon_run`, which only larger swarms need."""
    return entry(ABANDON)(abandon_run)


@cache
def world_functions(words):
    """Compile the start and the steps of a run, for few robots or for more.

    ``words`` is 1 or 2 for few robots, in one word or more, and 0 for more robots.
    """
    if words == 0:
        abandon()
    few = step.advance_general_few
    one, part = [(step.advance_general_crowd, shared), (few, alone), (few, shared)][words]
    together = rebound(advance, f"{one.__name__}_{words}", one_step=one, of_thread=part)
    return entry(START)(step.start_general), entry(ADVANCE)(together)
