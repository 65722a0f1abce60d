"""Search for the parameters with which a swarm is right most often within a given time."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from feasibee.errors import FeasibeeError, how_to_install
from feasibee.figures.style import figure, spaced_by_ratio
from feasibee.files import make_folder
from feasibee.results.statistics import Interval, paired_difference, wilson
from feasibee.scenario.scenario import Scenario
from feasibee.studies.comparison import right_at_end
from feasibee.studies.space import Dimension
from feasibee.sweeps.content import short

NAME = "tune.sqlite"
FINALISTS = 5
"""So many of the best trials are run again, more often, before one is chosen."""
FRESH = 2**63
"""What is added to the seed, modulo 2**64, for the runs on which the best is judged."""


@dataclass(frozen=True)
class Tuned:
    """What a search has found.

    Parameters
    ----------
    values : dict
        The best parameters, by dotted path.
    start, best : Interval
        Share of right swarms at the start's and at the best parameters, on fresh runs.
    gain : Interval
        Their difference, over the same fresh runs.
    trials : list of pairs
        Of each trial, in order, its parameters and its share of right swarms: an optimist's figure.
    """

    values: dict[str, Any]
    start: Interval
    best: Interval
    gain: Interval
    trials: list[tuple[dict[str, Any], float]]


def tune(
    scenario: Scenario,
    space: Sequence[Dimension],
    folder: str | Path,
    trials: int = 60,
    runs: int = 200,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Tuned:
    """Search, by Optuna's tree-structured Parzen estimator; goes on with what the folder holds.

    Parameters
    ----------
    scenario : Scenario
        Where the search starts; right means right at its last step.
    space : sequence of Dimension
        What to vary.
    folder : path
        Where the search is kept, in ``tune.sqlite``.
    trials : int
        In all, those of earlier calls counted.
    runs : int
        Runs of each trial; the best is judged on ten times as many fresh ones.
    seed : int
        64 bits.
    threads : int, optional
        By default one for each processor.
    progress : callable, optional
        Called with the share of the work done.

    Raises
    ------
    FeasibeeError
        If Optuna isn't installed, or what the folder holds is damaged.
    """
    scenario = scenario.replace({"run.stop_at_decision": False})
    path = make_folder(folder) / NAME
    search = _search(scenario, space, path, runs, seed)
    while len(search.trials) < trials:
        with _stored(path):
            trial = search.ask()
            values = {each.path: _suggested(trial, each) for each in space}
        share = float(right_at_end(scenario.replace(values), runs, seed, threads=threads).mean())
        with _stored(path):
            trial.set_user_attr("digest", _digest(trial.params, share))
            search.tell(trial, share)
        if progress is not None:
            progress(len(search.trials) / trials * 0.8)
    best = _winner(search, scenario, runs, (seed + FRESH // 2) % 2**64, threads)
    fresh = (seed + FRESH) % 2**64
    start_right = right_at_end(scenario, 10 * runs, fresh, threads=threads)
    best_right = right_at_end(scenario.replace(best), 10 * runs, fresh, threads=threads)
    if progress is not None:
        progress(1.0)
    return Tuned(
        best,
        wilson(int(start_right.sum()), start_right.size),
        wilson(int(best_right.sum()), best_right.size),
        paired_difference(best_right, start_right),
        [(dict(each.params), float(each.value)) for each in search.trials if each.value is not None],
    )


@contextmanager
def _stored(path: Path) -> Iterator[None]:
    """Say in a line what is wrong with the file of a search, whichever library finds it."""
    try:
        yield
    except FeasibeeError:
        raise
    except Exception as error:
        why = short(getattr(error, "orig", error))
        raise FeasibeeError(
            f"{path}: can't be read or written: {why}; move it away, and run the same command again"
        ) from None


def _digest(parameters: Mapping[str, Any], share: float) -> str:
    """Return what tells whether a trial is as it was written."""
    text = json.dumps([sorted(parameters.items()), share])
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def _check_trials(search: Any, path: Path) -> None:
    """Raise an error if a trial that was done isn't as it was written."""
    for place, trial in enumerate(search.trials):
        done = trial.value is not None or "digest" in trial.user_attrs
        if trial.number != place or (
            done and trial.user_attrs.get("digest") != _digest(trial.params, trial.value)
        ):
            raise FeasibeeError(
                f"{path}: trial {place} isn't as it was written; move the file away, and run the same "
                "command again: it searches anew"
            )


def _search(scenario: Scenario, space: Sequence[Dimension], path: Path, runs: int, seed: int) -> Any:
    try:
        import optuna
    except ImportError:
        raise FeasibeeError(f"Optuna: not installed; {how_to_install('tune')}") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    # Another scenario, seed or number of runs is another search; 2: each trial has a digest.
    name = f"2-{scenario.hash[:16]}-{seed}-{runs}-{'-'.join(sorted(each.path for each in space))}"
    with _stored(path):
        search = optuna.create_study(
            storage=f"sqlite:///{path}",
            sampler=optuna.samplers.TPESampler(seed=seed % 2**32),
            study_name=name,
            direction="maximize",
            load_if_exists=True,
        )
        _check_trials(search, path)
        now = {each.path: scenario.get(each.path) for each in space}
        if not search.trials and all(each.holds(now[each.path]) for each in space):
            search.enqueue_trial(now)
    return search


def _suggested(trial: Any, each: Dimension) -> Any:
    if each.choices:
        return trial.suggest_categorical(each.path, list(each.choices))
    if each.whole:
        return trial.suggest_int(each.path, round(each.low), round(each.high), log=each.by_ratio)
    return trial.suggest_float(each.path, each.low, each.high, log=each.by_ratio)


def _winner(search: Any, scenario: Scenario, runs: int, seed: int, threads: int | None) -> dict[str, Any]:
    """Return the best of the best trials by more runs: the first among many was also lucky."""
    ranked = sorted(search.trials, key=lambda trial: -(trial.value or 0.0))
    finalists = [dict(trial.params) for trial in ranked[:FINALISTS]]
    start = next((dict(trial.params) for trial in search.trials[:1]), {})
    if start not in finalists:
        finalists.append(start)
    shares = [
        float(right_at_end(scenario.replace(values), 5 * runs, seed, threads=threads).mean())
        for values in finalists
    ]
    return finalists[shares.index(max(shares))]


def draw_search(tuned: Tuned) -> Figure:
    """Draw the trials: the best so far, and each parameter against the share of right swarms."""
    names = list(tuned.values)
    shares = 100 * np.array([share for _, share in tuned.trials])
    with figure(2.4 * (1 + len(names)), 2.6, columns=1 + len(names), sharey=True) as (drawn, axes):
        axes[0].plot(shares, "o", color="0.6", markersize=3)
        axes[0].step(np.arange(shares.size), np.maximum.accumulate(shares), color="#0072B2", where="post")
        axes[0].set(xlabel="trial", ylabel="right swarms (%)", title="best so far")
        for ax, name in zip(axes[1:], names, strict=True):
            values = [parameters[name] for parameters, _ in tuned.trials]
            told = [str(value) for value in values] if isinstance(values[0], str | bool) else values
            order = ax.scatter(told, shares, c=np.arange(shares.size), cmap="viridis", s=12)
            ax.set(xlabel=name)
            if not isinstance(values[0], str | bool) and min(values) > 0:
                spaced_by_ratio(ax)
        drawn.colorbar(order, ax=axes[-1], label="trial")
    return drawn
