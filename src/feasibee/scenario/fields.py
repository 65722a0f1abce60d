"""The fields of a scenario, by section: types, units, bounds, defaults (the paper's) and descriptions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import Annotated, Any, Final, Literal, LiteralString, get_args
from unicodedata import category

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    Strict,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from feasibee.base.codes import exact
from feasibee.base.errors import FeasibeeError
from feasibee.scenario.cells import ImageError, cells_of
from feasibee.scenario.dimensions import DURATION, LENGTH, NO_UNIT, RATE, SPEED, TIME, Dimension
from feasibee.scenario.plugins import manifest_of, registered
from feasibee.strategies import STRATEGIES

STRICT: Final = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class Section(BaseModel):
    """A section of a scenario: immutable, without unknown keys, silent conversions or NaN."""

    model_config = ConfigDict(
        **STRICT,
        use_attribute_docstrings=True,
        defer_build=True,  # until the descriptions are on one line
    )

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Write each field's description, which is its docstring, on one line."""
        for field in cls.model_fields.values():
            field.description = " ".join((field.description or "").split())

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, given: Any) -> Any:
        return plain(given) if isinstance(given, Mapping) else given


def plain(table: Mapping[Any, Any]) -> dict[Any, Any]:
    """Convert numpy's numbers and arrays to Python's: values of a sweep often come from an array."""
    return {key: _plain(value) for key, value in table.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return plain(value)
    if not hasattr(value, "dtype"):
        return value
    if getattr(value, "shape", None) == ():
        return value.item()
    return value.tolist() if hasattr(value, "tolist") else value


def _without_minus(value: float) -> float:
    """Return 0.0 for -0.0, so that equal scenarios have equal texts and hashes."""
    return value + 0.0


def _must(rule: LiteralString, holds: Callable[[Any], bool]) -> AfterValidator:
    """Return a validator that raises an error unless a condition holds."""

    def validate(value: Any) -> Any:
        if not holds(value):
            raise PydanticCustomError("rule", rule)
        return value

    return AfterValidator(validate)


def _known_strategy(name: str, info: ValidationInfo) -> str:
    """Raise an error unless a strategy of this name exists and its file declares what it must."""
    if any(category(each) == "Cc" for each in name):
        raise PydanticCustomError("strategy", "must be a name without control characters")
    try:
        manifest_of(name, **(info.context or {}))
    except FeasibeeError as error:
        known = [*STRATEGIES, *registered()]
        found = name.endswith(".py") or name in known
        rule = str(error) if found else f"must be the path of a .py file, or one of {', '.join(known)}"
        raise PydanticCustomError("strategy", "{rule}", {"rule": rule}) from None
    return name


def _one_rule(kind: LiteralString, rule: LiteralString) -> WrapValidator:
    """Return a validator that raises one error in place of those about each type of a union."""

    def validate(value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
        try:
            return handler(value)
        except ValidationError:
            raise PydanticCustomError(kind, rule) from None

    return WrapValidator(validate)


def _polygons(value: Any) -> Any:
    """Return a zone of one polygon as a list of polygons."""
    is_one = isinstance(value, list | tuple) and value and isinstance(value[0], list | tuple) and value[0]
    return [value] if is_one and isinstance(value[0][0], int | float) else value


def without_default(schema: dict[str, Any]) -> None:
    """Remove a default that depends on another field from the JSON Schema."""
    schema.pop("default", None)


Million = Annotated[int, Field(ge=0, le=1_000_000)]
Some = Annotated[int, Field(ge=1, le=1_000_000)]
ManyTasks = Annotated[int, Field(ge=0, le=10_000_000)]
Step = Annotated[int, Field(ge=0, le=1_000_000_000), TIME]
Steps = Annotated[int, Field(ge=1, le=1_000_000_000), TIME]
Length = Annotated[float, Field(gt=0, le=1e6), LENGTH]
Duration = Annotated[float, Field(gt=0, le=1e6), DURATION]
Share = Annotated[float, Field(ge=0, le=1), AfterValidator(_without_minus)]
Sightings = Annotated[float, Field(ge=0, le=50), AfterValidator(_without_minus), RATE]
Rate = Annotated[
    float,
    Field(ge=0, le=10),
    AfterValidator(_without_minus),
    _must("must be 0, or at least 1e-9 per step", lambda rate: not 0 < rate < 1e-9),
    RATE,
]
"""A rate whose mean time isn't longer than any run."""
Word = Annotated[
    str, Field(min_length=1, max_length=40), _must("must contain printable characters only", str.isprintable)
]
Point = tuple[Annotated[float, LENGTH], Annotated[float, LENGTH]]
Side = Annotated[
    Length | Annotated[tuple[Length, Length], Strict(False)],
    _one_rule("side", "must be > 0 and ≤ 1000000, or two such numbers [width, height]"),
]
Listen = Annotated[
    Literal["always", "dissemination"] | Annotated[dict[Literal["last"], Some], Field(min_length=1)],
    _one_rule(
        "listen", "must be 'always', 'dissemination', or {last = 3} for the last 3 steps of dissemination"
    ),
]
Start = Annotated[
    Step | Literal["declared", "search", "safe"],
    _one_rule("start", "must be a step, or 'declared', 'search' or 'safe'"),
    TIME,
]
Faulty = Annotated[
    Annotated[float, Field(ge=0, lt=1), AfterValidator(_without_minus)]
    | Annotated[dict[Literal["count"], Million], Field(min_length=1)],
    _one_rule("faulty", "must be a share of the robots, a finite number ≥ 0 and < 1, or a count of them"),
]
"""A share of the robots, or ``{count = robots}``; 1 could be meant as either, and is neither."""
Points = Annotated[
    tuple[Annotated[Point, Strict(False)], ...],
    Strict(False),
    _one_rule("points", "must be the name of a CSV file, or pairs of numbers [x, y]"),
    WithJsonSchema({"anyOf": [{"type": "string"}, TypeAdapter(tuple[Point, ...]).json_schema()]}),
]
"""Pairs of numbers; `Scenario` has already replaced the name of a file by its points."""


Polygon = Annotated[tuple[Annotated[Point, Strict(False)], ...], Strict(False), Field(min_length=3)]
Polygons = Annotated[
    tuple[Polygon, ...],
    Strict(False),
    _one_rule("polygons", "must be a list of polygons, each a list of 3 or more points [x, y]"),
]
Zone = Annotated[
    Polygons, BeforeValidator(_polygons), WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "array"}]})
]
"""Polygons, or one of them; `Scenario` has already replaced the name of a file by its polygons."""

