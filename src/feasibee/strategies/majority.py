"""The majority rule, unmodulated: quality plays no part.

A robot broadcasts for g steps on average, then takes the majority of the opinions that it heard, its own
included. The swarm soon agrees on what more robots held at first; what it saw has no say. A baseline.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Galam, "Majority rule, hierarchical structures, and democratic totalitarianism", 1986.
"""


def quality(robots_seen, tasks_seen):
    """Return the quality of *feasible*: rho_1 = n_obs / (n_obs + m_obs), or 1/2 with nothing seen."""
    if robots_seen + tasks_seen == 0:
        return 0.5
    return robots_seen / (robots_seen + tasks_seen)


def dissemination(quality, gain):
    """Return the mean duration of broadcasting, in steps: g, whatever the quality."""
    return gain


def decide(mind, inbox):
    """Return the majority of the votes; a tie keeps the opinion."""
    feasible = inbox.feasible_votes + (mind.own_vote if mind.opinion == 1 else 0)
    infeasible = inbox.infeasible_votes + (mind.own_vote if mind.opinion == 0 else 0)
    if feasible > infeasible:
        return 1
    if feasible < infeasible:
        return 0
    return mind.opinion
