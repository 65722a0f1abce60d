"""simulate(): the door to the engine and the reference."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from feasibee.errors import FeasibeeError, quoted
from feasibee.model.record import Record
from feasibee.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

from feasibee.scenario.runs import check_numbers, whole
from feasibee.simulation.loading import load_engine

STEPS_LIMIT = 2**31 - 1
"""No step is later than this."""
CURVES_LIMIT = 8 * 2**30
"""Bytes of curves in one call."""
RUNS_LIMIT = 100_000_000
"""Runs in one call: their outcomes take 4 GB."""

REPLAY_LIMIT = 10_000_000
"""Pairs of robots and things, times steps, up to which the reference plays a failed run again: seconds."""


def simulate(
    scenario: Scenario | None = None,
    runs: int = 1,
    seed: int = 0,
    *,
    first_run: int = 0,
    curves: bool = False,
    threads: int | None = None,
    backend: Literal["engine", "reference"] = "engine",
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Simulate a swarm many times.

    Parameters
    ----------
    scenario : Scenario, optional
        What to simulate; by default the paper's swarm with 20 tasks.
    runs : int
        How many runs, at least 1.
    seed : int
        From 0 to 2**64 - 1. Scenario, seed and number of the run determine a run, whatever else is run with
        it, on whatever machine.
    first_run : int
        Number of the first run: runs 100 to 199 of a study are ``first_run=100, runs=100``.
    curves : bool
        Whether to keep the number of robots with opinion 1 at each step.
    threads : int, optional
        By default one for each processor.
    backend : {"engine", "reference"}
        The compiled engine, or the plain-Python reference: the same numbers, thousands of times slower.
    progress : callable, optional
        Called now and then with the share of the work done.

    Returns
    -------
    xarray.Dataset
        Over ``run``: ``decision`` (1 feasible, 0 infeasible, -1 undecided) and ``decision_step`` (-1 if
        undecided); over ``run`` and ``step``, with ``curves``: ``feasible_count``. The recipe is in the
        attributes.

    Raises
    ------
    FeasibeeError
        If an argument is out of its range.

    Examples
    --------
    >>> import feasibee
    >>> swarms = feasibee.simulate(feasibee.Scenario(tasks={"count": 2}), runs=100, seed=1)
    >>> int((swarms.decision == 1).sum())
    91
    """
    from feasibee.results.dataset import label

    scenario = check_scenario(scenario)
    runs, seed, first_run = check_numbers(runs, seed, first_run)
    record = simulate_record(
        scenario,
        runs,
        seed,
        first_run=first_run,
        curves=curves,
        threads=threads,
        backend=backend,
        progress=progress,
    )
    return label(record, scenario, seed)


def simulate_record(
    scenario: Scenario,
    runs: int,
    seed: int,
    *,
    first_run: int = 0,
    curves: bool = False,
    threads: int | None = None,
    chunk: int | None = None,
    backend: Literal["engine", "reference"] = "engine",
    progress: Callable[[float], None] | None = None,
) -> Record:
    """Simulate without labels: see `simulate`; ``chunk`` is how many runs a thread plays at a time."""
    scenario = check_scenario(scenario)
    runs, seed, first_run = check_numbers(runs, seed, first_run)
    if runs > RUNS_LIMIT:
        rule = f"must be at most {RUNS_LIMIT} at a time"
        raise FeasibeeError(f"runs = {runs}: {rule}; ask for fewer, and for the others with first_run")
    if not isinstance(curves, bool):
        raise FeasibeeError(f"curves = {quoted(curves)}: must be True or False; leave it out for False")
    check_progress(progress)
    threads = processors() if threads is None else whole("threads", threads, 1, 1024)
    if curves and 4 * runs * (scenario.run.steps + 1) > CURVES_LIMIT:
        raise FeasibeeError(
            f"curves of {runs} runs x {scenario.run.steps} steps: must fit {CURVES_LIMIT // 2**30} GiB; "
            "ask for fewer runs at a time, fewer steps, or no curves"
        )
    if not isinstance(backend, str) or backend not in ("engine", "reference"):
        raise FeasibeeError(f"backend = {quoted(backend)}: must be 'engine' or 'reference'; leave it out")
    if backend == "reference":
        from feasibee import reference

        return reference.simulate(scenario, runs, seed, first_run, curves)
    load_engine(scenario)
    from feasibee.engine import runner
    from feasibee.simulation.lowering import lower

    record = Record.empty(first_run, runs, scenario.run.steps + 1 if curves else 0)
    try:
        runner.simulate(lower(scenario, seed), record, threads, chunk, progress)
    except runner.RunError as failure:
        raise failure_of(scenario, seed, failure.run, failure.error) from None
    return record


def failure_of(scenario: Scenario, seed: int, run: int, error: Exception) -> Exception:
    """Return what to raise for a strategy that failed in a run: in the user's terms, if it is the user's.

    The engine knows the error only; the reference plays the run again, and knows line, arguments and value.
    """
    strategy = scenario.strategy
    if not strategy.source:
        return error
    which = f"in run {run} of seed {seed}"
    robots, things = scenario.robots.count, scenario.robots.count + scenario.tasks.count
    if robots * things * scenario.run.steps <= REPLAY_LIMIT:
        from feasibee import reference

        try:
            reference.simulate(scenario, 1, seed, run)
        except FeasibeeError as told:
            return FeasibeeError(f"{told} ({which})")
    return FeasibeeError(
        f"{strategy.name}: fails {which}: {error}; "
        f'simulate(scenario, 1, {seed}, first_run={run}, backend="reference") says where'
    )


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def check_scenario(scenario: Scenario | None) -> Scenario:
    """Return a scenario, by default the paper's, and refuse what isn't one."""
    if scenario is None:
        return Scenario()
    if not isinstance(scenario, Scenario):
        raise FeasibeeError(f"scenario = {quoted(scenario)}: must be a Scenario; write Scenario(...)")
    return scenario


def check_progress(progress: object) -> None:
    """Raise an error unless the progress callback can be called."""
    if progress is not None and not callable(progress):
        raise FeasibeeError(f"progress = {quoted(progress)}: must be a function of a share; leave it out")


def pair(name: str, value: tuple[int, int]) -> tuple[int, int]:
    """Return the first and the last of some steps as ints, if they are in order."""
    if not isinstance(value, tuple | list) or len(value) != 2:
        rule = "must be the first and the last step"
        raise FeasibeeError(f"{name} = {quoted(value)}: {rule}; such as (0, 100)")
    first, last = (whole(name, each, 0, STEPS_LIMIT) for each in value)
    if first > last:
        raise FeasibeeError(f"{name} = {first}:{last}: must be in order; such as (0, 100)")
    return first, last
