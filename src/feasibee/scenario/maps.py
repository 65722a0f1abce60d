"""Floor plans: files of maps and polygons, which the complete form of a scenario has as cells and points.

Nothing in a file is run, and its cells are counted before they are decoded.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, Final, NamedTuple, TypeVar

import numpy as np
from pydantic import ValidationError

from feasibee.base.codes import exact
from feasibee.base.errors import Problem, quoted
from feasibee.base.files import TABLE_LIMIT, UnreadableError, read_bytes, read_text
from feasibee.scenario.cells import MOST, Cells, ImageError, image_of, pixels_of, touched
from feasibee.scenario.fields import Arena, Place, Units
from feasibee.scenario.ground import shape_of

Table = dict[str, Any]
Points = list[tuple[Fraction, Fraction]]
Polygons = list[list[Points]]
Read = TypeVar("Read")
YAML_LIMIT = 2**16
"""Largest text of a YAML file, in characters: a hundred times a usual one."""
GEOJSON_LIMIT = 8 * 2**20
"""Largest GeoJSON file, in bytes: 100,000 walls of 4 corners."""
MAPS: Final = (".yaml", ".yml")
POLYGONS: Final = (".geojson", ".json")
NAME_ONE: Final = "name the .yaml file of a ROS map, or a .geojson file of polygons"


class _WrongError(Exception):
    """A file that isn't a floor plan: the rule that it breaks, and a remedy."""


class MapFrame(NamedTuple):
    """The grid of a place, and where it lies in the coordinates of files."""

    cell: Fraction
    """Side of a cell, in units."""
    metres: Fraction
    """Metres per unit."""
    left: Fraction
    """Coordinate x of the left edge, in metres."""
    low: Fraction
    """Coordinate y of the lower edge, in metres."""
    shape: tuple[int, int]
    """Number of rows and of columns."""

    def placed(self, polygons: Polygons) -> Polygons:
        """Return polygons in metres as polygons in units."""
        return [
            [
                [((x - self.left) / self.metres, (y - self.low) / self.metres) for x, y in ring]
                for ring in each
            ]
            for each in polygons
        ]


UNKNOWN: Final = MapFrame(Fraction(1), Fraction(1), Fraction(0), Fraction(0), (1, 1))
"""In place of a frame that follows from wrong values."""


class _Map(NamedTuple):
    """A ROS map, in metres; row 0 of its cells has the lowest y."""

    resolution: Fraction
    left: Fraction
    low: Fraction
    occupied: Cells
    closed: Cells
    """Which cells are occupied or unknown."""


def with_plans(place: Mapping[str, Any], side: object, metres: object) -> tuple[Table, list[Problem]]:
    """Replace names of files in the table of a place by cells and polygons; return the problems, too.

    Nothing is validated yet; ``side`` and ``metres`` are None if they aren't set.
    """
    table, problems = dict(place), list[Problem]()
    frame = _frame(place, side, metres)

    def read(reader: Callable[[str], Read], path: str, name: str) -> Read | None:
        try:
            return reader(name)
        except UnreadableError as error:
            problems.append(Problem(path, name, f"can't be read: {error.why}", NAME_ONE))
        except _WrongError as error:
            problems.append(Problem(path, name, *error.args))
        return None

    if isinstance(table.get("map"), str):
        found = read(partial(_map, frame=frame, has_side=side is not None), "place.map", table.pop("map"))
        frame, cells = found or (UNKNOWN, None)
        if cells is not None:
            table["map"] = _bitmap(frame, cells)
    if isinstance(table.get("keepout"), str):
        mask = read(partial(_keepout, frame=frame), "place.keepout", table.pop("keepout"))
        if mask is not None:
            table["keepout"] = _bitmap(frame, mask)
    if isinstance(table.get("zones"), Mapping):
        zones = {
            name: read(partial(_zone, frame=frame), f"place.zones.{name}", zone)
            if isinstance(zone, str)
            else zone
            for name, zone in table["zones"].items()
        }
        table["zones"] = {name: zone for name, zone in zones.items() if zone is not None}
    return table, problems


