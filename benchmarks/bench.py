"""Measure feasibee's speed, growth, start-up and memory, and print one table.

All times are CPU times on one thread, of code that is loaded and compiled, unless a table's title says
otherwise.

Examples
--------
::

    python benchmarks/bench.py
    python benchmarks/bench.py --quick --json figures.json
    python benchmarks/bench.py --only threads
    python benchmarks/bench.py --save
    python benchmarks/bench.py --against ../other/src
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import against
import history
from cases import CASES, QUICK, Plan
from measure import Row, machine

EPILOG = "example:\n  python benchmarks/bench.py --quick --json figures.json"


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure all cases, and print each as soon as it is measured."""
    options = parse(arguments)
    plan = QUICK if options.quick else Plan()
    if options.against:
        against.print_ratios(options.against, plan)
        return
    described = machine()
    print_machine(described, plan)
    figures = {}
    for title, case in CASES.items():
        if not title.lower().startswith(options.only.lower()):
            continue
        print(f"\n{title}")
        figures[title] = case(plan)
        for row in figures[title]:
            print(line(row), flush=True)
    tables = as_tables(described, figures)
    if not (options.only or options.quick):
        compare(tables)
    if options.json:
        options.json.write_text(json.dumps(tables, indent=2) + "\n", encoding="utf-8")
    if options.save:
        print(f"\nsaved as {history.save(tables)}")


def compare(tables: dict[str, object]) -> None:
    """Print which figures differ from those of the latest release."""
    path = history.latest()
    if path is None:
        return
    print(f"\nAgainst {path.stem}, times in units of the {history.YARDSTICK}; above 1 is slower or larger")
    every = list(history.changes(tables, history.read(path)))
    for each in every:
        if abs(each.ratio - 1) > history.NOTABLE:
            print(f"  {each.ratio:6.2f}  {each.name} ({each.title.partition(':')[0]})")
    same = sum(abs(each.ratio - 1) <= history.NOTABLE for each in every)
    print(f"  {same} of {len(every)} figures within {history.NOTABLE:.0%}")


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description="Measure feasibee's speed, growth, start-up and memory, and print one table.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--quick", action="store_true", help="use fewer sizes and repeats: less than a minute"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the figures to FILE")
    parser.add_argument(
        "--only", default="", metavar="TITLE", help="measure only the tables whose title begins so"
    )
    parser.add_argument(
        "--save", action="store_true", help="keep the figures in benchmarks/history/, by version"
    )
    parser.add_argument(
        "--against",
        type=Path,
        metavar="SRC",
        help="only compare with another version: the src folder of its working tree",
    )
    options = parser.parse_args(arguments)
    if options.save and (options.only or options.quick):
        parser.error("--save keeps all figures: leave out --quick and --only")
    return options


def print_machine(described: dict[str, str], plan: Plan) -> None:
    """Print the machine, the versions, and the header of the table."""
    for name, value in described.items():
        print(f"{name:10} {value}")
    print(f"\nCPU time, warm, one thread; best and median of at most {plan.repeats}, measured in turn.")
    print("Ratios: median of those of neighbours in time, with quartiles.\n")
    print(f"  {'':42} {'best':>10} {'median':>10}  {'unit':15} {'robot-steps/s':>13}  ratio")


def line(row: Row) -> str:
    """Return a row as a line of the table."""
    rate = f"{row.robot_steps_per_second:,.0f}" if row.robot_steps_per_second else ""
    ratio = f"{row.ratio:,.2f} ({row.low:,.2f} to {row.high:,.2f}) x {row.ratio_to}" if row.ratio else ""
    goal = f"  target {row.goal}, {'met' if row.meets else 'missed'}" if row.goal else ""
    figures = f"{row.best:>10,.2f} {row.median:>10,.2f}  {row.unit:15} {rate:>13}"
    return f"  {row.name:42} {figures}  {ratio}{goal}".rstrip()


def as_tables(described: dict[str, str], figures: dict[str, list[Row]]) -> dict[str, object]:
    """Return all figures as plain tables."""
    cases = {
        title: [
            {**asdict(row), "robot_steps_per_second": row.robot_steps_per_second, "meets": row.meets}
            for row in rows
        ]
        for title, rows in figures.items()
    }
    return {"machine": described, "cases": cases}


if __name__ == "__main__":
    main()
