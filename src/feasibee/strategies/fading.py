"""Fading: counts of lately seen tasks that lose their weight with time, for worlds that change.

Each robot counts the steps in which it explores, E, and the tasks in sight in these steps, M. In each step
both lose a share 1 / tau, so that they are about the last tau steps. It broadcasts both for g steps on
average, and keeps the latest pair that it heard directly from each id; nobody relays. Pairs heard fade, too.
A task is in sight in a share a = pi r**2 / area of the steps, so that the number of tasks is about

    m = (M + sum M_j) / (a (E + sum E_j))

In each step the robot holds *feasible* if m <= n + 1/2, halfway to the first number that isn't. Within walls
a is the mean share of the arena that is in sight; in a place with walls, that of the cells in which tasks may
be, by the plan. A sensor that misses a tenth needs ``sees`` = 0.9, by which a is multiplied. A robot that
doesn't know n takes one more than the number of ids that it heard lately: at least once in the time in which
it would see a given place three times. The n that robots know is that of the start; only those that don't
know it notice robots that join or leave.

With ``ratio`` = 1 robots need not know the area: the robots in sight, N, stand for E. A robot sees n - 1
others, so that

    m = (n - 1) (M + sum M_j) / (N + sum N_j)

``tau`` is in steps; 0: by a rule, if n is known, else 120, or 150 with the ratio. The rule asks that robots
are right unless tasks differ from n + 1/2 by less than ``margin``, in natural logarithms. All robots together
see enough in T = 1.2 z**2 / (2 kappa n margin**2) steps, where kappa = n s 2 r v / area is how often a task
is visited in a step, and s the share of steps in which a robot explores. One that hears each other robot at a
rate h has only a share tau h / (1 + tau h) of that. So tau solves tau**2 h = T (1 + tau h). With z = 2.4 it
is 107 in the paper's world. T is doubled with the ratio, since two counts err, and within walls, near which
tasks are seen more rarely: tau is 167. Robots that also passed on each other's counts were hardly faster at
the same accuracy.

With ``fast`` above 0, robots keep a second pair with this tau, and send both in turn. If the estimates differ
by half or more, the fast one decides: large changes are noticed sooner.

With ``bounded`` = 1 a robot that knows n believes of others that they explored in at most 1.2 times the mean
share of steps, and saw at least (n + 1/2) / 2 and at most 2 (n + 1/2) tasks. So a false row weighs little
more than a true one. The estimate is then too small or too large for numbers of tasks far from n.

A Byzantine robot denies the tasks that it saw, or doubles them. A colluding one sends what weighs most.

Message: id, and 16 bits: two logarithmic numbers of 8 bits in steps of 4 %, rounded at random by the hash of
robot and step; with ``fast`` 1 bit more. Memory: for each robot 16 bits and a step; two counts, and two sums.

References
----------
Our own; counts that fade are exponential smoothing: Brown, "Statistical forecasting for inventory control",
1959.
"""

import math

from feasibee.strategies.certified import room, steps_for, swept
from feasibee.strategies.clock import stamp_of, steps_since
from feasibee.strategies.quiet_census import decide

NEEDS_IDS = True
ONE_CLASS = True
ALL_ROUND = True
READS_PLAN = True
PARAMETERS = {"tau": 0.0, "margin": 0.2, "ratio": 0.0, "sees": 1.0, "fast": 0.0, "bounded": 0.0}
TAU, MARGIN, RATIO, SEES, FAST, BOUNDED = 0, 1, 2, 3, 4, 5
MEMORY = 10
FADE, LOOKS, TASKS, ALL_LOOKS, ALL_TASKS = 0, 1, 2, 3, 4
"""Numbers of a robot's memory: the share kept in a step, its own counts, and the sums of those heard."""
OF_FAST = 5
"""Place of the fast numbers; the slow ones stand before."""
Z = 2.4
"""Standard errors in the margin."""
UNKNOWN_TAU, UNKNOWN_RATIO_TAU = 120.0, 150.0
"""Tau where n is unknown, in steps."""
LONGEST_TAU = 1e6
STEP = 1.04
"""Ratio of successive numbers in a message."""
MOST = 255
ROW_BITS = 16
LEAST = 1.0 / 2048.0
"""Number of code 1, in tau."""
HEARD, ROWS = 0, 1
"""Words of what is known: number of robots heard; then for each robot its row, and the step when it came."""
SCALE = 65536.0
DIFFERS = 1.5
MOST_LOOKS, MOST_TIMES = 1.2, 2.0
"""What bounded robots believe at most: so many times the mean of the looks, so many times n + 1/2 tasks."""


