"""Up to 32 robots in the general engine: their neighbours as sets, found at once (model.md 6.1 to 6.6).

Places are compared in 16 bits first, and exactly where these leave a range in doubt. Larger swarms move and
sense robot by robot: see `feasibee.engine.motion` and `feasibee.engine.sensing`. What takes the state is
inlined, since passing it 20 times a step took a fifth of the time.
"""

from __future__ import annotations

from numba import float64, int32, int64, uint32, uint64

from feasibee.engine.bits import (
    bit,
    bit_if,
    first_bits,
    has_bit,
    lowest_member,
    pack_label,
    says_feasible,
    without_lowest,
)
from feasibee.engine.cells import near, shortest
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.draws import draw
from feasibee.engine.inbox import receive, receive_together
from feasibee.engine.intrinsics import find_near, lowest, popcount, within_roughly
from feasibee.engine.knowledge import defer_all, update_pending
from feasibee.engine.layout import WORD, Clock, Count, Link, Point, Robot, Set
from feasibee.engine.motion import around, meet, move_freely
from feasibee.engine.params import Action
from feasibee.engine.publishing import publish
from feasibee.engine.sensing import (
    count_all_false_sightings,
    find_listeners,
    observe_tasks,
)
from feasibee.engine.tasklists import pack_place
from feasibee.model.purposes import LOSS, MISS_ROBOT, MISS_TASK, PAIR

SURELY = 1e-14
"""More than the relative error of a product of four numbers, each rounded once."""


@spliced
def move_few(params, state, part):
    """Move each robot whose way is clear; the others stay and will turn (model.md 6.1, 6.2)."""
    blocked = uint32(0)
    if params.arena.walls:
        blocked |= find_beyond_walls(params, state.robots)
    if params.robots.avoid_collisions:
        blocked |= find_colliding(params, state.robots, state.links, state.sets[Set.THERE, 0])
    blocked &= state.sets[Set.WORKING, 0]
    state.sets[Set.BLOCKED, 0] = blocked
    if blocked == 0 and params.arena.wraps:
        move_freely(state, part)
    else:
        move_unless(params, state.robots, blocked)


@called
def find_beyond_walls(params, robots):
    """Return the set of robots whose step leads beyond a wall."""
    xs, ys = robots[Robot.X], robots[Robot.Y]
    steps_x, steps_y = robots[Robot.STEP_X], robots[Robot.STEP_Y]
    low, right = params.robots.radius, params.arena.width - params.robots.radius
    top = params.arena.height - params.robots.radius
    found = uint32(0)
    for i in range(32):
        x, y = int64(uint32(xs[i])) + int64(steps_x[i]), int64(uint32(ys[i])) + int64(steps_y[i])
        found |= bit_if((x < low) | (y < low) | (x > right) | (y > top), i)
    return found


@called
def move_unless(params, robots, blocked):
    """Move all robots but those of a set; a torus whose sides differ doesn't wrap by itself."""
    xs, ys = robots[Robot.X], robots[Robot.Y]
    steps_x, steps_y = robots[Robot.STEP_X], robots[Robot.STEP_Y]
    wraps, width, height = params.arena.wraps, params.arena.width, params.arena.height
    for i in range(32):
        moves = -int32(has_bit(~blocked, i))
        step_x, step_y = steps_x[i] & moves, steps_y[i] & moves
        x, y = int64(uint32(xs[i])) + int64(step_x), int64(uint32(ys[i])) + int64(step_y)
        xs[i] = int32(uint32(x if wraps else around(x, width)))
        ys[i] = int32(uint32(y if wraps else around(y, height)))


@called
def find_colliding(params, robots, links, there):
    """Return the set of those robots that are there whose step meets another, which may move too or stay."""
    band, close_by = params.robots.meet_band, links[Link.CLOSE]
    if params.arena.wraps and band.low > 0:  # some that are too far do no harm
        high = uint32(band.low + band.width)
        find_near(robots[Robot.X], robots[Robot.Y], close_by, params.robots.count, high, uint32(0))
    else:
        find_exactly(params, robots, close_by, params.robots.meet_limit)
    if params.changes:
        keep_only(close_by, there)
    found = uint32(0)
    for i in range(1, params.robots.count):
        close = close_by[i] & first_bits(i)
        while close:
            j = lowest(close)
            found |= who_collides(params, robots, i, j)
            close = without_lowest(close)
    return found


