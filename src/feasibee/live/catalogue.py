"""The catalogue: the scenario or the runs of a sweep that `feasibee watch` offers to its pages."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from feasibee.errors import FeasibeeError
from feasibee.files import named
from feasibee.model.codes import DECISIONS, FEASIBLE, INFEASIBLE, UNDECIDED
from feasibee.results.measures import truth_of_decisions
from feasibee.scenario.fields import dimension_of
from feasibee.scenario.plugins import registered
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import in_brackets
from feasibee.strategies import STRATEGIES
from feasibee.sweeps.journal import Journal, StoredPoint

STREAM: Final[Mapping[str, Any]] = {
    "robots.count": 20,
    "tasks.count": 20,
    "tasks.arrival_rate": 0.0114,
    "tasks.lifetime": 1800.0,
    "decision.strategy": next(name for name, each in STRATEGIES.items() if each.judges),
    "run.steps": 2500,
}
"""A world whose truth changes every 500 steps on average: `examples/changing.toml`, as the form's preset."""
PICKS: Final = ("wrong", "right", "undecided", "feasible", "infeasible", "all")
LISTED: Final = 500
"""Most runs of a sweep that a page lists."""


@dataclass(frozen=True)
class Replay:
    """A run of a sweep that a page can replay."""

    point: int
    run: int
    decision: int
    decision_step: int


@dataclass(frozen=True)
class Catalogue:
    """Scenario and runs that pages may show.

    Parameters
    ----------
    scenario : Scenario
        Scenario that a page starts with.
    seed, run : int
        Seed and number of the run that a page starts with.
    title : str
        Name of the file or folder that the scenario comes from.
    points : mapping of int to StoredPoint
        Points of the sweep that have a run in `replays`, by number.
    replays : sequence of Replay
        Runs of these points, at most `LISTED`, as many of each point.
    found : int
        Number of runs of the sweep that match `pick`, listed or not.
    pick : str
        One of `PICKS`: the decisions that were looked for.
    """

    scenario: Scenario
    seed: int = 0
    run: int = 0
    title: str = ""
    points: Mapping[int, StoredPoint] = field(default_factory=dict)
    replays: tuple[Replay, ...] = ()
    found: int = 0
    pick: str = ""

    def scenario_of(self, point: int | None) -> Scenario:
        """Return the scenario of a point as it was when the sweep ran; for None, the one to start with.

        Raise a FeasibeeError if the point is not listed.
        """
        if point is None and not self.replays:
            return self.scenario
        point = self.replays[0].point if point is None else point
        if point not in self.points:
            raise FeasibeeError(
                f"point = {point}: not found in {self.title or 'a journal'}; choose a run of the list"
            )
        return self.points[point].scenario

    def seed_of(self, point: int | None) -> int:
        """Return the seed of a point; for None, the one to start with."""
        return self.seed if point is None else self.points[point].seed

    @property
    def strategies(self) -> list[str]:
        """Names of all strategies to choose from: built-in, of other packages, and of the scenarios."""
        scenarios = [self.scenario, *(row.scenario for row in self.points.values())]
        names = [*STRATEGIES, *registered(), *(each.decision.strategy for each in scenarios)]
        return list(dict.fromkeys(names))

    def to_dict(self) -> dict[str, Any]:
        """Return the catalogue as a page receives it, in the message ``welcome``."""
        return {
            "title": named(self.title),
            "strategies": self.strategies,
            "stream": dict(STREAM),
            "seed": str(self.seed),
            "run": str(self.run),
            "point": self.replays[0].point if self.replays else None,
            "pick": self.pick,
            "found": self.found,
            "replays": [
                {
                    "point": each.point,
                    "run": str(each.run),
                    "seed": str(self.points[each.point].seed),
                    "values": {
                        path: (value if isinstance(value, str) else json.dumps(value, default=str))
                        + in_brackets(self.points[each.point].scenario, dimension_of(path), value)
                        for path, value in self.points[each.point].values.items()
                    },
                    "decision": DECISIONS[each.decision],
                    "decision_step": each.decision_step,
                }
                for each in self.replays
            ],
        }


def read_catalogue(folder: Path, pick: str, trust: bool = False) -> Catalogue:
    """Return the catalogue of a sweep: the runs whose decision matches ``pick``.

    Parameters
    ----------
    folder : path
        Folder of the sweep, with its journal.
    pick : str
        One of `PICKS`; ``"wrong"`` selects runs whose first decision differs from the ground truth of its
        step.
    trust : bool
        Whether strategies may run from the text in the journal, where it isn't that of the user's own file.

    Raises
    ------
    FeasibeeError
        If the folder has no journal, or no run matches.
    """
    with Journal(folder) as journal:
        points = {
            row.id: row._replace(scenario=row.scenario.with_trust()) if trust else row
            for row in journal.points
        }
        chosen: dict[int, list[Replay]] = {}
        found = 0
        for row in points.values():
            picked = _picked(row, journal.results(row.id), pick)
            found += len(picked)
            if len(picked):
                chosen[row.id] = [Replay(row.id, *numbers) for numbers in picked[:LISTED].tolist()]
    each = max(1, LISTED // max(1, len(chosen)))  # the same number of each point
    replays = [replay for runs in chosen.values() for replay in runs[:each]][:LISTED]
    if not replays:
        which = "runs" if pick == "all" else f"runs that are {pick}"
        raise FeasibeeError(f"{folder}: has no {which}; use another --pick: {', '.join(PICKS)}")
    used = {each.point for each in replays}
    shown = {point: row for point, row in points.items() if point in used}
    first = points[replays[0].point]
    run = replays[0].run
    return Catalogue(first.scenario, first.seed, run, str(folder), shown, tuple(replays), found, pick)


def _picked(row: StoredPoint, results: Any, pick: str) -> NDArray[np.int64]:
    """Return number, decision and its step of each run that matches ``pick``."""
    true = truth_of_decisions(results) if row.scenario.dynamic else int(row.truth)
    decisions = results.decision
    chosen = {
        "wrong": (decisions != UNDECIDED) & (decisions != true),
        "right": decisions == true,
        "undecided": decisions == UNDECIDED,
        "feasible": decisions == FEASIBLE,
        "infeasible": decisions == INFEASIBLE,
        "all": slice(None),
    }[pick]
    runs = np.stack([results.run, decisions, results.decision_step], axis=1)
    picked: NDArray[np.int64] = runs.astype(np.int64)[chosen]
    return picked
