"""Cases computed by hand, one for each rule, put to both minds."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import Scenario, reference
from feasibee.engine import layout, runner, translation
from feasibee.record import Record
from feasibee.robot import Controller, Message
from feasibee.simulation import simulate_record
from feasibee.strategies import STRATEGIES, dmmd

SIDE = 16.0  # a power of two: every multiple of 1/16 is exact in fixed point
UNIT = 2**32 / SIDE
LONG = 1000


class Engine:
    """A swarm of standing robots in the engine, arranged by hand."""

    def __init__(self, scenario, places, tasks, opinions, disseminating):
        self.params = translation.params_of(scenario, 0)
        memory = scenario.strategy.memory
        self.state = layout.empty_state(self.params, translation.kinds_of(scenario, self.params), 64, memory)
        start, self.advance, *self.strategy = runner.engine_functions(scenario)
        start(layout.packed(self.params), self.state, 0)
        count = len(places)
        fixed = (np.array(places) * UNIT).astype(np.uint32).view(np.int32)
        self.state.robots[[layout.X, layout.Y], :count] = fixed.T
        if tasks:  # sorted into one cell: SIDE / 2 is the least range that needs no grid
            assert self.params.task_grid.bits == 0
            spots = (np.array(tasks) * UNIT).astype(np.uint32).view(np.int32)
            self.state.task_cells.points[[layout.X, layout.Y], : len(tasks)] = spots.T
        self.state.robots[layout.PHASE_LEFT, :count] = LONG
        for i, (opinion, speaks) in enumerate(zip(opinions, disseminating, strict=True)):
            self.put(layout.OPINIONS, i, opinion == 1)
            self.put(layout.NEUTRAL, i, opinion == -1)
            self.put(layout.SAID, i, opinion == 1)
            self.put(layout.SPEAKING, i, speaks and opinion >= 0)
            self.put(layout.DISSEMINATING, i, speaks)
            self.state.robots[layout.LABELS, i] = 4 * i + 2 * (opinion == 1) + speaks

    def put(self, kind, i, member):
        word = self.state.sets[kind]
        word[i // 32] &= ~np.uint32(1 << i % 32)
        word[i // 32] |= np.uint32(bool(member) << i % 32)

    def has(self, kind, i):
        return bool(int(self.state.sets[kind, i // 32]) >> i % 32 & 1)

    def tell(self, i, value):
        """Let a robot send a number."""
        self.state.robots[layout.TOLD_VALUE, i] = value

    def rate(self, i, quality):
        """Give a robot a quality of *feasible*."""
        self.state.memory[i, 0] = quality

    def end_phase_of(self, i, after=1):
        self.state.robots[layout.PHASE_LEFT, i] = after

    def step(self):
        until = self.state.clock[layout.STEP] + 1
        record = Record.empty(0, 1, 0)
        unwatched = np.zeros(1, np.int64), np.zeros(1, np.bool_)
        curves = record.feasible_count[0], record.infeasible_count[0]
        outcome = record.decision, record.decision_step, *curves, record.account[0]
        self.advance(layout.packed(self.params), self.state, until, *outcome, *unwatched, *self.strategy)

    def seen(self, i):
        return tuple(self.state.counts[[layout.ROBOTS_SEEN, layout.TASKS_SEEN], i])

    def opinion(self, i):
        return -1 if self.has(layout.NEUTRAL, i) else int(self.has(layout.OPINIONS, i))

    def speaks(self, i):
        return self.has(layout.DISSEMINATING, i)

    def committed(self, i):
        return self.has(layout.COMMITTED, i)

    def memory(self, i):
        return self.state.memory[i, 1:].tolist()

    @property
    def bits_sent(self):
        return int(self.state.clock[layout.BITS])

    @property
    def ids(self):
        return self.state.robots[layout.IDENTITY]


class Plain:
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
        self.swarm.tasks = [(round(x * UNIT), round(y * UNIT)) for x, y in tasks]
        self.minds = [robot.mind for robot in self.swarm.robots]

    def tell(self, i, value):
        self.minds[i]._value = value

    def rate(self, i, quality):
        self.minds[i].feasible_quality = quality

    def end_phase_of(self, i, after=1):
        self.minds[i].phase_left = after

    def step(self):
        self.swarm.step()

    def seen(self, i):
        return sum(self.minds[i].robots_seen), sum(self.minds[i].tasks_seen)

    def opinion(self, i):
        return self.minds[i].opinion

    def speaks(self, i):
        return self.minds[i].disseminating

    def committed(self, i):
        return self.minds[i].committed

    def memory(self, i):
        return self.minds[i]._memory

    @property
    def bits_sent(self):
        return self.swarm.bits_sent

    @property
    def ids(self):
        return [self.swarm.names.id(i) for i in range(len(self.minds))]


NEVER = {"decision.commit.rounds": 1_000_000}
"""Nobody ever commits; but messages say so, so that the engine takes its way for worlds beyond the paper."""


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


def test_a_robot_exactly_at_range_is_seen_and_one_beyond_is_not(world):
    beyond = 1 / UNIT
    swarm = world([(4, 4), (6, 4), (4, 2 - beyond), (4 - 2, 4)])
    swarm.step()
    assert swarm.seen(0) == (2, 0)


def test_a_range_goes_round_both_edges_of_the_torus(world):
    swarm = world([(0.5, 0.5), (15.5, 15.5), (0.5, 15), (2.5, 15.5)], tasks=[(15, 1), (14, 14), (0.5, 15.5)])
    swarm.step()
    assert swarm.seen(0) == (2, 2)


def test_tasks_exactly_at_range_count_and_repeat_in_every_step(world):
    swarm = world([(4, 4)], tasks=[(6, 4), (4, 6 + 1 / UNIT), (5, 5)])
    swarm.step()
    swarm.step()
    assert swarm.seen(0) == (0, 4)


def test_a_disseminating_robot_does_not_count(world):
    swarm = world([(4, 4), (5, 4)], tasks=[(4, 4)], disseminating=[1, 0])
    swarm.step()
    assert swarm.seen(0) == (0, 0)
    assert swarm.seen(1) == (1, 1)


def test_counting_oneself_adds_one_a_step(world):
    swarm = world([(4, 4), (5, 4)], changes={"sensing.count_self": True})
    swarm.step()
    swarm.step()
    assert swarm.seen(0) == (4, 0)


def decide(world, own, votes, heard_for=1, **changes):
    """Let robot 0 hear the votes from robots about it, then end its dissemination; return its opinion."""
    places = [(4, 4)] + [(4 + 0.1 * k, 4) for k in range(len(votes))]
    swarm = world(places, opinions=[own, *votes], disseminating=[1] * len(places), changes=changes)
    for _ in range(heard_for - 1):
        swarm.step()
    swarm.end_phase_of(0)
    swarm.step()
    assert not swarm.speaks(0)
    return swarm.opinion(0)


@pytest.mark.parametrize("own", [0, 1])
def test_an_empty_inbox_keeps_the_opinion(world, own):
    assert decide(world, own, []) == own
    assert decide(world, own, [], **{"decision.own_vote": False}) == own


@pytest.mark.parametrize("own", [0, 1])
def test_a_tie_keeps_the_opinion(world, own):
    assert decide(world, own, [1 - own]) == own  # with the own vote, one against one
    assert decide(world, own, [0, 1], **{"decision.own_vote": False}) == own


@pytest.mark.parametrize("own", [0, 1])
def test_the_majority_wins_with_and_without_the_own_vote(world, own):
    other = 1 - own
    assert decide(world, own, [other, other]) == other
    assert decide(world, own, [other], **{"decision.own_vote": False}) == other
    assert decide(world, own, [other, own, own]) == own


def test_a_robot_heard_often_is_one_vote_or_as_many_as_its_messages(world):
    every = {"decision.inbox": "every-message", "decision.own_vote": False}
    assert decide(world, 1, [0], heard_for=3) == 1
    assert decide(world, 1, [0], heard_for=3, **every) == 0


def test_the_latest_opinion_of_a_robot_counts(world):
    """Robot 1 says 0, changes to 1 upon robot 2 and 3, and, silent, has left its last word: 0."""
    swarm = world(
        [(4, 4), (5, 4), (6.5, 4), (6.9, 4)],
        opinions=[1, 0, 1, 1],
        disseminating=[1, 1, 1, 1],
        changes={"decision.own_vote": False},
    )
    swarm.end_phase_of(1)
    swarm.step()
    assert swarm.opinion(1) == 1
    assert not swarm.speaks(1)
    swarm.end_phase_of(0)
    swarm.step()
    assert swarm.opinion(0) == 0


def test_opinions_heard_are_those_held_when_the_step_began(world):
    """Two robots that swap at the same time end with each other's old opinion."""
    swarm = world(
        [(4, 4), (5, 4)], opinions=[0, 1], disseminating=[1, 1], changes={"decision.own_vote": False}
    )
    swarm.end_phase_of(0)
    swarm.end_phase_of(1)
    swarm.step()
    assert (swarm.opinion(0), swarm.opinion(1)) == (1, 0)


