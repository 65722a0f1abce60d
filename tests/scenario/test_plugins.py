"""Strategies of the user's own: found, checked, run at speed; what is wrong with them, told by its line."""

from __future__ import annotations

import importlib.metadata

import numpy as np
import pytest
from own_files import LAID_OUT, MINE, assert_same

from feasibee import FeasibeeError, Scenario, ScenarioError, Swarm
from feasibee.robot import Message, Wire
from feasibee.scenario import plugins
from feasibee.scenario.plugins import load
from feasibee.scenario.runs import Runs
from feasibee.scenario.setting import setting_from
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES

SMALL = {"arena.side": 8.0, "run.steps": 40}


def scenario_of(path, **changes):
    return Scenario().replace({**SMALL, "decision.strategy": str(path), **changes})


def told(path, **tables):
    """Return the one problem of a scenario with a strategy."""
    with pytest.raises(ScenarioError) as caught:
        Scenario(decision={"strategy": str(path), **tables})
    (problem,) = caught.value.problems
    assert (problem.path, problem.value) == ("decision.strategy", str(path))
    assert len(str(caught.value).splitlines()) == 1
    return problem.rule


# --- A file of one's own ---


def test_a_file_runs(write):
    scenario = scenario_of(write(MINE))
    assert scenario.decision.parameters == {"weight": 2.0}
    assert Swarm(scenario).opinions.size == 20


def test_a_path_in_a_file_is_from_the_scenarios_folder(write, tmp_path, monkeypatch):
    write(MINE, "deep/mine.py")
    (tmp_path / "deep" / "swarm.toml").write_text('[decision]\nstrategy = "mine.py"\n')
    monkeypatch.chdir(tmp_path)
    scenario = Scenario.read("deep/swarm.toml")
    assert "def decide" in scenario.strategy.source
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    absolute = tmp_path / "absolute.toml"
    absolute.write_text(f'[decision]\nstrategy = "{tmp_path}/deep/mine.py"\n')
    assert Scenario.read(absolute).hash == scenario.hash


def test_a_strategy_is_the_text_of_its_file_and_not_its_path(write):
    path = write(MINE)
    first = scenario_of(path)
    assert first.hash != Scenario().replace(SMALL).hash
    assert scenario_of(write(MINE, "b.py")).hash == first.hash
    stays = simulate_record(first, Runs(3, 1), curves=True)
    path.write_text(MINE.replace("if lead > 0", "if lead < 0"))
    other = scenario_of(path)
    assert other.hash != first.hash
    assert not np.array_equal(
        simulate_record(other, Runs(3, 1), curves=True).feasible_count, stays.feasible_count
    )


def test_parameters_are_the_files_own(write):
    path = write(MINE)
    strict = scenario_of(path, **{"decision.parameters": {"weight": 1000}})
    assert strict.decision.parameters == {"weight": 1000.0}
    curves = simulate_record(strict, Runs(3, 2), curves=True).feasible_count
    assert (curves == curves[:, :1]).all()  # no lead is large enough: nobody ever changes
    assert strict.hash != scenario_of(path).hash
    with pytest.raises(ScenarioError) as caught:
        scenario_of(path, **{"decision.parameters": {"wait": 1.0}})
    assert "decision.parameters.wait = 1.0: " in str(caught.value)
    assert "it has weight" in str(caught.value)


# --- Strategies of other packages ---


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Install a package that registers strategies, as its metadata says."""

    def install(lines, **files):
        for name, text in files.items():
            (tmp_path / f"{name}.py").write_text(text)
        metadata = tmp_path / "fable-1.0.dist-info"
        metadata.mkdir()
        (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: fable\nVersion: 1.0\n")
        (metadata / "entry_points.txt").write_text("[feasibee.strategies]\n" + "\n".join(lines) + "\n")
        monkeypatch.syspath_prepend(str(tmp_path))

    return install


def test_a_package_registers_strategies_by_name(package, write):
    package(["fable = fable_one"], fable_one=MINE)
    assert [each.name for each in importlib.metadata.entry_points(group="feasibee.strategies")] == ["fable"]
    assert plugins.registered() == ["fable"]
    scenario = scenario_of("fable")
    assert scenario.strategy.name == "fable"
    assert_same(scenario_of(write(MINE)), scenario)
    assert scenario.hash == scenario_of(write(MINE)).hash
    with pytest.raises(ScenarioError, match=r"or one of dmmd, .*, census, .*, fable"):
        Scenario(decision={"strategy": "fables"})


def test_a_built_in_name_is_not_taken_over(package):
    package(["dmmd = fable_one"], fable_one="1 / 0")
    assert Scenario().strategy is STRATEGIES["dmmd"]


@pytest.mark.parametrize(
    ("target", "text", "words"),
    [
        ("fable_two", MINE.replace("def decide(", "def other("), "fable: has no function decide"),
        ("fable_none", MINE, "fable_none isn't a module in a .py file"),
        ("fable_two.none", MINE, "fable_two.none isn't a module in a .py file"),
        ("fable_two:decide", MINE, "fable_two:decide isn't a module"),
    ],
)
def test_what_is_wrong_with_a_registered_strategy_is_told(package, target, text, words):
    package([f"fable = {target}"], fable_two=text)
    assert words in told("fable")


def test_a_module_within_a_package_is_found_and_the_package_is_not_imported(package, tmp_path, write):
    (tmp_path / "fable_deep").mkdir()
    (tmp_path / "fable_deep" / "__init__.py").write_text("raise SystemExit('imported')")
    (tmp_path / "fable_deep" / "inner.py").write_text(MINE)
    package(["fable = fable_deep.inner"])
    assert scenario_of("fable").hash == scenario_of(write(MINE)).hash


@pytest.mark.parametrize("changes", [{}, {"radio.loss": 0.1}])
def test_a_failure_in_a_large_swarm_is_told_with_its_line(write, changes):
    """The reference, which names the arguments, too, would take too long for it."""
    text = MINE.replace("    lead = ", "    if 0.0 < inbox.chance < 0.2:\n        return 7\n    lead = ")
    scenario = scenario_of(write(text), **{"robots.count": 3000, "arena.side": 200.0, **changes})
    with pytest.raises(FeasibeeError, match=r"line 16: decide returns 7; must be .* \(in run 3 of seed 1\)"):
        simulate_record(scenario, Runs(1, 1, 3))


# --- Messages as bytes, by one function ---


def test_a_layout_makes_pack_and_unpack(write):
    strategy = load(str(write(LAID_OUT)))
    setting = setting_from((3, 2), (0, 0), False, None, ())
    wire = Wire(strategy, 2, setting=setting)
    message = Message(-1, knowledge=(1, 0, 1, 0, 1))
    assert wire.is_exact
    assert wire.bits(2, message) == 5
    assert wire.decode(wire.encode(2, message)) == (-1, message)
    assert {"layout", "pack", "unpack"} <= strategy.functions
