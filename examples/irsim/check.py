"""Compare what feasibee's robots see with IR-SIM's geometry. See README.md."""

import json
from pathlib import Path

import irsim
import numpy as np
import shapely
from shapely.geometry import LineString

CELL = 0.1
OUTSIDE, INSIDE = 1.5 * 2**0.5 * CELL, 0.5 * 2**0.5 * CELL
"""How far a line on which both differ may pass by a wall, or cut into it, in units."""


def walls_of(env, grid):
    """Return the walls of a world as one shape."""
    if grid is None:
        return shapely.union_all([each._geometry for each in env.obstacle_list])
    columns, rows = (grid > 50).nonzero()
    return shapely.union_all(
        shapely.box(columns * CELL, rows * CELL, (columns + 1) * CELL, (rows + 1) * CELL)
    )


def check(name, robots, tasks, sees, closed):
    """Print how many pairs of a place differ, and where."""
    env = irsim.make(f"{name}.yaml", display=False)
    world = env.get_map(CELL)
    lines = [LineString([robot, task]) for robot in robots for task in tasks]
    theirs = np.array([not world.is_collision(line) for line in lines])
    ours = np.array([int(each) for row in sees for each in row], bool)
    walls = walls_of(env, world.grid)
    differ = np.flatnonzero(ours != theirs)
    near = [shapely.intersects(walls.buffer(OUTSIDE), lines[k]) for k in differ]
    deep = [shapely.intersects(walls.buffer(-INSIDE), lines[k]) for k in differ]
    edge = [lines[k].distance(walls) <= CELL and not lines[k].intersects(walls.buffer(-CELL)) for k in differ]
    beyond = len(differ) - sum(n and not d for n, d in zip(near, deep, strict=True))
    print(f"{name}: {len(lines)} pairs, visible {theirs.sum()} in IR-SIM, {ours.sum()} in feasibee")
    print(f"  {len(differ)} differ: {(theirs & ~ours).sum()} visible in IR-SIM only")
    print(f"  {sum(edge)} of them within a cell of a wall's edge, {beyond} beyond the margins")
    if world.grid is not None:
        cells = np.array([list(row) for row in closed]) == "1"
        print(f"  {cells.size} cells, {(cells != (world.grid.T > 50)).sum()} of them not the same")
    return f"{int(''.join(map(str, theirs.astype(int))), 2):x}"


def main():
    """Check both places."""
    pairs = json.loads(Path("pairs.json").read_text())
    found = {name: check(name, **each) for name, each in pairs.items()}
    Path("irsim.json").write_text(json.dumps(found))


if __name__ == "__main__":
    main()
