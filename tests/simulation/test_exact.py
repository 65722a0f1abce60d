"""Cases computed by hand, one for each rule, put to both minds."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from feasibee import Scenario, Swarm, reference
from feasibee.model.purposes import IDENTITY
from feasibee.reference.mind import BYZANTINE
from feasibee.robot.controller import Controller, Message, Settings
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.lowering import lower
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Me

SIDE = 16.0  # a power of two: every multiple of 1/16 is exact in fixed point
UNIT = 2**32 / SIDE
LONG = 1000


class World:
    """What both minds have in common."""

    def step(self, *ending):
        """Advance the world by a step at which these robots end their phase; lengthen their next phase."""
        for i in ending:
            self.end_phase_of(i)
        self.advance()
        for i in ending:
            self.end_phase_of(i, LONG)

    @property
    def bits_sent(self):
        return self.swarm.bits_sent


class Engine(World):
    """A swarm of standing robots in the engine, arranged by hand."""

    def __init__(self, scenario, places, tasks, opinions, disseminating):
        inside = 0.25 / UNIT  # a place in a scenario is rounded down
        at = [(x + inside, y + inside) for x, y in tasks]
        spots = {"tasks.placement": "points", "tasks.points": at} if tasks else {}
        self.scenario = scenario.replace(spots)
        self.swarm = Swarm(self.scenario)
        self.state, count = self.swarm._state, len(places)
        fixed = (np.array(places) * UNIT).astype(np.uint32).view(np.int32)
        for row, values in zip(("X", "Y"), fixed.T, strict=True):
            self.state.robots[row][:count] = values
        self.state.robots["PHASE_LEFT"][:count] = LONG
        for i, (opinion, speaks) in enumerate(zip(opinions, disseminating, strict=True)):
            self.put("FOR_FEASIBLE", i, opinion == 1)
            self.put("NEUTRAL", i, opinion == -1)
            self.put("SAYS_FEASIBLE", i, opinion == 1)
            self.put("SPEAKING", i, speaks and opinion >= 0)
            self.put("DISSEMINATING", i, speaks)
            self.state.robots["LABEL"][i] = 4 * i + 2 * (opinion == 1) + (speaks and opinion >= 0)

    def put(self, name, i, member):
        word = self.state.sets[name]
        word[i // 32] &= ~np.uint32(1 << i % 32)
        word[i // 32] |= np.uint32(bool(member) << i % 32)

    def has(self, name, i):
        return bool(int(self.state.sets[name][i // 32]) >> i % 32 & 1)

    def let_all_lie(self):
        for i in range(self.scenario.robots.count):
            self.put("BYZANTINE", i, True)

    def tell(self, i, value):
        """Let a robot send a number."""
        self.state.robots["SENT_VALUE"][i] = value

    def told(self, i):
        return int(self.state.robots["SENT_VALUE"][i])

    def rate(self, i, quality):
        """Give a robot a quality of *feasible*."""
        self.state.array("quality", self.scenario.robots.count)[i] = quality

    def end_phase_of(self, i, after=1):
        self.state.robots["PHASE_LEFT"][i] = after

    def advance(self):
        self.swarm.advance()

    def seen(self, i):
        return tuple(int(self.state.counts[row][i]) for row in ("ROBOTS_SEEN", "TASKS_SEEN"))

    def opinion(self, i):
        return -1 if self.has("NEUTRAL", i) else int(self.has("FOR_FEASIBLE", i))

    def speaks(self, i):
        return self.has("DISSEMINATING", i)

    def declared(self, i):
        return self.has("DECLARED", i)

    def memory(self, i):
        length = self.scenario.strategy.memory
        return self.state.array("memory", self.scenario.robots.count, length)[i].tolist()

    @property
    def ids(self):
        return self.state.robots["IDENTITY"]


class Plain(World):
    """The same in the reference."""

    def __init__(self, scenario, places, tasks, opinions, disseminating):
        self.swarm = reference.Swarm(scenario, 0, 0)
        for robot, (x, y), opinion, speaks in zip(
            self.swarm.robots, places, opinions, disseminating, strict=True
        ):
            robot.place = (round(x * UNIT), round(y * UNIT))
            robot.mind.opinion = opinion
            robot.mind.disseminating = bool(speaks)
            robot.mind.phase_left = LONG
            robot.mind._said = opinion
            robot.mind._value = 0
        self.swarm.tasks = {i: (round(x * UNIT), round(y * UNIT)) for i, (x, y) in enumerate(tasks)}
        self.minds = [robot.mind for robot in self.swarm.robots]

    def let_all_lie(self):
        for robot in self.swarm.robots:
            robot.fault = BYZANTINE
            robot.mind.settings = replace(robot.mind.settings, fault=robot.fault)

    def tell(self, i, value):
        self.minds[i]._value = value

    def told(self, i):
        return self.minds[i]._value

    def rate(self, i, quality):
        self.minds[i].feasible_quality = quality

    def end_phase_of(self, i, after=1):
        self.minds[i].phase_left = after

    def advance(self):
        self.swarm.step()

    def seen(self, i):
        return sum(self.minds[i].robots_seen), sum(self.minds[i].tasks_seen)

    def opinion(self, i):
        return self.minds[i].opinion

    def speaks(self, i):
        return self.minds[i].disseminating

    def declared(self, i):
        return self.minds[i].declared != -1

    def memory(self, i):
        return self.minds[i]._memory

    @property
    def ids(self):
        return [self.swarm.names.id(i) for i in range(len(self.minds))]


NEVER = {"decision.declare.rounds": 1_000_000}
"""Nobody ever declares; but messages say so, so that the engine takes its way for worlds beyond the paper."""


@pytest.fixture(
    params=[(Engine, 0, {}), (Engine, 40, {}), (Engine, 0, NEVER), (Plain, 0, {})],
    ids=["engine, few", "engine, many", "engine, beyond", "reference"],
)
def world(request):
    """Build a world; ``many`` puts 40 silent robots far away, so that the engine takes its other way."""
    mind, extra, beyond = request.param

    def build(places, tasks=(), opinions=None, disseminating=None, changes=None):
        count = len(places)
        opinions = list(opinions or [1] * count) + [0] * extra
        disseminating = list(disseminating or [0] * count) + [0] * extra
        crowd = [(12.0, 12.0)] * extra
        scenario = Scenario(
            arena={"side": SIDE}, robots={"count": count + extra, "speed": 0.0}, tasks={"count": len(tasks)}
        ).replace({**beyond, **(changes or {})})
        return mind(scenario, [*places, *crowd], list(tasks), opinions, disseminating)

    return build


BEYOND = 1 / UNIT
SEEN = {  # places of robots and tasks, who disseminates, changes; what robot 0 has seen after each step
    "a robot at range, not one beyond": ([(4, 4), (6, 4), (4, 2 - BEYOND), (4 - 2, 4)], [], [], {}, (2, 0)),
    "round both edges of the torus": (
        [(0.5, 0.5), (15.5, 15.5), (0.5, 15), (2.5, 15.5)],
        [(15, 1), (14, 14), (0.5, 15.5)],
        *([], {}, (2, 2)),
    ),
    "tasks at range, in every step": ([(4, 4)], [(6, 4), (4, 6 + BEYOND), (5, 5)], [], {}, (0, 2)),
    "who explores sees the others": ([(4, 4), (5, 4)], [(4, 4)], [0, 1], {}, (1, 1)),
    "who disseminates sees nothing": ([(4, 4), (5, 4)], [(4, 4)], [1, 0], {}, (0, 0)),
    "oneself": ([(4, 4), (5, 4)], [], [], {"sensing.count_self": True}, (2, 0)),
}


@pytest.mark.parametrize("case", SEEN)
def test_a_robot_sees_in_each_step_what_is_at_range(world, case):
    places, tasks, disseminating, changes, (robots, things) = SEEN[case]
    swarm = world(places, tasks, None, disseminating, changes)
    for step in (1, 2):
        swarm.step()
        assert swarm.seen(0) == (step * robots, step * things)


@pytest.mark.parametrize(("inbox", "opinion"), [("latest-per-robot", 1), ("every-message", 0)])
def test_a_robot_heard_often_is_one_vote_or_as_many_as_its_messages(world, inbox, opinion):
    """Three messages for 0 against its own vote for 1, or one: a tie."""
    swarm = crowd(world, 1, [0], "dmmd", **{"decision.inbox": inbox})
    swarm.step()
    swarm.step()
    assert next_opinion(swarm) == opinion


def test_the_latest_opinion_of_a_robot_counts(world):
    """Robot 1 says 0, changes to 1 upon robot 2 and 3, and, silent, has left its last word: 0."""
    swarm = world(
        [(4, 4), (5, 4), (6.5, 4), (6.9, 4)],
        opinions=[1, 0, 1, 1],
        disseminating=[1, 1, 1, 1],
        changes={"decision.own_vote": False},
    )
    swarm.step(1)
    assert swarm.opinion(1) == 1
    assert not swarm.speaks(1)
    swarm.step(0)
    assert swarm.opinion(0) == 0


def test_opinions_heard_are_those_held_when_the_step_began(world):
    """Two robots that swap at the same time end with each other's old opinion."""
    swarm = world(
        [(4, 4), (5, 4)], opinions=[0, 1], disseminating=[1, 1], changes={"decision.own_vote": False}
    )
    swarm.step(0, 1)
    assert (swarm.opinion(0), swarm.opinion(1)) == (1, 0)


