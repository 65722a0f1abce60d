"""The picture of a floor plan, which all drawings of an arena share: an image of its cells, and its zones."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from feasibee.model.codes import ZONE
from feasibee.scenario.plan import Plan
from feasibee.scenario.sections import Sections
from feasibee.scenario.types import Polygon

if TYPE_CHECKING:
    from PIL import Image

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
