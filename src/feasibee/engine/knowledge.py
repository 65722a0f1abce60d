"""Knowledge that robots pass on: what they get for it, how it changes, what they send.

A call through a function pointer costs much with the arrays that knowledge needs. So the engine collects in
`State.pending` whom each function is to be called for, and calls `update`, which is compiled for each
strategy with the strategy's functions inlined: three or four times per step of the whole swarm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from numba import float64, int32, int64, uint32

from feasibee.engine.compile import called, inlined, rebound, spliced
from feasibee.engine.draws import coin, draw_now
from feasibee.engine.intrinsics import (
    contains,
    has_bit,
    lowest_member,
    number_of,
    pack_label,
    popcount,
    row_of,
    says_feasible,
    set_member,
    sure_row_of,
    tuple_of,
    without_lowest,
)
from feasibee.engine.layout import (
    PENDING_ROOM,
    WORD,
    Clock,
    Copy,
    Count,
    Delayed,
    Pending,
    Point,
    Robot,
    Set,
    Share,
)
from feasibee.engine.opinions import adopt, set_declared
from feasibee.engine.params import Action, Lie, Moment
from feasibee.engine.queues import store_members
from feasibee.model.codes import BITS_LIMIT, COUNT_LIMIT
from feasibee.model.outcomes import BITS_SENT
from feasibee.model.purposes import LIE
from feasibee.strategies.contract import Me, Setting, Thing


@spliced
def known_by(params, state, i):
    """Return the words that a robot knows."""
    return row_of(state.knowledge, Copy.KNOWN, i, params.strategy.knowledge.words)


@spliced
def told_by(params, state, i):
    """Return the words of a robot's message."""
    return row_of(state.knowledge, Copy.SENT, i, params.strategy.knowledge.message_words)


@inlined
def in_units(params, fixed):
    """Return a coordinate in units of length."""
    return float64(uint32(fixed)) * params.arena.unit


@inlined
def thing_seen(params, state, number, column, mark):
    """Return a robot or task as robots see it.

    Robots are numbered first, then tasks, then tasks under their wrong names, with the hash given. One that
    isn't there has number -1, and the class and hash given.
    """
    if number < 0:
        is_robot = column < params.robots.classes
        kind = column if is_robot else column - params.robots.classes
        return Thing(is_robot, int64(-1), kind, int64(uint32(mark)), 0.0, 0.0)
    # Without a branch: a wrong guess whether robot or task follows costs more than the rest.
    misnamed = number >= params.robots.count + params.tasks.count
    number -= params.tasks.count if misnamed else 0
    is_robot, kind, task = (
        number < params.robots.count,
        int64(state.tables.class_of[number]),
        number - params.robots.count,
    )
    identity = int64(state.robots[Robot.IDENTITY, number if is_robot else 0])
    own_mark = int64(state.hashes[identity if is_robot else number])
    fixed_x = state.robots[Robot.X, number] if is_robot else state.tasks[Point.X, task]
    fixed_y = state.robots[Robot.Y, number] if is_robot else state.tasks[Point.Y, task]
    x, y = in_units(params, fixed_x), in_units(params, fixed_y)
    if misnamed:
        half = 0.5 * params.arena.sides.width
        wrong = params.strategy.knowledge.task_ids - params.tasks.count + task
        return Thing(False, wrong, kind, int64(uint32(mark)), x + half if x < half else x - half, y)
    return Thing(is_robot, identity if is_robot else task, kind, own_mark, x, y)


@inlined
def passed(parameters):
    """Return the strategy's parameters as its functions get them; a built-in one has `constants`."""
    return parameters


@inlined
def setting_of(params, state):
    """Return the numbers of the scenario that a function of the strategy is given.

    Read before a loop over robots, not in it: the compiler must assume that the functions change them.
    """
    knowledge = params.strategy.knowledge
    return Setting(
        params.robots.count,
        params.robots.at_start,
        params.tasks.count,
        knowledge.robot_ids,
        knowledge.task_ids,
        params.robots.classes,
        knowledge.task_classes,
        params.radio.id_bits,
        passed(state.tables.parameters),
        params.robots.knows_count,
        params.faults.colluding,
        params.arena.sides.width,
        params.arena.sides.height,
        params.arena.walls,
        params.sensing.swept,
        params.radio.range,
        params.robots.speed,
        params.decision.exploration,
        params.decision.gain + params.decision.dissemination_floor,
        params.walk.mean_run,
        params.arena.place.flooding,
        float64(params.radio.delay),
        state.tables.ground.sketch,
        params.arena.place.plan_columns,
        params.robots.known_work,
        params.robots.known_charge,
    )


