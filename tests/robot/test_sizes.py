"""The table of sizes on docs/firmware.md is that of the compilers here."""

from __future__ import annotations

import re
import sys

import pytest

from benchmarks import sizes
from feasibee import FeasibeeError
from feasibee.robot.sizes import output
from tests.robot import boards
from tests.robot.driving import needs

PAGE = boards.SOURCES.parents[2] / "docs" / "firmware.md"
COLUMNS = [
    *("ATmega328P flash", "ATmega328P RAM", "Cortex-M0 flash", "Cortex-M0 RAM"),
    *("Cortex-M4 flash", "x86-64 flash", "wasm32 flash"),
]


HEADERS = {"opinions": "| strategy |", "frames": "| frames of |", "knowledge": "| strategy with knowledge |"}
"""Where each table begins."""


def table(name):
    """Return the numbers of each strategy in a table of the page, by column."""
    text = PAGE.read_text()
    lines = text[text.index(f"\n{HEADERS[name]}") :].split("\n\n")[0]
    rows = re.findall(r"^\| `([\w-]+)` \| ([\d,]+ \|.*)\|$", lines, re.MULTILINE)
    return {
        strategy: dict(zip(COLUMNS, [int(cell.replace(",", "")) for cell in cells.split("|")], strict=True))
        for strategy, cells in rows
    }


def assert_on_the_page(name, strategy, processor):
    """Compilers of another version may differ a little."""
    measured = sizes.row(name, strategy, [processor])
    stated = {column: number for column, number in table(name)[strategy].items() if column in measured}
    assert stated
    assert {column: measured[column] for column in stated} == pytest.approx(stated, rel=0.03)


@pytest.mark.parametrize("name", sizes.TABLES)
def test_the_tables_have_all_their_strategies(name):
    assert list(table(name)) == list(sizes.TABLES[name][0])


@pytest.mark.parametrize(
    ("name", "strategy"), [("opinions", "dmmd"), ("frames", "dmmd"), ("knowledge", "tally")]
)
def test_sizes_on_an_atmega328p_are_on_the_page(name, strategy):
    processor = sizes.PROCESSORS["ATmega328P"]
    needs(processor.compiler[0], processor.packages)
    assert_on_the_page(name, strategy, "ATmega328P")


@pytest.mark.slow
@pytest.mark.parametrize("processor", sizes.PROCESSORS)
@pytest.mark.parametrize("name", sizes.TABLES)
def test_the_sizes_are_on_the_page(name, processor):
    if not sizes.PROCESSORS[processor].found:
        pytest.skip(f"no compiler for {processor}; it is in {sizes.PROCESSORS[processor].packages}")
    for strategy in sizes.TABLES[name][0]:
        assert_on_the_page(name, strategy, processor)


def test_a_failing_compiler_is_reported_with_its_command():
    with pytest.raises(FeasibeeError, match=r"python.*: ended with status 1: sizes_of_nothing"):
        output(sys.executable, "-c", "raise SystemExit('sizes_of_nothing')")
