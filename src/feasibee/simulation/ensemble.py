"""Simulate many runs of a scenario: `simulate` returns a labelled dataset, `simulate_record` plain arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal

from feasibee.base.errors import FeasibeeError, quoted
from feasibee.base.record import Record
from feasibee.scenario.runs import Runs, check_integer
from feasibee.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

STEPS_LIMIT = 2**31 - 1
"""Largest number of a step."""
CURVES_LIMIT = 8 * 2**30
"""Largest size in bytes of one curve of all runs of a call, or of their truth at each step."""
RUNS_LIMIT = 100_000_000
"""Largest number of runs of a call: their outcomes without curves take 4 GB."""
THREADS_LIMIT = 1024
REPLAY_LIMIT = 10_000_000
"""Largest number of robots x things x steps of a failed run that the reference simulates again: seconds."""


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
    """Simulate many runs of a scenario; raise `FeasibeeError` if an argument is invalid.

    Parameters
    ----------
    scenario : Scenario, optional
        The swarm and its world; by default the paper's swarm with 20 tasks.
    runs, seed, first_run : int
        Number of runs, seed (0 to 2**64 - 1), number of the first. Scenario, seed and number determine a run.
    curves : bool
        Whether to keep the number of robots with each opinion at each step.
    threads : int, optional
        Number of threads, by default one per processor; it changes no result.
    backend : {"engine", "reference"}
        The compiled engine, or the plain-Python reference: equal results, thousands of times slower.
    progress : callable, optional
        Called about ten times a second with the share of the work that is done, from 0 to 1.

    Returns
    -------
    xarray.Dataset
        Over ``run``: ``decision``, ``decision_step``, ``bits_sent``, ``feasible_at_end``,
        ``infeasible_at_end``; if robots declare ``declare_step``, ``declared_feasible``,
        ``declared_infeasible``, and ``last_step`` if runs end then; if they give a probability
        ``said_at_end``; if they act ``first_taken_step``, ``all_taken_step``, ``tasks_taken``,
        ``distance_walked``, ``vain_arrivals``, ``starts_in_vain``, and ``all_done_step`` if tasks take time.
        With curves, over ``run`` and ``step``: ``feasible_count``, ``infeasible_count``. In a world that
        changes also ``truth``, ``held``, ``robots_present``, ``tasks_present``. Attributes: ``title``,
        ``recipe``; of variables ``long_name``, ``units`` and ``flag_values``, ``flag_meanings``.

    Examples
    --------
    >>> from feasibee import Scenario, simulate
    >>> int((simulate(Scenario(tasks={"count": 2}), runs=100, seed=1).decision == 1).sum())
    91
    """
    from feasibee.results.dataset import to_dataset

    scenario, which = check_scenario(scenario), Runs(runs, seed, first_run)
    options: Any = {"curves": curves, "threads": threads, "backend": backend, "progress": progress}
    return to_dataset(simulate_record(scenario, which, **options), scenario, which.seed)


def simulate_record(
    scenario: Scenario,
    runs: Runs,
    *,
    curves: bool = False,
    threads: int | None = None,
    chunk: int | None = None,
    backend: Literal["engine", "reference"] = "engine",
    progress: Callable[[float], None] | None = None,
) -> Record:
    """Simulate runs and return plain arrays; the options are those of `simulate`.

    ``chunk`` is the number of runs that a thread simulates per call of the engine.
    """
    check_size(scenario, runs, curves)
    check_progress(progress)
    threads = None if threads is None else check_integer("threads", threads, 1, THREADS_LIMIT)
    if not isinstance(backend, str) or backend not in ("engine", "reference"):
        rule = "must be 'engine' or 'reference'"
        raise FeasibeeError(f"backend = {quoted(backend)}: {rule}; leave it out for 'engine'")
    from feasibee.simulation.flooding import flooded

    scenario = flooded(scenario)
    if backend == "reference":
        from feasibee import reference

        return reference.simulate(scenario, runs, curves)
    from feasibee.engine import runner
    from feasibee.engine.tables import RunError
    from feasibee.simulation.lowering import lower

    length = scenario.run.steps + 1
    lengths = length if curves else 0, length if scenario.dynamic else 0
    record = Record.empty(runs.first, runs.count, *lengths)
    try:
        runner.simulate(lower(scenario, runs.seed), record, threads, chunk, progress)
    except RunError as failure:
        raise failure_of(scenario, Runs(1, runs.seed, failure.run), failure.error) from None
    return record


def check_size(scenario: Scenario, runs: Runs, curves: bool) -> None:
    """Raise an error if the outcomes of one call would take too much memory."""
    if runs.count > RUNS_LIMIT:
        rule = f"must be at most {RUNS_LIMIT} per call"
        raise FeasibeeError(f"runs = {runs.count}: {rule}; simulate the rest with first_run={RUNS_LIMIT}")
    if not isinstance(curves, bool):
        raise FeasibeeError(f"curves = {quoted(curves)}: must be True or False; leave it out for False")
    needed = 4 * runs.count * (scenario.run.steps + 1)
    if (curves or scenario.dynamic) and needed > CURVES_LIMIT:
        most = max(1, CURVES_LIMIT // (4 * (scenario.run.steps + 1)))
        what, instead = ("truths", "") if scenario.dynamic else ("curves", ", or leave curves out")
        raise FeasibeeError(
            f"{what} of {runs.count} runs x {scenario.run.steps} steps: need {needed / 2**30:.0f} GiB, above "
            f"{CURVES_LIMIT // 2**30} per call; simulate at most {most} runs per call{instead}"
        )


def failure_of(scenario: Scenario, run: Runs, error: Exception) -> Exception:
    """Return the error to raise when a strategy failed in one run.

    The engine has told line and values. The reference simulates the run again, if that takes seconds, and
    names the arguments too.
    """
    from feasibee.engine.tables import EndlessLoopError

    which = f"in run {run.first} of seed {run.seed}"
    robots, things = scenario.robots.count, scenario.robots.count + scenario.tasks.count
    quick = robots * things * scenario.run.steps <= REPLAY_LIMIT
    if quick and not isinstance(error, EndlessLoopError):
        from feasibee import reference

        try:
            reference.simulate(scenario, run)
        except FeasibeeError as explained:
            return FeasibeeError(f"{explained} ({which})")
    return FeasibeeError(f"{error} ({which})")


def check_scenario(scenario: Scenario | None) -> Scenario:
    """Validate a scenario's type and return it; for None return the paper's scenario."""
    if scenario is None:
        return Scenario()
    if not isinstance(scenario, Scenario):
        raise FeasibeeError(f"scenario = {quoted(scenario)}: must be a Scenario; write Scenario(...)")
    return scenario


def check_progress(progress: object) -> None:
    """Raise an error unless the progress callback is callable or None."""
    if progress is not None and not callable(progress):
        rule = "must be a function of one number, the share of the work that is done"
        raise FeasibeeError(f"progress = {quoted(progress)}: {rule}; leave it out for none")


def check_span(
    name: str, value: tuple[int, int], most: int = STEPS_LIMIT, what: str = "the limit"
) -> tuple[int, int]:
    """Validate the first and last step of a span; return them as built-in ints. ``what`` is ``most``."""
    if not isinstance(value, tuple | list) or len(value) != 2:
        rule = "must be the first and the last step"
        raise FeasibeeError(f"{name} = {quoted(value)}: {rule}; such as (0, 100)")
    first, last = (check_integer(name, each, 0, STEPS_LIMIT) for each in value)
    if first > last:
        rule = "must not begin after its end"
        raise FeasibeeError(f"{name} = {first}:{last}: {rule}; such as {last}:{first}")
    if last > most:
        rule = f"must lie between 0 and {what} = {most}"
        raise FeasibeeError(f"{name} = {first}:{last}: {rule}; such as 0:{most}")
    return first, last