@pytest.mark.parametrize(("listen", "opinion"), [("always", 0), ("dissemination", 1), ({"last": 3}, 1)])
def test_what_is_heard_while_exploring_counts_only_if_it_listens_always(world, listen, opinion):
    swarm = world(
        [(4, 4), (5, 4)],
        opinions=[1, 0],
        disseminating=[0, 1],
        changes={"decision.own_vote": False, "decision.listen": listen},
    )
    swarm.step(0, 1)  # robot 0 hears robot 1's last message while exploring, then disseminates
    swarm.step(0)
    assert swarm.opinion(0) == opinion


def test_the_radio_has_a_range_of_its_own(world):
    changes = {"radio.range": 3.0, "decision.own_vote": False}
    swarm = world([(4, 4), (7, 4)], opinions=[1, 0], disseminating=[1, 1], changes=changes)
    swarm.step(0)
    assert swarm.opinion(0) == 0
    assert swarm.seen(1) == (0, 0)


def test_counts_and_inbox_are_empty_after_a_decision(world):
    swarm = world([(4, 4), (5, 4), (5, 5)], opinions=[1, 0, 0], disseminating=[1, 1, 1])
    swarm.step(0, 1, 2)
    assert swarm.opinion(0) == 0
    assert swarm.seen(0) == (0, 0)
    swarm.step(0)  # exploration over
    assert swarm.speaks(0)
    swarm.step(0)  # nothing heard since
    assert swarm.opinion(0) == 0