# --- The sections ---

GATE: Final = 8
MERGED: Final = 3.75
"""In standard deviations: the gate by default, and by how much less two tasks under one name are apart.

Of 600 looks at two tasks farther apart, some miss the gate, and both have names: research/README.md.
"""


class NewSensing(Section):
    """What an event changes of `Sensing`."""

    miss: Share | None = None
    """New value of sensing.miss; by default it stays."""


class NewRadio(Section):
    """What an event changes of `Radio`."""

    loss: Share | None = None
    """New value of radio.loss; by default it stays."""


class Event(Section):
    """A change of the world at the beginning of a step (model.md 6.17)."""

    step: Step
    """Step at whose beginning the world changes."""
    tasks: int = Field(0, ge=-10_000_000, le=10_000_000)
    """Number of tasks that appear; negative: that vanish, drawn at random."""
    robots: int = Field(0, ge=-1_000_000, le=1_000_000)
    """Number of robots that join; negative: that leave for good, drawn at random."""
    task: int | None = Field(None, ge=0)
    """Number of the task that vanishes, or with at is put there."""
    robot: int | None = Field(None, ge=0)
    """Number of the robot that leaves for good, or with at is put there."""
    at: Annotated[Point, Strict(False)] | None = None
    """[x, y] in units: where the tasks appear, the robots join, or the one of that number is put; by default
    at random."""
    sensing: NewSensing = NewSensing()
    """New values of sensing."""
    radio: NewRadio = NewRadio()
    """New values of radio."""

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

    side: Side = 20.0
    """Side of the square arena in units; or [width, height] of a rectangle."""
    boundary: Literal["torus", "walls"] = "torus"
    """Edges of the arena: who leaves a torus enters at the opposite edge; walls stop robots."""

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

    cell: Length
    """Side of a cell, in units."""
    origin: Annotated[tuple[float, float], Strict(False)] = (0.0, 0.0)
    """Lower left corner in metres, as in files of polygons for this map."""
    image: Annotated[str, AfterValidator(_image)]
    """PNG in base64, a pixel per cell: black cells are closed; the top row has the highest y."""


Map = Annotated[Bitmap, WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "object"}]})]
"""A map; `Scenario` has already replaced the name of a file by its cells."""


