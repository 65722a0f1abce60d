"""One of the swarms that a page shows: its time, its frames and its other messages."""

from __future__ import annotations

from typing import Any, Final

from feasibee.errors import ScenarioError
from feasibee.live.form import EVENTS, shown
from feasibee.live.messages import encode_frame
from feasibee.live.reasons import reasons_of
from feasibee.live.scene import scene_of
from feasibee.live.timeline import History, Outlook, Timeline
from feasibee.scenario.feasibility import Verdict, explain
from feasibee.scenario.fields import dimension_of, fields
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import in_brackets
from feasibee.simulation.swarm import Swarm

STEPS_LIMIT: Final = 200_000
ROOM: Final = 256 * 2**20
"""Most bytes of a page's swarms, in addition to what is proportional to robots and tasks."""
LONGEST: Final = 2000
"""Most characters of a field that isn't a number or a word, in the form of settings."""


def last_step(scenario: Scenario) -> int:
    """Return the last step that a page can show: that of the run, but at most `STEPS_LIMIT`."""
    return min(scenario.run.steps, STEPS_LIMIT)


class Lane:
    """A swarm of a page, and which of its counts the page has received.

    ``number`` is 0, or 1 for the second swarm. ``room`` is the most bytes of its state, in addition to what
    is proportional to robots and tasks.
    """

    def __init__(self, number: int, scenario: Scenario, seed: int, run: int, room: int) -> None:
        self.number = number
        self.swarm = Swarm(scenario, seed, run, room=room)
        self.timeline = Timeline(self.swarm)
        self.history = History(self.timeline)
        self._which = scenario, seed, run
        self._room = room
        self._outlook: Outlook | None = None
        self._counts_sent = 0

    @property
    def outlook(self) -> Outlook:
        """What lies ahead; the first use makes a second swarm.

        Raise a FeasibeeError if that swarm needs too much memory.
        """
        if self._outlook is None:
            scenario, seed, run = self._which
            swarm = Swarm(scenario, seed, run, room=self._room // 2)
            self._outlook = Outlook(swarm, last_step(scenario))
        return self._outlook

    def frame(self, generation: int, jump: int) -> bytes:
        """Return the frame of the current step, with all counts that the page has not received."""
        frame = encode_frame(self.swarm, generation, self._counts_sent, lane=self.number, jump=jump)
        self._counts_sent = max(self._counts_sent, self.swarm.step + 1)
        return frame

    def reasons(self, robot: int) -> dict[str, Any]:
        """Return what a robot knows at this step, in words."""
        reasons = reasons_of(self.swarm, robot)
        at = {"lane": self.number, "step": self.swarm.step}
        return {"type": "robot", **at, "robot": robot, "reasons": reasons}

    def opened(self) -> dict[str, Any]:
        """Return the message ``opened``: the run, its scenario and its ground truth."""
        scenario = self.swarm.scenario
        about = opening(*self._which, self.swarm.robot_kinds.tolist(), last_step(scenario))
        return {"lane": self.number, **about, "step": self.swarm.step}


def opening(scenario: Scenario, seed: int, run: int, kinds: list[int], last: int) -> dict[str, Any]:
    """Return what a page gets of a run when it opens it; ``kinds`` are the classes of its robots."""
    return {
        "type": "opened",
        "last": last,
        "strategy": scenario.decision.strategy,
        "seed": str(seed),
        "run": str(run),
        "fields": _fields(scenario),
        "units": _units(scenario),
        "toml": scenario.to_toml(),
        "drawn": scenario.place.walls,
        "cell": scenario.place.map.cell if scenario.place.map else scenario.place.cell,
        "fixed": why_fixed(scenario),
        "events": [each.model_dump(exclude_defaults=True) for each in scenario.events],
        "proof": _proof(explain(scenario), scenario),
        **scene_of(scenario),
        "robotClasses": [each.name for each in scenario.robots.classes],
        "kinds": kinds if scenario.robots.classes else [],
        "threshold": scenario.decision.threshold,
    }


def _fields(scenario: Scenario) -> dict[str, Any]:
    """Return the values of the fields by dotted path, for the form; not those too long to edit."""
    tables = scenario.to_dict()
    events = {EVENTS: tables.pop(EVENTS, "")}
    fields = {f"{section}.{key}": value for section, table in tables.items() for key, value in table.items()}
    counts = {"robots.count": scenario.robots.count, "tasks.count": scenario.tasks.count}
    found = {path: shown(value) for path, value in (fields | counts | events).items()}
    return {path: value for path, value in found.items() if len(str(value)) <= LONGEST}


def _units(scenario: Scenario) -> dict[str, str]:
    """Return the unit of each field that has one, and its value in metres and seconds, if they are known."""
    found = {path: each for path in fields() if (each := dimension_of(path)).unit}
    return {path: each.unit + in_brackets(scenario, each, scenario.get(path)) for path, each in found.items()}


def why_fixed(scenario: Scenario) -> str:
    """Return why events can't change a world; empty if they can."""
    try:
        scenario.replace({EVENTS: [{"step": 1, "tasks": 1}]})
    except ScenarioError as error:
        return str(error.problems[0])
    return ""


def _proof(verdict: Verdict, scenario: Scenario) -> str:
    """Return in a few words why the tasks are feasible or infeasible."""
    robots, tasks = scenario.robots.count, scenario.tasks.count
    violator, where = verdict.violator, f"{verdict.where}: " if verdict.where else ""
    if not (scenario.robots.classes or scenario.tasks.classes):
        if violator is not None and where:
            return f"{where}{violator.robots:,} of {robots:,} robots, {violator.demand:,} of {tasks:,} tasks"
        return f"{robots:,} robots, {tasks:,} tasks"
    if violator is None:
        return "robots for all tasks"
    return f"{where}{', '.join(violator.skills)}: {violator.demand} places, {violator.robots} robots"
