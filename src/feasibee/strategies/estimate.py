"""Estimate: a tally that knows that nobody sees itself.

The table, the messages and the memory are those of `tally`. A robot that has k rows in its table knows of k
robots. Each saw only the k - 1 others, so that the number of tasks is about

    (k - 1) sum m_j / sum n_j

and the tasks are feasible if this is less than k + 1/2, halfway to the first number that isn't, and
infeasible if it is more; at k + 1/2 exactly, a tie, a robot keeps its opinion. So the swarm is about as often
right with one task too many as with just enough robots; a tally is neutral at m = n - 1.

Its probability that the tasks are feasible takes the rows for k independent, normal samples. Each leans by

    d_j = (2k - 2) m_j - (2k + 1) n_j,

whose mean is below 0 if the tasks are feasible. With Jeffreys' prior, flat in the mean and in the logarithm
of the spread, the mean follows Student's distribution with k - 1 degrees of freedom. An odd number of them is
rounded down, which is more careful: then the distribution is a finite sum.

References
----------
Our own. Jeffreys, "Theory of probability", 1961, section 3.41; Abramowitz and Stegun, "Handbook of
mathematical functions", 1964, 26.7.4.
"""

import math

from feasibee.strategies.tally import bits, decide, describe, layout, lie, merge, observe, rows_of, words
from feasibee.strategies.tally import count as sum_up

NEEDS_IDS = True


def count(known, counts, me):
    """Sum up all rows, times 2k + 1 for robots and 2k - 2 for tasks: both sides of the comparison."""
    classes = len(counts)
    sum_up(known, counts, me)
    rows, _ = rows_of(known, classes)
    for k in range(classes):
        counts[k] *= 2 * rows + 1 if k < me.setting.robot_classes else max(0, 2 * rows - 2)


def probability(mind, known, setting):
    """Return the probability that the rows lean to *feasible* on average."""
    rows, _ = rows_of(known, 2)
    total, squares = 0.0, 0.0
    for row in range(len(known) // 2):  # one without sightings doesn't lean
        leans = float((2 * rows - 2) * known[2 * row + 1] - (2 * rows + 1) * known[2 * row])
        total += leans
        squares += leans * leans
    return below_zero(total, squares, rows)


def below_zero(total, squares, samples):
    """Return the probability that the mean is below 0, from the samples' sum, sum of squares and number."""
    if samples < 3:
        return 0.5
    spread = squares - total * total / samples
    if spread <= 0.0:  # all are equal
        return 0.5 if total == 0.0 else 1.0 if total < 0.0 else 0.0
    freedom = (samples - 1) // 2 * 2
    cosine = freedom / (freedom + total * total * (samples - 1) / (samples * spread))  # its square
    term, part = 1.0, 0.0
    for k in range(freedom // 2):
        part += term
        term *= cosine * (2 * k + 1) / (2 * k + 2)
    half = min(0.5, 0.5 * part * math.sqrt(1.0 - cosine))
    return 0.5 + half if total < 0.0 else 0.5 - half
