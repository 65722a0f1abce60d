"""Search for good parameters, and for those that matter: Parzen estimators and rank correlations."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError, how_to_install
from feasibee.figures.style import GREY, PALETTE, along, figure, name_of_axis, note, text_colour
from feasibee.results.measures import MEASURES, Measure, tracking
from feasibee.results.statistics import (
    Interval,
    mean_difference,
    mean_of,
    mean_share,
    rank_correlation,
    wilson,
)
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.studies.space import Dimension
from feasibee.sweeps.plan import DesignPoint, Study
from feasibee.sweeps.sweep import Execution, Rounds
from feasibee.theory.screen import LONGEST, WALKED, Screen

Values = NDArray[np.float64]
RIGHT_AT_END: Final = "right_at_end"
TUNED: Final = tuple(each.name for each in MEASURES.values() if each.values is not None)
"""Names of the measures that a search may improve."""


@dataclass(frozen=True)
class Objective:
    """What a search improves."""

    measure: str = RIGHT_AT_END
    """One of `TUNED`."""
    false_alarms: float | None = None
    """Parameters with more false alarms per 1,000 steps aren't chosen."""
    worst: bool = False
    """Whether the search is for the worst parameters instead."""

    @property
    def of(self) -> Measure:
        """The measure."""
        return MEASURES[self.measure]

    @property
    def sign(self) -> int:
        """1 if more is better, otherwise -1."""
        return -1 if self.of.less != self.worst else 1

    def score(self, runs: Scored) -> float:
        """Return the mean of the measure, negative if less is better; -inf where it must not be chosen."""
        known = _known(runs.values)
        if not known.size or (self.false_alarms is not None and runs.false_alarms > self.false_alarms):
            return -math.inf
        return self.sign * float(known.mean())

    def interval(self, values: Values) -> Interval:
        """Return the mean over runs with its interval."""
        if self.of.holds is not None:
            return wilson(int(values.sum()), values.size)
        return mean_of(_known(values)) if self.of.less else mean_share(values)

    def gain(self, one: Values, other: Values) -> Interval:
        """Return by how much the first runs are better than the second: the same runs otherwise."""
        return mean_of(_known(other - one)) if self.of.less else mean_difference(one, other)


class Scored(NamedTuple):
    """Runs of one design point, as an objective sees them."""

    values: Values
    """The measure of each run."""
    false_alarms: float
    """False alarms per 1,000 steps; 0 in a world that doesn't change."""


def objective_for(
    scenario: Scenario, measure: str | None = None, false_alarms: float | None = None
) -> Objective:
    """Return the objective for a scenario; by default, its swarms are to be right as often as possible.

    Raises
    ------
    FeasibeeError
        If the measure, or a bound on false alarms, needs a world that changes.
    """
    chosen = measure or ("right_share" if scenario.dynamic else RIGHT_AT_END)
    if chosen not in TUNED:
        raise FeasibeeError(f"measure = {chosen}: is no measure; choose from {', '.join(TUNED)}")
    if not scenario.dynamic and (chosen != RIGHT_AT_END or false_alarms is not None):
        what = "false alarms" if chosen == RIGHT_AT_END else chosen
        raise FeasibeeError(f"{what}: needs a world that changes; add [[events]] or rates, or leave it out")
    return Objective(chosen, false_alarms)


def scored(
    rounds: Rounds, designs: Sequence[DesignPoint], runs: int, seed: int, objective: Objective
) -> list[Scored]:
    """Run one round; return the measure of each run of each point."""
    records, values = rounds.run(Study(designs, runs, seed)), objective.of.values
    assert values is not None  # as of all that `objective_for` returns
    found = []
    for record, scenario in zip(records, (design.scenario for design in designs), strict=True):
        tracked = tracking(record, scenario)
        alarms = 0.0 if tracked is None else tracked.false_alarms.estimate
        found.append(Scored(values(record, scenario), alarms))
    return found


def _known(values: Values) -> Values:
    return values[np.isfinite(values)]


