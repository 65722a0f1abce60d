"""Pictures of robots that act: free tasks hollow, taken ones full, and a line from each robot to its task."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import same_color
from pixels import DRAWINGS, close, seen_at, shown_by

from feasibee import Scenario, Swarm, plot_arena
from feasibee.base.codes import TASK
from feasibee.figures.animation import AFTER_DECISION, _span, draw_frame
from feasibee.figures.arena import DONE, STANDS, WALKS
from feasibee.scenario.runs import Runs
from feasibee.simulation.frames import LIGHT, Painter

ROBOTS, TASKS = ((4.0, 8.0), (10.0, 4.0), (19.5, 15.0)), ((4.0, 8.9), (10.0, 5.8), (1.1, 15.0))
"""The first robot is at its task from the start on. The third one sees its own across the edge."""
SCENARIO = Scenario(
    robots={"placement": "points", "points": ROBOTS, "speed": 0.1},
    tasks={"placement": "points", "points": TASKS},
    acting={"start": 0},
    run={"steps": 60},
)


def at_step(step):
    swarm = Swarm(SCENARIO)
    swarm.advance(step)
    return swarm


def test_the_world_of_these_tests():
    swarm = at_step(2)
    aims, standing, holders = swarm.acting
    assert (aims.tolist(), standing.tolist()) == ([0, 1, 2], [True, False, False])
    assert (holders.tolist(), swarm.task_numbers.tolist()) == ([0, -1, -1], [0, 1, 2])


@pytest.mark.parametrize(("theme", "draw"), DRAWINGS)
def test_a_frame_has_free_and_taken_tasks_and_lines_to_them(theme, draw):
    picture = draw(at_step(2))
    for (x, y), fill in zip(TASKS, (TASK, theme.paper, theme.paper), strict=True):
        assert close(seen_at(picture, SCENARIO, (x - 0.17, y - 0.15)), fill)

    def dark_at(place):
        spots = [seen_at(picture, SCENARIO, (place[0] + dx, place[1])) for dx in np.linspace(-0.1, 0.1, 21)]
        return sum(close(each, theme.ink, 120) for each in spots)

    assert 1 <= dark_at((10.0, 5.0)) <= 4  # a thin line
    assert dark_at((4.0, 8.75)) > 5  # a thick one
    assert not dark_at((7.0, 8.0))
    for x in (0.5, 20.1):  # the third line wraps, and nothing of it is beyond the edge
        columns = [seen_at(picture, SCENARIO, (x, 15.0 + dy)) for dy in np.linspace(-0.3, 0.3, 61)]
        assert any(close(each, theme.ink, 120) for each in columns) == (x < 20)


def test_a_painter_of_a_run_fills_tasks_as_they_are_taken():
    painter, swarm = Painter(SCENARIO, 300), at_step(0)
    for step in (0, 2, 10, 20, 30):
        swarm.advance(step - swarm.step)
        assert painter.draw(swarm).tobytes() == Painter(SCENARIO, 300).draw(swarm).tobytes()
    assert (swarm.holders >= 0).all()


def test_an_animation_ends_after_all_tasks_are_taken():
    swarm = at_step(60)
    assert 0 < swarm.all_taken_step < 25
    assert _span(SCENARIO, Runs.single(0, 0), None) == (0, swarm.all_taken_step + AFTER_DECISION)
    assert _span(SCENARIO.replace({"acting.start": 50}), Runs.single(0, 0), None) == (0, 60)


def test_the_figure_of_the_arena_has_fills_and_lines():
    ax = plot_arena(at_step(2))
    (lines,), (points,) = (
        [each for each in ax.collections if isinstance(each, LineCollection) == is_line]
        for is_line in (True, False)
    )
    assert [same_color(each, TASK) for each in points.get_facecolor()] == [True, False, False]
    assert list(lines.get_linewidths()) == [STANDS, WALKS, WALKS, WALKS]
    ends = [each.tolist()[-1] for each in lines.get_segments()]
    np.testing.assert_allclose(ends, [*TASKS[:2], (21.1, 15.0), TASKS[2]])
    named = [each.get_text() for each in ax.get_legend().get_texts()]
    assert {"free task", "taken task", "walks to", "stands at"} < set(named)
    assert "free task" not in [each.get_text() for each in plot_arena(Swarm()).get_legend().get_texts()]


def test_done_tasks_are_pale():
    swarm = Swarm(SCENARIO.replace({"tasks.work": 5}))
    swarm.advance(8)
    assert swarm.acting.looks.tolist() == [2, 0, 1]
    place = (TASKS[0][0], TASKS[0][1] + 0.2)
    for picture in (draw_frame(swarm, size=1000), shown_by(swarm)):
        assert close(seen_at(picture, SCENARIO, place), LIGHT.faint)
    ax, shown = plot_arena(swarm), swarm._repr_html_()
    (points,) = [each for each in ax.collections if not isinstance(each, LineCollection)]
    fills = ("white", TASK, DONE)
    assert all(
        same_color(found, fills[look])
        for found, look in zip(points.get_facecolor(), swarm.acting.looks, strict=True)
    )
    assert "done task" in [each.get_text() for each in ax.get_legend().get_texts()]
    assert "robots stand at 1 of 3 tasks and have done 1" in shown


def test_a_notebook_says_what_they_do():
    assert "robots stand at 1 of 3 tasks" in at_step(2)._repr_html_()
    assert "stand at" not in Swarm()._repr_html_()
