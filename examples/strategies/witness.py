"""Witness: broadcast what this robot saw in its life; believe what most robots broadcast."""

FORGETS = False


def say(mind):
    """Return the opinion that the robot's own sightings support."""
    return 1 if mind.feasible_quality > 0.5 else 0


def decide(mind, inbox):
    """Return the majority of the opinions, the robot's own sightings included; a tie keeps the opinion."""
    lead = inbox.feasible_votes - inbox.infeasible_votes + (1 if mind.feasible_quality > 0.5 else -1)
    return mind.opinion if lead == 0 else int(lead > 0)
