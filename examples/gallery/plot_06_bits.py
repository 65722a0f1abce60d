"""
Accuracy costs bits: 2 per robot-step give 77 %, 11 give 85 %, 217 give 99 %
============================================================================

Twelve strategies at four ratios near one, 50 swarms each. The share that is right at the end is drawn
against the mean number of bits that a robot sends per step. No strategy lies above and left of the grey
line, the Pareto frontier.
"""

import matplotlib.pyplot as plt

import feasibee

settling = [name for name, each in feasibee.STRATEGIES.items() if not (each.judges or each.needs_count)]
table = feasibee.compare(feasibee.Scenario(), settling, tasks=(16, 18, 22, 25), runs=50, seed=1)
table["bits"] = table.bits_per_robot_and_step.astype(float)
means = table.groupby("contender")[["bits", "accuracy"]].mean().sort_values("bits")

_, ax = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
best = means[means.accuracy >= means.accuracy.cummax()]
ax.plot(best.bits, 100 * best.accuracy, color="0.8", zorder=0)
ax.plot(means.bits, 100 * means.accuracy, "o")
for k, (name, (bits, share)) in enumerate(means.iterrows()):
    ax.annotate(name, (bits, 100 * share), (4, (3, -9)[k % 2]), textcoords="offset points", fontsize=8)
ax.set(xscale="log", xlabel="bits per robot-step", ylabel="right at the end (%)", ylim=(0, 110))

# %%
# With eleven bits, a message has a number in addition to the opinion. With hundreds, it has all that its
# robot knows of the swarm. :doc:`/strategies` has 1,000 runs of each, and the effects of walls, lost messages
# and Byzantine robots.
