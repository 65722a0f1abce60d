"""Totals: anonymous sums of what each robot saw in its life, in 16 bits and an id.

Each robot counts its own sightings, r_j of robots and t_j of tasks. It broadcasts both for g steps on
average, and keeps the latest that it heard directly from each id; nobody relays. A robot sees each of the
n - 1 others as often as each task, so that the number of tasks is about

    (n - 1) sum t_j / sum r_j

At the end of each dissemination it decides feasible if this is less than n + 1/2, halfway to the first number
that isn't, infeasible if it is more; a tie keeps the opinion. It must know n.

In a long life totals outgrow the message. A robot then sends and weighs both as if the larger one were the
largest of a message: their ratio stays, and all such robots weigh the same. It halves both when the larger
one fills its word.

With ``arrivals`` = 1 a thing counts only when it comes into view, that is if it wasn't in sight in the step
before: sightings of one visit depend on each other. As robots move, they come into view more often than
tasks, so their number is divided by ``kappa``. In an exploration of L steps, in an arena without walls, a
thing comes into view (D + (L - 1) (D - E o)) / area times. Here D = pi r**2, r is the range of sight, o is
the overlap of two discs of radius r that are as far apart as the relative motion of a step, and E is the
mean over the headings. With r = 2, steps of 1 and a mean of L = 10.5 the ratio of robots to tasks is 1.19. A
sensor that misses things makes it smaller: what is seen again counts again.

With ``tolerates`` = f a robot leaves out the f rows that speak most for *feasible* and the f that speak most
for *infeasible*: f false rows can't outweigh the others.

A Byzantine robot calls all that it saw robots, or tasks. A colluding one sends the largest total there is.

Message: id, and 16 bits: both totals in units of 2**e, 6 bits each, and e in 4 bits; up to 2,064,384.

Memory: the two totals, 16 bits for each robot; with ``arrivals`` also what was in sight in the step before.

It doesn't declare. A rule that declared at five standard errors was wrong in 0.67 of 400 runs with walls and
collisions at n = m = 20, since robots that avoid each other see each other less often than tasks.

References
----------
Our own; the ratio of arrivals is that of a gas of hard discs: moving ones meet 4 / pi times as often as one
meets those at rest, in the limit of short steps.
"""

import math

from feasibee.strategies.certified import tolerated
from feasibee.strategies.clock import LAST, stamp_of
from feasibee.strategies.tally import FULL, decide

NEEDS_COUNT = True
NEEDS_IDS = True
NEEDS_NAMES = "arrivals"
ONE_CLASS = True
ALL_ROUND = "arrivals"
PARAMETERS = {"arrivals": 0.0, "kappa": 1.19, "tolerates": 0.0}
DIGITS = 6
MOST = 63
"""Largest number of 6 bits."""
UNITS = 15
"""Largest exponent of 4 bits."""
LARGEST = MOST << UNITS
"""Largest total of a message."""
ROW_BITS = 16
ROWS = 2
"""Place of the first row heard; its own totals stand before."""


def words(setting):
    """Return the size: both totals, a row for each robot, and when each thing was last in sight."""
    in_sight = setting.robots + setting.tasks if setting.parameters[0] == 1 else 0
    return ROWS + setting.robots + in_sight


def message_words(setting):
    """Return the size of a message: one row."""
    return 1


def observe(known, thing, me):
    """Count a robot or task in sight, with ``arrivals`` only if it wasn't in sight in the step before."""
    if me.setting.parameters[0] == 1 and thing.id >= 0:
        place = ROWS + me.setting.robots + thing.id + (0 if thing.is_robot else me.setting.robots)
        stays = known[place] & LAST == stamp_of(me.step - 1)
        known[place] = stamp_of(me.step)
        if stays:
            return
    total = 0 if thing.is_robot else 1
    known[total] += 1
    if known[total] == FULL:
        known[0], known[1] = known[0] // 2, known[1] // 2


def scaled(total, larger):
    """Return one of two totals, of which the larger is given, as if that were at most the largest."""
    return total if larger <= LARGEST else total * LARGEST // larger


