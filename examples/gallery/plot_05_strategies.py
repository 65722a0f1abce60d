"""
A census is right where the paper's strategy is right by chance only
====================================================================

Six strategies on the same worlds: 20 robots, from twice as many robots as tasks to half as many, 100 swarms
each. A swarm is right if more than 90 % of its robots have the true opinion after 1,000 steps.
"""

import matplotlib.pyplot as plt
import numpy as np

import feasibee
from feasibee.studies.comparison import compare, contenders_of

tasks = (10, 13, 16, 18, 20, 21, 22, 25, 40)
names = ("dmmd", "dmvd", "dc", "tally", "estimate", "census")
outcomes = compare(contenders_of(feasibee.Scenario(), names), tasks, runs=100, seed=1)

_, ax = plt.subplots(figsize=(7, 3.8), layout="constrained")
for name, marker in zip(names, "os^vDP", strict=True):
    middle, low, high = 100 * np.array([each.accuracy for each in outcomes if each.contender == name]).T
    bars = (middle - low, high - middle)
    ax.errorbar(range(len(tasks)), middle, yerr=bars, marker=marker, label=name, elinewidth=0.7)
ax.set_xticks(range(len(tasks)), [f"{20 / number:.2g}\n{number}" for number in tasks])
ax.set(xlabel="robots per task, and below it the number of tasks", ylabel="right at the end (%)")
ax.legend(loc="center left", bbox_to_anchor=(1, 0.5))
