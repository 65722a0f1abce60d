"""Cases computed by hand, one for each rule, for the reference; the engine equals it (test_conformance)."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from feasibee import Scenario, reference
from feasibee.base.purposes import IDENTITY
from feasibee.reference.mind import BYZANTINE
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.lowering import lower
from feasibee.strategies import STRATEGIES

SIDE = 16.0  # a power of two: every multiple of 1/16 is exact in fixed point
BEYOND = 1.25 * SIDE / 2**32  # a place in a scenario is rounded down
LONG = 1000


class World:
    """A swarm of standing robots, arranged by hand; their phases last until a test ends them."""

    def __init__(self, places, opinions=None, speak=None, changes=None, tasks=()):
        given = {"arena.side": SIDE, "robots.speed": 0.0}
        for kind, points in (("robots", places), ("tasks", tasks)):
            given |= {f"{kind}.count": len(points)}
            given |= {f"{kind}.placement": "points", f"{kind}.points": points} if points else {}
        self.swarm = reference.Swarm(Scenario().replace(given | (changes or {})), 0, 0)
        self.minds = [robot.mind for robot in self.swarm.robots]
        count = len(places)
        for mind, opinion, speaks in zip(
            self.minds, opinions or [1] * count, speak or [0] * count, strict=True
        ):
            mind.opinion = mind._said = opinion
            mind.disseminating, mind.phase_left, mind._value = bool(speaks), LONG, 0

    def step(self, *ending):
        """Advance by a step at which these robots end their phase; lengthen their next one."""
        for i in ending:
            self.minds[i].phase_left = 1
        self.swarm.step()
        for i in ending:
            self.minds[i].phase_left = LONG

    def decide(self, *ending):
        """Let robot 0 decide, while some others end their phases, too; return its opinion."""
        self.step(0, *ending)
        assert not self.minds[0].disseminating
        return self.minds[0].opinion

    def speak_from_now(self, *robots):
        """Let robots end their exploration with this step, and disseminate for long."""
        self.step(*robots)
        assert all(self.minds[i].disseminating for i in robots)

    def let_all_lie(self):
        for robot in self.swarm.robots:
            robot.fault = BYZANTINE
            robot.mind.settings = replace(robot.mind.settings, fault=robot.fault)

    def seen(self, i):
        return sum(self.minds[i].robots_seen), sum(self.minds[i].tasks_seen)

    def known(self, i):
        """Return how many robots and tasks, or sightings of them, a robot knows."""
        robots, tasks = self.minds[i].knowledge.counted()
        return sum(robots), sum(tasks)

    def known_to_all(self):
        return [self.known(i) for i in range(len(self.minds))]


def crowd(own, votes, strategy="dmmd", **changes):
    """Return robot 0 with an opinion among robots that tell theirs."""
    places = [(4, 4)] + [(4 + 0.1 * k, 4) for k in range(len(votes))]
    return World(places, [own, *votes], [1] * len(places), {"decision.strategy": strategy, **changes})


def passing_on(strategy, robots=3, tasks=(), **changes):
    """Return robots in a row, a unit from one to the next, that see half a unit and hear one."""
    changes = {"decision.strategy": strategy, "sensing.range": 0.5, "radio.range": 1.0, **changes}
    return World([(4 + k, 4) for k in range(robots)], changes=changes, tasks=tasks)


SEEN = {  # places of robots and tasks, who disseminates, changes; what robot 0 has seen after each step
    "a robot at range, not one beyond": ([(4, 4), (6, 4), (4, 2 - BEYOND), (4 - 2, 4)], [], [], {}, (2, 0)),
    "round both edges of the torus": (
        [(0.5, 0.5), (15.5, 15.5), (0.5, 15), (2.5, 15.5)],
        [(15, 1), (14, 14), (0.5, 15.5)],
        *([], {}, (2, 2)),
    ),
    "nobody round the edge of an arena with walls": (
        *([(0.5, 4), (15.5, 4)], [(15.9, 4)], []),
        *({"arena.boundary": "walls"}, (0, 0)),
    ),
    "tasks at range, in every step": ([(4, 4)], [(6, 4), (4, 6 + BEYOND), (5, 5)], [], {}, (0, 2)),
    "who explores sees the others": ([(4, 4), (5, 4)], [(4, 4)], [0, 1], {}, (1, 1)),
    "who disseminates sees nothing": ([(4, 4), (5, 4)], [(4, 4)], [1, 0], {}, (0, 0)),
    "oneself": ([(4, 4), (5, 4)], [], [], {"sensing.count_self": True}, (2, 0)),
    "none who is in range of the radio alone": ([(4, 4), (7, 4)], [], [], {"radio.range": 3.0}, (0, 0)),
}


@pytest.mark.parametrize("case", SEEN)
def test_a_robot_sees_in_each_step_what_is_at_range(case):
    places, tasks, speak, changes, (robots, things) = SEEN[case]
    world = World(places, None, speak, changes, tasks)
    for step in (1, 2):
        world.step()
        assert world.seen(0) == (step * robots, step * things)


# --- What is heard ---

ALONE = {"decision.own_vote": False}
ROW = [(4, 4), (5, 4), (6.5, 4), (6.9, 4)]
HEARD = {  # places, opinions, who speaks, changes; who ends phases in each step; some opinions at the end
    "three messages of one robot are one vote": (ROW[:2], [1, 0], [1, 1], {}, [(), (), (0,)], {0: 1}),
    "or as many as its messages": (
        *(ROW[:2], [1, 0], [1, 1], {"decision.inbox": "every-message"}),
        *([(), (), (0,)], {0: 0}),
    ),
    "robot 1 says 0, becomes 1 and, silent, has left its last word": (
        *(ROW, [1, 0, 1, 1], [1, 1, 1, 1], ALONE),
        *([(1,), (0,)], {0: 0, 1: 1}),
    ),
    "two that swap hear what was held when the step began": (
        *(ROW[:2], [0, 1], [1, 1], ALONE),
        *([(0, 1)], {0: 1, 1: 0}),
    ),
    "a radio with a range of its own": (
        *([(4, 4), (7, 4)], [1, 0], [1, 1], {"radio.range": 3.0, **ALONE}),
        *([(0,)], {0: 0}),
    ),
    **{
        f"listens {listen}; robot 1 stops speaking while robot 0 explores": (
            *(ROW[:2], [1, 0], [0, 1], {"decision.listen": listen, **ALONE}),
            *([(0, 1), (0,)], {0: opinion}),
        )
        for listen, opinion in (("always", 0), ("dissemination", 1))
    },
    **{  # robots 1 and 2 say infeasible, 3 feasible; they fall silent one after the other
        f"the newest {size} of {order}, own opinion {own}": (
            *([ROW[0]] * 4, [own, 0, 0, 1], [1] * 4, {"decision.inbox_size": size, **ALONE}),
            *([*((silent,) for silent in order), (0,)], {0: opinion}),
        )
        for size, order, own, opinion in [
            (1, (1, 2, 3), 0, 1),  # robot 3's alone
            (2, (1, 2, 3), 0, 0),  # those of 2 and 3: a tie
            (2, (1, 2, 3), 1, 1),
            (3, (1, 2, 3), 1, 0),  # all
            (1, (3, 2, 1), 1, 0),  # robot 1 was heard last
            (2, (3, 1, 2), 1, 0),  # those of 1 and 2
        ]
    },
}


@pytest.mark.parametrize("case", HEARD)
def test_what_is_heard_becomes_opinions(case):
    places, opinions, speak, changes, steps, after = HEARD[case]
    world = World(places, opinions, speak, changes)
    for ending in steps:
        world.step(*ending)
    assert {i: world.minds[i].opinion for i in after} == after


@pytest.mark.parametrize(
    ("last", "spoken", "opinion"), [(2, 3, 1), (2, 4, 0), (1, 4, 1), (1, 5, 0), (5, 1, 0), (4, 1, 1)]
)
def test_listening_to_the_last_steps_of_dissemination_only(last, spoken, opinion):
    """Robot 0 has five steps of dissemination left, and robot 1 speaks for so many of them."""
    world = crowd(1, [0], **{"decision.listen": {"last": last}, **ALONE})
    world.minds[0].phase_left, world.minds[1].phase_left = 5, spoken
    for step in range(5):
        assert world.minds[0].disseminating
        world.step()
        if step + 1 == spoken:
            world.minds[1].phase_left = LONG
    assert world.minds[0].opinion == opinion


def test_two_robots_with_one_id_are_one_sender():
    """With ids of one bit, seven robots are two at most; the latest word of each id counts."""
    ids = [reference.draws.philox(0, 0, i, 0, IDENTITY)[0] >> 31 for i in range(8)]
    votes = [int(ids[i] not in ids[i + 1 :]) for i in range(1, 8)]
    assert 0 < sum(votes) <= 2  # else the seven would say the same
    assert crowd(0, votes, **ALONE).decide() == 0
    world = crowd(0, votes, **ALONE, **{"radio.id_bits": 1})
    assert [world.swarm.names.id(i) for i in range(8)] == [ids.index(each) for each in ids]
    assert world.decide() == 1


# --- How an inbox becomes an opinion ---

VOTES = ("x", "xxxxx", "ooooo", "")
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
def test_an_inbox_becomes_an_opinion(strategy, before, votes, changes, after, own):
    opinions = {"o": own, "x": 1 - own, "-": -1}
    heard = [opinions[each] for each in votes]
    assert crowd(opinions[before], heard, strategy, **changes).decide() == opinions[after]


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
def test_dc_switches_to_a_heard_opinion_of_higher_quality(own, quality, heard, value, outcome):
    world = crowd(own, [heard], "dc")
    world.minds[0].feasible_quality, world.minds[1]._value = quality, value
    assert world.decide() == outcome


# own opinion, quality, votes, credence; opinion and memory afterwards
BAYES = [
    (-1, 0.75, [1, 1, 0], 0.95, -1, [3.0, 1.0]),  # Beta(4, 2): P(p < 1/2) = 6/32
    (-1, 0.75, [1, 1, 1], 0.95, 1, [4.0, 0.0]),  # Beta(5, 1), P(p < 1/2) = 1/32: 0.969 exceeds 0.95
    (-1, 0.25, [0, 0, 0], 0.95, 0, [0.0, 4.0]),
    (-1, 0.5, [1, 1, 1], 0.95, -1, [3.0, 0.0]),  # without an own observation: 1/16 isn't less than 1/20
    (-1, 0.75, [1, 1, 1], 0.96875, -1, [4.0, 0.0]),  # 1/32 isn't less than 1/32
    (1, 0.0, [0] * 9, 0.95, 1, [0.0, 0.0]),  # an opinion is kept for good
]


@pytest.mark.parametrize(("own", "quality", "votes", "credence", "opinion", "memory"), BAYES)
def test_bayes_adds_what_it_saw_and_heard_until_it_is_sure(own, quality, votes, credence, opinion, memory):
    world = crowd(own, votes, "bayes", **{"decision.parameters": {"credence": credence}})
    world.minds[0].feasible_quality = quality
    assert world.decide() == opinion
    assert world.minds[0]._memory == memory


@pytest.mark.parametrize(("feedback", "said"), [(1.0, 1), (0.0, 0)])
def test_bayes_tells_its_opinion_or_what_it_observes(feedback, said):
    """Robot 0 has opinion 1 and sees a task only; robot 1 hears it, having seen nothing itself."""
    changes = {"decision.strategy": "bayes", "decision.parameters": {"positive_feedback": feedback}}
    ranges = {"sensing.range": 1.0, "radio.range": 3.0}
    world = World([(4, 4), (6, 4)], [1, -1], None, changes | ranges, [(4, 4.5)])
    for ending in (0, 1, 1):
        world.step(ending)
    assert world.minds[1]._memory == [float(said), float(not said)]


# --- Bits, quality and time ---


@pytest.mark.parametrize(
    ("strategy", "opinions", "id_bits", "bits"),
    [
        *(("dmmd", [1, 1, 0, 1], bits, 3 * ((bits or 2) + 1)) for bits in (None, 32)),
        ("voter", [1, 1, 0, 1], None, 3 * (2 + 1)),
        ("dc", [1, 1, 0, 1], None, 3 * (2 + 1 + 16)),
        ("cross-inhibition", [1, -1, 0, 1], None, 2 * (2 + 1)),  # without an opinion it is silent
    ],
)
def test_bits_are_id_opinion_and_value_of_each_speaker_and_step(strategy, opinions, id_bits, bits):
    """Robot 0 listens, three others speak for two steps; nobody need be in range to hear it."""
    changes = {"decision.strategy": strategy, "radio.id_bits": id_bits}
    world = World([(4, 4), (4, 5), (4, 6), (4, 14)], opinions, [0, 1, 1, 1], changes)
    for step in (1, 2):
        world.step()
        assert world.swarm.bits_sent == step * bits


def test_a_bayes_bot_that_saw_as_many_robots_as_tasks_is_silent():
    changes = {"decision.strategy": "bayes", "sensing.range": 1.0}
    world = World([(4, 4), (5, 4)], [-1, -1], None, changes, [(4, 4.5)])
    world.speak_from_now(0)
    world.step()
    assert world.swarm.bits_sent == 0


@pytest.mark.parametrize(
    ("robots", "tasks", "quality"), [(0, 0, 0.5), (3, 1, 0.75), (0, 5, 0.0), (5, 0, 1.0)]
)
def test_quality_is_the_share_of_robots_and_a_half_with_nothing_seen(robots, tasks, quality):
    assert STRATEGIES["dmmd"].quality(robots, tasks) == quality


@pytest.mark.parametrize("floor", [0, 3])
def test_the_floor_is_added_to_each_dissemination(floor):
    """A mean as small as this is one step."""
    world = World([(4, 4)], changes={"decision.dissemination_floor": floor, "decision.gain": 1e-9})
    world.minds[0].phase_left = 1
    spoke = []
    for _ in range(floor + 2):
        world.step()
        spoke.append(world.minds[0].disseminating)
    assert spoke == [True] * (floor + 1) + [False]


@pytest.mark.parametrize(("floor", "value"), [(0, 43690), (1, 43690), (2, 32768), (4, 32768)])
def test_dc_sends_the_quality_of_feasible_in_16_bits_of_counts_of_at_least_the_floor(floor, value):
    """Two robots and a task: 2 / (2 + 1); with a floor of 2, 2 / (2 + 2)."""
    changes = {"decision.strategy": "dc", "sensing.range": 1.0, "decision.quality_floor": floor}
    world = World([(4, 4), (5, 4), (4, 5)], None, None, changes, [(4.5, 4)])
    world.step(0)
    assert world.minds[0]._value == value


# --- Evidence kept and passed on ---

WITNESS = str(Path(__file__).parents[2] / "examples" / "strategies" / "witness.py")


@pytest.mark.parametrize(("strategy", "seen"), [("dmmd", (0, 1)), (WITNESS, (0, 3))])
def test_evidence_is_kept_over_explorations_or_thrown_away(strategy, seen):
    world = World([(4, 4)], [1], None, {"decision.strategy": strategy}, [(4, 4.5)])
    for ending in ((), (0,), (0,), ()):  # exploration over: two sightings; then back to exploration
        world.step(*ending)
    assert world.seen(0) == seen


def test_a_tally_keeps_the_newest_row_of_each_robot():
    world = passing_on("tally", tasks=[(4, 4.2), (6, 4.2)])
    world.speak_from_now(0)  # robots 0 and 2 have seen a task
    assert world.known_to_all() == [(0, 1), (0, 0), (0, 1)]
    world.speak_from_now(1)  # and robot 1 has heard of the first's
    assert world.known_to_all() == [(0, 1), (0, 1), (0, 2)]
    world.step(0)  # robot 2 hears it from robot 1
    assert world.known_to_all() == [(0, 1), (0, 1), (0, 4)]
    world.step()  # robot 0 explores again, and hears its own old row
    assert world.known_to_all() == [(0, 2), (0, 1), (0, 5)]


def test_a_census_is_a_union_and_exact():
    world = passing_on("census", tasks=[(4, 4.2), (6, 4.2)])
    world.speak_from_now(0)
    assert world.known_to_all() == [(1, 1), (1, 0), (1, 1)]
    world.speak_from_now(1)
    world.step()
    world.step()  # nothing is counted twice
    assert world.known_to_all() == [(2, 1), (2, 1), (3, 2)]
    world.step(2)
    world.step(2)
    assert world.minds[2].opinion == 1


def test_a_tally_is_1_bit_id_and_totals_for_each_row_and_their_width():
    world = passing_on("tally", tasks=[(4, 4.2), (4, 4.3)])
    world.step()
    world.speak_from_now(0, 2)
    world.step()  # robot 0 tells of four sightings, three binary digits; robot 2 of nothing
    assert world.swarm.bits_sent == (5 + (1 + 2 + 2 * 3) + 1) + (5 + 1)


def test_a_census_is_1_bit_and_id_for_each_robot_and_1_bit_and_32_for_each_task():
    world = passing_on("census", tasks=[(4, 4.2), (4, 4.3)])
    world.speak_from_now(0)
    assert world.swarm.bits_sent == 0
    world.speak_from_now(1)  # meanwhile robot 0 has told of itself and two tasks
    first = (1 + 2) + 1 + 2 * 33 + 1
    assert world.swarm.bits_sent == first
    world.step()  # robot 0 the same, and robot 1 of both of them
    assert world.swarm.bits_sent == 3 * first + 1 + 2


@pytest.mark.parametrize(("strategy", "bits"), [("tally", 6), ("estimate", 6), ("census", 1 + 1 + 2)])
@pytest.mark.parametrize("declares", [False, True])
def test_messages_of_little_knowledge_and_a_flag_cost_what_they_cost(strategy, bits, declares):
    """A robot whose strategy doesn't say whose message it is adds its id to the flag, and a bit."""
    rule = {"decision.declare.rounds": 1_000_000} if declares else {}
    world = passing_on(strategy, robots=2, **rule)
    world.speak_from_now(0)
    world.step()
    assert world.swarm.bits_sent == bits + (1 + 2) * declares


