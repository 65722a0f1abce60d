"""Cells of a place: those of images, and those that polygons cover, exactly (model.md 6.20.1)."""

from __future__ import annotations

import base64
import hashlib
import io
import math
import struct
import warnings
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from feasibee.base.codes import exact

# --- Images of cells: decoded with a limit, encoded, and identified by their cells ---


Cells = NDArray[np.bool_]
MOST = 4096
"""Most columns, and most rows."""
_PNG, _MODES = b"\x89PNG\r\n\x1a\n", ("1", "L", "LA", "P", "RGB", "RGBA")


class ImageError(ValueError):
    """An image that isn't one of cells; its text is the rule that it breaks."""


def pixels_of(data: bytes) -> tuple[NDArray[np.uint8], Cells]:
    """Return the grey of each pixel of a PNG or PGM image, and whether it is opaque; the top row is first.

    Raise an `ImageError` if it is no such image, or is larger than ``MOST``: then nothing is decoded.
    """
    from PIL import Image

    formats = {_PNG[:2]: "PNG", b"P2": "PPM", b"P5": "PPM"}
    if data[:2] not in formats:
        raise ImageError("must be a PNG or PGM image")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            image = Image.open(io.BytesIO(data), formats=[formats[data[:2]]])
        with image:
            width, height = image.size
            if max(width, height) > MOST:
                raise ImageError(f"must be at most {MOST} x {MOST} pixels, not {width} x {height}")
            if image.mode not in _MODES:
                raise ImageError("must have at most 8 bits per colour")
            if not image.has_transparency_data:
                grey = np.asarray(image.convert("L"))
                return grey, np.ones(grey.shape, bool)
            colours = image.convert("RGBA")
            return np.asarray(colours.convert("L")), np.asarray(colours)[..., 3] == 255
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise ImageError(f"must be at most {MOST} x {MOST} pixels") from None
    except ImageError:
        raise
    except (OSError, ValueError, LookupError, SyntaxError, EOFError, struct.error, zlib.error):
        raise ImageError("is damaged: it can't be decoded") from None


@lru_cache(maxsize=4)
def cells_of(image: str) -> Cells:
    """Return which cells of a PNG in base64 are closed, in a read-only array whose row 0 has the lowest y.

    Raise an `ImageError` if it isn't such a text.
    """
    try:
        data = base64.b64decode(image, validate=True)
    except ValueError:
        raise ImageError("must be a PNG in base64") from None
    if not data.startswith(_PNG):
        raise ImageError("must be a PNG in base64")
    cells: Cells = (pixels_of(data)[0] < 128)[::-1]
    cells.flags.writeable = False
    return cells


def image_of(cells: Cells) -> str:
    """Return cells as a PNG in base64, a bit per cell, from which `cells_of` gives them again."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(~cells[::-1]).save(file, "PNG")
    return base64.b64encode(file.getvalue()).decode()


def digest_of(image: str) -> str:
    """Return a hash of the cells of an image; of its text, if it is no image."""
    try:
        cells = cells_of(image)
    except ImageError:
        return image
    return hashlib.sha256(repr(cells.shape).encode() + np.packbits(cells).tobytes()).hexdigest()


# --- Polygons: a coordinate is the decimal that a user wrote ---


Number = float | Fraction
Ring = Sequence[tuple[Number, Number]]
"""Corners of a closed line."""
Integers = NDArray[Any]
"""int64, or Python's integers where these are too short."""
_CHUNK = 256
"""Edges at a time, which bounds the memory of their pieces: up to a cell per row and column each."""


def touched(polygons: Iterable[Sequence[Ring]], cell: Fraction, shape: tuple[int, int]) -> Cells:
    """Return which cells polygons, each of one or more rings, cover in part (model.md 6.20.1).

    Points in an odd number of rings of a polygon are inside. ``cell`` is the side of a cell in the unit of
    the points, and ``shape`` the number of rows and of columns.
    """
    return _covered(polygons, cell, shape, _fill, _draw)


def centred(polygons: Iterable[Sequence[Ring]], cell: Fraction, shape: tuple[int, int]) -> Cells:
    """Return the cells whose centres are in a polygon; parameters are those of `touched`."""
    return _covered(polygons, cell, shape, _fill)


