"""DMMD, Direct Modulation of Majority-based Decisions: the paper's strategy.

A robot broadcasts its opinion for a time in proportion to the opinion's quality, then takes the
majority of the opinions that it heard.

Message: the robot's id and its opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Valentini, Ferrante, Hamann, Dorigo, "Collective decision with 100 Kilobots", 2016; on feasibility:
Fuady, Tarapore, Ehsan, Soorati, "Collective Decision-Making on Task Allocation Feasibility", 2024.
"""


def quality(robots_seen: int, tasks_seen: int) -> float:
    """Return the quality of *feasible*: rho_1 = n_obs / (n_obs + m_obs), or 1/2 with nothing seen (eq. 1)."""
    if robots_seen + tasks_seen == 0:
        return 0.5
    return robots_seen / (robots_seen + tasks_seen)


def dissemination(quality: float, gain: float) -> float:
    """Return the mean duration, in steps, of broadcasting an opinion of this quality: g rho."""
    return gain * quality


def decide(opinion: int, feasible_votes: int, infeasible_votes: int) -> int:
    """Return the majority of the votes; a tie keeps the opinion."""
    if feasible_votes > infeasible_votes:
        return 1
    if feasible_votes < infeasible_votes:
        return 0
    return opinion
