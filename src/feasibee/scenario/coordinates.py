"""Points from a CSV file: two columns, x and y, in units; a header is allowed."""

from __future__ import annotations

import csv
import math
from array import array
from collections.abc import Sequence

from feasibee.errors import PROBLEMS_LIMIT, Problem, quoted
from feasibee.files import TABLE_LIMIT, UnreadableError, lines_of, read_text
from feasibee.scenario.fields import Point


def read_points(path: str, field: str) -> tuple[tuple[Point, ...], Sequence[int], list[Problem]]:
    """Read a file of points; return them, the line of each, and what is wrong, by line.

    Parameters
    ----------
    path : str
        The file.
    field : str
        The scenario's field that names it, for the problems.
    """
    try:
        text = read_text(path, "a CSV file of x and y", TABLE_LIMIT)
    except UnreadableError as error:
        return (), (), [Problem(field, path, f"can't be read: {error.why}", "name a CSV file of x and y")]
    points: list[Point] = []
    lines = array("L")
    problems: list[Problem] = []
    reader = csv.reader(lines_of(text), strict=True)
    try:
        for row in reader:
            line, cells = reader.line_num, [cell.strip() for cell in row]
            if not any(cells) or (line == 1 and cells[:2] == ["x", "y"]):
                continue
            point = _point(cells)
            if point is not None:
                points.append(point)
                lines.append(line)
                continue
            rule = f"line {line} must be two numbers, x and y"
            problems.append(Problem(field, path, f"{rule}, not {quoted(','.join(row))}", "mend the line"))
            if len(problems) >= PROBLEMS_LIMIT:
                break
    except csv.Error as error:
        problems.append(Problem(field, path, f"isn't CSV: {error}", "name a CSV file of x and y"))
    return tuple(points), lines, problems


def _point(cells: list[str]) -> Point | None:
    """Return two finite numbers; None if the cells aren't that."""
    try:
        x, y = (float(cell) for cell in cells)
    except ValueError:
        return None
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None
