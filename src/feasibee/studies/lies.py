"""Search for the worst lie of Byzantine robots: the messages with which the swarm is right least often."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from itertools import product
from typing import Any, Final, NamedTuple

from feasibee.errors import FeasibeeError
from feasibee.results.statistics import Interval, wilson
from feasibee.robot.controller import Message
from feasibee.robot.knowledge import Knowledge
from feasibee.robot.wire import Wire, WireError
from feasibee.scenario.plugins import ALLOWED, bindings
from feasibee.scenario.scenario import Scenario
from feasibee.strategies import module_of
from feasibee.strategies.contract import ARGUMENTS, Me, Setting, Strategy, Thing
from feasibee.studies.recommend import opposite_of, strategy_for
from feasibee.studies.space import Dimension
from feasibee.studies.tuning import FRESH_RUNS, FRESH_SEED, Objective, Tuned, scored, tune
from feasibee.sweeps.plan import DesignPoint
from feasibee.sweeps.sweep import Execution, Rounds

OWN: Final = 16
"""Form of the strategy's own lie: by it, and no word replaced."""
SIDES: Final = ("infeasible", "feasible")
"""What the robots speak for: the opposite of the truth, which they know."""
DEFAULTS: Final = {"form": float(OWN), "share": 1.0, "holds": 1.0, "duty": 1.0}
"""Parameters of a lie on each side. ``share`` is that of words replaced, and ``duty`` that of false steps.
A random word stays for ``holds`` steps."""
SAYS: Final = "faults.byzantine_says"
PACKAGE: Final = "feasibee.strategies."
WIRED: Final = ("layout", "pack", "unpack")
LIE: Final = """
from feasibee.strategies.contract import Thing

def lie_draw(seed):
    bits = ((seed ^ seed >> 16) * 0x2C1B3C6D + 0x1B873593) & 0xFFFFFFFF
    bits = ((bits ^ bits >> 12) * 0x297A2D39) & 0xFFFFFFFF
    return bits ^ bits >> 15

def lie(message, feasible, me):
    p, first = me.setting.parameters, LIE_FIRST + 4 * feasible
    form, share, duty = int(p[first]), p[first + 1], p[first + 3]
    who = lie_draw(me.id)
    if lie_draw(who ^ me.step & 0xFFFFFFFF) >= duty * 4294967296.0:
        return
    if form >= 16:
        lie_own(message, feasible, me)
    seed = lie_draw(who ^ me.step // max(int(p[first + 2]), 1) & 0xFFFFFFFF)
    for k in range(len(message)):
        act = form // 4 % 4 if k == 0 else form % 4
        if act > 0 and lie_draw(seed ^ 2 * k) < share * 4294967296.0:
            most = lie_most(k)
            message[k] = 0 if act == 1 else most if act == 2 else lie_draw(seed ^ 2 * k + 1) % (most + 1)
"""
INVENT: Final = """
def lie_own(message, feasible, me):
    robots, tasks = me.setting.robots, me.setting.tasks
    if feasible == 1:
        for k in range(len(message)):
            message[k] = 0
    first, number = (robots, max(tasks - robots, 0)) if feasible == 1 else (tasks, max(robots + 1 - tasks, 0))
    for k in range(number):
        observe(message, Thing(feasible == 1, first + k, 0, lie_draw(2 * k + feasible), 0.0, 0.0), me)
"""


class Found(NamedTuple):
    """The worst lie found for a scenario's strategy."""

    values: dict[str, float | str]
    """The lie: parameters of `lying`, or ``faults.byzantine_says``."""
    none: Interval
    """Share right without Byzantine robots, over a feasible and an infeasible side of as many runs."""
    own: Interval
    """Share right with the strategy's own lie, by colluding robots."""
    worst: Interval
    """Share right with the worst lie found, on runs that the search didn't use."""


def _join(tree: ast.Module, prefix: str, done: dict[str, dict[str, str]]) -> list[ast.stmt]:
    """Return a module's statements after those that it imports of strategies; add its names to ``done``."""
    bound = [name for name, node in bindings(tree) if not isinstance(node, ast.Import | ast.ImportFrom)]
    names = {name: prefix + name for name in bound} if prefix else {"lie": "lie_own"}
    body: list[ast.stmt] = []
    own: list[ast.stmt] = []
    for node in tree.body:
        module = node.module or "" if isinstance(node, ast.ImportFrom) else ""
        if isinstance(node, ast.ImportFrom) and module.startswith(PACKAGE) and module not in ALLOWED:
            if module not in done:
                imported = ast.parse(inspect.getsource(import_module(module)))
                body += _join(imported, f"{module.removeprefix(PACKAGE)}_", done)
            names |= {each.asname or each.name: done[module][each.name] for each in node.names}
        else:
            own.append(node)
    done[PACKAGE + prefix[:-1]] = names
    for each in ast.walk(ast.Module(own, [])):
        for name in ("id", "arg", "name"):
            if isinstance(each, ast.Name | ast.arg | ast.FunctionDef) and hasattr(each, name):
                setattr(each, name, names.get(getattr(each, name), getattr(each, name)))
    return [*body, *own]


