"""
One Byzantine robot in twenty makes a census wrong; a tally stays right
=======================================================================

Twenty robots and 40 tasks, which is infeasible. One Byzantine robot broadcasts *feasible*. In a census,
robots pass on the robots that it invents. A tally keeps the totals of each robot apart, and no robot accepts
its own row from others.
"""

import matplotlib.pyplot as plt
import numpy as np

import feasibee

names = ("dmmd", "dmvd", "bayes", "tally", "census")
honest = feasibee.Scenario(tasks={"count": 40})
byzantine = honest.replace({"faults.byzantine": 0.05, "faults.byzantine_says": "feasible"})

_, ax = plt.subplots(figsize=(6.4, 3.4), layout="constrained")
for shift, (label, scenario) in enumerate({"all honest": honest, "one Byzantine": byzantine}.items()):
    table = feasibee.compare(scenario, names, runs=200, seed=1)
    middle, low, high = 100 * table[["accuracy", "accuracy_low", "accuracy_high"]].to_numpy(float).T
    places, bars = np.arange(len(names)) + 0.4 * shift, (middle - low, high - middle)
    ax.bar(places, middle, 0.38, yerr=bars, label=label, color=("0.75", "#D55E00")[shift])
ax.set_xticks(np.arange(len(names)) + 0.2, names)
ax.set(ylabel="right at the end (%)", ylim=(0, 104))
ax.legend(loc="upper left", bbox_to_anchor=(1, 1))
