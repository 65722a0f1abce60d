"""
Half of the swarms have decided by step 127, and wrong swarms hardly later
==========================================================================

The percentage of 1,000 swarms of 20 robots with 10 tasks that had decided by each step, for each decision.
The tasks are feasible, so the dashed line shows the wrong swarms. The time of a decision is weak evidence of
whether it is right.
"""

import matplotlib.pyplot as plt

import feasibee

swarms = feasibee.simulate(feasibee.Scenario(tasks={"count": 10}), runs=1000, seed=1)
_, ax = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
feasibee.plot_decision_steps(swarms, ax)
ax.set_xlim(0, 600)

# %%
# Quartiles over all runs, and over the wrong ones. A run that never decides counts as later than any step; it
# isn't left out.

print(feasibee.decision_times(swarms.decision_step))
print(feasibee.decision_times(swarms.decision_step.where(swarms.decision == 0, drop=True)))
