"""
Clustered tasks make swarms wrong; walls hardly do
==================================================

Twenty robots and 40 tasks, which is clearly infeasible. With tasks in clusters, presumably most robots meet
robots and few tasks, and agree on *feasible* before they have moved far.
"""

import matplotlib.pyplot as plt
import numpy as np

import feasibee

paper = feasibee.Scenario(tasks={"count": 40})
walls = {"arena.boundary": "walls", "robots.avoid_collisions": True}
clusters = {"tasks.placement": "clusters"}
worlds = {
    "as in the paper": paper,
    "walls, and robots that collide": paper.replace(walls),
    "tasks in three clusters": paper.replace(clusters),
    "both": paper.replace({**walls, **clusters}),
}
decisions = [feasibee.simulate(world, runs=400, seed=1).decision for world in worlds.values()]
rates = [feasibee.wilson(int((each == 0).sum()), 400) for each in decisions]
middle, low, high = 100 * np.array(rates).T

_, (left, right) = plt.subplots(1, 2, figsize=(6.8, 3.2), layout="constrained", width_ratios=(1, 1.2))
feasibee.plot_arena(feasibee.Swarm(worlds["tasks in three clusters"], seed=1), left)
left.get_legend().remove()
right.errorbar(middle, range(4), xerr=(middle - low, high - middle), fmt="o", color="#0072B2", capsize=3)
right.set_yticks(range(4), list(worlds))
right.set(xlabel="swarms that rightly\ndecide infeasible (%)", xlim=(0, 100), ylim=(3.5, -0.5))
right.axvline(50, color="0.8", zorder=0)
