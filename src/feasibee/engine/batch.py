"""What Python calls: many runs at once, or one swarm step by step."""

from __future__ import annotations

from functools import cache

from numba import boolean, float64, int8, int32, int64, typeof, types

from feasibee.engine import step
from feasibee.engine.compile import entry, kernel
from feasibee.engine.layout import FEASIBLE_COUNT, FULL, STEP, empty_state
from feasibee.engine.translation import kinds_of, params_of
from feasibee.scenario import Scenario
from feasibee.vocabulary import FEASIBLE, INFEASIBLE, UNDECIDED

QUALITY = float64(int64, int64)
DISSEMINATION = float64(float64, float64)
DECIDE = int64(int64, int64, int64)

_params = params_of(Scenario(), 0)
PARAMS = typeof(_params)
STATE = typeof(empty_state(_params, kinds_of(Scenario(), _params), 2))
DECISIONS, STEPS, CURVES, DONE, CANCEL = int8[::1], int32[::1], int32[:, ::1], int64[::1], boolean[::1]
STRATEGY = (types.FunctionType(QUALITY), types.FunctionType(DISSEMINATION), types.FunctionType(DECIDE))

START = types.void(PARAMS, STATE, int64)
ADVANCE = types.void(PARAMS, STATE, int64, DECISIONS, STEPS, STEPS, DONE, CANCEL, *STRATEGY)


@kernel
def note(params, state, decision, decision_step, curve):
    """Write down a run's present step: its curve, and its decision if it is the first (model.md 4.7)."""
    feasible = state.clock[FEASIBLE_COUNT]
    if curve.size > 0:
        curve[state.clock[STEP]] = feasible
    if decision[0] == UNDECIDED:
        counted = params.robots - params.byzantine
        quorum = params.quorum
        if params.stopped > 0 and state.clock[STEP] >= params.stop_step:
            counted -= params.stopped
            quorum = params.quorum_stopped
        if feasible >= quorum:
            decision[0] = FEASIBLE
            decision_step[0] = state.clock[STEP]
        elif counted - feasible >= quorum:
            decision[0] = INFEASIBLE
            decision_step[0] = state.clock[STEP]


def start_paper(params, state, run):
    """Put the swarm of a run at step 0."""
    step.start_paper(params, state, run)


def start_beyond(params, state, run):
    """Put the swarm of a run at step 0, with what is beyond the paper."""
    step.start_beyond(params, state, run)


def advance_paper(
    params, state, until, decision, decision_step, curve, done, cancel, quality, dissemination, decide
):
    """Play one run on, up to a step or to its end.

    ``decision`` and ``decision_step`` hold one number each; ``curve`` is empty when nobody wants it.
    ``done[0]`` counts steps; setting ``cancel[0]`` ends the run, as does an inbox table that is full.
    """
    if state.clock[STEP] == 0:
        note(params, state, decision, decision_step, curve)
    while goes_on(params, state, until, decision, cancel):
        step.advance_paper(params, state, quality, dissemination, decide)
        note(params, state, decision, decision_step, curve)
        done[0] += 1


def advance_beyond(
    params, state, until, decision, decision_step, curve, done, cancel, quality, dissemination, decide
):
    """Do the same with what is beyond the paper."""
    if state.clock[STEP] == 0:
        note(params, state, decision, decision_step, curve)
    while goes_on(params, state, until, decision, cancel):
        step.advance_beyond(params, state, quality, dissemination, decide)
        note(params, state, decision, decision_step, curve)
        done[0] += 1


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
    done,
    cancel,
    start,
    advance,
    quality,
    dissemination,
    decide,
):
    """Play the runs from ``first_run`` on, one for each place of ``decisions``; return how many are whole.

    Fewer are whole than asked for when an inbox table ran full (the caller gives more room and goes on), or
    when ``cancel[0]`` was set. ``curves`` has no columns when nobody wants them.
    """
    for r in range(decisions.size):
        start(params, state, first_run + r)
        decisions[r] = UNDECIDED
        decision_steps[r] = -1
        advance(
            params,
            state,
            params.steps,
            decisions[r : r + 1],
            decision_steps[r : r + 1],
            curves[r],
            done,
            cancel,
            quality,
            dissemination,
            decide,
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
