"""What a robot sees of what is in range: not behind walls, and within its view (model.md 6.20, 6.22)."""

from __future__ import annotations

from numba import float64, int64, uint32

from feasibee.engine.bodies import short_way
from feasibee.engine.compile import called, inlined
from feasibee.engine.intrinsics import bit, contains, lowest_member, place_of, without_lowest
from feasibee.engine.layout import Heard, Link, Point, Robot, Sense
from feasibee.engine.place import drop_cut, is_cut, open_at, position, visible_tasks


@inlined
def is_in_view(params, robots, i, points, k):
    """Return whether a point is ahead of a robot, within half the angle of view."""
    walls, sensing = params.arena.walls, params.sensing
    x = short_way(robots[Robot.X, i], points[Point.X, k], params.arena.width, walls)
    y = short_way(robots[Robot.Y, i], points[Point.Y, k], params.arena.height, walls)
    u, v = int64(robots[Robot.STEP_X, i]), int64(robots[Robot.STEP_Y, i])
    along, across = float64(u * x + v * y), float64(abs(u * y - v * x))
    return along * sensing.view_sine >= across * sensing.view_cosine


@called
def drop_hidden(params, state, part, looking):
    """Leave robots out of the sets in `Link.SIGHT` that are in range but not seen by those that look."""
    if params.arena.place.exists:
        drop_cut(params, state, part, int64(Sense.SIGHT), params.arena.place.sight)
    if not params.sensing.ahead:
        return
    for other in range(part.first, part.last):
        sight = state.links[Link.SIGHT, other]
        for i in range(params.robots.count):
            left = sight[i] & -uint32(contains(looking, i))
            while left:
                j = lowest_member(other, left)
                if not is_in_view(params, state.robots, i, state.robots, j):
                    sight[i] &= ~bit(j)
                left = without_lowest(left)


@inlined
def may_hide(params, state, i):
    """Return whether a robot may not see all that is in range: walls are near, or it looks ahead only."""
    place = params.arena.place
    x, y = position(state.robots, i)
    return params.sensing.ahead or open_at(place, state.tables.ground, x, y) <= place.sight


@called
def seen_tasks(params, state, tasks, w, i):
    """Return which tasks of a word, all in range of a robot, it sees."""
    if params.arena.place.exists:
        tasks = visible_tasks(params, state, tasks, w, state.robots[Robot.X, i], state.robots[Robot.Y, i])
    left = tasks & -uint32(params.sensing.ahead)
    while left:
        task = lowest_member(w, left)
        if not is_in_view(params, state.robots, i, state.tasks, task):
            tasks &= ~bit(task)
        left = without_lowest(left)
    return tasks


@called
def keep_reached(params, state, points, part, sense, queued, packed):
    """Keep those pairs of the queue of which the first sees, or hears, the second; return their number.

    ``packed`` says that numbers are as `feasibee.engine.crowd.numbered` packs them.
    """
    queue, kept, place, ground = state.heard[part.thread], int64(0), params.arena.place, state.tables.ground
    receivers, others = queue[Heard.RECEIVER], queue[Heard.SENDER]
    ahead = params.sensing.ahead and sense == Sense.SIGHT
    for k in range(queued):
        i, other = receivers[k], others[k]
        j = place_of(other) if packed else int64(other)
        reached = not ahead or is_in_view(params, state.robots, int64(i), points, j)
        if place.exists:
            ax, ay = position(state.robots, i)
            bx, by = position(points, j)
            reached = reached and not is_cut(params, ground, sense, ax, ay, bx, by)
        receivers[kept], others[kept] = i, other
        kept += int64(reached)
    return kept
