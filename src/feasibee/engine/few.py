"""Sight, radio, walls and collisions of up to 128 robots at once, a pair of words of them after the other.

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
from feasibee.engine.draws import draw, rounds
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
from feasibee.engine.layout import (
    HEARD_ROOM,
    WORD,
    Clock,
    Count,
    Heard,
    Link,
    Point,
    Robot,
    Sense,
    Set,
)
from feasibee.engine.motion import move_freely
from feasibee.engine.params import Action, Moment
from feasibee.engine.place import drop_cut
from feasibee.engine.queues import store_members
from feasibee.engine.sensing import (
    count_all_false_sightings,
    find_listeners,
    observe_tasks,
    pack_place,
)
from feasibee.engine.view import drop_hidden, may_hide, seen_tasks
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
    find_all_near(params, state.robots, state.links[Link.SIGHT], reach.limit, reach.band, part.last)
    if params.changes:
        keep_only(state.links[Link.SIGHT], state.sets[Set.THERE], part)


@inlined
def keep_only(links, there, part):
    """Leave those robots out of each robot's set that aren't there."""
    for other in range(part.first, part.last):
        for i in range(WORD * part.last):
            links[other, i] &= there[other] & -uint32(contains(there, i))


@called
def find_all_near(params, robots, sight, limit, band, words):
    """Store who is near each robot, by 16 bits of each coordinate where these leave none in doubt."""
    xs, ys = robots[Robot.X], robots[Robot.Y]
    for other in range(words):
        first, count = WORD * other, min(params.robots.count - WORD * other, WORD)
        for w in range(words):
            sure = params.arena.wraps and find_near(
                xs, ys, sight[other], WORD * w, first, count, band.low, band.width
            )
            if not sure:
                find_near_exactly(params, robots, sight[other], w, other, limit)


@called
def find_near_exactly(params, robots, sight, w, other, limit):
    """Store which robots of one word are near each of another: in 1 of 100 steps of 20 robots."""
    first, count = WORD * other, params.robots.count
    for i in range(WORD * w, min(WORD * w + WORD, count)):
        x, y = robots[Robot.X, i], robots[Robot.Y, i]
        close = near(params, robots, first, min(first + WORD, count), x, y, limit)
        sight[i] = close & ~bit_if(w == other, i)


@spliced
def observe_few(params, state, functions, part):
    """Observe the robots and tasks in sight of the exploring robots (model.md 6.3)."""
    find_sight(params, state, params.sensing, part)
    for w in range(part.first, part.last):
        state.sets[Set.LOOKING, w] = ~state.sets[Set.DISSEMINATING, w] & state.sets[Set.WORKING, w]
    if params.sensing.hides:
        drop_hidden(params, state, part, state.sets[Set.LOOKING])
    if not params.sensing.counts_all:
        drop_unlucky(params, state, part, state.sets[Set.LOOKING], MISS_ROBOT, state.clock[Clock.MISS])
    for w in range(part.first, part.last):
        looking = state.sets[Set.LOOKING, w]
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
        seen = state.links[Link.SIGHT, other, i]
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
    total, hides = int64(0), params.sensing.hides and may_hide(params, state, i)
    for w in range(-(-params.tasks.count // WORD)):
        seen = tasks_near(params, state, w, x, y)
        if hides and seen:
            seen = seen_tasks(params, state, seen, w, i)
        if params.sensing.counts_all:
            total += popcount(seen)
            continue
        seen = not_missed(params, state, i, seen, w)
        if seen and params.acting.acts:
            functions.act(params, state, int64(Moment.SEE), int64(i), int64(w), uint32(seen))
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
    places, low, width = state.task_places, params.sensing.band.low, params.sensing.band.width
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
def not_missed(params, state, i, tasks, w):
    """Return which of the tasks of a word that are in sight a robot doesn't miss."""
    miss, run, now = uint64(state.clock[Clock.MISS]), state.clock[Clock.RUN], state.clock[Clock.STEP] + 1
    left = tasks if miss > 0 else uint32(0)
    while left:
        task = lowest_member(w, left)
        if uint64(draw(params, run, i, now, int64(MISS_TASK + PAIR * task))) < miss:
            tasks &= ~bit(task)
        left = without_lowest(left)
    return tasks


