"""The HTML that a notebook shows for a swarm: a picture of its arena and its counts, without scripts."""

from __future__ import annotations

from typing import Any, Final

from feasibee.model.codes import COLOURS, DECISIONS, FEASIBLE, INFEASIBLE
from feasibee.scenario.html import folded, framed
from feasibee.scenario.picture import as_html

MOST: Final = 20_000
"""Largest number of robots, or of tasks, that is drawn."""
SIZE: Final = 720
"""Width of the picture in pixels, twice that at which a notebook shows it."""


def show_swarm(swarm: Any, run: int) -> str:
    """Return a `Swarm` as HTML: its arena, its counts as a legend of colours, and its collapsed scenario."""
    world = swarm.scenario
    counts = {DECISIONS[FEASIBLE]: swarm.feasible_count, DECISIONS[INFEASIBLE]: swarm.infeasible_count}
    legend = ", ".join(
        f'{count} <span style="border-bottom: .2em solid {COLOURS[name]}">{name}</span>'
        for name, count in counts.items()
    )
    outcome = f"{DECISIONS[swarm.decision]} (truth: {DECISIONS[int(swarm.truth)]})"
    if world.declares:
        outcome += "; declared: {} feasible, {} infeasible".format(*swarm.declared_counts)
    if world.acts:
        outcome += f"; {swarm.acting.achieved}"
    head = f"<p><strong>Run {run}, step {swarm.step}</strong>: {legend}; {outcome}</p>"
    return framed(head + _picture(swarm) + folded("scenario", world._repr_html_()))


def _picture(swarm: Any) -> str:
    """Return the arena as an image, with a text for those who don't see it."""
    from feasibee.simulation.frames import Painter

    robots, tasks = int(swarm.present.sum()), len(swarm.tasks)
    if max(robots, tasks) > MOST:
        return f"<p>More than {MOST} robots or tasks aren't drawn here; use feasibee animate.</p>"
    drawn = Painter(swarm.scenario, SIZE).draw_arena(swarm)
    return as_html(drawn, f"An arena with {robots} robots and {tasks} tasks")
