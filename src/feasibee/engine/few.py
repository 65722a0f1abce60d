"""Sight, radio, walls and collisions of up to 64 robots at once, in sets of one word or two.

Places are compared in 16 bits first, and exactly where these leave a range in doubt. Larger swarms sense
robot by robot: see `feasibee.engine.sensing`. What takes the state is inlined, since passing it 20 times a
step took a fifth of the time.

The pairs that may meet are listed once, and all of them tested together. Larger swarms do so word by word:
see `feasibee.engine.bodies`.
"""

from __future__ import annotations

from numba import int32, int64, uint32, uint64

from feasibee.engine.bodies import (
    TOGETHER,
    around,
    find_beyond_walls,
    find_walls_beside,
    meets,
    meets_exactly,
    repeat_last,
    short_way,
    turn_away,
)
from feasibee.engine.cells import near
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.draws import draw
from feasibee.engine.inbox import receive, receive_together
from feasibee.engine.intrinsics import (
    bit,
    bit_if,
    contains,
    find_near,
    first_bits,
    has_bit,
    lowest,
    lowest_member,
    pack_label,
    popcount,
    says_feasible,
    within_roughly,
    without_lowest,
)
from feasibee.engine.knowledge import defer_all, publish, update_pending
from feasibee.engine.layout import WORD, Clock, Count, Heard, Link, Point, Robot, Set, Share
from feasibee.engine.motion import move_freely
from feasibee.engine.params import ALWAYS, Action
from feasibee.engine.sensing import (
    count_all_false_sightings,
    count_listed,
    find_listeners,
    observe_tasks,
    pack_place,
)
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


@spliced
def sense_together(params, state, part):
    """Let exploring robots observe and listening robots receive, on the fast path."""
    xs, ys = state.robots[Robot.X], state.robots[Robot.Y]
    speaking, disseminating = state.sets[Set.SPEAKING], state.sets[Set.DISSEMINATING]
    bits_sent = int64(0)
    for w in range(part.first, part.last):
        bits_sent += popcount(speaking[w]) * params.radio.message_bits
    part.shared[part.thread, Share.BITS] = bits_sent
    find_sight(params, state, params.sensing, part)
    for w in range(part.first, part.last):
        looking = uint32(first_bits(params.robots.count - WORD * w) & ~disseminating[w])
        while looking:
            i = lowest_member(w, looking)
            state.counts[Count.TASKS_SEEN, i] += count_listed(params, state, xs[i], ys[i])
            looking = without_lowest(looking)
        count_in_sight(params, state, part, w, ~disseminating[w])
    if params.radio.limit != params.sensing.limit:
        find_sight(params, state, params.radio, part)
    if params.decision.listens_for != ALWAYS:
        for other in range(part.first, part.last):
            for i in range(params.robots.count):
                if not contains(disseminating, i):
                    state.links[Link.SIGHT, other, i] = uint32(0)
    for other in range(part.first, part.last):
        receive_together(params, state, part, other, speaking[other], state.sets[Set.SAYS_FEASIBLE, other])


@inlined
def count_in_sight(params, state, part, w, looking):
    """Count the robots in sight of those of a word that look."""
    seen = state.counts[Count.ROBOTS_SEEN]
    for other in range(part.first, part.last):
        sight = state.links[Link.SIGHT, other]
        own = params.sensing.count_self * int64(other == w)
        for i in range(WORD * w, WORD * w + WORD):
            seen[i] += -int64(has_bit(looking, i)) & (popcount(sight[i]) + own)


@inlined
def find_sight(params, state, reach, part):
    """Store the set of robots within a range of each robot; ``reach`` has its limit and band."""
    sight = state.links[Link.SIGHT]
    sure = params.arena.wraps and find_roughly(
        params, state.robots, sight, reach.band.low, reach.band.width, part.last
    )
    if not sure:
        find_exactly(params, state.robots, sight, reach.limit)
    if params.changes:
        keep_only(sight, state.sets[Set.THERE], part)


@inlined
def keep_only(links, there, part):
    """Leave those robots out of each robot's set that aren't there."""
    for other in range(part.first, part.last):
        for i in range(WORD * part.last):
            links[other, i] &= there[other] & -uint32(contains(there, i))


@called
def find_roughly(params, robots, sight, low, width, words):
    """Store who is near each robot by 16 bits of each coordinate; return whether all are sure."""
    xs, ys, sure = robots[Robot.X], robots[Robot.Y], True
    for other in range(words):
        count = min(params.robots.count - WORD * other, WORD)
        for w in range(words):
            sure &= find_near(xs, ys, sight[other], WORD * w, WORD * other, count, low, width)
    return sure