@pytest.mark.parametrize(
    ("robots", "tasks", "quality"), [(0, 0, 0.5), (3, 1, 0.75), (0, 5, 0.0), (5, 0, 1.0)]
)
def test_quality_is_the_share_of_robots_and_a_half_with_nothing_seen(robots, tasks, quality):
    assert STRATEGIES["dmmd"].quality(robots, tasks) == quality


@pytest.mark.parametrize(("opinion", "mean"), [(1, 7.5), (0, 2.5)])
def test_dissemination_lasts_in_proportion_to_the_quality_of_the_own_opinion(opinion, mean):
    means = []

    def draw(mean):
        means.append(mean)
        return 1

    robot = Controller(
        STRATEGIES["dmmd"], opinion, draw, lambda: (0.0, 0.0), Settings(exploration=4.0, gain=10.0)
    )
    robot.observe(robots=3, tasks=1)
    robot.end_step()
    assert means == [4.0, mean]
    assert robot.message() == Message(opinion)


# --- The rivals: how an inbox becomes an opinion ---


def crowd(world, own, votes, strategy, disseminating=True, **changes):
    """Build robot 0 with an opinion among robots that tell theirs."""
    places = [(4, 4)] + [(4 + 0.1 * k, 4) for k in range(len(votes))]
    speaking = [int(disseminating), *([1] * len(votes))]
    changes = {"decision.strategy": strategy, **changes}
    return world(places, opinions=[own, *votes], disseminating=speaking, changes=changes)


def next_opinion(swarm, *ending):
    """Let robot 0 decide, while some others end their phases, too."""
    swarm.step(0, *ending)
    assert not swarm.speaks(0)
    return swarm.opinion(0)


VOTES = ("x", "xxxxx", "ooooo", "")
ALONE = {"decision.own_vote": False}
RANDOM = {"decision.ties": "random-message"}
TWO = {"decision.parameters": {"k": 2.0}}
RULES = [
    # A voter takes any opinion heard, never its own: o is its own opinion, x the other one.
    *((name, "o", votes, {}, votes[:1] or "o") for name in ("voter", "dmvd") for votes in VOTES),
    # An empty inbox and a tie keep the opinion; with its own vote counted, one against one is a tie.
    ("dmmd", "o", "", {}, "o"),
    ("dmmd", "o", "", ALONE, "o"),
    ("dmmd", "o", "x", {}, "o"),
    ("dmmd", "o", "xo", ALONE, "o"),
    ("dmmd", "o", "xx", {}, "x"),
    ("dmmd", "o", "x", ALONE, "x"),
    ("dmmd", "o", "xoo", {}, "o"),
    # The majority counts the robot's own vote, as dmmd does.
    ("majority", "o", "x", {}, "o"),
    ("majority", "o", "x", ALONE, "x"),
    ("majority", "o", "xx", {}, "x"),
    ("majority", "o", "", {}, "o"),
    # A tie may take a message, which is the other opinion if its own vote tied with one; no tie has none.
    *((name, "o", "x", RANDOM, "x") for name in ("dmmd", "majority")),
    *((name, "o", "", {**ALONE, **RANDOM}, "o") for name in ("dmmd", "majority")),
    ("dmmd", "o", "", RANDOM, "o"),
    ("dmmd", "o", "xoo", RANDOM, "o"),
    ("majority", "o", "xxo", {**ALONE, **RANDOM}, "x"),
    # k opinions that are equal, and nothing less: fewer, or not of one mind.
    ("k-unanimity", "o", "xxx", {}, "x"),
    ("k-unanimity", "o", "xx", {}, "o"),
    ("k-unanimity", "o", "xxo", {}, "o"),
    ("k-unanimity", "o", "xx", TWO, "x"),
    ("k-unanimity", "o", "", TWO, "o"),
    # Cross-inhibition has three states; - is to have no opinion.
    ("cross-inhibition", "o", "x", {}, "-"),
    ("cross-inhibition", "o", "o", {}, "o"),
    ("cross-inhibition", "o", "", {}, "o"),
    ("cross-inhibition", "-", "o", {}, "o"),
    ("cross-inhibition", "-", "", {}, "-"),
]


