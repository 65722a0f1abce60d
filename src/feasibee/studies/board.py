"""The board of the benchmark: how the contenders of a card rank among those that are given the same."""

from __future__ import annotations

import math
from collections.abc import Collection, Container, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from feasibee.figures.comparison import draw_against_bits
from feasibee.results.statistics import CONFIDENCE, OF_THE_RUNS, Interval, in_percent, normal_quantile
from feasibee.studies.benchmark import Card, Row
from feasibee.studies.comparison import percent
from feasibee.studies.files import encoded, write_page
from feasibee.studies.needs import IN_WORDS, NAMES
from feasibee.studies.suite import SIDES

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

    Parameters
    ----------
    path : Path
        The file.
    card : Card
        What to show.
    names : collection of str
        Contenders to put in front, with their classes first.
    command : str
        The command that made it, for the footer.
    """
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
