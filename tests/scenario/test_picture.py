"""The picture of a floor plan: its cells as PNG, its zones, and both as SVG."""

from __future__ import annotations

import io
import re
from xml.etree import ElementTree

import numpy as np
from PIL import Image
from walled import DOCK, PLACE, SIDE, bitmap

from feasibee import Scenario
from feasibee.scenario.picture import OPACITIES, draw_plan, extent_of, outlines_of, picture_of


def opacities_of(plan):
    """Return the opacity of each cell in the picture of a plan; row 0 has the lowest y."""
    with Image.open(io.BytesIO(picture_of(plan))) as picture:
        return np.asarray(picture.convert("RGBA").getchannel("A"))[::-1]


def test_each_cell_is_a_pixel_as_dark_as_what_it_is():
    plan = PLACE.plan
    seen = opacities_of(plan)
    assert seen.shape == plan.walls.shape == (20, 40)
    assert (seen[plan.walls] == OPACITIES["wall"]).all()
    assert (seen[plan.keepout & ~plan.walls] == OPACITIES["no-go"]).all()
    assert (seen[~plan.walls & ~plan.keepout] == OPACITIES["open"]).all()
    assert len(np.unique(seen)) == 3
    assert seen[0, 20] == OPACITIES["wall"]
    assert seen[-1, 20] == OPACITIES["open"]


def test_the_picture_is_as_large_as_the_arena():
    plan = Scenario(
        arena={"side": (20.0, 10.0), "boundary": "walls"},
        place={"walls": [[[0, 0], [1, 0], [1, 1]]], "cell": 2.0},
    ).plan
    assert extent_of(plan) == (20.0, 10.0)


def test_a_map_of_a_million_cells_is_small():
    rng = np.random.default_rng(1)
    closed = np.zeros((1006, 1674), bool)
    for y, x in rng.integers(0, 1000, (300, 2)):
        closed[y : y + 12, x : x + 40] = True
    plan = Scenario(
        arena={"side": (83.7, 50.3), "boundary": "walls"}, place={"map": bitmap(closed, 0.05)}
    ).plan
    assert len(picture_of(plan)) < 15_000  # 20 kB in base64
    assert (opacities_of(plan) > 0).sum() == closed.sum()


def test_a_zones_name_begins_at_its_upper_left():
    assert list(outlines_of(PLACE)) == [("<dock> & more", (DOCK,), (0.5, 9.5))]


def test_notebooks_show_the_plan_of_a_scenario():
    drawing = ElementTree.fromstring(re.search("<svg.*</svg>", PLACE._repr_html_().split("<details")[0])[0])
    every = {each.tag.rpartition("}")[2]: each for each in drawing.iter()}
    assert every["text"].text == "<dock> & more"
    image, frame = every["image"], [float(each) for each in drawing.get("viewBox").split()]
    assert image.get("href").startswith("data:image/png;base64,")
    width, height = (float(image.get(each)) for each in ("width", "height"))
    assert width == 2 * height
    assert 0.9 < width / frame[2] < 1
    assert draw_plan(Scenario(), 1.0, 20) == ""
    assert "<image" not in Scenario()._repr_html_()


def test_the_drawing_of_a_low_plan_stands_on_the_arenas_lower_edge():
    low = Scenario(
        arena={"side": (20.0, 10.0), "boundary": "walls"},
        place={"walls": [[[0, 0], [1, 0], [1, 1]]], "cell": 2.0},
    )
    assert re.search(r'y="(\S+)" width="200" height="100"', draw_plan(low, 10.0, 120))[1] == "20"
    assert SIDE[0] == 2 * SIDE[1]
