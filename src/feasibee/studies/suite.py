"""Suites of the benchmark: frozen worlds, each with a side whose tasks are feasible and one whose are not."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from importlib.resources import files
from typing import Any, Final, Literal, NamedTuple, Self

from feasibee.scenario.plugins import manifest_of
from feasibee.scenario.scenario import Scenario

LATEST: Final = "1"
"""The version of the suite that is run."""
SIDES: Final = ("feasible", "infeasible")
Side = Literal["feasible", "infeasible"]


class World(NamedTuple):
    """A world of a suite."""

    name: str
    group: str
    """What the world is hard by, such as ``"noise"``."""
    about: str
    sides: tuple[Mapping[str, Any], Mapping[str, Any]]
    """Changes of the paper's swarm, as tables: with feasible tasks, and with infeasible ones."""
    runs: float = 1.0
    """Share of the runs that it takes: large swarms take fewer."""
    known: float | None = None
    """Share that an observer without names could put right who hears of all sightings, where it is known."""

    def of(self, runs: int) -> int:
        """Return its number of runs of a side, at least 1."""
        return max(1, round(self.runs * runs))

    def scenario(
        self, side: str, strategy: str, source: str | None = None, *, trusted: bool = True
    ) -> Scenario:
        """Return a side with a strategy, whose robots know their number if it needs that.

        Parameters
        ----------
        side : str
            One of `SIDES`.
        strategy : str
            A built-in strategy, or the path of a file.
        source : str, optional
            The text to take for the file's; by default it is read.
        trusted : bool
            Whether that text may be run.

        Raises
        ------
        ScenarioError
            If the strategy can't take the world.
        """
        given = {"know_count": manifest_of(strategy, source).needs_count}
        tables = merged(self.sides[SIDES.index(side)], {"robots": given, "decision": {"strategy": strategy}})
        return Scenario.from_tables(tables, source=source, trusted=trusted)


@dataclass(frozen=True)
class Suite:
    """A frozen list of worlds."""

    version: str
    text: str
    """Its file."""

    @classmethod
    def read(cls, version: str = LATEST) -> Self:
        """Read a suite of this package."""
        return cls(version, (FOLDER / f"{version}.toml").read_text("utf-8"))

    @property
    def digest(self) -> str:
        """SHA-256 of its file."""
        return sha256(self.text.encode()).hexdigest()

    @cached_property
    def worlds(self) -> tuple[World, ...]:
        """Its worlds, in their order."""
        return tuple(_world(**each) for each in tomllib.loads(self.text)["world"])


FOLDER: Final = files("feasibee.studies") / "suites"


def _world(sides: list[Any], set: Mapping[str, Any] | None = None, **about: Any) -> World:  # noqa: A002
    one, other = (merged(set or {}, each) for each in sides)
    return World(**about, sides=(one, other))


def merged(one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a scenario with those of another laid over them."""
    return {
        **one,
        **{
            name: {**one.get(name, {}), **table} if isinstance(table, Mapping) else table
            for name, table in other.items()
        },
    }