WORST = -1e9
"""Score of parameters that must not be chosen, as Optuna takes it."""
FINALISTS = 5
"""Number of best trials that are run again, more often, before one is chosen."""
PROPOSED = 2
"""Number of best trials by theory that are run."""
MOST_SCORED = 200
"""Most trials that the theory scores: without noise, more of them hardly find better ones."""
FINAL_RUNS, FRESH_RUNS = 5, 10
"""Runs of a finalist, and of the start and the best at last, as multiples of those of a trial."""
FINAL_SEED, FRESH_SEED = 2**62, 2**63
"""What is added to the seed, modulo 2**64, for these runs."""


class Trial(NamedTuple):
    """Parameters that a search tried."""

    values: dict[str, Any]
    """The parameters, by dotted path."""
    score: float
    """Their score: the mean of the measure, negative if less is better."""


@dataclass(frozen=True)
class Tuned:
    """Result of a search."""

    values: dict[str, Any]
    """The best parameters, by dotted path."""
    start: Interval
    best: Interval
    """The measure with the start's and with the best parameters, on fresh runs: the mean over runs."""
    gain: Interval
    """By how much it is better, over the same fresh runs."""
    trials: list[Trial]
    """Of each trial, in order, its parameters and its score: the mean of the measure, negative if less is
    better. With too many false alarms, the score is -inf. The largest of these scores is biased upwards,
    because it was selected as the largest."""
    objective: Objective = Objective()
    """What was improved."""
    false_alarms: float = 0.0
    """False alarms per 1,000 steps with the best parameters, on fresh runs."""
    predicted: float | None = None
    """The measure with the best parameters, by theory, if it scored the trials; None if all were run."""

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
    theory: bool = True,
) -> Tuned:
    """Search by Optuna's tree-structured Parzen estimator.

    The theory scores the trials if it covers the start and half of them: only two and the start are run.

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
    theory : bool
        Whether the theory may score trials.

    Raises
    ------
    FeasibeeError
        If Optuna isn't installed.
    """
    objective = objective or objective_for(scenario)
    scenario = scenario.replace({"run.stop_at_decision": False})
    search = _search(scenario, space, seed)
    proposed = _proposed(scenario, space, trials, seed) if theory and objective == Objective() else None
    with Rounds(execution, _total(trials, proposed is not None) * runs) as rounds:
        rounds.phase = "trying"
        swarms = _Swarms(rounds, scenario, seed, objective)
        tried = proposed or _try_all(search, space, swarms.score_of(runs), trials, objective)
        return _judge(swarms, tried, runs, proposed is not None)


def _total(trials: int, proposed: bool) -> int:
    """Return the largest number of runs of a search, as a multiple of those of a trial."""
    trying, finalists = (0, PROPOSED) if proposed else (trials, FINALISTS)
    return trying + FINAL_RUNS * (finalists + 1) + FRESH_RUNS * 2


def _proposed(scenario: Scenario, space: Sequence[Dimension], trials: int, seed: int) -> list[Trial] | None:
    """Return the trials within the theory's reach, and their scores by it; None if it doesn't reach far."""
    varied = [
        value for each in space if each.path == "decision.exploration" for value in (each.high, *each.choices)
    ]
    longest = max([scenario.decision.exploration, *varied])
    if longest > LONGEST or WALKED & {each.path for each in space}:
        return None
    screen = Screen(longest)

    def score(values: Mapping[str, Any]) -> float:
        share = screen.right(scenario.replace(values))
        return -math.inf if share is None else share

    choices = ({each.path: choice} for each in space for choice in each.choices)
    if any(score(values) == -math.inf for values in ({}, *choices)):
        return None
    search = _search(scenario, space, seed)
    tried = [_try_one(search, space, score) for _ in range(min(trials, MOST_SCORED))]
    within = [trial for trial in tried if trial[1] > -math.inf]
    return within if 2 * len(within) >= len(tried) else None


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

    def score_of(self, runs: int) -> Callable[[Mapping[str, Any]], float]:
        """Return a function that scores parameters by so many runs."""
        return lambda values: self.objective.score(*self.scored([values], runs))


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
    search: Any, space: Sequence[Dimension], score_of: Callable[[Mapping[str, Any]], float]
) -> Trial:
    """Score the next trial; return its parameters and its score."""
    trial = search.ask()
    values = {each.path: _suggested(trial, each) for each in space}
    score = score_of(values)
    search.tell(trial, max(score, WORST))
    return Trial(dict(trial.params), score)


