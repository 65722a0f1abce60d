"""Witness: tell what you have seen in all your life, and believe what most robots tell."""

FORGETS = False


def quality(robots_seen, tasks_seen):
    """Return the share of robots in all that was seen."""
    return (robots_seen + 1) / (robots_seen + tasks_seen + 2)


def dissemination(quality, gain):
    """Return the mean duration of telling, in steps: the gain, whatever the quality."""
    return gain


def say(mind):
    """Return the opinion that the own eyes support, whatever the others say."""
    return 1 if mind.feasible_quality > 0.5 else 0


def decide(mind, inbox):
    """Return what most have seen, oneself included; a tie keeps the opinion."""
    lead = inbox.feasible_votes - inbox.infeasible_votes + (1 if mind.feasible_quality > 0.5 else -1)
    return mind.opinion if lead == 0 else int(lead > 0)