@inlined
def me_of(params, state, setting, now, i):
    """Return the robot that a function of the strategy works for."""
    identity = int64(state.robots[Robot.IDENTITY, i])
    mark = int64(state.hashes[identity])
    x, y = in_units(params, state.robots[Robot.X, i]), in_units(params, state.robots[Robot.Y, i])
    explores = not contains(state.sets[Set.DISSEMINATING], i)
    return Me(
        identity, int64(state.tables.class_of[i]), mark, now, state.memory[i, 1:], setting, explores, x, y
    )


def _missing(*arguments: Any) -> Any:
    """Stand for a strategy's function, in whose place a copy of `update` has it; see `updating`."""
    raise NotImplementedError


UNSENT: Final = -(2**62)
"""`Count.SENT_BITS` of a robot whose words of `Copy.SENT` are no copy of what it once knew."""

start = observe = encode = lie = falsify = merge = count = bits = declare = judge = _missing
repeats: bool = False
"""Whether a robot that learns nothing new repeats its message: a copy of what it knows, and its length."""


@inlined
def learns(state, i):
    """Mark a robot whose knowledge may have changed since its last message."""
    if state.counts[Count.SENT_BITS, i] >= 0:
        state.counts[Count.SENT_BITS, i] = ~state.counts[Count.SENT_BITS, i]


@inlined
def same(message, known):
    """Return whether a message is a copy of what is known."""
    differing = int32(0)
    for k in range(len(known)):
        differing |= message[k] ^ known[k]
    return differing == 0


def start_all(params, state, now, number):
    """Let robots know what they know when they begin."""
    setting = setting_of(params, state)
    for k in range(number):
        i = int64(state.pending[Pending.WHO, k])
        known = known_by(params, state, i)
        known[:] = 0
        state.counts[Count.SENT_BITS, i] = UNSENT
        start(known, me_of(params, state, setting, now, i))


def observe_all(params, state, now, number):
    """Add what was seen to what is known."""
    setting = setting_of(params, state)
    who, numbers, columns = (
        state.pending[Pending.WHO],
        state.pending[Pending.NUMBER],
        state.pending[Pending.COLUMN],
    )
    for k in range(number):
        i, seen, column = int64(who[k]), int64(numbers[k]), int64(columns[k])
        thing = thing_seen(params, state, seen, column, state.pending[Pending.MARK, k])
        learns(state, i)
        observe(known_by(params, state, i), thing, me_of(params, state, setting, now, i))


def speak_all(params, state, now, number):
    """Write the messages; return their length in bits."""
    setting, total = setting_of(params, state), int64(0)
    for k in range(number):
        i, says = int64(state.pending[Pending.WHO, k]), int64(state.pending[Pending.FALSE_OPINION, k])
        message, known = told_by(params, state, i), known_by(params, state, i)
        length = state.counts[Count.SENT_BITS, i]
        if repeats and UNSENT < length < 0 and same(message, known):
            length = state.counts[Count.SENT_BITS, i] = ~length
        if not repeats or length < 0:
            me = me_of(params, state, setting, now, i)
            encode(message, known, me)
            if says >= 0:
                falsify(params, state, message, says, me)
            length = bits(message, me)
            if not 0 <= length <= BITS_LIMIT:
                raise ValueError("bits must return a whole number from 0 to 2**40")
            if repeats and says < 0:
                state.counts[Count.SENT_BITS, i] = length
        if params.radio.delay > 0:
            state.delayed[slot_of(state, now), i, Delayed.LENGTH] = length
        else:
            total += length
    return total


def merge_all(params, state, now, number):
    """Add what was heard to what is known."""
    setting = setting_of(params, state)
    for k in range(number):
        i, sender = int64(state.pending[Pending.WHO, k]), int64(state.pending[Pending.SPEAKER, k])
        message, me = told_by(params, state, sender), me_of(params, state, setting, now, i)
        learns(state, i)
        merge(known_by(params, state, i), message, int64(state.robots[Robot.IDENTITY, sender]), me)


def count_all(params, state, now, number):
    """Count what is known, by class."""
    setting = setting_of(params, state)
    for k in range(number):
        i = int64(state.pending[Pending.WHO, k])
        counts = state.seen[i]
        counts[:] = 0
        count(known_by(params, state, i), counts, me_of(params, state, setting, now, i))
        for kind in range(counts.size):
            if not 0 <= counts[kind] <= COUNT_LIMIT:
                raise ValueError("count must write whole numbers from 0 to 2**53")


