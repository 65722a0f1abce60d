"""The contract of a strategy: plain functions, the same file in the engine, in the reference and on a robot.

A strategy's file must define ``decide``. It may define ``quality``, ``dissemination``, ``say``, ``value`` and
``lasting``, ``probability``, and the constants of `CONSTANTS`: see `Strategy`. The functions use only numbers
and ``math``, since the engine compiles them.

Knowledge
---------
Some strategies pass on more than an opinion and a number: sets, counters, sketches. The file of such a
strategy also defines ``words``, ``observe``, ``merge``, ``count`` and ``bits``, and may define those of
`KNOWLEDGE_OPTIONS`: see `Strategy`. A robot's knowledge is a row of ``Words``, 0 at the start.
In each step, in this order:

1. Each robot that broadcasts makes its message: ``encode(message, known, me)``, by default a copy of what
   it knows. The message of a Byzantine robot then passes through ``lie(message, feasible, me)``. The
   length of the message is ``bits(message, me)``.
2. Each robot that explores calls ``observe(known, thing, me)`` once per robot and task that it sees.
3. Each robot that listens calls ``merge(known, message, sender, me)`` once per message received.
4. Each robot that works calls ``judge(known, me)``; or, until it has declared, ``declare(known, me)``
   (model.md 6.15).
5. Each robot whose phase ends calls ``count(known, counts, me)``; ``quality`` then rates the counts.

So a robot passes on what it learns in a step from the next step on. Without ``lie`` a Byzantine robot
invents things: each is given to ``observe``, with the message in place of the knowledge. It invents as many
robots as there are tasks, or one task more than there are robots. Colluding robots invent as many as the lie
needs, and leave all else out of a message that is to speak for *feasible* (model.md 6.16).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Final, NamedTuple

from feasibee.base.codes import BITS_LIMIT, COUNT_LIMIT, LONGEST

ARGUMENTS: Final[Mapping[str, tuple[str, ...]]] = {
    "quality": ("robots_seen", "tasks_seen"),
    "dissemination": ("quality", "gain"),
    "decide": ("mind", "inbox"),
    "say": ("mind",),
    "value": ("mind",),
    "lasting": ("mind", "gain"),
    "probability": ("mind", "known", "setting"),
    "words": ("setting",),
    "message_words": ("setting",),
    "start": ("known", "me"),
    "observe": ("known", "thing", "me"),
    "encode": ("message", "known", "me"),
    "lie": ("message", "feasible", "me"),
    "merge": ("known", "message", "sender", "me"),
    "count": ("known", "counts", "me"),
    "bits": ("message", "me"),
    "declare": ("known", "me"),
    "judge": ("known", "me"),
    "describe": ("known", "me"),
    "layout": ("wire", "message", "sender", "setting"),
    "pack": ("writer", "message", "sender", "setting"),
    "unpack": ("message", "reader", "setting"),
}
"""The functions of a strategy's file, and the arguments of each."""
REQUIRED: Final = ("decide",)
"""The functions that every strategy's file defines."""
KNOWLEDGE: Final = ("words", "observe", "merge", "count", "bits")
"""The functions that a file must define in addition if its robots pass on knowledge."""
KNOWLEDGE_OPTIONS: Final = tuple(name for name in list(ARGUMENTS)[7:] if name not in KNOWLEDGE)
"""The functions that such a file may define."""
MUST: Final[Mapping[str, str]] = {
    **dict.fromkeys(("quality", "probability"), "must be a number from 0 to 1"),
    **dict.fromkeys(("dissemination", "lasting"), f"must be a number of steps from 0 to {LONGEST}"),
    **dict.fromkeys(("decide", "say", "declare", "judge"), "must be 1, 0, or -1 for none"),
    "value": "must be a number",
    "bits": f"must be a whole number from 0 to {BITS_LIMIT}",
    "count": f"must be whole numbers from 0 to {COUNT_LIMIT}",
}
"""What functions must return, or write into ``counts``."""
LARGEST: Final = math.nextafter(1e300, 0.0)
"""What is larger overflows sooner or later."""
LIMITS: Final[Mapping[str, tuple[float, float]]] = {
    **dict.fromkeys(("quality", "probability"), (0.0, 1.0)),
    **dict.fromkeys(("dissemination", "lasting"), (0.0, float(LONGEST))),
    "value": (-LARGEST, LARGEST),
}
"""Least and largest results of the functions that return a real number."""