@called
def find_exactly(params, robots, sight, limit):
    """Store who is near each robot, also where 16 bits leave it in doubt: in 1 of 100 steps of 20 robots."""
    count = params.robots.count
    for other in range(sight.shape[0]):
        first = WORD * other
        for i in range(count):
            x, y = robots[Robot.X, i], robots[Robot.Y, i]
            close = near(params, robots, first, min(first + WORD, count), x, y, limit)
            sight[other, i] = close & ~bit_if(i >> 5 == other, i)


@spliced
def observe_few(params, state, functions, part):
    """Observe the robots and tasks in sight of the exploring robots (model.md 6.3)."""
    find_sight(params, state, params.sensing, part)
    for w in range(part.first, part.last):
        looking = uint32(~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w])
        if params.sensing.counts_all:
            count_in_sight(params, state, part, w, looking)
        while looking:
            i = lowest_member(w, looking)
            if not params.sensing.counts_all:
                observe_neighbours(params, state, functions, part, i)
            if params.tasks.numbered:
                tasks = observe_numbered(params, state, functions, part, i)
                if params.sensing.only_counts:
                    state.counts[Count.TASKS_SEEN, i] += tasks
            looking = without_lowest(looking)
    if not params.tasks.numbered:
        observe_tasks(params, state, functions, part)


@inlined
def observe_neighbours(params, state, functions, part, i):
    """Observe the robots in sight of a robot."""
    for other in range(part.first, part.last):
        first = WORD * other
        sight = state.links[Link.SIGHT, other, i]
        seen = not_missed(params, state, i, sight, int64(MISS_ROBOT + PAIR * first))
        if params.sensing.count_self == 1:
            seen |= bit_if(i >> 5 == other, i)
        seen = new_ones(params, state, i, other, seen)
        if params.sensing.only_counts:
            state.counts[Count.ROBOTS_SEEN, i] += popcount(seen)
        else:
            count_sightings(params, state, functions, i, seen, first, int64(0))