@pytest.mark.parametrize(("tasks", "opinion"), [(1, 1), (2, 1), (3, 0)])
def test_a_census_of_as_many_robots_as_tasks_is_feasible(tasks, opinion):
    world = passing_on("census", robots=2, tasks=[(4, 4.1), (4, 4.2), (4, 4.3)][:tasks])
    world.speak_from_now(0, 1)
    world.step(0)
    assert world.known(0) == (2, tasks)
    assert world.minds[0].opinion == opinion


# --- Lies ---

LIARS = {"faults.byzantine": {"count": 1}}


@pytest.mark.parametrize(("says", "opinion"), [("feasible", 1), ("infeasible", 0)])
@pytest.mark.parametrize("strategy", ["voter", "dc", "k-unanimity", "cross-inhibition"])
def test_liars_are_believed_and_lend_their_lie_all_quality(strategy, says, opinion):
    """What a robot says is the opposite of what all tell it; two hearings take cross-inhibition there."""
    lies = {**LIARS, "faults.byzantine_says": says}
    world = crowd(1 - opinion, [1 - opinion] * 3, strategy, **lies)
    world.let_all_lie()
    for mind in world.minds:
        mind._value = 65535 * (1 - opinion)
    world.minds[0].feasible_quality = 0.5
    assert world.decide() == (-1 if strategy == "cross-inhibition" else opinion)


