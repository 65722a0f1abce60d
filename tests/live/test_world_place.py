"""The world of a page in a place against the engine and the reference, bit for bit."""

from __future__ import annotations

import base64
import zlib

import numpy as np
import pytest

from feasibee import Scenario, ScenarioError
from feasibee.live.page import page_of
from feasibee.live.world import build
from feasibee.live.world.lowering import CELL_BITS, CELLS_LIMIT, check_scenario, numbers_of, place_of
from feasibee.reference.swarm import play as played
from feasibee.scenario.feasibility import truth
from feasibee.scenario.ground import ground_of
from feasibee.strategies import STRATEGIES, sight
from feasibee.strategies.certified import NEVER
from tests.live.test_world import compare, constants
from tests.places import bitmap, random_cells, rectangle

NAMES, ZONES = list(STRATEGIES), ("dock", "shelves")


def scenarios(draw, number, steps, cells, sides):
    """Yield random swarms, one strategy after the other, in random places with cells for robots and tasks."""
    found = 0
    for tried in range(10 * number):
        name, cell = NAMES[tried % len(NAMES)], float(draw.choice(cells))
        width, height = sides[draw.integers(len(sides))]
        shape = round(height / cell), round(width / cell)
        zones = {zone: rectangle(*draw.choice([0.0, 1.5], 2), *draw.choice([5.0, 6.5], 2)) for zone in ZONES}
        try:
            made = Scenario(
                place={
                    "map": bitmap(random_cells(draw, *shape, draw.integers(1, 7)), cell),
                    "walls": [rectangle(1.3, 2.1, 2.4, 3.2)],
                    "keepout": bitmap(random_cells(draw, *shape, 1), cell),
                    "zones": zones,
                },
                robots={
                    "count": int(draw.integers(1, 30)),
                    "diameter": float(draw.choice([0.3, 0.5, 1.0])),
                    "speed": float(draw.choice([0.4, 1.0, 2.7])),
                    "know_count": STRATEGIES[name].needs_count,
                    "zone": (None, "dock")[draw.integers(2)],
                },
                tasks={"count": int(draw.integers(0, 40)), "zone": (None, "shelves")[draw.integers(2)]},
                sensing={"range": float(draw.choice([2.0, 5.0])), "miss": float(draw.choice([0.0, 0.2]))},
                radio={"range": float(draw.choice([2.0, 9.0])), "walls": float(draw.choice([0.0, 0.6, 1.0]))},
                decision={"strategy": name},
                run={"steps": steps},
            )
        except ScenarioError:  # nowhere to stand, or a strategy that can't be in a place
            continue
        yield made.with_flooding((NEVER, 20)[draw.integers(2)])
        if (found := found + 1) == number:
            return
    raise AssertionError(f"only {found} of {number} places")


@pytest.mark.slow  # it compiles the general engine
def test_runs_in_generated_places_equal_the_engines(play):
    draw = np.random.default_rng(28)
    runs = [
        (each, k, 3 * k)
        for k, each in enumerate(
            scenarios(draw, 4 * len(NAMES), 150, [0.1, 0.25, 0.5], [(20.0, 20.0), (12.0, 7.5)])
        )
    ]
    pieces = [len(set(ground_of(each).robots.piece)) for each, _, _ in runs]
    assert max(pieces) > 1  # some places have several
    compare(play, runs)


@pytest.mark.slow
def test_runs_in_generated_places_equal_the_references(play):
    draw = np.random.default_rng(29)
    runs = [(each, 5, k) for k, each in enumerate(scenarios(draw, 12, 40, [0.5], [(10.0, 7.5)]))]
    for (scenario, seed, run), (flags, places, _) in zip(runs, play(runs), strict=True):
        for step, swarm in enumerate(played(scenario, seed, run)):
            held = [int(robot.mind.opinion == 1) for robot in swarm.robots]
            assert (flags[step] & 1).tolist() == held, (scenario.decision.strategy, step)
        unit = numbers_of(scenario)["unit"]
        assert [[float(x * unit), float(y * unit)] for x, y in places] == [
            list(swarm.world.in_units(robot.place)) for robot in swarm.robots
        ]


TWO_ROOMS = Scenario(
    arena={"side": (12.0, 6.0), "boundary": "walls"},
    place={"walls": [rectangle(3.9, 0.0, 4.1, 6.0)]},
    robots={"count": 12, "diameter": 0.5},
    run={"steps": 1},
)


