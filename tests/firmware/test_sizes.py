"""The table of sizes on docs/targets.md is that of the compilers here."""

from __future__ import annotations

import re
import sys

import pytest

from benchmarks import sizes
from tests.firmware import boards

PAGE = boards.SOURCES.parents[2] / "docs" / "targets.md"
COLUMNS = [
    *("ATmega328P flash", "ATmega328P RAM", "Cortex-M0 flash", "Cortex-M0 RAM"),
    *("Cortex-M4 flash", "x86-64 flash", "wasm32 flash"),
]


def table():
    """Return the numbers of each strategy on the page, by column."""
    rows = re.findall(r"^\| `([\w-]+)` \| ([\d,]+ \|.*)\|$", PAGE.read_text(), re.MULTILINE)
    return {
        name: dict(zip(COLUMNS, [int(cell.replace(",", "")) for cell in cells.split("|")], strict=True))
        for name, cells in rows
    }


def assert_on_the_page(strategy, processor):
    """Compilers of another version may differ a little."""
    measured = sizes.row(strategy, [processor])
    stated = {column: number for column, number in table()[strategy].items() if column in measured}
    assert stated
    assert {name: measured[name] for name in stated} == pytest.approx(stated, rel=0.03)


def test_the_table_has_all_strategies_that_pass_on_opinions():
    assert list(table()) == sizes.opinion_strategies()


def test_the_size_of_dmmd_on_an_atmega328p_is_on_the_page():
    processor = sizes.PROCESSORS["ATmega328P"]
    boards.needs(processor.compiler[0], processor.packages)
    assert_on_the_page("dmmd", "ATmega328P")


@pytest.mark.slow
@pytest.mark.parametrize("processor", sizes.PROCESSORS)
@pytest.mark.parametrize("strategy", ["dmmd", "dc", "bayes", "average"])
def test_the_sizes_are_on_the_page(strategy, processor):
    if processor not in sizes.available():
        pytest.skip(f"no compiler for {processor}; it is in {sizes.PROCESSORS[processor].packages}")
    assert_on_the_page(strategy, processor)


def test_a_failing_compiler_is_reported_with_its_command():
    with pytest.raises(SystemExit, match=r"(?s)sizes_of_nothing.*ended with status"):
        sizes.output(sys.executable, "-c", "raise SystemExit('sizes_of_nothing')")
