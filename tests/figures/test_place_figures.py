"""Walls, no-go areas and zones under the robots in figures and frames."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex
from pixels import DRAWINGS, close, seen_at
from walled import DOCK, PLACE

from feasibee import Scenario, Swarm, plot_arena
from feasibee.base.codes import ZONE
from feasibee.scenario.picture import between

WALL_AT, NO_GO_AT, DOCK_AT, OPEN_AT = (10.0, 3.0), (15.0, 2.0), (2.5, 7.0), (13.0, 8.0)


@pytest.mark.parametrize(("theme", "draw"), DRAWINGS)
def test_a_frame_has_the_place_below_the_robots(theme, draw):
    swarm = Swarm(PLACE, seed=1)
    picture = draw(swarm)
    assert close(seen_at(picture, PLACE, WALL_AT), theme.ink)
    assert close(seen_at(picture, PLACE, NO_GO_AT), between(theme.paper, theme.ink, 0.25))
    assert close(seen_at(picture, PLACE, DOCK_AT), between(theme.paper, ZONE, 0.12))
    assert not close(seen_at(picture, PLACE, (0.5, 7.0)), between(theme.paper, ZONE, 0.12), 40)  # its outline
    assert close(seen_at(picture, PLACE, OPEN_AT), theme.paper)
    assert close(seen_at(picture, PLACE, (10.0, 7.0)), theme.paper)  # above the wall
    x, y = swarm.positions[0]
    assert not close(seen_at(picture, PLACE, (x + 0.19, y)), theme.paper)  # off the hole of a hollow disc


def test_a_figure_has_the_place_below_the_robots():
    ax = plot_arena(Swarm(PLACE, seed=1))
    (image,) = ax.images
    assert tuple(image.get_extent()) == (0.0, 20.0, 0.0, 10.0)
    assert (np.asarray(image.get_array())[::-1, :, 3] == 255).tolist() == PLACE.plan.walls.tolist()
    outlines = [
        each.get_xy()[:-1].tolist() for each in ax.patches if to_hex(each.get_edgecolor()) == ZONE.lower()
    ]
    assert [list(each) for each in DOCK] in outlines
    assert "<dock> & more" in [each.get_text() for each in ax.texts]
    assert ax.get_xlim() == (0, 20)
    assert not plot_arena(Swarm(Scenario(), seed=1)).images
