"""The session of one page: validate its requests, run its swarm. The server calls this in threads."""

from __future__ import annotations

import time
from typing import Any, Final, NamedTuple

from feasibee.errors import FeasibeeError, Problem, ScenarioError
from feasibee.live.catalogue import Catalogue
from feasibee.live.messages import Open, encode_frame, encode_tasks
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
"""Most bytes of a swarm's state, in addition to what is proportional to robots and tasks."""
FILES: Final = ("robots.points", "tasks.points")
"""Fields that may name a file; a page may not name one."""
STRATEGY: Final = "decision.strategy"


class RunRequest(NamedTuple):
    """A validated request of a page: a run, and the step to go to."""

    scenario: Scenario
    seed: int
    run: int
    step: int


def request_of(asked: Open, catalogue: Catalogue) -> RunRequest:
    """Validate what a page asks for.

    Raises
    ------
    FeasibeeError
        If the scenario, seed or run is invalid or beyond the limits of a page; it lists all problems.
    """
    scenario = catalogue.scenario_of(asked.point)
    if asked.changes.get(STRATEGY) == scenario.decision.strategy:
        del asked.changes[STRATEGY]  # keep its text: the file at that path may have changed
    problems = list(_forbidden(asked))
    seed = catalogue.seed_of(asked.point) if asked.seed is None else asked.seed
    run = catalogue.run if asked.run is None else asked.run
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
                Problem(path, count, f"must be ≤ {limit} on this page", "use feasibee run for more")
            )
    if problems:
        raise ScenarioError(problems)
    return RunRequest(scenario, *numbers, min(asked.step, last_step(scenario)))


def last_step(scenario: Scenario) -> int:
    """Return the last step that a page can show: that of the run, but at most `STEPS_LIMIT`."""
    return min(scenario.run.steps, STEPS_LIMIT)


def _forbidden(asked: Open) -> Any:
    """Yield a problem per change that would open a file or whose path isn't a field's."""
    strategies = [*STRATEGIES, *registered()]
    for path, value in asked.changes.items():
        if path in FILES and isinstance(value, str):
            rule = "can't be a file on this page"
            yield Problem(path, value, rule, "set it in the scenario of feasibee watch FILE")
        elif path == STRATEGY and value not in strategies:
            rule = f"must be one of {', '.join(strategies)}"
            yield Problem(
                path,
                value,
                rule,
                "to use a file, run feasibee watch --set decision.strategy=FILE.py",
            )
        elif "." not in path and path != "preset":
            yield Problem(
                path, value, "must be the path of a field", "write section.field, such as tasks.count"
            )


def _number(name: str, value: str | int | float, limit: int, problems: list[Problem]) -> int:
    """Return a whole number that a page sent as text; if it is invalid, append a problem and return 0."""
    number = (
        int(value)
        if isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 30
        else value
    )
    if isinstance(number, int) and not isinstance(number, bool) and 0 <= number < limit:
        return number
    problems.append(Problem(name, value, f"must be a whole number from 0 to {limit - 1}", "use 0"))
    return 0


class Session:
    """The swarm of one page, and which of its counts the page has received."""

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self._swarm: Swarm | None = None
        self._request: RunRequest | None = None
        self._generation = 0
        self._counts_sent = 0

    @property
    def swarm(self) -> Swarm:
        """The swarm that the page shows.

        Raises
        ------
        FeasibeeError
            If the page has not opened a run yet.
        """
        if self._swarm is None:
            raise FeasibeeError("message: no run is open; reload the page")
        return self._swarm

    def begin(self, request: RunRequest) -> None:
        """Replace the swarm by that of a request, at step 0; on an error the previous swarm stays."""
        self._swarm = Swarm(request.scenario, request.seed, request.run, room=ROOM)
        self._request = request
        self._generation += 1
        self._counts_sent = 0

    def advance(self, step: int, seconds: float) -> bool:
        """Advance to a step, or to the last, for a limited time; return whether it is reached."""
        swarm = self.swarm
        until = min(step, last_step(swarm.scenario))
        end = time.monotonic() + seconds
        chunk = 1
        while swarm.step < until and time.monotonic() < end:
            before = time.monotonic()
            swarm.advance(min(chunk, until - swarm.step))
            chunk = 2 * chunk if time.monotonic() - before < seconds / 8 else chunk
        return swarm.step >= until

    def next_frame(self, steps: int, seconds: float) -> bytes:
        """Advance by some steps, for a limited time, and return the frame."""
        self.advance(self.swarm.step + steps, seconds)
        return self.frame()

    def frame(self) -> bytes:
        """Return the frame of the current step, with all counts that the page has not received."""
        frame = encode_frame(self.swarm, self._generation, self._counts_sent)
        self._counts_sent = self.swarm.step + 1 if self.swarm.step >= self._counts_sent else self._counts_sent
        return frame

    def tasks(self) -> bytes:
        """Return the message with the positions of the tasks."""
        return encode_tasks(self.swarm, self._generation)

    def opened(self) -> dict[str, Any]:
        """Return the message ``opened``: the run, its scenario and its ground truth."""
        swarm, request = self.swarm, self._request
        assert request is not None
        scenario = request.scenario
        verdict = explain(scenario)
        width, height = scenario.arena.size
        return {
            "type": "opened",
            "generation": self._generation & 0xFFFF,
            "seed": str(request.seed),
            "run": str(request.run),
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
            "declares": scenario.manifest.declares,
            "step": swarm.step,
        }


def _fields(scenario: Scenario) -> dict[str, Any]:
    """Return the fields that are text or numbers by dotted path, for the controls."""
    tables = scenario.to_dict()
    fields = {f"{section}.{key}": value for section, table in tables.items() for key, value in table.items()}
    counts = {"robots.count": scenario.robots.count, "tasks.count": scenario.tasks.count}
    return {path: value for path, value in (fields | counts).items() if isinstance(value, str | int | float)}


def _proof(violator: Any, scenario: Scenario) -> str:
    """Return in a few words why the tasks are feasible or infeasible."""
    robots, tasks = scenario.robots.count, scenario.tasks.count
    if not (scenario.robots.classes or scenario.tasks.classes):
        return f"{robots:,} robots, {tasks:,} tasks"
    if violator is None:
        return "each place has a robot"
    return f"{', '.join(violator.skills)}: {violator.demand} places, {violator.robots} robots"