def _try_all(
    search: Any,
    space: Sequence[Dimension],
    score_of: Callable[[Mapping[str, Any]], float],
    trials: int,
    objective: Objective,
) -> list[Trial]:
    """Score trials in order; end early if the search is for the worst, and the last one had a share of 0."""
    tried: list[Trial] = []
    while len(tried) < trials and not (objective.worst and tried and tried[-1].score == 0):
        tried.append(_try_one(search, space, score_of))
    return tried


def _suggested(trial: Any, each: Dimension) -> Any:
    if each.choices:
        return trial.suggest_categorical(each.path, list(each.choices))
    if each.whole:
        return trial.suggest_int(each.path, round(each.low), round(each.high), log=each.by_ratio)
    return trial.suggest_float(each.path, each.low, each.high, log=each.by_ratio)


def _finalists(tried: Sequence[Trial], best: int = FINALISTS) -> list[dict[str, Any]]:
    """Return the best trials, and the first one: the best of many trials was also lucky."""
    ranked = sorted(tried, key=lambda trial: -trial[1])
    finalists = [values for values, _ in ranked[:best]]
    start, _ = tried[0]
    return finalists if start in finalists else [*finalists, start]


def _judge(swarms: _Swarms, tried: list[Trial], runs: int, proposed: bool = False) -> Tuned:
    """Choose the best of the finalists by more runs; compare it with the start on fresh runs."""
    swarms.rounds.phase = "judging the best"
    finalists = _finalists(tried, PROPOSED if proposed else FINALISTS)
    finals = swarms.scored(finalists, FINAL_RUNS * runs, FINAL_SEED)
    scores = [swarms.objective.score(found) for found in finals]
    chosen = finalists[scores.index(max(scores))]
    at_start, at_best = swarms.scored([{}, chosen], FRESH_RUNS * runs, FRESH_SEED)
    objective = swarms.objective
    return Tuned(
        values=chosen,
        start=objective.interval(at_start.values),
        best=objective.interval(at_best.values),
        gain=objective.gain(at_best.values, at_start.values),
        trials=tried,
        objective=objective,
        false_alarms=at_best.false_alarms,
        predicted=next(share for values, share in tried if values == chosen) if proposed else None,
    )


def draw_search(tuned: Tuned) -> Figure:
    """Draw the measure of each trial with the best so far, and against each parameter.

    The trials are grey, and the parameters that were chosen are highlighted. An axis is logarithmic if its
    values span a decade.
    """
    names, measure = list(tuned.values), tuned.objective.of
    label = f"mean {measure.label}" if measure.ends else measure.label
    if tuned.predicted is not None:
        label = f"predicted {label}"
    scores = np.array([score for _, score in tuned.trials])
    shares = np.where(
        np.isfinite(scores), (100 if measure.unit == "%" else tuned.objective.sign) * scores, np.nan
    )
    so_far = np.fmin if measure.less else np.fmax
    with figure(2.4 * (1 + len(names)), 2.6, columns=1 + len(names), sharey=True) as (drawn, axes):
        axes[0].plot(shares, "o", color=GREY, markersize=3)
        axes[0].step(np.arange(shares.size), so_far.accumulate(shares), color=PALETTE[0], where="post")
        axes[0].set(xlabel="trial", ylabel=label, title="best so far")
        for ax, name in zip(axes[1:], names, strict=True):
            values = [parameters[name] for parameters, _ in tuned.trials]
            shown = [str(value) for value in values] if isinstance(values[0], str | bool) else values
            ax.plot(shown, shares, "o", color=GREY, markersize=3)
            _mark_chosen(ax, tuned, shown, shares)
            along(ax, name_of_axis(name), values)
    return drawn


def _mark_chosen(ax: Axes, tuned: Tuned, shown: Sequence[Any], shares: NDArray[np.float64]) -> None:
    """Highlight the first trial with the parameters that were chosen."""
    place = next(place for place, (values, _) in enumerate(tuned.trials) if values == tuned.values)
    ax.plot(shown[place], shares[place], "o", color=PALETTE[0], markersize=5)
    note(ax, "chosen", (shown[place], shares[place]), (0, 9), ha="center", color=text_colour(PALETTE[0]))


RESAMPLES = 2000


