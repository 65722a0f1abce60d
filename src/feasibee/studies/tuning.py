"""Search for the parameters with which a swarm is right most often, or follows changes soonest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError, how_to_install
from feasibee.figures.style import GREY, PALETTE, are_spaced_by_ratio, figure, spaced_by_ratio, text_colour
from feasibee.results.statistics import Interval
from feasibee.scenario.scenario import Scenario
from feasibee.studies.objectives import Objective, Scored, objective_for, scored
from feasibee.studies.space import Dimension
from feasibee.sweeps.plan import DesignPoint
from feasibee.sweeps.sweep import Execution, Rounds

RIGHT = Objective()
"""By default, swarms are to be right at the last step."""
WORST = -1e9
"""Score of parameters that must not be chosen, as Optuna takes it."""
FINALISTS = 5
"""Number of best trials that are run again, more often, before one is chosen."""
FINAL_RUNS, FRESH_RUNS = 5, 10
"""Runs of a finalist, and of the start and the best at last, as multiples of those of a trial."""
FINAL_SEED, FRESH_SEED = 2**62, 2**63
"""What is added to the seed, modulo 2**64, for these runs."""


@dataclass(frozen=True)
class Tuned:
    """Result of a search.

    Parameters
    ----------
    values : dict
        The best parameters, by dotted path.
    start, best : Interval
        The measure with the start's and with the best parameters, on fresh runs: the mean over runs.
    gain : Interval
        By how much it is better, over the same fresh runs.
    trials : list of pairs
        Of each trial, in order, its parameters and its score: the mean of the measure, negative if less is
        better, and -inf if there are too many false alarms. The largest of these scores is biased upwards,
        because it was selected as the largest.
    objective : Objective
        What was improved.
    false_alarms : float
        False alarms per 1,000 steps with the best parameters, on fresh runs.
    """

    values: dict[str, Any]
    start: Interval
    best: Interval
    gain: Interval
    trials: list[tuple[dict[str, Any], float]]
    objective: Objective = RIGHT
    false_alarms: float = 0.0

    @property
    def gains(self) -> bool:
        """Whether the gain is clear: its interval lies above 0."""
        return self.gain.low > 0


def tune(
    scenario: Scenario,
    space: Sequence[Dimension],
    trials: int = 60,
    runs: int = 200,
    seed: int = 0,
    execution: Execution | None = None,
    objective: Objective | None = None,
) -> Tuned:
    """Search by Optuna's tree-structured Parzen estimator.

    The search is a function of its arguments. With a journal in a folder, the same search goes on with the
    runs that are there, and a longer one begins with the trials of a shorter one.

    Parameters
    ----------
    scenario : Scenario
        Where the search starts.
    space : sequence of Dimension
        Fields to vary.
    trials : int
        Number of trials.
    runs : int
        Number of runs of each trial; the best is judged on ten times as many fresh runs.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.
    objective : Objective, optional
        What to improve; by default that of ``objectives.objective_for``.

    Raises
    ------
    FeasibeeError
        If Optuna isn't installed.
    """
    objective = objective or objective_for(scenario)
    scenario = scenario.replace({"run.stop_at_decision": False})
    search = _search(scenario, space, seed)
    total = (trials + FINAL_RUNS * (FINALISTS + 1) + FRESH_RUNS * 2) * runs
    with Rounds(execution, total) as rounds:
        swarms = _Swarms(rounds, scenario, seed, objective)
        tried = [_try_one(search, space, swarms, runs) for _ in range(trials)]
        return _judge(swarms, tried, runs)


@dataclass(frozen=True)
class _Swarms:
    """Simulates a scenario with changed parameters."""

    rounds: Rounds
    scenario: Scenario
    seed: int
    objective: Objective

    def scored(self, changes: Sequence[Mapping[str, Any]], runs: int, added: int = 0) -> list[Scored]:
        """Return the measure of each run for each change; ``added`` is for the seed."""
        designs = [DesignPoint(values, self.scenario.replace(values)) for values in changes]
        return scored(self.rounds, designs, runs, (self.seed + added) % 2**64, self.objective)


def _search(scenario: Scenario, space: Sequence[Dimension], seed: int) -> Any:
    try:
        import optuna
    except ImportError:
        raise FeasibeeError(f"Optuna: not installed; {how_to_install('tune')}") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    search = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=seed % 2**32), direction="maximize")
    now = {each.path: scenario.get(each.path) for each in space}
    if all(each.holds(now[each.path]) for each in space):
        search.enqueue_trial(now)
    return search


def _try_one(
    search: Any, space: Sequence[Dimension], swarms: _Swarms, runs: int
) -> tuple[dict[str, Any], float]:
    """Run the next trial; return its parameters and its score."""
    trial = search.ask()
    values = {each.path: _suggested(trial, each) for each in space}
    (found,) = swarms.scored([values], runs)
    score = swarms.objective.score(found)
    search.tell(trial, max(score, WORST))
    return dict(trial.params), score


def _suggested(trial: Any, each: Dimension) -> Any:
    if each.choices:
        return trial.suggest_categorical(each.path, list(each.choices))
    if each.whole:
        return trial.suggest_int(each.path, round(each.low), round(each.high), log=each.by_ratio)
    return trial.suggest_float(each.path, each.low, each.high, log=each.by_ratio)


def _finalists(tried: Sequence[tuple[dict[str, Any], float]]) -> list[dict[str, Any]]:
    """Return the best trials, and the first one: the best of many trials was also lucky."""
    ranked = sorted(tried, key=lambda trial: -trial[1])
    finalists = [values for values, _ in ranked[:FINALISTS]]
    start, _ = tried[0]
    return finalists if start in finalists else [*finalists, start]


def _judge(swarms: _Swarms, tried: list[tuple[dict[str, Any], float]], runs: int) -> Tuned:
    """Choose the best of the finalists by more runs; compare it with the start on fresh runs."""
    finalists = _finalists(tried)
    finals = swarms.scored(finalists, FINAL_RUNS * runs, FINAL_SEED)
    scores = [swarms.objective.score(found) for found in finals]
    best = finalists[scores.index(max(scores))]
    at_start, at_best = swarms.scored([{}, best], FRESH_RUNS * runs, FRESH_SEED)
    measure = swarms.objective
    return Tuned(
        values=best,
        start=measure.interval(at_start.values),
        best=measure.interval(at_best.values),
        gain=measure.gain(at_best.values, at_start.values),
        trials=tried,
        objective=swarms.objective,
        false_alarms=at_best.false_alarms,
    )


def draw_search(tuned: Tuned) -> Figure:
    """Draw the measure of each trial with the best so far, and against each parameter.

    The trials are grey, and the parameters that were chosen are highlighted. An axis is logarithmic if its
    values span a decade.
    """
    names = list(tuned.values)
    objective, measure = tuned.objective, tuned.objective.of
    label = f"mean {measure.label}" if measure.ends else measure.label
    scores = np.array([score for _, score in tuned.trials])
    shares = np.where(np.isfinite(scores), (100 if measure.unit == "%" else objective.sign) * scores, np.nan)
    so_far = np.fmin if measure.less else np.fmax
    with figure(2.4 * (1 + len(names)), 2.6, columns=1 + len(names), sharey=True) as (drawn, axes):
        axes[0].plot(shares, "o", color=GREY, markersize=3)
        axes[0].step(np.arange(shares.size), so_far.accumulate(shares), color=PALETTE[0], where="post")
        axes[0].set(
            xlabel="trial",
            ylabel=label,
            title="best so far",
        )
        for ax, name in zip(axes[1:], names, strict=True):
            values = [parameters[name] for parameters, _ in tuned.trials]
            shown = [str(value) for value in values] if isinstance(values[0], str | bool) else values
            ax.plot(shown, shares, "o", color=GREY, markersize=3)
            _mark_chosen(ax, tuned, shown, shares)
            ax.set(xlabel=name)
            if not isinstance(values[0], str | bool) and are_spaced_by_ratio(values):
                spaced_by_ratio(ax)
    return drawn


def _mark_chosen(ax: Axes, tuned: Tuned, shown: Sequence[Any], shares: NDArray[np.float64]) -> None:
    """Highlight the first trial with the parameters that were chosen."""
    place = next(place for place, (values, _) in enumerate(tuned.trials) if values == tuned.values)
    ax.plot(shown[place], shares[place], "o", color=PALETTE[0], markersize=5)
    look: dict[str, Any] = {"color": text_colour(PALETTE[0]), "fontsize": 8}
    ax.annotate(
        "chosen", (shown[place], shares[place]), (0, 5), textcoords="offset points", ha="center", **look
    )
