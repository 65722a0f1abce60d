"""The session of one page: validate its requests, run its swarm. The server calls this in threads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

from feasibee.errors import FeasibeeError, Problem, ScenarioError
from feasibee.live.catalogue import Catalogue
from feasibee.live.form import EVENTS, typed
from feasibee.live.lane import ROOM, Lane, last_step
from feasibee.live.messages import Look, Open, Why, encode_tasks
from feasibee.live.prediction import prediction_of
from feasibee.live.reasons import sentence_of
from feasibee.live.timeline import advance_together
from feasibee.model.codes import RUN_LIMIT, SEED_LIMIT
from feasibee.scenario.plugins import registered
from feasibee.scenario.runs import check_integer
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.tables import with_names
from feasibee.simulation.swarm import Swarm
from feasibee.strategies import STRATEGIES

ROBOTS_LIMIT: Final = 20_000
TASKS_LIMIT: Final = 20_000
STRATEGY: Final = "decision.strategy"
OWN: Final = (STRATEGY, "decision.parameters")
"""Fields that belong to one strategy."""
AGAINST: Final = "against"
"""Path of the second swarm's strategy, in the form and in errors."""


def runs_of(asked: Open, catalogue: Catalogue) -> tuple[list[Scenario], int, int]:
    """Return the scenario of each swarm that a page asks for, their seed and their run.

    Raise a FeasibeeError if the scenario, seed or run is invalid or beyond the limits of a page; it lists all
    problems.
    """
    base = catalogue.scenario_of(asked.point)
    if asked.changes.get(STRATEGY) == base.decision.strategy:
        del asked.changes[STRATEGY]  # keep its text: the file at that path may have changed
    for path, value in asked.changes.items():
        asked.changes[path] = typed(path, value)
    problems = list(_forbidden(asked))
    seed = catalogue.seed_of(asked.point) if asked.seed is None else asked.seed
    run = catalogue.run if asked.run is None else asked.run
    numbers = (_number("seed", seed, SEED_LIMIT, problems), _number("run", run, RUN_LIMIT - 1, problems))
    allowed = {path: value for path, value in asked.changes.items() if path not in {p.path for p in problems}}
    try:
        scenario = base.replace(allowed)
    except ScenarioError as error:
        raise ScenarioError([*problems, *error.problems]) from None
    problems.extend(_too_many(scenario))
    if problems:
        raise ScenarioError(problems)
    second = [] if asked.against is None else [second_of(base, scenario, allowed, asked.against)]
    return [scenario, *second], *numbers


def second_of(base: Scenario, scenario: Scenario, changes: Mapping[str, Any], strategy: str) -> Scenario:
    """Return the scenario of the second swarm: the same world, another strategy with its parameters.

    The strategy of ``base``, from which ``changes`` led to the first swarm's scenario, keeps its text and
    parameters. One that is none of this page, or can't be used in that world, is a problem at ``against``.
    """
    if strategy == scenario.decision.strategy:
        return scenario
    if strategy == base.decision.strategy:
        return base.replace({path: each for path, each in changes.items() if not path.startswith(OWN)})
    problems = list(_forbidden(Open(type="open", changes={STRATEGY: strategy})))
    if not problems:
        try:
            return scenario.replace({STRATEGY: strategy, "decision.parameters": {}})
        except ScenarioError as error:
            problems = list(error.problems)
    raise ScenarioError(each._replace(path=AGAINST) if each.path == STRATEGY else each for each in problems)


def _too_many(scenario: Scenario) -> Iterator[Problem]:
    """Yield a problem if there are, or may be in a run, more robots or tasks than a page shows."""
    most = scenario.most
    for section, count, limit in (("robots", most.robots, ROBOTS_LIMIT), ("tasks", most.tasks, TASKS_LIMIT)):
        start = scenario.get(f"{section}.count")
        joining = sum(max(0, getattr(each, section)) for each in scenario.events)
        if start > limit:
            rule = f"must be ≤ {limit} on this page"
            yield Problem(f"{section}.count", start, rule, "use feasibee run for more")
        elif start + joining > limit:
            rule = f"let {start + joining} {section} appear in a run, above {limit} on this page"
            yield Problem(EVENTS, f"{len(scenario.events)} in all", rule, "use feasibee run for more")
        elif count > limit:
            path = f"{section}.arrival_rate"
            rule = f"lets up to {count} {section} appear in a run, above {limit} on this page"
            yield Problem(path, scenario.get(path), rule, "lower it, or run.steps")


def _forbidden(asked: Open) -> Any:
    """Yield a problem per change that would open a file or whose path isn't a field's."""
    strategies = [*STRATEGIES, *registered()]
    for path, value in asked.changes.items():
        if path != STRATEGY and with_names(path, value, lambda name: None) != value:
            rule = "can't be a file on this page"
            yield Problem(path, value, rule, "set it in the scenario of feasibee watch FILE")
        elif path == STRATEGY and value not in strategies:
            rule = f"must be one of {', '.join(strategies)}"
            remedy = "to use a file, run feasibee watch --set decision.strategy=FILE.py"
            yield Problem(path, value, rule, remedy)
        elif "." not in path and path not in ("preset", EVENTS):
            rule = "must be the path of a field"
            yield Problem(path, value, rule, "write section.field, such as tasks.count")


