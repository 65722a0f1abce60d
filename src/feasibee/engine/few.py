"""Up to 32 robots in the general engine: their neighbours as sets, found at once (model.md 6.3 to 6.6).

Places are compared in 16 bits first, and exactly where these leave a range in doubt. Larger swarms sense
robot by robot: see `feasibee.engine.sensing`. What takes the state is inlined, since passing it 20 times a
step took a fifth of the time.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.bits import (
    bit,
    bit_if,
    has_bit,
    lowest_member,
    pack_label,
    says_feasible,
    without_lowest,
)
from feasibee.engine.cells import near
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.draws import draw
from feasibee.engine.inbox import receive, receive_together
from feasibee.engine.intrinsics import find_near, lowest, popcount, within_roughly
from feasibee.engine.knowledge import defer_all, update_pending
from feasibee.engine.layout import WORD, Clock, Count, Link, Point, Robot, Set
from feasibee.engine.params import Action
from feasibee.engine.publishing import publish
from feasibee.engine.sensing import (
    count_all_false_sightings,
    find_listeners,
    observe_tasks,
)
from feasibee.engine.tasklists import pack_place
from feasibee.model.purposes import LOSS, MISS_ROBOT, MISS_TASK, PAIR


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