class Place(Section):
    """The obstacles in the arena (model.md 6.20)."""

    map: Map | None = None
    """Map of the walls: the YAML file of a ROS map, or a GeoJSON file of polygons in metres. It sets the size
    of the arena."""
    walls: Polygons = ()
    """Walls in addition: polygons of points [x, y], in units."""
    keepout: Map | None = None
    """Map of cells that robots must not enter but see across, in the same formats."""
    cell: Length = 0.1
    """Side of a cell, in units, if place.map doesn't set it."""
    zones: dict[Word, Zone] = Field(
        default_factory=dict, examples=[{"dock": [[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]]}]
    )
    """Zones by name for robots.zone and tasks.zone: polygons in units, or GeoJSON files."""

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

    placement: Literal["uniform", "clusters", "points"] = "uniform"
    """Initial positions: uniform over the arena, around random centres (clusters), or at given points."""
    clusters: int = Field(3, ge=1, le=1000)
    """Number of random centres, with placement "clusters"."""
    spread: Length = 1.5
    """Standard deviation around a centre, in units, per axis."""
    zone: Word | None = Field(None, examples=["dock"])
    """Name of the zone of place.zones for initial positions; by default all passable cells."""
    points: Points = Field((), examples=[[[5.0, 2.5], [15.0, 7.5]]])
    """Initial positions in units, with placement "points": a CSV file of x and y, or a list of [x, y]."""


class RobotClass(Section):
    """A class of robots with the same skills (model.md 6.7)."""

    name: Word
    """Name of the class of robots, unique among them."""
    count: Million
    """Number of robots of this class."""
    skills: Annotated[tuple[Word, ...], Strict(False)] = ()
    """Skills that each robot of this class has."""


class TaskClass(Section):
    """A class of tasks that need the same skills (model.md 6.7)."""

    name: Word
    """Name of the class of tasks, unique among them."""
    count: ManyTasks
    """Number of tasks of this class."""
    needs: dict[Word, Annotated[int, Field(ge=1, le=1000)]] = Field(min_length=1)
    """Number of robots with each skill that one task of this class needs."""


class Robots(Placed):
    """The robots of the swarm (model.md 1.2, 6.2, 6.7)."""

    count: Some = 20
    """Number of robots, n."""
    speed: Annotated[float, Field(ge=0, le=1e6), AfterValidator(_without_minus), SPEED] = 1.0
    """Speed of a moving robot, in units per step."""
    diameter: Length = 1.0
    """Diameter of a robot's disc, in units."""
    avoid_collisions: bool = False
    """Whether a robot stays where it is rather than overlap another robot."""
    contact: Literal["stand", "deflect"] = "stand"
    """Whether a blocked robot stands still, or turns away by 45 or 90° and goes on."""
    know_count: bool = False
    """Whether each robot knows the number of robots, for strategies that use it."""
    classes: Annotated[tuple[RobotClass, ...], Strict(False), Field(max_length=16)] = Field(
        (), examples=[[{"name": "arm", "count": 20, "skills": ["lift"]}]]
    )
    """Classes of robots with different skills, instead of robots.count."""
    arrival_rate: Rate | None = Field(None, examples=[0.01])
    """Mean number of robots that join per step; by default none join."""
    failure_rate: Rate | None = Field(None, examples=[0.001])
    """Rate per step at which each robot fails and leaves for good; by default none fails."""
    most: Some | None = Field(None, examples=[40])
    """Most robots at a time, beyond which none joins; by default as many as events bring, or twice as many as
    at the start."""
    work: Steps | None = Field(None, examples=[3000])
    """Steps that a robot works before it charges, away from the arena; by default it never does. Each first
    battery lasts 1 to so many steps."""
    charge: Steps | None = Field(None, examples=[600])
    """Steps that a robot charges, before it comes back to robots.zone."""
    away: Literal["counted", "missing"] = "counted"
    """Whether robots that charge count for the truth and keep their vote, or the truth is that of the robots
    at work."""


class Tasks(Placed):
    """The tasks that the swarm must judge (model.md 1.3, 6.7)."""

    count: ManyTasks = 20
    """Number of tasks, m; each needs one robot, and any robot can do it."""
    classes: Annotated[tuple[TaskClass, ...], Strict(False), Field(max_length=16)] = Field(
        (), examples=[[{"name": "carry", "count": 10, "needs": {"lift": 2}}]]
    )
    """Classes of tasks that need different skills, instead of tasks.count."""
    arrival_rate: Rate | None = Field(None, examples=[0.01])
    """Mean number of tasks that appear per step; by default none appear."""
    lifetime: Annotated[float, DURATION] | None = Field(None, gt=0, le=1e9, examples=[500.0])
    """Mean steps until a task is finished and vanishes; by default tasks stay."""
    work: Steps | None = Field(None, examples=[50])
    """Steps that a robot that acts works at a task before it goes on; by default it stays."""