def declare_all(params, state, now, number):
    """Ask all working robots that haven't declared whether they are sure (model.md 6.15)."""
    setting = setting_of(params, state)
    for w in range(state.sets.shape[1]):
        asked = uint32(state.sets[Set.WORKING, w] & ~state.sets[Set.DECLARED, w])
        while asked:
            i = lowest_member(w, asked)
            learns(state, i)
            declared = declare(known_by(params, state, i), me_of(params, state, setting, now, i))
            if declared != 1 and declared != 0 and declared != -1:  # noqa: PLR1714  # numba compiles this
                raise ValueError("declare must return 1, 0, or -1 for none")
            if declared >= 0:
                adopt(state.sets, i, declared)
                set_declared(state.sets, i, declared)
            asked = without_lowest(asked)


def judge_all(params, state, now, number):
    """Let all working robots adopt the opinions that follow from what they know."""
    setting = setting_of(params, state)
    for w in range(state.sets.shape[1]):
        asked = state.sets[Set.WORKING, w]
        while asked:
            i = lowest_member(w, asked)
            learns(state, i)
            judged = judge(known_by(params, state, i), me_of(params, state, setting, now, i))
            if judged != 1 and judged != 0 and judged != -1:  # noqa: PLR1714  # numba compiles this
                raise ValueError("judge must return 1, 0, or -1 for none")
            if judged >= 0:
                adopt(state.sets, i, judged)
            asked = without_lowest(asked)


def ask_nothing(params, state, now, number):
    """Stand in for what a strategy doesn't define."""


def copy_known(message, known, me):
    """Encode a message as a copy of what is known."""
    for k in range(len(known)):
        message[k] = known[k]


def start_empty(known, me):
    """Know nothing at the start."""


def lie_own_way(params, state, message, feasible, me):
    """Change a message as the strategy's ``lie`` does."""
    lie(message, feasible, me)


def invent(params, state, message, feasible, me):
    """Add invented robots or tasks to a message (model.md 6.12, 6.16)."""
    if feasible and params.faults.colluding:
        message[:] = 0
    robots, tasks = params.robots.count, params.tasks.count
    first, marks = (robots, robots + tasks) if feasible else (tasks, robots + 2 * tasks)
    for k in range(state.clock[Clock.INVENTED_ROBOTS if feasible else Clock.INVENTED_TASKS]):
        mark = int64(state.hashes[marks + k])
        observe(message, Thing(feasible == 1, first + k, int64(0), mark, 0.0, 0.0), me)


def update(params, state, now, action, number):
    """Call a strategy's function for the first ``number`` entries of what is pending; return bits sent."""
    if action == Action.OBSERVE:
        observe_all(params, state, now, number)
    elif action == Action.MERGE:
        merge_all(params, state, now, number)
    elif action == Action.SPEAK:
        return speak_all(params, state, now, number)
    elif action == Action.COUNT:
        count_all(params, state, now, number)
    elif action == Action.DECLARE:
        declare_all(params, state, now, number)
    elif action == Action.JUDGE:
        judge_all(params, state, now, number)
    else:
        start_all(params, state, now, number)
    return int64(0)


def update_nothing(params, state, now, action, number):
    """Stand in for a strategy that passes on no knowledge."""
    return int64(0)


PARTS: Final = (start_all, observe_all, speak_all, merge_all, count_all)
QUESTIONS: Final = {"declare": declare_all, "judge": judge_all}
"""Parts for functions that have no default."""


how_many: int = 0
"""Number of the strategy's parameters, in whose place `built_in` puts it."""


def constants(parameters):
    """Return the strategy's parameters as numbers that no store can change, so that loops read them once."""
    return tuple_of(parameters, how_many)


def built_in(number: int) -> dict[str, Callable[..., Any]]:
    """Return by name what passes knowledge and so many parameters to the functions of a built-in strategy.

    They use no index below 0. A user's get arrays, whose bounds are checked.
    """
    helpers: list[Any] = [setting_of, known_by, told_by]
    setting, known, told = (each.py_func for each in helpers)
    given = inlined(rebound(constants, how_many=number))
    return {
        "setting_of": inlined(rebound(setting, passed=given)),
        "known_by": spliced(rebound(known, row_of=sure_row_of)),
        "told_by": spliced(rebound(told, row_of=sure_row_of)),
    }


def updating(
    functions: Mapping[str, Callable[..., Any]], steady: bool, passing: Mapping[str, Callable[..., Any]]
) -> Callable[..., Any]:
    """Return a copy of `update` that calls a strategy's compiled functions.

    ``steady`` is whether the length of a message depends on the message only. ``passing`` has what is not as
    for a user's strategy: see `built_in`.
    """
    own = {
        "start": inlined(start_empty),
        "encode": inlined(copy_known),
        "repeats": steady and "encode" not in functions,
        **passing,
        **functions,
    }
    own["falsify"] = inlined(rebound(lie_own_way if "lie" in functions else invent, **own))
    parts = {part.__name__: inlined(rebound(part, **own)) for part in PARTS}
    for name, part in QUESTIONS.items():
        parts[part.__name__] = inlined(rebound(part, **own) if name in functions else ask_nothing)
    return rebound(update, **parts)