class Mind(NamedTuple):
    """What a robot knows of itself."""

    opinion: int
    """1 feasible, 0 infeasible, -1 none."""
    quality: float
    """Of the opinion that it holds, by its last exploration; 1/2 without an opinion (model.md 4.3)."""
    feasible_quality: float
    """Of *feasible*: rho_1."""
    own_vote: int
    """What its own opinion weighs in a majority: 1 or 0."""
    memory: Any
    """As many floats as ``MEMORY`` says, 0.0 at the start, the strategy's to read and write."""
    parameters: Any
    """The values of ``PARAMETERS``, floats in their order."""
    random_ties: int = 0
    """1 if it takes a message at random when votes tie, 0 if it keeps its opinion (``decision.ties``)."""


class Inbox(NamedTuple):
    """What a robot heard since its last decision."""

    feasible_votes: int
    """Messages that say *feasible*; the robot's own opinion isn't among them."""
    infeasible_votes: int
    """Messages that say *infeasible*."""
    heard_opinion: int
    """Opinion in one message, drawn at random; -1 without messages."""
    heard_value: float
    """Value in that message, 0 to 1; 0.0 without messages."""
    mean_value: float
    """Mean value of all messages; 0.0 without messages."""
    chance: float
    """A random number, 0 <= chance < 1, for what the strategy leaves to chance."""


class Setting(NamedTuple):
    """The numbers of a scenario on which the size and the meaning of knowledge may depend."""

    robots: int
    """Number of robots that have ids, which are below it: the most at a time, if the world changes."""
    count: int  # type: ignore[assignment]  # hides tuple.count
    """Number of robots at the start. With ``knows_count``, this is what a robot knows."""
    tasks: int
    """Number of tasks that have ids below it, for the size of rows: a real robot doesn't know it."""
    robot_ids: int
    """Number of ids of robots, those that Byzantine robots invent included."""
    task_ids: int
    """Number of ids of tasks, those that Byzantine robots invent and wrong names included."""
    robot_classes: int
    """Number of classes of robots, at least 1."""
    task_classes: int
    """Number of classes of tasks, at least 1."""
    id_bits: int
    """Length of a robot's id in a message, in bits."""
    parameters: Any
    """The values of ``PARAMETERS``, floats in their order."""
    knows_count: bool
    """Whether robots know how many robots there are (``robots.know_count``)."""
    colluding: bool
    """Whether Byzantine robots collude (model.md 6.16). For ``lie``: an honest robot doesn't know it."""
    width: float
    """Width of the arena, in units."""
    height: float
    """Height of the arena, in units."""
    walled: bool
    """Whether the arena has walls; otherwise it is a torus."""
    sight: float
    """Range of sight, in units; with a narrow view, half the width of the strip that a moving robot sees."""
    radio: float
    """Range of the radio, in units."""
    speed: float
    """Speed of a robot, in units per step."""
    exploration: float
    """Mean duration of exploration, in steps."""
    dissemination: float
    """Mean duration of dissemination for an opinion of quality 1, in steps."""
    mean_run: float = 10.0
    """Mean duration of a straight walk between two turns, in steps."""
    flooding: float = 0.0
    """In a place: step by which all surely know all names of tasks, 2**30 if never; elsewhere 0.0."""
    delay: float = 0.0
    """Delay of messages, in steps."""
    plan: bytes = b""
    """With ``READS_PLAN``, in a place with walls, its cells by row: 1 is a wall, 16 where tasks may be."""
    columns: int = 0
    """Number of columns of the plan; 0 without walls."""
    work: float = 0.0
    """Steps that a robot works before it charges; 0.0 if none does, or if robots that charge don't count."""
    charge: float = 0.0
    """Steps that it then charges."""