@inlined
def observe_numbered(params, state, functions, part, i):
    """Observe the tasks in sight of a robot, 32 at a time by number; return how many count."""
    x, y = state.robots[Robot.X, i], state.robots[Robot.Y, i]
    total = int64(0)
    for w in range(-(-params.tasks.count // WORD)):
        seen = tasks_near(params, state, w, x, y)
        if params.sensing.counts_all:
            total += popcount(seen)
            continue
        seen = not_missed(params, state, i, seen, int64(MISS_TASK + PAIR * WORD * w))
        seen = new_ones(params, state, i, part.last + w, seen)
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
    anyone = uint32(0)
    for w in range(part.first, part.last):
        anyone |= state.sets[Set.SPEAKING, w]
    if anyone == 0:
        return
    if params.radio.limit != params.sensing.limit:
        find_sight(params, state, params.radio, part)
    for other in range(part.first, part.last):
        find_heard(params, state, part, other)
    if params.strategy.knowledge.enabled:
        for i in range(params.robots.count):
            for other in range(part.first, part.last):
                heard = state.links[Link.SIGHT, other, i]
                defer_all(params, state, functions, Action.MERGE, int64(i), heard, WORD * other)
    if params.decision.declare.enabled or not params.strategy.knowledge.enabled:
        receive_heard(params, state, part)


@inlined
def find_heard(params, state, part, other):
    """Keep those robots of a word in each robot's sight that it hears."""
    heard, listening = state.links[Link.SIGHT, other], state.sets[Set.LISTENING]
    speaking = state.sets[Set.SPEAKING, other]
    for i in range(WORD * part.last):
        heard[i] &= speaking & -uint32(contains(listening, i))
    loss = uint64(state.clock[Clock.LOSS])
    if loss > 0:
        run, now, purpose = (
            state.clock[Clock.RUN],
            state.clock[Clock.STEP] + 1,
            int64(LOSS + PAIR * WORD * other),
        )
        for i in range(params.robots.count):
            heard[i] = without_unlucky(params, run, now, int64(i), heard[i], purpose, loss)


@inlined
def receive_heard(params, state, part):
    """Add what robots hear to their inboxes."""
    for other in range(part.first, part.last):
        said = sent_opinions(state, other)
        if params.decision.inbox_is_set:
            receive_together(params, state, part, other, state.sets[Set.SPEAKING, other], said)
            continue
        for i in range(params.robots.count):
            heard = state.links[Link.SIGHT, other, i]
            while heard:
                j = lowest_member(other, heard)
                message = pack_label(state.robots[Robot.IDENTITY, j], has_bit(said, j), True)
                receive(params, state, part, i, message, state.robots[Robot.SENT_VALUE, j])
                heard = without_lowest(heard)


@inlined
def sent_opinions(state, w):
    """Return which robots' messages say *feasible*, of a word; the labels of Byzantine robots have it."""
    said = state.sets[Set.SAYS_FEASIBLE, w]
    lying = uint32(state.sets[Set.BYZANTINE, w] & state.sets[Set.SPEAKING, w])
    while lying:
        i = lowest_member(w, lying)
        said = uint32(said & ~bit(i)) | bit_if(says_feasible(state.robots[Robot.LABEL, i]) == 1, i)
        lying = without_lowest(lying)
    return said


@spliced
def move_few(params, state, part):
    """Move each robot whose way is clear; the others stay and will turn (model.md 6.1, 6.2)."""
    standing = find_standing(params, state, part)
    for w in range(part.first, part.last):
        state.sets[Set.BLOCKED, w] = word_of(standing, w)
    if standing == 0 and params.arena.wraps:
        move_freely(state, part)
    else:
        move_unless(params, state.robots, standing)


@inlined
def word_of(both, w):
    """Return one word of a set of up to 64 robots."""
    return uint32(both >> uint64(WORD * w))


@inlined
def widened(word, w):
    """Return the set of up to 64 robots of one word."""
    return uint64(word) << uint64(WORD * w)


@inlined
def both_of(words, part):
    """Return the words of a set of up to 64 robots as one."""
    both = uint64(0)
    for w in range(part.first, part.last):
        both |= widened(words[w], w)
    return both


@spliced
def find_standing(params, state, part):
    """Return the set of robots that stand in this step. The steps of others may turn."""
    robots, pairs, listed = state.robots, state.heard[part.thread], int64(0)
    if params.robots.avoid_collisions:
        listed = list_pairs(params, robots, state.links[Link.CLOSE], state.sets[Set.THERE], pairs, part)
    blocked, left, right = find_meeting(params, robots, pairs, listed, ~uint64(0))
    blocked = uint64(
        (blocked | find_all_beyond(params, robots, part)) & both_of(state.sets[Set.WORKING], part)
    )
    if params.robots.deflects and blocked:
        for w in range(part.first, part.last):
            wall_left, wall_right = find_walls_beside(params, robots, w)
            left, right = left | widened(wall_left, w), right | widened(wall_right, w)
        blocked = deflect_few(params, robots, pairs, listed, blocked, uint64(right | ~left), part)
    return blocked


@inlined
def find_all_beyond(params, robots, part):
    """Return the set of robots whose step leads beyond a wall."""
    beyond = uint64(0)
    for w in range(part.first, part.last):
        beyond |= widened(find_beyond_walls(params, robots, w), w)
    return beyond


@called
def move_unless(params, robots, blocked):
    """Move all robots but those of a set; a torus whose sides differ doesn't wrap by itself."""
    xs, ys = robots[Robot.X], robots[Robot.Y]
    steps_x, steps_y = robots[Robot.STEP_X], robots[Robot.STEP_Y]
    wraps, width, height = params.arena.wraps, params.arena.width, params.arena.height
    for i in range(xs.size):
        moves = -int32(is_among(~blocked, i))
        step_x, step_y = steps_x[i] & moves, steps_y[i] & moves
        x, y = int64(uint32(xs[i])) + int64(step_x), int64(uint32(ys[i])) + int64(step_y)
        xs[i] = int32(uint32(x if wraps else around(x, width)))
        ys[i] = int32(uint32(y if wraps else around(y, height)))


@spliced
def list_pairs(params, robots, close_by, there, pairs, part):
    """List the pairs of robots that are there and may meet within a step; return their number."""
    band, listed = params.robots.meet_band, int64(0)
    if params.arena.wraps and band.low > 0:  # some that are too far do no harm
        find_roughly(params, robots, close_by, uint32(band.low + band.width), uint32(0), part.last)
    else:
        find_exactly(params, robots, close_by, params.robots.meet_limit)
    if params.changes:
        keep_only(close_by, there, part)
    for other in range(part.first, part.last):
        for w in range(other, part.last):
            listed = list_pairs_of(params, close_by[other], other, w, pairs, listed)
    repeat_last(pairs[Heard.RECEIVER], pairs[Heard.SENDER], listed)
    return listed


@called
def list_pairs_of(params, close_by, other, w, pairs, listed):
    """List the pairs of a robot of one word and a lower one of another word; return the number of pairs."""
    rows = uint32(0)
    for i in range(WORD * w, WORD * w + WORD):
        close_by[i] &= first_bits(i - WORD * other)
        rows |= bit_if(close_by[i] != 0, i)
    rows &= first_bits(params.robots.count - WORD * w)
    firsts, seconds = pairs[Heard.RECEIVER], pairs[Heard.SENDER]
    while rows:  # one loop over pairs: an inner one for each robot would often be mispredicted
        i = lowest_member(w, rows)
        close = close_by[i]
        firsts[listed], seconds[listed] = int32(i), int32(lowest_member(other, close))
        close_by[i] = without_lowest(close)
        rows &= ~bit_if(without_lowest(close) == 0, i)
        listed += 1
    return listed


@called
def keep_pairs(pairs, listed, members):
    """Keep those pairs of a list of which one or both are in a set; return their number."""
    firsts, seconds, kept = pairs[Heard.RECEIVER], pairs[Heard.SENDER], int64(0)
    for k in range(listed):
        i, j = firsts[k], seconds[k]
        firsts[kept], seconds[kept] = i, j
        kept += int64(is_among(members, i) | is_among(members, j))
    repeat_last(firsts, seconds, kept)
    return kept


@called
def find_meeting(params, robots, pairs, listed, staying):
    """Return which robots of listed pairs meet the other, and which of these have it on the left and right.

    The other one moves, or may stay if it is a member of ``staying``. A stopped robot has step 0. Without a
    branch, so that LLVM vectorizes the loop, unless floats leave a pair in doubt.
    """
    xs, ys, us, vs = robots[Robot.X], robots[Robot.Y], robots[Robot.STEP_X], robots[Robot.STEP_Y]
    firsts, seconds = pairs[Heard.RECEIVER], pairs[Heard.SENDER]
    arena, limit = params.arena, int64(params.robots.apart_limit)
    walls, width, height = arena.walls, arena.width, arena.height
    found, left, right, doubtful = uint64(0), uint64(0), uint64(0), False
    for k in range((listed + TOGETHER - 1) & -TOGETHER):
        i, j = uint64(uint32(firsts[k])), uint64(uint32(seconds[k]))
        way_x = short_way(xs[i], xs[j], width, walls)
        way_y = short_way(ys[i], ys[j], height, walls)
        ix, iy, jx, jy = int64(us[i]), int64(vs[i]), int64(us[j]), int64(vs[j])
        apart = way_x * way_x + way_y * way_y
        along_i, along_j = -(way_x * ix + way_y * iy), way_x * jx + way_y * jy
        across_i, across_j = way_y * ix - way_x * iy, way_x * jy - way_y * jx
        length_i, length_j = ix * ix + iy * iy, jx * jx + jy * jy
        length = length_i + length_j - 2 * (ix * jx + iy * jy)
        meets_i, sure_i = meets(limit, apart, along_i, across_i, length_i)
        meets_j, sure_j = meets(limit, apart, along_j, across_j, length_j)
        meets_both, sure = meets(limit, apart, along_i + along_j, across_i + across_j, length)
        # Opposite to each other on the torus, both take the way round in the same direction.
        doubtful |= (2 * abs(way_x) == width) | (2 * abs(way_y) == height) | (not (sure & sure_i & sure_j))
        meets_i = meets_both | (meets_i & is_among(staying, j))
        meets_j = meets_both | (meets_j & is_among(staying, i))
        found |= only_if(meets_i, i) | only_if(meets_j, j)
        left |= only_if(meets_i & (across_i > 0), i) | only_if(meets_j & (across_j > 0), j)
        right |= only_if(meets_i & (across_i < 0), i) | only_if(meets_j & (across_j < 0), j)
    if doubtful:
        return find_meeting_exactly(params, robots, pairs, listed, staying)
    return found, left, right


@called
def find_meeting_exactly(params, robots, pairs, listed, staying):
    """Return what `find_meeting` returns, by exact arithmetic."""
    found, left, right = uint64(0), uint64(0), uint64(0)
    for k in range(2 * listed):
        own, other = (Heard.RECEIVER, Heard.SENDER) if k & 1 else (Heard.SENDER, Heard.RECEIVER)
        i, j = int64(pairs[own, k >> 1]), int64(pairs[other, k >> 1])
        met, side = meets_exactly(params, robots, i, j, is_among(staying, j))
        found |= only_if(met, i)
        left |= only_if(met and side > 0, i)
        right |= only_if(met and side < 0, i)
    return found, left, right


@spliced
def deflect_few(params, robots, pairs, listed, blocked, turning_left, part):
    """Let the blocked robots turn away twice, as long as they are blocked; return those that still are.

    Their steps change, also of those that stay blocked: these draw a new heading (model.md 6.2.2 to 6.2.5).
    """
    for _ in range(2):
        for w in range(part.first, part.last):
            turn_away(robots, word_of(turning_left, w), word_of(blocked, w), w)
        beyond = find_all_beyond(params, robots, part)  # first: what gathers the steps waits for them
        listed = keep_pairs(pairs, listed, blocked)
        met, _, _ = find_meeting(params, robots, pairs, listed, blocked)
        blocked &= met | beyond
        if blocked == 0:
            break
    return blocked


@inlined
def is_among(both, i):
    """Return whether a set of up to 64 robots has robot i."""
    return uint64(both >> uint64(i)) & uint64(1) == uint64(1)


@inlined
def only_if(member, i):
    """Return the set of up to 64 robots with only robot i if it is a member, else the empty set."""
    return uint64(uint64(member) << uint64(i))
