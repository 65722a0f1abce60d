"""The benchmark: frozen worlds, each contender in each of them, its card, and the board that ranks them.

A suite has worlds, each with a side whose tasks are feasible and one whose are not. A card is a file with the
texts of its strategies, its seed and what was counted, so that anyone can simulate it again and compare each
number.
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Collection, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Final, Literal, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from feasibee.base.codes import MODEL_VERSION
from feasibee.base.errors import FeasibeeError, ScenarioError, one_line
from feasibee.base.files import read_text, write_text
from feasibee.base.record import Record
from feasibee.results.statistics import (
    CONFIDENCE,
    OF_THE_RUNS,
    Interval,
    declare_times,
    in_percent,
    normal_quantile,
)
from feasibee.robot.sizes import PROCESSORS, size_of
from feasibee.scenario.plugins import manifest_of
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.plan import DesignPoint, Study
from feasibee.simulation.schedule import run_work
from feasibee.simulation.sweep import Execution, Rounds
from feasibee.strategies import STRATEGIES
from feasibee.studies.comparison import CONTENDER, check_distinct, looks_at, outcome_of, percent, rounds_of
from feasibee.studies.needs import IN_WORDS, NAMES, Asked

LATEST: Final = "1"
"""The version of the suite that is run."""
SIDES: Final = ("feasible", "infeasible")
Side = Literal["feasible", "infeasible"]


class SuiteWorld(NamedTuple):
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

        ``source`` is the text to take for a strategy's file, by default that in it; ``trusted`` is whether it
        may be run.

        Raise a ScenarioError if the strategy can't take the world.
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
    def worlds(self) -> tuple[SuiteWorld, ...]:
        """Its worlds, in their order."""
        return tuple(_world(**each) for each in tomllib.loads(self.text)["world"])


FOLDER: Final = files("feasibee.studies") / "suites"


def _world(sides: list[Any], set: Mapping[str, Any] | None = None, **about: Any) -> SuiteWorld:  # noqa: A002
    one, other = (merged(set or {}, each) for each in sides)
    return SuiteWorld(**about, sides=(one, other))


def merged(one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a scenario with those of another laid over them."""
    return {
        **one,
        **{
            name: {**one.get(name, {}), **table} if isinstance(table, Mapping) else table
            for name, table in other.items()
        },
    }


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

        Raise a FeasibeeError if it can't be read, or isn't a card.
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
    def worlds(self) -> tuple[SuiteWorld, ...]:
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

    Strategies are names or paths of files, by default all built-in ones; large swarms take a stated share of
    the ``runs``. If the seed is drawn anew, nobody can fit a strategy to it. If the execution ends the study
    early, there are fewer runs.

    Raise a FeasibeeError if a strategy is unknown, no strategy, or named twice, or can't take the plain
    world.
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


def _contender(worlds: Sequence[SuiteWorld], name: str, source: str, *, trusted: bool = True) -> Contender:
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


Design = tuple[DesignPoint, SuiteWorld]


def designs_of(
    worlds: Sequence[SuiteWorld], sources: Mapping[str, str], seed: int, *, trusted: bool = True
) -> Iterator[Design]:
    """Yield the sides that each contender can take, with the same numbers of runs for all.

    ``sources`` has the texts of strategies' files by contender, empty for built-in ones, and ``trusted`` is
    whether these may be run.
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

    Raise a FeasibeeError if a text of a strategy may not be run, or the card's suite isn't in this version.
    ``trust`` is whether texts may be run.
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


COIN: Final = 0.5
"""What counts as right in a world that a strategy can't take: that of a coin."""
HEADS: Final = ("right", "interval", "word", "wrong", "half", "95 %", "bits", "Brier", "memory", "C")
CAPTION: Final = (
    "right: swarms that are right at the end (%), with the 95 % interval, over all worlds, each of which "
    "counts alike; one that a strategy can't take counts as a coin. word: swarms that declared rightly "
    "(%); wrong: those with a robot that did wrongly (%). half, 95 %: steps by which so many swarms "
    "had decided, medians over the worlds. bits: per robot-step"
)
COSTS: Final = (
    "memory: bits of a robot. C: bytes of its controller. could be known: swarms that an observer without "
    "names could put right who hears of all sightings (%)"
)
IN_A_TERMINAL: Final = 7
"""Number of columns that a terminal has room for."""


