"""The voter model, unmodulated: quality plays no part.

A robot broadcasts for g steps on average, then takes one of the opinions that it heard at random. The swarm
agrees on something; what it saw has no say. A baseline.

Message: id and opinion. Memory: two counts, and one opinion for each robot heard.

References
----------
Holley, Liggett, "Ergodic theorems for weakly interacting infinite systems and the voter model", 1975.
"""

from feasibee.strategies.dmvd import decide
