"""Heat maps: where robots were, and which places they saw."""

from __future__ import annotations

import math

import numpy as np
import pytest
from walled import PLACE

from feasibee import FeasibeeError, Scenario, Swarm
from feasibee.figures.heat import BINS, heat_of, plot_heat


def standing(x, y, **scenario):
    """Return the heat of one robot that stands at a place."""
    robots = {"count": 1, "speed": 0.0, "diameter": 0.5, "placement": "points", "points": [[x, y]]}
    return heat_of(Scenario(robots=robots, run={"steps": 5}, **scenario), runs=1)


def value_at(heat, values, x, y):
    return values[int(y / heat.side), int(x / heat.side)]


def test_on_a_torus_robots_are_everywhere_and_see_as_much_as_their_range_covers():
    shares = []
    heat = heat_of(Scenario(run={"steps": 400}), runs=10, seed=1, progress=shares.append)
    assert shares == [pytest.approx(k / 10) for k in range(1, 11)]
    assert heat.robots.shape == heat.sightings.shape == (BINS, BINS)
    assert heat.robots.sum() * heat.side**2 == pytest.approx(20)
    assert heat.sightings.mean() == pytest.approx(20 * math.pi * 2**2 / 400, rel=0.01)
    assert heat.sightings.std() < 0.2 * heat.sightings.mean()


def test_a_robot_sees_its_range_across_the_edges_of_a_torus_only():
    for boundary, sees in (("torus", 1.0), ("walls", 0.0)):
        heat = standing(0.5, 5.0, arena={"side": [20.0, 10.0], "boundary": boundary})
        assert heat.robots.shape == (BINS // 2, BINS)
        assert value_at(heat, heat.robots, 0.5, 5.0) * heat.side**2 == 1
        assert value_at(heat, heat.sightings, 2.2, 5.0) == 1
        assert value_at(heat, heat.sightings, 2.8, 5.0) == 0
        assert value_at(heat, heat.sightings, 19.4, 5.0) == sees


def test_walls_hide_and_no_go_cells_do_not():
    there = {"arena": {"side": [20.0, 10.0], "boundary": "walls"}, "sensing": {"range": 4.0}}
    place = PLACE.place.model_dump(exclude_defaults=True)
    heat = standing(8.0, 3.0, place=place, **there)
    assert value_at(heat, heat.sightings, 8.7, 3.0) == 1
    assert value_at(heat, heat.sightings, 11.5, 3.0) == 0
    bare = standing(8.0, 3.0, **there)
    assert value_at(bare, bare.sightings, 11.5, 3.0) == 1
    assert value_at(heat, heat.sightings, 8.5, 6.5) == 1
    past = standing(13.0, 2.0, place=place, **there)
    assert value_at(past, past.sightings, 16.5, 2.0) == 1
    moving = heat_of(
        PLACE.replace({"robots.points": [], "robots.placement": "uniform", "robots.count": 20}), 5
    )
    rows, columns = moving.robots.nonzero()
    inside = (abs((columns + 0.5) * moving.side - 10) < 1) & ((rows + 0.5) * moving.side < 6)
    assert not inside.any()
    assert len(rows) > 0.5 * moving.robots.size


def test_stopped_robots_are_there_and_see_nothing():
    apart = {"count": 2, "speed": 0.0, "placement": "points", "points": [[5.0, 5.0], [15.0, 15.0]]}
    scenario = Scenario(robots=apart, faults={"stopped": {"count": 1}}, run={"steps": 5})
    heat = heat_of(scenario, runs=1)
    assert value_at(heat, heat.robots, 5.0, 5.0) == value_at(heat, heat.robots, 15.0, 15.0) > 0
    assert sorted(value_at(heat, heat.sightings, each, each) for each in (5.0, 15.0)) == [0, 1]


@pytest.mark.slow
def test_opinions_are_shares_of_those_who_hold_one():
    scenario = Scenario(decision={"strategy": "cross-inhibition"}, robots={"count": 200})
    heat = heat_of(scenario, runs=1, seed=1, steps=(40, 40))
    swarm = Swarm(scenario, seed=1)
    swarm.advance(40)
    assert len(set(swarm.opinions.tolist())) == 3
    squares = (swarm.positions / heat.side).astype(int)
    for x, y in np.unique(squares, axis=0):
        held = swarm.opinions[(squares == (x, y)).all(axis=1)]
        expected = held[held >= 0].mean() if (held >= 0).any() else np.nan
        assert heat.feasible[y, x] == pytest.approx(expected, nan_ok=True)
    assert np.isnan(heat.feasible[heat.robots == 0]).all()


def test_the_figure_has_both_maps_over_the_plan():
    heat = heat_of(PLACE, runs=1, steps=(0, 20))
    axes = plot_heat(PLACE, heat).axes
    labels = ["robots per square unit", "robots that see the place", "opinions feasible (%)"]
    assert [each.get_ylabel() for each in axes[3:]] == labels
    for ax, values in zip(axes, (heat.robots, heat.sightings, 100 * heat.feasible), strict=False):
        shown, plan = ax.images
        assert np.ma.filled(shown.get_array(), 0).tolist() == np.nan_to_num(values).tolist()
        assert shown.get_extent() == plan.get_extent() == [0, 20, 0, 10]
        assert shown.zorder < plan.zorder
        assert shown.origin == "lower"


def test_wrong_spans_are_errors():
    with pytest.raises(FeasibeeError, match="steps = "):
        heat_of(Scenario(), steps=(5, 3))
    with pytest.raises(FeasibeeError, match=r"must lie between 0 and run\.steps = 1000"):
        heat_of(Scenario(), steps=(0, 1001))
    with pytest.raises(FeasibeeError, match="every = 0"):
        heat_of(Scenario(), every=0)
    with pytest.raises(FeasibeeError, match="runs = 0"):
        heat_of(Scenario(), 0)
