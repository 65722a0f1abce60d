"""Ground truth: whether the swarm can do all tasks at once, with a proof that can be checked (model.md 6.7).

The computation counts classes of robots and tasks, so its time doesn't grow with the number of robots.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate, combinations
from typing import Any, NamedTuple

import numpy as np

from feasibee.base.errors import FeasibeeError, quoted
from feasibee.scenario.fields import RobotClass, Robots, TaskClass, Tasks
from feasibee.scenario.ground import Surface, ground_of
from feasibee.scenario.sections import Sections

ANY = "any"
"""The skill that tasks without classes need and every robot has.

It can't be confused with a user's skill of this name: tasks have either classes with skills, or neither.
"""


class Violator(NamedTuple):
    """A set of skills needed at more places than robots have any of these skills (Hall's condition)."""

    skills: tuple[str, ...]
    """The skills of the set, in alphabetical order."""
    demand: int
    """Number of places in tasks that need a skill of the set."""
    robots: int
    """Number of robots with at least one skill of the set."""


class Piece(NamedTuple):
    """A piece of a place in a verdict: where it is, and which robots do its tasks (model.md 6.20.6)."""

    number: int
    """From 1 on."""
    x: tuple[float, float]
    """Left and right end of its passable cells, in units."""
    y: tuple[float, float]
    """Lower and upper end of its passable cells, in units."""
    assignment: Mapping[tuple[str, str, str], int]
    """As that of the `Verdict`, in this piece only."""

    def __str__(self) -> str:
        return f"{self.number} (x {self.x[0]:g} to {self.x[1]:g}, y {self.y[0]:g} to {self.y[1]:g})"


class Verdict(NamedTuple):
    """The ground truth of a scenario, and its proof."""

    assignment: Mapping[tuple[str, str, str], int]
    """Number of robots by class of robots, class of tasks and skill; empty if the tasks are infeasible."""
    violator: Violator | None
    """The set of skills whose demand exceeds its robots most; None if the tasks are feasible."""
    piece: int | None = None
    """The piece of a place that lacks robots; 0 for tasks that no robot reaches (model.md 6.20.10)."""
    pieces: tuple[Piece, ...] = ()
    """If robots and tasks are in several pieces of a place: all with tasks, or the one that lacks robots."""

    @property
    def feasible(self) -> bool:
        """Whether all tasks can be done at once, each place by a different robot."""
        return self.violator is None

    @property
    def where(self) -> str:
        """Which piece of a place lacks robots, in words; empty if the whole swarm is in one."""
        if self.piece is None:
            return ""
        return f"in piece {self.pieces[0]}" if self.piece else "where no robot gets"

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The assignment, one dict for each class of robots, class of tasks, skill and, if any, piece."""
        parts = [({"piece": each.number}, each.assignment) for each in self.pieces]
        return [
            {**piece, "robots": robots, "tasks": tasks, "skill": skill, "count": count}
            for piece, assignment in parts or [({}, self.assignment)]
            for (robots, tasks, skill), count in assignment.items()
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return the verdict and its proof as nested dicts."""
        boxes = [{"piece": each.number, "x": each.x, "y": each.y} for each in self.pieces]
        where = {"pieces": boxes} if boxes else {}
        if self.violator is not None:
            piece = {} if self.piece is None else {"piece": self.piece}
            return {"feasible": False, "violator": self.violator._asdict(), **piece, **where}
        return {"feasible": True, "assignment": self.rows, **where}


def truth(scenario: Sections) -> bool:
    """Return the ground truth: whether the swarm can do all tasks at once, each robot in one place.

    Parameters
    ----------
    scenario : Scenario
        The scenario, of which only the numbers and classes of robots and tasks matter.

    Returns
    -------
    bool
        Without classes, whether there are at least as many robots as tasks (paper, section II).

    Examples
    --------
    >>> from feasibee import Scenario, truth
    >>> truth(Scenario(robots={"count": 20}, tasks={"count": 21}))
    False
    """
    return explain(scenario).feasible


def explain(scenario: Sections) -> Verdict:
    """Return the ground truth with its proof.

    Parameters
    ----------
    scenario : Scenario
        The scenario, of which only the numbers and classes of robots and tasks matter. All robots are at
        work: see ``who_counts``.

    Returns
    -------
    Verdict
        If the tasks are feasible, an assignment that fills every place. If not, the smallest set of skills
        whose demand exceeds its robots most; there is only one. Without classes, all robots are of the class
        ``"robots"`` and all tasks of the class ``"tasks"``, which needs `ANY`.

    References
    ----------
    Hall, "On representatives of subsets", J. London Math. Soc. 1935.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> from feasibee.scenario.feasibility import explain
    >>> tasks = {"classes": [{"name": "carry", "count": 3, "needs": {"lift": 2}}]}
    >>> robots = {"classes": [{"name": "arm", "count": 5, "skills": ["lift"]}]}
    >>> explain(Scenario(robots=robots, tasks=tasks)).violator
    Violator(skills=('lift',), demand=6, robots=5)
    """
    if not isinstance(scenario, Sections):
        raise FeasibeeError(f"scenario = {quoted(scenario)}: must be a Scenario; write Scenario(...)")
    ground = ground_of(scenario)
    if ground is None or ground.is_one:
        return _verdict(scenario.robots, scenario.tasks)
    return _verdict_by_piece(scenario, ground)


def in_brief(scenario: Sections) -> str:
    """Return in a few words why the tasks are feasible or infeasible."""
    verdict, robots, tasks = explain(scenario), scenario.robots.count, scenario.tasks.count
    violator, where = verdict.violator, f"{verdict.where}: " if verdict.where else ""
    if not (scenario.robots.classes or scenario.tasks.classes):
        if violator is not None and where:
            return f"{where}{violator.robots:,} of {robots:,} robots, {violator.demand:,} of {tasks:,} tasks"
        return f"{robots:,} robots, {tasks:,} tasks"
    if violator is None:
        return "robots for all tasks"
    return f"{where}{', '.join(violator.skills)}: {violator.demand} places, {violator.robots} robots"


def who_counts(scenario: Sections) -> str:
    """Return in words which robots the truth is about if some charge; an empty text if none does.

    Examples
    --------
    >>> from feasibee import Scenario
    >>> from feasibee.scenario.feasibility import who_counts
    >>> who_counts(Scenario(robots={"work": 300, "charge": 100}))
    'Robots that charge count: the truth is about all 20, of which 15 are at work on average.'
    """
    robots = scenario.robots
    if robots.work is None or robots.charge is None:
        return ""
    working = f"{robots.count * robots.work / (robots.work + robots.charge):.3g}"
    if robots.away == "counted":
        whom = f"count: the truth is about all {robots.count}, of which {working} are at work on average"
    else:
        whom = f"don't count: the truth is about those at work, on average {working} of {robots.count}"
    return f"Robots that charge {whom}."


def _verdict_by_piece(scenario: Sections, ground: Surface) -> Verdict:
    """Return the verdict about the first piece whose tasks are infeasible, or that all are feasible."""
    total: Counter[tuple[str, str, str]] = Counter()
    pieces = list[Piece]()
    kinds = [kinds_of(section) for section in (scenario.robots, scenario.tasks)]
    for piece in range(int(ground.pieces.max()) + 1):
        there = [np.flatnonzero(each.piece == piece) for each in (ground.robots, ground.tasks)]
        robots, tasks = ([own[i] for i in some] for own, some in zip(kinds, there, strict=True))
        found = explain_kinds(scenario, robots, tasks)
        if not found.feasible:
            return found._replace(piece=piece, pieces=(_piece(ground, piece, {}),) if piece else ())
        if found.assignment:
            pieces.append(_piece(ground, piece, found.assignment))
            total.update(found.assignment)
    return Verdict(total, None, pieces=tuple(pieces))


def _piece(ground: Surface, number: int, assignment: Mapping[tuple[str, str, str], int]) -> Piece:
    """Return a piece of a place, with the box around its cells."""
    cell, inside = ground.plan.cell, ground.pieces == number
    columns, rows = (np.flatnonzero(inside.any(axis=axis)) for axis in (0, 1))
    x, y = ((float(cell * int(each[0])), float(cell * int(each[-1] + 1))) for each in (columns, rows))
    return Piece(number, x, y, assignment)


def kinds_of(section: Robots | Tasks) -> list[int]:
    """Return the class of each robot or task of the start."""
    counts = [each.count for each in section.classes] or [section.count]
    return [kind for kind, count in enumerate(counts) for _ in range(count)]


def _verdict(some_robots: Robots, some_tasks: Tasks) -> Verdict:
    robots, tasks = _classes(some_robots, some_tasks)
    demand: Counter[str] = Counter()
    for each in tasks:
        demand.update({skill: each.count * needed for skill, needed in each.needs.items()})
    violator = _violator(robots, demand)
    if violator is not None:
        return Verdict({}, violator)
    return Verdict(_assignment(_serving(robots, demand), tasks), None)


def explain_kinds(scenario: Sections, robots: Iterable[int], tasks: Iterable[int]) -> Verdict:
    """Return the truth if there are robots and tasks of these classes, each class by its number."""
    return _verdict(_of_kinds(scenario.robots, robots), _of_kinds(scenario.tasks, tasks))


def _of_kinds(section: Any, kinds: Iterable[int]) -> Any:
    """Return a section with so many of each class, or so many in all if it has no classes."""
    counts = Counter(kinds)
    classes = [each.model_copy(update={"count": counts[k]}) for k, each in enumerate(section.classes)]
    return section.model_copy(update={"count": counts.total(), "classes": tuple(classes)})


# --- Robots that act ---


def ranks_of(robots: Robots) -> list[int]:
    """Return the rank of each class of robots: 1 for the most skilled (model.md 6.25.1)."""
    numbers = [len(set(each.skills)) for each in robots.classes] or [0]
    return [1 + len({each for each in numbers if each > own}) for own in numbers]


def can_do(robots: Robots, tasks: Tasks) -> list[list[bool]]:
    """Return for each class of robots whether it can do a task of each class (model.md 6.7)."""
    needs = [set(each.needs) for each in tasks.classes] or [set[str]()]
    skills = [set(each.skills) for each in robots.classes] or [set[str]()]
    return [[need <= own for need in needs] for own in skills]


def most_taken(scenario: Sections, robots: Iterable[int]) -> int:
    """Return how many tasks of the start robots of these classes can take at once.

    It follows from Hall's condition, with its defect.
    """
    violator = explain_kinds(scenario, robots, kinds_of(scenario.tasks)).violator
    return scenario.tasks.count - (violator.demand - violator.robots if violator else 0)


def status_bits(scenario: Sections) -> int:
    """Return the length of what a message says of a task's status (model.md 6.25.7)."""
    return max(ranks_of(scenario.robots)).bit_length() + 8 * scenario.may_come_free


# --- The computation ---


def _classes(some_robots: Robots, some_tasks: Tasks) -> tuple[Sequence[RobotClass], Sequence[TaskClass]]:
    """Return the classes of robots and tasks; without classes, all robots or tasks are one class."""
    # Not validated: two threads at once would spoil what pydantic builds for that at a class's first use.
    robots = some_robots.classes or (RobotClass.model_construct(name="robots", count=some_robots.count),)
    if some_tasks.classes:
        return robots, some_tasks.classes
    able = [each.model_copy(update={"skills": (ANY,)}) for each in robots]
    return able, [TaskClass.model_construct(name="tasks", count=some_tasks.count, needs={ANY: 1})]


def _violator(robots: Sequence[RobotClass], demand: Mapping[str, int]) -> Violator | None:
    """Return the set of skills whose demand exceeds its robots most; None if there is no excess."""
    worst = max(
        (
            Violator(
                skills,
                sum(demand[skill] for skill in skills),
                sum(each.count for each in robots if not set(skills).isdisjoint(each.skills)),
            )
            for size in range(len(demand) + 1)
            for skills in combinations(sorted(demand), size)
        ),
        key=lambda each: each.demand - each.robots,
    )  # the first of equals has the fewest skills; the empty set has excess 0
    return worst if worst.skills else None


def _serving(robots: Sequence[RobotClass], demand: Mapping[str, int]) -> dict[tuple[str, str], int]:
    """Return the number of robots per class and skill used: a maximum flow along shortest paths."""
    if len(demand) == 1:  # scipy takes 0.3 s to import
        [(skill, places)] = demand.items()
        able = [each for each in robots if skill in each.skills]
        before = accumulate((each.count for each in able), initial=0)
        return {
            (each.name, skill): min(each.count, max(places - others, 0))
            for each, others in zip(able, before, strict=False)
        }
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import maximum_flow

    skills = list(dict.fromkeys(skill for each in robots for skill in each.skills if skill in demand))
    first, sink = 1 + len(robots), 1 + len(robots) + len(skills)
    room = np.zeros((sink + 1, sink + 1), np.int32)
    room[0, 1:first] = [each.count for each in robots]
    room[first:sink, sink] = [demand[skill] for skill in skills]
    for number, each in enumerate(robots, start=1):
        room[number, first:sink] = [each.count * (skill in each.skills) for skill in skills]
    flow = maximum_flow(csr_array(room), 0, sink, method="edmonds_karp").flow.toarray()
    return {
        (each.name, skill): int(flow[number, first + place])
        for number, each in enumerate(robots, start=1)
        for place, skill in enumerate(skills)
    }


def _assignment(
    serving: dict[tuple[str, str], int], tasks: Sequence[TaskClass]
) -> dict[tuple[str, str, str], int]:
    """Assign the robots used for each skill to the classes of tasks that need it, in order."""
    assignment = {}
    left = dict(serving)
    for each in tasks:
        for skill, needed in each.needs.items():
            places = each.count * needed
            for robots, theirs in serving:
                taken = min(places, left[robots, theirs]) if theirs == skill else 0
                if taken:
                    assignment[robots, each.name, skill] = taken
                    left[robots, skill] -= taken
                    places -= taken
    return assignment