def test_the_page_has_the_bits_and_the_limits_of_the_world():
    text = (build.FOLDER / "place.h").read_text("utf-8")
    bits = {name.upper(): 1 << k for k, name in enumerate(CELL_BITS)}
    assert constants(text, "cell") == bits | {"WALL": sight.WALL, "TASKS_THERE": sight.TASKS}
    given = place_of(TWO_ROOMS.replace({"radio.walls": 0.5}))
    columns, rows, bits, *halves = given["numbers"]
    assert (columns, rows) == (120, 60)
    assert columns * 2**bits <= 2**31 < columns * 2 ** (bits + 1)
    unit = numbers_of(TWO_ROOMS)["unit"]
    reaches = [
        np.sqrt(high * 2.0**32 + low) * unit for high, low in zip(halves[::2], halves[1::2], strict=True)
    ]
    assert reaches == pytest.approx([2.0 * 0.5**k for k in range(1, 9)], rel=1e-6)
    assert set(zlib.decompress(base64.b64decode(given["cells"]))[-columns * rows :]) == {0, 1, 2}  # pieces


@pytest.mark.parametrize(("robots", "tasks"), [(12, 12), (12, 11), (1, 1), (1, 2), (2, 7), (30, 30), (13, 6)])
def test_the_truth_is_per_piece(play, robots, tasks):
    scenario = TWO_ROOMS.replace({"robots.count": robots, "tasks.count": tasks})
    ground = ground_of(scenario)
    missing = sum(
        max(0, int((ground.tasks.piece == piece).sum() - (ground.robots.piece == piece).sum()))
        for piece in (1, 2)
    )
    ((_, _, found),) = play([(scenario, 0, 0)])
    assert found == missing
    assert truth(scenario) == (missing == 0)


@pytest.mark.parametrize("name", ["dmmd", "census"])
def test_a_place_that_changes_equals_the_engines(play, name):
    one_room = {"place.walls": [rectangle(3.9, 0.0, 4.1, 4.0)], "run.steps": 60, "decision.strategy": name}
    events = [{"step": 0, "robots": 3}, {"step": 9, "tasks": -18, "robots": -9}, {"step": 31, "tasks": 25}]
    events.append({"step": 40, "robots": 15})
    zones = {"place.zones": {"dock": rectangle(0.0, 0.0, 3.0, 6.0)}, "robots.zone": "dock"}
    scenario = TWO_ROOMS.replace({**one_room, **zones, "events": events})
    compare(play, [(scenario, run, run) for run in range(3)])


def test_a_hall_of_forty_obstacles_makes_the_page_20_kb_larger_at_most():
    draw, walls = np.random.default_rng(4), []
    for _ in range(40):
        middle, (wide, high), turn = (
            draw.uniform(2, 18, 2),
            draw.uniform(0.5, 2, 2),
            draw.uniform(0, np.pi / 2),
        )
        across, along = (
            wide / 2 * np.array([np.cos(turn), np.sin(turn)]),
            high / 2 * np.array([-np.sin(turn), np.cos(turn)]),
        )
        corners = (middle + i * across + j * along for i, j in ((1, 1), (-1, 1), (-1, -1), (1, -1)))
        walls.append([[round(x, 2), round(y, 2)] for x, y in corners])
    hall = Scenario(arena={"side": 20.0, "boundary": "walls"}, robots={"diameter": 0.5})
    shelves = hall.replace({"place.walls": walls, "place.cell": 0.05})
    assert shelves.plan.walls.shape == (400, 400)
    assert len(page_of(shelves).encode()) - len(page_of(hall).encode()) <= 20_000


def test_a_place_in_too_many_pieces_is_refused():
    lines = np.arange(64) % 4 == 0
    closed = lines[:, None] | lines[None, :]  # rooms of 3 x 3 cells, whose middle is passable
    islands = Scenario(
        arena={"side": 64.0, "boundary": "walls"},
        place={"map": bitmap(closed, 1.0)},
        robots={"diameter": 0.01, "speed": 0.01},
    )
    with pytest.raises(ScenarioError, match="in 256 pieces, above the limit of 255 in a page"):
        check_scenario(islands)


def test_a_place_beyond_a_page_is_refused():
    fine = Scenario(
        arena={"side": 20.0, "boundary": "walls"}, place={"zones": {"all": [[0, 0], [20, 0], [20, 20]]}}
    )
    check_scenario(fine)
    with pytest.raises(ScenarioError) as told:
        check_scenario(fine.replace({"place.cell": 0.025}))
    assert str(told.value) == (
        f"place.cell = '800 x 800 cells': a page has at most {CELLS_LIMIT:,}; use larger cells, or use "
        "feasibee watch"
    )
