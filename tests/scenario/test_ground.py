"""Passable cells, pieces and shares of a place: two ways of finding them agree (model.md 6.20)."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario, ScenarioError
from feasibee.live.scene import settings_of
from feasibee.reference.place import ground_of as reference_ground
from feasibee.scenario.feasibility import explain
from feasibee.scenario.ground import ground_of, nearest, shares
from tests.commands import output_of
from tests.places import bitmap, random_cells, rectangle, rooms


def placed(closed, cell=0.5, **sections):
    """Return a scenario in a map."""
    sections.setdefault("robots", {"count": 9, "diameter": 0.4})
    return Scenario(place={"map": bitmap(closed, cell)}, **sections)


@pytest.mark.parametrize("seed", range(16))
def test_two_ways(seed):
    """Growth, pieces and shares of random maps are those of the reference, for slow and fast robots."""
    random = np.random.default_rng(seed)
    rows, columns = random.integers(12, 40, 2)
    robots = {
        "count": 30,
        "diameter": float(random.choice([0.2, 0.7, 1.3])),
        "speed": float(random.choice([0.3, 1.5])),
    }
    try:
        scenario = placed(random_cells(random, rows, columns, random.integers(0, 12)), robots=robots)
    except ScenarioError:
        return  # no room for robots of this size
    ground, reference = ground_of(scenario), reference_ground(scenario)
    passable = {(int(x), int(y)) for y, x in zip(*ground.passable.nonzero(), strict=True)}
    assert passable == reference.passable
    assert {cell: int(ground.pieces[cell[1], cell[0]]) for cell in passable} == reference.piece
    assert list(ground.robots.piece) == reference.robot_pieces
    assert list(ground.tasks.piece) == reference.task_pieces


def test_a_gap_that_a_step_leaps_joins_rooms():
    """Fast robots pass a neck without passable cells, if a quarter of a step leads across."""
    closed = np.zeros((40, 40), bool)
    closed[:, 20] = True
    closed[17:23, 20] = False
    ground = ground_of(placed(closed, 0.1, robots={"diameter": 0.2, "speed": 1.5}))
    assert not ground.passable[:, 20].any()
    assert ground.pieces.max() == 1
    closed[20:, 20] = True
    assert ground_of(placed(closed, 0.1, robots={"diameter": 0.2, "speed": 1.5})).pieces.max() == 2


@pytest.mark.parametrize(
    ("areas", "count", "found"),
    [
        ([0, 30, 30], 5, [1, 2, 1, 2, 1]),
        ([0, 75, 25], 4, [1, 1, 2, 1]),
        ([0, 1000, 3], 20, [1] * 20),
        ([0, 0, 7], 3, [2, 2, 2]),
    ],
)
def test_shares(areas, count, found):
    """Each robot goes to the piece that is farthest behind; a pocket gets none."""
    assert list(shares(np.array(areas), count)) == found


def test_nearest():
    """A task near a wall belongs to the piece next to it, and to none if that is too far."""
    pieces = np.zeros((9, 9), np.int32)
    pieces[:, 6:] = 2
    pieces[:, 0] = 1
    assert nearest(pieces, 4 * 9 + 4, 1) == 2
    assert nearest(pieces, 4 * 9 + 3, 4) == 1, "the first of equals"
    assert nearest(pieces, 4 * 9 + 4, 0) == 0


TWO = {"arena": {"boundary": "walls"}, "place": {"walls": rooms(0)}}
"""Two rooms, and no way from one to the other."""


def test_truth_by_piece():
    """Ten robots and ten tasks are feasible, but not with all robots in one room and a task in the other."""
    two = {**TWO, "place": {**TWO["place"], "zones": {"left": rectangle(0, 0, 9, 20)}}}
    assert explain(Scenario(**two, robots={"count": 10}, tasks={"count": 10})).feasible
    verdict = explain(
        Scenario(**two, robots={"count": 10}, tasks={"placement": "points", "points": [[5, 5], [15, 5]]})
    )
    assert verdict.feasible
    given = {"placement": "points", "points": [[15, 5 + k] for k in range(6)]}
    verdict = explain(Scenario(**two, robots={"count": 10}, tasks=given))
    assert (verdict.feasible, verdict.piece, verdict.violator[1:]) == (False, 2, (6, 5))
    assert verdict.to_dict()["piece"] == 2
    verdict = explain(Scenario(**two, robots={"count": 10, "zone": "left"}, tasks=given))
    assert (verdict.piece, verdict.violator[1:]) == (2, (6, 0))
    box = [rectangle(4, 4, 8, 5), rectangle(4, 7, 8, 8), rectangle(4, 4, 5, 8), rectangle(7, 4, 8, 8)]
    behind = {"placement": "points", "points": [[6, 6], [12, 12]]}  # no robot reaches the first
    verdict = explain(Scenario(**{**two, "place": {"walls": box}}, robots={"diameter": 1.9}, tasks=behind))
    assert (verdict.feasible, verdict.piece) == (False, 0)


def test_a_certificate_has_each_piece_and_where_it_is():
    """A wall of 0.2 in the middle: robots of diameter 1 keep 0.6 from it and from the edges."""
    verdict = explain(Scenario(**TWO, robots={"count": 11}, tasks={"count": 9}))
    one, other = verdict.pieces
    assert (one.x, one.y, other.x) == ((0.6, 9.3), (0.6, 19.4), (10.7, 19.4))
    assert [sum(each.assignment.values()) for each in (one, other)] == [5, 4]
    assert sum(verdict.assignment.values()) == 9
    said = verdict.to_dict()
    assert [(row["piece"], row["count"]) for row in said["assignment"]] == [(1, 5), (2, 4)]
    assert [(each["piece"], each["x"]) for each in said["pieces"]] == [(1, one.x), (2, other.x)]
    whole = explain(Scenario(**TWO | {"place": {"walls": rooms(4)}}))
    assert (whole.pieces, whole.to_dict().keys()) == ((), {"feasible", "assignment"})


SAID = "tasks, each for any one robot: 12; robots: 10 of 20."
SPLIT = Scenario(**TWO, tasks={"placement": "points", "points": [[15.0, 1.0 + k] for k in range(12)]})


def test_the_command_and_the_page_name_the_piece_that_lacks_robots(tmp_path):
    (file := tmp_path / "split.toml").write_text(SPLIT.to_toml())
    where = "in piece 2 (x 10.7 to 19.4, y 0.6 to 19.4)"
    assert output_of("show", "truth", file) == f"Infeasible {where}: {SAID}\n"
    assert settings_of(SPLIT)["proof"] == f"{where}: 10 of 20 robots, 12 of 12 tasks"
    found = explain(SPLIT).to_dict()
    assert (found["piece"], found["violator"]["demand"], len(found["pieces"])) == (2, 12, 1)
    output = output_of("show", "truth", file, "--set", 'tasks.placement="uniform"', "--set", "tasks.count=20")
    table = [line for line in output.splitlines() if "│" in line]
    assert [line.split("│")[1].strip()[:4] for line in table] == ["1 (x", "2 (x"]


HALL = {"arena": {"boundary": "walls", "side": 10.0}}


def test_lattice_sites_are_in_the_zone():
    """The lattice of last resort has sites in cells of the zone only, those of the reference among them."""
    dock = {"zones": {"dock": rectangle(0, 0, 4, 10)}, "cell": 0.25}
    scenario = Scenario(**HALL, place=dock, robots={"zone": "dock", "count": 5, "diameter": 1.0})
    ((xs, ys),) = ground_of(scenario).lattice
    unit = float(scenario.plan.unit)
    assert xs.max() * unit < 4.0
    assert len(xs) == len({*zip(xs.tolist(), ys.tolist(), strict=True)})
    reference = reference_ground(scenario)
    sites = set(zip(xs.tolist(), ys.tolist(), strict=True))
    assert set(reference.lattice) <= sites