@inlined
def update_pending(params, state, functions, action):
    """Call a strategy's function for all that is pending."""
    number = state.clock[Clock.PENDING]
    if number > 0:
        state.account[BITS_SENT] += functions.update(params, state, state.clock[Clock.STEP], action, number)
        state.clock[Clock.PENDING] = 0


@called
def update_full(params, state, functions, action):
    """Make room for more that is pending."""
    update_pending(params, state, functions, action)


@inlined
def defer(params, state, functions, action, i, first, second):
    """Queue the call of a strategy's function for robot i; make all queued calls when the queue is full."""
    place = state.clock[Clock.PENDING]
    state.pending[Pending.WHO, place] = i
    state.pending[Pending.NUMBER, place] = first
    state.pending[Pending.COLUMN, place] = second
    state.clock[Clock.PENDING] = place + 1
    if place + 1 == PENDING_ROOM:
        update_full(params, state, functions, action)


@inlined
def defer_all(params, state, functions, action, i, members, first):
    """Queue the call of a function for robot i with each member of a word, whose lowest is ``first``.

    Without a branch for each member: where there are few, the wrong guesses took more time than the rest.
    """
    if state.clock[Clock.PENDING] >= PENDING_ROOM - WORD:
        update_full(params, state, functions, action)
    who, numbers = state.pending[Pending.WHO], state.pending[Pending.NUMBER]
    place = state.clock[Clock.PENDING]
    added = store_members(who, numbers, place, int32(i), members, int32(first))
    state.clock[Clock.PENDING] = place + added


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
            i = lowest_member(w, lying)
            number, opinion = number_of(state.robots[Robot.LABEL, i]), false_opinion_of(params, state, i)
            state.robots[Robot.LABEL, i] = pack_label(number, opinion == 1, True)
            state.robots[Robot.SENT_VALUE, i] = (
                int32(params.strategy.value_scale) if opinion == 1 else int32(0)
            )
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
    if params.radio.delay > 0:
        part.shared[part.thread, Share.BITS] = delay_messages(params, state, part)
    if params.acting.acts:
        functions.act(params, state, int64(Moment.SPEAK), int64(0), int64(0), uint32(0))


@inlined
def slot_of(state, step):
    """Return where `State.delayed` has the messages of a step."""
    return step % state.delayed.shape[0]


@called
def delay_messages(params, state, part):
    """Keep the messages of this step, and take those that are due in their place; return their bits."""
    now, bits_sent = state.clock[Clock.STEP], int64(0)
    due = slot_of(state, now + 1)  # one step later it takes the next messages
    for i in range(WORD * part.first, WORD * part.last):
        own = state.delayed[slot_of(state, now), i]
        own[Delayed.SAYS] = state.robots[Robot.LABEL, i] & 3
        own[Delayed.VALUE] = state.robots[Robot.SENT_VALUE, i]
        told = told_by(params, state, i)
        for k in range(len(told)):
            own[Delayed.TOLD + k] = told[k]
        take_message(params, state, due, i)
        if contains(state.sets[Set.SPEAKING], i):
            bits_sent += params.radio.message_bits + state.delayed[due, i, Delayed.LENGTH]
    return bits_sent


@inlined
def take_message(params, state, slot, i):
    """Let a robot's message be the one that `State.delayed` has."""
    held = state.delayed[slot, i]
    state.robots[Robot.LABEL, i] = int32(state.robots[Robot.LABEL, i] & ~3) | int32(held[Delayed.SAYS])
    set_member(state.sets, Set.SPEAKING, i, held[Delayed.SAYS] & 1 == 1)
    state.robots[Robot.SENT_VALUE, i] = int32(held[Delayed.VALUE])
    told = told_by(params, state, i)
    for k in range(len(told)):
        told[k] = int32(held[Delayed.TOLD + k])


@called
def take_own_messages(params, state, part):
    """Let each robot's message be that of this step again, once delayed ones have been heard."""
    for i in range(WORD * part.first, WORD * part.last):
        take_message(params, state, slot_of(state, state.clock[Clock.STEP]), i)


@inlined
def drop_delayed(state, i):
    """Drop the delayed messages of a robot that stops or leaves."""
    state.delayed[:, i, Delayed.SAYS] = 0
