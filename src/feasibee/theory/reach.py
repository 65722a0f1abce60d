"""Reach of the theory: the scenarios that it covers, and the error that was measured in them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Final, NamedTuple

from feasibee.base.errors import Problem, ScenarioError
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.supported import THEORY, unsupported
from feasibee.theory.classes import Moves
from feasibee.theory.rule import SAYS
from feasibee.theory.saddle import Tipping, tipping

RULE: Final = "the theory doesn't cover it"
OTHERWISE: Final = ", or use feasibee run"
_TESTED: Final = (
    ("dmmd", 0.03),
    ("majority", 0.03),
    ("k-unanimity", 0.04),
    ("voter", 0.04),
    ("cross-inhibition", 0.06),
    ("dmvd", 0.03),
)
ERRORS: Final = dict(_TESTED)
"""By strategy: largest error of a share of swarms that was measured within reach, against the engine."""
UNRELIABLE: Final = 0.045
"""Largest error with lost messages, missed sightings, unequal ranges, or faulty robots."""
DRIFTING: Final = "dmvd", "voter"
"""Strategies whose opinions don't tip; their times are less exact."""
WITH_FAULTS: Final = "dmmd", "majority", "k-unanimity", "cross-inhibition"
"""Strategies whose error was measured with faulty robots, too. It is up to 0.15 with the other ones."""
FAULTY: Final = 0.15
"""Largest share of faulty robots in the test."""
SMALL_ERROR: Final = 0.04
"""Largest error that needs no warning."""
TIME_ERROR: Final = 0.12
"""Largest error of the median step that needs no warning, as a share of it."""
BEGINS: Final = 0.2, 0.8
"""Least and largest share of robots that begin with *feasible*."""
MOVED: Final = 0.1
"""Largest distance between the tipping points with first sight and with a coin, which should be equal."""
NARROW: Final = 4.0
"""Largest ratio of the arena's sides; beyond it, robots stay among the same ones."""
LONG: Final = 3.0
"""Largest gain, in units of the exploration, up to which that error holds."""
SLOW_ROBOTS: Final = 0.3
"""Least speed, in ranges of the radio per step, down to which those errors hold."""
SHORT: Final = 10.0
"""Least exploration, in steps, down to which those errors hold."""
SENDING: Final = 2.0
"""Least number of robots that broadcast at a time."""
HEARD: Final = 0.7, 5.0
"""Least and largest number of robots heard per round."""
TESTED_ROBOTS: Final = 10, 40
"""Numbers of robots in the test; larger swarms are predicted with a warning."""
SLOW: Final = 0.25
"""Largest time in which a deviation grows e-fold, as a share of the steps of a run."""


def check_fields(scenario: Scenario) -> None:
    """Raise a `ScenarioError` if a field has a value that the theory doesn't take into account."""
    problems = [*unsupported(scenario, THEORY, RULE, OTHERWISE), *_wrong_fields(scenario)]
    if problems:
        raise ScenarioError(problems)


def _wrong_fields(scenario: Scenario) -> Iterator[Problem]:
    """Yield a problem for each supported field whose value is beyond reach."""
    decision, (_, lying, stubborn) = scenario.decision, scenario.faulty
    if decision.strategy not in ERRORS:
        yield _wrong(scenario, "decision.strategy", RULE, f"use one of {', '.join(ERRORS)}")
    if decision.inbox != "latest-per-robot":
        yield _wrong(scenario, "decision.inbox", RULE, 'use "latest-per-robot"')
    if decision.listen not in ("always", "dissemination"):
        yield _wrong(scenario, "decision.listen", RULE, 'use "always" or "dissemination"')
    if lying and scenario.faults.byzantine_says not in SAYS:
        says = ", ".join(f'"{each}"' for each in SAYS)
        yield _wrong(scenario, "faults.byzantine_says", RULE, f"use one of {says}")
    if lying + stubborn and decision.strategy not in WITH_FAULTS:
        remedy = f"use one of {', '.join(WITH_FAULTS)} with faulty robots"
        yield _wrong(scenario, "decision.strategy", "with faulty robots its error is larger", remedy)
    if lying + stubborn > (most := int(FAULTY * scenario.robots.count)):
        path = "faults.byzantine" if lying else "faults.stubborn"
        rule = f"the theory was tested with up to {FAULTY:.0%} of faulty robots"
        yield Problem(path, lying + stubborn, rule, f"use {{count = {most}}} or less{OTHERWISE}")
    for path, least, rule in (
        ("robots.count", TESTED_ROBOTS[0], "the theory takes a swarm's noise as nearly normal"),
        ("decision.exploration", 6.0, "the theory needs new neighbours in each round"),
        ("robots.speed", 0.2 * scenario.radio.range, "the theory needs new neighbours in each round"),
    ):
        if scenario.get(path) < least:
            yield _wrong(scenario, path, rule, f"use {least:g} or more")
    yield from _wrong_walks(scenario)


def _wrong(scenario: Scenario, path: str, rule: str, remedy: str) -> Problem:
    """Return the problem of a field, with its value."""
    return Problem(path, scenario.get(path), rule, f"{remedy}{OTHERWISE}")


def _wrong_walks(scenario: Scenario) -> Iterator[Problem]:
    """Yield a problem if robots leave their neighbours more slowly than in the test."""
    low, high = sorted(scenario.arena.size)
    if high > NARROW * low:
        rule = f"the theory was tested with sides of up to {NARROW:g} to 1"
        remedy = f"use a square of {math.sqrt(low * high):.3g}{OTHERWISE}"
        yield Problem("arena.side", list(scenario.arena.size), rule, remedy)
    if scenario.robots.speed * scenario.walk.mean_run < scenario.radio.range:
        rule = "the theory needs runs as long as the range of the radio"
        least = math.ceil(100 * scenario.radio.range / scenario.robots.speed) / 100
        yield _wrong(scenario, "walk.mean_run", rule, f"use {least:g} or more")


