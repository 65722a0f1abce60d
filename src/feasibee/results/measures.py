"""How well the runs of a scenario went: the one table of measures, and how they are computed.

A run is judged by the ground truth; in a world that changes, by that of the step in question. Commands,
studies and figures derive from `MEASURES`, and sum up runs by `Measured`.

All functions take ``results``: runs as Record, Dataset or DataFrame, with each outcome as an attribute. Their
``scenario`` is what these runs were simulated from.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from feasibee.base.codes import DECISIONS, FEASIBLE, INFEASIBLE, UNDECIDED, exact
from feasibee.base.outcomes import ACTS, CHANGES, DECLARES, STOPS, Need
from feasibee.results.statistics import (
    DeclareTimes,
    Interval,
    Quartiles,
    bits_per_robot_and_step,
    confidence_sequence,
    decision_times,
    declare_times,
    event_rate,
    mean_of,
    mean_share,
    plain,
    quartiles,
    wilson,
)
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario

PER: Final = 1000
"""Steps that false alarms are counted per."""
OF_RUNS: Final[Mapping[str, str]] = {
    "right_steps": "steps, from step 1 on, at which the swarm held the truth of that step",
    "changes": "changes of truth just before which the swarm was right",
    "missed": "changes of these that the swarm did not follow before the next one or the end",
    "first_delay": "steps until the swarm followed the first of these changes; -1: none, or missed",
    "false_alarms": "times that the swarm took up the wrong opinion though the truth had not changed",
    "robot_steps": "robots present, summed over the steps from step 1 on",
}
"""Measures of single runs, in words."""


def decided_right(results: Any, scenario: Scenario) -> NDArray[np.bool_]:
    """Return whether the first collective decision of each run was the truth of its step: shape (runs,)."""
    there = truth_of_decisions(results) if scenario.dynamic else int(truth(scenario))
    right: NDArray[np.bool_] = column(results, "decision") == there
    return right


def truth_of_decisions(results: Any) -> NDArray[np.int8]:
    """Return the truth of the step of each run's first decision; of an undecided run, that of step 0."""
    truths, step = np.asarray(results.truth), np.maximum(column(results, "decision_step"), 0)
    there: NDArray[np.int8] = truths[np.arange(step.size), step]
    return there


def ended_right(results: Any, scenario: Scenario, feasible: bool | None = None) -> NDArray[np.bool_]:
    """Return whether more than the threshold's share of each run's robots were right at the end.

    ``feasible`` is the opinion that is right; by default it is the ground truth at the end of each run.
    """
    if scenario.dynamic:
        there = np.asarray(results.truth)[:, -1] if feasible is None else int(feasible)
        agreed: NDArray[np.bool_] = np.asarray(results.held)[:, -1] == there
        return agreed
    wanted = truth(scenario) if feasible is None else feasible
    return is_quorum(column(results, "feasible_at_end" if wanted else "infeasible_at_end"), results, scenario)


def ended_agreed(results: Any, scenario: Scenario) -> NDArray[np.bool_]:
    """Return whether more than the threshold's share of each run's robots agreed at the end, on either."""
    return ended_right(results, scenario, True) | ended_right(results, scenario, False)


def mean_bits(results: Any, scenario: Scenario) -> float:
    """Return the mean number of bits per robot-step over all runs; robots count while they are present."""
    return bits_per_robot_and_step(column(results, "bits_sent"), robot_steps(results, scenario))


def robot_steps(results: Any, scenario: Scenario) -> NDArray[np.int64]:
    """Return the number of robots that are there, summed over the steps of each run: shape (runs,)."""
    if scenario.dynamic:
        return _robot_steps(results)
    return scenario.robots.count * last_steps(results, scenario)


def _robot_steps(results: Any) -> NDArray[np.int64]:
    """Return the same in a world that changes."""
    present = np.asarray(results.robots_present)[:, 1:]
    total: NDArray[np.int64] = np.maximum(present, 0).sum(axis=1, dtype=np.int64)
    return total


def last_steps(results: Any, scenario: Scenario) -> NDArray[np.int64]:
    """Return the last step of each run, which may end at its decision or declarations: shape (runs,)."""
    if STOPS.is_met(scenario):
        return column(results, "last_step")
    decided = column(results, "decision_step")
    ends = scenario.run.stop_at_decision & (decided >= 0)
    return np.where(ends, decided, scenario.run.steps)


