"""The sections of a scenario, and their fields: types, defaults (the paper's), ranges and descriptions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, Final, Literal, get_args

from pydantic import AfterValidator, Field, Strict, WithJsonSchema
from pydantic_core import PydanticCustomError

from feasibee.scenario.bitmaps import ImageError, cells_of
from feasibee.scenario.types import (
    NO_UNIT,
    Angle,
    Bits,
    Deviation,
    Dimension,
    Duration,
    Faulty,
    Late,
    Length,
    Lie,
    Lifetime,
    Listen,
    ManyTasks,
    Million,
    Point,
    Points,
    Polygons,
    Quorum,
    Rate,
    Section,
    Share,
    Side,
    Sightings,
    Some,
    Speed,
    Start,
    Step,
    Steps,
    StrategyName,
    Wait,
    Word,
    Zone,
    without_default,
)

GATE: Final = 8
MERGED: Final = 3.75
"""In standard deviations: the gate by default, and by how much less two tasks under one name are apart.

Of 600 looks at two tasks farther apart, some miss the gate, and both have names: claims/measure/names.py.
"""


class NewSensing(Section):
    """What an event changes of `Sensing`."""

    miss: Share | None = Field(None, description="New value of sensing.miss; by default it stays.")


class NewRadio(Section):
    """What an event changes of `Radio`."""

    loss: Share | None = Field(None, description="New value of radio.loss; by default it stays.")


class Event(Section):
    """A change of the world at the beginning of a step (model.md 6.17)."""

    step: Step = Field(description="Step at whose beginning the world changes.")
    tasks: int = Field(
        0,
        ge=-10_000_000,
        le=10_000_000,
        description="Number of tasks that appear; negative: that vanish, drawn at random.",
    )
    robots: int = Field(
        0,
        ge=-1_000_000,
        le=1_000_000,
        description="Number of robots that join; negative: that leave for good, drawn at random.",
    )
    task: int | None = Field(
        None, ge=0, description="Number of the task that vanishes, or with at is put there."
    )
    robot: int | None = Field(
        None, ge=0, description="Number of the robot that leaves for good, or with at is put there."
    )
    at: Annotated[Point, Strict(False)] | None = Field(
        None,
        description="[x, y] in units: where the tasks appear, the robots join, or the one of that number "
        "is put; by default at random.",
    )
    sensing: NewSensing = Field(NewSensing(), description="New values of sensing.")
    radio: NewRadio = Field(NewRadio(), description="New values of radio.")

    @property
    def of_tasks(self) -> bool:
        """Whether a point is for tasks."""
        return self.tasks > 0 or self.task is not None

    def more(self, name: str) -> int:
        """Return by how many it changes the number of ``robots`` or ``tasks``."""
        named: int | None = getattr(self, name.removesuffix("s"))
        return int(getattr(self, name)) - (self.at is None and named is not None)


class Arena(Section):
    """The arena in which the robots move (model.md 1.1, 6.1)."""

    side: Side = Field(
        20.0, description="Side of the square arena in units; or [width, height] of a rectangle."
    )
    boundary: Literal["torus", "walls"] = Field(
        "torus",
        description="Edges of the arena: who leaves a torus enters at the opposite edge; walls stop robots.",
    )

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, in units."""
        return self.side if isinstance(self.side, tuple) else (self.side, self.side)


def _image(text: str) -> str:
    """Raise an error unless a text is an image of cells."""
    try:
        cells_of(text)
    except ImageError as error:
        raise PydanticCustomError("image", "{rule}", {"rule": str(error)}) from None
    return text


class Bitmap(Section):
    """A map of square cells, as an image (model.md 6.20)."""

    cell: Length = Field(description="Side of a cell, in units.")
    origin: Annotated[tuple[float, float], Strict(False)] = Field(
        (0.0, 0.0), description="Lower left corner in metres, as in files of polygons for this map."
    )
    image: Annotated[str, AfterValidator(_image)] = Field(
        description="PNG in base64, a pixel per cell: black cells are closed; the top row has the highest y.",
    )