@pytest.mark.parametrize(
    ("strategy", "says", "heard"),
    [
        ("tally", "feasible", (4, 0)),  # all four sightings were robots
        ("tally", "infeasible", (0, 4)),  # all were tasks; robot 1's own lie doesn't come back to it
        ("census", "feasible", (1 + 2 + 1, 1)),  # itself, as many invented as tasks, and whom it heard
        ("census", "infeasible", (1 + 1, 1 + 3)),  # as many invented as robots, and one more
    ],
)
def test_liars_that_pass_on_knowledge_invent_robots_or_tasks(strategy, says, heard):
    """Robot 0 has seen a task and a robot in each of two steps; robot 1, far from both, hears of it."""
    changes = {"decision.strategy": strategy, "radio.range": 4.0, "sensing.range": 1.0, **LIARS}
    changes |= {"faults.byzantine_says": says, "sensing.count_self": True}
    world = World([(4, 4), (8, 4)], None, None, changes, [(4, 4.5), (8, 12)])
    world.let_all_lie()
    world.step(1)
    world.speak_from_now(0)
    own = world.known(1) if strategy == "tally" else (0, 0)
    world.step()
    assert world.known(1) == (heard[0] + own[0], heard[1] + own[1])


# --- Commitment ---


def by_votes(own, votes, quorum=0.9, rounds=1, heard=1, strategy="dmmd"):
    rule = {"quorum": quorum, "rounds": rounds, "heard": heard}
    return crowd(own, votes, strategy, **{"decision.declare": rule})


