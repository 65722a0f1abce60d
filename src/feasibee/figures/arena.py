"""The arena of one swarm as a figure."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle, Polygon, Wedge
from PIL import Image

from feasibee.base.codes import COLOURS, DECISIONS, INFEASIBLE, NO_OPINION, TASK, ZONE
from feasibee.base.errors import FeasibeeError, quoted
from feasibee.figures.style import as_text, axes_for, in_metres, text_colour
from feasibee.scenario.picture import extent_of, images, outlines_of, picture_of, segments
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.swarm import Swarm

DONE = "0.6"
"""Fill of done tasks."""
HOLE, SMALL = 0.72, 0.72
"""Sizes of the hole of a robot that holds infeasible, and of one without opinion, in radii."""
WALKS, STANDS = 0.5, 1.8
"""Widths of the lines from robots to the tasks to which they walk, and at which they stand, in points."""


def plot_arena(swarm: Swarm, ax: Axes | None = None) -> Axes:
    """Draw robots (numbered discs, shaded ranges) and tasks (triangles) of a step, as the paper's Fig. 1.

    Parameters
    ----------
    swarm : Swarm
        Whose present step to draw. A robot that holds *feasible* is full, *infeasible* hollow; one without
        opinion is small. A black rim says that it has declared. If robots act, free tasks are hollow. A thin
        line leads to the task to which a robot walks, and a thick one to that at which it stands.
    ax : matplotlib Axes, optional
        By default a new figure's.
    """
    scenario = getattr(swarm, "scenario", None)
    if not isinstance(scenario, Scenario):
        raise FeasibeeError(f"swarm = {quoted(swarm)}: must be a Swarm; write Swarm(scenario, seed=1)")
    width, height = scenario.arena.size
    with axes_for(ax, 3.4, min(6.0, max(1.6, 0.9 + 2.5 * height / width))) as axes:
        draw_ground(axes, scenario)
        _draw_robots(axes, swarm, scenario)
        _draw_tasks(axes, swarm, scenario)
        frame_arena(axes, scenario)
        _arena_legend(axes, scenario, bool((swarm.opinions[swarm.present] == NO_OPINION).any()))
        return axes


def frame_arena(ax: Axes, scenario: Scenario) -> None:
    """Draw the edges of the arena, and label its axes."""
    width, height = scenario.arena.size
    ax.set(xlim=(0, width), ylim=(0, height), xlabel="x (units)", ylabel="y (units)", aspect="equal")
    ticks = ax.get_xticks() if width >= height else ax.get_yticks()
    ax.set_xticks([tick for tick in ticks if 0 <= tick <= width])
    ax.set_yticks([tick for tick in ticks if 0 <= tick <= height])
    ax.spines[:].set_visible(True)
    if scenario.arena.boundary == "walls":
        ax.spines[:].set_linewidth(2.5)
    in_metres(ax, scenario.units.metres)


def draw_ground(ax: Axes, scenario: Scenario) -> None:
    """Draw the walls, no-go cells and zones of a scenario's place, if it has one."""
    if scenario.plan is None:
        return
    width, height = extent_of(scenario.plan)
    with Image.open(io.BytesIO(picture_of(scenario.plan))) as picture:
        cells = np.asarray(picture.convert("RGBA"))
    ax.imshow(cells, extent=(0, width, 0, height), interpolation="nearest", zorder=1.2)
    for name, polygons, place in outlines_of(scenario):
        for each in polygons:
            ax.add_patch(Polygon(each, facecolor=ZONE, alpha=0.12, zorder=0.6))
            ax.add_patch(Polygon(each, fill=False, edgecolor=ZONE, linewidth=0.8, zorder=1.3))
        above: dict[str, Any] = {"fontsize": 6, "va": "top", "zorder": 1.4, "clip_on": True}
        ax.annotate(as_text(name), place, (3, -3), textcoords="offset points", **above)