@inlined
def who_collides(params, robots, i, j):
    """Return the set of those of two robots whose step meets the other, which may move too or stay.

    Without a branch, unless floats leave it in doubt. A stopped robot has step 0.
    """
    way_x, way_y = way_between(params, robots, i, j)
    ix, iy = int64(robots[Robot.STEP_X, i]), int64(robots[Robot.STEP_Y, i])
    jx, jy = int64(robots[Robot.STEP_X, j]), int64(robots[Robot.STEP_Y, j])
    apart = way_x * way_x + way_y * way_y
    along_i, along_j = -(way_x * ix + way_y * iy), way_x * jx + way_y * jy
    across_i, across_j = way_y * ix - way_x * iy, way_x * jy - way_y * jx
    length_i, length_j = ix * ix + iy * iy, jx * jx + jy * jy
    length_both = length_i + length_j - 2 * (ix * jx + iy * jy)
    meets_i, sure_i = meets(params, apart, along_i, across_i, length_i)
    meets_j, sure_j = meets(params, apart, along_j, across_j, length_j)
    meets_both, sure_both = meets(params, apart, along_i + along_j, across_i + across_j, length_both)
    # Opposite to each other on the torus, both take the way round in the same direction.
    is_opposite = (2 * abs(way_x) == params.arena.width) | (2 * abs(way_y) == params.arena.height)
    if sure_i & sure_j & sure_both & ~is_opposite:
        return bit_if(meets_i | meets_both, i) | bit_if(meets_j | meets_both, j)
    return bit_if(collides(params, robots, i, j), i) | bit_if(collides(params, robots, j, i), j)


@inlined
def way_between(params, robots, i, j):
    """Return the way from a robot to another, along x and y."""
    way_x = int64(uint32(robots[Robot.X, j])) - int64(uint32(robots[Robot.X, i]))
    way_y = int64(uint32(robots[Robot.Y, j])) - int64(uint32(robots[Robot.Y, i]))
    if params.arena.walls:
        return way_x, way_y
    return shortest(way_x, params.arena.width), shortest(way_y, params.arena.height)


@inlined
def meets(params, apart, along, across, length):
    """Return whether two discs overlap at some moment of a step, as `meet` does, and whether that is sure.

    The squared distance is ``apart`` at the start and ``apart + 2 along + length`` at the end.
    """
    limit = int64(params.robots.apart_limit)
    passes = (along < 0) & (-along < length)
    at_ends = apart + (int64(0) if along >= 0 else 2 * along + length) < limit
    squared, least = float64(across) * float64(across), float64(limit) * float64(length)
    sure = (abs(squared - least) > SURELY * least) | ~passes
    return (passes & (squared < least)) | (~passes & at_ends), sure


@called
def collides(params, robots, i, other):
    """Return whether a robot's step meets another, by exact arithmetic."""
    way_x, way_y = way_between(params, robots, i, other)
    dx, dy = -int64(robots[Robot.STEP_X, i]), -int64(robots[Robot.STEP_Y, i])
    both_x, both_y = dx + int64(robots[Robot.STEP_X, other]), dy + int64(robots[Robot.STEP_Y, other])
    return meet(params, way_x, way_y, dx, dy) or meet(params, way_x, way_y, both_x, both_y)


@spliced
def sense_general_few(params, state, functions, part):
    """Let exploring robots observe and listening robots receive (model.md 6.3, 6.5, 6.6).

    What a robot observes in a step it knows before it receives messages.
    """
    publish(params, state, functions, part)
    observe_few(params, state, functions, part)
    count_all_false_sightings(params, state, functions, part)
    update_pending(params, state, functions, Action.OBSERVE)
    find_listeners(params, state, part)
    hear_few(params, state, functions, part)
    update_pending(params, state, functions, Action.MERGE)


@inlined
def find_sight(params, state, reach):
    """Store the set of robots within a range of each robot; ``reach`` has its limit and band."""
    low, width, sight = reach.band.low, reach.band.width, state.links[Link.SIGHT]
    sure = params.arena.wraps and find_roughly(state.robots, sight, params.robots.count, low, width)
    if not sure:
        find_exactly(params, state.robots, sight, reach.limit)
    if params.changes:
        keep_only(sight, state.sets[Set.THERE, 0])


