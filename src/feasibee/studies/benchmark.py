"""The benchmark: every contender in every world of a suite, and its card.

A card is a file with the texts of its strategies, its seed and what was counted, so that anyone can simulate
it again and compare each number.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Final, Literal, NamedTuple, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from feasibee.base.codes import MODEL_VERSION
from feasibee.base.errors import FeasibeeError, ScenarioError, one_line
from feasibee.base.files import read_text, write_text
from feasibee.base.record import Record
from feasibee.results.statistics import declare_times
from feasibee.robot.sizes import PROCESSORS, size_of
from feasibee.scenario.plugins import manifest_of
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.plan import DesignPoint, Study
from feasibee.simulation.schedule import run_work
from feasibee.simulation.sweep import Execution, Rounds
from feasibee.strategies import STRATEGIES
from feasibee.studies.comparison import CONTENDER, check_distinct, looks_at, outcome_of, rounds_of
from feasibee.studies.needs import Asked
from feasibee.studies.suite import FOLDER, LATEST, SIDES, Side, Suite, World

PLAIN: Final = "near"
"""The world in which memory and size in C are measured."""
PROCESSOR: Final = "x86-64"
PHASE: Final = "runs of each side"


def _printable(name: str) -> str:
    if one_line(name) != name:
        raise ValueError("must be one short printable line")
    return name


Name = Annotated[str, AfterValidator(_printable)]
Count = Annotated[int, Field(ge=0, le=2**53)]
Share = Annotated[float, Field(ge=0, le=1)]


class Row(NamedTuple):
    """What was counted of a contender in one side of a world."""

    contender: Name
    world: Name
    side: Side
    runs: Annotated[int, Field(ge=1, le=2**31)]
    right: Annotated[float, Field(ge=0)]
    """Number of runs that were right at the last step; in a world that changes, sum of shares of steps."""
    ok: Count | None
    """Number of runs in which robots declared rightly; None if they don't declare."""
    wrong: Count | None
    """Number of runs in which at least one robot declared wrongly."""
    median: Count | None
    p95: Count | None
    """Steps by which half and 95 % of the swarms had decided; None: never."""
    bits: Annotated[float, Field(ge=0)]
    """Bits sent per robot-step."""
    brier: Share | None
    """Brier score; None in a world that changes."""


class Contender(BaseModel):
    """A strategy on a card."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    source: str = ""
    """The text of its file; a built-in strategy has none."""
    given: tuple[Literal["names", "ids", "count"], ...] = ()
    """What its robots are given or recognise: ``"names"``, ``"ids"`` or ``"count"``."""
    memory: Count = 0
    """Bits that a robot remembers in the plain world."""
    flash: Count | None = None
    """Bytes of its controller in C, where it can be translated and a compiler was found."""


class Card(BaseModel):
    """What came of a benchmark."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    suite: str
    suite_sha256: str
    version: str
    model_version: int
    seed: Annotated[int, Field(ge=0, lt=2**64)]
    runs: Annotated[int, Field(ge=1, le=100_000)]
    """Number of runs of each side of a world."""
    contenders: dict[Name, Contender]
    rows: tuple[Row, ...]

    @model_validator(mode="after")
    def _has_texts(self) -> Self:
        """Check that each text is there: a card must not name files of whoever reads it."""
        for name, each in self.contenders.items():
            if not each.source and name not in STRATEGIES:
                raise ValueError(f"{name} is neither built in, nor is its text there")
        return self

    @classmethod
    def read(cls, path: Path) -> Self:
        """Read a card; nothing of it is run.

        Raises
        ------
        FeasibeeError
            If it can't be read, or isn't a card.
        """
        try:
            return cls.model_validate_json(read_text(path, "a card of feasibee benchmark"))
        except ValidationError as error:
            first = error.errors()[0]
            place = one_line(".".join(map(str, first["loc"])))
            rule = (
                f"isn't a card of feasibee benchmark: {place + ': ' if place else ''}{one_line(first['msg'])}"
            )
            raise FeasibeeError(f"{path}: {rule}; use its file benchmark.json") from None

    def write(self, path: Path) -> None:
        """Write the card, a row per line."""
        head = json.dumps(self.model_dump(mode="json", exclude={"rows"}), indent=1)
        rows = ",\n".join(json.dumps(row) for row in self.rows)
        write_text(path, f'{head[:-2]},\n "rows": [\n{rows}\n ]\n}}\n')

    @cached_property
    def worlds(self) -> tuple[World, ...]:
        """The worlds of its suite, which must be one of this package, with the same text."""
        suite = Suite.read()
        if (self.suite, self.suite_sha256) != (suite.version, suite.digest):
            rule = f"is suite {self.suite} ({self.suite_sha256[:16]}), which this version lacks"
            raise FeasibeeError(f"suite: {rule}; use feasibee {self.version}")
        return suite.worlds

    def joined(self, other: Card) -> Card:
        """Return the contenders of this card and those of another one, each with its own runs."""
        others = {name: each for name, each in other.contenders.items() if name not in self.contenders}
        rows = (*self.rows, *(row for row in other.rows if row.contender in others))
        return self.model_copy(update={"contenders": {**self.contenders, **others}, "rows": rows})


