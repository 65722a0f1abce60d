"""Start and step of one swarm, and the transitions of its robots (model.md 3, 4)."""

from __future__ import annotations

from numba import int32, int64, uint32

from feasibee.engine import inbox
from feasibee.engine.acting import start_acting
from feasibee.engine.bodies import move_where_clear
from feasibee.engine.compile import called, inlined, spliced
from feasibee.engine.crowd import keep_order
from feasibee.engine.draws import draw_phases, list_members, phase_duration, present_phase
from feasibee.engine.dynamics import draw_dynamics
from feasibee.engine.few import move_few, sense_general_few
from feasibee.engine.intrinsics import contains, lowest_member, set_member, without_lowest
from feasibee.engine.knowledge import defer, known_by, setting_of, take_own_messages, update_pending
from feasibee.engine.layout import Clock, Count, Heard, Robot, Set
from feasibee.engine.motion import head, tick, turn
from feasibee.engine.opinions import adopt, count_opinions, opinion_of, set_declared
from feasibee.engine.params import Action, Moment
from feasibee.engine.sensing import fill_general, forget, sense_general_crowd
from feasibee.engine.starting import (
    assign_identities,
    clear,
    draw_faults,
    enter_phase,
    place_robots,
    place_tasks,
    prepare_robots,
    set_quorum,
    stop,
)
from feasibee.engine.team import wait_for_all
from feasibee.model.codes import CERTAIN, NO_OPINION
from feasibee.strategies.contract import Inbox, Mind


def start_general(params, state, run):
    """Put the swarm of a run at step 0, in the general engine (model.md 6)."""
    clear(params, state, run)
    assign_identities(params, state)
    place_tasks(params, state)
    place_robots(params, state)
    draw_faults(params, state)
    prepare_robots(params, state)
    if params.sensing.unique:
        state.remembered[:] = uint32(0)
    if params.faults.stop_step == 0:
        for w in range(state.sets.shape[1]):
            stop(params, state, w)
        set_quorum(params, state.clock, counted_after_stop(params))
    if params.acting.acts:
        start_acting(state)
    if params.changes:
        draw_dynamics(params, state)


@inlined
def let_act(params, state, functions, moment):
    """Let robots that act do what belongs to a moment of the step (model.md 6.25)."""
    if params.acting.acts:
        functions.act(params, state, int64(moment), int64(0), int64(0), uint32(0))


@spliced
def advance_general_few(params, state, functions, part):
    """Do one step of few robots in the general engine."""
    begin_general(params, state, functions, part)
    move_few(params, state, part)
    let_act(params, state, functions, Moment.MOVED)
    tick(state, part)
    sense_general_few(params, state, functions, part)
    end_general(params, state, functions, part)
    finish_few(params, state, functions, part)


@spliced
def advance_general_crowd(params, state, functions, part):
    """Do one step of more robots in the general engine."""
    if state.clock[Clock.STEP] == 0:
        fill_general(params, state, part)
    begin_general(params, state, functions, part)
    move_where_clear(params, state, part)
    keep_order(params, state, part)
    let_act(params, state, functions, Moment.MOVED)
    tick(state, part)
    sense_general_crowd(params, state, functions, part)
    wait_for_all(part)
    end_general(params, state, functions, part)
    finish(params, state, functions, part)


@inlined
def counted_after_stop(params):
    """Return the number of honest robots that work once the others have stopped."""
    return params.robots.at_start - params.faults.byzantine - params.faults.stopped


@inlined
def change_world(params, state, functions, now):
    """Change the world at the beginning of a step (model.md 6.17)."""
    if params.changes:
        functions.change(params, state, now)


@spliced
def begin_general(params, state, functions, part):
    """Stop robots whose time has come, change the world, and let robots begin to know."""
    now = state.clock[Clock.STEP] + 1
    if params.faults.stopped > 0 and now == params.faults.stop_step:
        for w in range(part.first, part.last):
            stop(params, state, w)
        set_quorum(params, state.clock, counted_after_stop(params))
        wait_for_all(part)
    if params.strategy.knowledge.enabled and now == 1:
        begin_to_know(params, state, functions)
    change_world(params, state, functions, now)
    if params.strategy.knowledge.enabled and params.changes:
        begin_to_know(params, state, functions)
    let_act(params, state, functions, Moment.BEGIN)


