"""The majority rule, unmodulated: quality plays no part.

A robot broadcasts for g steps on average, then takes the majority of the opinions that it heard, its own
included. The swarm soon agrees on what more robots held at first; what it saw has no say. A baseline.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Galam, "Majority rule, hierarchical structures, and democratic totalitarianism", 1986.
"""

from feasibee.strategies.dmmd import decide
