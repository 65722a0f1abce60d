"""Fading votes: robots vote by what they saw lately, in an id and 1 bit, for worlds that change.

Each robot keeps two counts that fade, as in `fading`, and tells nobody. Its vote is what they say: feasible
if they stand for at most n + 1/2 tasks. Half a sighting is added to those of tasks, since counts of rare
things are more often below their mean than above. It broadcasts its vote for g steps on average, and keeps
the latest vote that it heard directly from each id. Votes heard lose a share 1 / tau of their weight in each
step. In each step a robot holds what most of the weight is for, its own vote included; a tie keeps the
opinion.

``tau``, ``margin``, ``ratio``, ``sees`` and what a robot must know are those of `fading`.

A Byzantine robot votes for the lie.

Message: id and vote. Memory: for each robot its vote and a step; two counts, and two sums.

References
----------
Our own.
"""

from feasibee.strategies.clock import stamp_of
from feasibee.strategies.fading import (
    FADE,
    HEARD,
    LOOKS,
    ROWS,
    SCALE,
    TASKS,
    fade,
    is_old,
    look,
    message_words,
    observe,
    robots_of,
    share_in_sight,
    taken,
    tau_of,
    uses_ratio,
)
from feasibee.strategies.quiet_census import decide

NEEDS_IDS = True
ONE_CLASS = True
ALL_ROUND = True
READS_PLAN = True
PARAMETERS = {"tau": 0.0, "margin": 0.2, "ratio": 0.0, "sees": 1.0}
MEMORY = 5
WEIGHTS = 3
"""Place of the weights against and for, behind the numbers of `fading`; rows hold votes."""


def words(setting):
    """Return the size: for each robot its vote, and the step in which it came."""
    return ROWS + 2 * setting.robots


def start(known, me):
    """Write the share of its counts that a robot keeps in a step."""
    me.memory[FADE] = 1.0 - 1.0 / tau_of(me.setting)


def vote_of(known, me):
    """Return the robot's own vote."""
    tasks, robots = me.memory[TASKS] + 0.5, robots_of(known, me)
    if uses_ratio(me.setting):
        return 1 if tasks * (robots - 1) <= (robots + 0.5) * me.memory[LOOKS] else 0
    return 1 if tasks <= (robots + 0.5) * share_in_sight(me.setting) * me.memory[LOOKS] else 0


def encode(message, known, me):
    """Write the robot's vote."""
    message[0] = vote_of(known, me)


def lie(message, feasible, me):
    """Vote for the lie."""
    message[0] = feasible


def merge(known, message, sender, me):
    """Replace the vote of an id, and what is left of it."""
    place, vote = ROWS + 2 * sender, message[0] & 1
    me.memory[WEIGHTS + known[place]] -= taken(known, place, 0, me)
    me.memory[WEIGHTS + vote] += 1.0
    known[place] = vote
    known[place + 1] = stamp_of(me.step)
    known[HEARD] += 1


def judge(known, me):
    """Return what the votes say, and let all counts and votes fade."""
    look(me)
    place = ROWS + 2 * (me.step % me.setting.robots)
    if not me.setting.knows_count and is_old(known[place + 1], me):
        me.memory[WEIGHTS + known[place]] -= taken(known, place, 0, me)
    lead = me.memory[WEIGHTS + 1] - me.memory[WEIGHTS] + (1.0 if vote_of(known, me) == 1 else -1.0)
    fade(me)
    return -1 if lead == 0.0 else 1 if lead > 0.0 else 0


def count(known, counts, me):
    """Write the weights of the votes for and against *feasible*, the robot's own included."""
    own = vote_of(known, me)
    for side in range(2):
        weight = max(me.memory[WEIGHTS + side], 0.0) + (1.0 if own == side else 0.0)
        counts[1 - side] = int(SCALE * weight)


def describe(known, me):
    """Return the votes in words."""
    against, favour = me.memory[WEIGHTS], me.memory[WEIGHTS + 1]
    own = "feasible" if vote_of(known, me) == 1 else "infeasible"
    return f"votes {own}; heard {favour:.1f} votes for feasible and {against:.1f} for infeasible, by weight"


def bits(message, me):
    """Return the length of a message: an id and a vote."""
    return me.setting.id_bits + 1


def layout(wire, message, sender, setting):
    """Go through the id and the vote."""
    sender = wire.number(sender, setting.id_bits, setting.robots)
    message[0] = wire.number(message[0], 1)
    return sender
