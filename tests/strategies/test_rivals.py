"""Rules of other authors in `examples/rivals/`: each decides as its source says, in both implementations."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from scipy import stats

from feasibee import Scenario, simulate, truth
from feasibee.scenario.plugins import load
from feasibee.strategies.contract import Inbox, Mind

FOLDER = Path(__file__).parents[2] / "examples" / "rivals"
NAMES = ["crosscombe_2017", "ebert_2020", "evolved", "subcdm", "valentini_2016"]
FOUND = {
    "crosscombe_2017": ([7, 18, 11, 6], [0, 10, 0, 0]),
    "ebert_2020": ([20, 20, 20, 20], [0, 0, 0, 0]),
    "evolved": ([20, 20, 20, 20], [0, 0, 0, 0]),
    "subcdm": ([12, 8, 16, 14], [2, 8, 10, 9]),
    "valentini_2016": ([19, 18, 20, 20], [0, 0, 0, 0]),
}
SHORT = {"robots.count": 10, "tasks.count": 6, "arena.side": 10.0, "run.steps": 150}


def strategy(name):
    return load(str(FOLDER / f"{name}.py"))


def imported(name):
    """Return a file of the folder as a module."""
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def decision(name, opinion, votes, *, seen=0.5, chance=0.0, heard=-1, value=1.0, **parameters):
    """Return what a robot decides that heard (feasible, infeasible) votes."""
    rule = strategy(name)
    values = [parameters.get(key, default) for key, default in rule.parameters.items()]
    mind = Mind(opinion, 0.5, seen, 1, [0.0] * rule.memory, values)
    return rule.decide(mind, Inbox(*votes, heard, value, value, chance))


def test_every_file_is_tested():
    assert sorted(path.stem for path in FOLDER.glob("*.py")) == sorted([*NAMES, "evolve"])
    assert {path.stem for path in FOLDER.glob("*.toml")} == {*NAMES, "tiles"} - {"evolved"}


@pytest.mark.parametrize("name", NAMES)
def test_a_rival_decides_alike_in_both_implementations(name):
    scenario = Scenario().replace({**SHORT, "decision.strategy": str(FOLDER / f"{name}.py")})
    engine, plain = (
        simulate(scenario, runs=2, seed=5, curves=True, backend=each) for each in ("engine", "reference")
    )
    assert plain.equals(engine)


@pytest.mark.parametrize(("name", "feasible"), FOUND.items())
def test_a_rival_gives_the_same_small_result_as_before(name, feasible):
    """Robots that hold *feasible* after 500 steps, in four swarms with ten tasks and four with 40."""
    path = FOLDER / f"{name}.toml"
    own = {"strategy": str(FOLDER / f"{name}.py")}
    base = Scenario.read(path) if path.exists() else Scenario(decision=own)
    for tasks, expected in zip((10, 40), feasible, strict=True):
        found = simulate(base.replace({"tasks.count": tasks, "run.steps": 500}), runs=4, seed=3)
        assert found["feasible_at_end"].values.tolist() == expected


# --- The rules ---


@pytest.mark.parametrize(
    ("opinion", "votes", "share"),
    [
        (0, (2, 0), 2 / 3),  # two heard and its own: each has one chance in three
        (1, (2, 0), 1.0),
        (1, (1, 1), 2 / 3),
        (0, (1, 0), 1 / 2),  # one that differs: a coin
        (1, (1, 0), 1.0),
        (0, (0, 0), 0.0),  # nobody: it keeps its own
        (1, (0, 0), 1.0),
    ],
)
def test_subcdm_draws_from_what_it_heard_and_its_own(opinion, votes, share):
    for k in range(60):
        assert decision("subcdm", opinion, votes, chance=(k + 0.5) / 60) == ((k + 0.5) / 60 < share)


def test_valentini_leaves_its_own_opinion_out_and_breaks_ties_by_what_it_saw():
    assert decision("valentini_2016", 0, (1, 0), seen=0.1) == 1
    assert decision("valentini_2016", 1, (1, 2), seen=0.9) == 0
    for votes in ((0, 0), (2, 2)):
        assert decision("valentini_2016", 0, votes, seen=0.6) == 1
        assert decision("valentini_2016", 1, votes, seen=0.4) == 0
    assert decision("valentini_2016", 0, (1, 2), heard=1, seen=0.1, voter=1.0) == 1
    assert decision("valentini_2016", 0, (0, 0), seen=0.9, voter=1.0) == 1


@pytest.mark.parametrize("opinion", [1, 0, -1])
@pytest.mark.parametrize("heard", [1, 0])
def test_crosscombe_is_unsure_after_a_contradiction(opinion, heard):
    expected = heard if opinion in (heard, -1) else -1
    assert decision("crosscombe_2017", opinion, (1, 1), heard=heard) == expected
    assert (
        decision("crosscombe_2017", opinion, (1, 1), heard=heard, value=0.0) == opinion
    )  # an unsure message
    assert decision("crosscombe_2017", opinion, (0, 0)) == opinion


@pytest.mark.parametrize(("less", "more"), [(10, 11), (10, 25), (300, 420), (1, 4)])
def test_the_doubt_of_ebert_is_that_of_the_beta_distribution(less, more):
    assert imported("ebert_2020").doubt(float(less), float(more)) == pytest.approx(
        stats.beta.cdf(0.5, more, less), rel=1e-9
    )


def test_ebert_without_its_prior_is_the_built_in_bayes():
    same = {**SHORT, "decision.parameters.positive_feedback": 0.0, "run.steps": 400}
    ebert = {**same, "decision.parameters.prior": 1.0, "decision.parameters.threshold": 0.99}
    ours = Scenario().replace({**ebert, "decision.strategy": str(FOLDER / "ebert_2020.py")})
    built_in = Scenario().replace(
        {**same, "decision.strategy": "bayes", "decision.parameters.credence": 0.99}
    )
    first, second = (simulate(each, runs=20, seed=2) for each in (ours, built_in))
    assert first["decision_step"].equals(second["decision_step"])
    assert (first["decision"] >= 0).sum() > 10


def test_the_weights_of_the_net_are_those_that_evolution_found():
    """The loss of the committed weights is that of the last generation of `evolve.py`."""
    parameters = strategy("evolved").parameters
    loss = imported("evolve").wrong(list(parameters.values()), list(parameters))
    assert loss == pytest.approx(0.013392857, abs=1e-9)


def test_robots_on_tiles_read_colours_only():
    """At the rates of the tiles and of a sensor, alike in both implementations."""
    scenario = Scenario.read(FOLDER / "tiles.toml").replace({"run.steps": 60, "decision.exploration": 1000.0})
    assert not truth(scenario)
    assert scenario.sensing.false_tasks == pytest.approx(0.675 * 0.95 + 0.325 * 0.05)
    assert scenario.sensing.false_robots == pytest.approx(1 - scenario.sensing.false_tasks)
    one, other = (simulate(scenario, runs=2, seed=3, backend=each) for each in ("engine", "reference"))
    assert one.equals(other)
