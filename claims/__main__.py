"""`make claims`: compute the numbers of the documentation again, and correct those that differ."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence

from claims.book import Page, read, read_all
from claims.commands import outcome
from claims.compare import Finding, examine, line_of, mended
from claims.cover import uncovered, unused

EPILOG = "examples:\n  python -m claims paper\n  python -m claims --check --short"


def main(arguments: Sequence[str] | None = None) -> int:
    """Check or correct the pages, and return the exit status: 1 if a difference is left."""
    options = parse(arguments)
    pages = [read(name) for name in options.pages] or read_all()
    wrong = 0
    for page in pages:
        text = page.path.read_text(encoding="utf-8")
        outcomes = {name: outcome(page, name) for name in (page.quick if options.short else page.commands)}
        findings = list(examine(text, page, outcomes))
        complaints = list(unaccounted(text, page))
        for line in [*(told(page, text, each) for each in findings), *complaints]:
            print(line)
        wrong += len(complaints) + sum(options.check or not each.mends for each in findings)
        if not options.check:
            page.path.write_text(mended(text, findings), encoding="utf-8")
    claims = sum(len(page.claims) + len(page.tables) for page in pages)
    print(f"{claims} claims on {len(pages)} pages: {wrong or 'nothing'} to correct", file=sys.stderr)
    return 1 if wrong else 0


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m claims",
        description="Compute the numbers of the documentation again, and correct those that differ.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("pages", nargs="*", metavar="PAGE", help="such as paper; by default all")
    parser.add_argument("--check", action="store_true", help="report differences, change nothing")
    parser.add_argument(
        "--short",
        action="store_true",
        help="run quick commands only; check that the sentences of all other claims are on their page",
    )
    return parser.parse_args(arguments)


def told(page: Page, text: str, each: Finding) -> str:
    """Return a finding as text."""
    place = f"{page.path.name}:{line_of(text, each.start)}"
    if not each.mends:
        return f"{place}: {each.measured}: {each.about}"
    if "|" not in each.stated:
        return f"{place}: states {each.stated}, measured {each.measured}: {each.about}"
    rows = zip(each.stated.splitlines(), each.measured.splitlines(), strict=False)
    lines = [f"  - {old}\n  + {new}" for old, new in rows if old != new]
    return "\n".join([f"{place}: table {each.about}", *lines])


def unaccounted(text: str, page: Page) -> Iterator[str]:
    """Yield a line for each number that no claim covers, and for each given phrase that isn't on the page."""
    for each in uncovered(text, page):
        place = f"{page.path.name}:{line_of(text, each.start())}"
        around = " ".join(text[max(0, each.start() - 40) : each.end() + 40].split())
        yield f"{place}: {each[0]}: covered by no claim, and not given: {around}"
    for phrase in unused(text, page):
        yield f"{page.path.name}: given, but not on the page: {phrase}"


if __name__ == "__main__":
    sys.exit(main())