def words(setting):
    """Return the size: for each robot and tau a row, and the step in which it came."""
    return ROWS + 2 * setting.robots * (2 if setting.parameters[FAST] > 0 else 1)


def message_words(setting):
    """Return the size of a message: one row."""
    return 1


def start(known, me):
    """Write the share of its counts that a robot keeps in a step, of the slow and the fast ones."""
    me.memory[FADE] = 1.0 - 1.0 / tau_of(me.setting)
    me.memory[OF_FAST + FADE] = 1.0 - 1.0 / max(me.setting.parameters[FAST], 1.0)


def uses_ratio(setting):
    """Return whether robots in sight stand for the steps in which the robot looked."""
    return setting.parameters[RATIO] > 0


def tau_of(setting):
    """Return tau in steps, by the rule unless it is set."""
    if setting.parameters[TAU] > 0:
        return min(max(setting.parameters[TAU], 1.0), LONGEST_TAU)
    if not setting.knows_count:
        return UNKNOWN_RATIO_TAU if uses_ratio(setting) else UNKNOWN_TAU
    exploring = setting.exploration / (setting.exploration + setting.dissemination)
    visits = swept(setting.sight * exploring, setting.count, setting) / room(setting)
    met = swept(setting.radio * (1.0 - exploring), 1, setting) / (setting.width * setting.height)
    meets = 4.0 / math.pi * met
    seen = 2.0 * visits * setting.count * max(setting.parameters[MARGIN], 1e-3) ** 2
    if seen <= 0.0 or meets <= 0.0:
        return LONGEST_TAU
    pooled = 1.2 * Z * Z / seen * (2.0 if uses_ratio(setting) else 1.0)
    return min(max((pooled + math.sqrt(pooled * (pooled + 4.0 / meets))) / 2.0, 1.0), LONGEST_TAU)


def share_in_sight(setting):
    """Return the mean share of the arena that a robot sees; within walls that of a random place."""
    area, reach = setting.width * setting.height, setting.sight
    seen = math.pi * reach * reach
    if setting.walled:
        seen += reach**3 * (reach / 2.0 - 4.0 / 3.0 * (setting.width + setting.height)) / area
    if setting.in_sight > 0.0:
        seen = setting.in_sight * area
    return min(max(seen / area * setting.parameters[SEES], 1e-9), 1.0)


def note(me, which):
    """Add one to a count of the robot's own, slow and fast."""
    for first in range(0, len(me.memory), OF_FAST):
        me.memory[first + which] += 1.0


def observe(known, thing, me):
    """Count a task in sight, or, for the ratio, a robot."""
    if not thing.is_robot:
        note(me, TASKS)
    elif thing.id != me.id and uses_ratio(me.setting):
        note(me, LOOKS)


def look(me):
    """Count a step of exploration, unless robots in sight stand for it."""
    if me.explores and not uses_ratio(me.setting):
        note(me, LOOKS)


def fade(me):
    """Let all counts and sums fade."""
    for first in range(0, len(me.memory), OF_FAST):
        for k in range(first + LOOKS, first + ALL_TASKS + 1):
            me.memory[k] *= me.memory[first + FADE]


def power(base, exponent):
    """Return a power with a whole exponent; the same bits on all platforms."""
    result = 1.0
    while exponent > 0:
        if exponent & 1:
            result *= base
        base *= base
        exponent >>= 1
    return result