class Me(NamedTuple):
    """The robot whose knowledge a function is given."""

    id: int
    """Its id; with ``radio.id_bits`` two robots may have the same."""
    kind: int
    """Number of its class, 0 for the first."""
    hash: int
    """32 random bits, the same for all who see a robot of this id."""
    step: int
    """Number of steps that have passed before this one, by its own clock, modulo 2**32."""
    memory: Any
    """As many floats as ``MEMORY`` says: the same as `Mind.memory`."""
    setting: Setting
    """The numbers of the scenario."""
    explores: bool = True
    """Whether it explores in this step; otherwise it disseminates."""
    x: float = 0.0
    """Its position in a frame that all robots share, in units, from 0 to the width of the arena."""
    y: float = 0.0
    """Its position, from 0 to the height of the arena."""


class Thing(NamedTuple):
    """A robot or a task that a robot sees."""

    is_robot: bool
    """Whether it is a robot."""
    id: int
    """Below `Setting.robot_ids` or `Setting.task_ids`; -1 for a false sighting."""
    kind: int
    """Number of its class, among those of robots or among those of tasks."""
    hash: int
    """32 random bits, the same for all who see it; a false sighting has its own, drawn anew each time."""
    x: float = 0.0
    """Its position in the shared frame, in units; 0.0 if it isn't there."""
    y: float = 0.0
    """Its position, in units."""


def quality(robots_seen: int, tasks_seen: int) -> float:
    """Return the quality of *feasible*: rho_1 = n_obs / (n_obs + m_obs), or 1/2 with nothing seen (eq. 1)."""
    if robots_seen + tasks_seen == 0:
        return 0.5
    return robots_seen / (robots_seen + tasks_seen)


def dissemination(quality: float, gain: float) -> float:
    """Return the mean duration of broadcasting, in steps: g, whatever the quality."""
    return gain


def modulated(quality: float, gain: float) -> float:
    """Return the mean duration of broadcasting, in steps, in proportion to the quality: g rho."""
    return gain * quality


def say(mind: Mind) -> int:
    """Return the opinion to broadcast: the robot's own."""
    return mind.opinion


def value(mind: Mind) -> float:
    """Return the value to broadcast, if messages have one: the quality of *feasible*."""
    return mind.feasible_quality


def lasting(mind: Mind, gain: float) -> float:
    """Return the mean duration of a dissemination; not called, since ``dissemination`` says it."""
    return gain


def probability(mind: Mind, known: Any, setting: Setting) -> float:
    """Return what an opinion says: 1 for *feasible*, 0 for *infeasible*, 1/2 for none."""
    return 0.5 if mind.opinion < 0 else float(mind.opinion)


