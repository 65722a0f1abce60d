"""
Opinions start at random and end in agreement
=============================================

One swarm of 20 robots with 50 tasks, at four moments. Robots are discs: full blue with opinion *feasible*,
hollow orange with opinion *infeasible*. Tasks are triangles. The shade shows the range of a robot's sight.
Twenty robots can't do fifty tasks, and all robots agree on that at the end.
"""

import matplotlib.pyplot as plt

import feasibee

swarm = feasibee.Swarm(feasibee.Scenario(tasks={"count": 50}), seed=4)
_, axes = plt.subplots(2, 2, figsize=(5.6, 6.1), layout="constrained")
for ax, step in zip(axes.flat, (0, 40, 80, 160), strict=True):
    swarm.advance(step - swarm.step)
    feasibee.plot_arena(swarm, ax)
    ax.get_legend().remove()
    infeasible = int((swarm.opinions == 0).sum())
    ax.set_title(f"step {swarm.step}: {infeasible} infeasible")

# %%
# ``swarm`` computes the same run as :func:`feasibee.simulate` with the same seed and run number.
