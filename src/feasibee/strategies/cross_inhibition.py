"""Cross-inhibition: whoever hears the other opinion first gives up its own.

A robot broadcasts its opinion for a time in proportion to the opinion's quality, g rho. Then it draws one of
the messages that it heard: if it says other than the robot's opinion, the robot has none from then on
(it is *uncommitted*, and silent); a robot without an opinion takes the one that it drew.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Reina, Valentini, Fernandez-Oto, Dorigo, Trianni, "A design pattern for decentralised decision making", 2015.
"""

MODULATES = True


def decide(mind, inbox):
    """Return no opinion (-1) upon a contradiction, what it heard if it has none, else its own."""
    if inbox.heard_opinion < 0:
        return mind.opinion
    if mind.opinion < 0:
        return inbox.heard_opinion
    if inbox.heard_opinion != mind.opinion:
        return -1
    return mind.opinion