Map = Annotated[Bitmap, WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "object"}]})]
"""A map; `Scenario` has already replaced the name of a file by its cells."""


class Place(Section):
    """The obstacles in the arena (model.md 6.20)."""

    map: Map | None = Field(
        None,
        description="Map of the walls: the YAML file of a ROS map, or a GeoJSON file of polygons in metres. "
        "It sets the size of the arena.",
    )
    walls: Polygons = Field((), description="Walls in addition: polygons of points [x, y], in units.")
    keepout: Map | None = Field(
        None, description="Map of cells that robots must not enter but see across, in the same formats."
    )
    cell: Length = Field(0.1, description="Side of a cell, in units, if place.map doesn't set it.")
    zones: dict[Word, Zone] = Field(
        default_factory=dict,
        description="Zones by name for robots.zone and tasks.zone: polygons in units, or GeoJSON files.",
        examples=[{"dock": [[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]]}],
    )

    @property
    def exists(self) -> bool:
        """Whether the arena has cells."""
        return bool(self.map or self.walls or self.keepout or self.zones)

    @property
    def hides(self) -> bool:
        """Whether there are walls that hide things."""
        return bool(self.map or self.walls)


class Placed(Section):
    """The initial positions of robots or tasks (model.md 6.4)."""

    placement: Literal["uniform", "clusters", "points"] = Field(
        "uniform",
        description="Initial positions: uniform over the arena, around random centres (clusters), or at "
        "given points.",
    )
    clusters: int = Field(
        3, ge=1, le=1000, description='Number of random centres, with placement "clusters".'
    )
    spread: Length = Field(1.5, description="Standard deviation around a centre, in units, per axis.")
    zone: Word | None = Field(
        None,
        description="Name of the zone of place.zones for initial positions; by default all passable cells.",
        examples=["dock"],
    )
    points: Points = Field(
        (),
        description='Initial positions in units, with placement "points": a CSV file of x and y, or a list '
        "of [x, y].",
        examples=[[[5.0, 2.5], [15.0, 7.5]]],
    )


class RobotClass(Section):
    """A class of robots with the same skills (model.md 6.7)."""

    name: Word = Field(description="Name of the class of robots, unique among them.")
    count: Million = Field(description="Number of robots of this class.")
    skills: Annotated[tuple[Word, ...], Strict(False)] = Field(
        (), description="Skills that each robot of this class has."
    )


class TaskClass(Section):
    """A class of tasks that need the same skills (model.md 6.7)."""

    name: Word = Field(description="Name of the class of tasks, unique among them.")
    count: ManyTasks = Field(description="Number of tasks of this class.")
    needs: dict[Word, Annotated[int, Field(ge=1, le=1000)]] = Field(
        min_length=1, description="Number of robots with each skill that one task of this class needs."
    )


class Robots(Placed):
    """The robots of the swarm (model.md 1.2, 6.2, 6.7)."""

    count: Some = Field(20, description="Number of robots, n.")
    speed: Speed = Field(1.0, description="Speed of a moving robot, in units per step.")
    diameter: Length = Field(1.0, description="Diameter of a robot's disc, in units.")
    avoid_collisions: bool = Field(
        False, description="Whether a robot stays where it is rather than overlap another robot."
    )
    contact: Literal["stand", "deflect"] = Field(
        "stand", description="Whether a blocked robot stands still, or turns away by 45 or 90° and goes on."
    )
    know_count: bool = Field(
        False, description="Whether each robot knows the number of robots, for strategies that use it."
    )
    classes: Annotated[tuple[RobotClass, ...], Strict(False), Field(max_length=16)] = Field(
        (),
        description="Classes of robots with different skills, instead of robots.count.",
        examples=[[{"name": "arm", "count": 20, "skills": ["lift"]}]],
    )
    arrival_rate: Rate | None = Field(
        None, description="Mean number of robots that join per step; by default none join.", examples=[0.01]
    )
    failure_rate: Rate | None = Field(
        None,
        description="Rate per step at which each robot fails and leaves for good; by default none fails.",
        examples=[0.001],
    )
    most: Some | None = Field(
        None,
        description="Most robots at a time, beyond which none joins; by default as many as events bring, or "
        "twice as many as at the start.",
        examples=[40],
    )
    work: Steps | None = Field(
        None,
        description="Steps that a robot works before it charges, away from the arena; by default it never "
        "does. Each first battery lasts 1 to so many steps.",
        examples=[3000],
    )
    charge: Steps | None = Field(
        None, description="Steps that a robot charges, before it comes back to robots.zone.", examples=[600]
    )
    away: Literal["counted", "missing"] = Field(
        "counted",
        description="Whether robots that charge count for the truth and keep their vote, or the truth is "
        "that of the robots at work.",
    )