def is_quorum(counts: NDArray[Any], results: Any, scenario: Scenario) -> NDArray[np.bool_]:
    """Return whether a number of robots of each run is more than the threshold of the counted ones."""
    enough: NDArray[np.bool_] = counts >= least_quorum(scenario, counted_robots(results, scenario))
    return enough


def least_quorum(scenario: Scenario, counted: Any) -> Any:
    """Return the least number of so many counted robots, or of an array, that is more than the threshold."""
    threshold = exact(scenario.decision.threshold)
    return counted * threshold.numerator // threshold.denominator + 1


def held_decision(scenario: Scenario, feasible: int, infeasible: int, counted: int) -> int:
    """Return the decision of so many counted robots, of which some hold each opinion: 1, 0, or -1 if none."""
    needed = least_quorum(scenario, counted)
    return FEASIBLE if feasible >= needed else INFEASIBLE if infeasible >= needed else UNDECIDED


def counted_robots(results: Any, scenario: Scenario) -> NDArray[np.int64]:
    """Return the number of counted robots at the end of each run: shape (runs,).

    Robots may stop working during a run. A run may end before they do.
    """
    stop = scenario.faults.stop_step
    counted: NDArray[np.int64] = np.where(
        last_steps(results, scenario) < stop, scenario.counted(0), scenario.counted(stop)
    )
    return counted


def column(results: Any, name: str) -> NDArray[np.int64]:
    """Return an outcome as 64-bit integers: shape (runs,)."""
    return np.asarray(getattr(results, name)).astype(np.int64)


class Declarations(NamedTuple):
    """Declarations in the runs of a scenario (model.md 6.14, 6.15)."""

    feasible: float
    infeasible: float
    """Share of the counted robots of all runs that declared feasible, and infeasible."""
    ok: Interval
    """Share of runs in which more than the threshold's share of robots declared rightly, and none wrongly."""
    wrong: Interval
    """Share of runs in which at least one robot declared wrongly."""
    step_90: DeclareTimes
    """Steps by which more than the threshold's share of the robots had declared."""


def declarations(results: Any, scenario: Scenario) -> Declarations | None:
    """Return the shares of runs that declared rightly and wrongly, and when; None without declarations."""
    return measured(results, scenario).declared


def declared_right(results: Any, scenario: Scenario, feasible: bool | None = None) -> NDArray[np.bool_]:
    """Return whether enough robots of each run declared rightly, and none wrongly: bool, shape (runs,).

    ``feasible`` is the opinion that is right; by default the ground truth, before any change.
    """
    wanted = truth(scenario) if feasible is None else feasible
    right = column(results, "declared_feasible" if wanted else "declared_infeasible")
    return is_quorum(right, results, scenario) & ~declared_wrong(results, scenario, wanted)


def declared_wrong(results: Any, scenario: Scenario, feasible: bool | None = None) -> NDArray[np.bool_]:
    """Return whether at least one robot of each run declared wrongly: bool, shape (runs,)."""
    wanted = truth(scenario) if feasible is None else feasible
    return column(results, "declared_infeasible" if wanted else "declared_feasible") > 0


class Changes(NamedTuple):
    """Changes of the truth just before which a swarm was right, in the order of runs and steps."""

    run: NDArray[np.int64]
    """Row of the run."""
    step: NDArray[np.int64]
    """Step of the change."""
    delay: NDArray[np.int64]
    """Steps until the swarm held the new truth; -1 if it did not before the next change or the end."""
    watched: NDArray[np.int64]
    """Last delay that could have been seen: up to the step before the next change, or up to the end."""


class Tracking(NamedTuple):
    """Measures of runs in a world that changes."""

    right_share: Interval
    """Share of steps at which the swarm held the truth of that step, mean over runs."""
    detection_delay: Quartiles
    """Steps from a change of truth to the first step at which the swarm held the new truth."""
    missed: Interval | None
    """Share of changes that the swarm did not follow before the next one or the end; None without any."""
    changes: int
    """Number of changes of truth just before which the swarm was right: those that delays are of."""
    false_alarms: Interval
    """Number of false alarms per 1,000 steps."""

    def to_dict(self) -> dict[str, Any]:
        """Return the measures as plain tables, for programs."""
        tables: dict[str, Any] = plain(self)
        tables["detection_delay"]["changes"] = tables.pop("changes")
        return tables


