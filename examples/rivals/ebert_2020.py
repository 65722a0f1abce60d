"""Bayesian robots with a prior: they count observations, own and heard, until they are sure enough.

As the built-in `bayes`, but alpha and beta begin with ``prior``, 10 in the source, not 1. An exploration is
one observation: feasible if the robot saw more robots than tasks, infeasible if fewer. A robot broadcasts it;
with ``positive_feedback`` = 1 it broadcasts its opinion instead, once it has one.

Message: id and observation. Memory: two counts of things, two of observations, and the messages heard.

References
----------
Ebert, Gauci, Mallmann-Trenn, Nagpal, "Bayes Bots: collective Bayesian decision-making in decentralized robot
swarms", 2020. Read in khaiyichin/collective_perception, commit 04111dc2.
"""

PARAMETERS = {"threshold": 0.99, "prior": 10.0, "positive_feedback": 0.0}
MEMORY = 2
STARTS_NEUTRAL = True


def say(mind):
    """Return what to broadcast: the last observation, -1 if it has none, or the opinion."""
    if mind.parameters[2] > 0.0 and mind.opinion >= 0:
        return mind.opinion
    if mind.feasible_quality == 0.5:
        return -1
    return 1 if mind.feasible_quality > 0.5 else 0


def decide(mind, inbox):
    """Return the opinion that has enough credence, for good, or -1."""
    if mind.opinion >= 0:
        return mind.opinion
    mind.memory[0] += inbox.feasible_votes + (1.0 if mind.feasible_quality > 0.5 else 0.0)
    mind.memory[1] += inbox.infeasible_votes + (1.0 if mind.feasible_quality < 0.5 else 0.0)
    if mind.memory[0] == mind.memory[1]:
        return -1
    alpha, beta = mind.memory[0] + mind.parameters[1], mind.memory[1] + mind.parameters[1]
    if doubt(min(alpha, beta), max(alpha, beta)) >= 1.0 - mind.parameters[0]:
        return -1
    return 1 if alpha > beta else 0


def doubt(less, more):
    """Return the probability that the rarer side is the more frequent: P(p < 1/2) for Beta(more, less)."""
    # This is the chance of at least `more` heads in less + more - 1 fair coins. Halving avoids overflow.
    coins = less + more - 1.0
    halves, term = coins, 1.0
    for i in range(1, int(less)):
        term *= (more + i) / i
        while term > 1.0:
            term *= 0.5
            halves -= 1.0
    while halves > 0.0:
        term *= 0.5
        halves -= 1.0
    total, heads = 0.0, more
    while heads <= coins and term > 0.0:
        total += term
        heads += 1.0
        term *= (coins - heads + 1.0) / heads
    return total
