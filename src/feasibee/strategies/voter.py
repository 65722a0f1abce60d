"""The voter model, unmodulated: quality plays no part.

A robot broadcasts for g steps on average, then takes one of the opinions that it heard at random. The swarm
agrees on something; what it saw has no say. A baseline.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Holley, Liggett, "Ergodic theorems for weakly interacting infinite systems and the voter model", 1975.
"""


def decide(mind, inbox):
    """Return a random opinion of those heard, or keep the robot's if none was heard."""
    if inbox.heard_opinion < 0:
        return mind.opinion
    return inbox.heard_opinion
