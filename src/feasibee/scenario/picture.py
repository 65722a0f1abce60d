"""The picture of a floor plan, which all drawings of an arena share: an image of its cells, and its zones."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterator
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from feasibee.model.codes import ZONE
from feasibee.scenario.plan import Plan
from feasibee.scenario.sections import Sections
from feasibee.scenario.types import Polygon

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


def draw_plan(scenario: Sections, scale: float, height: int) -> str:
    """Return the plan of a scenario as elements of SVG; empty without a place.

    Parameters
    ----------
    scenario : Sections
        The scenario.
    scale : float
        Length of a unit in the drawing.
    height : int
        Height of the arena in the drawing, in which y points downward.
    """
    plan = scenario.plan
    if plan is None:
        return ""
    width, tall = (scale * each for each in extent_of(plan))
    data = base64.b64encode(picture_of(plan)).decode()
    parts = [
        f'<image href="data:image/png;base64,{data}" y="{height - tall:g}" width="{width:g}" '
        f'height="{tall:g}" preserveAspectRatio="none" style="image-rendering:pixelated"/>'
    ]
    size = round(scale * max(scenario.arena.size) / 32)
    for name, polygons, (x, y) in outlines_of(scenario):
        path = "".join(
            "M" + "L".join(f"{scale * px:g} {height - scale * py:g}" for px, py in each) + "z"
            for each in polygons
        )
        parts.append(
            f'<path d="{path}" fill="{ZONE}" fill-opacity=".12" stroke="{ZONE}" stroke-width="{size / 8:g}"/>'
            f'<text x="{scale * x + size / 2:g}" y="{height - scale * y + 1.2 * size:g}" font-size="{size}" '
            f'font-family="sans-serif" fill="#222">{html.escape(name)}</text>'
        )
    return "".join(parts)