@pytest.mark.parametrize("own", [0, 1])
@pytest.mark.parametrize(("strategy", "before", "votes", "changes", "after"), RULES)
def test_an_inbox_becomes_an_opinion(world, strategy, before, votes, changes, after, own):
    opinions = {"o": own, "x": 1 - own, "-": -1}
    heard = [opinions[each] for each in votes]
    assert next_opinion(crowd(world, opinions[before], heard, strategy, **changes)) == opinions[after]


# own opinion and quality of *feasible*, heard opinion and its value (65535: quality of *feasible* 1), outcome
COMPARED = [
    (1, 0.5, 0, 0, 0),  # 1 - 0 = 1 > 0.5
    (1, 0.5, 0, 65535, 1),  # 1 - 1 = 0 < 0.5
    (1, 0.5, 0, 32767, 0),  # a hair above one half
    (1, 0.5, 0, 32768, 1),  # a hair below
    (0, 0.25, 1, 65535, 1),  # 1 > 0.75
    (0, 0.25, 1, 49151, 0),  # 49151 / 65535 < 0.75
    (0, 0.25, 1, 49152, 1),  # 49152 / 65535 > 0.75
    (0, 0.0, 1, 65535, 0),  # 1 = 1: not higher
    (1, 0.2, 1, 65535, 1),
]


@pytest.mark.parametrize(("own", "quality", "heard", "value", "outcome"), COMPARED)
def test_dc_switches_to_a_heard_opinion_of_higher_quality(world, own, quality, heard, value, outcome):
    swarm = crowd(world, own, [heard], "dc")
    swarm.rate(0, quality)
    swarm.tell(1, value)
    assert next_opinion(swarm) == outcome


def test_a_robot_without_an_opinion_is_silent_and_sends_no_bits(world):
    swarm = crowd(world, 1, [-1], "cross-inhibition")
    assert next_opinion(swarm) == 1
    assert swarm.bits_sent == bits_of(swarm, 1)


def numbers_of(swarm):
    """Return the robots of a swarm, and whether they declare."""
    if isinstance(swarm, Plain):
        return len(swarm.minds), swarm.swarm.scenario.decision.declare is not None
    return swarm.scenario.robots.count, swarm.scenario.decision.declare is not None


def bits_of(swarm, messages, extra=0, id_bits=None):
    """Return the bits of messages of id, opinion, a flag if robots declare, and more."""
    robots, declares = numbers_of(swarm)
    return messages * ((id_bits or math.ceil(math.log2(robots))) + 1 + int(declares) + extra)


@pytest.mark.parametrize("id_bits", [None, 32])
@pytest.mark.parametrize(("strategy", "extra"), [("dmmd", 0), ("voter", 0), ("dc", 16)])
def test_bits_are_id_opinion_and_value_of_each_speaker_and_step(world, strategy, extra, id_bits):
    """Robot 0 listens, three others speak for two steps; nobody need be in range to hear it."""
    swarm = world(
        [(4, 4), (4, 5), (4, 6), (4, 14)],
        opinions=[1, 1, 0, 1],
        disseminating=[0, 1, 1, 1],
        changes={"decision.strategy": strategy, "radio.id_bits": id_bits},
    )
    swarm.step()
    swarm.step()
    assert swarm.bits_sent == bits_of(swarm, 6, extra, id_bits)


# --- Bayes Bots ---


def test_bayes_adds_what_it_saw_and_what_it_heard(world):
    swarm = crowd(world, -1, [1, 1, 0], "bayes")
    swarm.rate(0, 0.75)
    assert next_opinion(swarm) == -1  # Beta(4, 2): P(p < 1/2) = 6/32
    assert swarm.memory(0) == [3.0, 1.0]


