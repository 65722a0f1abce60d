"""Engine and reference, written apart, agree bit for bit."""

from __future__ import annotations

import dataclasses
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from feasibee import Scenario, ScenarioError, Swarm, reference
from feasibee.model.record import Record
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.snapshot import FLAGS
from feasibee.strategies import STRATEGIES

ARRAYS = tuple(each.name for each in dataclasses.fields(Record) if each.name != "first_run")


def assert_equal(scenario, seed, runs=1, first_run=0):
    """See that engine and reference give the same runs; return their record."""
    records = [
        simulate_record(scenario, Runs(runs, seed, first_run), curves=True, backend=backend)
        for backend in ("engine", "reference")
    ]
    for name in ARRAYS:
        np.testing.assert_array_equal(*(getattr(each, name) for each in records), err_msg=name)
    return records[0]


PARAMETERS = {
    "k": st.one_of(st.integers(-1, 6).map(float), st.floats(0, 8)),
    "credence": st.one_of(st.floats(0, 1), st.sampled_from([0.5, 0.9, 0.95, 1.0])),
    "positive_feedback": st.sampled_from([0.0, 1.0]),
    "quiet": st.one_of(st.just(0.0), st.floats(0, 30)),
    "tolerates": st.sampled_from([-1.0, 0.0, 1.0, 2.0, 1e300]),
    "hurry": st.sampled_from([-1.0, 0.0, 0.3, 1.0, 1e300]),
    "lasts": st.sampled_from([-1.0, 0.0, 0.5, 20.0, 1e300]),
    "names": st.sampled_from([-1.0, 0.0, 1.0, 2.5, 6.0]),
    "cell": st.floats(0.9, 9),
    "rows": st.sampled_from([-1.0, 0.0, 1.0, 2.5, 1e300]),
    "name_bits": st.sampled_from([0.0, 4.0, 20.0, 31.0, 99.0]),
    "looks": st.sampled_from([1.0, 2.0]),
    "task_timeout": st.one_of(st.just(0.0), st.floats(-1, 60)),
    "robot_timeout": st.one_of(st.just(0.0), st.floats(-1, 60)),
}
RULE = st.builds(
    dict,
    quorum=st.one_of(st.sampled_from([0.0, 0.5, 0.6, 2 / 3, 0.9, 1.0]).map(lambda x: round(x, 9))),
    rounds=st.integers(1, 4),
    heard=st.integers(1, 4),
)


@st.composite
def deciding(draw, longest_exploration, longest_gain):
    """Draw how robots decide, less what has no meaning for the strategy; now and then as in the paper."""
    name = draw(st.sampled_from(list(STRATEGIES)))
    strategy = STRATEGIES[name]
    both = ["latest-per-robot", "every-message"]
    inbox = "latest-per-robot" if strategy.value_bits else draw(st.sampled_from(both))
    decision = {
        "strategy": name,
        "parameters": {each: draw(PARAMETERS[each]) for each in strategy.parameters if draw(st.booleans())},
        "exploration": draw(st.floats(0.1, longest_exploration)),
        "gain": draw(st.floats(0.1, longest_gain)),
        "dissemination_floor": draw(st.one_of(st.just(0), st.integers(0, 6))),
        "quality_floor": 0 if strategy.knowledge else draw(st.one_of(st.just(0), st.integers(0, 4))),
        "listen": draw(st.sampled_from(["always", "dissemination"])),
        "inbox": inbox,
        "own_vote": draw(st.booleans()),
        "ties": draw(st.sampled_from(["keep", "random-message"])),
        "start": "coin"
        if strategy.knowledge or strategy.starts_neutral
        else draw(st.sampled_from(["coin", "first-sight"])),
        "threshold": draw(st.floats(0.5, 0.99)),
    }
    if draw(st.booleans()):
        decision["listen"] = draw(st.one_of(st.just("always"), st.builds(dict, last=st.integers(1, 8))))
        decision["declare"] = None if strategy.declares else draw(st.one_of(st.none(), RULE))
        if inbox == "latest-per-robot":
            decision["inbox_size"] = draw(st.one_of(st.none(), st.integers(1, 6)))
    return decision


def knows_count(decision):
    """Draw whether robots know how many they are; some strategies need it."""
    return st.just(True) if STRATEGIES[decision["strategy"]].needs_count else st.booleans()


def ids():
    """Draw the length of ids."""
    return st.one_of(st.none(), st.none(), st.integers(1, 8), st.just(32))