@pytest.mark.parametrize(("listen", "opinion"), [("always", 0), ("dissemination", 1)])
def test_what_is_heard_while_exploring_counts_only_if_it_listens_always(world, listen, opinion):
    swarm = world(
        [(4, 4), (5, 4)],
        opinions=[1, 0],
        disseminating=[0, 1],
        changes={"decision.own_vote": False, "decision.listen": listen},
    )
    swarm.end_phase_of(0)
    swarm.end_phase_of(1)
    swarm.step()  # robot 0 hears robot 1's last message while exploring, then disseminates
    swarm.end_phase_of(0)
    swarm.step()
    assert swarm.opinion(0) == opinion


def test_the_radio_has_a_range_of_its_own(world):
    changes = {"radio.range": 3.0, "decision.own_vote": False}
    swarm = world([(4, 4), (7, 4)], opinions=[1, 0], disseminating=[1, 1], changes=changes)
    swarm.end_phase_of(0)
    swarm.step()
    assert swarm.opinion(0) == 0
    assert swarm.seen(1) == (0, 0)


def test_counts_and_inbox_are_empty_after_a_decision(world):
    swarm = world([(4, 4), (5, 4), (5, 5)], opinions=[1, 0, 0], disseminating=[1, 1, 1])
    swarm.end_phase_of(0)
    swarm.end_phase_of(1)
    swarm.end_phase_of(2)
    swarm.step()
    assert swarm.opinion(0) == 0
    assert swarm.seen(0) == (0, 0)
    swarm.end_phase_of(0)
    swarm.step()  # exploration over
    assert swarm.speaks(0)
    swarm.end_phase_of(0)
    swarm.step()  # nothing heard since
    assert swarm.opinion(0) == 0