def _number(name: str, value: str | int | float, limit: int, problems: list[Problem]) -> int:
    """Return a whole number that a page sent as text; if it is invalid, append a problem and return 0."""
    is_text = isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 30
    number = int(value) if is_text else value
    if isinstance(number, int) and not isinstance(number, bool) and 0 <= number < limit:
        return number
    problems.append(Problem(name, value, f"must be a whole number from 0 to {limit - 1}", "use 0"))
    return 0


class Session:
    """The swarms of one page: one, or two side by side that are always at the same step."""

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self._lanes: list[Lane] = []
        self._generation = 0
        self._jump = 0
        self._inspected: int | None = None

    @property
    def swarm(self) -> Swarm:
        """The first swarm that the page shows."""
        return self.lane(0).swarm

    def lane(self, number: int) -> Lane:
        """Return a swarm of the page.

        Raise a FeasibeeError if the page has not opened a run yet, or shows no second swarm.
        """
        if number >= len(self._lanes):
            what = f"no swarm {number}" if self._lanes else "no run"
            raise FeasibeeError(f"message: {what} is open; reload the page")
        return self._lanes[number]

    @property
    def step(self) -> int:
        """The step that the page has reached."""
        return self.swarm.step

    @property
    def last(self) -> int:
        """The last step that the page can show."""
        return last_step(self.swarm.scenario)

    def begin(self, asked: Open) -> int:
        """Replace the swarms by those that a page asks for, at step 0; return the step to go to.

        Raise a FeasibeeError if the request is invalid, or its swarms take too much memory; the previous ones
        stay.
        """
        scenarios, seed, run = runs_of(asked, self._catalogue)
        room = ROOM // len(scenarios)
        self._lanes = [Lane(number, each, seed, run, room) for number, each in enumerate(scenarios)]
        self._generation += 1
        self._jump = 0
        self._inspected = None
        return min(asked.step, self.last)

    def advance(self, step: int, seconds: float) -> bool:
        """Advance to a step, or to the last, for a limited time; return whether it is reached."""
        return advance_together([each.timeline for each in self._lanes], min(step, self.last), seconds)

    def rewind(self, step: int, jump: int) -> None:
        """Go to a step before a given one, from which `advance` leads there; number the frames anew."""
        for each in self._lanes:
            each.timeline.rewind(step)
        nearest = min(each.swarm.step for each in self._lanes)
        for each in self._lanes:
            if each.swarm.step > nearest:
                each.timeline.rewind(nearest)
                each.timeline.advance(nearest)
        self._jump = jump

    def inspect(self, robot: int | None) -> None:
        """Send what a robot knows with each frame from now on.

        Raise a FeasibeeError if there is no such robot.
        """
        if robot is not None:
            check_integer("robot", robot, 0, self.swarm.present.size - 1)
        self._inspected = robot

    def next_messages(self, steps: int, seconds: float) -> list[dict[str, Any] | bytes]:
        """Advance by some steps, for a limited time, and return the messages of that step."""
        self.advance(self.swarm.step + steps, seconds)
        return self.messages()

    def messages(self) -> list[dict[str, Any] | bytes]:
        """Return the messages of the current step; the frame of the first swarm comes last."""
        robot = self._inspected
        said = [] if robot is None else [self._marked(each.reasons(robot)) for each in self._lanes]
        return [*said, *(each.frame(self._generation, self._jump) for each in reversed(self._lanes))]

    def openings(self) -> list[dict[str, Any] | bytes]:
        """Return the messages with which a run begins: its swarms, and the positions of the tasks."""
        opened = [self._marked({"swarms": len(self._lanes), **each.opened()}) for each in self._lanes]
        return [*opened, encode_tasks(self.swarm, self._generation)]

    def look(self, asked: Look, seconds: float) -> dict[str, Any]:
        """Look ahead in a run for a limited time, and return what is found."""
        lane = self.lane(asked.lane)
        if asked.robot is not None:
            check_integer("robot", asked.robot, 0, lane.swarm.present.size - 1)
        try:
            lane.outlook.follow(asked.robot)
            lane.outlook.look(seconds)
            found = lane.outlook.to_dict(asked.first, asked.seen)
        except FeasibeeError as error:  # it needs too much memory, or the strategy fails later in the run
            found = asked.nothing(str(error))
        return self._marked({"lane": asked.lane, **found})

    def why(self, asked: Why) -> dict[str, Any]:
        """Return why a robot holds its opinion; raise a FeasibeeError if there is no such robot."""
        lane = self.lane(asked.lane)
        check_integer("robot", asked.robot, 0, lane.swarm.present.size - 1)
        text = sentence_of(lane.swarm, asked.robot, lane.history)
        return self._marked({**asked.model_dump(), "step": self.step, "text": text})

    def prediction(self, number: int) -> dict[str, Any]:
        """Return what the theory says of a swarm of the page.

        Raise a FeasibeeError if the page shows no such swarm.
        """
        lane, generation = self.lane(number), self._generation  # another run may begin meanwhile
        found = prediction_of(lane.swarm.scenario)
        return {"type": "predicted", "lane": number, "generation": generation & 0xFFFF, **found}

    def _marked(self, message: dict[str, Any]) -> dict[str, Any]:
        return {**message, "generation": self._generation & 0xFFFF, "jump": self._jump}