@called
def begin_to_know(params, state, functions):
    """Let those robots know what they know when they begin that don't yet."""
    for w in range(state.sets.shape[1]):
        left = state.sets[Set.JOINING, w]
        while left:
            defer(params, state, functions, Action.START, lowest_member(w, left), int64(0), int64(0))
            left = without_lowest(left)
        state.sets[Set.JOINING, w] = uint32(0)
    update_pending(params, state, functions, Action.START)


@spliced
def end_general(params, state, functions, part):
    """Ask robots whether they are sure, or for their opinions, and rate what they know."""
    if params.radio.delay > 0:
        take_own_messages(params, state, part)
    if params.strategy.declares:
        state.clock[Clock.PENDING] = params.robots.count
        update_pending(params, state, functions, Action.DECLARE)
    if params.strategy.judges:
        state.clock[Clock.PENDING] = params.robots.count
        update_pending(params, state, functions, Action.JUDGE)
    let_act(params, state, functions, Moment.END)
    rate_general(params, state, functions, part)


@spliced
def finish_few(params, state, functions, part):
    """Do what `finish` does with few robots, which have pools: so none are listed first."""
    for w in range(part.first, part.last):
        left = state.sets[Set.TURNING, w]
        while left:
            head(params, state, 0, lowest_member(w, left), 0)
            left = without_lowest(left)
    for w in range(part.first, part.last):
        left = state.sets[Set.ENDING, w]
        while left:
            i = lowest_member(w, left)
            end_phase(params, state, functions, part, i, present_phase(params, state, 0, i, 0))
            left = without_lowest(left)
    count_opinions(params, state, part)


@spliced
def finish(params, state, functions, part):
    """Turn the robots whose heading ends, and move on those whose phase ends."""
    turn(params, state, part)
    w = part.first
    while w < part.last:
        w, count = list_members(state, part.thread, state.sets[Set.ENDING], w, part.last)
        draw_phases(params, state, part.thread, count)
        for k in range(count):
            i = int64(state.heard[part.thread, Heard.RECEIVER, k])
            phase = present_phase(params, state, part.thread, i, k)
            end_phase(params, state, functions, part, i, phase)
    count_opinions(params, state, part)


@spliced
def end_phase(params, state, functions, part, i, phase):
    """Begin a robot's next phase, which has been drawn."""
    if contains(state.sets[Set.DISSEMINATING], i):
        end_dissemination(params, state, functions, part, i, phase)
    else:
        end_exploration(params, state, functions, i, phase)


@spliced
def end_exploration(params, state, functions, i, phase):
    """Begin to broadcast, for a duration that the opinion's quality sets (model.md 4.4)."""
    if params.decision.first_sight and contains(state.sets[Set.JOINING], i):
        adopt_first_sight(state, i)
    mind = mind_of(params, state, i)
    said = mind.opinion
    if params.strategy.says:
        said = functions.say(mind)
    set_member(state.sets, Set.SPEAKING, i, 0 <= said <= 1)
    set_member(state.sets, Set.SAYS_FEASIBLE, i, said == 1)
    if params.strategy.value_scale > 0.0:
        share = min(max(functions.value(mind), 0.0), 1.0)
        state.robots[Robot.SENT_VALUE, i] = int32(share * params.strategy.value_scale + 0.5)
    set_member(state.sets, Set.DISSEMINATING, i, True)
    length, _, _ = phase
    mean = functions.dissemination(mind.quality, params.decision.gain)
    if params.strategy.lasts:
        mean = functions.lasting(mind, params.decision.gain)
    lasts = phase_duration(params, state, i, length, mean)
    enter_phase(state, i, lasts + int32(params.decision.dissemination_floor))


@inlined
def adopt_first_sight(state, i):
    """Let a robot adopt what its first exploration favours; a tie keeps its opinion (model.md 6.10)."""
    set_member(state.sets, Set.JOINING, i, False)
    if state.memory[i, 0] != 0.5:
        adopt(state.sets, i, int64(state.memory[i, 0] > 0.5))