def board() -> Card:
    """Return the card of all built-in strategies that comes with this package."""
    return Card.model_validate_json((FOLDER / f"{LATEST}.json").read_text("utf-8"))


def benchmark(
    strategies: Sequence[str] = (),
    runs: int = 200,
    seed: int = 0,
    execution: Execution | Rounds | None = None,
) -> Card:
    """Simulate strategies in all worlds of the suite that they can take.

    Parameters
    ----------
    strategies : sequence of str
        Names, or paths of files; by default all built-in ones.
    runs : int
        Number of runs of each side of a world; large swarms take a stated share of them.
    seed : int
        64 bits. If it is drawn anew, nobody can fit a strategy to it.
    execution : Execution or Rounds, optional
        Where to compute and keep the runs. If it ends the study early, there are fewer runs.

    Raises
    ------
    FeasibeeError
        If a strategy is unknown, no strategy, or named twice, or can't take the plain world.
    """
    suite, sources = Suite.read(), _sources(strategies or tuple(STRATEGIES))
    contenders = {label: _contender(suite.worlds, label, source) for label, source in sources.items()}
    designs = list(designs_of(suite.worlds, sources, seed))
    with rounds_of(execution, PHASE) as rounds:
        rounds.phases = {PHASE: sum(run_work(each.scenario) * world.of(runs) for each, world in designs)}
        done = looks_at(
            rounds,
            runs,
            lambda number: studies_of(designs, number, seed),
            lambda number: _so_far(rows_of(rounds, designs, number, seed)),
        )
        rows = rows_of(rounds, designs, done, seed)
    return Card(
        suite=suite.version,
        suite_sha256=suite.digest,
        version=version("feasibee"),
        model_version=MODEL_VERSION,
        seed=seed,
        runs=done,
        contenders=contenders,
        rows=tuple(rows),
    )


def _sources(names: Sequence[str]) -> dict[str, str]:
    """Return the texts of strategies by their names without folders, empty for built-in ones."""
    labels = [Path(name).name for name in names]
    check_distinct(labels)
    for label in labels:
        if one_line(label) != label:
            raise FeasibeeError(f"{label}: must be a printable line, to stand in a card; rename the file")
    return {label: manifest_of(name).source for label, name in zip(labels, names, strict=True)}


def _so_far(rows: Sequence[Row]) -> str:
    """Return in words which contender is right most often so far, over the worlds that it takes."""
    shares: dict[str, list[float]] = {}
    for row in rows:
        shares.setdefault(row.contender, []).append(row.right / row.runs)
    best, found = max(shares.items(), key=lambda pair: sum(pair[1]) / len(pair[1]))
    return f"right most often so far: {best}, {100 * sum(found) / len(found):.1f} % over {len(found)} sides"


def _contender(worlds: Sequence[World], name: str, source: str, *, trusted: bool = True) -> Contender:
    """Return what a strategy is given and takes, in the plain world."""
    plain = next(world for world in worlds if world.name == PLAIN)
    scenario = plain.scenario(SIDES[0], name, source or None, trusted=trusted)
    return Contender(
        source=source,
        given=scenario.strategy.needs(scenario.strategy.parameters),
        memory=Asked(scenario).memory_bits,
        flash=_flash(scenario),
    )