def test_bayes_is_sure_once_the_tail_is_below_the_credence(world):
    """Three heard and one seen: Beta(5, 1), P(p < 1/2) = 1/32; the complement 0.969 exceeds 0.95."""
    for quality, votes, outcome in ((0.75, [1, 1, 1], 1), (0.25, [0, 0, 0], 0), (0.5, [1, 1, 1], -1)):
        swarm = crowd(world, -1, votes, "bayes")  # without an own observation: 1/16 isn't less than 1/20
        swarm.rate(0, quality)
        assert next_opinion(swarm) == outcome
    swarm = crowd(world, -1, [1, 1, 1], "bayes", **{"decision.parameters": {"credence": 0.96875}})
    swarm.rate(0, 0.75)
    assert next_opinion(swarm) == -1  # 1/32 isn't less than 1/32


def test_bayes_keeps_an_opinion_for_good(world):
    swarm = crowd(world, 1, [0] * 9, "bayes")
    swarm.rate(0, 0.0)
    assert next_opinion(swarm) == 1
    assert swarm.memory(0) == [0.0, 0.0]


@pytest.mark.parametrize(("feedback", "said"), [(1.0, 1), (0.0, 0)])
def test_bayes_tells_its_opinion_or_what_it_observes(world, feedback, said):
    """Robot 0 has opinion 1 and sees a task only; robot 1 hears it, having seen nothing itself."""
    swarm = world(
        [(4, 4), (6, 4)],
        tasks=[(4, 4.5)],
        opinions=[1, -1],
        changes={
            "decision.strategy": "bayes",
            "decision.parameters": {"positive_feedback": feedback},
            "sensing.range": 1.0,
            "radio.range": 3.0,
        },
    )
    swarm.step(0)
    swarm.step(1)
    swarm.step(1)
    assert swarm.memory(1) == [float(said), float(not said)]


def test_a_bayes_bot_that_saw_as_many_robots_as_tasks_is_silent(world):
    changes = {"decision.strategy": "bayes", "sensing.range": 1.0}
    swarm = world([(4, 4), (5, 4)], tasks=[(4, 4.5)], opinions=[-1, -1], changes=changes)
    swarm.step(0)
    assert swarm.speaks(0)
    swarm.step()
    assert swarm.bits_sent == 0


# --- Evidence kept and passed on ---


WITNESS = str(Path(__file__).parents[2] / "examples" / "strategies" / "witness.py")


@pytest.mark.parametrize(("strategy", "seen"), [("dmmd", (0, 1)), (WITNESS, (0, 3))])
def test_evidence_is_kept_over_explorations_or_thrown_away(world, strategy, seen):
    swarm = world([(4, 4)], tasks=[(4, 4.5)], opinions=[1], changes={"decision.strategy": strategy})
    swarm.step()
    swarm.step(0)  # exploration over: two sightings
    swarm.step(0)  # back to exploration
    swarm.step()
    assert swarm.seen(0) == seen


def passing_on(world, strategy, robots=3, tasks=(), **changes):
    """Build robots in a row, a unit from one to the next, that see half a unit and hear one."""
    changes = {"decision.strategy": strategy, "sensing.range": 0.5, "radio.range": 1.0, **changes}
    return world([(4 + k, 4) for k in range(robots)], tasks=list(tasks), changes=changes)


def known(swarm, i):
    """Return how many robots and tasks, or sightings of them, a robot knows: of a tally or a census."""
    if isinstance(swarm, Plain):
        robots, tasks = swarm.minds[i].knowledge.counted()
        return sum(robots), sum(tasks)
    strategy, setting = swarm.scenario.strategy, swarm.scenario.setting
    words = swarm.state.known()[i].tolist()
    counts = [0, 0]
    strategy.count(words, counts, Me(0, 0, 0, 0, [], setting))
    return tuple(counts)


def speak_from_now(swarm, *robots):
    """Let robots end their exploration with this step, and disseminate for long."""
    swarm.step(*robots)
    assert all(swarm.speaks(i) for i in robots)


def test_a_tally_keeps_the_newest_row_of_each_robot(world):
    swarm = passing_on(world, "tally", tasks=[(4, 4.2), (6, 4.2)])
    speak_from_now(swarm, 0)  # robots 0 and 2 have seen a task
    assert [known(swarm, i) for i in range(3)] == [(0, 1), (0, 0), (0, 1)]
    speak_from_now(swarm, 1)  # and robot 1 has heard of the first's
    assert [known(swarm, i) for i in range(3)] == [(0, 1), (0, 1), (0, 2)]
    swarm.step(0)  # robot 2 hears it from robot 1
    assert [known(swarm, i) for i in range(3)] == [(0, 1), (0, 1), (0, 4)]
    swarm.step()  # robot 0 explores again, and hears its own old row
    assert [known(swarm, i) for i in range(3)] == [(0, 2), (0, 1), (0, 5)]