class Standing(NamedTuple):
    """How a contender did over all worlds; each world counts alike, and so does each side."""

    contender: str
    given: str
    """What its robots are given, in words: the class in which it ranks."""
    right: Interval
    """Share of right runs; a world that it can't take counts as a coin."""
    word: float | None
    """Share of the runs in which robots declared rightly, of all worlds; None if they never declare."""
    wrong: float | None
    """Share of the runs in which a robot declared wrongly."""
    median: int | None
    p95: int | None
    """Medians over the sides of the steps by which half and 95 % of the swarms had decided; None: never."""
    bits: float
    """Mean bits per robot-step, over the worlds that it takes."""
    brier: float
    """Mean Brier score, over those of them that don't change."""
    memory: int
    """Bits that a robot remembers."""
    flash: int | None
    """Bytes of its controller in C."""
    worlds: Mapping[str, float | None]
    """Share of right runs by world; None: it can't take the world."""

    @property
    def cells(self) -> list[str]:
        """The cells of its row, under `HEADS`."""
        words = ["" if share is None else f"{100 * share:.1f}" for share in (self.word, self.wrong)]
        steps = ["never" if step is None else f"{step:,}" for step in (self.median, self.p95)]
        flash = "" if self.flash is None else f"{self.flash:,}"
        costs = [f"{self.bits:,.3g}", f"{self.brier:.3f}", f"{self.memory:,}", flash]
        middle, low, high = (100 * each for each in self.right)
        return [f"{middle:.1f}", f"{low:.1f} to {high:.1f}", *words, *steps, *costs]


def standings(card: Card) -> dict[str, list[Standing]]:
    """Return how all contenders did, by class; within it, and among classes, the best first."""
    found = sorted((_standing(card, name) for name in card.contenders), key=lambda each: -each.right.estimate)
    classes: dict[str, list[Standing]] = {}
    for each in found:
        classes.setdefault(each.given, []).append(each)
    return classes


def _standing(card: Card, name: str) -> Standing:
    rows, about = [row for row in card.rows if row.contender == name], card.contenders[name]
    sides = len(SIDES) * len(card.worlds)
    word, wrong = (
        _share_of_all([getattr(row, each) for row in rows], rows, sides) for each in ("ok", "wrong")
    )
    shares = {
        world.name: [row.right / row.runs for row in rows if row.world == world.name] for world in card.worlds
    }
    return Standing(
        contender=name,
        given=" and ".join(IN_WORDS[each] for each in about.given) or "nothing",
        right=_right(rows, sides),
        word=word,
        wrong=wrong,
        median=_middle([row.median for row in rows]),
        p95=_middle([row.p95 for row in rows]),
        bits=float(np.mean([row.bits for row in rows])),
        brier=float(np.mean([row.brier for row in rows if row.brier is not None])),
        memory=about.memory,
        flash=about.flash,
        worlds={world: float(np.mean(found)) if found else None for world, found in shares.items()},
    )


def _share_of_all(counts: Sequence[int | None], rows: Sequence[Row], sides: int) -> float | None:
    """Return the mean share over all sides, 0 in those without; None if no row has a count."""
    found = [count / row.runs for count, row in zip(counts, rows, strict=True) if count is not None]
    return sum(found) / sides if found else None


def _middle(steps: Sequence[int | None]) -> int | None:
    """Return the median of steps of which some are never."""
    middle = float(np.median([math.inf if step is None else step for step in steps]))
    return round(middle) if math.isfinite(middle) else None