def _flash(scenario: Scenario) -> int | None:
    """Return the bytes of a robot's controller in C; None without a compiler or a translation."""
    if not PROCESSORS[PROCESSOR].found:
        return None
    try:
        return size_of(PROCESSORS[PROCESSOR], scenario.strategy, scenario.setting)[0]
    except FeasibeeError:
        return None


Design = tuple[DesignPoint, World]


def designs_of(
    worlds: Sequence[World], sources: Mapping[str, str], seed: int, *, trusted: bool = True
) -> Iterator[Design]:
    """Yield the sides that each contender can take, with the same numbers of runs for all.

    Parameters
    ----------
    worlds : sequence of World
        Those of a suite.
    sources : mapping of str to str
        Texts of strategies' files by contender, empty for built-in ones.
    seed : int
        64 bits.
    trusted : bool
        Whether the texts may be run.
    """
    places = [(world, side) for world in worlds for side in SIDES]
    for name, source in sources.items():
        for place, (world, side) in enumerate(places):
            try:
                scenario = world.scenario(side, name, source or None, trusted=trusted)
            except ScenarioError:
                continue
            values = {CONTENDER: name, "world": world.name, "side": side}
            yield DesignPoint(values, scenario, Runs.of_point(place, 1, seed).first), world


def studies_of(designs: Sequence[Design], runs: int, seed: int) -> Iterator[Study]:
    """Yield what to run, worlds with the same number of runs together."""
    for number in dict.fromkeys(world.of(runs) for _, world in designs):
        yield Study([point for point, world in designs if world.of(runs) == number], number, seed, False)


def rows_of(rounds: Rounds, designs: Sequence[Design], runs: int, seed: int) -> list[Row]:
    """Run some designs; return their rows, in their order."""
    found = [
        _row(point, record)
        for study in studies_of(designs, runs, seed)
        for point, record in zip(study.points, rounds.run(study), strict=True)
    ]
    order = {tuple(point.values.values()): place for place, (point, _) in enumerate(designs)}
    return sorted(found, key=lambda row: order[row[:3]])


def _row(point: DesignPoint, record: Record) -> Row:
    outcome = outcome_of(point.values[CONTENDER], point.scenario, record)
    counts, brier, times = outcome.found.counts, outcome.brier, declare_times(record.decision_step)
    return Row(
        **point.values,
        runs=outcome.runs,
        right=round(float(outcome.shares.sum()), 6),
        ok=counts.get("declared_ok"),
        wrong=counts.get("declared_wrong"),
        median=times.median,
        p95=times.p95,
        bits=round(float(outcome.bits.mean()), 6),
        brier=None if brier is None else round(brier.estimate, 6),
    )


def again(card: Card, trust: bool, execution: Execution | None = None) -> list[str]:
    """Simulate a card again; return what differs, a line for each row and each fact on a contender.

    Parameters
    ----------
    card : Card
        Perhaps somebody else's.
    trust : bool
        Whether texts of strategies in it may be run.
    execution : Execution, optional
        Where to compute the runs.

    Raises
    ------
    FeasibeeError
        If a text may not be run, or the card's suite isn't in this version.
    """
    sources = {name: each.source for name, each in card.contenders.items()}
    found = [_contender(card.worlds, name, source, trusted=trust) for name, source in sources.items()]
    designs = list(designs_of(card.worlds, sources, card.seed, trusted=trust))
    with rounds_of(execution, PHASE) as rounds:
        new = {row[:3]: row for row in rows_of(rounds, designs, card.runs, card.seed)}
    old = {row[:3]: row for row in card.rows}
    lines = [
        f"{', '.join(key)}: {_change(old.get(key), new.get(key))}"
        for key in dict.fromkeys([*old, *new])
        if old.get(key) != new.get(key)
    ]
    for (name, was), now in zip(card.contenders.items(), found, strict=True):
        if (was.given, was.memory) != (now.given, now.memory):
            lines.append(f"{name}: given {was.given}, {was.memory} bits, is {now.given}, {now.memory} bits")
    return lines


def _change(old: Row | None, new: Row | None) -> str:
    """Return how a row differs from the one that was simulated again, or that one of them is missing."""
    if old is None or new is None:
        return "isn't on the card" if old is None else "is nothing that the strategy can take"
    changed = ((name, was, now) for name, was, now in zip(Row._fields, old, new, strict=True) if was != now)
    return "; ".join(f"{name} was {was}, is {now}" for name, was, now in changed)