def test_a_tally_is_1_bit_id_and_totals_for_each_row_and_their_width(world):
    swarm = passing_on(world, "tally", tasks=[(4, 4.2), (4, 4.3)])
    swarm.step()
    speak_from_now(swarm, 0, 2)
    swarm.step()  # robot 0 tells of four sightings, three binary digits; robot 2 of nothing
    robots, declares = numbers_of(swarm)
    width = math.ceil(math.log2(robots))
    flags = 2 * (width + 2) if declares else 0
    assert swarm.bits_sent == (5 + (1 + width + 2 * 3) + 1) + (5 + 1) + flags


def test_a_census_is_a_union_and_exact(world):
    swarm = passing_on(world, "census", tasks=[(4, 4.2), (6, 4.2)])
    speak_from_now(swarm, 0)
    assert [known(swarm, i) for i in range(3)] == [(1, 1), (1, 0), (1, 1)]
    speak_from_now(swarm, 1)
    swarm.step()
    swarm.step()  # nothing is counted twice
    assert [known(swarm, i) for i in range(3)] == [(2, 1), (2, 1), (3, 2)]
    swarm.step(2)
    swarm.step(2)
    assert swarm.opinion(2) == 1


def test_a_census_is_1_bit_and_id_for_each_robot_and_1_bit_and_32_for_each_task(world):
    swarm = passing_on(world, "census", tasks=[(4, 4.2), (4, 4.3)])
    speak_from_now(swarm, 0)
    assert swarm.bits_sent == 0
    speak_from_now(swarm, 1)  # meanwhile robot 0 has told of itself and two tasks
    robots, declares = numbers_of(swarm)
    width = math.ceil(math.log2(robots))
    flags = width + 2 if declares else 0
    first = (1 + width) + 1 + 2 * 33 + 1 + flags
    assert swarm.bits_sent == first
    swarm.step()  # robot 0 the same, and robot 1 of both of them
    assert swarm.bits_sent == 3 * first + 1 + width


@pytest.mark.parametrize(("tasks", "opinion"), [(1, 1), (2, 1), (3, 0)])
def test_a_census_of_as_many_robots_as_tasks_is_feasible(world, tasks, opinion):
    spots = [(4, 4.1), (4, 4.2), (4, 4.3)][:tasks]
    swarm = passing_on(world, "census", robots=2, tasks=spots)
    speak_from_now(swarm, 0, 1)
    swarm.step(0)
    assert known(swarm, 0) == (2, tasks)
    assert swarm.opinion(0) == opinion


@pytest.mark.parametrize("strategy", ["tally", "estimate", "census"])
def test_a_flag_costs_what_it_costs(world, strategy):
    """Also that a robot without knowledge sends an empty message of all the others."""
    swarm = passing_on(world, strategy, robots=2)
    speak_from_now(swarm, 0)
    swarm.step()
    robots, declares = numbers_of(swarm)
    width = math.ceil(math.log2(robots))
    empty = {"tally": 6, "estimate": 6, "census": 1 + width + 2}
    assert swarm.bits_sent == empty[strategy] + (width + 2 if declares else 0)


# --- The field's variants ---


@pytest.mark.parametrize(
    ("size", "order", "own", "opinion"),
    [
        (1, (1, 2, 3), 0, 1),  # robot 3's alone
        (2, (1, 2, 3), 0, 0),  # those of 2 and 3: a tie
        (2, (1, 2, 3), 1, 1),
        (3, (1, 2, 3), 1, 0),  # all
        (9, (1, 2, 3), 1, 0),
        (1, (3, 2, 1), 1, 0),  # robot 1 was heard last
        (2, (3, 1, 2), 1, 0),  # those of 1 and 2
    ],
)
def test_an_inbox_keeps_the_newest_of_so_many_senders(world, size, order, own, opinion):
    """Robots 1 and 2 say infeasible, 3 feasible; they fall silent one after the other."""
    changes = {"decision.inbox_size": size, "decision.own_vote": False}
    swarm = crowd(world, own, [0, 0, 1], "dmmd", **changes)
    for silent in order:
        swarm.step(silent)
    assert next_opinion(swarm) == opinion


@pytest.mark.parametrize(
    ("last", "spoken", "opinion"), [(2, 3, 1), (2, 4, 0), (1, 4, 1), (1, 5, 0), (5, 1, 0), (4, 1, 1)]
)
def test_listening_to_the_last_steps_of_dissemination_only(world, last, spoken, opinion):
    """Robot 0 has five steps of dissemination left, and robot 1 speaks for so many of them."""
    changes = {"decision.listen": {"last": last}, "decision.own_vote": False}
    swarm = crowd(world, 1, [0], "dmmd", **changes)
    swarm.end_phase_of(0, 5)
    swarm.end_phase_of(1, spoken)
    for step in range(5):
        assert swarm.speaks(0)
        swarm.step()
        if step + 1 == spoken:
            swarm.end_phase_of(1, LONG)
    assert swarm.opinion(0) == opinion


