"""Accumulate: DMMD with evidence that is never thrown away.

The counts run over all explorations of a robot's life, so that the quality of its opinion becomes ever less
noisy; broadcasts and majority are those of DMMD.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Our own; the evidence of one short exploration is what limits DMMD near ratio one.
"""

FORGETS = False


def quality(robots_seen, tasks_seen):
    """Return the quality of *feasible*: rho_1 = n_obs / (n_obs + m_obs), or 1/2 with nothing seen."""
    if robots_seen + tasks_seen == 0:
        return 0.5
    return robots_seen / (robots_seen + tasks_seen)


def dissemination(quality, gain):
    """Return the mean duration, in steps, of broadcasting an opinion of this quality: g rho."""
    return gain * quality


def decide(mind, inbox):
    """Return the majority of the votes; a tie keeps the opinion."""
    feasible = inbox.feasible_votes + (mind.own_vote if mind.opinion == 1 else 0)
    infeasible = inbox.infeasible_votes + (mind.own_vote if mind.opinion == 0 else 0)
    if feasible > infeasible:
        return 1
    if feasible < infeasible:
        return 0
    return mind.opinion
