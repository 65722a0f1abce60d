"""Draw two places, and write which tasks feasibee's robots see there. See README.md."""

from __future__ import annotations

import json
import math
from pathlib import Path
from random import Random

from PIL import Image, ImageDraw

import feasibee

THINGS = 100
"""Robots, and tasks: each robot and each task are a pair."""
SIDE, CELL, SEED = 20.0, 0.1, 28
CLEARANCE = 0.5
"""Units from walls to robots and tasks: cells in which robots of this size can be begin there."""


def rectangles(random):
    """Return the corners of 40 rectangles at any angle, in units."""
    found = []
    for _ in range(40):
        x, y, angle = random.uniform(2, SIDE - 2), random.uniform(2, SIDE - 2), random.uniform(0, math.pi)
        width, height = random.uniform(0.15, 1.0), random.uniform(0.15, 1.0)
        u, v = (math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))
        corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
        found.append(
            [
                [round(c + a * width * p + b * height * q, 3) for c, p, q in zip((x, y), u, v, strict=True)]
                for a, b in corners
            ]
        )
    return found


def hall():
    """Return a map as a robot would draw it: four rooms with doors, shelves, a ragged wall."""
    cells, random = round(SIDE / CELL), Random(SEED)
    image = Image.new("L", (cells, cells), 254)
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, 0, cells - 1, cells - 1), outline=0, width=2)
    for k in range(0, cells, 4):  # two walls whose thickness changes, with doors of 1.2 and 2.4 units
        if not 40 <= k < 52:
            draw.rectangle((k, 98, k + 3, 98 + random.randrange(1, 5)), fill=0)
        if not 130 <= k < 154:
            draw.rectangle((98, k, 98 + random.randrange(1, 5), k + 3), fill=0)
    for x in range(118, 190, 18):
        draw.rectangle((x, 120, x + 5, 160), fill=0)
    draw.ellipse((30, 130, 60, 150), fill=0)
    return image


def is_clear(image, x, y):
    """Return whether no cell within the clearance is a wall; the top row has the highest y."""
    reach, column, row = round(CLEARANCE / CELL), int(x / CELL), int((SIDE - y) / CELL)
    if not (reach <= column < image.width - reach and reach <= row < image.height - reach):
        return False
    around = image.crop((column - reach, row - reach, column + reach + 1, row + reach + 1))
    return around.getextrema()[0] > 0


def points(image, random):
    """Draw the positions of the robots, or of the tasks."""
    found = []
    while len(found) < THINGS:
        point = round(random.uniform(0, SIDE), 3), round(random.uniform(0, SIDE), 3)
        if is_clear(image, *point):
            found.append(point)
    return found


def drawn(polygons):
    """Return an image of polygons."""
    image = Image.new("L", (round(SIDE / CELL),) * 2, 254)
    for polygon in polygons:
        ImageDraw.Draw(image).polygon([(x / CELL, (SIDE - y) / CELL) for x, y in polygon], fill=0)
    return image


def scenario(place, robots, tasks):
    """Return a scenario in which robots learn which tasks they see, and nothing by radio."""
    return feasibee.Scenario(
        arena={} if "map" in place else {"side": SIDE, "boundary": "walls"},
        place=place,
        robots={"placement": "points", "points": robots, "speed": 0, "diameter": 0.2},
        tasks={"placement": "points", "points": tasks},
        sensing={"range": 2 * SIDE},
        radio={"range": 1e-3},
        decision={"strategy": "census"},
    )


def sights(world):
    """Return which tasks each robot sees: a row of 0 and 1 per robot, as strings."""
    swarm, first = feasibee.Swarm(world), (THINGS + 31) >> 5
    swarm.advance()
    known = swarm.knowledge[:, first:].tolist()
    return ["".join(str(row[t >> 5] >> (t & 31) & 1) for t in range(THINGS)) for row in known]


def places():
    """Return both places, the walls as feasibee takes them and as an image; write the map as nav2 has it."""
    polygons, image = rectangles(Random(SEED)), hall()
    image.save("hall.png")
    Path("hall_map.yaml").write_text(f"image: hall.png\nresolution: {CELL}\norigin: [0, 0, 0]\n")
    return {
        "polygons": ({"walls": polygons, "cell": CELL}, drawn(polygons)),
        "hall": ({"map": "hall_map.yaml"}, image),
    }


def worlds():
    """Yield the name, place and scenario of each place."""
    for name, (place, image) in places().items():
        yield name, place, scenario(place, points(image, Random(1)), points(image, Random(2)))


def main():
    """Write the files."""
    pairs = {}
    for name, place, world in worlds():
        found = {"world": {"width": SIDE, "height": SIDE}}
        if name == "hall":
            found["world"] |= {"obstacle_map": "hall.png", "mdownsample": 1}
        else:
            shapes = [{"name": "polygon", "vertices": polygon} for polygon in place["walls"]]
            found["obstacle"] = [{"shape": shape, "state": [0, 0, 0]} for shape in shapes]
        Path(f"{name}.yaml").write_text(json.dumps(found))  # JSON is YAML, too
        walls = ["".join(map(str, row)) for row in world.plan.walls.astype(int).tolist()]
        things = {"robots": world.robots.points, "tasks": world.tasks.points}
        pairs[name] = {**things, "sees": sights(world), "closed": walls}
    Path("pairs.json").write_text(json.dumps(pairs))


if __name__ == "__main__":
    main()