class Tasks(Placed):
    """The tasks that the swarm must judge (model.md 1.3, 6.7)."""

    count: ManyTasks = Field(
        20, description="Number of tasks, m; each needs one robot, and any robot can do it."
    )
    classes: Annotated[tuple[TaskClass, ...], Strict(False), Field(max_length=16)] = Field(
        (),
        description="Classes of tasks that need different skills, instead of tasks.count.",
        examples=[[{"name": "carry", "count": 10, "needs": {"lift": 2}}]],
    )
    arrival_rate: Rate | None = Field(
        None,
        description="Mean number of tasks that appear per step; by default none appear.",
        examples=[0.01],
    )
    lifetime: Lifetime | None = Field(
        None,
        description="Mean steps until a task is finished and vanishes; by default tasks stay.",
        examples=[500.0],
    )
    work: Steps | None = Field(
        None,
        description="Steps that a robot that acts works at a task before it goes on; by default it stays.",
        examples=[50],
    )


class Walk(Section):
    """The random walk of the robots (model.md 2)."""

    mean_run: Duration = Field(
        10.0,
        description="Mean duration of a straight walk between two turns, in steps, rounded up: sigma.",
    )


class Sensing(Section):
    """The observation of robots and tasks (model.md 1.4, 4.2, 6.3)."""

    range: Length = Field(2.0, description="Range of observation d, in units, from centre to centre.")
    observation: Literal["repeated", "unique"] = Field(
        "repeated",
        description="Whether a robot counts each robot or task in range in every step (repeated), or once "
        "in an exploration (unique).",
    )
    count_self: bool = Field(False, description="Whether a robot counts itself, once per step.")
    miss: Share = Field(
        0.0, description="Probability that a robot misses a robot or task in range in a step."
    )
    false_robots: Sightings = Field(
        0.0, description="Mean number of robots that an exploring robot sees falsely, per step."
    )
    false_tasks: Sightings = Field(
        0.0, description="Mean number of tasks that an exploring robot sees falsely, per step."
    )
    misname: Share = Field(
        0.0, description="Probability that a robot gives a task in sight a wrong name in a step."
    )
    position_error: Deviation = Field(
        0.0, description="Standard deviation of a task's position as a robot sees it, in units, per axis."
    )
    gate: Length | None = Field(
        None,
        description="Distance up to which robots take two positions for one task, in units; by default 8 "
        "times position_error.",
        examples=[0.4],
    )
    view: Angle = Field(
        360.0, description="Angle of view in degrees, half of it on either side of the robot's heading."
    )

    @property
    def swept(self) -> float:
        """Half the width of the strip that a moving robot sees, in units: with a wide view, the range."""
        narrow = math.sin(math.radians(self.view / 2)) if self.view < 180 else 1.0
        return self.range if narrow == 1 else round(self.range * narrow, 9)

    @property
    def gated(self) -> float:
        """Distance up to which robots take two positions for one task, in units (model.md 6.24)."""
        return round(GATE * self.position_error, 9) if self.gate is None else self.gate

    @property
    def merged(self) -> float:
        """Largest distance of two tasks under one name, in units; below 0 without position errors."""
        return round(self.gated - MERGED * self.position_error, 9) if self.position_error else -1.0

    @property
    def wrong(self) -> float:
        """Probability that a robot gives a task in sight a wrong name in a step, by either error."""
        if not self.position_error:
            return self.misname
        beyond = math.exp(-((self.gated / self.position_error / 2) ** 2))
        return float(f"{self.misname + (1 - self.misname) * beyond:.9g}")


