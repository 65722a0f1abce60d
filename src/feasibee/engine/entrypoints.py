"""What Python calls: many runs at once, or one swarm step by step."""

from __future__ import annotations

from functools import cache

from numba import boolean, float64, int8, int32, int64, typeof, types

from feasibee.engine import step
from feasibee.engine.compile import entry, kernel
from feasibee.engine.layout import (
    BITS,
    COMMITTED_FEASIBLE,
    COMMITTED_INFEASIBLE,
    FEASIBLE_COUNT,
    FULL,
    NEUTRAL_COUNT,
    STEP,
    empty_state,
    packed,
)
from feasibee.engine.translation import kinds_of, params_of
from feasibee.model.codes import FEASIBLE, INFEASIBLE, UNDECIDED
from feasibee.model.record import BITS_SENT, COMMIT_STEP
from feasibee.model.record import COMMITTED_FEASIBLE as FOR
from feasibee.model.record import COMMITTED_INFEASIBLE as AGAINST
from feasibee.scenario.scenario import Scenario
from feasibee.strategies.contract import Inbox, Mind

_params = params_of(Scenario(), 0)
_state = empty_state(_params, kinds_of(Scenario(), _params), 2)
PARAMS = typeof(packed(_params))
STATE = typeof(_state)
MIND = typeof(Mind(0, 0.0, 0.0, 0, _state.memory[0, 1:], _state.kinds.parameters))
INBOX = typeof(Inbox(0, 0, 0, 0.0, 0.0, 0.0))
SIGNATURES = {
    "quality": float64(int64, int64),
    "dissemination": float64(float64, float64),
    "decide": int64(MIND, INBOX),
    "say": int64(MIND),
    "value": float64(MIND),
}
"""Of the functions of a strategy, in the order of `feasibee.engine.step`."""
STRATEGY = [types.FunctionType(each) for each in SIGNATURES.values()]
DECISIONS, STEPS, DONE, CANCEL = int8[::1], int32[::1], int64[::1], boolean[::1]
CURVES, CURVE = int32[:, ::1], int32[::1]

START = types.void(PARAMS, STATE, int64)
ADVANCE = types.void(
    PARAMS, STATE, int64, DECISIONS, STEPS, CURVE, CURVE, int64[::1], DONE, CANCEL, *STRATEGY
)


@kernel
def note(params, state, decision, decision_step, curve, counter_curve, account):
    """Write down a run's present step: its curves, and its decision if it is the first (model.md 4.7)."""
    counted = params.robots - params.byzantine
    quorum = params.quorum
    if params.stopped > 0 and state.clock[STEP] >= params.stop_step:
        counted -= params.stopped
        quorum = params.quorum_stopped
    feasible = state.clock[FEASIBLE_COUNT]
    infeasible = counted - feasible - state.clock[NEUTRAL_COUNT]
    if curve.size > 0:
        curve[state.clock[STEP]] = feasible
        counter_curve[state.clock[STEP]] = infeasible
    if decision[0] == UNDECIDED:
        if feasible >= quorum:
            decision[0] = FEASIBLE
            decision_step[0] = state.clock[STEP]
        elif infeasible >= quorum:
            decision[0] = INFEASIBLE
            decision_step[0] = state.clock[STEP]
    committed = state.clock[COMMITTED_FEASIBLE] + state.clock[COMMITTED_INFEASIBLE]
    if params.commit and account[COMMIT_STEP] < 0 and committed >= quorum:
        account[COMMIT_STEP] = state.clock[STEP]


@kernel
def settle(state, account):
    """Write down what a run has come to."""
    account[BITS_SENT] = state.clock[BITS]
    account[FOR] = state.clock[COMMITTED_FEASIBLE]
    account[AGAINST] = state.clock[COMMITTED_INFEASIBLE]


def start_paper(params, state, run):
    """Put the swarm of a run at step 0."""
    step.start_paper(params, state, run)


def start_beyond(params, state, run):
    """Put the swarm of a run at step 0, with what is beyond the paper."""
    step.start_beyond(params, state, run)


def advance_paper(
    params,
    state,
    until,
    decision,
    decision_step,
    curve,
    counter_curve,
    account,
    done,
    cancel,
    quality,
    dissemination,
    decide,
    say,
    value,
):
    """Play one run on, up to a step or to its end.

    ``decision`` and ``decision_step`` hold one number each; the curves are empty when nobody wants them.
    ``done[0]`` counts steps; setting ``cancel[0]`` ends the run, as does an inbox table that is full.
    """
    if state.clock[STEP] == 0:
        note(params, state, decision, decision_step, curve, counter_curve, account)
    while goes_on(params, state, until, decision, cancel):
        step.advance_paper(params, state, quality, dissemination, decide, say, value)
        note(params, state, decision, decision_step, curve, counter_curve, account)
        done[0] += 1
    settle(state, account)


def advance_beyond(
    params,
    state,
    until,
    decision,
    decision_step,
    curve,
    counter_curve,
    account,
    done,
    cancel,
    quality,
    dissemination,
    decide,
    say,
    value,
):
    """Do the same with what is beyond the paper."""
    if state.clock[STEP] == 0:
        note(params, state, decision, decision_step, curve, counter_curve, account)
    while goes_on(params, state, until, decision, cancel):
        step.advance_beyond(params, state, quality, dissemination, decide, say, value)
        note(params, state, decision, decision_step, curve, counter_curve, account)
        done[0] += 1
    settle(state, account)


@kernel
def goes_on(params, state, until, decision, cancel):
    """Tell whether a run has a next step."""
    if state.clock[STEP] >= until or state.clock[FULL] or cancel[0]:
        return False
    return not (params.stop_at_decision and decision[0] != UNDECIDED)


@entry(
    int64(
        PARAMS,
        STATE,
        int64,
        DECISIONS,
        STEPS,
        CURVES,
        CURVES,
        int64[:, ::1],
        DONE,
        CANCEL,
        types.FunctionType(START),
        types.FunctionType(ADVANCE),
        *STRATEGY,
    )
)
def play(
    params,
    state,
    first_run,
    decisions,
    decision_steps,
    curves,
    counter_curves,
    accounts,
    done,
    cancel,
    start,
    advance,
    quality,
    dissemination,
    decide,
    say,
    value,
):
    """Play the runs from ``first_run`` on, one for each place of ``decisions``; return how many are whole.

    Fewer are whole than asked for when an inbox table ran full (the caller gives more room and goes on), or
    when ``cancel[0]`` was set. ``curves`` has no columns when nobody wants them.
    """
    for r in range(decisions.size):
        start(params, state, first_run + r)
        decisions[r] = UNDECIDED
        decision_steps[r] = -1
        accounts[r, COMMIT_STEP] = -1
        advance(
            params,
            state,
            params.steps,
            decisions[r : r + 1],
            decision_steps[r : r + 1],
            curves[r],
            counter_curves[r],
            accounts[r],
            done,
            cancel,
            quality,
            dissemination,
            decide,
            say,
            value,
        )
        if state.clock[FULL] or cancel[0]:
            return r
    return decisions.size


@cache
def world_functions(beyond):
    """Compile how a run starts and goes on, for the paper's world or for any."""
    if beyond:
        return entry(START)(start_beyond), entry(ADVANCE)(advance_beyond)
    return entry(START)(start_paper), entry(ADVANCE)(advance_paper)