def _frame(place: Mapping[str, Any], side: object, metres: object) -> MapFrame:
    """Return the grid of a place whose map, if any, isn't a file; `UNKNOWN` if values are wrong."""
    own = {key: place[key] for key in ("map", "cell") if key in place and not isinstance(place[key], str)}
    try:
        known = Place.model_validate(own)
        size = Arena.model_validate({} if side is None else {"side": side}).size
        unit = Units.model_validate({"metres": metres}).metres
    except ValidationError:
        return UNKNOWN
    cell, shape = exact(known.map.cell if known.map else known.cell), shape_of(known, size)
    left, low = map(exact, known.map.origin if known.map else (0.0, 0.0))
    frame = MapFrame(cell, Fraction(1) if unit is None else exact(unit), left, low, shape)
    return frame if max(shape) <= MOST else UNKNOWN


def _bitmap(frame: MapFrame, cells: Cells) -> Table:
    origin = float(frame.left), float(frame.low)
    return {"cell": float(frame.cell), "origin": origin, "image": image_of(cells)}


def _map(name: str, frame: MapFrame, has_side: bool) -> tuple[MapFrame, Cells]:
    """Read the file of a map; return its grid and which cells are closed."""
    if _is_polygons(name):
        polygons = _polygons(name)
        frame = frame if has_side else _around(polygons, frame)
        return frame, touched(frame.placed(polygons), frame.cell, frame.shape)
    found = _ros_map(name)
    cell = _rounded(found.resolution / frame.metres)
    return MapFrame(cell, frame.metres, found.left, found.low, found.closed.shape), found.closed


def _around(polygons: Polygons, frame: MapFrame) -> MapFrame:
    """Return the smallest grid with all corners of polygons."""
    xs, ys = zip(*(point for each in polygons for ring in each for point in ring), strict=True)
    step = frame.cell * frame.metres
    rows, columns = (max(1, math.ceil((max(each) - min(each)) / step)) for each in (ys, xs))
    if max(rows, columns) > MOST:
        least = max(max(each) - min(each) for each in (xs, ys)) / MOST / frame.metres
        rule = f"has {columns} x {rows} cells of {float(frame.cell):g} units, above {MOST} x {MOST}"
        raise _WrongError(rule, f"set place.cell to {math.ceil(least * 1000) / 1000:g} or more")
    return frame._replace(left=min(xs), low=min(ys), shape=(rows, columns))


def _keepout(name: str, frame: MapFrame) -> Cells:
    """Read the file of cells that robots must not enter, in the grid of a place."""
    if _is_polygons(name):
        return touched(frame.placed(_polygons(name)), frame.cell, frame.shape)
    mask = _ros_map(name)
    cells = np.zeros(frame.shape, bool)
    if frame is UNKNOWN:
        return cells
    step = float(frame.cell * frame.metres)
    if _rounded(mask.resolution / frame.metres) != frame.cell:
        rule = f"must have the resolution of the place, {step:g} m, not {float(mask.resolution):g} m"
        raise _WrongError(rule, f"export it with {step:g} m per pixel")
    offset = (
        round((mask.low - frame.low) / mask.resolution),
        round((mask.left - frame.left) / mask.resolution),
    )
    ours, theirs = (
        tuple(
            slice(max(0, sign * by), max(0, sign * by + size)) for by, size in zip(offset, sizes, strict=True)
        )
        for sign, sizes in ((1, mask.occupied.shape), (-1, frame.shape))
    )
    if not cells[ours].size:
        raise _WrongError("lies outside of the place", "correct the origin in the YAML file")
    cells[ours] = mask.occupied[theirs]
    return cells