class Radio(Section):
    """The communication between robots (model.md 1.4, 6.5)."""

    range: Length = Field(
        default=None,  # type: ignore[assignment]  # resolved by Scenario
        description="Range of a broadcast, in units; by default sensing.range.",
        json_schema_extra=without_default,
    )
    loss: Share = Field(0.0, description="Probability that a robot in range misses a message.")
    delay: Late = Field(
        0, description="Steps by which messages are late: a robot broadcasts what it would have said then."
    )
    walls: Share = Field(
        0.0, description="Factor by which each wall on the way shortens the range: 0 blocks, 1 lets pass."
    )
    id_bits: Bits | None = Field(
        None,
        description="Length in bits of robots' random ids, which may collide; by default each id is unique.",
        examples=[8],
    )


class Declare(Section):
    """When a robot declares its opinion, because those whom it hears hold it, too (model.md 6.14)."""

    quorum: Quorum = Field(
        0.9, description="Least share of a robot's inbox that must agree with its decision."
    )
    rounds: Some = Field(3, description="Number of consecutive decisions that must reach the quorum.")
    heard: Some = Field(3, description="Least number of messages in the inbox at each of these decisions.")


class Decision(Section):
    """The controller of a robot: explore, disseminate, decide (model.md 4)."""

    strategy: StrategyName = Field(
        "dmmd",
        description="Strategy that rates and chooses opinions: its name, or the path of a .py file.",
    )
    parameters: dict[Word, float] = Field(
        default_factory=dict,
        description="Parameters of the strategy by name, if it has any.",
        examples=[{"k": 3.0}],
    )
    exploration: Duration = Field(
        10.0,
        description="Mean duration of an exploration, in steps, before it is rounded up: 10 gives 10.51.",
    )
    gain: Duration = Field(
        10.0,
        description="Mean duration of a dissemination of quality 1, in steps, before it is rounded up: g. "
        "With 10, quality 0.9 lasts 6.0 times as long as 0.1, not 9 times.",
    )
    dissemination_floor: Wait = Field(
        0, description="Number of steps added to the duration of each dissemination."
    )
    quality_floor: Million = Field(
        0, description="Least value of each of the two counts when a robot rates the quality."
    )
    listen: Listen = Field(
        "always",
        description="When a robot receives messages: always, during dissemination, or with {last = 3} in its "
        "last 3 steps.",
    )
    inbox: Literal["latest-per-robot", "every-message"] = Field(
        "latest-per-robot",
        description="Whether the inbox keeps only the latest message of each robot, or every message.",
    )
    inbox_size: Some | None = Field(
        None,
        description="Number of robots whose messages the inbox keeps, the newest; by default all.",
        examples=[8],
    )
    own_vote: bool = Field(True, description="Whether a robot counts its own opinion in the majority.")
    ties: Literal["keep", "random-message"] = Field(
        "keep",
        description="What a robot does with a tie in the majority: keep its opinion, or adopt that of one "
        "message, drawn at random from its inbox.",
    )
    start: Literal["coin", "first-sight"] = Field(
        "coin",
        description="First opinion of a robot: a fair coin, or the one that its counts favour when its first "
        "exploration ends. With a tie it keeps the coin.",
    )
    declare: Declare | None = Field(
        None,
        description="Rule by which a robot declares its opinion, if its strategy doesn't define `declare`; "
        "by default none does.",
        examples=[{"quorum": 0.9, "rounds": 3, "heard": 3}],
    )
    threshold: float = Field(
        0.9,
        ge=0.5,
        lt=1,
        description="Share of the swarm: it has decided when more than this share has the same opinion.",
    )


