"""Why a robot holds its opinion and what it does next, in words.

What comes next is what its own controller does with what the robot knows at this step: see
`feasibee.robot.controller`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from feasibee.errors import FeasibeeError
from feasibee.live.timeline import History
from feasibee.reference.robot import settings_of
from feasibee.robot.controller import Controller, Message
from feasibee.scenario.acting import ranks_of
from feasibee.scenario.geometry import segments
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.types import LENGTH, TIME
from feasibee.scenario.units import in_brackets
from feasibee.simulation.snapshot import FLAGS, RobotState
from feasibee.simulation.swarm import Swarm
from feasibee.strategies.certified import NEVER
from feasibee.theory.geometry import ending

OPINIONS: Final = {1: "feasible", 0: "infeasible", -1: "no opinion"}
GONE: Final = 2**30
"""Version of a task that has vanished or is done (model.md 6.25.5, 6.26.2)."""
FREE: Final = -1
"""Holder of a task that is free."""
LISTED: Final = 12
"""Most senders of one opinion that are listed."""
RHO: Final = "\N{GREEK SMALL LETTER RHO}\N{SUBSCRIPT ONE}"
"""The quality of *feasible*, which docstrings write in ASCII."""
TAKEN: Final = 10_000
"""Most messages that are given to the controller again."""


class Prospect(NamedTuple):
    """What a controller has when the phase of its robot ends; declared is -1 for no opinion."""

    opinion: int
    quality: float
    """Quality of *feasible*."""
    declared: int
    mean: float
    """Mean duration of the phase that follows, in steps."""


def reasons_of(swarm: Swarm, number: int) -> list[list[str]]:
    """Return what a robot knows at this step as pairs of a title and a text."""
    if not swarm.present[number]:
        return [["Phase", "no robot has this number at this step"]]
    return [list(each) for each in _lines(swarm, swarm.robot(number), number)]


def sentence_of(swarm: Swarm, number: int, history: History) -> str:
    """Return in a sentence or two since when a robot holds its opinion, and what it knows."""
    if not swarm.present[number]:
        return ""
    history.follow()
    steps = (int(each[number]) for each in (history.held, history.decided))
    ends = (each and _at(swarm.scenario, each) + " or before" * (each <= history.first) for each in steps)
    state, (held, decided) = swarm.robot(number), ends
    since = f"Holds {OPINIONS[opinion_of(state)]} since {held or 'the start'}."
    if swarm.scenario.manifest.knowledge:
        return (
            f"{since} Knows: {_known(swarm.scenario, controller_of(swarm, state, number, 0.5), swarm.step)}."
        )
    votes = zip(state.votes, (1, 0), strict=True)
    heard = ", ".join(f"{count:,} {OPINIONS[opinion]}" for count, opinion in votes if count)
    return (
        f"{since} Heard {heard or 'nobody'} since {f'its decision at {decided}' if decided else 'the start'}."
    )


def _has(state: RobotState, name: str) -> bool:
    return bool(state.flags >> FLAGS.index(name) & 1)


def opinion_of(state: RobotState) -> int:
    """Return a robot's opinion: 1 feasible, 0 infeasible, -1 none."""
    return -1 if _has(state, "neutral") else int(_has(state, "feasible"))


def _lines(swarm: Swarm, state: RobotState, number: int) -> Iterator[tuple[str, str]]:
    scenario = swarm.scenario
    if not _has(state, "working"):
        yield "Phase", "stopped"
        return
    yield "Phase", _phase(scenario, state)
    if scenario.acts and not _has(state, "byzantine"):
        yield "Acts", _deed(swarm, state, number)
    if not scenario.manifest.knowledge:
        yield "Saw", _seen(scenario, state)
    if not scenario.manifest.knowledge or scenario.decision.declare is not None:
        yield "Heard", _heard(scenario, state)
    try:
        yield from _rated(swarm, state, number)
    except FeasibeeError as error:  # of a user's strategy
        yield "Error", str(error)


def _phase(scenario: Scenario, state: RobotState) -> str:
    """Return the phase, how long it lasts, and what is broadcast."""
    left = _numbered(state.phase_left, "step") + in_brackets(scenario, TIME, state.phase_left)
    if not _has(state, "disseminating"):
        return f"exploring, {left} left"
    said = "nothing" if state.broadcasts < 0 else OPINIONS[state.broadcasts]
    said = "what it knows" if scenario.manifest.knowledge else said
    return f"disseminating, {left} left; broadcasts {said}"


