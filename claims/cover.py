"""Find the numbers of a page that neither a claim nor a given phrase covers."""

from __future__ import annotations

import re
from collections.abc import Iterator

from claims.book import Page, common
from claims.compare import find_claim, find_table
from claims.template import NUMBER

HIDDEN = re.compile(
    r"""
    ^[ ]*```.*?^[ ]*```[ ]*$    # a block of code
    | `[^`]+`                   # code in a line
    | (?<=\])\([^)\s]*\)        # the target of a link
    | <!--.*?-->                # a comment
    | ^[ ]*\d+\.(?=[ ])         # the number of an item of a list
    """,
    re.VERBOSE | re.MULTILINE | re.DOTALL,
)
WORD = re.compile(rf"(?<![\w.]){NUMBER}(?!\w)")
"""A number that isn't part of a name."""


def uncovered(text: str, page: Page) -> Iterator[re.Match[str]]:
    """Yield the numbers of a page that no claim covers and that aren't given."""
    if not page.covered:
        return
    prose = HIDDEN.sub(lambda found: re.sub(r"[^\n]", "`", found[0]), text)
    covered = _claimed(text, page)
    for part in page.given_parts:
        covered.update(_part(text, part))
    for phrase in [*common(), *page.given]:
        for found in _phrase(phrase).finditer(prose):
            covered.update(range(*found.span()))
    for found in WORD.finditer(prose):
        if not covered.issuperset(range(*found.span())):
            yield found


def unused(text: str, page: Page) -> list[str]:
    """Return the given phrases and parts that aren't on the page."""
    phrases = [phrase for phrase in page.given if not _phrase(phrase).search(text)]
    return phrases + [part for part in page.given_parts if not _part(text, part)]


def _claimed(text: str, page: Page) -> set[int]:
    """Return the positions in a page that claims cover."""
    covered: set[int] = set()
    for claim in page.claims:
        found = find_claim(text, claim)
        if not isinstance(found, str):
            covered.update(range(*found.span()))
    for table in page.tables:
        rows = find_table(text, table)
        if not isinstance(rows, str):
            covered.update(range(text.index(table.header), rows[1]))
    return covered


def _part(text: str, start: str) -> range:
    """Return the positions of the table or section with a given first line."""
    found = re.search(rf"^{re.escape(start)}", text, re.MULTILINE)
    if not found:
        return range(0)
    level = len(start) - len(start.lstrip("#"))
    last = re.compile(rf"^#{{1,{level}}} " if level else r"^(?!\|)", re.MULTILINE).search(
        text, found.end() + 1
    )
    return range(found.start(), last.start() if last else len(text))


def _phrase(phrase: str) -> re.Pattern[str]:
    """Return a pattern that finds a given phrase: ``#`` matches any number, a blank any gap."""
    parts = re.split(r"(#|\s+)", phrase)
    known = {"#": NUMBER}
    pattern = "".join(
        known.get(part, r"\s+" if part.isspace() else re.escape(part)) for part in parts if part
    )
    return re.compile(rf"(?<![\w.]){pattern}(?!\w)")