@pytest.mark.parametrize(
    ("robots", "tasks", "quality"), [(0, 0, 0.5), (3, 1, 0.75), (0, 5, 0.0), (5, 0, 1.0)]
)
def test_quality_is_the_share_of_robots_and_a_half_with_nothing_seen(robots, tasks, quality):
    assert dmmd.quality(robots, tasks) == quality


@pytest.mark.parametrize(("opinion", "mean"), [(1, 7.5), (0, 2.5)])
def test_dissemination_lasts_in_proportion_to_the_quality_of_the_own_opinion(opinion, mean):
    means = []

    def draw(mean):
        means.append(mean)
        return 1

    robot = Controller(
        STRATEGIES["dmmd"], opinion, draw, draw_choice=lambda: (0.0, 0.0), exploration=4.0, gain=10.0
    )
    robot.observe(robots=3, tasks=1)
    robot.end_step()
    assert means == [4.0, mean]
    assert robot.message() == Message(opinion)


@pytest.mark.parametrize(
    ("count", "threshold", "least"),
    [(20, 0.9, 19), (10, 0.9, 10), (10, 0.7, 8), (10, 0.5, 6), (1, 0.9, 1), (3, 0.5, 2)],
)
def test_a_decision_takes_strictly_more_than_the_threshold(count, threshold, least):
    scenario = Scenario(robots={"count": count}, decision={"threshold": threshold})
    assert translation.params_of(scenario, 0).quorum == least
    swarm = reference.Swarm(scenario, 0, 0)
    for holders, decision in ((least, 1), (least - 1, 0 if count - least + 1 >= least else -1), (0, 0)):
        for i, robot in enumerate(swarm.robots):
            robot.mind.opinion = int(i < holders)
        assert swarm.decision == decision


def test_the_start_counts_as_step_0():
    alone = simulate_record(Scenario(robots={"count": 1}, run={"steps": 5}), 200, 1, curves=True)
    assert (alone.decision_step == 0).all()
    np.testing.assert_array_equal(alone.decision, alone.feasible_count[:, 0])
    assert 60 < alone.decision.sum() < 140


def test_a_decision_is_the_first_step_with_enough_robots_of_one_opinion():
    record = simulate_record(Scenario(run={"steps": 200}), 300, 1, curves=True)
    reached = (record.feasible_count >= 19) | (record.feasible_count <= 1)
    first = np.where(reached.any(axis=1), reached.argmax(axis=1), -1)
    np.testing.assert_array_equal(record.decision_step, first)
    assert (record.decision_step == -1).any()
    decided = first >= 0
    at_first = record.feasible_count[np.arange(300), first]
    np.testing.assert_array_equal(record.decision[decided], at_first[decided] >= 19)