def _draw_robots(ax: Axes, swarm: Swarm, scenario: Scenario) -> None:
    """Draw each robot's range, body in the shape of its opinion, rim if it has declared, and number."""
    reach, radius = scenario.sensing.range, scenario.robots.diameter / 2
    walls = scenario.arena.boundary == "walls"
    there = np.flatnonzero(swarm.present)
    places, found = images(swarm.positions[there], max(reach, radius), scenario.arena.size, walls)
    declared, half = swarm.declared, scenario.sensing.view / 2
    ahead = np.degrees(swarm.headings)[:, np.newaxis]
    middle: dict[str, Any] = {"ha": "center", "va": "center_baseline"}
    for place, number in zip(map(tuple, places.tolist()), there[found].tolist(), strict=True):
        opinion = int(swarm.opinions[number])
        colour, body = COLOURS[DECISIONS[opinion]], radius * (SMALL if opinion == NO_OPINION else 1)
        seen = Circle(place, reach) if half == 180 else Wedge(place, reach, *(ahead[number] + (-half, half)))
        seen.set(color="0.5", alpha=0.13, linewidth=0)
        ax.add_patch(seen)
        rim = 0.9 if declared[number] >= 0 else 0.0  # points
        ax.add_patch(Circle(place, body, facecolor=colour, edgecolor="black", linewidth=rim, zorder=3))
        ink = "white"
        if opinion == INFEASIBLE:
            ax.add_patch(Circle(place, HOLE * radius, facecolor="white", linewidth=0, zorder=3))
            ink = text_colour(colour)
        ax.annotate(str(number + 1), place, color=ink, fontsize=5.5, zorder=4, clip_on=True, **middle)


def _draw_tasks(ax: Axes, swarm: Swarm, scenario: Scenario) -> None:
    """Draw the tasks; if robots act, free ones hollow, and lines from robots to their tasks."""
    x, y = swarm.tasks.T
    look: dict[str, Any] = {"color": TASK, "edgecolor": "black", "linewidth": 0.4}
    if scenario.acts:
        aims, standing, _ = swarm.acting
        look["color"] = [("white", TASK, DONE)[each] for each in swarm.acting.looks]
        bound, walls = np.flatnonzero(aims >= 0), scenario.arena.boundary == "walls"
        lines, found = segments(swarm.positions[bound], swarm.tasks[aims[bound]], scenario.arena.size, walls)
        widths = np.where(standing[bound], STANDS, WALKS)[found]
        ax.add_collection(LineCollection(list(lines), colors="black", linewidths=widths, zorder=2.1))
    ax.scatter(x, y, marker="^", s=26, zorder=2, **look)


def _arena_legend(ax: Axes, scenario: Scenario, neutral: bool) -> None:
    """Write above the axes what robots, tasks, ranges and lines look like."""
    declares, acts = scenario.declares, scenario.acts
    rim: dict[str, Any] = {"color": "white", "markeredgecolor": "black", "markeredgewidth": 0.9}
    task = {"marker": "^", "color": TASK, "markeredgecolor": "black", "markeredgewidth": 0.4}
    line = {"linestyle": "-", "marker": "", "color": "black"}
    looks: dict[str, dict[str, Any]] = {
        "feasible": {"color": COLOURS["feasible"]},
        "infeasible": {"color": COLOURS["infeasible"], "markerfacecolor": "white", "markeredgewidth": 1.5},
        **({"no opinion": {"color": COLOURS["undecided"], "markersize": 4}} if neutral else {}),
        **({"declared": rim} if declares else {}),
        "taken task" if acts else "task": task,
        **({"free task": {**task, "color": "white"}} if acts else {}),
        "range": {"markersize": 9, "color": "0.87"},
    }
    if scenario.tasks.work is not None:
        looks["done task"] = {**task, "color": DONE}
    if acts:
        looks |= {"walks to": {**line, "linewidth": WALKS}, "stands at": {**line, "linewidth": STANDS}}
    usual = {"linestyle": "", "marker": "o", "markersize": 6}
    handles = [ax.plot([], [], **{**usual, **look})[0] for look in looks.values()]
    where: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "columnspacing": 1}
    where |= {"handlelength": 1.2, "handletextpad": 0.5} if acts else {"handletextpad": 0.2}
    ax.legend(handles, looks, ncols=3 if acts or declares else 4, **where)