@inlined
def new_ones(params, state, i, w, things):
    """Return the set of things that count, if things count once: those not remembered; remember them."""
    if not params.sensing.unique:
        return things
    remembered = state.remembered[i, w]
    state.remembered[i, w] = remembered | things
    return uint32(things & ~remembered)


@inlined
def drop_unlucky(params, state, part, asked, purpose, probability):
    """Leave those out of the sets of the robots of ``asked`` to which an event happens in this step."""
    if probability == 0:
        return
    links, pairs, listed = state.links[Link.SIGHT], state.heard[part.thread], int64(0)
    for other in range(part.first, part.last):
        for i in range(params.robots.count):
            members = links[other, i] & -uint32(contains(asked, i))
            listed += store_members(
                pairs[Heard.RECEIVER], pairs[Heard.SENDER], listed, int32(i), members, int32(WORD * other)
            )
            if listed > HEARD_ROOM:
                drop_listed(params, state.clock, links, pairs, listed, purpose, uint64(probability))
                listed = int64(0)
    drop_listed(params, state.clock, links, pairs, listed, purpose, uint64(probability))


@called
def drop_listed(params, clock, links, pairs, listed, purpose, probability):
    """Leave the second of a listed pair out of the first one's set if the event happens to it."""
    run, now, low, high = clock[Clock.RUN], clock[Clock.STEP] + 1, params.seed.low, params.seed.high
    who, others, unlucky = pairs[Heard.RECEIVER], pairs[Heard.SENDER], pairs[Heard.UNLUCKY]
    for k in range(listed):
        word = rounds(now, who[k], run, purpose + PAIR * others[k], low, high)[0]
        unlucky[k] = uint64(word) < probability
    for k in range(listed):
        if unlucky[k]:
            links[others[k] >> 5, who[k]] &= ~bit(others[k])


@spliced
def hear_few(params, state, functions, part):
    """Let the listening robots receive what the robots in radio range of them send (model.md 6.5, 6.6)."""
    anyone = uint32(0)
    for w in range(part.first, part.last):
        anyone |= state.sets[Set.SPEAKING, w]
    if anyone == 0:
        return
    if not params.radio.as_sight or state.clock[Clock.MISS] > 0:
        find_sight(params, state, params.radio, part)
        if params.arena.place.exists:
            drop_cut(params, state, part, int64(Sense.RADIO), params.arena.place.radio)
    for other in range(part.first, part.last):
        find_heard(params, state, part, other)
    drop_unlucky(params, state, part, state.sets[Set.LISTENING], LOSS, state.clock[Clock.LOSS])
    if params.strategy.knowledge.enabled or params.acting.acts:
        merge_heard(params, state, functions, part)
    if params.decision.declare.enabled or not params.strategy.knowledge.enabled:
        receive_heard(params, state, part)


@inlined
def merge_heard(params, state, functions, part):
    """Let robots add what they hear of tasks and of the rest to what they know."""
    for i in range(params.robots.count):
        for other in range(part.first, part.last):
            heard = state.links[Link.SIGHT, other, i]
            if heard and params.acting.acts:
                functions.act(params, state, int64(Moment.HEAR), int64(i), int64(other), uint32(heard))
            if params.strategy.knowledge.enabled:
                defer_all(params, state, functions, Action.MERGE, int64(i), heard, WORD * other)


