"""Accumulate: DMMD with evidence that is never thrown away.

The counts run over all explorations of a robot's life, so that the quality of its opinion becomes ever less
noisy; broadcasts and majority are those of DMMD.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Our own; the evidence of one short exploration is what limits DMMD near ratio one.
"""

from feasibee.strategies.dmmd import decide, dissemination

FORGETS = False
