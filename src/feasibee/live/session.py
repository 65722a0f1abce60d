"""One page's swarm: checked, begun, advanced. The server calls all this in threads."""

from __future__ import annotations

import time
from typing import Any, Final, NamedTuple

from feasibee.errors import FeasibeeError, Problem, ScenarioError
from feasibee.live.catalogue import Programme
from feasibee.live.messages import Open, frame_of, tasks_of
from feasibee.model.codes import RUN_LIMIT, SEED_LIMIT
from feasibee.scenario.feasibility import explain
from feasibee.scenario.plugins import registered
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.swarm import Swarm
from feasibee.strategies import STRATEGIES

ROBOTS_LIMIT: Final = 20_000
TASKS_LIMIT: Final = 20_000
STEPS_LIMIT: Final = 200_000
ROOM: Final = 256 * 2**20
"""Bytes of a swarm's state, beside what it takes in proportion to robots and tasks."""
FILES: Final = ("robots.points", "tasks.points")
"""Fields that may name a file, which a page may not."""
STRATEGY: Final = "decision.strategy"


class Plan(NamedTuple):
    """A run that a page asks for, checked."""

    scenario: Scenario
    seed: int
    run: int
    step: int


def plan_of(asked: Open, programme: Programme) -> Plan:
    """Check what a page asks for.

    Raises
    ------
    FeasibeeError
        If there is no such run, or it isn't one for a page: all problems at once.
    """
    scenario = programme.scenario_of(asked.point)
    if asked.changes.get(STRATEGY) == scenario.decision.strategy:
        del asked.changes[STRATEGY]  # the text that it has, not whatever lies at that path now
    problems = list(_forbidden(asked))
    seed = programme.seed_of(asked.point) if asked.seed is None else asked.seed
    run = programme.run if asked.run is None else asked.run
    numbers = (_number("seed", seed, SEED_LIMIT, problems), _number("run", run, RUN_LIMIT - 1, problems))
    allowed = {path: value for path, value in asked.changes.items() if path not in {p.path for p in problems}}
    try:
        scenario = scenario.replace(allowed)
    except ScenarioError as error:
        raise ScenarioError([*problems, *error.problems]) from None
    for path, count, limit in (
        ("robots.count", scenario.robots.count, ROBOTS_LIMIT),
        ("tasks.count", scenario.tasks.count, TASKS_LIMIT),
    ):
        if count > limit:
            problems.append(
                Problem(path, count, f"must be ≤ {limit} on this page", "simulate more with feasibee run")
            )
    if problems:
        raise ScenarioError(problems)
    return Plan(scenario, *numbers, min(asked.step, last_step(scenario)))


def last_step(scenario: Scenario) -> int:
    """Return the last step that a page can see: that of the run, unless it is very long."""
    return min(scenario.run.steps, STEPS_LIMIT)


def _forbidden(asked: Open) -> Any:
    """Yield the changes that would open a file, which only the command line may name."""
    strategies = [*STRATEGIES, *registered()]
    for path, value in asked.changes.items():
        if path in FILES and isinstance(value, str):
            rule = "can't be a file here"
            yield Problem(path, value, rule, "name it in the scenario on the command line")
        elif path == STRATEGY and value not in strategies:
            rule = f"must be one of {', '.join(strategies)}"
            yield Problem(
                path,
                value,
                rule,
                "name a file on the command line: feasibee watch --set decision.strategy=...",
            )
        elif "." not in path and path != "preset":
            yield Problem(
                path, value, "isn't the path of a field", "write section.field, such as tasks.count"
            )


def _number(name: str, value: str | int | float, limit: int, problems: list[Problem]) -> int:
    """Return a whole number of the page, which writes them as text, or note the problem."""
    number = (
        int(value)
        if isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 30
        else value
    )
    if isinstance(number, int) and not isinstance(number, bool) and 0 <= number < limit:
        return number
    problems.append(Problem(name, value, f"must be a whole number from 0 to {limit - 1}", "choose one"))
    return 0