@inlined
def keep_only(links, there):
    """Leave those robots out of each robot's set that aren't there."""
    for i in range(32):
        links[i] &= there & -uint32(has_bit(there, i))


@called
def find_roughly(robots, sight, count, low, width):
    """Store who is near each robot by 16 bits of each coordinate; return whether all are sure."""
    return find_near(robots[Robot.X], robots[Robot.Y], sight, count, low, width)


@called
def find_exactly(params, robots, sight, limit):
    """Store who is near each robot."""
    for i in range(params.robots.count):
        x, y = robots[Robot.X, i], robots[Robot.Y, i]
        sight[i] = near(params, robots, 0, params.robots.count, x, y, limit) & ~bit(i)


@spliced
def observe_few(params, state, functions, part):
    """Observe the robots and tasks in sight of the exploring robots (model.md 6.3)."""
    find_sight(params, state, params.sensing)
    looking = uint32(~state.sets[Set.DISSEMINATING, 0] & state.sets[Set.WORKING, 0])
    if params.sensing.counts_all:
        sight, seen = state.links[Link.SIGHT], state.counts[Count.ROBOTS_SEEN]
        for i in range(32):
            seen[i] += -int64(has_bit(looking, i)) & (popcount(sight[i]) + params.sensing.count_self)
    while looking:
        i = lowest(looking)
        if not params.sensing.counts_all:
            observe_neighbours(params, state, functions, i)
        if params.tasks.numbered:
            tasks = observe_numbered(params, state, functions, i)
            if params.sensing.only_counts:
                state.counts[Count.TASKS_SEEN, i] += tasks
        looking = without_lowest(looking)
    if not params.tasks.numbered:
        observe_tasks(params, state, functions, part)


@inlined
def observe_neighbours(params, state, functions, i):
    """Observe the robots in sight of a robot."""
    seen = not_missed(params, state, i, state.links[Link.SIGHT, i], int64(MISS_ROBOT))
    if params.sensing.count_self == 1:
        seen |= bit(i)
    seen = new_ones(params, state, i, 0, seen)
    if params.sensing.only_counts:
        state.counts[Count.ROBOTS_SEEN, i] += popcount(seen)
        return
    count_sightings(params, state, functions, i, seen, int64(0), int64(0))


