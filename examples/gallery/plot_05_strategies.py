"""
A census is right where the paper's strategy is right by chance only
====================================================================

Six strategies on the same worlds: 20 robots, from twice as many robots as tasks to half as many, 100 swarms
each. A swarm is right if more than 90 % of its robots have the true opinion after 1,000 steps.
"""

import matplotlib.pyplot as plt

import feasibee

tasks = (10, 13, 16, 18, 20, 21, 22, 25, 40)
names = ("dmmd", "dmvd", "dc", "tally", "estimate", "census")
table = feasibee.compare(feasibee.Scenario(), names, tasks, runs=100, seed=1)

_, ax = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
for name, rows in table.groupby("contender", sort=False):
    ratio, right = rows.robots / rows.tasks, 100 * rows.accuracy
    bars = [right - 100 * rows.accuracy_low, 100 * rows.accuracy_high - right]
    ax.errorbar(ratio, right, yerr=bars, marker="o", markersize=4, label=name)
ax.set(xscale="log", xlabel="robots per task", ylabel="right at the end (%)")
ax.minorticks_off()
ax.set_xticks([0.5, 1, 2], ["0.5", "1", "2"])
ax.legend(loc="upper left", bbox_to_anchor=(1, 1))