@st.composite
def scenarios(draw):
    side = draw(st.floats(2, 40))
    robots = draw(st.one_of(st.integers(1, 34), st.integers(1, 34), st.sampled_from([40, 70, 129])))
    reach = st.floats(0.01, 0.5).map(lambda share: share * side)
    decision = draw(deciding(15, 30))
    return Scenario(
        arena={"side": side},
        robots={
            "count": robots,
            "speed": draw(st.floats(0, 0.5)) * side,
            "know_count": draw(knows_count(decision)),
        },
        tasks={"count": draw(st.one_of(st.integers(0, 70), st.just(200)))},
        walk={"mean_run": draw(st.floats(0.1, 30))},
        sensing={"range": draw(reach), "count_self": draw(st.booleans())},
        radio=draw(st.one_of(st.just({}), st.builds(dict, range=reach), st.builds(dict, id_bits=ids()))),
        decision=decision,
        run={"steps": draw(st.integers(1, 40)), "stop_at_decision": draw(st.booleans())},
    )


@given(scenarios(), st.integers(0, 2**64 - 1), st.integers(0, 2**32 - 2))
def test_engine_equals_reference_over_generated_scenarios(scenario, seed, first_run):
    assert_equal(scenario, seed, first_run=first_run)


SKILLS = ("lift", "scan", "push")


@st.composite
def split(draw, count, names):
    """Share a count among classes; some may be empty."""
    cuts = sorted(draw(st.integers(0, count)) for _ in names[1:])
    return [b - a for a, b in zip([0, *cuts], [*cuts, count], strict=True)]


@st.composite
def robot_classes(draw, count):
    names = [f"r{k}" for k in range(draw(st.integers(1, 4)))]
    skills = st.lists(st.sampled_from(SKILLS), unique=True)
    counts = draw(split(count, names))
    return [{"name": n, "count": c, "skills": draw(skills)} for n, c in zip(names, counts, strict=True)]


@st.composite
def task_classes(draw, count):
    names = [f"t{k}" for k in range(draw(st.integers(1, 4)))]
    needs = st.dictionaries(st.sampled_from(SKILLS), st.integers(1, 3), min_size=1)
    counts = draw(split(count, names))
    return [{"name": n, "count": c, "needs": draw(needs)} for n, c in zip(names, counts, strict=True)]


@st.composite
def placing(draw, sides, number, points):
    """Draw where things stand; ``number`` is how they are told, and ``points`` where they may be given."""
    how = draw(st.sampled_from(["uniform", "clusters", "points"]))
    if how == "points" and points:
        return {"placement": how, "points": points, **number}
    return {
        "placement": how if how != "points" else "uniform",
        "clusters": draw(st.integers(1, 4)),
        "spread": draw(st.floats(0.01, 1)) * min(sides),
        **number,
    }


@st.composite
def faulty(draw, robots):
    """Draw how many robots have each fault, as counts, shares or exact halves; an honest one works."""
    given_, left = {}, robots
    for kind in ("byzantine", "stopped", "stubborn"):
        number = draw(st.one_of(st.just(0), st.integers(0, left - (kind != "stubborn"))))
        half, share = max(0.0, (number - 0.5) / robots), min(number / robots, 0.999)
        given_[kind] = draw(st.sampled_from([{"count": number}, half, share]))
        left -= number
    return given_


