"""Cells that polygons cover (model.md 6.20.1), exactly: a coordinate is the decimal that a user wrote."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.model.codes import exact
from feasibee.scenario.bitmaps import Cells

Number = float | Fraction
Ring = Sequence[tuple[Number, Number]]
"""Corners of a closed line."""
Integers = NDArray[Any]
"""int64, or Python's integers where these are too short."""
_CHUNK = 256
"""Edges at a time, which bounds the memory of their pieces: up to a cell per row and column each."""


class _Edges(NamedTuple):
    """Edges of a polygon, each from its lower end (x, y) to (x + dx, y + dy), with dy ≥ 0."""

    x: Integers
    y: Integers
    dx: Integers
    dy: Integers
    cell: int
    """Side of a cell in the unit of these numbers, which is even."""
    thin: Integers
    """Whether an edge is one of a ring without area."""

    def of(self, which: Any) -> _Edges:
        """Return some of the edges."""
        x, y, dx, dy = (each[which] for each in (self.x, self.y, self.dx, self.dy))
        return _Edges(x, y, dx, dy, self.cell, self.thin[which])


def touched(polygons: Iterable[Sequence[Ring]], cell: Fraction, shape: tuple[int, int]) -> Cells:
    """Return which cells polygons, each of one or more rings, cover in part (model.md 6.20.1).

    Parameters
    ----------
    polygons : iterable of sequences of rings
        Points [x, y] of each ring. Points in an odd number of rings of a polygon are inside.
    cell : Fraction
        Side of a cell, in the unit of the points.
    shape : tuple of int
        Number of rows and of columns.
    """
    cells = np.zeros(shape, bool)
    for polygon in polygons:
        edges = _edges(polygon, cell)
        if edges:
            _fill(cells, edges)
            _draw(cells, edges)
    return cells


def centred(polygons: Iterable[Sequence[Ring]], cell: Fraction, shape: tuple[int, int]) -> Cells:
    """Return the cells whose centres are in a polygon; parameters are those of `touched`."""
    cells = np.zeros(shape, bool)
    for polygon in polygons:
        edges = _edges(polygon, cell)
        if edges:
            _fill(cells, edges)
    return cells


def _edges(rings: Sequence[Ring], cell: Fraction) -> _Edges | None:
    """Return the edges of a polygon that have a length; None if it has none."""
    scaled = [[(_exact(x) / cell, _exact(y) / cell) for x, y in ring] for ring in rings]
    unit = 2 * math.lcm(*(each.denominator for ring in scaled for point in ring for each in point))
    rows = list[tuple[int, int, int, int, bool]]()
    for ring in scaled:
        points = [
            (x.numerator * (unit // x.denominator), y.numerator * (unit // y.denominator)) for x, y in ring
        ]
        ends = list(zip(points, [*points[1:], points[0]], strict=True))
        is_thin = not sum(ax * by - bx * ay for (ax, ay), (bx, by) in ends)
        for one, other in ends:
            if one != other:
                (ax, ay), (bx, by) = sorted((one, other), key=lambda point: point[1])
                rows.append((ax, ay, bx - ax, by - ay, is_thin))
    if not rows:
        return None
    fits = max(unit, *(abs(each) for row in rows for each in row)) < 2**29  # the largest product, below 2**63
    x, y, dx, dy, thin = np.array(rows, np.int64 if fits else object).T
    return _Edges(x, y, dx, dy, unit, thin.astype(bool))


def _exact(value: Number) -> Fraction:
    return value if isinstance(value, Fraction) else exact(value)


def _up(value: Any, unit: Any) -> Any:
    """Return a quotient, rounded up."""
    return -(-value // unit)


def _within(value: Any, most: int) -> Any:
    """Return whole numbers from 0 to ``most``."""
    return np.minimum(np.maximum(value, 0), most).astype(np.int64)


def spread(first: Any, last: Any) -> tuple[Any, Any]:
    """Return each whole number of some ranges, and the index of its range."""
    lengths = np.maximum(last - first, 0)
    index = np.repeat(np.arange(len(lengths)), lengths)
    starts = np.cumsum(lengths) - lengths
    return np.arange(len(index)) - (starts - first)[index], index


def _pieces(edges: _Edges, first: Any, last: Any) -> Iterator[tuple[Any, _Edges]]:
    """Yield a row and an edge for each row from ``first`` to below ``last`` of each edge."""
    for start in range(0, len(first), _CHUNK):
        some = slice(start, start + _CHUNK)
        rows, index = spread(first[some], last[some])
        yield rows, edges.of(some).of(index)


def _fill(cells: Cells, edges: _Edges) -> None:
    """Close the cells whose centres are inside: those with an odd number of edges to the right."""
    height, width = cells.shape
    x, y, dx, dy, cell, _ = edges
    first, last = (_within(_up(each - cell // 2, cell), height) for each in (y, y + dy))
    low, high = first.min(), last.max()
    left, right = np.minimum(x, x + dx).min() // cell, _up(np.maximum(x, x + dx).max(), cell)
    left, right = (min(max(int(each), 0), width) for each in (left, right))
    odd = np.zeros((max(high - low, 0), right - left + 1), bool)
    for rows, (x, y, dx, dy, *_) in _pieces(edges, first, last):
        middle = rows.astype(x.dtype) * cell + cell // 2
        columns = _within(_up(x * dy + (middle - y) * dx - cell // 2 * dy, cell * dy), width)
        np.logical_xor.at(odd, (rows - low, columns - left), True)
    inside = np.logical_xor.accumulate(odd[:, :0:-1], axis=1)[:, ::-1]
    cells[low:high, left:right] |= inside


def _draw(cells: Cells, edges: _Edges) -> None:
    """Close the cells through which an edge runs, and those along which a ring without area runs."""
    height, cell, slanted = len(cells), edges.cell, edges.of(edges.dy > 0)
    first, last = slanted.y // cell, _up(slanted.y + slanted.dy, cell)
    for rows, (x, y, dx, dy, _, thin) in _pieces(slanted, _within(first, height), _within(last, height)):
        below = rows.astype(x.dtype) * cell
        heights = np.maximum(y, below), np.minimum(y + dy, below + cell)
        ends = [x * dy + (each - y) * dx for each in heights]
        low, high = np.minimum(*ends) // (cell * dy), _up(np.maximum(*ends), cell * dy)
        along = thin & (low == high)
        _close(cells, rows, low - along, high + along)
    flat = edges.of(edges.dy == 0)
    for rows, (x, _, dx, *_) in _pieces(flat, *(_within(each, height) for each in _flat_rows(flat))):
        _close(cells, rows, np.minimum(x, x + dx) // cell, _up(np.maximum(x, x + dx), cell))


def _flat_rows(flat: _Edges) -> tuple[Any, Any]:
    """Return the first row of each level edge, and the row after its last."""
    row, on_border = flat.y // flat.cell, flat.y % flat.cell == 0
    return row - (on_border & flat.thin), row + (~on_border.astype(bool) | flat.thin)


def _close(cells: Cells, rows: Any, low: Any, high: Any) -> None:
    """Close the cells of each row from column ``low`` to below ``high``."""
    width = cells.shape[1]
    columns, index = spread(_within(low, width), _within(high, width))
    cells[rows[index], columns] = True
