"""Compare the claims of a page with the output of its commands, and write the measured values."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from textwrap import shorten
from typing import Any

from claims.book import Claim, Page, Rows
from claims.template import evaluate


@dataclass(frozen=True)
class Finding:
    """A difference between a page and the measured values.

    Parameters
    ----------
    start, end : int
        Position in the text of the page; both 0 if it isn't found.
    stated, measured : str
        The text of the page, and the measured one.
    about : str
        The words around it, or the error.
    mends : bool
        Whether ``measured`` can replace ``stated`` on the page.
    """

    start: int
    end: int
    stated: str
    measured: str
    about: str
    mends: bool = True


def examine(text: str, page: Page, outcomes: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield the differences of a page; for claims without an outcome, only that their text is missing."""
    for claim in page.claims:
        yield from _examine_claim(text, claim, outcomes if page.needs(claim) <= set(outcomes) else None)
    for table in page.tables:
        yield from _examine_table(text, table, outcomes if page.needs(table) <= set(outcomes) else None)


def mended(text: str, findings: list[Finding]) -> str:
    """Return the page with all values that can be corrected."""
    for each in sorted({each for each in findings if each.mends}, key=lambda each: each.start, reverse=True):
        text = text[: each.start] + each.measured + text[each.end :]
    return text


def line_of(text: str, place: int) -> int:
    """Return the number of the line of a position."""
    return text.count("\n", 0, place) + 1


def find_claim(text: str, claim: Claim) -> re.Match[str] | str:
    """Return the match of a claim on a page, or the error."""
    found = list(claim.template.pattern().finditer(text))
    if len(found) == 1:
        return found[0]
    return "is on the page twice; use a longer text" if found else "isn't on the page"


def find_table(text: str, table: Rows) -> tuple[int, int] | str:
    """Return the start and end of a table's rows, or the error."""
    starts = [each.start() for each in re.finditer(rf"^{re.escape(table.header)}", text, re.MULTILINE)]
    if len(starts) != 1:
        return "two tables have this header" if starts else "no table has this header"
    body = re.compile(r"[^\n]*\n\|[-|: ]+\n((?:\|[^\n]*\n)*)").match(text, starts[0])
    return body.span(1) if body else "the table has no rows"


def _examine_claim(text: str, claim: Claim, outcomes: Mapping[str, Any] | None) -> Iterator[Finding]:
    found = find_claim(text, claim)
    if isinstance(found, str):
        yield Finding(0, 0, "", found, _brief(claim.template.text), mends=False)
        return
    if outcomes is None:
        return
    about = _brief(found[0])
    if claim.holds and not evaluate(claim.holds, outcomes):
        yield Finding(*found.span(), "its words", f"not true: {claim.holds}", about, mends=False)
    stated = found.groups()
    measured = [slot.measured(outcomes) for slot in claim.template.slots]
    if all(slot.agrees(*pair) for slot, *pair in zip(claim.template.slots, stated, measured, strict=True)):
        return
    for place, (old, new) in enumerate(zip(stated, measured, strict=True), start=1):
        if old.split() != new.split():
            yield Finding(*found.span(place), old, _spaced_as(old, new), about)


def _examine_table(text: str, table: Rows, outcomes: Mapping[str, Any] | None) -> Iterator[Finding]:
    found = find_table(text, table)
    if isinstance(found, str):
        yield Finding(0, 0, "", found, table.header, mends=False)
        return
    start, end = found
    if outcomes is None:
        pattern = table.row.pattern(".+?")
        for line in text[start:end].splitlines():
            if not pattern.fullmatch(line):
                yield Finding(start, end, line, f"like {table.row.text}", table.header, mends=False)
        return
    lines = "".join(each + "\n" for each in rows_of(table, outcomes))
    if lines != text[start:end]:
        yield Finding(start, end, text[start:end], lines, table.header)


def _brief(text: str) -> str:
    return shorten(text, 100, placeholder=" …")


def _spaced_as(old: str, new: str) -> str:
    """Return a text with the line breaks of another text with as many words."""
    gaps = re.findall(r"\s+", old)
    words = new.split()
    if len(gaps) != len(words) - 1:
        return new
    return words[0] + "".join(gap + word for gap, word in zip(gaps, words[1:], strict=True))


def rows_of(table: Rows, outcomes: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a table."""
    names = [name.strip() for name in table.each.split(",")]
    for values in evaluate(table.of, outcomes):
        row = dict(zip(names, values if len(names) > 1 else [values], strict=True))
        yield table.row.filled({**outcomes, **row})
