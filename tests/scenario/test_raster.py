"""The cells that polygons cover, against the definition in exact fractions, cell by cell."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from feasibee.scenario.cells import centred, touched

SHAPE = 5, 6
TENTH = Fraction(1, 10)
coordinates = st.integers(-4, 28).map(lambda quarters: Fraction(quarters, 4))
rings = st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=6)


def drawn(cells):
    return ["".join(".#"[int(each)] for each in row) for row in cells[::-1]]


def edges_of(ring):
    return pairwise([*ring, ring[0]])


def stretch(edge, column, row):
    """Return the part of an edge, from 0 to 1, in a closed cell; None if it has no length."""
    low, high = Fraction(0), Fraction(1)
    for start, end, side in zip(*edge, (column, row), strict=True):
        begin, way = start - side, end - start
        if way == 0:
            if not 0 <= begin <= 1:
                return None
            continue
        one, other = sorted((-begin / way, (1 - begin) / way))
        low, high = max(low, one), min(high, other)
    return (low, high) if low < high and edge[0] != edge[1] else None


def runs_through(edge, column, row):
    """Return whether an edge has a point in an open cell: then so has the middle of its part in it."""
    part = stretch(edge, column, row)
    if part is None:
        return False
    middle = sum(part) / 2
    return all(
        0 < start + middle * (end - start) - side < 1
        for start, end, side in zip(*edge, (column, row), strict=True)
    )


def is_inside(point, polygon):
    """Return whether an odd number of edges is right of a point; an edge has its lower end, not its upper."""
    x, y = point
    crossings = 0
    for ring in polygon:
        for (ax, ay), (bx, by) in edges_of(ring):
            if (ay > y) != (by > y):
                crossings += x < ax + (y - ay) * (bx - ax) / (by - ay)
    return crossings % 2 == 1


def has_no_area(ring):
    return sum(ax * by - bx * ay for (ax, ay), (bx, by) in edges_of(ring)) == 0


def is_covered(polygon, column, row):
    edges = [(edge, has_no_area(ring)) for ring in polygon for edge in edges_of(ring)]
    return any(
        runs_through(edge, column, row) or (thin and stretch(edge, column, row) and is_level(edge))
        for edge, thin in edges
    )


def is_level(edge):
    return edge[0][0] == edge[1][0] or edge[0][1] == edge[1][1]


@given(polygons=st.lists(st.lists(rings, min_size=1, max_size=2), max_size=2))
def test_cells_are_those_of_the_definition(polygons):
    middles, covered = (np.zeros(SHAPE, bool) for _ in range(2))
    half = Fraction(1, 2)
    for polygon, row, column in product(polygons, range(SHAPE[0]), range(SHAPE[1])):
        inside = is_inside((column + half, row + half), polygon)
        middles[row, column] |= inside
        covered[row, column] |= inside or is_covered(polygon, column, row)
    assert drawn(centred(polygons, Fraction(1), SHAPE)) == drawn(middles)
    assert drawn(touched(polygons, Fraction(1), SHAPE)) == drawn(covered)
    tenths = [[[(x * TENTH, y * TENTH) for x, y in ring] for ring in each] for each in polygons]
    assert drawn(touched(tenths, TENTH, SHAPE)) == drawn(covered)
    more = [[with_points_between(ring) for ring in each] for each in polygons]
    assert drawn(touched(more, Fraction(1), SHAPE)) == drawn(covered)


def with_points_between(ring):
    """Return a ring with points on its edges whose coordinates are too long for integers of 64 bits."""
    share = Fraction(1, 3**19)
    return [
        point
        for one, other in edges_of(ring)
        for point in (one, tuple(a + (b - a) * share for a, b in zip(one, other, strict=True)))
    ]


@pytest.mark.parametrize("left", [k / 10 for k in range(0, 150, 3)])
def test_a_wall_of_two_tenths_is_two_cells_wide_wherever_it_stands(left):
    """Floats would make it three: 0.7 / 0.1 is 6.999999999999999."""
    right = round(left + 0.2, 1)
    for wall in (
        [(left, 0.3), (right, 0.3), (right, 0.7), (left, 0.7)],
        [(0.3, left), (0.3, right), (0.7, right)],
    ):
        cells = touched([[wall]], TENTH, (160, 160))
        assert [np.ptp(each) + 1 for each in cells.nonzero()] in ([4, 2], [2, 4])


LINES = {
    "along a border": ([(0.2, 0.2), (0.5, 0.2)], ["......", "..###.", "..###.", "......"]),
    "up a border": ([(0.2, 0.0), (0.2, 0.3)], ["......", ".##...", ".##...", ".##..."]),
    "within a row": ([(0.2, 0.25), (0.5, 0.25)], ["......", "..###.", "......", "......"]),
    "through corners": ([(0.1, 0.1), (0.4, 0.4)], ["...#..", "..#...", ".#....", "......"]),
    "from far away": ([(-1e300, 0.15), (1e300, 0.15)], ["......", "......", "######", "......"]),
    "tiny": ([(0.2, 0.15), (5e-324, 0.15)], ["......", "......", "##....", "......"]),
}


@pytest.mark.parametrize("what", LINES)
def test_a_line_closes_the_cells_that_it_runs_through_or_along(what):
    ends, expected = LINES[what]
    assert drawn(touched([[[*ends, ends[0]]]], TENTH, (4, 6))) == expected


def test_a_polygon_far_larger_than_the_arena_covers_it_and_one_outside_nothing():
    big = [[(-1e9, -1e9), (1e9, -1e9), (0.123456789012345, 1e9)]]
    assert touched([big], TENTH, (50, 40)).all()
    left = [(-1e6, 0.0), (-1e6 - 0.5, 0.0), (-1e6, 5.0)]
    right, far = ([(shift, 0.0), (9e6, 0), (shift, 5)] for shift in (4.0, 1e6))
    for none in ([], *([[ring]] for ring in (left, right, far, [(1.0, 1.0)] * 3))):
        assert not touched(none, TENTH, (50, 40)).any()