def _right(rows: Sequence[Row], sides: int) -> Interval:
    """Return the mean share of right runs over all sides.

    Its interval is at least as wide as it should be: a share of steps varies no more than a rate of its mean,
    and one more run of either kind keeps rates from 0 and 1.
    """
    middle = (sum(row.right / row.runs for row in rows) + COIN * (sides - len(rows))) / sides
    rates = [((row.right + 1) / (row.runs + 2), row.runs) for row in rows]
    half = normal_quantile(CONFIDENCE) * math.sqrt(sum(p * (1 - p) / n for p, n in rates)) / sides
    return Interval(middle, max(0.0, middle - half), min(1.0, middle + half))


def gaps(group: Sequence[Standing], name: str) -> list[tuple[str, float, str, float]]:
    """Return the worlds in which a contender of a class is behind the best one, the widest gap first.

    Each has the contender's share of right runs, the best one, and that one's share.
    """
    own = next(each for each in group if each.contender == name)
    found = []
    for world, share in own.worlds.items():
        best = max(group, key=lambda each: each.worlds[world] or 0.0)
        theirs = best.worlds[world] or 0.0
        if share is not None and theirs > share:
            found.append((world, share, best.contender, theirs))
    return sorted(found, key=lambda gap: gap[1] - gap[3])


def in_words(classes: Mapping[str, Sequence[Standing]], names: Container[str]) -> Iterator[str]:
    """Yield how some contenders rank; without any, how the best of each class do."""
    for given, group in classes.items():
        for place, each in enumerate(group, start=1):
            if each.contender in names or (not names and place == 1):
                taken = sum(share is not None for share in each.worlds.values())
                rank = f"is number {place} of {len(group)} that are given {given}"
                worlds = f"It takes {taken} of {len(each.worlds)} worlds."
                yield f"{each.contender} {rank}: right in {in_percent(each.right, OF_THE_RUNS)}. {worlds}"


def behind(classes: Mapping[str, Sequence[Standing]], names: Container[str]) -> Iterator[str]:
    """Yield in which worlds some contenders are furthest behind."""
    for group in classes.values():
        for each in group:
            if each.contender in names and (found := gaps(group, each.contender)[:3]):
                worlds = [
                    f"{world} ({100 * right:.0f} %, {best} {100 * theirs:.0f} %)"
                    for world, right, best, theirs in found
                ]
                yield f"{each.contender} is furthest behind in {', '.join(worlds)}."


def write_board(path: Path, card: Card, names: Collection[str], command: str) -> None:
    """Write the board as one HTML file: by class a table, the Pareto front, and shares by world.

    Contenders that are ``names`` come first, with their classes; the ``command`` stands in the footer.
    """
    from feasibee.studies.files import write_page  # loads matplotlib

    classes = standings(card)
    foremost = sorted(classes.values(), key=lambda group: not any(each.contender in names for each in group))
    write_page(
        path,
        "board.html",
        command,
        card=card,
        brief=[*in_words(classes, names), *behind(classes, names)],
        classes={f"Given {group[0].given}": _class_of(card, group, names) for group in foremost},
        caption=f"{CAPTION}. {COSTS}",
        worlds=[f"{world.name} ({world.group}): {world.about}." for world in card.worlds],
    )


def _class_of(card: Card, group: Sequence[Standing], names: Container[str]) -> tuple[Any, ...]:
    """Return a class as a table, the Pareto front if several are in it, and the shares by world."""
    from feasibee.figures.comparison import draw_against_bits
    from feasibee.studies.files import encoded

    figure = None
    if len(group) > 1:
        totals = {each.contender: (each.bits, each.right) for each in group}
        keep = [name for name in totals if name in names] or None
        drawn = draw_against_bits(totals, "right at the end, over all worlds (%)", keep=keep)
        best = f"Best: {group[0].contender}, {percent(group[0].right)}."
        figure = f"Given {group[0].given}: right swarms against bits on the air", best, encoded(drawn)
    columns = {each.contender: each.worlds for each in group}
    if NAMES not in group[0].given:
        columns = {"could be known": {world.name: world.known for world in card.worlds}, **columns}
    shares = [[world.name, *(column[world.name] for column in columns.values())] for world in card.worlds]
    ranks = [[each.contender, *each.cells] for each in group]
    return [["", *HEADS], *ranks], figure, [["", *columns], *shares]
