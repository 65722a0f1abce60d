"""The effective chain for model checkers, and the drift of opinions as a differential equation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from feasibee.errors import Problem, ScenarioError
from feasibee.results.measures import least_quorum
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.supported import EXACT, unsupported
from feasibee.theory.classes import Array
from feasibee.theory.geometry import ending
from feasibee.theory.predict import Prediction, predict
from feasibee.theory.reach import ERRORS
from feasibee.theory.rule import adopting, voting_of

FASTEST = 0.9
"""Largest probability to leave a state in one tick."""
DEGREE = 3
"""Degree of the polynomial that the drift is fitted with, besides its zeros at both consensus states."""


def _predicted(scenario: Scenario) -> Prediction:
    """Return the prediction of a scenario without faulty robots, with which there are several chains."""
    if any(scenario.faulty):
        raise ScenarioError(
            [Problem("faults", "set", "a model has robots without faults", "leave out faults")]
        )
    return predict(scenario)


def to_prism(scenario: Scenario) -> str:
    """Return the effective chain as a model for PRISM or Storm.

    State 0 is the decision infeasible, the last but one the decision feasible. The last is the start, whose
    first tick draws the coins. Labels: ``feasible``, ``infeasible``, ``decided``.
    Reward: ``steps``.

    Parameters
    ----------
    scenario : Scenario
        A scenario within the theory's reach.
    """
    chain = _predicted(scenario).chain
    among, exits = chain.moves()
    last = len(among) + 1
    ticks = max(1, math.ceil((among.sum(1) + exits.sum(1)).max() / FASTEST))
    rates = np.concatenate([exits[:, 1:], among, exits[:, :1]], axis=1) / ticks
    rates[np.arange(last - 1), np.arange(1, last)] = 1 - rates.sum(1)
    first = np.array([chain.decided[1], *chain.start, chain.decided[0]])

    def row(state: int, chances: np.ndarray) -> str:
        moves = enumerate(chances.tolist())
        to = " + ".join(f"{chance!r}:(x'={k})" for k, chance in moves if chance > 0)
        return f"  [] x={state} -> {to};"

    return "\n".join(
        [
            f"// {scenario.robots.count} robots, {scenario.tasks.count} tasks, {scenario.decision.strategy}",
            f"dtmc\nconst int ticks_per_step = {ticks};",
            f"module swarm\n  x : [0..{last + 1}] init {last + 1};",
            row(last + 1, first / first.sum()),
            *(row(state, chances) for state, chances in enumerate(rates, 1)),
            f"  [] x=0|x={last} -> true;\nendmodule",
            f'label "feasible" = x={last};\nlabel "infeasible" = x=0;\nlabel "decided" = x=0|x={last};',
            f'rewards "steps"\n  x>0&x<{last} : 1/{ticks};\nendrewards\n',
        ]
    )


FEW: Final = 2, 3
"""Numbers of robots of an exact model."""
_RULE: Final = "the exact model doesn't cover it"


def to_exact_prism(scenario: Scenario) -> str:
    """Return the exact model of two or three robots that hear and see all, for PRISM or Storm.

    Each robot is a module, and a step moves them all at once (model.md 3 and 4). Its opinion is ``o`` = 0 or
    1. Its phase ``p`` is 0 (exploring), 1 (disseminating), or 2 before the coins of the first tick. ``a1_2``
    is the latest opinion that robot 1 has from robot 2, or -1. Labels and reward are those of `to_prism`.

    Parameters
    ----------
    scenario : Scenario
        Its ranges reach across the arena, which has walls.

    Raises
    ------
    ScenarioError
        If it has other fields, with each of them, and what to use.
    """
    if problems := [*unsupported(scenario, EXACT, _RULE), *_not_exact(scenario)]:
        raise ScenarioError(problems)
    decision, robots, table = scenario.decision, scenario.robots.count, _decisions(scenario)
    seen = robots - 1 + scenario.sensing.count_self
    feasible = seen / (seen + scenario.tasks.count)
    ends = [ending(scenario.strategy.dissemination(rho, decision.gain)) for rho in (1 - feasible, feasible)]
    everyone, needed = range(1, robots + 1), least_quorum(scenario, robots)
    agreed = "+".join(f"o{robot}" for robot in everyone)
    lines = [
        f"// exact: {robots} robots, {scenario.tasks.count} tasks, {decision.strategy}",
        f"dtmc\nformula feasible = p1<2 & {agreed}>={needed};",
        f"formula infeasible = p1<2 & {agreed}<={robots - needed};\nformula done = feasible | infeasible;",
    ]
    for robot in everyone:
        others = [other for other in everyone if other != robot]
        lines += _module(robot, others, table, ending(decision.exploration), ends)
    return "\n".join(
        [
            *lines,
            'label "feasible" = feasible;\nlabel "infeasible" = infeasible;\nlabel "decided" = done;',
            'rewards "steps"\n  !done & p1<2 : 1;\nendrewards\n',
        ]
    )


def _not_exact(scenario: Scenario) -> Iterator[Problem]:
    """Yield a problem for each supported field that keeps the model from being exact."""
    decision, across = scenario.decision, math.ceil(100 * math.hypot(*scenario.arena.size)) / 100
    few, rule = f"{FEW[0]} or {FEW[1]}", "robots must hear and see all of the arena"
    for path, covered, why, use in (
        ("decision.strategy", decision.strategy in ERRORS, _RULE, f"one of {', '.join(ERRORS)}"),
        ("decision.inbox", decision.inbox == "latest-per-robot", _RULE, '"latest-per-robot"'),
        ("decision.listen", decision.listen == "always", _RULE, '"always"'),
        ("robots.count", scenario.robots.count in FEW, "states multiply", few),
        ("arena.boundary", scenario.arena.boundary == "walls", rule, '"walls"'),
        ("sensing.range", scenario.sensing.range >= across, rule, f"{across:g} or more"),
        ("radio.range", scenario.radio.range >= across, rule, f"{across:g} or more"),
    ):
        if not covered:
            yield Problem(path, scenario.get(path), why, f"use {use}")


def _decisions(scenario: Scenario) -> Array:
    """Return the probability of each opinion after a decision, by opinion and votes; all robots have one."""
    decision, strategy = scenario.decision, scenario.strategy
    parameters = tuple(float(decision.parameters[name]) for name in strategy.parameters)
    table = adopting(strategy, parameters, voting_of(decision), scenario.robots.count - 1)
    if len(table) > 2:
        rule = "the exact model needs robots that always have an opinion"
        raise ScenarioError([Problem("decision.strategy", decision.strategy, rule, "use another strategy")])
    return table


def _module(
    robot: int, others: Sequence[int], table: Array, explored: float, ends: Sequence[float]
) -> Iterator[str]:
    """Yield the module of a robot, and what it has heard after this step."""
    own = f"o{robot}'"
    for other in others:
        yield f"formula h{robot}_{other} = (p{other}=1 ? o{other} : a{robot}_{other});"
    for opinion in (0, 1):
        heard = "+".join(f"(h{robot}_{other}={opinion} ? 1 : 0)" for other in others)
        yield f"formula votes{robot}_{opinion} = {heard};"
    keeps = "&".join(f"(a{robot}_{other}'=h{robot}_{other})" for other in others)
    empties = "&".join(f"(a{robot}_{other}'=-1)" for other in others)
    yield f"module robot{robot}\n  o{robot} : [0..1] init 0;\n  p{robot} : [0..2] init 2;"
    yield from (f"  a{robot}_{other} : [-1..1] init -1;" for other in others)
    yield f"  [t] p{robot}=2 -> 0.5:({own}=0)&(p{robot}'=0) + 0.5:({own}=1)&(p{robot}'=0);"
    yield f"  [t] !done & p{robot}=0 -> {explored!r}:(p{robot}'=1)&{keeps} + {1 - explored!r}:{keeps};"
    for opinion, yes, no in np.ndindex(2, len(others) + 1, len(others) + 1):
        if yes + no <= len(others):
            guard = f"!done & p{robot}=1 & o{robot}={opinion} & votes{robot}_1={yes} & votes{robot}_0={no}"
            chances = np.round(table[1 - opinion, yes, no], 12) * ends[opinion]
            moves = [
                f"{float(chance)!r}:({own}={after})&(p{robot}'=0)&{empties}"
                for after, chance in zip((1, 0), chances, strict=True)
                if chance > 0
            ]
            yield f"  [t] {guard} -> {' + '.join(moves)} + {1 - ends[opinion]!r}:{keeps};"
    yield "  [] done -> true;\nendmodule" if robot == 1 else "endmodule"


def to_ode(scenario: Scenario) -> str:
    """Return the drift of the share of feasible opinions as a differential equation.

    Parameters
    ----------
    scenario : Scenario
        A scenario within the theory's reach.
    """
    along = _predicted(scenario).along
    share = along.holders[:, 0] / scenario.robots.count
    drift = along.drift * np.gradient(share, along.places)
    ends = share * (1 - share)
    basis = ends[:, None] * share[:, None] ** np.arange(DEGREE + 1)
    factors = np.linalg.lstsq(basis, drift, rcond=None)[0]
    error = np.abs(basis @ factors - drift).max() / np.abs(drift).max()
    terms = " + ".join(f"({factor:.6g})*x^{power}" for power, factor in enumerate(factors))
    return (
        f"# feasibee scenario --to ode: {scenario.robots.count} robots, {scenario.tasks.count} tasks\n"
        f"# x: share of feasible opinions; t: steps; fit within {error:.1%} of the largest drift\n"
        f"dx/dt = x*(1-x)*({terms})\n"
    )
