"""Mixture: voters among majority robots.

All robots broadcast their opinion for a time in proportion to its quality, g rho. At its first decision each
robot is made a voter with probability ``voters``, else a majority robot, for life. A voter decides as in
DMVD: it takes one of the opinions that it heard at random. The others decide as in DMMD: by the majority.
Voters keep a little disagreement alive. A baseline for worlds that change.

Message: id and opinion. Memory: two counts, one opinion for each robot heard, and which rule it follows.

References
----------
Our own mixture of `dmvd` and `dmmd`, whose files name the sources of both rules.
"""

from feasibee.strategies.dmmd import decide as by_majority
from feasibee.strategies.dmmd import dissemination
from feasibee.strategies.dmvd import decide as by_one_vote

PARAMETERS = {"voters": 0.25}
MEMORY = 1
VOTER, MAJORITY = 1.0, 2.0
"""What a robot's memory holds from its first decision on."""


def decide(mind, inbox):
    """Return the decision of the robot's rule, which is drawn the first time."""
    if mind.memory[0] == 0.0:
        mind.memory[0] = VOTER if inbox.chance < mind.parameters[0] else MAJORITY
    return by_one_vote(mind, inbox) if mind.memory[0] == VOTER else by_majority(mind, inbox)
