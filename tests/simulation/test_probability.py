"""What robots say how probable feasible is, at the end of a run: built-in and users' strategies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from declaring import declaring
from scipy.stats import beta, t

from feasibee import FeasibeeError, Scenario, Swarm, simulate
from feasibee.base.codes import CERTAIN
from feasibee.base.outcomes import OUTCOMES
from feasibee.results.calibration import said_feasible
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES
from feasibee.strategies.bayes import probability
from feasibee.strategies.contract import Mind
from feasibee.strategies.estimate import below_zero

WITNESS = (Path(__file__).parents[2] / "examples" / "strategies" / "witness.py").read_text(encoding="utf-8")
QUALITY = """

def probability(mind, known, setting):
    return half(mind.feasible_quality + (1.0 if setting.robots == 20 and len(known) == 0 else 0.5))


def half(number):
    return 0.5 * number
"""
"""With a helper, and all that a robot without knowledge is given."""
SURE = """

def probability(mind, known, setting):
    return 0.25 if known[0] == 1 else 0.125  # the robot with id 0 is known to itself, at least
"""


def both(scenario, runs=2, seed=7):
    """Return the record of an engine that does as the reference does."""
    engine = simulate_record(scenario, Runs(runs, seed))
    plain = simulate_record(scenario, Runs(runs, seed), backend="reference")
    np.testing.assert_array_equal(engine.account, plain.account)
    return engine


@pytest.fixture
def mine(tmp_path):
    """Return the scenario of a strategy with this text."""

    def of(text, **sections):
        path = tmp_path / "mine.py"
        path.write_text(text, encoding="utf-8")
        return Scenario(decision={"strategy": str(path)}, **sections)

    return of


def test_robots_or_tasks_with_classes_are_not_asked():
    scenario = Scenario(
        tasks={"classes": [{"name": "heavy", "count": 8, "needs": {"lift": 2}}]},
        robots={"classes": [{"name": "arm", "count": 20, "skills": ["lift"]}]},
        decision={"strategy": "estimate"},
        run={"steps": 100},
    )
    assert not scenario.gives_probability
    record = both(scenario)
    assert (record.said_at_end == 0).all()
    np.testing.assert_array_equal(said_feasible(record, scenario), record.feasible_at_end / 20)


def test_threads_that_share_a_swarm_say_the_same_as_one():
    scenario = Scenario(
        robots={"count": 4500}, arena={"side": 300.0}, decision={"strategy": "bayes"}, run={"steps": 40}
    )
    one, two = (simulate_record(scenario, Runs(1, 1), threads=each) for each in (1, 4))
    np.testing.assert_array_equal(one.account, two.account)
    assert one.said_at_end[0] > 0


def test_robots_that_have_declared_say_one_or_zero(tmp_path):
    """By votes, and by a strategy of one's own; also if a run ends once all have declared."""
    scenario = declaring(tmp_path, 10.0, tasks={"count": 21}, arena={"side": 8.0}, run={"steps": 60})
    path = Path(scenario.decision.strategy)
    path.write_text(path.read_text(encoding="utf-8") + SURE, encoding="utf-8")
    scenario = declared = Scenario(**scenario.to_dict())
    record = both(declared)
    assert (record.said_at_end == CERTAIN * record.declared_feasible).all()
    assert (record.declared_infeasible > 0).any()
    stopped = both(declared.replace({"run.stop_at_declarations": True}))
    assert (stopped.last_step < 60).all()
    np.testing.assert_array_equal(stopped.said_at_end, record.said_at_end)
    undecided = both(scenario.replace({"decision.parameters.quiet": 1000.0, "run.steps": 1}))
    assert (undecided.said_at_end <= 20 * CERTAIN // 4).all()
    votes = Scenario(decision={"strategy": "bayes", "declare": {"rounds": 2}}, tasks={"count": 5})
    record = both(votes.replace({"run.steps": 300}))
    certain = CERTAIN * record.declared_feasible
    unsure = 20 - record.declared_feasible - record.declared_infeasible
    assert ((record.declared_feasible > 10) & (certain <= record.said_at_end)).all()
    assert (record.said_at_end <= certain + CERTAIN * unsure).all()


def test_a_file_with_the_function_has_a_column_and_is_otherwise_as_without(mine):
    sections = {"run": {"steps": 60}}
    without = mine(WITNESS, **sections)
    assert not without.gives_probability
    assert "said_at_end" not in simulate(without, 2)
    plain = simulate_record(without, Runs(4, 7))
    scenario = mine(WITNESS + QUALITY, **sections)
    record = both(scenario, 4)
    assert "said_at_end" in simulate(scenario, 2)
    for name in {each.name for each in OUTCOMES} - {"said_at_end"}:
        np.testing.assert_array_equal(getattr(record, name), getattr(plain, name), name)
    swarm = Swarm(scenario, 7)
    swarm.advance(60)
    said = [0.5 * (swarm.robot(i).feasible_quality + 1.0) for i in range(20)]
    assert record.said_at_end[0] == sum(int(each * CERTAIN + 0.5) for each in said)
    assert said_feasible(record, scenario)[0] == pytest.approx(np.mean(said), abs=1e-6)


def test_a_swarm_in_a_world_that_changes_is_not_asked(mine):
    scenario = mine(WITNESS + QUALITY, tasks={"arrival_rate": 0.01}, run={"steps": 20})
    assert not scenario.gives_probability
    assert (both(scenario).said_at_end == 0).all()


@pytest.mark.parametrize(
    ("returned", "words"),
    [
        ("1.5", "returns 1.5; must be a number from 0 to 1"),
        ("None", "returns None; must be a number from 0 to 1"),
        ("mind.memory.__setitem__(0, 1.0)", "object has no attribute '__setitem__'"),
        ("known[0]", "IndexError"),
    ],
)
def test_what_is_wrong_with_the_function_is_told_with_its_line(mine, returned, words):
    wrong = f"MEMORY = 1\n\n\ndef probability(mind, known, setting): return {returned}\n"
    with pytest.raises(FeasibeeError, match=r"mine\.py, line ") as caught:
        simulate(mine(f"{WITNESS}\n\n{wrong}"))
    assert words in str(caught.value)


def test_a_function_that_does_not_compile_or_fails_late_is_told_with_its_line(mine):
    for body, words in (
        ("{1: 0.5}[1]", "probability doesn't compile"),
        ("0.5 if mind.opinion < 2 and setting.robots < 20 else 1.5", "returns 1.5; must be a number from 0"),
    ):
        text = f"{WITNESS}\n\ndef probability(mind, known, setting): return {body}\n"
        with pytest.raises(FeasibeeError, match=words):
            simulate(mine(text, run={"steps": 5}))


def test_arguments_are_checked(mine):
    with pytest.raises(FeasibeeError, match=r"must take 3; write def probability\(mind, known, setting\)"):
        mine(f"{WITNESS}\n\ndef probability(mind): return 0.5\n")


# --- The built-in probabilities ---


def test_bayes_has_the_tail_of_its_belief():
    for counts in ((0, 0), (3, 0), (0, 1), (40, 31), (100, 160), (2000, 2050)):
        mind = Mind(-1, 0.5, 0.5, 1, [float(each) for each in counts], [0.95, 1.0])
        expected = beta(counts[0] + 1, counts[1] + 1).sf(0.5)
        assert probability(mind, (), None) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("samples", [3, 5, 21, 4, 20])
def test_a_few_samples_say_what_students_distribution_says(samples):
    rng = np.random.default_rng(samples)
    freedom = (samples - 1) // 2 * 2
    for shift in (-2, -0.3, 0, 0.1, 5):
        drawn = rng.normal(shift, 1, samples)
        standard = drawn.mean() / (drawn.std(ddof=1) / np.sqrt(samples))
        found = below_zero(drawn.sum(), (drawn**2).sum(), samples)
        assert found == pytest.approx(t(freedom).cdf(-standard), abs=1e-9)


def test_too_few_or_equal_samples():
    assert below_zero(-7.0, 25.0, 2) == 0.5
    assert [below_zero(each, each * each / 4, 4) for each in (-8.0, 0.0, 8.0)] == [1.0, 0.5, 0.0]


def test_which_built_in_strategies_have_one():
    assert {name for name, each in STRATEGIES.items() if each.gives_probability} == {"bayes", "estimate"}