@dataclass(frozen=True, eq=False, kw_only=True)
class Manifest:
    """What the file of a strategy declares: all that can be known without running it."""

    name: str
    """What a scenario calls the strategy."""
    parameters: Mapping[str, float] = field(default_factory=dict)
    """``PARAMETERS``, with their defaults; a scenario changes them in ``[decision.parameters]``."""
    positive: tuple[str, ...] = ()
    """``POSITIVE``: names of parameters that must be above 0."""
    memory: int = 0
    """``MEMORY``: number of floats that a robot keeps."""
    value_bits: int = 0
    """``VALUE_BITS``: length of the value in a message, in bits; 0: messages have none."""
    forgets: bool = True
    """``FORGETS``: whether each exploration counts afresh."""
    starts_neutral: bool = False
    """``STARTS_NEUTRAL``: whether robots start without an opinion."""
    modulates: bool = False
    """``MODULATES``: whether robots broadcast in proportion to the quality of their opinion: for the gain
    times the quality, on average, instead of for the gain. Not in addition to ``dissemination`` or
    ``lasting``."""
    by_name: bool = False
    """``BY_NAME``: whether knowledge is about things by id or hash, so that false sightings mean nothing."""
    needs_count: bool = False
    """``NEEDS_COUNT``: whether robots must know how many robots there are."""
    needs_ids: bool | str = False
    """``NEEDS_IDS``: whether ids of robots must never be mistaken; or a parameter, above 0 if so."""
    needs_names: bool = False
    """``NEEDS_NAMES``: whether all robots must name a task alike, such as by its place in a shared frame."""
    sends_positions: bool = False
    """``SENDS_POSITIONS``: whether robots name tasks by positions that they send whole, so that they can
    compare them with a gate."""
    all_round: bool = False
    """``ALL_ROUND``: whether robots must see all that is in range: what they don't see isn't there."""
    reads_plan: bool = False
    """``READS_PLAN``: whether robots know the plan of their place, and so what walls hide from them."""
    one_class: bool = False
    """``ONE_CLASS``: whether robots and tasks can't have classes."""
    functions: frozenset[str] = frozenset()
    """The functions of `ARGUMENTS` that the file defines."""
    source: str = ""
    """The text of a user's file; it is part of a scenario's hash. Built-in strategies have none here."""
    trusted: bool = True
    """Whether the text may be run. Text that came with results may not, unless the user says so."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Manifest) and (self.name, self.source) == (other.name, other.source)

    def __hash__(self) -> int:
        return hash((self.name, self.source))

    @property
    def knowledge(self) -> bool:
        """Whether robots pass on knowledge in addition to opinions."""
        return "merge" in self.functions

    def needs(self, parameters: Mapping[str, float]) -> tuple[str, ...]:
        """Return what a robot needs: ``"names"``, ``"ids"`` or ``"count"``, by the file's constants.

        Parameters
        ----------
        parameters : mapping of str to float
            Values of the strategy's parameters.
        """
        ids = self.needs_ids
        if isinstance(ids, str):
            ids = parameters[ids] > 0
        all_needs = {"names": self.needs_names, "ids": ids, "count": self.needs_count}
        return tuple(name for name, need in all_needs.items() if need)

    @property
    def declares(self) -> bool:
        """Whether robots declare when they are sure."""
        return "declare" in self.functions

    @property
    def judges(self) -> bool:
        """Whether opinions follow from knowledge in every step."""
        return "judge" in self.functions

    @property
    def gives_probability(self) -> bool:
        """Whether robots have a probability of their own that the tasks are feasible."""
        return "probability" in self.functions


CONSTANTS: Final = {each.name.upper(): each.name for each in fields(Manifest)[1:-3]}
"""The constants of a strategy's file, and the fields of `Manifest` that hold them."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Strategy(Manifest):
    """How opinions are rated, broadcast and chosen: a manifest with its functions.

    The functions from ``words`` on are those of a strategy that passes on knowledge; others have None.
    """

    quality: Callable[[int, int], float] = quality
    """``quality(robots_seen, tasks_seen)``: the quality of *feasible*, 0 to 1; by default the share of
    robots."""
    dissemination: Callable[[float, float], float] = dissemination
    """``dissemination(quality, gain)``: for how long to broadcast an opinion of this quality, on average,
    in steps; by default ``gain``, or ``gain * quality`` with ``MODULATES``."""
    decide: Callable[[Mind, Inbox], int]
    """``decide(mind, inbox)``: the next opinion, 1 or 0, or -1 for none."""
    say: Callable[[Mind], int] = say
    """``say(mind)``: what to broadcast for the whole dissemination, 1 or 0, or -1 to be silent."""
    value: Callable[[Mind], float] = value
    """``value(mind)``: a number from 0 to 1 to broadcast with it, near 1 if it speaks for *feasible*."""
    lasting: Callable[[Mind, float], float] = lasting
    """``lasting(mind, gain)``: for how long to broadcast, as ``dissemination``, which it replaces."""
    probability: Callable[[Mind, Any, Setting], float] = probability
    """``probability(mind, known, setting)``: how probable it is that the tasks are feasible, 0 to 1, by what
    the robot knows; ``known`` has no words without knowledge. It may change nothing. A robot is asked at the
    end of a run, unless it has declared."""
    words: Callable[[Setting], int] | None = None
    """``words(setting)``: number of words of a robot's knowledge. Called before a run, never in it."""
    message_words: Callable[[Setting], int] | None = None
    """``message_words(setting)``: number of words that a message takes; by default as many as knowledge."""
    start: Callable[[Any, Me], None] | None = None
    """``start(known, me)``: write what a robot knows at step 0; by default nothing."""
    observe: Callable[[Any, Thing, Me], None] | None = None
    """``observe(known, thing, me)``: add a robot or task in sight to what is known."""
    encode: Callable[[Any, Any, Me], None] | None = None
    """``encode(message, known, me)``: write the message, once per step while disseminating. It may change
    what is known, such as whose turn it is. By default a copy of what is known."""
    lie: Callable[[Any, int, Me], None] | None = None
    """``lie(message, feasible, me)``: change a Byzantine robot's message so that it speaks for *feasible*
    (1) or *infeasible* (0). A file with ``encode`` needs it if robots are Byzantine."""
    merge: Callable[[Any, Any, int, Me], None] | None = None
    """``merge(known, message, sender, me)``: add what a message says; ``sender`` is the id of the
    neighbour that sent it. The message can't be changed."""
    count: Callable[[Any, Any, Me], None] | None = None
    """``count(known, counts, me)``: write the numbers of robots and then of tasks, by class, whole and at
    least 0, into ``counts``, which is all 0. Only their ratio matters to most rules of ``quality``."""
    bits: Callable[[Any, Me], int] | None = None
    """``bits(message, me)``: exact length of a message, in bits."""
    declare: Callable[[Any, Me], int] | None = None
    """``declare(known, me)``: what the robot is sure of, 1 feasible or 0 infeasible, or -1 as long as it
    isn't. It may change what is known, such as the step of the last news. Once it returns 1 or 0, it
    isn't called again."""
    judge: Callable[[Any, Me], int] | None = None
    """``judge(known, me)``: the opinion that the robot holds from this step on, 1 feasible or 0 infeasible,
    or -1 to keep its own. It may change what is known, such as the age of a sighting. A file with
    ``judge`` can't have ``declare``."""
    describe: Callable[[Any, Me], str] | None = None
    """``describe(known, me)``: what is known, as a text for people, for the live page; no run calls it."""
    layout: Callable[[Any, Any, int, Setting], int] | None = None
    """``layout(wire, message, sender, setting)``: go through a message from its first bit to its last, in
    place of ``pack`` and ``unpack``, which are made of it: see ``feasibee.strategies.layout``."""
    pack: Callable[[Any, Sequence[int], int, Setting], None] | None = None
    unpack: Callable[[Any, Any, Setting], int] | None = None
    """``pack(writer, message, sender, setting)``: write a message as the bits that ``bits`` counts.
    ``unpack(message, reader, setting)``: read it; return the sender's id, -1 if it isn't sent."""

    def __post_init__(self) -> None:
        """Let a strategy that modulates broadcast in proportion to quality."""
        if self.modulates and self.dissemination is dissemination:
            object.__setattr__(self, "dissemination", modulated)

    def row_lengths(self, setting: Setting) -> tuple[int, int]:
        """Return the numbers of words of a robot's knowledge and of its message, if robots pass on any."""
        functions: Any = self  # those for knowledge are None in other strategies only
        known = functions.words(setting)
        return known, known if functions.message_words is None else functions.message_words(setting)


def sent(value: float, bits: int) -> int:
    """Return a value from 0 to 1 as the whole number of ``bits`` bits that a message holds."""
    return int(min(max(value, 0.0), 1.0) * (2**bits - 1) + 0.5)