POWERS = tuple((1 << digit, power(STEP, 1 << digit)) for digit in range(7, -1, -1))
"""Powers of two, and `STEP` to them."""


def chance_of(me, which):
    """Return a number from 0 to 1 by the robot's hash and the step."""
    bits = (me.hash ^ (me.step * 0x5851F42D + which * 0x14057B7F)) & 0xFFFFFFFF
    bits = ((bits ^ bits >> 16) * 0x2C1B3C6D) & 0xFFFFFFFF
    bits = ((bits ^ bits >> 12) * 0x297A2D39) & 0xFFFFFFFF
    return (bits ^ bits >> 15) / 4294967296.0


def code_of(value, chance):
    """Return a number as 8 bits, rounded up or down at random so that its mean is right."""
    if value < LEAST:
        return 1 if chance * LEAST < value else 0
    code, reached = 1, LEAST
    for weight, factor in POWERS:
        if code + weight <= MOST and reached * factor <= value:
            code += weight
            reached *= factor
    return code + (1 if code < MOST and chance * (STEP - 1.0) * reached < value - reached else 0)


def value_of(code):
    """Return the number of a code."""
    return LEAST * power(STEP, code - 1) if code > 0 else 0.0


def encode(message, known, me):
    """Write the robot's own counts in units of tau, in turn of the slow and the fast ones."""
    first = OF_FAST * (me.step & 1) if me.setting.parameters[FAST] > 0 else 0
    unit = 1.0 - me.memory[first + FADE]
    looks, tasks = me.memory[first + LOOKS] * unit, me.memory[first + TASKS] * unit
    too_large = max(1.0, max(looks, tasks) / value_of(MOST))
    row = code_of(looks / too_large, chance_of(me, 0)) << 8 | code_of(tasks / too_large, chance_of(me, 1))
    message[0] = row | (1 << 16 if first > 0 else 0)


def lie(message, feasible, me):
    """Deny all tasks, or double them; a colluding robot sends what weighs most, also with ``bounded``."""
    looks, tasks = message[0] & ~MOST, message[0] & MOST
    if me.setting.colluding:
        looks = (MOST if feasible == 1 else most_looks(me.setting)) << 8 | looks & 1 << 16
        tasks = MOST
    message[0] = looks | (0 if feasible == 1 else min(MOST, tasks + 18))


def merge(known, message, sender, me):
    """Replace the row of an id, and what is left of it in the sums."""
    row, robots, first = believed(message[0], me), me.setting.robots, 0
    place = ROWS + 2 * sender
    if message[0] >> 16 & 1 and me.setting.parameters[FAST] > 0:
        place += 2 * robots
        first = OF_FAST
    add(known[place], first, -taken(known, place, first, me), me)
    add(row, first, 1.0, me)
    known[place] = row
    known[place + 1] = stamp_of(me.step)
    known[HEARD] += 1 if first == 0 else 0


def most_looks(setting):
    """Return the largest code of looks, or of robots in sight, that bounded robots believe."""
    mean = setting.exploration / (setting.exploration + setting.dissemination)
    if uses_ratio(setting):
        mean *= share_in_sight(setting) * setting.count
    return code_of(MOST_LOOKS * mean, 1.0)


def believed(message, me):
    """Return the row of a message; with ``bounded`` one that is honest for about n + 1/2 tasks."""
    looks, tasks = message >> 8 & MOST, message & MOST
    if me.setting.parameters[BOUNDED] > 0 and me.setting.knows_count:
        excess = max(0, looks - most_looks(me.setting))
        looks, tasks = looks - excess, max(0, tasks - excess)  # both by the same factor
        neutral = (me.setting.count + 0.5) * value_of(looks)
        neutral *= (
            1.0 / max(me.setting.count - 1, 1) if uses_ratio(me.setting) else share_in_sight(me.setting)
        )
        tasks = max(code_of(neutral / MOST_TIMES, 1.0), min(tasks, code_of(neutral * MOST_TIMES, 1.0)))
    return looks << 8 | tasks