@inlined
def find_heard(params, state, part, other):
    """Keep those robots of a word in each robot's sight that it hears, unless a message is lost."""
    heard, listening = state.links[Link.SIGHT, other], state.sets[Set.LISTENING]
    speaking = state.sets[Set.SPEAKING, other]
    for i in range(WORD * part.last):
        heard[i] &= speaking & -uint32(contains(listening, i))


@inlined
def receive_heard(params, state, part):
    """Add what robots hear to their inboxes."""
    for other in range(part.first, part.last):
        said = sent_opinions(params, state, other)
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
def sent_opinions(params, state, w):
    """Return which robots' messages say *feasible*, of a word; labels have it of lies and late messages."""
    said = state.sets[Set.SAYS_FEASIBLE, w]
    differing = state.sets[Set.SPEAKING, w]
    if params.radio.delay == 0:
        differing = uint32(differing & state.sets[Set.BYZANTINE, w])
    while differing:
        i = lowest_member(w, differing)
        said = uint32(said & ~bit(i)) | bit_if(says_feasible(state.robots[Robot.LABEL, i]) == 1, i)
        differing = without_lowest(differing)
    return said


@spliced
def move_few(params, state, part):
    """Move each robot whose way is clear; the others stay and will turn (model.md 6.1, 6.2)."""
    if find_standing(params, state, part) or not params.arena.wraps:
        move_unless(params, state.robots, state.sets[Set.BLOCKED])
    else:
        move_freely(state, part)


@spliced
def find_standing(params, state, part):
    """Find the robots that stand in this step; return whether there are any. The steps of others may turn."""
    robots, sets, pairs, listed = state.robots, state.sets, state.heard[part.thread], int64(0)
    if params.robots.avoid_collisions:
        listed = list_pairs(params, robots, state.links[Link.CLOSE], sets[Set.THERE], pairs, part)
    find_meeting(params, robots, sets, pairs, listed, True)
    some = uint32(0)
    for w in range(part.first, part.last):
        working = sets[Set.WORKING, w]
        blocked = uint32(sets[Set.MET, w] & working) | find_beyond_walls(params, state, working, w)
        sets[Set.BLOCKED, w] = blocked
        some |= blocked
    if params.robots.deflects and some:
        for w in range(part.first, part.last):
            wall_left, wall_right = find_walls_beside(params, state, sets[Set.BLOCKED, w], w)
            sets[Set.TURNING_LEFT, w] = (
                sets[Set.MET_RIGHT, w] | wall_right | ~(sets[Set.MET_LEFT, w] | wall_left)
            )
        some = deflect_few(params, state, pairs, listed, part)
    return some != 0


@called
def move_unless(params, robots, blocked):
    """Move all robots but those of a set; a torus whose sides differ doesn't wrap by itself."""
    xs, ys = robots[Robot.X], robots[Robot.Y]
    steps_x, steps_y = robots[Robot.STEP_X], robots[Robot.STEP_Y]
    wraps, width, height = params.arena.wraps, params.arena.width, params.arena.height
    for w in range(blocked.size):
        base, stays = uint64(WORD * w), blocked[w]
        for k in range(32):
            i = uint64(base + k)
            moves = int32(has_bit(stays, k)) - int32(1)
            step_x, step_y = steps_x[i] & moves, steps_y[i] & moves
            x, y = int64(uint32(xs[i])) + int64(step_x), int64(uint32(ys[i])) + int64(step_y)
            xs[i] = int32(uint32(x if wraps else around(x, width)))
            ys[i] = int32(uint32(y if wraps else around(y, height)))


@spliced
def list_pairs(params, robots, close_by, there, pairs, part):
    """List the pairs of robots that are there and may meet within a step; return their number."""
    listed, limit, band = int64(0), params.robots.meet_limit, params.robots.meet_band
    find_all_near(params, robots, close_by, limit, band, part.last)
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
        kept += int64(contains(members, i) | contains(members, j))
    repeat_last(firsts, seconds, kept)
    return kept


