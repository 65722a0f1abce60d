"""The HTML that a notebook shows for a swarm: a picture of its arena and its counts, without scripts."""

from __future__ import annotations

from typing import Any, Final

from feasibee.model.codes import COLOURS, DECISIONS, FEASIBLE, INFEASIBLE
from feasibee.scenario.html import render
from feasibee.scenario.picture import encoded

MOST: Final = 20_000
"""Largest number of robots, or of tasks, that is drawn."""
SIZE: Final = 720
"""Width of the picture in pixels, twice that at which a notebook shows it."""


def show_swarm(swarm: Any, run: int) -> str:
    """Return a `Swarm` as HTML: its arena, its counts as a legend of colours, and its collapsed scenario."""
    from feasibee.simulation.frames import Painter

    outcome = f"{DECISIONS[swarm.decision]} (truth: {DECISIONS[int(swarm.truth)]})"
    if swarm.scenario.declares:
        outcome += "; declared: {} feasible, {} infeasible".format(*swarm.declared_counts)
    if swarm.scenario.acts:
        outcome += f"; {swarm.acting.achieved}"
    robots, tasks = int(swarm.present.sum()), len(swarm.tasks)
    few = max(robots, tasks) <= MOST
    return render(
        "swarm.html",
        swarm=swarm,
        run=run,
        counts={DECISIONS[FEASIBLE]: swarm.feasible_count, DECISIONS[INFEASIBLE]: swarm.infeasible_count},
        colours=COLOURS,
        outcome=outcome,
        picture=encoded(Painter(swarm.scenario, SIZE).draw_arena(swarm)) if few else None,
        robots=robots,
        tasks=tasks,
        most=MOST,
    )