class Walk(Section):
    """The random walk of the robots (model.md 2)."""

    mean_run: Duration = 10.0
    """Mean duration of a straight walk between two turns, in steps, rounded up: sigma."""


class Sensing(Section):
    """The observation of robots and tasks (model.md 1.4, 4.2, 6.3)."""

    range: Length = 2.0
    """Range of observation d, in units, from centre to centre."""
    observation: Literal["repeated", "unique"] = "repeated"
    """Whether a robot counts each robot or task in range in every step (repeated), or once in an exploration
    (unique)."""
    count_self: bool = False
    """Whether a robot counts itself, once per step."""
    miss: Share = 0.0
    """Probability that a robot misses a robot or task in range in a step."""
    false_robots: Sightings = 0.0
    """Mean number of robots that an exploring robot sees falsely, per step."""
    false_tasks: Sightings = 0.0
    """Mean number of tasks that an exploring robot sees falsely, per step."""
    misname: Share = 0.0
    """Probability that a robot gives a task in sight a wrong name in a step."""
    position_error: Annotated[float, Field(ge=0, le=1e6), AfterValidator(_without_minus), LENGTH] = 0.0
    """Standard deviation of a task's position as a robot sees it, in units, per axis."""
    gate: Length | None = Field(None, examples=[0.4])
    """Distance up to which robots take two positions for one task, in units; by default 8 times
    position_error."""
    view: float = Field(360.0, gt=0, le=360)
    """Angle of view in degrees, half of it on either side of the robot's heading."""

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

    range: Length = Field(default=None, json_schema_extra=without_default)  # type: ignore[assignment]
    """Range of a broadcast, in units; by default sensing.range."""
    loss: Share = 0.0
    """Probability that a robot in range misses a message."""
    delay: Annotated[int, TIME] = Field(0, ge=0, le=1_000)
    """Steps by which messages are late: a robot broadcasts what it would have said then."""
    walls: Share = 0.0
    """Factor by which each wall on the way shortens the range: 0 blocks, 1 lets pass."""
    id_bits: int | None = Field(None, ge=1, le=32, examples=[8])
    """Length in bits of robots' random ids, which may collide; by default each id is unique."""


class Declare(Section):
    """When a robot declares its opinion, because those whom it hears hold it, too (model.md 6.14)."""

    quorum: Annotated[
        Share, _must("must have at most 9 decimals", lambda share: exact(share).denominator <= 10**9)
    ] = 0.9
    """Least share of a robot's inbox that must agree with its decision."""
    rounds: Some = 3
    """Number of consecutive decisions that must reach the quorum."""
    heard: Some = 3
    """Least number of messages in the inbox at each of these decisions."""


class Decision(Section):
    """The controller of a robot: explore, disseminate, decide (model.md 4)."""

    strategy: Annotated[str, AfterValidator(_known_strategy)] = "dmmd"
    """Strategy that rates and chooses opinions: its name, or the path of a .py file."""
    parameters: dict[Word, float] = Field(default_factory=dict, examples=[{"k": 3.0}])
    """Parameters of the strategy by name, if it has any."""
    exploration: Duration = 10.0
    """Mean duration of an exploration, in steps, before it is rounded up: 10 gives 10.51."""
    gain: Duration = 10.0
    """Mean duration of a dissemination of quality 1, in steps, before it is rounded up: g. With 10, quality
    0.9 lasts 6.0 times as long as 0.1, not 9 times."""
    dissemination_floor: Annotated[int, TIME] = Field(0, ge=0, le=1_000_000)
    """Number of steps added to the duration of each dissemination."""
    quality_floor: Million = 0
    """Least value of each of the two counts when a robot rates the quality."""
    listen: Listen = "always"
    """When a robot receives messages: always, during dissemination, or with {last = 3} in its last 3
    steps."""
    inbox: Literal["latest-per-robot", "every-message"] = "latest-per-robot"
    """Whether the inbox keeps only the latest message of each robot, or every message."""
    inbox_size: Some | None = Field(None, examples=[8])
    """Number of robots whose messages the inbox keeps, the newest; by default all."""
    own_vote: bool = True
    """Whether a robot counts its own opinion in the majority."""
    ties: Literal["keep", "random-message"] = "keep"
    """What a robot does with a tie in the majority: keep its opinion, or adopt that of one message, drawn at
    random from its inbox."""
    start: Literal["coin", "first-sight"] = "coin"
    """First opinion of a robot: a fair coin, or the one that its counts favour when its first exploration
    ends. With a tie it keeps the coin."""
    declare: Declare | None = Field(None, examples=[{"quorum": 0.9, "rounds": 3, "heard": 3}])
    """Rule by which a robot declares its opinion, if its strategy doesn't define `declare`; by default none
    does."""
    threshold: float = Field(0.9, ge=0.5, lt=1)
    """Share of the swarm: it has decided when more than this share has the same opinion."""


