"""The k-unanimity rule, with modulated broadcasts.

A robot broadcasts its opinion for a time in proportion to the opinion's quality, g rho. Then it draws k of
the messages that it heard, none twice, and takes their opinion if they all say the same. With fewer than k
it keeps its own. A larger k is slower and surer.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Scheidler, Brutschy, Ferrante, Dorigo, "The k-unanimity rule for self-organized decision-making in swarms of
robots", 2016.
"""

MODULATES = True
PARAMETERS = {"k": 3.0}


def decide(mind, inbox):
    """Return the opinion on which k random messages agree, else the robot's own."""
    k = max(1.0, mind.parameters[0])
    votes = inbox.feasible_votes + inbox.infeasible_votes
    if votes < k:
        return mind.opinion
    all_feasible = 1.0  # the probability that the k drawn all say feasible
    all_infeasible = 1.0
    drawn = 0
    while drawn < k:
        all_feasible *= max(0, inbox.feasible_votes - drawn) / (votes - drawn)
        all_infeasible *= max(0, inbox.infeasible_votes - drawn) / (votes - drawn)
        drawn += 1
    if inbox.chance < all_feasible:
        return 1
    if inbox.chance >= 1.0 - all_infeasible:
        return 0
    return mind.opinion