def _text(strategy: Strategy, tops: Sequence[tuple[int, int]]) -> str:
    """Return the text of a strategy with all that it imports, and a lie that its parameters describe."""
    source = strategy.source or inspect.getsource(module_of(strategy.name))
    done: dict[str, dict[str, str]] = {}
    body = _join(ast.parse(source), "", done)
    imported = {("lie_own" if name == "lie" else name): name for name in done[PACKAGE] if name in ARGUMENTS}
    wraps = [
        f"def {name}({', '.join(ARGUMENTS[of])}):\n    return {done[PACKAGE][of]}({', '.join(ARGUMENTS[of])})"
        for name, of in imported.items()
        if of not in WIRED and done[PACKAGE][of] != "lie_own"
    ]
    parameters = {
        **strategy.parameters,
        **{f"{name}_{side}": DEFAULTS[name] for side in SIDES for name in DEFAULTS},
    }
    most = "".join(f"    if k < {end}:\n        return {top}\n" for end, top in tops)
    kept = [node for node in body if not (isinstance(node, ast.FunctionDef) and node.name in WIRED)]
    return "\n".join(
        (
            ast.unparse(ast.Module(kept, [])),
            *wraps,
            f"LIE_FIRST = {len(strategy.parameters)}\nPARAMETERS = {parameters!r}",
            f"def lie_most(k):\n{most}    return 0{LIE}{'' if strategy.lie else INVENT}",
        )
    )


def _robot(strategy: Strategy, setting: Setting, number: int, invents: bool) -> Knowledge:
    """Return a robot that has seen all robots and tasks, and all that are invented."""
    robot = Knowledge(strategy, Me(number, 0, 77 * number, 0, [0.0] * strategy.memory, setting))
    ids = (setting.robot_ids, setting.task_ids) if invents else (setting.robots, setting.tasks)
    things = [
        Thing(kind == 0, k, 0, (k * 2654435761 + 97 * kind) % 2**32, k * 7.3 % setting.width, k * 3.1 % 4)
        for kind in (0, 1)
        for k in range(ids[kind])
    ]
    robot.observe(things)
    return robot


def _samples(strategy: Strategy, setting: Setting) -> Iterator[tuple[int, ...]]:
    """Yield honest messages of robots that have seen everything, and the strategy's own lies."""
    for number, invents in product((0, setting.robots - 1), (True, False)):
        robot = _robot(strategy, setting, number, invents)
        for step in range(3 * setting.task_ids):
            robot.me = robot.me._replace(step=step)
            message = robot.message()
            yield message
            if strategy.lie is not None:
                yield from (robot.lie(message, feasible, ()) for feasible in (0, 1))


def _tops(strategy: Strategy, setting: Setting) -> list[tuple[int, int]]:
    """Return the largest value of each word of a message, as runs: the word after the last, and the value."""
    tops = [
        max(word) & 0xFFFFFFFF if min(word) >= 0 else 2**32 - 1
        for word in zip(*_samples(strategy, setting), strict=True)
    ]
    runs: list[tuple[int, int]] = []
    for k, top in enumerate(tops):
        alike = k > 1 and runs[-1][1].bit_length() == top.bit_length()
        runs.append((k + 1, max(top, runs.pop()[1]) if alike else top))
    return runs


def lying(scenario: Scenario, values: Mapping[str, float] | None = None) -> Scenario:
    """Return a scenario whose Byzantine robots collude, with a lie that parameters of its strategy describe.

    Parameters
    ----------
    scenario : Scenario
        Its robots pass on knowledge. ``faults.byzantine`` says how many lie.
    values : mapping of str to float, optional
        Parameters of the lie, for each side, such as ``form_feasible``; by default the strategy's own lie.

    Raises
    ------
    FeasibeeError
        If robots pass on opinions only: ``faults.byzantine_says`` has all their lies.
    """
    strategy = scenario.strategy
    if not strategy.knowledge:
        raise FeasibeeError(
            f"decision.strategy = {strategy.name}: passes on opinions only; set faults.byzantine_says"
        )
    scenario = scenario.replace({"faults.byzantine_says": "colluding"})
    tables = scenario.to_dict()
    decision = tables["decision"]
    decision["parameters"] = {**scenario.decision.parameters, **(values or {})}
    decision["strategy"] = f"{strategy.name.removesuffix('.py')}-lying.py"
    return Scenario.from_tables(tables, source=_text(strategy, _tops(strategy, scenario.setting)))


