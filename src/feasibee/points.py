"""Points from a CSV file: two columns, x and y, in units; a header is allowed."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from feasibee.errors import Problem
from feasibee.sections import Point


def read_points(path: str, field: str) -> tuple[tuple[Point, ...], list[str], list[Problem]]:
    """Read a file of points; return them, where each stands, and what is wrong, by line.

    Parameters
    ----------
    path : str
        The file.
    field : str
        The scenario's field that names it, for the problems.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        return (), [], [Problem(field, path, f"can't be read: {why}", "name a CSV file of x and y")]
    points: list[Point] = []
    places: list[str] = []
    problems: list[Problem] = []
    for line, row in enumerate(csv.reader(text.splitlines()), start=1):
        cells = [cell.strip() for cell in row]
        if not any(cells) or (line == 1 and cells[:2] == ["x", "y"]):
            continue
        try:
            x, y = (float(cell) for cell in cells)
        except ValueError:
            x = y = math.nan
        if math.isfinite(x) and math.isfinite(y):
            points.append((x, y))
            places.append(f"{path}, line {line}")
        else:
            rule = f"line {line} must be two numbers, x and y"
            problems.append(Problem(field, path, f"{rule}, not {','.join(row)!r}", "mend the line"))
    return tuple(points), places, problems