class RunCounts(NamedTuple):
    """What is counted of runs in a world that changes; runs of several scenarios can be joined."""

    steps: NDArray[np.int64]
    """Number of steps, by run."""
    right: NDArray[np.int64]
    """Number of steps at which the swarm was right, by run."""
    alarms: NDArray[np.int64]
    """Number of false alarms, by run."""
    changes: Changes

    @property
    def shares(self) -> NDArray[np.float64]:
        """Share of the steps at which each swarm was right: shape (runs,)."""
        return self.right / np.maximum(1, self.steps)


def tracking(results: Any, scenario: Scenario, first_step: int = 1) -> Tracking | None:
    """Return how swarms tracked the truth; None in a world that doesn't change, or without steps.

    The results need ``truth`` and ``held``. Steps before ``first_step`` are a warm-up: changes and alarms at
    them aren't counted.

    Notes
    -----
    A *change* is a step whose truth differs from that of the step before. A *false alarm* is a step at which
    a swarm takes up the wrong opinion, although the last opinion that it held since the last change of truth
    was right. Delay and false alarms are the two sides of quickest detection [1]_ [2]_.

    References
    ----------
    .. [1] Page, "Continuous inspection schemes", Biometrika 1954.
    .. [2] Basseville, Nikiforov, "Detection of Abrupt Changes: Theory and Application", 1993.
    """
    return summarised([counts_of(results, first_step)] if scenario.dynamic else [])


def counts_of(results: Any, first_step: int = 1) -> RunCounts:
    """Return what is counted of runs in a world that changes; the arguments are those of `tracking`."""
    truth, held = np.asarray(results.truth), np.asarray(results.held)
    return RunCounts(
        (truth[:, first_step:] >= 0).sum(axis=1),
        _is_right(truth, held)[:, first_step:].sum(axis=1),
        _false_alarms(truth, held, first_step),
        changes_of(truth, held, first_step),
    )


def summarised(parts: Sequence[RunCounts]) -> Tracking | None:
    """Return the measures of some runs together; None if none of them has a step."""
    if not any(part.steps.sum() for part in parts):
        return None
    steps, right, alarms = (np.concatenate(each) for each in zip(*(part[:3] for part in parts), strict=True))
    delay, watched = (
        np.concatenate([getattr(each.changes, name) for each in parts]) for name in ("delay", "watched")
    )
    played, missed = steps > 0, int((delay < 0).sum())
    rate = event_rate(alarms, steps)
    return Tracking(
        mean_share(right[played] / steps[played]),
        quartiles(delay, watched),
        wilson(missed, delay.size) if delay.size else None,
        delay.size,
        Interval(*(PER * each for each in rate)),
    )


def measures_of_runs(results: Any) -> dict[str, NDArray[np.int64]]:
    """Return the measures `OF_RUNS` of each run of a world that changes: shape (runs,)."""
    counts = counts_of(results)
    runs, changes = counts.steps.size, counts.changes
    first = np.full(runs, -1, np.int64)
    first[changes.run[::-1]] = changes.delay[::-1]  # the first change of a run is written last
    return {
        "right_steps": counts.right,
        "changes": np.bincount(changes.run, minlength=runs),
        "missed": np.bincount(changes.run[changes.delay < 0], minlength=runs),
        "first_delay": first,
        "false_alarms": counts.alarms,
        "robot_steps": _robot_steps(results),
    }


def changes_of(truth: ArrayLike, held: ArrayLike, first_step: int = 1) -> Changes:
    """Return the changes of truth just before which a swarm was right, and when it followed them.

    ``truth`` and ``held`` are those of ``feasibee.base.record.Record``; ``first_step`` is the first whose
    change counts.
    """
    truths, right = np.asarray(truth), _is_right(truth, held)
    length = truths.shape[1]
    row, step = np.nonzero(_changed(truths))
    end = (truths >= 0).sum(axis=1)[row]  # the step after the last one watched
    same = row[1:] == row[:-1]
    end[:-1][same] = step[1:][same]
    first = row * length + step
    found = np.append(np.flatnonzero(right.ravel()), right.size)
    followed = found[np.searchsorted(found, first)]
    delay = np.where(followed < row * length + end, followed - first, -1)
    counts = right[row, step - 1] & (step >= first_step)
    return Changes(row[counts], step[counts], delay[counts], (end - 1 - step)[counts])


