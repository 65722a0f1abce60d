"""The HTML that a notebook shows for a swarm: its arena as SVG, without scripts."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from feasibee.model.codes import COLOURS, DECISIONS, FEASIBLE, INFEASIBLE, NO_OPINION, TASK
from feasibee.scenario.geometry import Acting, images, segments
from feasibee.scenario.html import folded, framed
from feasibee.scenario.picture import draw_plan

MOST = 20_000
"""Largest number of robots, or of tasks, that is drawn."""
GRAIN = 2000
"""Longer side of an arena in a drawing's units, in which positions are short whole numbers."""
DETAILED = 12
"""Smallest radius, in a drawing's units, of robots that show more than their colour."""
LEAST = 4
"""Smallest radius of a robot, in a drawing's units."""


def show_swarm(swarm: Any, run: int) -> str:
    """Return a `Swarm` as HTML: its arena, its counts as a legend of colours, and its collapsed scenario."""
    world, there = swarm.scenario, swarm.present
    acting = swarm.acting if world.acts else None
    drawn = draw_arena(
        world.arena.size,
        swarm.positions[there],
        swarm.opinions[there],
        swarm.disseminating[there],
        swarm.declared[there],
        swarm.tasks,
        diameter=world.robots.diameter,
        walls=world.arena.boundary == "walls",
        ground=draw_plan(world, *scale_of(world.arena.size)),
        looks=None if acting is None else acting.looks,
        lines="" if acting is None else _lines(swarm, acting),
    )
    counts = {DECISIONS[FEASIBLE]: swarm.feasible_count, DECISIONS[INFEASIBLE]: swarm.infeasible_count}
    legend = ", ".join(
        f'{count} <span style="border-bottom: .2em solid {COLOURS[name]}">{name}</span>'
        for name, count in counts.items()
    )
    outcome = f"{DECISIONS[swarm.decision]} (truth: {DECISIONS[int(swarm.truth)]})"
    if world.declares:
        outcome += "; declared: {} feasible, {} infeasible".format(*swarm.declared_counts)
    if acting is not None:
        outcome += f"; {acting.achieved}"
    head = f"<p><strong>Run {run}, step {swarm.step}</strong>: {legend}; {outcome}</p>"
    return framed(head + drawn + folded("scenario", world._repr_html_()))


def draw_arena(
    size: tuple[float, float],
    positions: NDArray[np.float64],
    opinions: NDArray[np.int8],
    disseminating: NDArray[np.bool_],
    declared: NDArray[np.int8],
    tasks: NDArray[np.float64],
    *,
    diameter: float,
    walls: bool,
    ground: str = "",
    looks: NDArray[np.uint8] | None = None,
    lines: str = "",
) -> str:
    """Return an arena as SVG on white; it has few paths, so that thousands of robots need little memory.

    Parameters
    ----------
    size : tuple of float
        Width and height of the arena, in units.
    positions, tasks : float64 array, shape (robots or tasks, 2)
        Positions of the robots and of the tasks, in units.
    opinions : int8 array, shape (robots,)
        1 feasible, 0 infeasible, -1 none.
    disseminating : bool array, shape (robots,)
        Whether each robot is disseminating; such robots have a ring.
    declared : int8 array, shape (robots,)
        What each robot has declared, -1 for nothing yet; the others have a dark rim.
    diameter : float
        Diameter of a robot, in units.
    walls : bool
        Whether the arena has walls instead of being a torus.
    ground, lines : str
        Elements of SVG below tasks, and between tasks and robots, on the scale of `scale_of`.
    looks : uint8 array, shape (tasks,), optional
        If robots act, those of `feasibee.scenario.geometry.Acting`; free tasks are hollow, done ones pale.
    """
    if max(len(positions), len(tasks)) > MOST:
        return f"<p>More than {MOST} robots or tasks aren't drawn here; use feasibee animate.</p>"
    scale, height = scale_of(size)
    width = max(1, round(size[0] * scale))
    radius = max(LEAST, round(diameter / 2 * scale))

    def place(units: NDArray[np.float64], reach: int) -> list[list[int]]:
        return _places(units, scale, (width, height), reach, walls)

    shapes = [(tasks, 1)] if looks is None else [(tasks[looks == each], each) for each in (2, 1, 0)]
    parts = [ground, *(_triangles(place(some, 0), radius, look) for some, look in shapes), lines]
    for opinion in DECISIONS:
        for tells, sure in product((False, True), repeat=2):
            chosen = positions[(opinions == opinion) & (disseminating == tells) & ((declared >= 0) == sure)]
            parts += _robots(place(chosen, round(1.5 * radius)), radius, opinion, tells, sure)
    label = f"An arena with {len(positions)} robots and {len(tasks)} tasks"
    return _framed("".join(parts), width, height, walls, label)


