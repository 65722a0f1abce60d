"""What strategies share whose robots give a probability: how sure a few samples make of a mean.

The samples are taken for independent and normal, with unknown mean and spread. With Jeffreys' prior, flat in
the mean and in the logarithm of the spread, the mean then follows Student's distribution with one degree of
freedom less than there are samples. An odd number of them is rounded down, which is more careful: then the
distribution is a finite sum.

References
----------
Jeffreys, "Theory of probability", 1961, section 3.41; Abramowitz and Stegun, "Handbook of mathematical
functions", 1964, 26.7.4.
"""

import math


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