@st.composite
def beyond(draw):
    """Scenarios beyond the paper (model.md 6), every part of it now and then."""
    width, height = draw(st.tuples(st.floats(4, 30), st.floats(4, 30)))
    square = draw(st.booleans())
    height = width if square else height
    shorter = min(width, height)
    walls, avoid = draw(st.booleans()), draw(st.booleans())
    diameter = draw(st.floats(0.02, 0.2)) * shorter
    most = (shorter / 2 - diameter) / 2 if avoid and not walls else shorter / 2
    speed = draw(st.floats(0, 0.99)) * most
    columns, rows = int(width / diameter * 0.999), int(height / diameter * 0.999)
    wanted = draw(st.one_of(st.integers(1, 12), st.integers(25, 40), st.integers(60, 70)))
    robots = min(wanted, columns * rows) if avoid else wanted
    tasks = draw(st.one_of(st.integers(0, 30), st.just(70)))
    if avoid:
        sites = [(diameter * 1.0005 * (i % columns + 0.5), diameter * 1.0005 * (i // columns + 0.5))
                 for i in draw(st.permutations(range(columns * rows)))[:robots]]  # fmt: skip
    else:
        shares = st.tuples(st.floats(0, 0.999), st.floats(0, 0.999))
        sites = [(diameter / 2 + x * (width - diameter), diameter / 2 + y * (height - diameter))
                 for x, y in draw(st.lists(shares, min_size=robots, max_size=robots))]  # fmt: skip
    seeds = draw(st.integers(0, 2**16))
    spots = [
        (float(x), float(y)) for x, y in np.random.default_rng(seeds).uniform(0, (width, height), (tasks, 2))
    ]
    decision = draw(deciding(8, 15))
    split = not STRATEGIES[decision["strategy"]].one_class
    who = {"classes": draw(robot_classes(robots))} if split and draw(st.booleans()) else {"count": robots}
    what = {"classes": draw(task_classes(tasks))} if split and draw(st.booleans()) else {"count": tasks}
    reach = st.floats(0.01, 1.6 if walls else 0.5).map(lambda share: share * shorter)
    chance = st.one_of(st.just(0.0), st.floats(0, 1), st.sampled_from([0.1, 1.0]))
    views = st.sampled_from([360.0, 360.0, 180.0, 90.0, 1e-9]) | st.floats(1, 359.99)
    false = st.one_of(st.just(0.0), st.floats(0, 3), st.just(40.0))
    steps = draw(st.integers(1, 40))
    names_nothing = not STRATEGIES[decision["strategy"]].by_name
    judges = STRATEGIES[decision["strategy"]].judges
    has_names, sight = STRATEGIES[decision["strategy"]].needs_names, draw(reach)
    compares = not has_names or STRATEGIES[decision["strategy"]].sends_positions
    batteries = st.builds(
        lambda work, charge: {"work": work, "charge": charge}, st.integers(1, 15), st.integers(1, 9)
    )
    return Scenario(
        arena={
            "side": width if square else [width, height],
            "boundary": "walls" if walls else "torus",
        },
        robots={
            **draw(placing((width, height), who, sites)),
            "speed": speed,
            "diameter": diameter,
            "avoid_collisions": avoid,
            "contact": draw(st.sampled_from(["stand", "deflect"])) if avoid else "stand",
            "know_count": draw(knows_count(decision)),
            **draw(st.just({}) | batteries),
        },
        tasks=draw(placing((width, height), what, spots)),
        walk={"mean_run": draw(st.floats(0.1, 15))},
        sensing={
            "range": sight,
            "count_self": draw(st.booleans()),
            "observation": draw(st.sampled_from(["repeated"] if judges else ["repeated", "unique"])),
            "miss": draw(chance),
            "false_robots": draw(false) if names_nothing else 0.0,
            "false_tasks": draw(false) if names_nothing else 0.0,
            "misname": draw(chance) if has_names else 0.0,
            "position_error": draw(st.sampled_from([0.0, 0.02, 0.1])) * sight if compares else 0.0,
            "gate": draw(st.none() | st.floats(0.01, 1).map(lambda share: share * sight)),
            "view": draw(views) if speed and not STRATEGIES[decision["strategy"]].all_round else 360.0,
        },
        radio={
            "range": draw(reach),
            "loss": draw(chance),
            "id_bits": draw(ids()),
            "delay": draw(st.sampled_from([0, 0, 1, 3, 20])),
        },
        decision=decision,
        faults={
            **draw(faulty(robots)),
            "stop_step": draw(st.integers(0, 12)),
            "byzantine_says": draw(st.sampled_from(LIES)),
        },
        run={
            "steps": min(steps, max(4, 15_000 // (robots * (robots + tasks)))),
            "stop_at_decision": draw(st.booleans()),
            "stop_at_declarations": draw(st.booleans()),
        },
    )


LIES = ["opposite", "feasible", "infeasible", "random", "colluding"]


@given(beyond(), st.integers(0, 2**64 - 1), st.integers(0, 2**32 - 2))
def test_engine_equals_reference_beyond_the_paper(scenario, seed, first_run):
    assert_equal(scenario, seed, first_run=first_run)


@st.composite
def events(draw, scenario):
    """Draw what happens at a step; it may change nothing of the world that robots notice."""
    steps, sides = scenario.run.steps, scenario.arena.size
    loss, miss = (draw(st.one_of(st.none(), st.sampled_from([0.0, 0.3, 1.0]))) for _ in range(2))
    tasks, robots = draw(st.integers(-30, 30)), draw(st.one_of(st.just(0), st.integers(-20, 20)))
    event = {"step": draw(st.integers(0, steps)), "tasks": tasks or 1, "robots": robots}
    if draw(st.booleans()):  # says where, or which one
        kind = draw(st.sampled_from(["tasks", "robots", "task", "robot"]))
        least, most = (1, 5) if kind in ("tasks", "robots") else (0, 20)
        event = {"step": event["step"], kind: draw(st.integers(least, most))}
        if least or draw(st.booleans()):
            event["at"] = [draw(st.floats(0.05, 0.95)) * side for side in sides]
    return {**event, "radio": {"loss": loss}, "sensing": {"miss": miss}}


@st.composite
def changing(draw):
    """Scenarios beyond the paper whose world changes (model.md 6.17)."""
    scenario = draw(beyond())
    assume(not scenario.manifest.declares)
    rates = st.one_of(st.none(), st.sampled_from([0.0, 0.05, 0.5]))
    most = st.one_of(st.none(), st.integers(scenario.robots.count, scenario.robots.count + 40))
    changes = {
        "decision.declare": None,
        "run.stop_at_decision": False,
        "run.stop_at_declarations": False,
        "events": draw(st.lists(events(scenario), max_size=4)),
        "sensing.position_error": 0.0,
        "tasks.lifetime": draw(st.one_of(st.none(), st.floats(0.5, 60))),
        "tasks.arrival_rate": draw(rates),
        "robots.failure_rate": draw(rates),
        "robots.arrival_rate": draw(rates),
        "robots.most": draw(most),
        "robots.away": draw(st.sampled_from(["counted", "missing"] if scenario.robots.work else ["counted"])),
    }
    with suppress(ScenarioError):  # such as more robots that leave than there are
        return scenario.replace(changes)
    assume(False)
    raise AssertionError


@given(changing(), st.integers(0, 2**64 - 1), st.integers(0, 2**32 - 3))
def test_engine_equals_reference_in_worlds_that_change(scenario, seed, first_run):
    assert_equal(scenario, seed, runs=2, first_run=first_run)


@st.composite
def acting(draw):
    """Scenarios beyond the paper, whose world may change, and whose robots act (model.md 6.25)."""
    scenario = draw(st.one_of(beyond(), changing()))
    robots, tasks = scenario.robots, scenario.tasks
    least = max(robots.speed, robots.diameter, 0.01)
    steps = st.integers(0, scenario.run.steps)
    changes = {
        "acting.start": draw(steps | st.sampled_from(["declared", "search", "safe"])),
        "acting.choose": draw(st.sampled_from(["nearest", "rank"])),
        "acting.hold": draw(st.sampled_from(["stand", "tag"])),
        "acting.reach": draw(st.floats(1, 3)) * least,
        "tasks.work": draw(st.none() | st.integers(1, 20)),
        "sensing.misname": 0.0,
        "sensing.position_error": 0.0,
        "robots.work": None,
        "robots.charge": None,
        "robots.away": "counted",
        "run.stop_when_taken": draw(st.booleans()),
    }
    if tasks.classes:
        classes = [
            {"name": each.name, "count": each.count, "needs": {min(each.needs): 1}} for each in tasks.classes
        ]
        changes["tasks.classes"] = classes
    with suppress(ScenarioError):  # such as tags and ranks together
        return scenario.replace(changes)
    assume(False)
    raise AssertionError


@given(acting(), st.integers(0, 2**64 - 1), st.integers(0, 2**32 - 3))
def test_engine_equals_reference_with_robots_that_act(scenario, seed, first_run):
    assert_equal(scenario, seed, runs=2, first_run=first_run)


CREW = {
    "robots": {
        "classes": [
            {"name": "a", "count": 4, "skills": ["x", "y"]},
            {"name": "b", "count": 4, "skills": ["x"]},
        ]
    },
    "tasks": {
        "classes": [
            {"name": "a", "count": 4, "needs": {"x": 1}},
            {"name": "b", "count": 4, "needs": {"y": 1}},
        ]
    },
}
COMING = {"lifetime": 50.0, "arrival_rate": 0.1, "count": 8}
MISSIONS = {
    "tags": {"acting": {"start": 40, "hold": "tag"}},
    "tasks that take time": {"acting": {"start": 5}, "tasks": {"work": 9, "count": 30}},
    "by rank once declared": {
        "acting": {"start": "declared", "choose": "rank"},
        "decision": {"strategy": "quiet-census"},
        "run": {"steps": 250},
    },
    "bodies within walls": {
        "acting": {"start": 10},
        "robots": {"count": 12, "avoid_collisions": True, "diameter": 0.6},
        "arena": {"side": 14, "boundary": "walls"},
    },
    "a crew, until some stop": {
        **CREW,
        "acting": {"start": 0},
        "faults": {"stopped": 0.3, "stop_step": 50},
    },
    "liars and delay": {
        "acting": {"start": 5},
        "faults": {"byzantine": {"count": 3}},
        "radio": {"delay": 2},
    },
    "robots and tasks that come and go": {
        "acting": {"start": 0},
        "tasks": COMING,
        "robots": {"count": 12, "arrival_rate": 0.1, "failure_rate": 0.01, "most": 20},
    },
}


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", MISSIONS)
def test_longer_missions_are_equal(name):
    usual = {"arena": {"side": 14}, "robots": {"count": 12, "know_count": True}, "tasks": {"count": 11}}
    record = assert_equal(Scenario(**{**usual, "run": {"steps": 120}, **MISSIONS[name]}), 3, runs=6)
    assert (record.tasks_taken > 1).all()
    assert record.vain_arrivals.sum() > 0 or name == "by rank once declared"


@pytest.mark.slow
@pytest.mark.parametrize("listen", ["always", "dissemination"])
@pytest.mark.parametrize("inbox", ["latest-per-robot", "every-message"])
def test_engine_equals_reference_in_a_crowd_where_inbox_tables_grow(listen, inbox):
    """130 robots that all hear each other for long fill tables of 64 slots."""
    scenario = Scenario(
        arena={"side": 5.5},
        robots={"count": 130},
        tasks={"count": 50},
        decision={"gain": 60.0, "listen": listen, "inbox": inbox},
        run={"steps": 100},
    )
    assert_equal(scenario, seed=2)


def assert_same_swarms(scenario, seed, run, steps):
    swarm = Swarm(scenario, seed=seed, run=run)
    plain = reference.Swarm(scenario, seed=seed, run=run)
    unit, before = float(plain.world.unit), np.full(swarm.present.size, -1)
    for _ in range(steps):
        there = [each.number for each in plain.robots]
        np.testing.assert_array_equal(np.flatnonzero(swarm.present), there)
        assert np.isnan(swarm.positions[~swarm.present]).all()
        places = np.reshape([each.place for each in plain.robots], (-1, 2))
        np.testing.assert_array_equal(swarm.positions[there], places * unit)
        np.testing.assert_array_equal(swarm.task_numbers, list(plain.tasks))
        np.testing.assert_array_equal(swarm.tasks, np.reshape([*plain.tasks.values()], (-1, 2)) * unit)
        np.testing.assert_array_equal(swarm.opinions[there], [each.mind.opinion for each in plain.robots])
        assert (swarm.opinions[~swarm.present] == -1).all()
        counted, robots = plain.counted, plain.robots
        speaking = {each.number for each in robots if each.mind.disseminating and each.works(plain.time)}
        assert set(np.flatnonzero(swarm.disseminating)) == speaking  # the stopped are silent
        assert set(np.flatnonzero(swarm.counted)) == {each.number for each in counted}
        declared = swarm.declared
        np.testing.assert_array_equal(declared[there], [each.mind.declared for each in robots])
        np.testing.assert_array_equal(swarm.snapshot().flags >> FLAGS.index("declared") & 1, declared >= 0)
        assert ((declared == before) | (before == -1)).all()  # once and for good
        assert swarm.declared_counts == (plain.declared(1), plain.declared(0))
        before = declared
        assert swarm.truth == swarm.truths[-1] == swarm.verdict.feasible == plain.truth
        counts = swarm.robot_counts[-1], swarm.task_counts[-1], swarm.counted_counts[-1]
        assert counts == (len(robots), len(plain.tasks), len(counted))
        assert swarm.feasible_count == plain.feasible_count
        assert swarm.infeasible_count == plain.infeasible_count
        assert swarm.bits_sent == plain.bits_sent
        assert swarm.decision == plain.decision
        swarm.advance()
        plain.step()


CROWDED = {"arena.side": 6.0, "decision.gain": 40.0}
BEYOND = {
    "the paper's": CROWDED,
    "the paper's, of forty": {**CROWDED, "robots.count": 40},
    "the paper's, of seventy": {**CROWDED, "robots.count": 70},
    "the paper's, of 130": {**CROWDED, "robots.count": 130},
    "walls and collisions": {
        "arena.side": [8.0, 12.0],
        "arena.boundary": "walls",
        "robots.avoid_collisions": True,
        "robots.count": 66,
    },
    "few in a crowd": {"arena.side": 7.0, "robots.avoid_collisions": True, "robots.speed": 0.3},
    "few that deflect": {
        "arena.side": 7.0,
        "arena.boundary": "walls",
        "robots.avoid_collisions": True,
        "robots.contact": "deflect",
        "robots.speed": 0.5,
        "faults.stopped": 0.2,
        "faults.stop_step": 9,
    },
    "eighty that deflect, miss, lose and lie": {
        "arena.side": [13.0, 16.0],
        "sensing.miss": 0.2,
        "sensing.count_self": True,
        "radio.range": 3.0,
        "radio.loss": 0.2,
        "faults.byzantine": 0.2,
        "robots.count": 80,
        "robots.avoid_collisions": True,
        "robots.contact": "deflect",
        "robots.speed": 0.4,
    },
    "many that deflect": {
        "arena.side": [15.0, 18.0],
        "robots.count": 130,
        "robots.avoid_collisions": True,
        "robots.contact": "deflect",
        "robots.speed": 0.4,
    },
    "a rectangular torus": {"arena.side": [9.0, 4.5], "robots.count": 33, "sensing.observation": "unique"},
    "clusters and a bad sensor": {
        "robots.placement": "clusters",
        "tasks.placement": "clusters",
        "sensing.miss": 0.3,
        "sensing.false_robots": 0.5,
        "sensing.false_tasks": 0.7,
        "radio.loss": 0.4,
        "arena.side": 10.0,
    },
    "faults": {
        "faults.stopped": 0.25,
        "faults.stop_step": 9,
        "faults.byzantine": 0.25,
        "faults.byzantine_says": "random",
        "faults.stubborn": 0.25,
        "arena.side": 10.0,
        "robots.avoid_collisions": True,
    },
    "one class of each, with several places a task": {
        "robots.classes": [{"name": "a", "count": 20, "skills": ["lift"]}],
        "tasks.classes": [{"name": "x", "count": 9, "needs": {"lift": 2, "scan": 1}}],
        "arena.side": 10.0,
    },
    "a mixed team that remembers": {
        "robots.classes": [
            {"name": "a", "count": 20, "skills": ["lift"]},
            {"name": "b", "count": 15, "skills": ["lift", "scan"]},
        ],
        "tasks.classes": [
            {"name": "x", "count": 9, "needs": {"lift": 2, "scan": 1}},
            {"name": "y", "count": 4, "needs": {"push": 1}},
        ],
        "sensing.observation": "unique",
        "arena.side": 10.0,
    },
}


@pytest.mark.quick(5)
@pytest.mark.parametrize("name", BEYOND)
def test_a_swarm_step_by_step_is_the_references_swarm(name):
    scenario = Scenario().replace({"decision.exploration": 4.0, **BEYOND[name]})
    assert_same_swarms(scenario, seed=6, run=4, steps=25)


# --- The strategies ---

QUICK = {"arena.side": 10.0, "decision.exploration": 5.0, "decision.gain": 8.0, "run.steps": 90}
BY_VOTES = {"decision.declare": {"quorum": 0.6, "rounds": 2, "heard": 2}}
WORLDS = {
    "twenty": {},
    "forty": {"robots.count": 40},
    "a hundred and thirty": {"robots.count": 130, "arena.side": 24.0, "run.steps": 25},
    "all that can go wrong": {
        "arena.boundary": "walls",
        "robots.avoid_collisions": True,
        "radio.loss": 0.2,
        "faults.byzantine": 0.2,
        "faults.byzantine_says": "random",
        "faults.stubborn": 0.1,
        "faults.stopped": 0.1,
        "faults.stop_step": 30,
    },
    "liars that say feasible, and few ids": {
        "faults.byzantine": 0.2,
        "faults.byzantine_says": "feasible",
        "radio.id_bits": 4,
        "decision.inbox_size": 4,
        **BY_VOTES,
    },
    "classes": {
        "robots.classes": [
            {"name": "a", "count": 12, "skills": ["lift"]},
            {"name": "b", "count": 8, "skills": ["lift", "scan"]},
        ],
        "tasks.classes": [
            {"name": "x", "count": 6, "needs": {"lift": 2, "scan": 1}},
            {"name": "y", "count": 4, "needs": {"lift": 1}},
        ],
        "faults.byzantine": 0.1,
    },
    "declaring by votes": {**BY_VOTES, "decision.listen": {"last": 3}, "decision.dissemination_floor": 2},
    "colluders that invent tasks": {
        "arena.side": [12.0, 8.0],
        "robots.count": 33,
        "tasks.count": 30,
        "faults.byzantine": 0.1,
        "faults.byzantine_says": "colluding",
        "faults.stopped": 0.1,
        "faults.stop_step": 30,
    },
    "colluders that invent robots": {
        "tasks.count": 23,
        "faults.byzantine": 0.1,
        "faults.byzantine_says": "colluding",
        "radio.id_bits": 4,
    },
}
SLOW_WORLDS = (
    "forty",
    "a hundred and thirty",
    "liars that say feasible, and few ids",
    "declaring by votes",
    "colluders that invent robots",
)


def small_scenario(name, changes):
    """Return a small scenario of a strategy with some changes; None if the strategy doesn't support them."""
    known = {"robots.know_count": True} if STRATEGIES[name].needs_count else {}
    with suppress(ScenarioError):
        return Scenario().replace({**QUICK, "decision.strategy": name, **known, **changes})


@pytest.mark.quick(8)
@pytest.mark.parametrize(
    "world", [pytest.param(each, marks=[pytest.mark.slow] * (each in SLOW_WORLDS)) for each in WORLDS]
)
@pytest.mark.parametrize("name", STRATEGIES)
def test_every_strategy_is_equal_in_every_world(name, world):
    """All strategies in all worlds keep their bytes in test_same_bytes, too."""
    scenario = small_scenario(name, WORLDS[world])
    if scenario:
        assert_equal(scenario, seed=7)
    else:
        assert STRATEGIES[name].one_class or STRATEGIES[name].declares


FRESH = {"decision.start": "first-sight", "decision.exploration": 4.0}
SEVENTY = {"robots.count": 70, "run.steps": 20}


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("dmmd", {"faults.stubborn": 0.2, "faults.byzantine": 0.2}),
        ("dc", {"robots.count": 40, "run.steps": 30}),
        ("k-unanimity", SEVENTY),
        ("cross-inhibition", {**SEVENTY, "faults.stubborn": 0.2}),
        ("dmmd", {"robots.arrival_rate": 0.5, "robots.failure_rate": 0.05, "robots.most": 30}),
    ],
)
def test_robots_that_begin_with_their_first_sight_are_equal(name, changes):
    scenario = small_scenario(name, {**FRESH, **changes})
    record = assert_equal(scenario, seed=7)
    tossed = assert_equal(scenario.replace({"decision.start": "coin"}), seed=7)
    assert (record.feasible_count != tossed.feasible_count).any()


@pytest.mark.parametrize("name", ["census", "tally"])
def test_robots_that_all_see_and_hear_each_other_are_equal(name):
    """Their queue of what they learn is full several times in a step, at a word or at a false sighting."""
    near = {"arena.side": 8.5, "sensing.range": 4.0, "radio.range": 4.0, "run.steps": 40}
    things = {"robots.count": 32, "tasks.count": 128}
    wrong = {} if STRATEGIES[name].by_name else {"sensing.false_robots": 0.5, "sensing.false_tasks": 0.5}
    assert_equal(small_scenario(name, {**near, **things, **wrong}), seed=7)


DECLARING = [name for name, each in STRATEGIES.items() if each.declares]
COLLUDING = {"faults.byzantine": 0.15, "faults.byzantine_says": "colluding", "run.steps": 60}


@pytest.mark.quick(2)
@pytest.mark.parametrize("tasks", [15, 25])
@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("name", DECLARING)
def test_declarations_among_colluding_robots_are_equal(name, known, tasks):
    believed = {"tolerates": 3.0} if "tolerates" in STRATEGIES[name].parameters else {}
    for parameters in ({}, believed):
        changes = {"tasks.count": tasks, "robots.know_count": known, "decision.parameters": parameters}
        if known or not STRATEGIES[name].needs_count:
            assert_equal(small_scenario(name, {**COLLUDING, **changes}), seed=9)


@pytest.mark.quick(1)
@pytest.mark.parametrize("parameters", [{"names": 0.0}, {"names": 3.0, "tolerates": 1.0}, {"names": -1.0}])
def test_messages_of_turns_are_equal(parameters):
    for world in ({}, {**COLLUDING, "tasks.count": 17}, {**COLLUDING, "tasks.count": 24}):
        assert_equal(small_scenario("turns", {**world, "decision.parameters": parameters}), seed=10)


@pytest.mark.quick(6)
@pytest.mark.parametrize("name", STRATEGIES)
def test_a_swarm_of_every_strategy_step_by_step_is_the_references_swarm(name):
    changes = {**({} if name in DECLARING else BY_VOTES), "faults.byzantine": 0.1}
    assert_same_swarms(small_scenario(name, changes), seed=8, run=1, steps=50)


def test_opinions_none_at_all_and_declaring_do_occur_in_what_is_compared():
    """Else the comparisons above would compare nothing."""
    for name in ("cross-inhibition", "bayes"):
        scenario = Scenario().replace({**QUICK, "decision.strategy": name})
        record = simulate_record(scenario, Runs(1, 7), curves=True)
        assert (record.feasible_count + record.infeasible_count < 20).any()
    for name in STRATEGIES:
        if name in DECLARING:
            record = simulate_record(small_scenario(name, {}), Runs(20, 7))
            assert record.declared_feasible.any() or record.declared_infeasible.any(), name
            continue
        scenario = small_scenario(name, BY_VOTES)
        record = simulate_record(scenario, Runs(20, 7))
        assert record.declared_feasible.any() or record.declared_infeasible.any(), name
        assert (record.bits_sent > 0).all()


# --- Swarms of worlds that change, step by step ---

CHANGING = {
    "run.steps": 60,
    "arena.side": 10.0,
    "decision.exploration": 5.0,
    "decision.gain": 8.0,
    "events": [
        {"step": 0, "tasks": 3, "robots": -2},
        {"step": 4, "robots": -9, "tasks": -12},
        {"step": 9, "robots": 6, "radio": {"loss": 0.3}},
        {"step": 9, "tasks": 14, "sensing": {"miss": 0.2}},
    ],
    "tasks.arrival_rate": 0.5,
    "tasks.lifetime": 40.0,
    "robots.arrival_rate": 0.3,
    "robots.failure_rate": 0.01,
}
CHANGING_WORLDS = {
    "twenty": {},
    "forty that collide": {"robots.count": 40, "arena.boundary": "walls", "robots.avoid_collisions": True},
    "130 that collide": {
        "robots.count": 130,
        "arena.side": 18.0,
        "arena.boundary": "walls",
        "robots.avoid_collisions": True,
    },
    "twenty that deflect": {"arena.side": 8.0, "robots.avoid_collisions": True, "robots.contact": "deflect"},
    "faults": {
        "faults.byzantine": 0.2,
        "faults.byzantine_says": "random",
        "faults.stopped": 0.2,
        "faults.stop_step": 7,
        "faults.stubborn": 0.1,
        "sensing.observation": "unique",
    },
    "classes": {
        "robots.classes": BEYOND["a mixed team that remembers"]["robots.classes"],
        "tasks.classes": WORLDS["classes"]["tasks.classes"],
    },
    "names": {"decision.strategy": "census"},
    "named and placed": {
        "robots.avoid_collisions": True,
        "events": [
            {"step": 0, "tasks": 3, "at": [1.0, 2.0]},
            *({"step": 5, kind: 3, "at": [5.0, 5.0]} for kind in ("robots", "robot", "task")),
            *({"step": 6, kind: 4} for kind in ("robot", "task")),
            {"step": 7, "robots": 2, "at": [8.0, 1.5]},
            *({"step": k, "robot": k, "at": [0.5 * k, 5.0]} for k in range(8, 19)),
            *({"step": 20, "robot": k, "at": [1.2 * k, y]} for k in range(9) for y in (3.0, 3.3)),
            {"step": 19, "task": 22},
        ],
    },
    "all go": {"events": [{"step": 3, "tasks": -900, "robots": -900}, {"step": 20, "tasks": 2, "robots": 1}]},
}


@pytest.mark.quick(2)
@pytest.mark.parametrize("world", CHANGING_WORLDS)
def test_a_swarm_of_a_changing_world_step_by_step_is_the_references_swarm(world):
    assert_same_swarms(Scenario().replace({**CHANGING, **CHANGING_WORLDS[world]}), seed=3, run=5, steps=60)


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    "parameters", [{}, {"robot_timeout": 12.0, "looks": 1.0}, {"robot_timeout": 30.0, "tolerates": 1.0}]
)
def test_names_that_are_forgotten_are_equal(parameters):
    changes = {"decision.strategy": "roster", "decision.parameters": parameters}
    for world in ({}, {"robots.know_count": True, "arena.boundary": "walls"}, COLLUDING):
        assert_equal(Scenario().replace({**CHANGING, **changes, **world}), seed=11)
