"""Labels at the ends of lines and at points, placed so that they don't overlap."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from itertools import product
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox, blended_transform_factory, offset_copy
from numpy.typing import NDArray

from feasibee.figures.style import GREY, PLAIN, LineStyle, as_text, text_colour

SIZE: Final = 8.0
"""Size of labels, in points."""
TEXT: Final[Any] = {"va": "center", "fontsize": SIZE, "annotation_clip": False}
GAP: Final = 1.3 * SIZE
"""Least distance between two labels, from baseline to baseline, in points."""
SPACE: Final = 16.0
"""Length of the line from the axes to its label, in points."""
DISTANCES: Final = (4.0, 11.0, 20.0, 32.0)
"""Distances of a label from its point, in points; the first one that has room is taken."""
DIRECTIONS: Final = ((1, 0), (1, -1), (-1, 0), (0, -1), (0, 1), (1, 1), (-1, -1), (-1, 1))
"""On which sides of a point a label may stand, in order of preference."""
BETTER: Final = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))
"""The same for a highlighted point: where no point is better in both."""


def label_ends(
    ax: Axes,
    ends: Mapping[str, tuple[float, float]],
    looks: Mapping[str, LineStyle],
    scores: Mapping[str, float] = MappingProxyType({}),
    *,
    markers: bool = True,
    title: str = "",
) -> None:
    """Write names to the right of the axes, each joined to the end of its line; name grey lines below.

    Call it after all else is drawn. Of lines that end in one place, that with the larger score is on top.
    ``ends`` has the last point of each line, by name; those of grey lines aren't used. ``title`` is what the
    names are values of.

    With ``markers``, the names have those of their lines. Otherwise the lines reach the edge of the axes, and
    a piece of the line leads from there to the name.
    """
    figure: Any = ax.figure.figure  # the outermost one
    _name_others(figure, [name for name, look in looks.items() if look == PLAIN])
    figure.draw_without_rendering()  # fixes the height of the axes
    inverse = ax.transData.inverted()
    if title:
        top = offset_copy(ax.transAxes, figure, SPACE, 0.5 * GAP, "points")
        ax.text(1.0, 1.0, title, transform=top, fontsize=SIZE, va="bottom", clip_on=False)
    shown = [name for name in ends if looks[name] != PLAIN]
    names = sorted(shown, key=lambda name: (round(ends[name][1]), scores.get(name, 0.0)))
    scale = figure.dpi / 72
    box = ax.get_window_extent()
    wanted = [ax.transData.transform(ends[name])[1] for name in names]
    heights = spread(wanted, GAP * scale, box.y0, box.y1)
    side = offset_copy(blended_transform_factory(ax.transAxes, ax.transData), figure, SPACE, 0, "points")
    for name, height in zip(names, heights, strict=True):
        place, look = (1.0, float(inverse.transform((0, height))[1])), looks[name]
        start, frame, joint = ends[name], ax.transData, {"color": GREY, "linewidth": 0.5}
        if markers:
            ax.plot(*place, look.marker, color=look.colour, markersize=4, transform=side, clip_on=False)
        else:
            start, frame = (1.0, start[1]), blended_transform_factory(ax.transAxes, ax.transData)
            joint = {"color": look.colour, "linestyle": look.dashes, "linewidth": 1.0}
        arrow = {"arrowstyle": "-", "shrinkA": 0, "shrinkB": 2, "relpos": (0, 0.5), **joint}
        colour = text_colour(look.colour)
        ax.annotate(f"  {as_text(name)}", start, place, frame, side, arrowprops=arrow, color=colour, **TEXT)


def _name_others(figure: Figure, grey: Sequence[str]) -> None:
    """Write below a figure which lines are grey, if any."""
    if grey:
        width = int(figure.get_figwidth() * 72 / (0.53 * (SIZE - 1)))
        whole: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
        text = textwrap.fill(f"grey: {', '.join(map(as_text, grey))}", width, **whole)
        figure.supxlabel(text, x=0.01, ha="left", fontsize=SIZE - 1, color="0.4")


def spread(wanted: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Return places in ascending order, at least a gap apart and within limits, nearest to given ones.

    Neighbours that are too close are moved as a group, to where the sum of their squared moves is least. If
    there is no room for all, they begin at ``low`` and pass ``high``.
    """
    groups: list[tuple[float, int]] = []  # sum of the wanted places of the first label, and number of labels
    for number, place in enumerate(wanted):
        total, size = min(max(place, low), high) - number * gap, 1
        while groups and groups[-1][0] / groups[-1][1] > total / size:
            before = groups.pop()
            total, size = total + before[0], size + before[1]
        groups.append((total, size))
    top = high - (len(wanted) - 1) * gap
    firsts = [max(low, min(total / size, top)) for total, size in groups for _ in range(size)]
    return [first + number * gap for number, first in enumerate(firsts)]