def _zone(name: str, frame: MapFrame) -> list[list[list[float]]]:
    """Read the file of a zone; return its polygons in units."""
    if not _is_polygons(name):
        raise _WrongError("must be a file of polygons", "name a .geojson file")
    return [[[float(x), float(y)] for x, y in _joined(each)] for each in frame.placed(_polygons(name))]


def _joined(rings: list[Points]) -> Points:
    """Return a polygon with holes as one ring that goes to each hole and back."""
    outer, *holes = rings
    points = list(outer)
    for hole in holes:
        points += [outer[0], *hole, hole[0]]
    return points


def _is_polygons(name: str) -> bool:
    """Return whether a file's name is that of polygons, not of a ROS map; raise an error if of neither."""
    suffix = Path(name).suffix.lower()
    if suffix not in MAPS + POLYGONS:
        raise _WrongError(f"must end with {', '.join(MAPS)}, {' or '.join(POLYGONS)}", NAME_ONE)
    return suffix in POLYGONS


# --- ROS maps ---


def _ros_map(name: str) -> _Map:
    """Read a YAML file and its image, as nav2's map server does."""
    table = _yaml(read_text(name, NAME_ONE))
    resolution, free, occupied = (
        _number(table, key, default, least, most)
        for key, default, least, most in (
            ("resolution", None, Fraction(1, 10**6), 10**6),
            ("free_thresh", "0.25", 0, 1),
            ("occupied_thresh", "0.65", 0, 1),
        )
    )
    if free >= occupied:
        raise _WrongError("free_thresh must be below occupied_thresh", "set free_thresh: 0.25")
    mode, negate = table.get("mode", "trinary"), table.get("negate", "0")
    if mode not in ("trinary", "scale"):
        raise _WrongError(f"mode {quoted(mode)} must be trinary or scale", "export it as mode: trinary")
    if negate not in ("0", "1", "false", "true"):
        raise _WrongError(f"negate {quoted(negate)} must be 0 or 1", "set negate: 0")
    left, low = _origin(table.get("origin", ["0", "0", "0"]))
    grey, opaque = _image(name, table.get("image"))
    shades = [Fraction(each if negate in ("1", "true") else 255 - each, 255) for each in range(256)]
    is_open, is_occupied = (
        np.array([test(each) for each in shades]) for test in (free.__ge__, occupied.__le__)
    )
    return _Map(resolution, left, low, (is_occupied[grey] & opaque)[::-1], ~(is_open[grey] & opaque)[::-1])


def _yaml(text: str) -> Table:
    """Parse YAML with all values as text."""
    import yaml

    if len(text) > YAML_LIMIT:
        raise _WrongError(f"must have at most {YAML_LIMIT} characters", NAME_ONE)
    try:
        found = yaml.load(text, yaml.BaseLoader)
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f", line {mark.line + 1}" if mark else ""
        raise _WrongError(f"isn't YAML{where}", NAME_ONE) from None
    if not isinstance(found, dict):
        raise _WrongError("must be a table of image, resolution and origin", NAME_ONE)
    return found


def _number(table: Table, key: str, default: object, least: Fraction | int, most: int) -> Fraction:
    if default is None and key not in table:
        raise _WrongError(f"{key} is missing in this file", f"write {key}: 0.05, in metres per pixel")
    number = _exact(table.get(key, default))
    if number is None or not least <= number <= most:
        rule = f"{key} {quoted(table.get(key))} must be a number from {float(least):g} to {most}"
        raise _WrongError(rule, f"write {key}: {default or 0.05}")
    return number


def _exact(value: object) -> Fraction | None:
    """Return a finite number exactly, from text or a float; None for anything else."""
    try:
        number = float(value) if isinstance(value, str | float) else math.nan
    except ValueError:
        return None
    return exact(number) if math.isfinite(number) else None


def _rounded(value: Fraction) -> Fraction:
    """Return a side of cells with 7 digits: some programs write that of 0.05 m as 0.05000000074505806."""
    return exact(float(f"{float(value):.7g}"))


