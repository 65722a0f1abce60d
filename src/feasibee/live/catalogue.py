"""The catalogue: the scenario or the runs of a sweep that `feasibee watch` offers, and what pages ask."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from feasibee.base.codes import DECISIONS
from feasibee.base.errors import FeasibeeError, Problem, ScenarioError
from feasibee.live.form import EVENTS, STRATEGY, typed
from feasibee.live.packet import check_scenario
from feasibee.results.measures import decided_right
from feasibee.scenario.fields import dimension_of
from feasibee.scenario.plugins import is_own, registered
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.tables import with_names
from feasibee.scenario.units import in_brackets
from feasibee.simulation.store import Store, StoredPoint
from feasibee.strategies import STRATEGIES

Whole = Annotated[str, Field(pattern="^[0-9]{1,20}$")]
"""A whole number as text: JavaScript's numbers have 53 bits."""
PICKS: Final = ("wrong", "right", "undecided", "feasible", "infeasible", "all")
LISTED: Final = 500
"""Most runs that are listed."""


class SweptRun(NamedTuple):
    """A run of a sweep that can be replayed."""

    point: StoredPoint
    run: int
    decision: int
    decision_step: int


class Request(BaseModel):
    """Request of a page for a scenario: changes to that of a point, or to the one to start with."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    point: int | None = None
    changes: dict[str, JsonValue] = Field({}, max_length=64)
    """By dotted path."""
    seed: Whole = "0"
    run: Whole = "0"


@dataclass(frozen=True)
class Catalogue:
    """The scenario and run that pages start with, and those of a sweep that they may show."""

    scenario: Scenario
    seed: int = 0
    run: int = 0
    title: str = ""
    """Name of the file or folder that the scenario comes from."""
    point: int | None = None
    """Point of the sweep that pages start with."""
    points: Mapping[int, StoredPoint] = field(default_factory=dict)
    replays: Mapping[str, Any] | None = None
    """Runs of these points, as a page lists them."""

    def chosen(self, asked: Request) -> tuple[Scenario, Runs]:
        """Return the scenario and the run that a page asks for.

        Raise a FeasibeeError if scenario, seed or run is invalid or beyond the limits of a page; it lists all
        problems.
        """
        runs = Runs.single(int(asked.seed), int(asked.run))
        if asked.point is not None and asked.point not in self.points:
            raise FeasibeeError(f"point = {asked.point}: not found; choose a run of the list")
        base = self.scenario if asked.point is None else self.points[asked.point].scenario
        changes = {path: typed(path, value) for path, value in asked.changes.items()}
        if changes.get(STRATEGY) == base.decision.strategy:
            del changes[STRATEGY]  # keep its text: the file at that path may have changed
        problems = list(_forbidden(changes))
        allowed = {path: changes[path] for path in changes.keys() - {each.path for each in problems}}
        try:
            scenario = base.replace(allowed)
            check_scenario(scenario)
        except ScenarioError as error:
            problems += error.problems
        if problems:
            raise ScenarioError(problems)
        return scenario, runs


def _forbidden(changes: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield a problem per change that would open a file or whose path isn't a field's."""
    strategies = [*STRATEGIES, *registered()]
    for path, value in changes.items():
        if path == STRATEGY and value not in strategies:
            remedy = "to use a file, run feasibee watch --set decision.strategy=FILE.py"
            yield Problem(path, value, f"must be one of {', '.join(strategies)}", remedy)
        elif path != STRATEGY and with_names(path, value, lambda name: None) != value:
            remedy = "set it in the scenario of feasibee watch FILE"
            yield Problem(path, value, "can't be a file on this page", remedy)
        elif "." not in path and path not in ("preset", EVENTS):
            remedy = "write section.field, such as tasks.count"
            yield Problem(path, value, "must be the path of a field", remedy)


def read_catalogue(folder: Path, pick: str, trust: bool = False) -> Catalogue:
    """Return the catalogue of a sweep: the runs that `picked_runs` returns.

    Pages start with the first whose strategy may run. With ``trust``, strategies may run from the text in the
    folder, where it isn't that of the user's own file.
    """
    picked, found = picked_runs(folder, pick)
    points = {row.id: row for row, *_ in picked}
    if trust:
        points = {n: row._replace(scenario=row.scenario.with_trust()) for n, row in points.items()}
    may_run = {n for n, row in points.items() if trust or is_own(row.scenario.manifest)}
    first = next((each for each in picked if each.point.id in may_run), picked[0])
    start = points[first.point.id]
    replays = {"replays": list(map(_listed, picked)), "pick": pick, "found": found}
    return Catalogue(start.scenario, start.seed, first.run, str(folder), start.id, points, replays)


def picked_runs(folder: Path, pick: str) -> tuple[list[SweptRun], int]:
    """Return runs whose decision matches one of `PICKS`, and how many there are.

    ``"wrong"`` selects runs whose first decision differs from the ground truth of its step. At most `LISTED`
    are returned, as many of each point. Raise a FeasibeeError if the folder has no results, or no such run.
    """
    picked: list[list[SweptRun]] = []
    found = 0
    store = Store(folder)
    for row in store.points:
        results = store.results(row.key)
        runs = np.flatnonzero(_are_picked(results, row.scenario, pick))
        found += len(runs)
        if len(runs):
            columns = (results.run, results.decision, results.decision_step)
            listed = zip(*(each[runs[:LISTED]].tolist() for each in columns), strict=True)
            picked.append([SweptRun(row, *run) for run in listed])
    store.check()
    if not picked:
        which = "runs" if pick == "all" else f"runs that are {pick}"
        raise FeasibeeError(f"{folder}: has no {which}; use another --pick: {', '.join(PICKS)}")
    each = max(1, LISTED // len(picked))
    return [replay for replays in picked for replay in replays[:each]][:LISTED], found


def _are_picked(results: Any, scenario: Scenario, pick: str) -> NDArray[np.bool_]:
    """Return whether each run matches one of `PICKS`: bool, shape (runs,)."""
    matches: dict[str, NDArray[np.bool_]]
    matches = {name: results.decision == code for code, name in DECISIONS.items()}
    right = decided_right(results, scenario)
    matches |= {"right": right, "wrong": ~right & ~matches["undecided"], "all": np.ones_like(right)}
    return matches[pick]


def _listed(replay: SweptRun) -> dict[str, Any]:
    """Return a run as a page lists it: values of its point with metres and seconds, if they are known."""
    row = replay.point
    values = {
        path: (value if isinstance(value, str) else json.dumps(value, default=str))
        + in_brackets(row.scenario, dimension_of(path), value)
        for path, value in row.values.items()
    }
    which = {"point": row.id, "run": str(replay.run), "seed": str(row.seed), "values": values}
    return {**which, "decision": DECISIONS[replay.decision], "decision_step": replay.decision_step}