class Point(NamedTuple):
    """A point with a label and a vertical bar."""

    name: str
    x: float
    y: float
    look: LineStyle
    low: float
    high: float
    """Ends of its bar."""
    hollow: bool = False


def draw_points(ax: Axes, points: Sequence[Point]) -> None:
    """Draw points with their bars."""
    for _, x, y, look, low, high, hollow in points:
        face: dict[str, Any] = {"markerfacecolor": "white"} if hollow else {}
        ax.errorbar([x], [y], [[y - low], [high - y]], **look.bars, **face)


def label_points(ax: Axes, points: Sequence[Point]) -> None:
    """Write names at points where they cover no point, bar or other name; leave out grey ones without room.

    Call it after all else is drawn. Highlighted points choose first; one without room near it has its label
    at some distance, joined by a line.
    """
    figure: Any = ax.figure.figure  # the outermost one
    figure.draw_without_rendering()
    scale = figure.dpi / 72
    inside = ax.get_window_extent().padded(-scale)
    taken = [_bar(ax, point, scale) for point in points]
    for point in sorted(points, key=lambda point: (not point.look.highlighted, -point.y)):
        name = as_text(point.name)
        label = ax.annotate(name, (point.x, point.y), **_text(point.look))
        label.set_in_layout(False)
        size = label.get_window_extent()
        label.remove()
        middle = ax.transData.transform((point.x, point.y))
        directions = BETTER if point.look.highlighted else DIRECTIONS
        found = _room(middle, (size.width, size.height), directions, taken, inside, scale)
        if found is None and not point.look.highlighted:
            continue
        left, bottom = offset = found or (DISTANCES[0], 0.0)
        placed = ax.annotate(
            name,
            (point.x, point.y),
            (left, bottom),
            textcoords="offset points",
            arrowprops=_leader(offset, (size.width / scale, size.height / scale), point.look),
            **_text(point.look),
        )
        placed.set_in_layout(False)
        corner = middle[0] + left * scale, middle[1] + bottom * scale
        taken.append(Bbox.from_bounds(*corner, size.width, size.height))


def _text(look: LineStyle) -> dict[str, Any]:
    colour = text_colour(look.colour) if look.highlighted else "0.4"
    return {"fontsize": SIZE if look.highlighted else SIZE - 1, "color": colour, "ha": "left", "va": "bottom"}


def _bar(ax: Axes, point: Point, scale: float) -> Bbox:
    """Return the box of a point with its bar, in pixels."""
    ends = ax.transData.transform([(point.x, point.low), (point.x, point.high), (point.x, point.y)])
    half = 3.5 * scale
    return Bbox([[ends[0][0] - half, ends[:, 1].min() - half], [ends[0][0] + half, ends[:, 1].max() + half]])


def _room(
    middle: NDArray[np.float64],
    size: tuple[float, float],
    directions: Sequence[tuple[int, int]],
    taken: Sequence[Bbox],
    inside: Bbox,
    scale: float,
) -> tuple[float, float] | None:
    """Return the offset of a label's lower left corner from its point, in points; None without room."""
    width, height = size
    for distance, (across, up) in product(DISTANCES, directions):
        reach = distance * scale
        left = across * reach + (0 if across > 0 else -width if across < 0 else -width / 2)
        bottom = up * reach + (0 if up > 0 else -height if up < 0 else -height / 2)
        box = Bbox.from_bounds(middle[0] + left, middle[1] + bottom, width, height)
        within = inside.x0 <= box.x0 and box.x1 <= inside.x1 and inside.y0 <= box.y0 and box.y1 <= inside.y1
        if within and not any(box.overlaps(each) for each in taken):
            return left / scale, bottom / scale
    return None


def _leader(offset: tuple[float, float], size: tuple[float, float], look: LineStyle) -> dict[str, Any] | None:
    """Return the line from a label to its point, if they are far apart."""
    nearest = [max(start, 0.0, -(start + length)) for start, length in zip(offset, size, strict=True)]
    if max(nearest) <= DISTANCES[0] + 1:
        return None
    return {"arrowstyle": "-", "linewidth": 0.6, "color": look.colour, "shrinkA": 1, "shrinkB": 3}