def row_of(robots, tasks):
    """Return two totals as 16 bits: 4 of the exponent, 6 of the robots, 6 of the tasks."""
    larger = max(robots, tasks)
    robots, tasks, larger = scaled(robots, larger), scaled(tasks, larger), scaled(larger, larger)
    units = max(0, larger.bit_length() - DIGITS)
    units += (larger + half(units)) >> units > MOST
    return units << 2 * DIGITS | (robots + half(units)) >> units << DIGITS | (tasks + half(units)) >> units


def half(units):
    """Return half a unit, to round to the nearest."""
    return 1 << units >> 1


def robots_of(row):
    """Return the total of robots in a row."""
    return (row >> DIGITS & MOST) << (row >> 2 * DIGITS)


def tasks_of(row):
    """Return the total of tasks in a row."""
    return (row & MOST) << (row >> 2 * DIGITS)


def encode(message, known, me):
    """Write the robot's own totals."""
    message[0] = row_of(known[0], known[1])


def lie(message, feasible, me):
    """Call all that was seen robots, or tasks; a colluding robot sends the largest total."""
    total = robots_of(message[0]) + tasks_of(message[0])
    if me.setting.colluding:
        total = MOST << UNITS
    message[0] = row_of(total, 0) if feasible == 1 else row_of(0, total)


def merge(known, message, sender, me):
    """Keep the latest row of each id."""
    known[ROWS + sender] = message[0]


def kappa(me):
    """Return by how much a robot is counted more often than a task, at least 0.01."""
    return max(0.01, me.setting.parameters[1]) if me.setting.parameters[0] == 1 else 1.0


def lean_of(row, me):
    """Return how much a row speaks for *feasible*: (n + 1/2) r / kappa - (n - 1) t."""
    robots, tasks = robots_of(row), tasks_of(row)
    return (me.setting.robots + 0.5) * robots / kappa(me) - (me.setting.robots - 1) * tasks


def next_extreme(known, me, sign, last):
    """Return the place of the row that leans most to a side, 1 or -1, after the last one; 0 for none."""
    found, most = 0, 0.0
    bound = sign * lean_of(known[last], me) if last > 0 else math.inf
    for place in range(ROWS, ROWS + me.setting.robots):
        if known[place] != 0:
            leans = sign * lean_of(known[place], me)
            follows = leans < bound or (leans == bound and sign * place > sign * last)
            leads = found == 0 or leans > most or (leans == most and sign * place < sign * found)
            if follows and leads:
                found, most = place, leans
    return found


def count(known, counts, me):
    """Sum up its own totals and the rows heard, but for the extreme ones, by both sides of the rule."""
    robots, tasks, heard = 0, 0, 0
    for place in range(ROWS, ROWS + me.setting.robots):
        robots += robots_of(known[place])
        tasks += tasks_of(known[place])
        heard += known[place] != 0
    out = tolerated(me.setting, 2)
    if heard <= 2 * out:
        robots, tasks, out = 0, 0, 0
    for sign in range(-1, 2, 2):
        place = 0
        for _ in range(out):
            place = next_extreme(known, me, sign, place)
            robots -= robots_of(known[place])
            tasks -= tasks_of(known[place])
    larger = max(known[0], known[1])
    robots, tasks = robots + scaled(known[0], larger), tasks + scaled(known[1], larger)
    counts[0] = int((2 * me.setting.robots + 1) * robots / kappa(me))
    counts[1] = 2 * (me.setting.robots - 1) * tasks


def describe(known, me):
    """Return its own totals and the number of rows in words."""
    heard = sum(known[place] != 0 for place in range(ROWS, ROWS + me.setting.robots))
    return f"saw robots {known[0]} times and tasks {known[1]} times in its life; has totals of {heard} others"


def bits(message, me):
    """Return the length of a message: an id and a row."""
    return me.setting.id_bits + ROW_BITS


def layout(wire, message, sender, setting):
    """Go through the id and the row."""
    sender = wire.number(sender, setting.id_bits, setting.robots)
    message[0] = wire.number(message[0], ROW_BITS)
    return sender