def _lines(swarm: Any, acting: Acting) -> str:
    """Return lines from robots to the tasks to which they walk, and thick ones if they stand there."""
    size, bound = swarm.scenario.arena.size, np.flatnonzero(acting.aims >= 0)
    ends = swarm.positions[bound], swarm.tasks[acting.aims[bound]]
    found, robots = segments(*ends, size, swarm.scenario.arena.boundary == "walls")
    (scale, height), thick = scale_of(size), acting.standing[bound][robots]
    pixels = np.rint(found * (scale, -scale) + (0, height)).astype(np.int64)
    return "".join(
        f'<path d="{"".join("M{} {}L{} {}".format(*each.ravel()) for each in pixels[thick == stands])}" '
        f'stroke="#222" stroke-width="{width}"/>'
        for stands, width in ((False, 3), (True, 14))
    )


def scale_of(size: tuple[float, float]) -> tuple[float, int]:
    """Return the length of a unit in a drawing of an arena of this size, and the height of the drawing."""
    scale = GRAIN / max(size)
    return scale, max(1, round(size[1] * scale))


def _robots(spots: list[list[int]], radius: int, opinion: int, ring: bool, rim: bool) -> Iterator[str]:
    """Yield the discs of robots with the same opinion, in layers from the back to the front."""
    colour = COLOURS[DECISIONS[opinion]]
    if radius >= DETAILED and ring:
        yield _dots(spots, 2.8 * radius, colour)
        yield _dots(spots, 2.4 * radius, "#fff")
    width = 1.4 if opinion == NO_OPINION else 2.0
    if radius >= DETAILED and rim:
        yield _dots(spots, 2.24 * radius, "#222")
        width -= 0.28
    yield _dots(spots, width * radius, colour)
    if opinion == INFEASIBLE:
        yield _dots(spots, 0.96 * radius, "#fff")


def _framed(drawn: str, width: int, height: int, walls: bool, label: str) -> str:
    """Return a drawing as SVG with a border; what is beyond the border is cut off."""
    thick = 16 if walls else 4
    border = (
        f'<rect x="{-thick / 2}" y="{-thick / 2}" width="{width + thick}" height="{height + thick}" '
        f'fill="none" stroke="{"#222" if walls else "#999"}" stroke-width="{thick}"/>'
    )
    pad = 2 * thick + 8
    box = f"{-pad} {-pad} {width + 2 * pad} {height + 2 * pad}"
    paper = f'<rect x="{-pad}" y="{-pad}" width="{width + 2 * pad}" height="{height + 2 * pad}" fill="#fff"/>'
    inside = f'<svg width="{width}" height="{height}">{drawn}</svg>'  # an inner svg clips its content
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" role="img" aria-label="{label}">'
        f"{paper}{inside}{border}</svg>"
    )


def _places(
    units: NDArray[np.float64], scale: float, size: tuple[int, int], reach: int, walls: bool
) -> list[list[int]]:
    """Return the positions of things and their images in a drawing, with y downward."""
    places = np.rint(units.reshape(-1, 2) * scale).astype(np.int64)
    places[:, 1] = size[1] - places[:, 1]
    listed: list[list[int]] = images(places, reach, size, walls)[0].tolist()
    return listed


def _dots(spots: list[list[int]], width: float, colour: str) -> str:
    """Return discs as round strokes of one path, the shortest SVG for many discs."""
    if not spots:
        return ""
    path = "".join(f"M{x} {y}h0" for x, y in spots)
    return f'<path d="{path}" stroke="{colour}" stroke-width="{width:g}" stroke-linecap="round" fill="none"/>'


def _triangles(spots: list[list[int]], radius: int, look: int) -> str:
    """Return tasks of one look as triangles of one path."""
    if not spots:
        return ""
    half, detailed = 0.9 * radius, radius >= DETAILED
    shape = f"l{half:g} {1.8 * half:g}h{-2 * half:g}z"
    path = "".join(f"M{x} {y - round(1.05 * half)}{shape}" for x, y in spots)
    fill = (("#fff", TASK, "#bbb") if detailed else ("#222", "#bbb", "#bbb"))[look]
    outline = f' stroke="#222" stroke-width="{0.14 * radius:g}"' if detailed else ""
    return f'<path d="{path}" fill="{fill}"{outline}/>'