@pytest.mark.parametrize("floor", [0, 3])
def test_the_floor_is_added_to_each_dissemination(world, floor):
    """A mean as small as this is one step."""
    changes = {"decision.dissemination_floor": floor, "decision.gain": 1e-9}
    swarm = world([(4, 4)], changes=changes)
    swarm.end_phase_of(0)
    swarm.step()
    for _ in range(floor):
        swarm.step()
        assert swarm.speaks(0)
    swarm.step()
    assert not swarm.speaks(0)


@pytest.mark.parametrize(("floor", "value"), [(0, 43690), (1, 43690), (2, 32768), (4, 32768)])
def test_dc_sends_the_quality_of_feasible_in_16_bits_of_counts_of_at_least_the_floor(world, floor, value):
    """Two robots and a task: 2 / (2 + 1); with a floor of 2, 2 / (2 + 2)."""
    swarm = world(
        [(4, 4), (5, 4), (4, 5)],
        tasks=[(4.5, 4)],
        changes={"decision.strategy": "dc", "sensing.range": 1.0, "decision.quality_floor": floor},
    )
    swarm.step(0)
    assert swarm.told(0) == value


def test_two_robots_with_one_id_are_one_sender(world):
    """With ids of one bit, seven robots are two at most; the latest word of each id counts."""
    ids = [reference.draws.philox(0, 0, i, 0, IDENTITY)[0] >> 31 for i in range(8)]
    votes = [int(ids[i] not in ids[i + 1 :]) for i in range(1, 8)]
    assert 0 < sum(votes) <= 2  # else the seven would say the same
    assert next_opinion(crowd(world, 0, votes, "dmmd", **ALONE)) == 0
    swarm = crowd(world, 0, votes, "dmmd", **ALONE, **{"radio.id_bits": 1})
    assert list(swarm.ids[:8]) == [ids.index(each) for each in ids]
    assert next_opinion(swarm) == 1


# --- Lies ---

LIARS = {"faults.byzantine": {"count": 1}}


@pytest.mark.parametrize(("says", "opinion"), [("feasible", 1), ("infeasible", 0)])
@pytest.mark.parametrize("strategy", ["voter", "dc", "k-unanimity", "cross-inhibition"])
def test_liars_are_believed_and_lend_their_lie_all_quality(world, strategy, says, opinion):
    """What a robot says is the opposite of what all tell it; two hearings take cross-inhibition there."""
    lies = {**LIARS, "faults.byzantine_says": says}
    swarm = crowd(world, 1 - opinion, [1 - opinion] * 3, strategy, **lies)
    swarm.let_all_lie()
    for i in range(4):
        swarm.tell(i, 65535 * (1 - opinion))
    swarm.rate(0, 0.5)
    heard = next_opinion(swarm)
    assert heard == (-1 if strategy == "cross-inhibition" else opinion)


@pytest.mark.parametrize(
    ("strategy", "says", "heard"),
    [
        ("tally", "feasible", (4, 0)),  # all four sightings were robots
        ("tally", "infeasible", (0, 4)),  # all were tasks; robot 1's own lie doesn't come back to it
        ("census", "feasible", (1 + 2 + 1, 1)),  # itself, as many invented as tasks, and whom it heard
        ("census", "infeasible", (1 + 1, 1 + 3)),  # as many invented as robots, and one more
    ],
)
def test_liars_that_pass_on_knowledge_invent_robots_or_tasks(world, strategy, says, heard):
    """Robot 0 has seen a task and a robot in each of two steps; robot 1, far from both, hears of it."""
    swarm = world(
        [(4, 4), (8, 4)],
        tasks=[(4, 4.5), (8, 12)],
        changes={"decision.strategy": strategy, "radio.range": 4.0, "sensing.range": 1.0, **LIARS}
        | {"faults.byzantine_says": says, "sensing.count_self": True},
    )
    swarm.let_all_lie()
    swarm.step(1)
    speak_from_now(swarm, 0)
    before = known(swarm, 1)
    swarm.step()
    robots = numbers_of(swarm)[0]
    more = robots - 2 if (strategy, says) == ("census", "infeasible") else 0  # the silent crowd
    own = before if strategy == "tally" else (0, 0)
    assert known(swarm, 1) == (heard[0] + own[0], heard[1] + own[1] + more)


# --- Commitment ---


def by_votes(world, own, votes, quorum=0.9, rounds=1, heard=1, strategy="dmmd"):
    rule = {"quorum": quorum, "rounds": rounds, "heard": heard}
    return crowd(world, own, votes, strategy, **{"decision.declare": rule})