def _covered(
    polygons: Iterable[Sequence[Ring]],
    cell: Fraction,
    shape: tuple[int, int],
    *ways: Callable[[Cells, Integers, int], None],
) -> Cells:
    """Return the cells that some ways of closing them close for polygons."""
    cells = np.zeros(shape, bool)
    for polygon in polygons:
        edges, side = _edges(polygon, cell)
        for close in ways if len(edges) else ():
            close(cells, edges, side)
    return cells


def _edges(rings: Sequence[Ring], cell: Fraction) -> tuple[Integers, int]:
    """Return the edges of a polygon that have a length, a row each, and the side of a cell, which is even.

    An edge is from its lower end (x, y) to (x + dx, y + dy), with dy ≥ 0; the last column is whether it is of
    a ring without area.
    """
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
    fits = max((unit, *(abs(each) for row in rows for each in row))) < 2**29  # largest product below 2**63
    return np.array(rows, np.int64 if fits else object).reshape(-1, 5), unit


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


def _pieces(edges: Integers, first: Any, last: Any) -> Iterator[tuple[Any, Integers]]:
    """Yield a row and the columns of an edge for each row from ``first`` to below ``last`` of each edge."""
    for start in range(0, len(first), _CHUNK):
        some = slice(start, start + _CHUNK)
        rows, index = spread(first[some], last[some])
        yield rows, edges[some][index].T


def _fill(cells: Cells, edges: Integers, cell: int) -> None:
    """Close the cells whose centres are inside: those with an odd number of edges to the right."""
    height, width = cells.shape
    x, y, dx, dy, _ = edges.T
    first, last = (_within(_up(each - cell // 2, cell), height) for each in (y, y + dy))
    low, high = first.min(), last.max()
    left, right = np.minimum(x, x + dx).min() // cell, _up(np.maximum(x, x + dx).max(), cell)
    left, right = (min(max(int(each), 0), width) for each in (left, right))
    odd = np.zeros((max(high - low, 0), right - left + 1), bool)
    for rows, (x, y, dx, dy, _) in _pieces(edges, first, last):
        middle = rows.astype(x.dtype) * cell + cell // 2
        columns = _within(_up(x * dy + (middle - y) * dx - cell // 2 * dy, cell * dy), width)
        np.logical_xor.at(odd, (rows - low, columns - left), True)
    inside = np.logical_xor.accumulate(odd[:, :0:-1], axis=1)[:, ::-1]
    cells[low:high, left:right] |= inside


def _draw(cells: Cells, edges: Integers, cell: int) -> None:
    """Close the cells through which an edge runs, and those along which a ring without area runs."""
    height, slanted, flat = len(cells), edges[edges[:, 3] > 0], edges[edges[:, 3] == 0]
    first, last = slanted[:, 1] // cell, _up(slanted[:, 1] + slanted[:, 3], cell)
    for rows, (x, y, dx, dy, thin) in _pieces(slanted, _within(first, height), _within(last, height)):
        below = rows.astype(x.dtype) * cell
        heights = np.maximum(y, below), np.minimum(y + dy, below + cell)
        ends = [x * dy + (each - y) * dx for each in heights]
        low, high = np.minimum(*ends) // (cell * dy), _up(np.maximum(*ends), cell * dy)
        along = thin.astype(bool) & (low == high)
        _close(cells, rows, low - along, high + along)
    row, inside, thin = flat[:, 1] // cell, flat[:, 1] % cell != 0, flat[:, 4].astype(bool)
    first, last = row - (~inside.astype(bool) & thin), row + (inside.astype(bool) | thin)
    for rows, (x, _, dx, _, _) in _pieces(flat, _within(first, height), _within(last, height)):
        _close(cells, rows, np.minimum(x, x + dx) // cell, _up(np.maximum(x, x + dx), cell))


def _close(cells: Cells, rows: Any, low: Any, high: Any) -> None:
    """Close the cells of each row from column ``low`` to below ``high``."""
    width = cells.shape[1]
    columns, index = spread(_within(low, width), _within(high, width))
    cells[rows[index], columns] = True
