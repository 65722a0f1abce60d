"""What Python calls: many runs at once, or one swarm step by step."""

from __future__ import annotations

from numba import boolean, float64, int8, int32, int64, typeof, types

from feasibee.engine import step
from feasibee.engine.compile import entry, kernel
from feasibee.engine.layout import FEASIBLE_COUNT, FULL, STEP, empty_state, params_of
from feasibee.scenario import Scenario
from feasibee.vocabulary import FEASIBLE, INFEASIBLE, UNDECIDED

QUALITY = float64(int64, int64)
DISSEMINATION = float64(float64, float64)
DECIDE = int64(int64, int64, int64)

_params = params_of(Scenario(), 0)
PARAMS = typeof(_params)
STATE = typeof(empty_state(_params, 2))
STRATEGY = (types.FunctionType(QUALITY), types.FunctionType(DISSEMINATION), types.FunctionType(DECIDE))


@entry(types.void(PARAMS, STATE, int64))
def start(params, state, run):
    """Put the swarm of a run at step 0."""
    step.start(params, state, run)


@entry(types.void(PARAMS, STATE, *STRATEGY))
def advance(params, state, quality, dissemination, decide):
    """Do one step."""
    step.advance(params, state, quality, dissemination, decide)


@kernel
def note(params, state, r, decisions, decision_steps, curves):
    """Write down the state of a run: its curve, and its decision if it is the first (model.md 4.7)."""
    feasible = state.clock[FEASIBLE_COUNT]
    if curves.shape[1] > 0:
        curves[r, state.clock[STEP]] = feasible
    if decisions[r] == UNDECIDED:
        if feasible >= params.quorum:
            decisions[r] = FEASIBLE
            decision_steps[r] = state.clock[STEP]
        elif params.robots - feasible >= params.quorum:
            decisions[r] = INFEASIBLE
            decision_steps[r] = state.clock[STEP]


@entry(int64(PARAMS, STATE, int64, int8[::1], int32[::1], int32[:, ::1], int64[::1], boolean[::1], *STRATEGY))
def play(
    params, state, first_run, decisions, decision_steps, curves, done, cancel, quality, dissemination, decide
):
    """Play the runs from ``first_run`` on, one for each place of ``decisions``; return how many are whole.

    Fewer are whole than asked for when an inbox table ran full (the caller gives more room and goes on), or
    when ``cancel[0]`` was set. ``curves`` has no columns when nobody wants them. ``done[0]`` counts steps.
    """
    for r in range(decisions.size):
        step.start(params, state, first_run + r)
        decisions[r] = UNDECIDED
        decision_steps[r] = -1
        note(params, state, r, decisions, decision_steps, curves)
        while state.clock[STEP] < params.steps:
            if params.stop_at_decision and decisions[r] != UNDECIDED:
                break
            step.advance(params, state, quality, dissemination, decide)
            note(params, state, r, decisions, decision_steps, curves)
            done[0] += 1
            if state.clock[FULL] or cancel[0]:
                return r
    return decisions.size
