"""DMVD, Direct Modulation of Voter-based Decisions.

A robot broadcasts its opinion for a time in proportion to the opinion's quality, g rho, then takes one of
the opinions that it heard at random; its own isn't among them.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Valentini, Hamann, Dorigo, "Self-organized collective decision making: the weighted voter model", 2014.
"""

MODULATES = True


def decide(mind, inbox):
    """Return a random opinion of those heard, or keep the robot's if none was heard."""
    if inbox.heard_opinion < 0:
        return mind.opinion
    return inbox.heard_opinion
