"""SubCDM: a robot adopts an opinion drawn at random from those that it heard and its own.

A robot broadcasts its opinion for a time in proportion to the opinion's quality, g rho. Then it draws one
opinion: those that it heard and its own are equally likely. In the source it keeps two opinions heard, so
that its own has one chance in three; `subcdm.toml` sets that.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Fuady, Tarapore, Soorati, "Subset-Based Collective Decision-Making: Maintaining Decision Accuracy with Fewer
Robots", 2025 (arXiv 2508.00467). Read in SooratiLab/subset_CDM, commit 8c59e646.
"""


def dissemination(quality, gain):
    """Return the mean duration of broadcasting, in steps, in proportion to the quality."""
    return gain * quality


def decide(mind, inbox):
    """Return an opinion drawn from those heard and the robot's own."""
    feasible = inbox.feasible_votes + (1 if mind.opinion == 1 else 0)
    return 1 if inbox.chance * (inbox.feasible_votes + inbox.infeasible_votes + 1) < feasible else 0
