"""
Three swarms in four decide correctly above ratio 2 and below 1/2
=================================================================

The paper's Fig. 3, 400 runs at each of 13 ratios, with 95 % Wilson intervals. At ratio one about half of the
swarms are right, as by chance.
"""

import matplotlib.pyplot as plt

import feasibee

numbers = (2, 3, 4, 6, 8, 13, 20, 31, 50, 67, 100, 133, 200)
rates = {"feasible": [], "infeasible": [], "undecided": []}
for tasks in numbers:
    swarms = feasibee.simulate(feasibee.Scenario(tasks={"count": tasks}), runs=400, seed=1)
    for decision, rate in feasibee.decision_rates(swarms.decision).items():
        rates[decision].append(rate)

_, ax = plt.subplots(figsize=(6.8, 3.6), layout="constrained")
feasibee.plot_decisions([20 / tasks for tasks in numbers], rates, ax)
ax.axhline(75, color="0.6", linestyle=":", linewidth=1)

# %%
# ``feasibee paper`` draws this figure at 21 ratios. It also writes the data and tests the paper's claims.
