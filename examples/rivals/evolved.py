"""An evolved net: two recurrent units whose twelve weights were found by differential evolution.

The units read what the last exploration saw, what the messages say, and both units before. The first unit's
sign is the opinion. The second unit is broadcast in 8 bits, and what it means was left to evolution.
`evolve.py` computes the weights again. Nobody designed this rule.

Message: id, opinion, and a value in 8 bits. Memory: two counts, two units, and one opinion and value for each
robot heard.

References
----------
Storn, Price, "Differential evolution: a simple and efficient heuristic for global optimization over
continuous spaces", 1997.
"""

MEMORY = 2
VALUE_BITS = 8
PARAMETERS = {
    "seen_1": 3.125,
    "votes_1": 2.271,
    "told_1": -0.308,
    "first_1": 2.659,
    "second_1": 2.387,
    "bias_1": 0.801,
    "seen_2": 3.623,
    "votes_2": 2.452,
    "told_2": -3.250,
    "first_2": 3.853,
    "second_2": 1.053,
    "bias_2": -2.650,
}


def unit(total):
    """Return a number between -1 and 1 that grows with the total: softsign, which needs no library."""
    return total / (1.0 + abs(total))


def value(mind):
    """Return the second unit, from 0 to 1."""
    return (mind.memory[1] + 1.0) * 0.5


def decide(mind, inbox):
    """Compute both units anew, and return the sign of the first."""
    seen = 2.0 * mind.feasible_quality - 1.0
    heard = inbox.feasible_votes + inbox.infeasible_votes
    votes, told = 0.0, 0.0
    if heard > 0:
        votes = (inbox.feasible_votes - inbox.infeasible_votes) / heard
        told = 2.0 * inbox.mean_value - 1.0
    w = mind.parameters
    first, second = mind.memory[0], mind.memory[1]
    mind.memory[0] = unit(w[0] * seen + w[1] * votes + w[2] * told + w[3] * first + w[4] * second + w[5])
    mind.memory[1] = unit(w[6] * seen + w[7] * votes + w[8] * told + w[9] * first + w[10] * second + w[11])
    return 1 if mind.memory[0] > 0.0 else 0
