"""The map: which cells a robot knows, what it declares, whom it believes, and what a message costs."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from minds import knowing, task

from feasibee import Scenario
from feasibee.scenario.runs import Runs
from feasibee.scenario.setting import setting_from
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import map as map_
from feasibee.strategies.map import CELLS, COLUMNS, DOWN, ROW, ROWS, VALUES, VERDICT

UNSURE, INFEASIBLE, FEASIBLE = 0, 1, 2
"""Verdicts."""


def robot_of(number=0, *, robots=20, **changes):
    """Return the knowledge of a robot."""
    return knowing("map", (robots, 90), number, **changes)


def look(own, x, y, *tasks):
    """Let a robot explore for a step at a place, with these tasks in sight; return what it declares."""
    own.move_to(x, y)
    own.observe(tasks)
    return own.declare()


def values(own):
    """Return the values of the cells that a robot knows, by column and row."""
    columns, rows = own.words[COLUMNS], own.words[ROWS]
    words = own.words[VALUES : VALUES + columns * rows]
    return {(k % columns, k // columns): word - 1 for k, word in enumerate(words) if word}


def message_of(cells, like, verdict=UNSURE, row=0):
    """Return a message with the values of some cells, by column and row of the message."""
    columns = like.words[COLUMNS]
    message = [0] * map_.message_words(like.me.setting)
    message[VERDICT], message[ROW] = verdict, row
    for (column, down), value in cells.items():
        message[CELLS + down * columns + column] = value + 1
    map_.summarize(message)
    return tuple(message)


def everywhere(like, value=0):
    """Return the cells of a whole map, of one value each."""
    return {(c, r): value for c in range(like.words[COLUMNS]) for r in range(like.words[ROWS])}


# --- Cells ---


@pytest.mark.parametrize(
    ("size", "cell", "cells", "parts"),
    [
        ((20, 20), 1.0, (20, 20), (2, 2)),
        ((31.6, 31.6), 1.0, (32, 32), (2, 2)),
        ((7.3, 20), 2.0, (4, 10), (4, 4)),
        ((20, 10), 0.4, (50, 25), (1, 1)),
        ((20, 10), 1e9, (1, 1), (31, 20)),
        ((20, 10), 0.0, (1000, 1000), (1, 1)),
        ((20, 10), -3.0, (1000, 1000), (1, 1)),
        ((20, 10), 1e-300, (1000, 1000), (1, 1)),
    ],
)
def test_cells_divide_the_arena_evenly_and_sub_cells_the_cells(size, cell, cells, parts):
    setting = setting_from((20, 20), (1, 1), False, None, (cell, 0.0, 0.0), size=size)
    assert (map_.columns_of(setting), map_.rows_of(setting)) == cells
    assert (map_.across_of(setting), map_.down_of(setting)) == parts
    assert map_.words(setting) == VALUES + cells[0] * cells[1] * (2 + parts[1]) + 1
    assert map_.message_words(setting) == CELLS + cells[0] * cells[1]


@pytest.mark.parametrize("rows", [-1.0, 0.9, 10.0, 1e300])
def test_a_number_of_rows_that_means_nothing_is_the_whole_map(rows):
    assert len(robot_of(rows=rows, cell=2.0).message()) == CELLS + 100


def searched(own, places, per_side):
    """Return the cells of which all sub-cells have their four corners in sight of one place, by numpy."""
    setting = own.me.setting
    sides = np.array([setting.width, setting.height])
    cells = np.array([own.words[COLUMNS], own.words[ROWS]])
    size = sides / cells / per_side
    columns, rows = cells * per_side
    corners = np.array([(c, r) for r in range(rows) for c in range(columns)])[:, None] + np.array(
        [(0, 0), (1, 0), (0, 1), (1, 1)]
    )
    marked = np.zeros(len(corners), bool)
    images = [(0, 0)] if setting.walled else [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)]
    for place in places:
        for image in images:
            distances = np.hypot(*np.moveaxis(corners * size + np.array(image) * sides - place, -1, 0))
            marked |= (distances <= setting.sight * (1 - 1e-6)).all(axis=1)
    blocks = marked.reshape(cells[1], per_side[1], cells[0], per_side[0]).all(axis=(1, 3))
    return {(int(c), int(r)) for r, c in np.argwhere(blocks)}


@pytest.mark.quick(3)
@pytest.mark.parametrize("walled", [False, True])
@pytest.mark.parametrize(
    ("size", "cell", "sight", "per_side"),
    [
        ((20.0, 20.0), 1.0, 2.0, (2, 2)),
        ((31.6, 7.3), 1.0, 2.0, (2, 2)),
        ((7.3, 31.6), 2.0, 2.0, (4, 4)),
        ((10.0, 8.0), 0.5, 3.9, (1, 1)),
        ((6.0, 6.0), 3.0, 1.0, (12, 12)),
        ((4.0, 4.0), 9.0, 1.9, (9, 9)),
    ],
)
def test_a_cell_is_known_once_all_its_sub_cells_were_wholly_in_sight(size, cell, sight, per_side, walled):
    """Of one place each: against a computation of all corners, around the torus too."""
    generator = np.random.default_rng(5)
    own = robot_of(cell=cell, size=size, sight=sight, walled=walled)
    assert own.words[DOWN] == per_side[1]
    places = generator.uniform((0, 0), size, (150, 2))
    for seen in range(150):
        look(own, *places[seen])
        if seen in (0, 3, 12, 40, 149):
            assert set(values(own)) == searched(own, places[: seen + 1], per_side), seen
    assert len(values(own)) > 0


def test_a_robot_that_disseminates_searches_nothing():
    own = robot_of()
    own.end_step(explores=False)
    look(own, 10.0, 10.0)
    assert values(own) == {}
    own.end_step(explores=True)
    look(own, 10.0, 10.0)
    assert (9, 10) in values(own)


def test_the_value_of_a_cell_is_the_number_of_tasks_seen_there_by_name():
    own = robot_of()
    look(own, 5.0, 5.0, task(1, 5.1, 5.1), task(1, 5.1, 5.1), task(2, 5.9, 5.9), task(3, 6.9, 5.0))
    look(own, 5.0, 5.0, task(1, 5.1, 5.1), task(3, 6.9, 5.0))
    assert values(own)[5, 5] == 2
    assert values(own)[4, 4] == 0
    assert (6, 5) not in values(own)  # its far corners were out of sight
    look(own, 6.0, 5.0)
    assert values(own)[6, 5] == 1  # what it saw before it searched the cell counts


@pytest.mark.parametrize(
    ("x", "y", "walled", "cell"),
    [
        (1.0, 0.0, False, (1, 0)),
        (np.nextafter(1.0, 0.0), 19.999, False, (0, 19)),
        (20.0, 20.0, True, (19, 19)),
        (0.0, 20.0, True, (0, 19)),
    ],
)
def test_a_task_on_a_border_is_in_one_cell(x, y, walled, cell):
    own = robot_of(walled=walled)
    for place in [(a, b) for a in (0.5, 19.5) for b in (0.5, 19.5)]:
        look(own, *place, task(1, float(x), float(y)))
    assert [each for each, value in values(own).items() if value] == [cell]


# --- Declaring ---


def test_feasible_takes_the_whole_map():
    own = robot_of(cell=10.0)
    for cells, said in (({(0, 0): 20, (1, 0): 0, (0, 1): 0}, -1), ({(1, 1): 0}, 1)):
        own.merge(message_of(cells, own), 3)
        assert look(own, 5.0, 5.0) == said


@pytest.mark.parametrize(("more", "declared"), [(0, -1), (1, 0)])
def test_infeasible_counts_the_known_cells_and_the_tasks_seen_in_others(more, declared):
    own = robot_of(robots=7)
    own.merge(message_of({(15, 15): 4, (16, 15): 1 + more}, own), 3)
    assert look(own, 5.9, 5.0, task(1, 7.8, 5.0), task(2, 3.95, 5.1)) == declared
    assert own.counted() == ([7], [7 + more])


def test_a_task_seen_in_a_cell_that_is_known_counts_once():
    own = robot_of(robots=2)
    for sender, things in ((3, [task(1, 7.8, 5.0), task(2, 7.9, 5.0)]), (4, [task(1, 7.8, 5.0)])):
        own.merge(message_of({(7, 5): 2}, own), sender)
        assert look(own, 6.0, 5.0, *things) == -1


def test_a_known_cell_stays_known():
    own = robot_of()
    own.merge(message_of({(1, 1): 3}, own), 3)
    own.merge(message_of({(1, 1): 5, (2, 1): 1}, own), 4)
    look(own, 1.5, 1.5)
    assert (values(own)[1, 1], values(own)[2, 1]) == (3, 1)


def test_a_robot_that_is_sure_sends_its_verdict_and_others_adopt_it():
    own, other = robot_of(cell=10.0), robot_of(1, cell=10.0)
    own.merge(message_of(everywhere(own, 5), own), 3)
    assert look(own, 5.0, 5.0) == 1
    assert own.message()[VERDICT] == FEASIBLE
    other.merge(own.message(), 0)
    assert look(other, 5.0, 5.0) == 1
    assert values(other) == {}
    liar = message_of({}, other, INFEASIBLE)
    own.merge(liar, 9)
    assert own.message()[VERDICT] == FEASIBLE


# --- Rows ---


@pytest.mark.parametrize(("rows", "firsts"), [(1, [*range(10)]), (4, [0, 4, 6]), (9, [0, 1]), (10, [0])])
def test_rows_are_sent_in_turn(rows, firsts):
    own, other = robot_of(cell=2.0, rows=float(rows)), robot_of(1, cell=2.0, rows=float(rows))
    look(own, 10.0, 10.0, task(1, 9.0, 9.0))
    look(own, 19.0, 19.0)
    look(own, 1.0, 1.0)
    known = values(own)
    assert len(known) > 0
    messages = [own.message() for _ in range(2 * len(firsts))]
    assert [message[ROW] for message in messages] == 2 * firsts
    assert {len(message) for message in messages} == {CELLS + 10 * rows}
    for message in messages[: len(firsts)]:
        other.merge(message, 0)
    assert values(other) == known


# --- Bits ---


FIRST = {(c, 0): 0 for c in range(10)}
LACKING = {**{(c, 0): 0 for c in range(9)}, (0, 0): 5}
FOUR = {(c, r): int(r < 2) for c in range(10) for r in range(4) if (c, r) != (9, 3)}
LENGTHS = [  # parameters, cells, verdict; bits: id, verdict, row, whether whole, cells, values
    ({"cell": 2.0}, {}, FEASIBLE, 5 + 2),
    ({"cell": 1.25, "rows": 1.0}, {}, UNSURE, 5 + 1 + 4 + 1 + 16),  # sixteen rows, told apart by four bits
    ({"cell": 2.0, "rows": 1.0}, FIRST, UNSURE, 5 + 1 + 4 + 1 + 10),
    ({"cell": 2.0, "rows": 1.0}, LACKING, UNSURE, 5 + 1 + 4 + 1 + 10 + 9 + 5),
    ({"cell": 2.0, "rows": 4.0}, FOUR, UNSURE, 5 + 1 + 4 + 1 + 40 + 39 + 20),
]


@pytest.mark.parametrize(("parameters", "cells", "verdict", "bits"), LENGTHS)
def test_a_message_costs_what_it_takes_to_write(parameters, cells, verdict, bits):
    """One row of cells of 2 takes at most 34 bits with 5 tasks in it, four rows at most 110 with 20."""
    own = robot_of(**parameters)
    assert own.bits(message_of(cells, own, verdict)) == bits


# --- Byzantine robots ---


@pytest.mark.parametrize("tolerates", [0.0, 1.0])
def test_a_liar_for_feasible_sends_a_map_without_tasks(tolerates):
    own = robot_of(tolerates=tolerates)
    look(own, 3.0, 3.0, task(1, 3.0, 3.1))
    lie = own.lie(own.message(), 1, ())
    assert lie[VERDICT] == FEASIBLE
    if tolerates:
        assert lie == message_of(everywhere(own), own, FEASIBLE)


@pytest.mark.parametrize("rows", [0.0, 1.0])
def test_a_liar_for_infeasible_sends_n_plus_one_tasks_in_the_first_cell(rows):
    """In each message, in addition to what it knows of the first rows."""
    own = robot_of(tolerates=1.0, rows=rows)
    look(own, 3.0, 1.0, task(1, 3.0, 1.1))
    known = {cell: value for cell, value in values(own).items() if not rows or cell[1] == 0}
    assert (0, 0) not in known
    assert known
    assert own.lie(own.message(), 0, ()) == message_of({(0, 0): 21} | known, own, INFEASIBLE)
    if rows:
        assert own.lie(own.message(), 0, ()) == message_of({(0, 0): 21}, own, INFEASIBLE)


def test_one_liar_makes_a_robot_wrong_that_tolerates_none():
    for feasible in (0, 1):
        own, liar = robot_of(), robot_of(1)
        own.merge(liar.lie(liar.message(), feasible, ()), 1)
        assert look(own, 5.0, 5.0) == feasible


TOLD = [  # f; values of one cell that neighbours send in turn, by sender; and what is adopted
    *((f, [*(2 * [*((each, 2) for each in range(1, f + 1))]), (8, 3)], None) for f in (1, 2, 3)),
    *((f, [*((each, 2) for each in range(1, f + 1)), (8, 3), (9, 2)], 2) for f in (1, 2, 3)),
    (2, [(s, v) for v in (1, 2, 3) for s in (1, 2)] + [(5, 1), (6, 2)], None),  # only the latest of each
    (2, [(s, v) for v in (1, 2, 3) for s in (1, 2)] + [(5, 1), (6, 2), (6, 3)], 3),
]


@pytest.mark.parametrize(("f", "told", "value"), TOLD)
def test_a_value_is_adopted_once_more_than_f_neighbours_say_the_same_last(f, told, value):
    own = robot_of(cell=10.0, tolerates=float(f))
    for sender, each in told:
        own.merge(message_of({(1, 0): each}, own), sender)
    assert values(own) == ({} if value is None else {(1, 0): value})
    assert own.counted() == ([20], [value or 0])


@pytest.mark.parametrize(("tolerates", "needed"), [(-3.0, 1), (0.9, 1), (1.5, 2), (7.0, 8), (1e300, 99)])
def test_a_number_of_tolerated_robots_that_is_not_whole_or_not_possible(tolerates, needed):
    own = robot_of(cell=10.0, tolerates=tolerates)
    adopted = []
    for sender in range(1, 20):
        own.merge(message_of({(0, 1): 1}, own), sender)
        adopted.append(bool(values(own)))
    assert adopted == [sender >= needed for sender in range(1, 20)]


def test_a_verdict_is_adopted_from_more_than_f_different_neighbours():
    own = robot_of(cell=10.0, tolerates=1.0)
    for sender, verdict in ((4, FEASIBLE), (4, FEASIBLE), (5, INFEASIBLE)):
        own.merge(message_of({}, own, verdict), sender)
        assert look(own, 5.0, 5.0) == -1
    own.merge(message_of({}, own, INFEASIBLE), 4)
    assert look(own, 5.0, 5.0) == 0


def test_what_a_robot_searches_it_needs_nobody_to_confirm():
    own = robot_of(tolerates=3.0)
    look(own, 5.0, 5.0, task(1, 5.1, 5.1))
    assert values(own)[5, 5] == 1


def test_a_robot_that_tolerates_liars_sends_its_map_with_its_verdict():
    own, other = (robot_of(k, cell=10.0, tolerates=1.0) for k in range(2))
    for sender in (3, 4):
        own.merge(message_of(everywhere(own), own), sender)
    assert look(own, 5.0, 5.0) == 1
    other.merge(own.message(), 0)
    other.merge(message_of(everywhere(own), own), 5)
    assert values(other) == everywhere(own)


# --- Soundness ---


def world(rng):
    """Return a small world without missed sightings, and with no more liars than robots tolerate."""
    robots, sight = rng.randint(2, 24), rng.uniform(0.6, 2.0)
    liars = rng.randint(0, min(3, robots // 3))
    changes = {
        "arena.side": rng.choice([[7.3, 7.3], [9.0, 5.1], [8.0, 8.0], [4.0, 11.3]]),
        "arena.boundary": rng.choice(["walls", "torus"]),
        "robots.count": robots,
        "robots.know_count": True,
        "robots.speed": rng.uniform(0.2, 0.9),
        "robots.avoid_collisions": rng.choice([True, False]),
        "robots.diameter": 0.1,
        "tasks.count": max(0, robots + rng.randint(-2, 3)),
        "tasks.placement": rng.choice(["uniform", "clusters"]),
        "tasks.spread": 0.5,
        "sensing.range": sight,
        "sensing.observation": rng.choice(["repeated", "unique"]),
        "radio.range": rng.uniform(0.5, 2.0),
        "radio.loss": rng.choice([0.0, 0.5]),
        "decision.strategy": "map",
        "decision.exploration": rng.uniform(1, 10),
        "decision.gain": rng.uniform(1, 10),
        "decision.parameters.cell": sight * rng.choice([0.25, 0.5, 0.8, 1.3, 3.0]),
        "decision.parameters.rows": float(rng.randint(0, 3)),
        "decision.parameters.tolerates": float(rng.randint(liars, liars + 1)),
        "faults.byzantine": math.floor(1e6 * liars / robots) / 1e6,
        "faults.byzantine_says": rng.choice(["colluding", "opposite", "random"]),
        "run.steps": 200,
    }
    return Scenario().replace(changes)


@pytest.mark.slow
def test_no_robot_ever_declares_wrongly():
    """In small worlds: odd sides, walls, clusters, lost messages, and as many liars as they tolerate."""
    declared, rng = 0, random.Random(1)
    for seed in range(200):
        scenario = world(rng)
        record = simulate_record(scenario, Runs(6, seed))
        feasible = scenario.tasks.count <= scenario.robots.count
        assert not (record.declared_infeasible if feasible else record.declared_feasible).any(), scenario
        declared += (record.declared_feasible + record.declared_infeasible).any()
    assert declared > 5  # so that something was tried


# --- How soon, and how surely ---


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tasks", "liars", "median", "most"),
    [(20, 0, 150, 195), (21, 0, 100, 125), (20, 1, 220, 260), (20, 3, 290, 330), (21, 3, 290, 330)],
)
def test_more_than_90_percent_declare_rightly_in_time(tasks, liars, median, most):
    """400 swarms: none wrong, with as many colluding liars as robots tolerate."""
    scenario = Scenario().replace(
        {
            "decision.strategy": "map",
            "robots.know_count": True,
            "tasks.count": tasks,
            "faults.byzantine": liars / 20,
            "faults.byzantine_says": "colluding",
            "decision.parameters.tolerates": float(liars),
            "run.steps": 600,
        }
    )
    record = simulate_record(scenario, Runs(400, 1))
    right, wrong = record.declared_feasible, record.declared_infeasible
    if tasks > 20:
        right, wrong = wrong, right
    assert not wrong.any()
    assert (right > 0.9 * (20 - liars)).all()
    assert np.percentile(record.declare_step, 50) <= median
    assert np.percentile(record.declare_step, 95) <= most
