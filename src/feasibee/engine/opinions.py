"""The opinions of robots, as members of sets (model.md 4.1, 6.9)."""

from __future__ import annotations

from numba import int64

from feasibee.engine.bits import contains, set_member
from feasibee.engine.compile import inlined
from feasibee.engine.layout import Set
from feasibee.model.codes import NO_OPINION


@inlined
def keeps_opinion(sets, i):
    """Return whether a robot never changes its opinion again."""
    return (
        contains(sets[Set.STUBBORN], i) or contains(sets[Set.COMMITTED], i) or contains(sets[Set.DECLARED], i)
    )


@inlined
def opinion_of(sets, i):
    """Return a robot's opinion."""
    if contains(sets[Set.NEUTRAL], i):
        return int64(NO_OPINION)
    return int64(contains(sets[Set.FEASIBLE], i))


@inlined
def set_opinion(sets, i, opinion):
    """Set a robot's opinion; any value but 1 and 0 means none."""
    set_member(sets, Set.FEASIBLE, i, opinion == 1)
    set_member(sets, Set.NEUTRAL, i, not 0 <= opinion <= 1)