@inlined
def observe_numbered(params, state, functions, i):
    """Observe the tasks in sight of a robot, 32 at a time by number; return how many count."""
    x, y = state.robots[Robot.X, i], state.robots[Robot.Y, i]
    total = int64(0)
    for w in range(-(-params.tasks.count // WORD)):
        seen = tasks_near(params, state, w, x, y)
        if params.sensing.counts_all:
            total += popcount(seen)
            continue
        seen = not_missed(params, state, i, seen, int64(MISS_TASK + PAIR * WORD * w))
        seen = new_ones(params, state, i, 1 + w, seen)
        if params.sensing.only_counts:
            total += popcount(seen)
            continue
        first = params.robots.count + WORD * w
        count_sightings(params, state, functions, i, seen, first, params.robots.classes)
    return total


@inlined
def count_sightings(params, state, functions, i, seen, first, classes):
    """Count the members of a word of robots or tasks by class, or add them to what the robot knows.

    ``first`` is the number of the lowest and ``classes`` that of the classes before theirs.
    """
    if params.strategy.knowledge.enabled:
        defer_all(params, state, functions, Action.OBSERVE, i, seen, first)
        return
    while seen:
        kind = int64(state.tables.class_of[first + lowest(seen)])
        state.seen[i, classes + kind] += 1
        seen = without_lowest(seen)


@inlined
def tasks_near(params, state, w, x, y):
    """Return which of the tasks of a word are in sight of a place."""
    places, low, width = state.task_lists.places, params.sensing.band.low, params.sensing.band.width
    place = pack_place(x, y, uint32(16))
    first, doubtful_first = within_roughly(places, WORD * w, place, low, width)
    second, doubtful_second = within_roughly(places, WORD * w + 16, place, low, width)
    members = state.tasks_there[w]
    close = uint32(first | uint32(second << uint32(16))) & members
    doubtful = uint32(doubtful_first | uint32(doubtful_second << uint32(16))) & members
    while doubtful:
        task = lowest_member(w, doubtful)
        way_x = int64(int32(x - state.tasks[Point.X, task]))
        way_y = int64(int32(y - state.tasks[Point.Y, task]))
        is_near = uint64(way_x * way_x + way_y * way_y) < params.sensing.limit
        close = uint32(close & ~bit(task)) | bit_if(is_near, task)
        doubtful = without_lowest(doubtful)
    return close


@inlined
def not_missed(params, state, i, things, purpose):
    """Return the set of things in sight that a robot doesn't miss; ``purpose`` is that of the first thing."""
    miss = state.clock[Clock.MISS]
    if miss == 0:
        return things
    run, now = state.clock[Clock.RUN], state.clock[Clock.STEP] + 1
    return without_unlucky(params, run, now, i, things, purpose, uint64(miss))


@inlined
def new_ones(params, state, i, w, things):
    """Return the set of things that count, if things count once: those not remembered; remember them."""
    if not params.sensing.unique:
        return things
    remembered = state.remembered[i, w]
    state.remembered[i, w] = remembered | things
    return uint32(things & ~remembered)


@called
def without_unlucky(params, run, now, i, others, purpose, probability):
    """Return a set without those for which an event happens to a robot in this step."""
    left = others
    while left:
        other = lowest(left)
        word = draw(params, run, i, now, purpose + PAIR * other)
        if uint64(word) < probability:
            others &= ~bit(other)
        left = without_lowest(left)
    return others


@spliced
def hear_few(params, state, functions, part):
    """Let the listening robots receive what the robots in radio range of them send (model.md 6.5, 6.6)."""
    speaking = state.sets[Set.SPEAKING, 0]
    if speaking == 0:
        return
    if params.radio.limit != params.sensing.limit:
        find_sight(params, state, params.radio)
    heard = state.links[Link.SIGHT]
    for i in range(32):
        heard[i] &= speaking & -uint32(has_bit(state.sets[Set.LISTENING, 0], i))
    loss = uint64(state.clock[Clock.LOSS])
    if loss > 0:
        run, now = state.clock[Clock.RUN], state.clock[Clock.STEP] + 1
        for i in range(params.robots.count):
            heard[i] = without_unlucky(params, run, now, int64(i), heard[i], int64(LOSS), loss)
    if params.strategy.knowledge.enabled:
        merge_heard(params, state, functions)
    if params.decision.commit.enabled or not params.strategy.knowledge.enabled:
        receive_heard(params, state, part)


@inlined
def merge_heard(params, state, functions):
    """Let robots that pass on knowledge merge what they hear."""
    for i in range(params.robots.count):
        heard = state.links[Link.SIGHT, i]
        defer_all(params, state, functions, Action.MERGE, int64(i), heard, int64(0))


@inlined
def receive_heard(params, state, part):
    """Add what robots hear to their inboxes."""
    said = sent_opinions(state)
    if params.decision.inbox_is_set:
        receive_together(params, state, state.sets[Set.SPEAKING, 0], said)
        return
    for i in range(params.robots.count):
        heard = state.links[Link.SIGHT, i]
        while heard:
            j = lowest(heard)
            message = pack_label(state.robots[Robot.IDENTITY, j], has_bit(said, j), True)
            receive(params, state, part, i, message, state.robots[Robot.SENT_VALUE, j])
            heard = without_lowest(heard)


@inlined
def sent_opinions(state):
    """Return the set of robots whose messages say *feasible*; the labels of Byzantine robots have it."""
    said = state.sets[Set.SAYS_FEASIBLE, 0]
    lying = uint32(state.sets[Set.BYZANTINE, 0] & state.sets[Set.SPEAKING, 0])
    while lying:
        i = lowest(lying)
        said = uint32(said & ~bit(i)) | bit_if(says_feasible(state.robots[Robot.LABEL, i]) == 1, i)
        lying = without_lowest(lying)
    return said


@called
def number_tasks(places, xs, ys, count):
    """Store 16 bits of each coordinate of the tasks, in the order of their numbers."""
    for task in range(count):
        places[task] = pack_place(xs[task], ys[task], uint32(16))