def check_swarm(scenario: Scenario, swarm: Moves) -> None:
    """Raise a `ScenarioError` if robots broadcast too seldom, or hear too few robots or too many."""
    sending, heard = swarm.activity()
    problems = []
    if sending < SENDING:
        rule = f"{sending:.2g} robots broadcast at a time, and the theory needs {SENDING:g}"
        problems.append(_wrong(scenario, "decision.gain", rule, "use a larger gain"))
    if not HEARD[0] <= heard <= HEARD[1]:
        rule = (
            f"a robot hears {heard:.2g} others per round, and the theory needs {HEARD[0]:g} to {HEARD[1]:g}"
        )
        factor = (HEARD[heard > HEARD[1]] / heard) ** 0.5  # between those of short and of long contacts
        problems.append(_wrong(scenario, "radio.range", rule, f"try {scenario.radio.range * factor:.2g}"))
    if scenario.decision.start != "coin" and (why := _beyond_first_sight(swarm)):
        problems.append(_wrong(scenario, "decision.start", why, 'use "coin"'))
    if problems:
        raise ScenarioError(problems)


def _beyond_first_sight(swarm: Moves) -> str | None:
    """Return why a swarm begins too far from balance, if it does: the theory is linear in this."""
    low, high = BEGINS
    if not low <= swarm.begins <= high:
        return (
            f"{swarm.begins:.1%} of the robots begin with feasible; the theory needs {low:.0%} to {high:.0%}"
        )
    here, coin = tipping(swarm), tipping(replace(swarm, begins=0.5))
    if here is None or coin is None or (moved := abs(here.point - coin.point)) <= MOVED:
        return None
    return f"the tipping point moves by {moved:.2f}, and the theory needs {MOVED:g} or less"


class Doubt(NamedTuple):
    """Why the error of a prediction may be larger than elsewhere."""

    path: str
    """The field."""
    why: str
    """What the theory omits, and where that matters."""
    error: float
    """Largest error of a share of swarms that was measured there."""
    time: float = TIME_ERROR
    """Largest error of the median step that was measured there, as a share of it."""


def doubts(scenario: Scenario) -> Iterator[Doubt]:
    """Yield where a scenario is near the edge of the theory's reach."""
    decision = scenario.decision
    if (error := ERRORS[decision.strategy]) > SMALL_ERROR:
        why = "robots without an opinion are taken as in balance; it matters if m is near n"
        yield Doubt("decision.strategy", why, error)
    if decision.strategy in DRIFTING:
        yield Doubt(
            "decision.strategy", "opinions don't tip, and half decide sooner than predicted", error, 0.2
        )
    if (robots := scenario.robots.count) > TESTED_ROBOTS[1]:
        why = f"above {TESTED_ROBOTS[1]} robots, swarms lean to feasible if m is near n"
        yield Doubt("robots.count", why, 0.07 if robots <= 200 else 0.2)
    if decision.gain > LONG * decision.exploration:
        yield Doubt("decision.gain", f"above {LONG:g} times the exploration, robots meet senders again", 0.05)
    if scenario.robots.speed < SLOW_ROBOTS * scenario.radio.range:
        why = f"below {SLOW_ROBOTS:g} times the range of the radio, robots stay among the same ones"
        yield Doubt("robots.speed", why, 0.04)
    if decision.exploration < SHORT:
        yield Doubt("decision.exploration", f"below {SHORT:g}, robots stay among the same ones", 0.045)
    if scenario.faulty[1] and scenario.faults.byzantine_says in ("feasible", "infeasible"):
        yield Doubt("faults.byzantine_says", "they broadcast as long as their opinion's quality says", 0.07)
    if scenario.faulty[1] and scenario.faults.byzantine_says == "opposite":
        yield Doubt("faults.byzantine_says", "half decide sooner than predicted", UNRELIABLE, 0.26)
    if decision.start != "coin":
        why = "robots that meet begin alike, and hold a coin until their first exploration ends"
        error, time = (0.075, 0.85) if decision.strategy in DRIFTING else (0.06, 0.35)
        yield Doubt("decision.start", why, error if decision.own_vote else 0.08, time)


def warnings_for(scenario: Scenario, tips: Tipping | None) -> Iterator[str]:
    """Yield why the error may be larger, or a number missing, each with what was measured."""
    for path, why, error, time in doubts(scenario):
        late = f", of the median step up to {time:.0%}" if time > TIME_ERROR else ""
        yield f"{path} = {scenario.get(path)}: {why}; measured errors of shares up to {error:g}{late}"
    if tips is None:
        yield "opinions do not tip here: no balance of opinions from which both consensus states grow"
    elif tips.e_fold > SLOW * scenario.run.steps:
        yield f"opinions tip slowly: they grow e-fold in {tips.e_fold:,.0f} steps; many runs don't decide"


def tested_error(scenario: Scenario) -> float:
    """Return the largest error of a share of swarms that was measured in such scenarios."""
    radio, sensing = scenario.radio, scenario.sensing
    unreliable = any((radio.loss, sensing.miss, radio.range != sensing.range, *scenario.faulty))
    errors = [ERRORS[scenario.decision.strategy], UNRELIABLE if unreliable else 0.0]
    return max([*errors, *(each.error for each in doubts(scenario))])


def time_error(scenario: Scenario) -> float:
    """Return the largest error of the median step that was measured in such scenarios, as a share of it."""
    return max([TIME_ERROR, *(each.time for each in doubts(scenario))])