# own opinion, votes, quorum, number heard; whether it declares
QUORUMS = [
    (1, [1, 1, 1, 0], 0.75, 4, True),  # exactly the quorum, and exactly so many
    (1, [1, 1, 1, 0], 0.76, 4, False),
    (1, [1, 1, 1, 0], 0.75, 5, False),
    (0, [0, 0, 0, 1], 0.75, 4, True),
    (0, [1, 1, 1], 1.0, 3, True),  # with what it has just decided
    (1, [], 0.0, 1, False),
    (1, [1, 0], 0.5, 1, True),
    (1, [1, 1, 0, 0], 0.6, 1, False),
]


@pytest.mark.parametrize(("own", "votes", "quorum", "heard", "declares"), QUORUMS)
def test_a_robot_declares_if_enough_of_its_inbox_agree(own, votes, quorum, heard, declares):
    world = by_votes(own, votes, quorum, 1, heard)
    world.decide()
    assert (world.minds[0].declared != -1) == declares


def test_a_robot_declares_after_so_many_rounds_running():
    world = by_votes(1, [1, 1, 1], rounds=2, heard=3)
    world.decide()
    assert world.minds[0].declared == -1
    world.step(1, 2, 3)  # heard for the last time, and
    world.step(0)
    world.decide()
    assert world.minds[0].declared == 1


