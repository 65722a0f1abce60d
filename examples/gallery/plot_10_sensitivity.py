"""
Dissemination time and range of sight matter; other fields show no clear effect
===============================================================================

Five fields of the scenario vary at once over a Latin hypercube of 150 points, with 20 swarms of 20 robots
and 10 tasks at each. The figure shows rank correlations with the share of the swarms that are right after
1,000 steps, with 95 % intervals.
"""

import feasibee
from feasibee.studies.space import dimensions
from feasibee.studies.tuning import draw_sensitivities, sensitivities

scenario = feasibee.Scenario(tasks={"count": 10})
space = dimensions(
    scenario,
    ["sensing.range=1:5", "walk.mean_run", "decision.exploration", "decision.gain", "radio.loss=0:0.5"],
)
found, places, shares = sensitivities(scenario, space, points=150, runs=20, seed=1)
figure = draw_sensitivities(found)
