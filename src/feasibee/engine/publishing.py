"""What robots send in a step, true or lies (model.md 6.6, 6.11)."""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine.bits import (
    contains,
    has_bit,
    lowest_member,
    number_of,
    pack_label,
    says_feasible,
    without_lowest,
)
from feasibee.engine.compile import inlined, spliced
from feasibee.engine.draws import coin, draw_now
from feasibee.engine.intrinsics import popcount
from feasibee.engine.knowledge import defer, update_pending
from feasibee.engine.layout import Clock, Robot, Set, Share
from feasibee.engine.params import Action, Lie
from feasibee.model.purposes import LIE


@inlined
def false_opinion_of(params, state, i):
    """Return the opinion in a Byzantine robot's message (model.md 6.6, 6.16)."""
    if params.faults.byzantine_says == Lie.COLLUDING:
        return 1 - state.clock[Clock.TRUTH]
    if params.faults.byzantine_says == Lie.OPPOSITE:
        return 1 - int64(contains(state.sets[Set.SAYS_FEASIBLE], i))
    if params.faults.byzantine_says == Lie.RANDOM:
        return coin(draw_now(params, state, number_of(state.robots[Robot.LABEL, i]), LIE))
    return int64(params.faults.byzantine_says == Lie.FEASIBLE)


@spliced
def publish(params, state, functions, part):
    """Fix the message of each robot for this step, and count its bits."""
    bits_sent = int64(0)
    for w in range(part.first, part.last):
        byzantine = state.sets[Set.BYZANTINE, w]
        if params.faults.colluding:
            state.sets[Set.SPEAKING, w] |= uint32(byzantine & state.sets[Set.WORKING, w])
        speaking = state.sets[Set.SPEAKING, w]
        bits_sent += popcount(speaking) * params.radio.message_bits
        lying = uint32(speaking & byzantine)
        while lying:
            lie_to_all(params, state, lowest_member(w, lying))
            lying = without_lowest(lying)
        while speaking and params.strategy.knowledge.enabled:
            i = lowest_member(w, speaking)
            false_opinion = (
                says_feasible(state.robots[Robot.LABEL, i]) if has_bit(byzantine, i) else int64(-1)
            )
            defer(params, state, functions, Action.SPEAK, i, false_opinion, int64(0))
            speaking = without_lowest(speaking)
    part.shared[part.thread, Share.BITS] = bits_sent
    update_pending(params, state, functions, Action.SPEAK)


@inlined
def lie_to_all(params, state, i):
    """Fix the message of a Byzantine robot for this step."""
    number, opinion = number_of(state.robots[Robot.LABEL, i]), false_opinion_of(params, state, i)
    state.robots[Robot.LABEL, i] = pack_label(number, opinion == 1, True)
    state.robots[Robot.SENT_VALUE, i] = int32(params.strategy.value_scale) if opinion == 1 else int32(0)
