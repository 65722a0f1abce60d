"""Rooms of a place, swarms that split into them, and what helps (docs/places.md)."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario
from feasibee.scenario.ground import ground_of
from feasibee.studies.assess import assess, changes_of
from feasibee.studies.report import sections
from feasibee.studies.rooms import changes_of_place, is_split, rooms_in_words, rooms_of, split_of, splits_of
from tests.places import rectangle, rooms


def world(walls, **changes):
    """Return a hall of 20 by 20 with these walls."""
    hall = {"arena.side": 20.0, "arena.boundary": "walls", "place.walls": walls, "run.steps": 300}
    bodies = {"robots.diameter": 0.5, "robots.avoid_collisions": True, "robots.contact": "deflect"}
    zone = {"place.zones": {"left": [rectangle(0.0, 0.0, 9.0, 20.0)]}}
    return Scenario().replace({**hall, **bodies, **zone, "tasks.count": 16, **changes})


@pytest.mark.parametrize(("door", "number"), [(1.0, 2), (2.0, 2), (4.0, 1), (0.0, 2)])
def test_rooms_end_at_doors_in_which_no_disc_of_half_the_sight_fits(door, number):
    found = rooms_of(world(rooms(door)))
    assert found.max() == number
    if number == 2:
        assert {int(each) for each in np.unique(found[:, :90])} == {0, 1}
        assert {int(each) for each in np.unique(found[:, 110:])} == {0, 2}


def test_obstacles_alone_make_no_rooms():
    assert rooms_of(world([rectangle(4.0, 4.0, 6.0, 6.0), rectangle(12.0, 9.0, 13.0, 13.0)])).max() == 1


@pytest.mark.parametrize(
    ("held", "split"),
    [
        ([(1, 1), (1, 1), (2, 0), (2, 0)], True),
        ([(1, 1), (1, 1), (2, 1), (2, 1)], False),
        ([(1, 1), (1, 1), (2, 0)], False),
        ([(1, 1), (1, 1), (0, 0), (0, 0)], False),
        ([(1, 1), (1, 0), (2, 0), (2, 0)], False),
        ([(1, 1), (1, 1), (1, 0), (2, 0), (2, 0), (2, -1)], True),
    ],
)
def test_a_swarm_is_split_if_two_rooms_have_opposite_majorities(held, split):
    where, opinions = np.array(held).T
    assert is_split(where, opinions.astype(np.int8)) is split


def test_a_wider_door_is_wider_by_a_unit_and_all_else_stays():
    narrow = world(rooms(1.0))
    change = changes_of_place(narrow)["doors wider by 1"]
    wide = narrow.replace(change)
    opened = narrow.plan.walls & ~wide.plan.walls
    assert not (wide.plan.walls & ~narrow.plan.walls).any()
    assert np.flatnonzero(opened.any(axis=0)).tolist() == [99, 100]
    across = [int(ground_of(each).passable[:, 100].sum()) * 0.1 for each in (narrow, wide)]
    assert across[1] - across[0] == pytest.approx(1.0, abs=0.31)


def test_what_may_help_depends_on_the_place():
    hall = world([rectangle(4.0, 4.0, 6.0, 6.0)])
    assert list(changes_of_place(hall)) == ["radio through walls"]
    docked = world(rooms(1.0), **{"robots.zone": "left", "radio.walls": 1.0})
    assert list(changes_of_place(docked)) == ["robots that start everywhere", "doors wider by 1"]
    assert changes_of_place(docked).keys() <= changes_of(docked).keys()
    assert changes_of_place(Scenario()) == {}


@pytest.mark.slow
def test_a_narrow_door_splits_swarms_and_a_wide_one_less():
    found = splits_of(world(rooms(1.0)), seed=1, runs=40)
    own, wider = found[""], found["doors wider by 1"]
    assert own == split_of(world(rooms(1.0)), 1, 40)
    assert own.split.estimate > wider.split.estimate
    assert 0 < own.passages < wider.passages
    lines = rooms_in_words(found)
    assert lines[0].endswith("Robots decide on their room's ratio.")
    assert len(lines) == 3
    assert splits_of(world(rooms(6.0)), seed=1, runs=2) == {}
    assert rooms_in_words({}) == []
    assert split_of(world(rooms(0.0)), 1, 3).passages == 0


@pytest.mark.slow
def test_an_assessment_in_a_place_warns_of_rooms():
    found = assess(world(rooms(1.0)), runs=20, seed=1)
    assert found.rooms[""].rooms == 2
    assert "The place has 2 rooms" in str(sections(found))
    assert found.to_dict()["rooms"][""]["rooms"] == 2
    assert "map" in found.recommendation.excluded