@dataclass(frozen=True)
class Sensitivity:
    """Rank correlation of a field with the share of right swarms."""

    path: str
    """The field."""
    correlation: Interval
    """Spearman's correlation over the points, -1 to 1, with its 95 % interval (bootstrap)."""

    @property
    def matters(self) -> bool:
        """Whether the interval of the correlation excludes 0."""
        return self.correlation.low > 0 or self.correlation.high < 0


def sensitivities(
    scenario: Scenario,
    space: Sequence[Dimension],
    points: int = 200,
    runs: int = 20,
    seed: int = 0,
    execution: Execution | None = None,
) -> tuple[list[Sensitivity], NDArray[np.float64], NDArray[np.float64]]:
    """Vary all fields at once; correlate each with the share of right swarms.

    Parameters
    ----------
    scenario : Scenario
        What all points have in common.
    space : sequence of Dimension
        Fields to vary.
    points : int
        Number of points of the Latin hypercube.
    runs : int
        Number of runs at each point.
    seed : int
        Seed of the hypercube and of the runs.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.

    Returns
    -------
    list of Sensitivity
        The strongest first.
    float64 array, shape (points, fields)
        Place of each point in each field, as a share of the way from its low end to its high end.
    float64 array, shape (points,)
        Share of swarms that are right at the last step, at each point; in a world that changes, share of
        steps at which they are right.
    """
    Runs(points * runs, seed)  # raises before anything is computed
    places = latin_hypercube(points, len(space), seed)
    designs = [_design(scenario, space, place, number * runs) for number, place in enumerate(places)]
    with Rounds(execution) as rounds:
        found_runs = scored(rounds, designs, runs, seed, objective_for(scenario))
        shares = np.array([each.values.mean() for each in found_runs])
    found = [
        Sensitivity(each.path, spearman(places[:, column], shares, seed)) for column, each in enumerate(space)
    ]
    return sorted(found, key=lambda each: -abs(each.correlation.estimate)), places, shares


def _design(
    scenario: Scenario, space: Sequence[Dimension], place: NDArray[np.float64], first_run: int
) -> DesignPoint:
    values = {each.path: each.at(float(share)) for each, share in zip(space, place, strict=True)}
    return DesignPoint(values, scenario.replace({**values, "run.stop_at_decision": False}), first_run)


def latin_hypercube(points: int, dimensions: int, seed: int) -> NDArray[np.float64]:
    """Return points in the unit cube: each axis has as many slices as points, and each slice one point.

    References
    ----------
    McKay, Beckman, Conover, "A comparison of three methods for selecting values of input variables", 1979.
    """
    random = np.random.default_rng(seed)
    slices = np.stack([random.permutation(points) for _ in range(dimensions)], axis=1)
    places: NDArray[np.float64] = (slices + random.random((points, dimensions))) / points
    return places


def spearman(one: NDArray[np.float64], other: NDArray[np.float64], seed: int) -> Interval:
    """Return the rank correlation of two quantities with a bootstrap interval; 0 if one is constant."""
    random = np.random.default_rng(seed)
    drawn = random.integers(0, one.size, (RESAMPLES, one.size))
    resampled = [rank_correlation(one[rows], other[rows]) for rows in drawn]
    low, high = np.quantile(resampled, (0.025, 0.975))
    return Interval(rank_correlation(one, other), float(low), float(high))


def draw_sensitivities(found: Sequence[Sensitivity]) -> Figure:
    """Draw each field's correlation with its interval, the strongest on top; grey if it may be 0."""
    with figure(5.0, 1.0 + 0.28 * len(found)) as (drawn, ax):
        rows = np.arange(len(found))[::-1]
        ax.axvline(0, color="0.8", linewidth=0.8, zorder=0)
        for row, each in zip(rows, found, strict=True):
            middle, low, high = each.correlation
            colour = PALETTE[0] if each.matters else GREY
            look: dict[str, Any] = {"fmt": "o", "color": colour, "markersize": 4}
            ax.errorbar(middle, row, xerr=[[middle - low], [high - middle]], **look)
        ax.set_yticks(rows, [name_of_axis(each.path, unit="") for each in found])
        ax.set(xlim=(-1, 1), ylim=(-0.6, len(found) - 0.4), xlabel="rank correlation with right decisions")
    return drawn
