"""DMMD of a benchmark: robots follow those whom they hear now, and break ties by what they saw.

A robot broadcasts its opinion for a time in proportion to the opinion's quality, g rho. Then it takes the
majority of the opinions that it hears in that step, without its own. With a tie, or if it hears nobody, it
takes what its last exploration favours. With ``voter`` = 1 it takes one of the opinions heard at random
instead of their majority.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Valentini, Brambilla, Hamann, Dorigo, "Collective perception of environmental features in a robot swarm",
2016. Read in khaiyichin/collective_perception, commit 04111dc2.
"""

PARAMETERS = {"voter": 0.0}


def dissemination(quality, gain):
    """Return the mean duration of broadcasting, in steps, in proportion to the quality."""
    return gain * quality


def decide(mind, inbox):
    """Return the majority of the opinions heard, or one of them; without either, what the robot saw."""
    if mind.parameters[0] > 0.0 and inbox.heard_opinion >= 0:
        return inbox.heard_opinion
    lead = inbox.feasible_votes - inbox.infeasible_votes
    if lead == 0:
        return 1 if mind.feasible_quality > 0.5 else 0
    return 1 if lead > 0 else 0