@spliced
def end_dissemination(params, state, functions, part, i, phase):
    """Decide by the inbox, or by knowledge, and explore again (model.md 4.6)."""
    length, chance, tie = phase
    feasible, votes, heard, told, total = inbox.read(params, state, i, tie)
    mean = inbox.as_share(params, total) / votes if votes > 0 else 0.0
    received = Inbox(feasible, votes - feasible, heard, inbox.as_share(params, told), mean, chance)
    decided = functions.decide(mind_of(params, state, i), received)
    adopt(state.sets, i, decided)
    if params.decision.declare.enabled:
        declare_by_votes(params, state.robots[Robot.AGREED], state.sets, i, feasible, votes)
    forget(params, state, part, i)
    set_member(state.sets, Set.DISSEMINATING, i, False)
    set_member(state.sets, Set.SPEAKING, i, False)
    enter_phase(state, i, phase_duration(params, state, i, length, params.decision.exploration))


@inlined
def rate(params, state, i, quality):
    """Rate the quality of *feasible* from a robot's counts."""
    floor = params.decision.quality_floor
    robots, tasks = state.counts[Count.ROBOTS_SEEN, i], state.counts[Count.TASKS_SEEN, i]
    state.memory[i, 0] = quality(max(robots, floor), max(tasks, floor))


@spliced
def rate_general(params, state, functions, part):
    """Rate the quality in the general engine.

    Knowledge grows while disseminating, so rate again before deciding.
    """
    if params.strategy.knowledge.enabled:
        for w in range(part.first, part.last):
            left = state.sets[Set.ENDING, w]
            while left:
                i = lowest_member(w, left)
                defer(params, state, functions, Action.COUNT, i, int64(0), int64(0))
                left = without_lowest(left)
        update_pending(params, state, functions, Action.COUNT)
    for w in range(part.first, part.last):
        left = state.sets[Set.ENDING, w]
        if not params.strategy.knowledge.enabled:
            left = uint32(left & ~state.sets[Set.DISSEMINATING, w])
        while left:
            i = lowest_member(w, left)
            if state.seen.shape[0] > 0:
                state.memory[i, 0] = scarcest(params, state, i, functions.quality)
            else:
                rate(params, state, i, functions.quality)
            left = without_lowest(left)


@inlined
def mind_of(params, state, i):
    """Return a robot's `Mind`."""
    quality = state.memory[i, 0]
    feasible_quality = quality
    opinion = opinion_of(state.sets, i)
    if opinion == 0:
        quality = 1.0 - quality
    elif opinion == NO_OPINION:
        quality = 0.5
    return Mind(
        opinion,
        quality,
        feasible_quality,
        params.decision.own_vote,
        state.memory[i, 1:],
        state.tables.parameters,
        params.decision.random_ties,
    )


@called
def sum_probabilities(params, state, functions):
    """Return the sum of what the counted robots say how probable *feasible* is (model.md 6.15.9)."""
    said, setting = int64(0), setting_of(params, state)
    for w in range(state.sets.shape[1]):
        left = state.sets[Set.COUNTED, w]
        while left:
            i = lowest_member(w, left)
            if contains(state.sets[Set.DECLARED], i):
                said += CERTAIN * int64(contains(state.sets[Set.DECLARED_FEASIBLE], i))
            else:
                share = functions.probability(mind_of(params, state, i), known_by(params, state, i), setting)
                said += int64(share * CERTAIN + 0.5)
            left = without_lowest(left)
    return said


@inlined
def scarcest(params, state, i, quality):
    """Return the least quality over the sets of skills of which anything was seen (model.md 6.7)."""
    least, floor = 2.0, params.decision.quality_floor
    for s in range(state.tables.adds.shape[0]):
        robots, tasks = int64(0), int64(0)
        for kind in range(params.robots.classes):
            robots += state.tables.adds[s, kind] * state.seen[i, kind]
        for kind in range(params.robots.classes, state.tables.adds.shape[1]):
            tasks += state.tables.adds[s, kind] * state.seen[i, kind]
        if robots + tasks > 0:
            least = min(least, quality(max(robots, floor), max(tasks, floor)))
    return quality(floor, floor) if least == 2.0 else least


@called
def declare_by_votes(params, agreed, sets, i, feasible, votes):
    """Let a robot declare after enough decisions in a row with which its inbox agreed (model.md 6.14)."""
    opinion = opinion_of(sets, i)
    agreeing = feasible if opinion == 1 else votes - feasible
    agrees = (
        votes >= params.decision.declare.heard
        and agreeing * params.decision.declare.whole >= params.decision.declare.share * votes
    )
    if opinion == NO_OPINION or not agrees:
        agreed[i] = 0
        return
    agreed[i] += int32(1)
    if agreed[i] >= params.decision.declare.rounds:
        set_declared(sets, i, opinion)
