"""Places for tests: rooms, and maps drawn at random."""

from __future__ import annotations

import base64
import io

import numpy as np
from PIL import Image


def rectangle(left, low, right, top):
    """Return the corners of a rectangle."""
    return [[left, low], [right, low], [right, top], [left, top]]


def rooms(door, side=20.0):
    """Return two rooms with a door in the wall between them."""
    middle, low, high = side / 2, (side - door) / 2, (side + door) / 2
    wall = (middle - 0.1, middle + 0.1)
    parts = [rectangle(wall[0], 0.0, wall[1], low), rectangle(wall[0], high, wall[1], side)]
    return parts if door else [rectangle(wall[0], 0.0, wall[1], side)]


def bitmap(closed, cell):
    """Return a map as a scenario has it."""
    file = io.BytesIO()
    Image.fromarray(~closed[::-1]).save(file, "PNG")
    return {"cell": cell, "image": base64.b64encode(file.getvalue()).decode()}


def random_cells(random, rows, columns, obstacles):
    """Return closed cells: blocks and thin walls."""
    closed = np.zeros((rows, columns), bool)
    for _ in range(obstacles):
        y, x = random.integers(0, rows), random.integers(0, columns)
        long = int(random.integers(3, max(rows, columns)))
        high, wide = [(1, long), (long, 1), tuple(random.integers(1, 5, 2))][random.integers(0, 3)]
        closed[y : y + high, x : x + wide] = True
    return closed
