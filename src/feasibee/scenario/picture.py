"""Pictures of the arena: its floor plan, and positions and lines with images across a torus's edges."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from feasibee.base.codes import ZONE
from feasibee.scenario.fields import Polygon
from feasibee.scenario.ground import Plan
from feasibee.scenario.sections import Sections

if TYPE_CHECKING:
    from PIL import Image
from typing import Self, TypeVar

from numpy.typing import NDArray

# --- The floor plan: an image of its cells, and its zones ---


OPACITIES: Final = {"open": 0, "no-go": 64, "wall": 255}
"""Of 255: how dark cells are drawn, in the colour of the drawing's ink."""


class Outline(NamedTuple):
    """A zone as it is drawn."""

    name: str
    polygons: tuple[Polygon, ...]
    """In units."""
    at: tuple[float, float]
    """Where its name begins, in units: the upper left corner of its first polygon's box."""


@lru_cache(maxsize=16)
def picture_of(plan: Plan) -> bytes:
    """Return the cells of a plan as a PNG, a pixel per cell; the top row has the highest y.

    Walls are black, no-go cells are translucent, and open cells are transparent. So pages and figures can
    draw it in their own ink, by its opacity alone.
    """
    from PIL import Image

    looks = np.where(plan.walls, 2, np.where(plan.keepout, 1, 0)).astype(np.uint8)[::-1]
    image = Image.fromarray(np.ascontiguousarray(looks), "P")
    image.putpalette(bytes(3 * len(OPACITIES)))
    image.save(kept := io.BytesIO(), "PNG", transparency=bytes(OPACITIES.values()), bits=2, optimize=True)
    return kept.getvalue()


def extent_of(plan: Plan) -> tuple[float, float]:
    """Return the width and height of the picture in units."""
    rows, columns = plan.walls.shape
    return float(plan.cell * columns), float(plan.cell * rows)


def outlines_of(scenario: Sections) -> Iterator[Outline]:
    """Yield the zones of a scenario's place."""
    for name, polygons in scenario.place.zones.items():
        xs, ys = zip(*polygons[0], strict=True)
        yield Outline(name, polygons, (min(xs), max(ys)))


def between(one: str, other: str, part: float) -> tuple[int, ...]:
    """Return the colour at a share of the way from one colour to another."""
    from PIL.ImageColor import getrgb

    ends = zip(getrgb(one), getrgb(other), strict=True)
    return tuple(round(start + part * (end - start)) for start, end in ends)


def paint_plan(
    ground: Image.Image, scenario: Sections, font: Any, paper: str = "#FFFFFF", ink: str = "#1F2328"
) -> None:
    """Paint zones with their names, no-go cells and walls into a picture of the arena."""
    from PIL import Image, ImageDraw

    if scenario.plan is None:
        return
    pen, height, scale = ImageDraw.Draw(ground), ground.height, max(ground.size) / max(scenario.arena.size)
    for name, polygons, (x, y) in outlines_of(scenario):
        for each in polygons:
            corners = [(scale * px, height - scale * py) for px, py in each]
            pen.polygon(corners, between(paper, ZONE, 0.12), ZONE, 2)
        pen.text((scale * x + 6, height - scale * y + 4), name, ink, font, "la")
    with Image.open(io.BytesIO(picture_of(scenario.plan))) as picture:
        size = [max(1, round(scale * each)) for each in extent_of(scenario.plan)]
        way = Image.Resampling.NEAREST if size[0] > picture.width else Image.Resampling.BOX
        dark = picture.convert("RGBA").getchannel("A").resize((size[0], size[1]), way)
    ground.paste(ink, (0, height - size[1]), dark)


def encoded(picture: Image.Image) -> str:
    """Return a picture as PNG of few colours in base64."""
    picture.quantize(128).save(kept := io.BytesIO(), "PNG", optimize=True)
    return base64.b64encode(kept.getvalue()).decode()


# --- Positions and lines ---


Number = TypeVar("Number", np.float64, np.int64)


class Deeds(NamedTuple):
    """What robots that act do at a step (model.md 6.25), as pictures and pages draw it."""

    aims: NDArray[np.int64]
    """Task to which each robot walks, or at which it stands: int64, shape (robots,).

    It is the task's place among those of the step. -1 stands for none, or for one that has vanished.
    """
    standing: NDArray[np.bool_]
    """Whether each robot stands at a task: bool, shape (robots,)."""
    holders: NDArray[np.int64]
    """Robot that stands at each task of the step, or has marked it: int64, shape (tasks,).

    -1 stands for none, and -2 for a done task.
    """

    @property
    def looks(self) -> NDArray[np.uint8]:
        """0 for each free task of the step, 1 for a taken one, 2 for a done one: uint8, shape (tasks,)."""
        return np.choose(np.minimum(self.holders, 0) + 2, [2, 0, 1]).astype(np.uint8)

    @property
    def achieved(self) -> str:
        """At how many tasks robots stand, and how many are done, in words."""
        done = int((self.looks == 2).sum())
        more = f" and have done {done}" if done else ""
        return f"robots stand at {self.standing.sum()} of {len(self.holders)} tasks{more}"

    @classmethod
    def of(
        cls,
        targets: NDArray[np.int32],
        standing: NDArray[np.bool_],
        holders: NDArray[np.int32],
        numbers: NDArray[np.int64],
    ) -> Self:
        """Return what robots do; targets and holders are those of ``Swarm``, numbers those of its tasks."""
        aims = np.where(np.isin(targets, numbers), np.searchsorted(numbers, targets), -1)
        held = holders[numbers].astype(np.int64)
        at = np.flatnonzero((held >= 0) & standing[held])
        aims[held[at]] = at
        return cls(aims, standing, held)


def images(
    places: NDArray[Number], reach: float, size: tuple[float, float], walls: bool
) -> tuple[NDArray[Number], NDArray[np.int64]]:
    """Return positions to draw: those of all things and, on a torus, their images beyond the opposite edges.

    ``places`` are positions, shape (things, 2), from 0 to the sides of the arena, ``size``, in any unit.
    Things are drawn up to ``reach`` from them. Walls have no images. The second array has the number of the
    thing of each position; those of the things come first, in their order.
    """
    names = np.arange(len(places))
    for axis, side in enumerate(() if walls else size):
        low, high = (places[:, axis] < reach).nonzero()[0], (places[:, axis] > side - reach).nonzero()[0]
        every = np.concatenate([np.arange(len(places)), low, high])
        shift = np.zeros((len(every), 2), places.dtype)
        shift[len(places) : len(places) + len(low), axis] = side
        shift[len(places) + len(low) :, axis] = -side
        places, names = places[every] + shift, names[every]
    return places, names


def segments(
    starts: NDArray[np.float64], ends: NDArray[np.float64], size: tuple[float, float], walls: bool
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return lines to draw from places to others: on a torus the shortest way, from both ends if it wraps.

    ``starts`` and ``ends`` have the shape (lines, 2). The first array returned, shape (parts, 2, 2), has the
    start and end of each line, and then of each second part; the second one the line of each part.
    """
    straight = ends - starts
    ways = straight if walls else straight - np.round(straight / size) * size
    wrapped = (ways != straight).any(axis=1).nonzero()[0]
    whole, second = np.stack([starts, starts + ways], axis=1), np.stack([ends - ways, ends], axis=1)
    return np.concatenate([whole, second[wrapped]]), np.concatenate([np.arange(len(starts)), wrapped])
