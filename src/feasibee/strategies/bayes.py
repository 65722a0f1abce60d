"""Bayes Bots: each robot counts observations, its own and others', until it is sure.

An exploration is one observation: *feasible* if the robot saw more robots than tasks, *infeasible* if fewer.
It broadcasts the observation for g steps on average. At the end of each dissemination it adds its own to one
of the two counts, and one for every robot that it heard:

    alpha = observations of feasible + 1,  beta = observations of infeasible + 1

The belief that robots are the more frequent kind follows Beta(alpha, beta). Once P(p > 1/2) or its
complement exceeds the credence, the robot has an opinion, for good; until then it has none. With positive
feedback it broadcasts that opinion from then on instead of what it observes.

Its probability that the tasks are feasible is P(p > 1/2), from the uniform prior of p that alpha and beta
begin with, as if no observation depended on another.

Message: id and observation. Memory: two counts of things, two of observations, and one observation for each
robot heard.

References
----------
Ebert, Gauci, Mallmann-Trenn, Nagpal, "Bayes Bots: collective Bayesian decision-making in decentralized robot
swarms", 2020.
"""

PARAMETERS = {"credence": 0.95, "positive_feedback": 1.0}
MEMORY = 2
STARTS_NEUTRAL = True


def say(mind):
    """Return the opinion of a robot that has one, with positive feedback; else its last observation."""
    if mind.parameters[1] > 0.0 and mind.opinion >= 0:
        return mind.opinion
    if mind.feasible_quality == 0.5:
        return -1
    return 1 if mind.feasible_quality > 0.5 else 0


def decide(mind, inbox):
    """Return the opinion that has enough credence, or none (-1)."""
    if mind.opinion >= 0:
        return mind.opinion
    mind.memory[0] += inbox.feasible_votes + (1.0 if mind.feasible_quality > 0.5 else 0.0)
    mind.memory[1] += inbox.infeasible_votes + (1.0 if mind.feasible_quality < 0.5 else 0.0)
    alpha, beta = mind.memory[0] + 1.0, mind.memory[1] + 1.0
    if alpha != beta and tail_of(alpha, beta) < 1.0 - mind.parameters[0]:
        return 1 if alpha > beta else 0
    return -1


def tail_of(alpha, beta):
    """Return the lesser of P(p < 1/2) and P(p > 1/2), but 1/2 or more for equal counts."""
    # The lesser of P(p < 1/2) and P(p > 1/2) is the chance that alpha + beta - 1 fair coins show at least
    # max(alpha, beta) heads: a sum that starts at its largest term, kept near 1 while it is multiplied out.
    coins = alpha + beta - 1.0
    heads = max(alpha, beta)
    term, factors, halves = 1.0, 0.0, coins
    while factors < coins - heads or halves > 0.0:
        if halves > 0.0 and (term > 1.0 or factors == coins - heads):
            halves -= 1.0
            term *= 0.5
        else:
            factors += 1.0
            term *= (heads + factors) / factors
    tail = 0.0
    while heads <= coins and term > 0.0:
        tail += term
        heads += 1.0
        term *= (coins - heads + 1.0) / heads
    return tail


def probability(mind, known, setting):
    """Return P(p > 1/2)."""
    alpha, beta = mind.memory[0] + 1.0, mind.memory[1] + 1.0
    if alpha == beta:
        return 0.5
    tail = min(0.5, tail_of(alpha, beta))
    return 1.0 - tail if alpha > beta else tail