def _origin(value: object) -> tuple[Fraction, Fraction]:
    numbers = [_exact(each) for each in value] if isinstance(value, list) else []
    if len(numbers) not in (2, 3) or None in numbers:
        raise _WrongError(f"origin {quoted(value)} must be three numbers", "write origin: [0, 0, 0]")
    left, low, yaw = [each or Fraction(0) for each in (*numbers, None)][:3]
    if yaw:
        raise _WrongError(
            f"origin has yaw {float(yaw):g}, which must be 0", "turn the image, and set yaw to 0"
        )
    return left, low


def _image(name: str, image: object) -> tuple[Any, Cells]:
    if image is None:
        raise _WrongError("image is missing in this file", "write image: hall.pgm, the name of its image")
    if not isinstance(image, str) or not image:
        raise _WrongError(f"image {quoted(image)} must be a file's name", "write image: hall.pgm")
    try:
        return pixels_of(read_bytes(Path(name).parent / image, "an image", TABLE_LIMIT))
    except UnreadableError as error:
        raise _WrongError(
            f"image {quoted(image)} can't be read: {error.why}", "name a PGM or PNG image"
        ) from None
    except ImageError as error:
        raise _WrongError(f"image {quoted(image)} {error}", "export the map as PGM or PNG") from None


# --- GeoJSON ---


def _polygons(name: str) -> Polygons:
    """Read the polygons of a GeoJSON file, in metres."""
    text = read_text(name, NAME_ONE, GEOJSON_LIMIT)
    try:
        found = list(_shapes(json.loads(text, parse_int=float), ""))
    except RecursionError:
        raise _WrongError("is nested too deeply", NAME_ONE) from None
    except ValueError as error:
        raise _WrongError(f"isn't JSON: {error}", NAME_ONE) from None
    if not found:
        raise _WrongError("has no polygon", "draw one, or leave the file out")
    return found


def _shapes(value: object, where: str) -> Iterator[list[Points]]:
    """Yield the polygons of a GeoJSON object; ``where`` names it in errors."""
    table: Mapping[str, Any] = value if isinstance(value, dict) else {}
    kind = table.get("type")
    if kind == "FeatureCollection":
        for number, each in enumerate(_list(table.get("features"), f"{where}features"), start=1):
            yield from _shapes(each, f"{where}feature {number}: ")
    elif kind == "Feature":
        yield from _shapes(table.get("geometry"), where)
    elif kind == "Polygon":
        yield _rings(table.get("coordinates"), where)
    elif kind == "MultiPolygon":
        yield from (_rings(each, where) for each in _list(table.get("coordinates"), f"{where}coordinates"))
    else:
        rule = f"{where}must be a Polygon or MultiPolygon, not {quoted(kind)}"
        raise _WrongError(rule, "export polygons in metres as GeoJSON")


def _rings(value: object, where: str) -> list[Points]:
    """Return the rings of a polygon, without the closing point, which is the first again."""
    rings = [
        [_point(each, where) for each in _list(ring, f"{where}ring")]
        for ring in _list(value, f"{where}rings")
    ]
    rings = [ring[:-1] if ring and ring[0] == ring[-1] else ring for ring in rings]
    if not rings or min(map(len, rings)) < 3:
        raise _WrongError(f"{where}a polygon must have rings of 3 or more points", "remove it")
    return rings


def _point(value: object, where: str) -> tuple[Fraction, Fraction]:
    numbers = [
        _exact(each) if isinstance(each, float) else None for each in _list(value, f"{where}point")[:2]
    ]
    if len(numbers) < 2 or numbers[0] is None or numbers[1] is None:
        rule = f"{where}{quoted(value)} must be a point of two finite numbers"
        raise _WrongError(rule, "write metres, such as [1.5, 2.0]")
    return numbers[0], numbers[1]


def _list(value: object, where: str) -> list[Any]:
    if not isinstance(value, list):
        raise _WrongError(f"{where} {quoted(value)} must be a list", "export polygons in metres as GeoJSON")
    return value
