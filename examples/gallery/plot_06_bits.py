"""
Accuracy costs bits: 2 a step buy 77 %, 11 buy 85 %, 217 buy 99 %
=================================================================

All fourteen strategies at four ratios near one, 50 swarms each: how often they are right at the end,
against what a robot sends in a step on average. Nothing stands above and left of the grey line.
"""

import feasibee
from feasibee.figures.comparison import draw_against_bits
from feasibee.studies.comparison import by_contender, compare, contenders_of, mean_bits, overall

contenders = contenders_of(feasibee.Scenario())
outcomes = compare(contenders, tasks=(16, 18, 22, 25), runs=50, seed=1)
totals = {name: (mean_bits(group), overall(group)) for name, group in by_contender(outcomes).items()}
figure = draw_against_bits(totals)

# %%
# Eleven bits are a number beside the opinion; hundreds are what each robot knows of all the others.
# :doc:`/strategies` has 1,000 runs of each, and what walls, losses and liars do to them.
