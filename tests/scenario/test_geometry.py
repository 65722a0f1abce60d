"""What shows in a picture of the arena: one rule for figures, frames and notebooks."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from feasibee.scenario.picture import images, segments

SIDES = st.integers(1, 200).map(lambda number: number / 4)
PARTS = st.integers(0, 64).map(lambda number: number / 64)
"""Sums of these are exact, so that edges are edges."""


def copies(places, reach, size):
    """Return all of the nine copies of each place that reach into view, the plain way."""
    width, height = size
    return sorted(
        (x + dx, y + dy, name)
        for name, (x, y) in enumerate(places)
        for dx in (-width, 0.0, width)
        for dy in (-height, 0.0, height)
        if -reach < x + dx < width + reach and -reach < y + dy < height + reach
    )


@given(SIDES, SIDES, PARTS, st.lists(st.tuples(PARTS, PARTS), max_size=8))
def test_on_a_torus_every_copy_that_reaches_into_view_shows(width, height, share, shares):
    """Catches sides taken for each other: most arenas are longer one way."""
    reach = share * min(width, height) / 2
    places = np.array([(x * width, y * height) for x, y in shares]).reshape(-1, 2)
    spots, names = images(places, reach, (width, height), walls=False)
    found = sorted((*spot, name) for spot, name in zip(spots.tolist(), names.tolist(), strict=True))
    inside = [(*place, name) for name, place in enumerate(places.tolist())]
    assert found == sorted({*copies(places.tolist(), reach, (width, height)), *inside})


def test_within_walls_each_shows_once():
    places = np.array([(0.0, 0.0), (30.0, 12.0), (0.1, 11.9)])
    spots, names = images(places, 5.0, (30.0, 12.0), walls=True)
    assert spots.tolist() == places.tolist()
    assert names.tolist() == [0, 1, 2]
    spots, names = images(np.array([[1, 5]]), 2, (30, 12), walls=False)
    assert (spots.tolist(), spots.dtype) == ([[1, 5], [31, 5]], np.int64)  # pixels need no rounding
    assert names.tolist() == [0, 0]


@given(SIDES, SIDES, st.tuples(PARTS, PARTS, PARTS, PARTS))
def test_lines_on_a_torus_go_the_shortest_way_and_end_where_they_should(width, height, shares):
    size = np.array([width, height])
    start, end = np.array(shares[:2]) * size, np.array(shares[2:]) * size
    lines, names = segments(start[None], end[None], (width, height), walls=False)
    copies = [np.hypot(*(end + size * (i, j) - start)) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    assert np.hypot(*(lines[0, 1] - lines[0, 0])) == min(copies)
    assert lines[0, 0].tolist() == start.tolist()
    assert lines[-1, 1].tolist() == end.tolist()
    assert names.tolist() == [0] * (1 if lines[0, 1].tolist() == end.tolist() else 2)


def test_lines_within_walls_are_straight():
    lines, names = segments(np.array([[1.0, 1.0]]), np.array([[29.0, 11.0]]), (30.0, 12.0), walls=True)
    assert lines.tolist() == [[[1.0, 1.0], [29.0, 11.0]]]
    assert names.tolist() == [0]
