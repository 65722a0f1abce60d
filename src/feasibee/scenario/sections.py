"""All sections of a scenario together, and the numbers that follow from several of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from fractions import Fraction
from typing import Annotated, Any, Final, Literal, NamedTuple

from pydantic import BaseModel, Field, PrivateAttr, Strict

from feasibee.base.codes import exact
from feasibee.scenario import fields
from feasibee.scenario.fields import SECTIONS, STRICT, Bitmap, Event, Robots, Tasks
from feasibee.scenario.ground import Plan, ground_of, plan_of, size_of
from feasibee.scenario.plugins import reads_flooding
from feasibee.scenario.setting import setting_from
from feasibee.scenario.tables import PRESETS
from feasibee.strategies.certified import NEVER, sightings_to_flood, steps_for
from feasibee.strategies.contract import Manifest, Setting

KINDS: Final = ("stopped", "byzantine", "stubborn")
"""The faults of which a robot has one at most, in the order in which faulty robots are drawn."""
TWICE: Final = 2
"""Largest number of robots, in units of those at the start, if robots join by rate."""


class Most(NamedTuple):
    """How many robots and tasks of a scenario have numbers."""

    robots: int
    """Robots that may be there at a time (model.md 6.17.6)."""
    tasks: int
    """Tasks that may appear in a run (model.md 6.17.4)."""


class Sections(BaseModel):
    """The sections of a scenario, each validated by itself."""

    model_config = STRICT

    preset: Literal[*PRESETS] | None = Field(  # type: ignore[valid-type]
        None,
        exclude=True,
        description="Name of a published controller, whose values replace the paper's defaults.",
    )
    arena: fields.Arena = fields.Arena()
    place: fields.Place = fields.Place()
    robots: Robots = Robots()
    tasks: Tasks = Tasks()
    walk: fields.Walk = fields.Walk()
    sensing: fields.Sensing = fields.Sensing()
    radio: fields.Radio = Field(default_factory=fields.Radio)  # no default: it depends on sensing
    decision: fields.Decision = fields.Decision()
    faults: fields.Faults = fields.Faults()
    run: fields.Run = fields.Run()
    acting: fields.Acting = fields.Acting()
    units: fields.Units = fields.Units()
    events: Annotated[tuple[Event, ...], Strict(False), Field(max_length=1000)] = Field(
        (), description="Changes of the world at given steps (model.md 6.17)."
    )
    _manifest: Manifest = PrivateAttr()

    def resolve(self, wrong: set[tuple[Any, ...]], find: Callable[[str], Manifest]) -> None:
        """Fill in values that follow from other fields, without marking them as set.

        Wrong fields are taken out, and so is what follows from them: reading one is an AttributeError.
        """
        values = vars(self)
        values["preset"] = None  # its values are filled in: the scenario is the same without the name
        for name, *key in wrong:
            if name in SECTIONS and key:
                values[name] = values[name].model_copy()
                vars(values[name]).pop(key[0], None)
            else:
                values.pop(name, None)
        with suppress(AttributeError):
            self._manifest = find(self.decision.strategy)
        self._follow("arena", "side", lambda: self._of_map("side", size_of))
        self._follow("arena", "boundary", lambda: self._of_map("boundary", lambda _: "walls"))
        self._follow("radio", "range", lambda: self.radio.range or self.sensing.range)
        self._follow("decision", "parameters", self._parameters)
        self._follow("robots", "count", lambda: _count(self.robots))
        self._follow("tasks", "count", lambda: _count(self.tasks))

    def _follow(self, name: str, key: str, found: Callable[[], Any]) -> None:
        """Replace a value by what follows from other fields; take it out if one of them is."""
        section = vars(self).get(name)
        if section is None or key not in vars(section):
            return
        vars(self)[name] = copied = section.model_copy()
        try:
            vars(copied)[key] = found()
        except AttributeError:
            del vars(copied)[key]

    def _of_map(self, key: str, found: Callable[[Bitmap], Any]) -> Any:
        """Return a field of the arena that a map sets unless it is given."""
        plan = self.place.map
        return found(plan) if plan and key not in self.arena.model_fields_set else getattr(self.arena, key)

    def _parameters(self) -> dict[str, float]:
        every = {**self.manifest.parameters, **self.decision.parameters}
        return {name: float(value) for name, value in every.items()}

    @property
    def manifest(self) -> Manifest:
        """Declarations of the strategy; of a user's file, as it was when the scenario was made."""
        return self._manifest

    @property
    def plan(self) -> Plan | None:
        """The cells of its place, if it has one (model.md 6.20)."""
        return plan_of(self.place, self.arena.size)

    @property
    def flooding(self) -> int | None:
        """Step by which names flood its place; `NEVER` if they take too long, None if it isn't known.

        `feasibee.simulation.flooding` computes it.
        """
        found: int | None = self.__dict__.get("_flooding")
        return found

    @property
    def waits_for_names(self) -> bool:
        """Whether its robots wait for a time that follows from how soon names flood its place."""
        if not self.place.exists:
            return False
        given = not self.manifest.source and self.decision.parameters.get("quiet", 0.0) > 0
        return self.acting.start in ("search", "safe") or (reads_flooding(self.manifest) and not given)

    @property
    def faulty(self) -> tuple[int, int, int]:
        """Number of stopped, of Byzantine and of stubborn robots (model.md 6.6)."""
        stopped, byzantine, stubborn = (
            whole_robots(getattr(self.faults, kind), self.robots.count) for kind in KINDS
        )
        return stopped, byzantine, stubborn

    @property
    def acts(self) -> bool:
        """Whether robots go to tasks and do them (model.md 6.25)."""
        return self.acting.start is not None

    @property
    def acts_from(self) -> int:
        """Step from which on robots act that haven't declared infeasible; `NEVER` if they must declare."""
        start, robots = self.acting.start, self.robots.count
        if not isinstance(start, str):
            return NEVER if start is None else start
        if start == "declared":
            return NEVER
        flooding: float = sightings_to_flood(robots)
        sightings = flooding if start == "safe" else math.log(robots) + 1
        steps: int = steps_for(sightings, robots, self.setting)
        return steps

    @property
    def may_come_free(self) -> bool:
        """Whether a taken task may come free again, or be done (model.md 6.25.5, 6.25.7)."""
        return self.dynamic or self.faulty[0] > 0 or self.tasks.work is not None

    @property
    def dynamic(self) -> bool:
        """Whether its world may change (model.md 6.17)."""
        robots, tasks = self.robots, self.tasks
        streams = robots.arrival_rate, robots.failure_rate, tasks.arrival_rate, tasks.lifetime
        go_missing = robots.work is not None and robots.away == "missing"
        return bool(self.events) or any(streams) or go_missing

    @property
    def in_motion(self) -> bool:
        """Whether robots or tasks may come or go; the truth stays if they only charge (model.md 6.23)."""
        return self.dynamic or self.robots.work is not None

    @property
    def puts(self) -> bool:
        """Whether an event says where robots or tasks are (model.md 6.17.12)."""
        return any(each.at for each in self.events)

    @property
    def most(self) -> Most:
        """How many robots there may be at a time, and how many tasks may appear in a run."""
        robots, tasks = self.robots, self.tasks
        if not self.dynamic:
            return Most(robots.count, tasks.count)
        most = robots.most
        if most is None:
            most = robots.count + sum(max(0, each.robots) for each in self.events)
            if robots.arrival_rate:
                most = max(most, TWICE * robots.count)
        appearing = sum(max(0, each.tasks) for each in self.events)
        streaming = surely_above((tasks.arrival_rate or 0.0) * self.run.steps)
        return Most(max(most, robots.count), tasks.count + appearing + streaming)

    @property
    def setting(self) -> Setting:
        """Numbers that a strategy's knowledge may depend on."""
        return setting_from(
            self.most,
            (len(self.robots.classes), len(self.tasks.classes)),
            self.faulty[1] > 0,
            self.radio.id_bits,
            self.decision.parameters.values(),
            misnames=self.sensing.wrong > 0,
            size=self.arena.size,
            count=self.robots.count,
            knows_count=self.robots.know_count,
            colluding=self.faults.byzantine_says == "colluding",
            walled=self.arena.boundary == "walls",
            sight=self.sensing.swept,
            radio=self.radio.range,
            speed=self.robots.speed,
            exploration=self.decision.exploration,
            dissemination=self.decision.gain + self.decision.dissemination_floor,
            mean_run=self.walk.mean_run,
            flooding=float(self.flooding or NEVER) if self.place.exists else 0.0,
            delay=float(self.radio.delay),
            **self._plan,
            work=float(self.robots.work or 0) if self.robots.away == "counted" else 0.0,
            charge=float(self.robots.charge or 0) if self.robots.away == "counted" else 0.0,
        )

    @property
    def _plan(self) -> dict[str, Any]:
        """What robots know of the plan of their place, as `Setting` has it."""
        ground = ground_of(self) if self.manifest.reads_plan and self.place.hides else None
        if ground is None:
            return {}
        return {"plan": ground.sketch, "columns": ground.pieces.shape[1]}


def _count(section: Robots | Tasks) -> int:
    """Return the number of robots or tasks, which classes or points may imply."""
    if section.classes:
        return sum(each.count for each in section.classes)
    counted = "count" in section.model_fields_set or section.placement != "points"
    return section.count if counted else len(section.points)


def whole_robots(faulty: float | Mapping[str, int], robots: int) -> int:
    """Return a count, or a share of the swarm as a number of robots, with halves rounded up (model.md 6.6).

    Examples
    --------
    >>> from feasibee.scenario.sections import whole_robots
    >>> whole_robots(0.1, 5), whole_robots({"count": 1}, 5)
    (1, 1)
    """
    if isinstance(faulty, Mapping):
        return faulty["count"]
    return math.floor(exact(faulty) * robots + Fraction(1, 2)) if faulty else 0  # exact fractions are slow


def surely_above(mean: float) -> int:
    """Return a number that a Poisson number of this mean exceeds with a probability below 1e-12."""
    return math.ceil(mean + 8 * math.sqrt(mean) + 16) if mean > 0 else 0