class Faults(Section):
    """The faults of robots (model.md 6.6); each run draws which robots are faulty."""

    stopped: Faulty = 0.0
    """Share of robots that stop moving, observing and sending, or {count = 1} for one robot."""
    stop_step: Step = 0
    """First step at which the stopped robots are stopped."""
    byzantine: Faulty = 0.0
    """Share of robots that broadcast false opinions, or {count = 1} for one robot."""
    byzantine_says: Literal["opposite", "feasible", "infeasible", "random", "colluding"] = "opposite"
    """Opinion that Byzantine robots broadcast: the opposite of their own, always the same, random, or,
    colluding, all the opposite of the truth in every step."""
    stubborn: Faulty = 0.0
    """Share of robots that never change their opinion, or {count = 1} for one robot."""


class Run(Section):
    """The length of a run (model.md 4.7)."""

    steps: Steps = 1000
    """Number of steps of a run; a swarm that has not decided by then is undecided."""
    stop_at_decision: bool = False
    """Whether a run ends at the swarm's first decision."""
    stop_at_declarations: bool = False
    """Whether a run ends once all counted robots have declared (model.md 6.15.8)."""
    stop_when_taken: bool = False
    """Whether a run ends once all tasks are taken (model.md 6.25.14)."""


class Acting(Section):
    """Robots that go to tasks and do them (model.md 6.25)."""

    start: Start | None = Field(None, examples=[40])
    """Step from which on robots act; or, once they know most tasks (search), surely all (safe), or have
    declared feasible (declared). By default they never act."""
    choose: Literal["nearest", "rank"] = "nearest"
    """Which task a robot goes to: the nearest that it knows to be free, or, for robot i, the i-th that it
    knows."""
    hold: Literal["stand", "tag"] = "stand"
    """Whether robots only walk about before they act, or mark the first free task that they reach, walk on,
    and come back."""
    reach: Length = 1.0
    """Distance at which a robot has reached its task, in units."""


class Units(Section):
    """The size of a unit and of a step, for axes and reports. They change no run, and no hash."""

    metres: float | None = Field(None, ge=1e-9, le=1e9, examples=[0.5])
    """Metres per unit."""
    seconds: float | None = Field(None, ge=1e-9, le=1e9, examples=[1.0])
    """Seconds per step."""


SECTIONS: Final[Mapping[str, type[Section]]] = {
    each.__name__.lower(): each
    for each in (Arena, Place, Robots, Tasks, Walk, Sensing, Radio, Decision, Faults, Run, Acting, Units)
}
"""The sections of a scenario by name, in the order of its complete form."""
TABLES: Final[Mapping[str, type[BaseModel]]] = {**SECTIONS, "events": Event}
"""The sections and the table of an event, by name."""
EVENT: Final[Mapping[str, Any]] = {"step": 500, "tasks": 15}
"""An event, as an example."""


def fields() -> list[str]:
    """Return the dotted paths of all fields of a scenario."""
    return [f"{name}.{key}" for name, section in SECTIONS.items() for key in section.model_fields]


def field_of(path: str) -> FieldInfo | None:
    """Return the field at a dotted path, in which a number is a place in a list; None for other names."""
    name, *keys = path.split(".")
    model, field = TABLES.get(name), None
    for key in keys:
        if not key.isdigit():
            field = model.model_fields.get(key) if model else None
            model = table_of(field.annotation) if field else None
    return field


def table_of(annotation: Any) -> type[BaseModel] | None:
    """Return the model of a field's tables, if it has any."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(table_of, get_args(annotation))), None)


def _within(*types: Any) -> Dimension | None:
    """Return the first dimension within types, if any."""
    found = (each if isinstance(each, Dimension) else _within(*get_args(each)) for each in types)
    return next(filter(None, found), None)


@cache
def dimension_of(path: str) -> Dimension:
    """Return the dimension of the field at a dotted path, such as `LENGTH`, or `NO_UNIT`."""
    field = field_of(path)
    return (_within(field.annotation, *field.metadata) if field else None) or NO_UNIT