class Session:
    """The swarm of one page."""

    def __init__(self, programme: Programme) -> None:
        self._programme = programme
        self._swarm: Swarm | None = None
        self._plan: Plan | None = None
        self._generation = 0
        self._told = 0

    @property
    def swarm(self) -> Swarm:
        """The swarm that the page sees.

        Raises
        ------
        FeasibeeError
            If it hasn't begun one.
        """
        if self._swarm is None:
            raise FeasibeeError("message: there is no swarm yet; open one first")
        return self._swarm

    def begin(self, plan: Plan) -> None:
        """Put a swarm at step 0, in place of the one before; if that fails, the one before stays."""
        self._swarm = Swarm(plan.scenario, plan.seed, plan.run, room=ROOM)
        self._plan = plan
        self._generation += 1
        self._told = 0

    def advance(self, step: int, seconds: float) -> bool:
        """Go on until a step, or the end of the run, but not for long; tell whether it is reached."""
        swarm = self.swarm
        until = min(step, last_step(swarm.scenario))
        end = time.monotonic() + seconds
        chunk = 1
        while swarm.step < until and time.monotonic() < end:
            before = time.monotonic()
            swarm.advance(min(chunk, until - swarm.step))
            chunk = 2 * chunk if time.monotonic() - before < seconds / 8 else chunk
        return swarm.step >= until

    def advanced(self, steps: int, seconds: float) -> bytes:
        """Let some steps pass, as far as time allows, and return the frame."""
        self.advance(self.swarm.step + steps, seconds)
        return self.frame()

    def frame(self) -> bytes:
        """Return the present step, with all counts that the page hasn't got."""
        frame = frame_of(self.swarm, self._generation, self._told)
        self._told = self.swarm.step + 1 if self.swarm.step >= self._told else self._told
        return frame

    def tasks(self) -> bytes:
        """Return where the tasks are."""
        return tasks_of(self.swarm, self._generation)

    def opened(self) -> dict[str, Any]:
        """Return what the page is told of a swarm that has begun."""
        swarm, plan = self.swarm, self._plan
        assert plan is not None
        scenario = plan.scenario
        verdict = explain(scenario)
        width, height = scenario.arena.size
        return {
            "type": "opened",
            "generation": self._generation & 0xFFFF,
            "seed": str(plan.seed),
            "run": str(plan.run),
            "last": last_step(scenario),
            "fields": _fields(scenario),
            "toml": scenario.to_toml(),
            "truth": verdict.feasible,
            "proof": _proof(verdict.violator, scenario),
            "robots": scenario.robots.count,
            "tasks": scenario.tasks.count,
            "robotClasses": [[each.name, each.count] for each in scenario.robots.classes],
            "taskClasses": [[each.name, each.count] for each in scenario.tasks.classes],
            "size": [width, height],
            "walls": scenario.arena.boundary == "walls",
            "diameter": scenario.robots.diameter,
            "sight": scenario.sensing.range,
            "radio": scenario.radio.range,
            "threshold": scenario.decision.threshold,
            "counted": [scenario.counted(0), scenario.counted(scenario.faults.stop_step)],
            "stopStep": scenario.faults.stop_step,
            "commits": scenario.decision.commit is not None,
            "step": swarm.step,
        }


def _fields(scenario: Scenario) -> dict[str, Any]:
    """Return the plain fields by dotted path, for the controls."""
    tables = scenario.to_dict()
    fields = {f"{section}.{key}": value for section, table in tables.items() for key, value in table.items()}
    counts = {"robots.count": scenario.robots.count, "tasks.count": scenario.tasks.count}
    return {path: value for path, value in (fields | counts).items() if isinstance(value, str | int | float)}


def _proof(violator: Any, scenario: Scenario) -> str:
    """Return in a few words why the tasks are feasible or not."""
    robots, tasks = scenario.robots.count, scenario.tasks.count
    if not (scenario.robots.classes or scenario.tasks.classes):
        return f"{robots:,} robots, {tasks:,} tasks"
    if violator is None:
        return "every place can be filled"
    return f"{', '.join(violator.skills)}: {violator.demand} places, {violator.robots} robots"
