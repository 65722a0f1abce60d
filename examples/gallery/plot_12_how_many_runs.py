"""
Showing that 0.80 exceeds 0.75 takes 750 runs; the paper's 100 runs suffice for 0.88
====================================================================================

The probability that a study shows that more than 75 % of the swarms decide correctly, against the true
share. A study shows it if its 95 % Wilson interval lies above 75 %. There is no simulation: the probability
follows from the binomial distribution. The grey line is nine studies in ten.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import feasibee


def power(truth, runs):
    """Return the probability that the interval of so many runs lies above 0.75."""
    shown = np.array([feasibee.wilson(right, runs).low > 0.75 for right in range(runs + 1)])
    right = np.arange(runs + 1)
    logs = np.cumsum(np.log(np.maximum(1, right)))  # of factorials
    chance = logs[-1] - logs - logs[::-1] + right * math.log(truth) + (runs - right) * math.log1p(-truth)
    return float(np.exp(chance)[shown].sum())


_, ax = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
truths = np.linspace(0.75, 0.95, 41)
for runs, dashes in {100: "-", 400: "--", 750: "-.", 2000: ":"}.items():
    ax.plot(truths, [100 * power(truth, runs) for truth in truths], dashes, label=f"{runs:,} runs")
ax.axhline(90, color="0.8", linewidth=1, zorder=0)
ax.set(xlabel="true share of right decisions", ylabel="studies that show more than 0.75 (%)")
ax.legend()
print({runs: round(power(0.80, runs), 2) for runs in (100, 400, 750, 2000)})
