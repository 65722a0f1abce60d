"""A small place with a wall, a no-go area and a zone, for tests of pictures."""

from __future__ import annotations

import base64
import io

import numpy as np
from PIL import Image

from feasibee import Scenario

SIDE = (20.0, 10.0)
WALL = ((9.0, 0.0), (11.0, 0.0), (11.0, 6.0), (9.0, 6.0))
"""It stands at the lower edge."""
DOCK = ((0.5, 5.5), (4.5, 5.5), (4.5, 9.5), (0.5, 9.5))
"""It lies at the upper left."""


def bitmap(closed, cell):
    """Return a map of cells, whose row 0 has the lowest y, as the scenario has it."""
    Image.fromarray(~np.asarray(closed, bool)[::-1]).save(kept := io.BytesIO(), "PNG")
    return {"cell": cell, "image": base64.b64encode(kept.getvalue()).decode()}


def no_go(cell=0.5):
    """Return a map that closes x from 14 to 16, y from 1 to 3."""
    closed = np.zeros((round(SIDE[1] / cell), round(SIDE[0] / cell)), bool)
    closed[round(1 / cell) : round(3 / cell), round(14 / cell) : round(16 / cell)] = True
    return bitmap(closed, cell)


PLACE = Scenario(
    arena={"side": SIDE, "boundary": "walls"},
    place={"walls": [WALL], "keepout": no_go(), "cell": 0.5, "zones": {"<dock> & more": DOCK}},
    robots={"count": 2, "diameter": 0.5, "placement": "points", "points": [[6.0, 2.0], [6.0, 8.0]]},
    tasks={"count": 1, "placement": "points", "points": [[18.0, 8.0]]},
)