def _false_alarms(truth: NDArray[Any], held: NDArray[Any], first_step: int) -> NDArray[np.int64]:
    """Return the number of false alarms of each run: shape (runs,)."""
    runs, length = truth.shape
    starts = _changed(truth)
    starts[:, :1] = True
    stretch = np.cumsum(starts.ravel())  # steps of one run and one truth have the same number
    at = np.flatnonzero(((held >= 0) & (truth >= 0)).ravel())
    right = _is_right(truth, held).ravel()[at]
    alarm = np.zeros(at.size, np.bool_)
    alarm[1:] = right[:-1] & ~right[1:] & (stretch[at[1:]] == stretch[at[:-1]])
    places = at[alarm]
    return np.bincount(places[places % length >= first_step] // length, minlength=runs)


def truth_intervals(truth: ArrayLike) -> list[dict[str, Any]] | None:
    """Return the stretches of steps with one truth, if all runs share them; else None.

    Examples
    --------
    >>> from feasibee.results.measures import truth_intervals
    >>> truth_intervals([[1, 1, 0]])
    [{'first': 0, 'last': 1, 'truth': 'feasible'}, {'first': 2, 'last': 2, 'truth': 'infeasible'}]
    """
    truths = np.asarray(truth)
    if not truths.size or (truths != truths[0]).any():
        return None
    shared = truths[0][truths[0] >= 0]
    edges = [0, *(np.flatnonzero(np.diff(shared)) + 1).tolist(), shared.size]
    return [
        {"first": first, "last": after - 1, "truth": DECISIONS[int(shared[first])]}
        for first, after in pairwise(edges)
    ]


def _is_right(truth: ArrayLike, held: ArrayLike) -> NDArray[np.bool_]:
    """Return whether each swarm held the truth at each step; False after the end of a run."""
    truths = np.asarray(truth)
    right: NDArray[np.bool_] = (np.asarray(held) == truths) & (truths >= 0)
    return right


def _changed(truths: NDArray[Any]) -> NDArray[np.bool_]:
    """Return whether the truth of each step differs from that of the step before."""
    changed = np.zeros(truths.shape, np.bool_)
    changed[:, 1:] = (truths[:, 1:] != truths[:, :-1]) & (truths[:, 1:] >= 0)
    return changed


class Achieved(NamedTuple):
    """What robots that act achieved in all runs together, with 95 % confidence intervals (model.md 6.25)."""

    done: Interval
    """Share of runs in which all tasks were taken, or as many as there were robots for."""
    started_in_vain: Interval
    """Share of runs in which a robot took a task although the tasks were infeasible."""
    first_taken_step: DeclareTimes
    """Steps by which a first task was taken."""
    all_taken_step: DeclareTimes
    """Steps by which all tasks were taken: the makespan."""
    tasks_taken: Interval
    """Number of tasks taken at the end of a run."""
    vain_arrivals: Interval
    """Number of arrivals per run at tasks that others had."""
    distance: Interval
    """Distance that a robot walked until all tasks were taken, in units."""
    all_done_step: DeclareTimes | None
    """Steps by which all tasks were done, if they take time (model.md 6.26)."""

    @property
    def makespan(self) -> Interval:
        """The median of the makespan, NaN for never."""
        steps = self.all_taken_step.median, *self.all_taken_step.median_interval
        return Interval(*(np.nan if each is None else float(each) for each in steps))


Acts = Mapping[str, NDArray[Any]]
"""What robots did in each run: outcomes by name, each of shape (runs,).

``distance`` is the mean per robot of the start, in units. ``all_done_step`` is empty unless tasks take time.
"""


def acts_of(results: Any, scenario: Scenario) -> Acts:
    """Return what robots did in each run of a scenario in which they act."""
    names = ("first_taken_step", "all_taken_step", "tasks_taken", "vain_arrivals", "starts_in_vain")
    acts: dict[str, NDArray[Any]] = {name: column(results, name) for name in names}
    acts["distance"] = column(results, "distance_walked") * (scenario.robots.speed / scenario.robots.count)
    acts["all_done_step"] = column(results, "all_done_step")[: None if scenario.tasks.work else 0]
    return acts


def achieved(parts: Sequence[Acts]) -> Achieved | None:
    """Return what robots achieved in the runs of all parts; None without runs."""
    if not sum(each["distance"].size for each in parts):
        return None
    acts = {name: np.concatenate([each[name] for each in parts]) for name in parts[0]}
    runs, done = acts["distance"].size, acts["all_done_step"]
    return Achieved(
        wilson(int((acts["all_taken_step"] >= 0).sum()), runs),
        wilson(int((acts["starts_in_vain"] > 0).sum()), runs),
        declare_times(acts["first_taken_step"]),
        declare_times(acts["all_taken_step"]),
        mean_of(acts["tasks_taken"]),
        mean_of(acts["vain_arrivals"]),
        mean_of(acts["distance"]),
        declare_times(done) if done.size else None,
    )


class Measure(NamedTuple):
    """A number that says how well the runs of a scenario went."""

    name: str
    """Name in commands, tables and JSON."""
    words: str
    """What it is, as the label of an axis."""
    unit: str = "%"
    """Unit in figures; empty if the words have it."""
    needs: Need | None = None
    """What a scenario must have for it; None if all scenarios have it."""
    holds: Callable[[Any, Scenario], NDArray[np.bool_]] | None = None
    """Returns whether it holds of each run, if it is a share of the runs; `Tracking` has the others."""
    less: bool = False
    """Whether less of it is better."""
    ends: str = ""
    """What stands for its estimate and the ends of its interval, if no confidence interval does."""
    column: str = ""
    """Name of its column in exports, if it has one."""
    of_run: str = ""
    """What that column says of a run."""

    @property
    def label(self) -> str:
        """The words with the unit, for an axis."""
        return f"{self.words} ({self.unit})" if self.unit else self.words


def _decided(code: int) -> Callable[[Any, Scenario], NDArray[np.bool_]]:
    return lambda results, scenario: column(results, "decision") == code


_TABLE: Final = (
    Measure(
        "accuracy",
        "right decisions",
        holds=decided_right,
        column="right",
        of_run="whether the swarm's collective decision is the truth",
    ),
    Measure(
        "right_at_end",
        "runs that are right at the end",
        holds=ended_right,
        column="right_at_end",
        of_run="whether more than the threshold's share of the robots hold the true opinion at the end",
    ),
    Measure("declared_ok", "runs that declared rightly", needs=DECLARES, holds=declared_right),
    Measure(
        "declared_wrong", "runs with a robot that declared wrongly", needs=DECLARES, holds=declared_wrong
    ),
    Measure("feasible", "runs that decide feasible", holds=_decided(FEASIBLE)),
    Measure("infeasible", "runs that decide infeasible", holds=_decided(INFEASIBLE)),
    Measure("undecided", "runs that stay undecided", holds=_decided(UNDECIDED)),
    Measure("right_share", "steps at which swarms are right", needs=CHANGES),
    Measure(
        "detection_delay",
        "delay of detection",
        "steps",
        CHANGES,
        less=True,
        ends="median and quartiles",
    ),
    Measure("missed", "changes of truth that swarms missed", needs=CHANGES, less=True),
    Measure("false_alarms", "false alarms per 1,000 steps", "", CHANGES, less=True),
    Measure(
        "done",
        "runs in which all tasks were taken",
        needs=ACTS,
        holds=lambda results, scenario: column(results, "all_taken_step") >= 0,
    ),
    Measure(
        "started_in_vain",
        "runs in which a robot started in vain",
        needs=ACTS,
        holds=lambda results, scenario: column(results, "starts_in_vain") > 0,
        less=True,
    ),
    Measure("makespan", "step at which all tasks are taken, median", "steps", ACTS, less=True),
    Measure("distance", "distance per robot", "units", ACTS, less=True),
)
MEASURES: Final[Mapping[str, Measure]] = {each.name: each for each in _TABLE}
"""All measures by name, in the order in which commands offer them."""
TRACKED: Final = tuple(each.name for each in _TABLE if each.needs is CHANGES)
"""Those of worlds that change, each a field of `Tracking`."""
NONE: Final = Interval(np.nan, np.nan, np.nan)


def rightness(results: Any, scenario: Scenario) -> dict[str, NDArray[np.bool_]]:
    """Return the measures with a column in exports, of each run: bool, shape (runs,)."""
    return {each.column: each.holds(results, scenario) for each in _TABLE if each.column and each.holds}


class Measured(NamedTuple):
    """What came of the runs of one scenario."""

    runs: int
    counts: Mapping[str, int]
    """Number of runs of which each measure holds that is a share of the runs."""
    times: Quartiles
    """Steps of the decisions."""
    bits: float
    """Bits per robot-step."""
    declared: Declarations | None
    """Declarations in the runs; None without runs, or if the robots can't declare."""
    followed: RunCounts | None
    """What is counted of how swarms tracked the truth; None in a world that doesn't change."""
    sequential: bool = False
    """Whether a stopping rule chose the number of runs."""
    acts: Acts | None = None
    """What robots did in each run; None if they don't act."""

    def share(self, name: str) -> Interval | None:
        """Return a share of the runs; None without runs, or if their scenario doesn't have it."""
        return together([self], name) if self.runs and name in self.counts else None

    @property
    def rates(self) -> dict[str, Interval]:
        """Shares of the runs by decision."""
        return {name: together([self], name) for name in DECISIONS.values()}

    @property
    def tracking(self) -> Tracking | None:
        """How swarms tracked the truth; None without runs, or in a world that doesn't change."""
        return summarised([self.followed] if self.followed else [])

    @property
    def acting(self) -> Achieved | None:
        """What robots that act achieved; None without runs, or if they don't act."""
        return achieved([self.acts] if self.acts else [])

    def to_dict(self) -> dict[str, Any]:
        """Return declarations, what robots did, and how swarms tracked the truth, as plain tables."""
        tracking, acting = self.tracking, self.acting
        did = {} if acting is None else {"acting": plain(acting)}
        return {"declared": plain(self.declared), **did, **({} if tracking is None else tracking.to_dict())}


def measured(results: Any, scenario: Scenario, sequential: bool = False) -> Measured:
    """Sum up the runs of a scenario.

    If a stopping rule chose the number of runs, they are ``sequential``: shares then have confidence
    sequences.
    """
    had = [each for each in _TABLE if each.needs is None or each.needs.is_met(scenario)]
    found = Measured(
        column(results, "decision").size,
        {each.name: int(each.holds(results, scenario).sum()) for each in had if each.holds},
        decision_times(results.decision_step),
        mean_bits(results, scenario),
        None,
        counts_of(results) if scenario.dynamic else None,
        sequential,
        acts_of(results, scenario) if scenario.acts else None,
    )
    if not (found.runs and scenario.declares):
        return found
    robots = max(1, int(counted_robots(results, scenario).sum()))
    feasible, infeasible = (column(results, f"declared_{name}").sum() for name in ("feasible", "infeasible"))
    ok, wrong = (together([found], name) for name in ("declared_ok", "declared_wrong"))
    times = declare_times(column(results, "declare_step"))
    declared = Declarations(float(feasible / robots), float(infeasible / robots), ok, wrong, times)
    return found._replace(declared=declared)


def together(parts: Sequence[Measured], name: str) -> Interval:
    """Return a measure of the runs of some points together; NaN where it is unknown, or never.

    The interval of a share of runs is Wilson's, or a confidence sequence if a stopping rule chose the runs of
    one of the points. That of a delay of detection is from its lower to its upper quartile.
    """
    if MEASURES[name].holds:
        counted = [each for each in parts if each.runs and name in each.counts]
        runs = sum(each.counts[name] for each in counted), sum(each.runs for each in counted)
        interval = confidence_sequence if any(each.sequential for each in counted) else wilson
        return interval(*runs) if counted else NONE
    of_all: Tracking | Achieved | None
    if name in TRACKED:
        of_all = summarised([each.followed for each in parts if each.followed])
    else:
        of_all = achieved([each.acts for each in parts if each.acts])
    found = getattr(of_all, name, None)
    if isinstance(found, Quartiles):
        ends = (np.nan if step is None else float(step) for step in (found.median, found.q25, found.q75))
        return Interval(*ends)
    return NONE if found is None else found


def tracked(results: Any, scenario: Scenario) -> dict[str, Any]:
    """Return how swarms tracked the truth, and when it changed, as plain tables; none if it can't change."""
    found = tracking(results, scenario)
    return {} if found is None else {**found.to_dict(), "truth_intervals": truth_intervals(results.truth)}


def columns(name: str, found: Interval | Quartiles | None) -> dict[str, object]:
    """Return an interval or quartiles as columns of a table, None for what is unknown."""
    ends = Quartiles._fields if isinstance(found, Quartiles) else ("", "low", "high")
    cells = found or (None, None, None)
    return {f"{name}_{end}" if end else name: cell for end, cell in zip(ends, cells, strict=True)}