def decide_again(swarm):
    """Let robot 0 end its exploration, hear once more while disseminating, and decide."""
    swarm.step(0)
    return next_opinion(swarm)


@pytest.mark.parametrize(
    ("own", "votes", "quorum", "heard", "declares"),
    [
        (1, [1, 1, 1, 0], 0.75, 4, True),  # exactly the quorum, and exactly so many
        (1, [1, 1, 1, 0], 0.76, 4, False),
        (1, [1, 1, 1, 0], 0.75, 5, False),
        (0, [0, 0, 0, 1], 0.75, 4, True),
        (0, [1, 1, 1], 1.0, 3, True),  # with what it has just decided
        (1, [], 0.0, 1, False),
        (1, [1, 0], 0.5, 1, True),
        (1, [1, 1, 0, 0], 0.6, 1, False),
    ],
)
def test_a_robot_declares_if_enough_of_its_inbox_agree(world, own, votes, quorum, heard, declares):
    swarm = by_votes(world, own, votes, quorum, 1, heard)
    next_opinion(swarm)
    assert swarm.declared(0) == declares


def test_a_robot_declares_after_so_many_rounds_running(world):
    swarm = by_votes(world, 1, [1, 1, 1], rounds=2, heard=3)
    next_opinion(swarm)
    assert not swarm.declared(0)
    swarm.step(1, 2, 3)  # heard for the last time, and
    swarm.step(0)
    next_opinion(swarm)
    assert swarm.declared(0)


def test_a_round_without_agreement_starts_the_count_again(world):
    swarm = by_votes(world, 1, [1, 1, 1], rounds=2, heard=3)
    next_opinion(swarm, 1, 2, 3)  # the first
    decide_again(swarm)  # in silence
    speak_from_now(swarm, 1, 2, 3)
    decide_again(swarm)  # the first again
    assert not swarm.declared(0)
    decide_again(swarm)
    assert swarm.declared(0)


@pytest.mark.parametrize("strategy", ["dmmd", "voter"])
def test_a_declared_robot_keeps_its_opinion(world, strategy):
    places = [(4, 4)] + [(4 + 0.1 * k, 4) for k in range(6)]
    swarm = world(
        places,
        opinions=[1, 1, 0, 0, 0, 0, 0],
        disseminating=[1, 1, 0, 0, 0, 0, 0],
        changes={
            "decision.strategy": strategy,
            "decision.declare": {"quorum": 0.9, "rounds": 1, "heard": 1},
        },
    )
    assert next_opinion(swarm, 1) == 1
    assert swarm.declared(0)
    speak_from_now(swarm, 2, 3, 4, 5, 6)
    assert decide_again(swarm) == 1
    assert swarm.declared(0)


def test_a_robot_without_an_opinion_declares_nothing(world):
    swarm = by_votes(world, 1, [0, 0, 0], quorum=0.0, strategy="cross-inhibition")
    assert next_opinion(swarm) == -1
    assert not swarm.declared(0)


@pytest.mark.parametrize(
    ("count", "threshold", "least"),
    [(20, 0.9, 19), (10, 0.9, 10), (10, 0.7, 8), (10, 0.5, 6), (1, 0.9, 1), (3, 0.5, 2)],
)
def test_a_decision_takes_strictly_more_than_the_threshold(count, threshold, least):
    scenario = Scenario(robots={"count": count}, decision={"threshold": threshold})
    share, whole = lower(scenario, 0).params.decision.quorum
    assert count * share // whole + 1 == least
    swarm = reference.Swarm(scenario, 0, 0)
    for holders, decision in ((least, 1), (least - 1, 0 if count - least + 1 >= least else -1), (0, 0)):
        for i, robot in enumerate(swarm.robots):
            robot.mind.opinion = int(i < holders)
        assert swarm.decision == decision


def test_the_start_counts_as_step_0():
    alone = simulate_record(Scenario(robots={"count": 1}, run={"steps": 5}), Runs(200, 1), curves=True)
    assert (alone.decision_step == 0).all()
    np.testing.assert_array_equal(alone.decision, alone.feasible_count[:, 0])
    assert 60 < alone.decision.sum() < 140


def test_a_decision_is_the_first_step_with_enough_robots_of_one_opinion():
    record = simulate_record(Scenario(run={"steps": 200}), Runs(300, 1), curves=True)
    reached = (record.feasible_count >= 19) | (record.feasible_count <= 1)
    first = np.where(reached.any(axis=1), reached.argmax(axis=1), -1)
    np.testing.assert_array_equal(record.decision_step, first)
    assert (record.decision_step == -1).any()
    decided = first >= 0
    at_first = record.feasible_count[np.arange(300), first]
    np.testing.assert_array_equal(record.decision[decided], at_first[decided] >= 19)
