"""
Opinions start as coin tosses and end as one
============================================

One swarm of 20 robots with 50 tasks, at four moments. Robots are discs, blue if they hold *feasible*,
orange if they hold *infeasible*; tasks are triangles; the shade is how far a robot sees. Twenty robots
can't do fifty tasks, and all find out.
"""

import matplotlib.pyplot as plt

import feasibee

swarm = feasibee.Swarm(feasibee.Scenario(tasks={"count": 50}), seed=4)
_, axes = plt.subplots(2, 2, figsize=(8, 8.6), layout="constrained")
for ax, step in zip(axes.flat, (0, 40, 80, 160), strict=True):
    swarm.advance(step - swarm.step)
    feasibee.plot_arena(swarm, ax)
    ax.get_legend().remove()
    infeasible = int((swarm.opinions == 0).sum())
    ax.set_title(f"step {swarm.step}: {infeasible} of 20 say infeasible")

# %%
# ``swarm`` is the same computation as :func:`feasibee.simulate`, run for run: the run's number and the seed
# say which.
