"""The picture of a floor plan: its cells as PNG, its zones, and both on the ground of an arena."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image
from pixels import close, shown_by
from walled import DOCK, PLACE, bitmap

from feasibee import Scenario
from feasibee.base.codes import ZONE
from feasibee.scenario.picture import OPACITIES, between, extent_of, outlines_of, paint_plan, picture_of


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
    picture, shown = shown_by(PLACE), PLACE._repr_html_()
    assert 'alt="Floor plan, zone &lt;dock&gt; &amp; more"' in shown
    assert abs(picture.width - 2 * picture.height) < 10  # for its edge
    white, ink = "#FFFFFF", "#1F2328"
    for (x, y), colour in {
        (10.0, 3.0): ink,
        (15.0, 2.0): between(white, ink, 64 / 255),
        (2.5, 7.0): between(white, ZONE, 0.12),
        (13.0, 8.0): white,
        (10.0, 7.0): white,  # above the wall
        (0.0, 5.0): ink,  # the edge
    }.items():
        assert close(picture.getpixel((2 + int(x * 36), 2 + int((10 - y) * 36))), colour)
    named = np.asarray(picture.convert("L").crop((22, 20, 180, 45)))  # at the upper left of the zone
    assert (named < 90).sum() > 100
    assert "<img" not in Scenario()._repr_html_()


def test_a_low_plan_is_as_large_as_the_arena_and_stands_on_its_lower_edge():
    low = Scenario(
        arena={"side": (20.0, 10.0), "boundary": "walls"},
        place={"walls": [[[0, 0], [1, 0], [1, 1]]], "cell": 2.0},
    )
    assert extent_of(low.plan) == (20.0, 10.0)
    paint_plan(ground := Image.new("RGB", (200, 120), "#FFFFFF"), low, None)
    dark = np.argwhere(np.asarray(ground.convert("L")) < 128)
    assert (dark.min(axis=0).tolist(), dark.max(axis=0).tolist()) == ([100, 0], [119, 19])
