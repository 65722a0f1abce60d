"""Read points from a CSV file with two columns, x and y, in units, and an optional header."""

from __future__ import annotations

import csv
import math
from array import array
from collections.abc import Sequence

from feasibee.errors import PROBLEMS_LIMIT, Problem, quoted
from feasibee.files import TABLE_LIMIT, UnreadableError, lines_of, read_text
from feasibee.scenario.field_types import Point


def read_points(path: str, field: str) -> tuple[tuple[Point, ...], Sequence[int], list[Problem]]:
    """Read a CSV file of points; return the points, the line of each, and the problems.

    Parameters
    ----------
    path : str
        The CSV file.
    field : str
        The path of the scenario's field that names the file, for the problems.
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
            problems.append(
                Problem(
                    field, path, f"{rule}, not {quoted(','.join(row))}", "write two numbers, such as 1.5,2.0"
                )
            )
            if len(problems) >= PROBLEMS_LIMIT:
                break
    except csv.Error as error:
        problems.append(Problem(field, path, f"isn't a CSV file: {error}", "name a CSV file of x and y"))
    return tuple(points), lines, problems


def _point(cells: list[str]) -> Point | None:
    """Return the cells as two finite numbers; None if they aren't."""
    try:
        x, y = (float(cell) for cell in cells)
    except ValueError:
        return None
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None