class Faults(Section):
    """The faults of robots (model.md 6.6); each run draws which robots are faulty."""

    stopped: Faulty = Field(
        0.0,
        description="Share of robots that stop moving, observing and sending, or {count = 1} for one robot.",
    )
    stop_step: Step = Field(0, description="First step at which the stopped robots are stopped.")
    byzantine: Faulty = Field(
        0.0,
        description="Share of robots that broadcast false opinions, or {count = 1} for one robot.",
    )
    byzantine_says: Lie = Field(
        "opposite",
        description="Opinion that Byzantine robots broadcast: the opposite of their own, always the same, "
        "random, or, colluding, all the opposite of the truth in every step.",
    )
    stubborn: Faulty = Field(
        0.0,
        description="Share of robots that never change their opinion, or {count = 1} for one robot.",
    )


class Run(Section):
    """The length of a run (model.md 4.7)."""

    steps: Steps = Field(
        1000, description="Number of steps of a run; a swarm that has not decided by then is undecided."
    )
    stop_at_decision: bool = Field(False, description="Whether a run ends at the swarm's first decision.")
    stop_at_declarations: bool = Field(
        False, description="Whether a run ends once all counted robots have declared (model.md 6.15.8)."
    )
    stop_when_taken: bool = Field(
        False, description="Whether a run ends once all tasks are taken (model.md 6.25.14)."
    )


class Acting(Section):
    """Robots that go to tasks and do them (model.md 6.25)."""

    start: Start | None = Field(
        None,
        description="Step from which on robots act; or, once they know most tasks (search), surely all "
        "(safe), or have declared feasible (declared). By default they never act.",
        examples=[40],
    )
    choose: Literal["nearest", "rank"] = Field(
        "nearest",
        description="Which task a robot goes to: the nearest that it knows to be free, or, for robot i, the "
        "i-th that it knows.",
    )
    hold: Literal["stand", "tag"] = Field(
        "stand",
        description="Whether robots only walk about before they act, or mark the first free task that they "
        "reach, walk on, and come back.",
    )
    reach: Length = Field(1.0, description="Distance at which a robot has reached its task, in units.")


class Units(Section):
    """The size of a unit and of a step, for axes and reports. They change no run, and no hash."""

    metres: float | None = Field(None, ge=1e-9, le=1e9, description="Metres per unit.", examples=[0.5])
    seconds: float | None = Field(None, ge=1e-9, le=1e9, description="Seconds per step.", examples=[1.0])


SECTIONS: Final[Mapping[str, type[Section]]] = {
    "arena": Arena,
    "place": Place,
    "robots": Robots,
    "tasks": Tasks,
    "walk": Walk,
    "sensing": Sensing,
    "radio": Radio,
    "decision": Decision,
    "faults": Faults,
    "run": Run,
    "acting": Acting,
    "units": Units,
}
"""The sections of a scenario by name, in the order of its complete form."""


def fields() -> list[str]:
    """Return the dotted paths of all fields of a scenario."""
    return [f"{name}.{key}" for name, section in SECTIONS.items() for key in section.model_fields]


@cache
def dimensions(section: type[Section]) -> dict[str, Dimension]:
    """Return the dimensions of the fields of a section that have one."""
    found = {key: _within(each.annotation, *each.metadata) for key, each in section.model_fields.items()}
    return {key: each for key, each in found.items() if each}


def _within(*types: Any) -> Dimension | None:
    """Return the first dimension within types, if any."""
    found = (each if isinstance(each, Dimension) else _within(*get_args(each)) for each in types)
    return next(filter(None, found), None)


def dimension_of(path: str) -> Dimension:
    """Return the dimension of the field at a dotted path, such as `LENGTH`, or `NO_UNIT`."""
    name, _, key = path.partition(".")
    section = Event if name == "events" else SECTIONS.get(name, Section)
    return dimensions(section).get(key.partition(".")[2] if name == "events" else key, NO_UNIT)
