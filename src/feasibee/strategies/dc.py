"""DC, direct comparison of qualities.

A robot broadcasts its opinion and its quality for g steps on average, whatever the quality. Then it draws
one of the messages that it heard, and takes its opinion if that has the higher quality:
rho_heard > rho_own.

Message: id, opinion, quality of *feasible* in 16 bits. Memory: two counts, and one opinion and quality for
each robot heard.

References
----------
Valentini, Brambilla, Hamann, Dorigo, "Collective perception of environmental features in a robot swarm",
2016.
"""

VALUE_BITS = 16


def decide(mind, inbox):
    """Return the opinion of a random message if its quality is higher than the robot's."""
    heard_quality = inbox.heard_value if inbox.heard_opinion == 1 else 1.0 - inbox.heard_value
    if inbox.heard_opinion >= 0 and heard_quality > mind.quality:
        return inbox.heard_opinion
    return mind.opinion