def add(row, first, weight, me):
    """Add a row to the sums with a weight."""
    weight /= 1.0 - me.memory[first + FADE]
    me.memory[first + ALL_LOOKS] += weight * value_of(row >> 8 & MOST)
    me.memory[first + ALL_TASKS] += weight * value_of(row & MOST)


def taken(known, place, first, me):
    """Remove the row of an id; return the weight that is left of it, or 0 if there is no such row."""
    came = known[place + 1]
    if came == 0:
        return 0.0
    known[place + 1] = 0
    known[HEARD] -= 1 if first == 0 else 0
    return power(me.memory[first + FADE], steps_since(came, stamp_of(me.step)))


def robots_of(known, me):
    """Return the number of robots that the robot believes in: n of the start, or itself and all heard."""
    return me.setting.count if me.setting.knows_count else 1 + known[HEARD]


def tasks_of(known, first, me):
    """Return the number of tasks by the counts, slow or fast; -1.0 as long as they say nothing."""
    looks = me.memory[first + LOOKS] + me.memory[first + ALL_LOOKS]
    tasks = me.memory[first + TASKS] + me.memory[first + ALL_TASKS]
    by_ratio, others = uses_ratio(me.setting), robots_of(known, me) - 1
    if looks < 1e-9 or (by_ratio and others == 0):
        return -1.0
    if by_ratio:
        return max(tasks, 0.0) * others / looks
    return max(tasks, 0.0) / (looks * share_in_sight(me.setting))


def estimate(known, me):
    """Return the number of tasks; -1.0 if nothing is known."""
    slow = tasks_of(known, 0, me)
    if me.setting.parameters[FAST] > 0:
        fast = tasks_of(known, OF_FAST, me)
        if fast >= 0.0 and (fast > DIFFERS * slow or DIFFERS * fast < slow):
            return fast
    return slow


def judge(known, me):
    """Return what the estimate says, and let all counts fade."""
    look(me)
    place = ROWS + 2 * (me.step % me.setting.robots)  # one in turn
    if not me.setting.knows_count and is_old(known[place + 1], me):
        add(known[place], 0, -taken(known, place, 0, me), me)
    tasks = estimate(known, me)
    fade(me)
    if tasks < 0.0:
        return -1
    return 1 if tasks <= robots_of(known, me) + 0.5 else 0


def is_old(came, me):
    """Return whether a row that came in a step, counted from 1, is from a robot that may have left since."""
    return came != 0 and steps_since(came, stamp_of(me.step)) > steps_for(3.0, 1, me.setting)


def gap(known, me):
    """Return the estimated number of tasks, less that of robots, rounded."""
    tasks = estimate(known, me)
    return 0 if tasks < 0.0 else math.floor(tasks - robots_of(known, me) + 0.5)


def count(known, counts, me):
    """Write both sides of the rule."""
    tasks = estimate(known, me)
    if tasks >= 0.0:
        counts[0] = int(SCALE * (robots_of(known, me) + 0.5))
        counts[1] = int(SCALE * min(tasks, SCALE * SCALE))


def describe(known, me):
    """Return the estimate in words."""
    tasks = estimate(known, me)
    if tasks < 0.0:
        return "has seen nothing yet"
    return f"about {tasks:.1f} tasks, by what {1 + known[HEARD]} robots saw lately"


def bits(message, me):
    """Return the length of a message: an id and a row, and which it is if there are two."""
    return me.setting.id_bits + ROW_BITS + (1 if me.setting.parameters[FAST] > 0 else 0)


def layout(wire, message, sender, setting):
    """Go through the id, which row it is if there are two, and the row."""
    sender = wire.number(sender, setting.id_bits, setting.robots)
    message[0] = wire.number(message[0], ROW_BITS + (1 if setting.parameters[FAST] > 0 else 0))
    return sender
