"""Shares of random outcomes, for tests with fixed seeds."""

from __future__ import annotations

import math

import numpy as np

Z = 5.3
"""Standard errors of a two-sided alpha of 1.2e-7."""


def bound(share, number, others=math.inf):
    """Return Z standard errors of how far a share of a number is from its expectation, or another share."""
    return Z * math.sqrt(share * (1 - share) * (1 / number + 1 / others))


def assert_share(hits, share, slack=1e-12):
    """See that a share of outcomes is the expected one but for chance."""
    hits = np.asarray(hits)
    assert abs(hits.mean() - share) <= bound(share, hits.size) + slack, (hits.mean(), share, hits.size)


def assert_even(values, low, high, bins=16):
    """See that values are uniform: each bin has its share."""
    counts, _ = np.histogram(values, bins=bins, range=(low, high))
    assert np.abs(counts - np.size(values) / bins).max() < Z * math.sqrt(np.size(values) / bins)
