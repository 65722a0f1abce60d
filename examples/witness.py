"""Witness: broadcast what this robot saw in its life; believe what most robots broadcast."""

FORGETS = False


def quality(robots_seen, tasks_seen):
    """Return the share of robots among all sightings."""
    return (robots_seen + 1) / (robots_seen + tasks_seen + 2)


def dissemination(quality, gain):
    """Return the mean duration of dissemination in steps: the gain, for any quality."""
    return gain


def say(mind):
    """Return the opinion that the robot's own sightings support."""
    return 1 if mind.feasible_quality > 0.5 else 0


def decide(mind, inbox):
    """Return the majority of the opinions, the robot's own sightings included; a tie keeps the opinion."""
    lead = inbox.feasible_votes - inbox.infeasible_votes + (1 if mind.feasible_quality > 0.5 else -1)
    return mind.opinion if lead == 0 else int(lead > 0)
