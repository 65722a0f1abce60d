"""Figure of whether asking first pays: the cheapest way to start, over robots per task and the penalty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from feasibee.figures.style import PALETTE, RATIO, figure, robots_per_task

Cell = tuple[str, float, bool]
"""The cheapest policy, its mean cost, and whether it is surely cheaper than each other."""


def draw_diagram(
    panels: Mapping[str, Sequence[Sequence[Cell]]],
    ratios: Sequence[float],
    penalties: Sequence[float],
    policies: Sequence[str],
) -> Figure:
    """Draw a phase diagram per panel: a colour for the cheapest policy, its cost, in brackets if it's close.

    Parameters
    ----------
    panels : mapping of str to rows of cells
        By title: a row for each penalty, with a cell for each ratio.
    ratios : sequence of float
        Robots per task, along the horizontal axis.
    penalties : sequence of float
        Costs of a start in vain, along the vertical axis.
    policies : sequence of str
        All policies, in the order of their colours.
    """
    size = 1.0 + 0.46 * len(ratios), 1.1 + (0.5 + 0.28 * len(penalties)) * len(panels)
    with figure(*size, rows=len(panels), sharex=True, squeeze=False) as (drawn, axes):
        for ax, (title, rows) in zip(axes[:, 0], panels.items(), strict=True):
            _draw(ax, rows, ratios, policies)
            robots_per_task(ax, ratios, "")
            ax.set_yticks(range(len(penalties)), [f"{each:g}" for each in penalties])
            ax.set_title(title, loc="left")
            ax.set(ylabel="cost of a start in vain")
        axes[-1, 0].set(xlabel=f"{RATIO}; in a cell: mean cost, in brackets if another is as cheap")
        handles = [axes[0, 0].scatter([], [], marker="s", color=each) for each in PALETTE[: len(policies)]]
        drawn.legend(handles, policies, loc="outside upper center", ncols=3)
    return drawn


def _draw(ax: Any, rows: Sequence[Sequence[Cell]], ratios: Sequence[float], policies: Sequence[str]) -> None:
    chosen = np.array([[policies.index(policy) for policy, _, _ in row] for row in rows])
    middles = np.sqrt(np.multiply(ratios[1:], ratios[:-1]))
    columns = [ratios[0] ** 2 / middles[0], *middles, ratios[-1] ** 2 / middles[-1]]
    look: dict[str, Any] = {"cmap": ListedColormap(PALETTE[: len(policies)]), "alpha": 0.55}
    ax.pcolormesh(columns, np.arange(len(rows) + 1) - 0.5, chosen, vmin=0, vmax=len(policies) - 1, **look)
    for place, row in enumerate(rows):
        for ratio, (_, cost, sure) in zip(ratios, row, strict=True):
            text = f"{cost:.0f}" if sure else f"({cost:.0f})"
            ax.text(ratio, place, text, ha="center", va="center", fontsize=6.5)
    ax.spines[:].set_visible(False)
