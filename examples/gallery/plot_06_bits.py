"""
Accuracy costs bits: 2 per robot-step give 77 %, 11 give 85 %, 217 give 99 %
============================================================================

Sixteen strategies at four ratios near one, 50 swarms each. The share that is right at the end is drawn
against the mean number of bits that a robot sends per step. No strategy lies above and left of the grey
line, the Pareto frontier.
"""

import feasibee
from feasibee.figures.comparison import draw_against_bits
from feasibee.strategies import STRATEGIES
from feasibee.studies.comparison import by_contender, compare, contenders_of, mean_bits, overall

settling = [name for name, each in STRATEGIES.items() if not (each.judges or each.needs_count)]
contenders = contenders_of(feasibee.Scenario(), settling)
outcomes = compare(contenders, tasks=(16, 18, 22, 25), runs=50, seed=1)
totals = {name: (mean_bits(group), overall(group)) for name, group in by_contender(outcomes).items()}
figure = draw_against_bits(totals)

# %%
# With eleven bits, a message has a number in addition to the opinion. With hundreds, it has all that its
# robot knows of the swarm. :doc:`/strategies` has 1,000 runs of each, and the effects of walls, lost messages
# and Byzantine robots.