def _is_sent(original: Scenario, liar: Scenario, side: int, form: int) -> bool:
    """Whether all messages of a lie of this form can be sent in the strategy's own format."""
    strategy: Any = original.strategy
    if form == OWN or strategy.functions.isdisjoint(WIRED):
        return True
    id_bits = max(original.setting.id_bits, (original.setting.robot_ids - 1).bit_length())
    parameters = {**liar.decision.parameters, f"form_{SIDES[side]}": float(form)}
    setting = original.setting._replace(id_bits=id_bits)
    wire = Wire(strategy, id_bits, setting=setting)
    robot = _robot(liar.strategy, setting._replace(parameters=tuple(parameters.values())), 0, False)
    for step in range(20):
        robot.me = robot.me._replace(step=step)
        told = robot.lie(robot.message(), side, ())
        try:
            written = wire.bits(0, Message(-1, knowledge=told))
            wire.decode(wire.encode(0, Message(-1, knowledge=told)))
        except (WireError, IndexError):
            return False
        if written != strategy.bits(told, robot.me):
            return False
    return True


def _space(original: Scenario, liar: Scenario, side: int) -> list[Dimension]:
    """Return what a search on one side varies."""
    if not original.strategy.knowledge:
        says = ("colluding", "opposite", "feasible", "infeasible", "random")
        return [Dimension(SAYS, choices=says)]
    path = f"decision.parameters.{{}}_{SIDES[side]}".format
    forms = tuple(float(form) for form in range(1, 32) if _is_sent(original, liar, side, form))
    return [
        Dimension(path("form"), choices=forms),
        Dimension(path("share"), 0.05, 1.0),
        Dimension(path("holds"), 1.0, 1000.0),
        Dimension(path("duty"), 0.05, 1.0),
    ]


def worst_lie(
    scenario: Scenario,
    name: str,
    liars: int = 1,
    trials: int = 30,
    runs: int = 40,
    seed: int = 0,
    execution: Execution | None = None,
) -> Found:
    """Search for the lie with which swarms are right least often, at a ratio and at its reciprocal.

    The liars collude and know the truth, so that the lie of each side is searched by itself, by Optuna.

    Parameters
    ----------
    scenario : Scenario
        The world.
    name : str
        The strategy, which tolerates so many Byzantine robots if it can.
    liars : int
        Number of Byzantine robots.
    trials, runs : int
        Number of lies tried on each side, and runs of each.
    seed : int
        64 bits.
    execution : Execution, optional
        Where to compute and keep the runs; by default on threads, and in memory.

    Raises
    ------
    FeasibeeError
        If Optuna isn't installed, or the scenario has no opposite side.
    """
    changes = {"faults.byzantine": 0.0, "run.stop_at_decision": False}
    world = scenario.replace({**strategy_for(scenario, name, liars), **changes})
    other = opposite_of(world)
    if other is None:
        raise FeasibeeError("tasks: must have a reciprocal ratio; leave out classes and tasks.points")
    honest, found = [world, other], []
    for each in honest:
        told = each.replace({"faults.byzantine": {"count": liars}, "faults.byzantine_says": "colluding"})
        liar = lying(told) if told.strategy.knowledge else told
        space = _space(told, liar, _side(told))
        found.append(tune(liar, space, trials, runs, seed, execution, Objective(worst=True), theory=False))
    return _summary(honest, found, runs, seed, execution)


def _side(scenario: Scenario) -> int:
    """Return what Byzantine robots speak for that know the truth: 1 for feasible."""
    return int(scenario.tasks.count > scenario.robots.count)


def _summary(
    honest: Sequence[Scenario], found: Sequence[Tuned], runs: int, seed: int, execution: Execution | None
) -> Found:
    """Return the shares over both sides, without Byzantine robots, with the strategy's lie, and the worst."""
    fresh = FRESH_RUNS * runs
    with Rounds(execution) as rounds:
        designs = [DesignPoint({}, each) for each in honest]
        alone = scored(rounds, designs, fresh, (seed + FRESH_SEED) % 2**64, Objective())
    right = sum(int(each.values.sum()) for each in alone)
    own, worst = (
        sum(round(getattr(each, name).estimate * fresh) for each in found) for name in ("start", "best")
    )
    values = {
        f"says_{SIDES[_side(each)]}" if path == SAYS else path.removeprefix("decision.parameters."): value
        for each, tuned in zip(honest, found, strict=True)
        for path, value in tuned.values.items()
    }
    return Found(values, *(wilson(number, 2 * fresh) for number in (right, own, worst)))
