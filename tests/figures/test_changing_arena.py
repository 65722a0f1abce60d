"""Pictures of swarms in worlds that change: what is there at a step, and its truth."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from pixels import close, seen_at

from feasibee import Scenario, Swarm, plot_arena
from feasibee.base.codes import COLOURS, TASK
from feasibee.figures.animation import _span, animate, draw_frame
from feasibee.scenario.runs import Runs
from feasibee.simulation.frames import DRAWN, Painter

SPOTS = ((4.0, 4.0), (10.0, 4.0), (16.0, 4.0))
SCENARIO = Scenario(
    robots={"placement": "points", "points": SPOTS, "speed": 0.0},
    tasks={"placement": "points", "points": ((10.0, 16.0),)},
    events=[{"step": 5, "robots": -2}, {"step": 10, "tasks": -1}, {"step": 15, "tasks": 2}],
    run={"steps": 20},
)


def at_step(step):
    swarm = Swarm(SCENARIO)
    swarm.advance(step)
    return swarm


@pytest.mark.parametrize(("step", "robots", "tasks"), [(4, 3, 1), (5, 1, 1), (10, 1, 0), (15, 1, 2)])
def test_a_frame_has_what_is_there(step, robots, tasks):
    swarm = at_step(step)
    picture = draw_frame(swarm, size=600)
    assert (swarm.present.sum(), len(swarm.tasks)) == (robots, tasks)
    for place, there in zip(SPOTS, swarm.present, strict=True):
        assert close(seen_at(picture, SCENARIO, (place[0], place[1] + 0.36)), "#FFFFFF") != there
    assert close(seen_at(picture, SCENARIO, (10.0, 15.9)), TASK) == (tasks > 0)


def test_a_painter_of_a_run_draws_tasks_as_they_come_and_go():
    painter, swarm = Painter(SCENARIO, 300, span=(0, 20)), at_step(0)
    for step in (0, 4, 10, 14, 15):
        swarm.advance(step - swarm.step)
        alone = Painter(SCENARIO, 300, span=(0, 20)).draw(swarm)
        assert painter.draw(swarm).tobytes() == alone.tobytes()


def test_the_truth_is_a_band_above_the_curves():
    swarm, painter = at_step(20), Painter(SCENARIO, 600, span=(0, 20))
    drawn = np.asarray(painter.draw(swarm))
    left, top, right, _ = (each / DRAWN for each in painter.strip)
    row = drawn[round(top - 3)]
    columns = [round(left + (right - left) * step / 20) for step in (3, 10, 17)]
    assert swarm.truths[[3, 10, 17]].tolist() == [True, True, False]
    assert close(row[columns[0]], COLOURS["feasible"])
    assert close(row[columns[1]], COLOURS["feasible"])
    assert close(row[columns[2]], "#FFFFFF")  # hollow
    assert close(drawn[round(top - 5)][columns[2]], COLOURS["infeasible"])


def test_the_whole_run_is_shown_by_default(tmp_path):
    assert _span(SCENARIO, Runs.single(1, 0), None) == (0, 20)
    animate(SCENARIO, tmp_path / "run.gif", size=240)
    with Image.open(tmp_path / "run.gif") as film:
        assert film.n_frames == 21


def test_the_figure_of_the_arena_has_what_is_there():
    swarm = at_step(5)
    ax = plot_arena(swarm)
    assert [text.get_text() for text in ax.texts] == [str(int(np.flatnonzero(swarm.present)[0]) + 1)]
    (points,) = ax.collections
    np.testing.assert_allclose(points.get_offsets(), [[10.0, 16.0]])
    assert len(plot_arena(at_step(10)).collections[0].get_offsets()) == 0
