"""
A census is right where the paper's strategy is right by chance only
====================================================================

Six strategies on the same worlds: 20 robots, from twice as many robots as tasks to half as many, 100 swarms
each. A swarm is right if more than 90 % of its robots have the true opinion after 1,000 steps.
"""

import feasibee
from feasibee.figures.comparison import draw_against_ratio
from feasibee.studies.comparison import compare, contenders_of

tasks = (10, 13, 16, 18, 20, 21, 22, 25, 40)
names = ("dmmd", "dmvd", "dc", "tally", "estimate", "census")
outcomes = compare(contenders_of(feasibee.Scenario(), names), tasks, runs=100, seed=1)

shares = {name: [each.accuracy for each in outcomes if each.contender == name] for name in names}
figure = draw_against_ratio(20, tasks, shares)