def _deed(swarm: Swarm, state: RobotState, number: int) -> str:
    """Return what a robot does that may act, why, and what it knows of tasks (model.md 6.25)."""
    aims, standing, holders = swarm.acting
    versions, statuses = swarm.news[number], max(ranks_of(swarm.scenario.robots)) + 1
    known = {
        each: versions[each] % statuses
        for each in np.flatnonzero((versions >= 0) & (versions < GONE)).tolist()
    }
    free = sum(status == 0 for status in known.values())
    knows = f"knows {_numbered(len(known), 'task')}, {free} of them as free"
    if swarm.targets[number] >= 0 > aims[number]:
        return f"walks to task {swarm.targets[number]}, but it has vanished; {knows}"
    if aims[number] < 0:
        return f"{_idle(swarm, state, number, len(known))}; {knows}"
    task, holder = int(swarm.task_numbers[aims[number]]), holders[aims[number]]
    if standing[number]:
        return f"stands at task {task}; {knows}"
    scenario, ends = swarm.scenario, (swarm.positions[[number]], swarm.tasks[aims[[number]]])
    line = segments(*ends, scenario.arena.size, scenario.arena.boundary == "walls")[0][0]
    away = float(np.hypot(*(line[1] - line[0])))
    how = "sees" if away <= scenario.sensing.range else "saw or heard"
    why = f"it {how} that it is free"
    if holder == number:
        why = "it has marked it"
    elif holder != FREE:
        why += ", but it is done" if holder < 0 else f", but robot {holder} has it"
    return f"walks to task {task}, {away:.1f} units{in_brackets(scenario, LENGTH, away)} away: {why}; {knows}"


def _idle(swarm: Swarm, state: RobotState, number: int, known: int) -> str:
    """Return why a robot goes to no task that may act."""
    scenario, (_, _, holders) = swarm.scenario, swarm.acting
    declared, start = _has(state, "declared"), scenario.acts_from
    if declared and opinion_of(state) == 0:
        return "doesn't act: it has declared infeasible"
    if scenario.tasks.work is None and scenario.robots.know_count and known > scenario.robots.count:
        return "doesn't act: it knows more tasks than there are robots"
    if swarm.step >= start or (scenario.acting.start == "declared" and declared):
        return "knows no free task that it can do"
    begins = "once it declares feasible" if start == NEVER else f"from {_at(scenario, start)} on"
    marked = [f"has marked task {each}, and " for each in swarm.task_numbers[holders == number].tolist()]
    return f"{''.join(marked)}acts {begins}"


def _at(scenario: Scenario, step: int) -> str:
    return f"step {step:,}{in_brackets(scenario, TIME, step)}"


def _numbered(count: int, word: str) -> str:
    return f"{count:,} {word}{'' if count == 1 else 's'}"


def _seen(scenario: Scenario, state: RobotState) -> str:
    """Return the counts of an exploration, by class if there are classes."""
    since = "in its last exploration" if _has(state, "disseminating") else "so far in this exploration"
    since = since if scenario.manifest.forgets else "in its life"
    robots, tasks = (
        _counted(counts, [each.name for each in classes], word)
        for counts, classes, word in (
            (state.robots_seen, scenario.robots.classes, "robot"),
            (state.tasks_seen, scenario.tasks.classes, "task"),
        )
    )
    often = ", each counted in every step" if scenario.sensing.observation == "repeated" else ""
    return f"{robots} and {tasks} {since}{often}"


def _counted(counts: Sequence[int], names: Sequence[str], word: str) -> str:
    number = _numbered(sum(counts), word)
    if not names:
        return number
    return f"{number} ({', '.join(f'{name} {each:,}' for name, each in zip(names, counts, strict=False))})"


def _heard(scenario: Scenario, state: RobotState) -> str:
    """Return the inbox: how many say what, and who they are."""
    if not sum(state.votes):
        return "nobody since its last decision"
    called = "id" if scenario.radio.id_bits else "robot"
    parts = []
    for opinion, votes in zip((1, 0), state.votes, strict=True):
        senders = [str(sender) for sender, said, _ in state.heard if said == opinion]
        more = f" and {len(senders) - LISTED} more" if len(senders) > LISTED else ""
        many = "s" if len(senders) > 1 else ""
        named = f" ({called}{many} {', '.join(senders[:LISTED])}{more})" if senders else ""
        parts.append(f"{votes:,} {OPINIONS[opinion]}{named}")
    return ", ".join(parts)


def _rated(swarm: Swarm, state: RobotState, number: int) -> Iterator[tuple[str, str]]:
    """Yield the quality, the knowledge, the memory, and what comes next by which rule."""
    scenario, strategy = swarm.scenario, swarm.scenario.strategy
    now = controller_of(swarm, state, number, 0.5)
    opinion = opinion_of(state)
    quality = {1: state.feasible_quality, 0: 1.0 - state.feasible_quality}.get(opinion, 0.5)
    of_its = f", so {quality:.2f} for its opinion" if opinion == 0 else ""
    yield "Quality", f"{state.feasible_quality:.2f} for feasible{of_its}, as it last rated it"
    if now.knowledge is not None:
        yield "Knows", _known(scenario, now, swarm.step)
    if state.memory:
        yield "Memory", ", ".join(f"{each:.4g}" for each in state.memory)
    yield "Next", _next(scenario, state, _prospects(swarm, state, number), swarm.step)
    rule = strategy.quality if not _has(state, "disseminating") else strategy.decide
    text = " ".join((rule.__doc__ or "").replace("*", "").replace("rho_1", RHO).split())
    if text:
        name = strategy.name.replace("\\", "/").rpartition("/")[2]
        yield f"Rule of {name}", text.removeprefix("Return ")
    fixed = [name for name in ("byzantine", "stubborn", "declared") if _has(state, name)]
    if fixed:
        shown = {"byzantine": "Byzantine: it broadcasts what is false", "declared": "has declared"}
        kept = "" if fixed == ["byzantine"] else "; it keeps its opinion"
        yield "Special", ", ".join(shown.get(each, each) for each in fixed) + kept


