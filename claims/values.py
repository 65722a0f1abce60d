"""Outputs of commands as records and tables, and the format of numbers on pages."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Iterable
from decimal import ROUND_HALF_UP, Decimal
from typing import Any

MINUS = "\N{MINUS SIGN}"
SPEC = re.compile(r"(\+?)(?:\.(\d+))?([fgs]?)(±\d*%?)?")
"""A format: sign, decimals (``.2f``) or digits (``.3g``), ``s`` for words, and a tolerance (``±20%``; ``±``
for a date)."""


class Record(dict[str, Any]):
    """A table of JSON, or a row of CSV; ``record.name`` is ``record["name"]``."""

    def __getattr__(self, name: str) -> Any:
        """Return the value of a key."""
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"{name}: not one of {', '.join(self)}") from None


class Table(list[Any]):
    """Rows: ``table(tasks=10)`` are those that match; ``table.name`` is a column, or a value of the only row.

    ``text`` is the printed output of the command.
    """

    text = ""

    def __call__(self, **where: Any) -> Table:
        """Return the rows that match."""
        found = Table(row for row in self if all(row[name] == value for name, value in where.items()))
        if not found:
            raise LookupError(f"no row with {where}")
        return found

    def __getattr__(self, name: str) -> Any:
        """Return a value of the only row, or the column of all rows."""
        if name.startswith("__"):
            raise AttributeError(name)
        parts = Table(getattr(row, name) for row in self)
        return parts[0] if len(parts) == 1 else parts

    def groups(self, name: str) -> dict[Any, Table]:
        """Return the rows of each value of a column."""
        return {row[name]: self(**{name: row[name]}) for row in self}


def parse_json(text: str) -> Any:
    """Return JSON as records and tables."""
    return _as_parts(json.loads(text))


def parse_csv(text: str) -> Table:
    """Return CSV as records; ``x``, ``x_low`` and ``x_high`` become one interval ``x``."""
    return Table(_with_intervals(row) for row in csv.DictReader(io.StringIO(text)))


def show(value: Any, spec: str = "") -> str:
    """Return a value as pages write it: halves rounded up, intervals as ``0.75 (0.73 to 0.77)``."""
    if value is None:
        return "never"
    if isinstance(value, Record):
        return f"{show(value.estimate, spec)} ({show(value.low, spec)} to {show(value.high, spec)})"
    if isinstance(value, list | tuple):
        return " | ".join(show(each, spec) for each in value)
    if isinstance(value, str):
        return value
    sign, places, kind, _ = SPEC.fullmatch(spec).groups()
    if isinstance(value, int) and places is None:
        return f"{value:{sign},}".replace("-", MINUS)
    if places is None:
        raise ValueError(f"{value} has no format; add one, such as {{...:.2f}}")
    digits = 0 if kind == "f" or value == 0 else math.floor(math.log10(abs(value))) + 1
    rounded = Decimal(repr(float(value))).quantize(
        Decimal(1).scaleb(min(0, digits - int(places))), ROUND_HALF_UP
    )
    return f"{rounded:{sign}z,}".replace("-", MINUS)


def number(text: str) -> float:
    """Return the number in a page's text; NaN if it isn't a number."""
    try:
        return float(text.replace(MINUS, "-").replace(",", ""))
    except ValueError:
        return math.nan


def mean(values: Iterable[float]) -> float:
    """Return the mean of values."""
    listed = list(values)
    return math.fsum(listed) / len(listed)


def median(values: Iterable[Any]) -> Any:
    """Return the median, the upper of two middle values; None (never) is larger than all numbers."""
    ordered = sorted(values, key=lambda value: math.inf if value is None else value)
    return ordered[len(ordered) // 2]


def printed(text: str, start: str, table: str) -> list[float]:
    """Return the numbers in the row of a printed table that starts with a word; ``table`` is its title."""
    lines = [line.strip() for line in text.splitlines()]
    row = next(each for each in lines[lines.index(table) :] if each.startswith(start + " "))
    return [number(each) for each in re.findall(r"[-+]?\d+(?:\.\d+)?", row[len(start) :])]


def _as_parts(value: Any) -> Any:
    if isinstance(value, dict):
        return Record((name, _as_parts(each)) for name, each in value.items())
    return Table(_as_parts(each) for each in value) if isinstance(value, list) else value


def _with_intervals(row: dict[str, str]) -> Record:
    plain = {name: _number(text) for name, text in row.items()}
    record = Record(plain)
    for name, value in plain.items():
        if f"{name}_low" in plain:
            record[name] = Record(estimate=value, low=plain[f"{name}_low"], high=plain[f"{name}_high"])
    return record


def _number(text: str) -> Any:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text or None