def test_a_round_without_agreement_starts_the_count_again():
    world = by_votes(1, [1, 1, 1], rounds=2, heard=3)
    world.decide(1, 2, 3)  # the first
    declared = []
    for speak in ((), (1, 2, 3), ()):  # in silence; the first again; the second
        if speak:
            world.speak_from_now(*speak)
        world.step(0)
        world.decide()
        declared.append(world.minds[0].declared)
    assert declared == [-1, -1, 1]


@pytest.mark.parametrize("strategy", ["dmmd", "voter"])
def test_a_declared_robot_keeps_its_opinion(strategy):
    rule = {"decision.strategy": strategy, "decision.declare": {"quorum": 0.9, "rounds": 1, "heard": 1}}
    world = World([(4 + 0.1 * k, 4) for k in range(7)], [1, 1] + [0] * 5, [1, 1] + [0] * 5, rule)
    assert world.decide(1) == 1
    assert world.minds[0].declared == 1
    world.speak_from_now(2, 3, 4, 5, 6)
    world.step(0)
    assert world.decide() == world.minds[0].declared == 1


def test_a_robot_without_an_opinion_declares_nothing():
    world = by_votes(1, [0, 0, 0], quorum=0.0, strategy="cross-inhibition")
    assert world.decide() == world.minds[0].declared == -1


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


def test_a_decision_is_the_first_step_with_enough_robots_of_one_opinion():
    """The start counts as step 0."""
    record = simulate_record(Scenario(run={"steps": 200}), Runs(300, 1), curves=True)
    reached = (record.feasible_count >= 19) | (record.feasible_count <= 1)
    first = np.where(reached.any(axis=1), reached.argmax(axis=1), -1)
    np.testing.assert_array_equal(record.decision_step, first)
    assert (record.decision_step == -1).any()
    decided = first >= 0
    at_first = record.feasible_count[np.arange(300), first]
    np.testing.assert_array_equal(record.decision[decided], at_first[decided] >= 19)
    alone = simulate_record(Scenario(robots={"count": 1}, run={"steps": 5}), Runs(200, 1), curves=True)
    assert (alone.decision_step == 0).all()
    np.testing.assert_array_equal(alone.decision, alone.feasible_count[:, 0])
    assert math.isclose(alone.decision.mean(), 0.5, abs_tol=0.2)
