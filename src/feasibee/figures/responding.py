"""Figure of swarms that call for robots and release them: how often there are enough, against idle robots."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from feasibee.figures.labels import Point, label_points
from feasibee.figures.style import GREY, PALETTE, PLAIN, Look, figure, looks
from feasibee.results.responding import Judgement, Service

FIXED = Look("0.35")
"""Look of fixed numbers of robots."""


def draw_service(judged: Mapping[str, Judgement], *, before: Mapping[str, Look] | None = None) -> Figure:
    """Draw the share of steps with enough robots against idle robots, up and left being better.

    A contender to the right of the curve of fixed numbers does worse than robots that never ask.

    Parameters
    ----------
    judged : mapping of str to Judgement
        By contender, all on the same tasks.
    before : mapping of str to Look, optional
        Looks of contenders in another figure.
    """
    shares = {name: each.own.feasible_share.estimate for name, each in judged.items()}
    found = looks(shares, list(shares)[: len(PALETTE)], before)
    some = next(iter(judged.values()))
    lines = dict(
        sorted((number, each) for judgement in judged.values() for number, each in judgement.fixed.items())
    )
    with figure(7.2, 3.6) as (drawn, ax):
        points = [
            _point(name, each.own, found[name] if found[name].highlighted else Look(GREY, "o"))
            for name, each in judged.items()
        ]
        points.append(_point("oracle", some.oracle, Look("black", "*")))
        idle = [each.idle.estimate for each in lines.values()]
        enough = [100 * each.feasible_share.estimate for each in lines.values()]
        ax.plot(idle, enough, color=FIXED.colour, linewidth=0.8, marker="|", zorder=1)
        for number, x, y in zip(lines, idle, enough, strict=True):
            ax.annotate(str(number), (x, y), (4, -10), textcoords="offset points", fontsize=7, color="0.35")
        where = {"xytext": (24, 0), "textcoords": "offset points", "va": "center", "fontsize": 8}
        ax.annotate("so many robots\nthat never ask", (idle[-1], enough[-1]), **where, color="0.35")
        for point in points:
            bars = {"color": point.look.colour, "capsize": 2, "marker": point.look.marker, "zorder": 3}
            ax.errorbar([point.x], [point.y], [[point.y - point.low], [point.high - point.y]], **bars)
        lowest = min(*enough, *(point.low for point in points))
        ax.set(xlabel="idle robots, mean", ylabel="steps with enough robots (%)", ylim=(lowest - 6, 104))
        beside = 0.012 * (ax.get_xlim()[1] - ax.get_xlim()[0])
        numbers = [Point("", x + beside, y - 2, PLAIN, y - 3, y) for x, y in zip(idle, enough, strict=True)]
        label_points(ax, [*points, *numbers])
    return drawn


def _point(name: str, service: Service, look: Look) -> Point:
    share, low, high = (100 * each for each in service.feasible_share)
    return Point(name, service.idle.estimate, share, look, low, high)
