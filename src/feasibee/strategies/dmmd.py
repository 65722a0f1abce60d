"""DMMD, Direct Modulation of Majority-based Decisions: the paper's strategy.

A robot broadcasts its opinion for a time in proportion to the opinion's quality, g rho, then takes the
majority of the opinions that it heard, its own included.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Valentini, Ferrante, Hamann, Dorigo, "Collective decision with 100 Kilobots", 2016; on feasibility:
Fuady, Tarapore, Ehsan, Soorati, "Collective Decision-Making on Task Allocation Feasibility", 2024.
"""

MODULATES = True


def decide(mind, inbox):
    """Return the majority of the votes; a tie keeps the opinion, or takes a random message."""
    feasible = inbox.feasible_votes + (mind.own_vote if mind.opinion == 1 else 0)
    infeasible = inbox.infeasible_votes + (mind.own_vote if mind.opinion == 0 else 0)
    if feasible > infeasible:
        return 1
    if feasible < infeasible:
        return 0
    if mind.random_ties == 1 and inbox.heard_opinion >= 0:
        return inbox.heard_opinion
    return mind.opinion