@called
def find_meeting(params, robots, sets, pairs, listed, at_first):
    """Find which robots of listed pairs meet the other, and which of these have it on the left and right.

    The other one moves, or may stay: ``at_first`` any, later the blocked ones. A stopped robot has step 0.
    Without a branch, so that LLVM vectorizes the loop, unless floats leave a pair in doubt.
    """
    xs, ys, us, vs = robots[Robot.X], robots[Robot.Y], robots[Robot.STEP_X], robots[Robot.STEP_Y]
    firsts, seconds, meetings = pairs[Heard.RECEIVER], pairs[Heard.SENDER], pairs[Heard.MEETING]
    arena, limit, staying = params.arena, int64(params.robots.apart_limit), sets[Set.BLOCKED]
    walls, width, height, doubtful = arena.walls, arena.width, arena.height, False
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
        meets_i = meets_both | (meets_i & (at_first | has_bit(staying[j >> uint64(5)], j)))
        meets_j = meets_both | (meets_j & (at_first | has_bit(staying[i >> uint64(5)], i)))
        meetings[k] = meeting_of(meets_i, across_i) | meeting_of(meets_j, across_j) << 3
    if doubtful:
        find_meeting_exactly(params, robots, staying, pairs, listed, at_first)
    collect_meetings(sets, pairs, listed)


@inlined
def meeting_of(met, side):
    """Return in three bits whether a robot meets another, has it on its left, and on its right."""
    return int32(met) | int32(met & (side > 0)) << 1 | int32(met & (side < 0)) << 2


@called
def find_meeting_exactly(params, robots, staying, pairs, listed, at_first):
    """Find what `find_meeting` finds, by exact arithmetic."""
    for k in range(listed):
        i, j = int64(pairs[Heard.RECEIVER, k]), int64(pairs[Heard.SENDER, k])
        met_i, side_i = meets_exactly(params, robots, i, j, at_first or contains(staying, j))
        met_j, side_j = meets_exactly(params, robots, j, i, at_first or contains(staying, i))
        pairs[Heard.MEETING, k] = meeting_of(met_i, side_i) | meeting_of(met_j, side_j) << 3


@called
def collect_meetings(sets, pairs, listed):
    """Put the robots of listed pairs that meet into sets."""
    for row in (Set.MET, Set.MET_LEFT, Set.MET_RIGHT):
        sets[row, :] = uint32(0)
    for k in range(listed):
        meeting = pairs[Heard.MEETING, k]
        if meeting == 0:
            continue
        for own in (Heard.RECEIVER, Heard.SENDER):
            i = int64(pairs[own, k])
            sets[Set.MET, i >> 5] |= bit_if((meeting & 1) != 0, i)
            sets[Set.MET_LEFT, i >> 5] |= bit_if((meeting & 2) != 0, i)
            sets[Set.MET_RIGHT, i >> 5] |= bit_if((meeting & 4) != 0, i)
            meeting >>= 3


@spliced
def deflect_few(params, state, pairs, listed, part):
    """Let the blocked robots turn away twice, as long as they are blocked; return whether some still are.

    Their steps change, also of those that stay blocked: these draw a new heading (model.md 6.2.2 to 6.2.5).
    """
    robots, sets, some = state.robots, state.sets, uint32(0)
    for _ in range(2):
        for w in range(part.first, part.last):
            turn_away(robots, sets[Set.TURNING_LEFT, w], sets[Set.BLOCKED, w], w)
        listed = keep_pairs(pairs, listed, sets[Set.BLOCKED])
        find_meeting(params, robots, sets, pairs, listed, False)
        some = uint32(0)
        for w in range(part.first, part.last):
            blocked = sets[Set.BLOCKED, w]
            sets[Set.BLOCKED, w] &= sets[Set.MET, w] | find_beyond_walls(params, state, blocked, w)
            some |= sets[Set.BLOCKED, w]
        if some == 0:
            break
    return some
