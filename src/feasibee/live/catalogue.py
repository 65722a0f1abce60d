"""What the command line lets pages show: a scenario, or the runs of a sweep."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from feasibee.errors import FeasibeeError
from feasibee.model.codes import DECISIONS, FEASIBLE, INFEASIBLE, UNDECIDED
from feasibee.scenario.plugins import registered
from feasibee.scenario.scenario import Scenario
from feasibee.strategies import STRATEGIES
from feasibee.sweeps.journal import Journal, Row

PICKS: Final = ("wrong", "right", "undecided", "feasible", "infeasible", "all")
LISTED: Final = 500
"""Runs of a sweep that are sent to a page."""


@dataclass(frozen=True)
class Replay:
    """A run of a sweep."""

    point: int
    run: int
    decision: int
    decision_step: int


@dataclass(frozen=True)
class Programme:
    """What pages may show.

    Parameters
    ----------
    scenario : Scenario
        What a page starts from.
    seed, run : int
        Which run of it.
    title : str
        Where it comes from: the name of a file or folder.
    points : mapping of int to Row
        Those of a journal.
    replays : sequence of Replay
        Runs of these points, at most `LISTED`, as many of each.
    found : int
        How many there are.
    pick : str
        What these have in common; one of `PICKS`.
    """

    scenario: Scenario
    seed: int = 0
    run: int = 0
    title: str = ""
    points: Mapping[int, Row] = field(default_factory=dict)
    replays: tuple[Replay, ...] = ()
    found: int = 0
    pick: str = ""

    def scenario_of(self, point: int | None) -> Scenario:
        """Return the scenario of a point, as it was when the sweep ran; without one, what a page starts from.

        Raises
        ------
        FeasibeeError
            If there is no such point.
        """
        if point is None and not self.replays:
            return self.scenario
        point = self.replays[0].point if point is None else point
        if point not in self.points:
            raise FeasibeeError(
                f"point = {point}: isn't in {self.title or 'a journal'}; choose a run listed there"
            )
        return self.points[point].scenario

    def seed_of(self, point: int | None) -> int:
        """Return the seed of a point."""
        return self.seed if point is None else self.points[point].seed

    @property
    def strategies(self) -> list[str]:
        """Names of all strategies that appear: built-in ones, other packages', and those of the scenarios."""
        named = [self.scenario, *(row.scenario for row in self.points.values())]
        names = [*STRATEGIES, *registered(), *(each.decision.strategy for each in named)]
        return list(dict.fromkeys(names))

    def to_dict(self) -> dict[str, Any]:
        """Return what a page is told of it."""
        return {
            "title": self.title,
            "strategies": self.strategies,
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
                    "values": {path: _text(value) for path, value in self.points[each.point].values.items()},
                    "decision": DECISIONS[each.decision],
                    "decision_step": each.decision_step,
                    "truth": DECISIONS[int(self.points[each.point].truth)],
                }
                for each in self.replays
            ],
        }


def _text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, default=str)


def of_folder(folder: Path, pick: str, trust: bool = False) -> Programme:
    """Return the programme of a sweep's folder: its runs that decided in a way.

    Parameters
    ----------
    folder : path
        With a journal.
    pick : str
        One of `PICKS`; ``"wrong"`` are those whose first decision isn't as the truth.
    trust : bool
        Whether the texts of strategies that the journal keeps may be run, if they aren't the user's own.

    Raises
    ------
    FeasibeeError
        If there is no journal, or no such run.
    """
    with Journal(folder) as journal:
        points = {row.id: _trusted(row) if trust else row for row in journal.points}
        chosen: dict[int, list[Replay]] = {}
        found = 0
        for row in points.values():
            columns = journal.columns(row.id)[:, :3]
            picked = columns[_is_picked(columns[:, 1], row.truth, pick)]
            found += len(picked)
            if len(picked):
                chosen[row.id] = [Replay(row.id, *numbers) for numbers in picked[:LISTED].tolist()]
    each = max(1, LISTED // max(1, len(chosen)))  # of every point, so that no one fills the list
    replays = [replay for runs in chosen.values() for replay in runs[:each]][:LISTED]
    if not replays:
        which = "runs" if pick == "all" else f"runs that are {pick}"
        raise FeasibeeError(f"{folder}: has no {which}; choose another --pick: {', '.join(PICKS)}")
    first = replays[0]
    used = {each.point for each in replays}
    shown = {point: row for point, row in points.items() if point in used}
    scenario = points[first.point].scenario
    return Programme(
        scenario, points[first.point].seed, first.run, str(folder), shown, tuple(replays), found, pick
    )


def _trusted(row: Row) -> Row:
    return row._replace(scenario=row.scenario.with_trust())


def _is_picked(decisions: Any, true: bool, pick: str) -> Any:
    return {
        "wrong": (decisions != UNDECIDED) & (decisions != true),
        "right": decisions == true,
        "undecided": decisions == UNDECIDED,
        "feasible": decisions == FEASIBLE,
        "infeasible": decisions == INFEASIBLE,
        "all": slice(None),
    }[pick]
