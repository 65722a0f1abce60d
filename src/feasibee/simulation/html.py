"""What a notebook shows of a swarm: its arena as SVG, without scripts."""

from __future__ import annotations

import html
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from feasibee.model.codes import COLOURS, DECISIONS, INFEASIBLE, NO_OPINION, TASK
from feasibee.scenario.geometry import images
from feasibee.scenario.html import folded, framed

MOST = 20_000
"""Robots or tasks that are drawn."""
GRAIN = 2000
"""The longer side of an arena in the units of a drawing: whole numbers are short."""
DETAILED = 12  # such units: the radius from which on robots show more than their colour
LEAST = 4  # such units


def show_swarm(title: str, arena: str, counts: Mapping[str, int], outcome: str, scenario: str) -> str:
    """Return a swarm as HTML: its arena, its counts with the colours' legend, and its scenario, folded."""
    legend = ", ".join(
        f'{count} <span style="border-bottom: .2em solid {COLOURS[name]}">{name}</span>'
        for name, count in counts.items()
    )
    head = f"<p><strong>{html.escape(title)}</strong>: {legend}; {html.escape(outcome)}</p>"
    return framed(head + arena + folded("scenario", scenario))


def draw_arena(
    size: tuple[float, float],
    positions: NDArray[np.float64],
    opinions: NDArray[np.int8],
    disseminating: NDArray[np.bool_],
    tasks: NDArray[np.float64],
    *,
    diameter: float,
    walls: bool,
) -> str:
    """Return an arena as SVG, on white paper; a few paths, so that thousands of robots stay light.

    Parameters
    ----------
    size : tuple of float
        Of the arena, in units.
    positions, tasks : float64 array, shape (robots or tasks, 2)
        In units.
    opinions : int8 array, shape (robots,)
        1 feasible, 0 infeasible, -1 none.
    disseminating : bool array, shape (robots,)
        Which robots get a ring.
    diameter : float
        Of a robot, in units.
    walls : bool
        Whether the arena is closed, and not a torus.
    """
    if max(len(positions), len(tasks)) > MOST:
        return f"<p>More than {MOST} robots or tasks aren't drawn here; see feasibee animate.</p>"
    scale = GRAIN / max(size)
    width, height = (max(1, round(side * scale)) for side in size)
    radius = max(LEAST, round(diameter / 2 * scale))
    detailed = radius >= DETAILED
    parts = [_triangles(_places(tasks, scale, (width, height), 0, walls), radius, detailed)]
    for opinion, name in DECISIONS.items():
        for tells in (False, True):
            chosen = positions[(opinions == opinion) & (disseminating == tells)]
            spots = _places(chosen, scale, (width, height), round(1.5 * radius), walls)
            colour = COLOURS[name]
            if detailed and tells:
                parts += [_dots(spots, 2.8 * radius, colour), _dots(spots, 2.4 * radius, "#fff")]
            parts.append(_dots(spots, (1.4 if opinion == NO_OPINION else 2.0) * radius, colour))
            if opinion == INFEASIBLE:
                parts.append(_dots(spots, 0.96 * radius, "#fff"))
    thick = 16 if walls else 4
    border = (
        f'<rect x="{-thick / 2}" y="{-thick / 2}" width="{width + thick}" height="{height + thick}" '
        f'fill="none" stroke="{"#222" if walls else "#999"}" stroke-width="{thick}"/>'
    )
    label = f"An arena with {len(positions)} robots and {len(tasks)} tasks"
    pad = 2 * thick + 8
    box = f"{-pad} {-pad} {width + 2 * pad} {height + 2 * pad}"
    paper = f'<rect x="{-pad}" y="{-pad}" width="{width + 2 * pad}" height="{height + 2 * pad}" fill="#fff"/>'
    inside = (
        f'<svg width="{width}" height="{height}">{"".join(parts)}</svg>'  # cuts off what is beyond its edges
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" role="img" aria-label="{label}">'
        f"{paper}{inside}{border}</svg>"
    )


def _places(
    units: NDArray[np.float64], scale: float, size: tuple[int, int], reach: int, walls: bool
) -> list[list[int]]:
    """Return where things show in a drawing, y downward."""
    places = np.rint(units.reshape(-1, 2) * scale).astype(np.int64)
    places[:, 1] = size[1] - places[:, 1]
    listed: list[list[int]] = images(places, reach, size, walls)[0].tolist()
    return listed


def _dots(spots: list[list[int]], width: float, colour: str) -> str:
    """Return discs as strokes of one path: the short way to say where many things are."""
    if not spots:
        return ""
    path = "".join(f"M{x} {y}h0" for x, y in spots)
    return f'<path d="{path}" stroke="{colour}" stroke-width="{width:g}" stroke-linecap="round" fill="none"/>'


def _triangles(spots: list[list[int]], radius: int, detailed: bool) -> str:
    if not spots:
        return ""
    half = 0.9 * radius
    shape = f"l{half:g} {1.8 * half:g}h{-2 * half:g}z"
    path = "".join(f"M{x} {y - round(1.05 * half)}{shape}" for x, y in spots)
    outline = f' stroke="#222" stroke-width="{0.14 * radius:g}"' if detailed else ""
    return f'<path d="{path}" fill="{TASK if detailed else "#bbb"}"{outline}/>'