def _known(scenario: Scenario, now: Controller, step: int) -> str:
    """Return what a robot knows that passes on knowledge."""
    assert now.knowledge is not None
    describe = now.strategy.describe
    if describe is not None:
        return str(describe(tuple(now.knowledge.words), now.knowledge.me))
    robots, tasks = (sum(each) for each in now.knowledge.counted())
    return f"robots to tasks as {robots:,} to {tasks:,}"


def controller_of(
    swarm: Swarm,
    state: RobotState,
    number: int,
    chance: float,
    draw_duration: Callable[[float], int] = lambda mean: 1,
) -> Controller:
    """Return the controller of a robot with what the robot knows at this step."""
    scenario = swarm.scenario
    controller = Controller(
        scenario.strategy,
        opinion=opinion_of(state),
        draw_duration=draw_duration,
        draw_choice=lambda: (chance, chance),
        settings=replace(
            settings_of(scenario),
            first_sight=state.first_sight,
            me=(state.id, state.kind, state.hash),
            place=state.place,
        ),
        stubborn=_has(state, "stubborn"),
    )
    controller.opinion = opinion_of(state)
    controller.disseminating = _has(state, "disseminating")
    controller.feasible_quality = state.feasible_quality
    controller.robots_seen, controller.tasks_seen = list(state.robots_seen), list(state.tasks_seen)
    controller._memory[:] = state.memory
    controller.declared = opinion_of(state) if _has(state, "declared") else -1
    if controller.knowledge is None:
        _hear_again(controller, state)
        return controller
    if swarm.step:  # at step 0, the engine has not called the strategy's start yet
        controller.knowledge.words[:] = state.knowledge
    controller.knowledge.me = controller.knowledge.me._replace(
        step=swarm.step, explores=not controller.disseminating
    )
    return controller


def _hear_again(controller: Controller, state: RobotState) -> None:
    """Give a controller the messages of an inbox, or as many for each opinion if it keeps every message."""
    for sender, said, value in state.heard:
        controller.hear(sender, Message(said, value))
    if not state.heard:
        for said, votes in zip((1, 0), state.votes, strict=True):
            for each in range(min(votes, TAKEN)):
                controller.hear(each, Message(said))


def _prospects(swarm: Swarm, state: RobotState, number: int) -> list[Prospect]:
    """Return what may come next, for different chances of a decision."""
    found = []
    for chance in (0.0, 0.25, 0.5, 0.75, 0.999):
        means: list[float] = []

        def note(mean: float, means: list[float] = means) -> int:
            means.append(mean)
            return 1

        controller = controller_of(swarm, state, number, chance, note)
        controller.phase_left = 1
        controller.end_step()
        floor = 0 if _has(state, "disseminating") else controller.settings.dissemination_floor
        mean = floor + 1 / ending(means[-1])  # of whole steps: model.md 3.4
        declared = controller.declared
        prospect = Prospect(controller.opinion, controller.feasible_quality, declared, mean)
        if prospect not in found:
            found.append(prospect)
        if not _has(state, "disseminating"):
            break
    return found


def _next(scenario: Scenario, state: RobotState, prospects: list[Prospect], step: int) -> str:
    when = f"at {_at(scenario, step + state.phase_left)}"
    first = prospects[0]
    if scenario.manifest.declares and first.declared >= 0 and not _has(state, "declared"):
        return f"it is sure, and declares {OPINIONS[first.declared]}"
    if not _has(state, "disseminating"):
        quality = {1: first.quality, 0: 1.0 - first.quality}.get(first.opinion, 0.5)
        rated = f"with what it has seen by now, {OPINIONS[first.opinion]} has quality {quality:.2f}, and "
        rated = rated if first.opinion >= 0 else "it has no opinion; "
        lasting = f"{first.mean:.1f} steps{in_brackets(scenario, TIME, first.mean)}"
        return f"{when} it begins to disseminate; {rated}it broadcasts for {lasting} on average"
    if scenario.manifest.judges:
        return f"{when} it explores again; its opinion follows what it knows in any step"
    opinions = list(dict.fromkeys(OPINIONS[each.opinion] for each in prospects))
    source = "what it knows now" if scenario.manifest.knowledge else "the inbox of now"
    result = opinions[0] if len(opinions) == 1 else f"{' or '.join(opinions)}, by chance"
    return f"{when} it decides; with {source}: {result}"
