"""Strategies of the user's own: found, checked, run at speed; what is wrong with them, told by its line."""

from __future__ import annotations

import importlib.metadata
import inspect
from pathlib import Path

import numpy as np
import pytest
from own_files import MINE, assert_same, copy_of, replaced, why_not

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


def told_when_run(path):
    """Return what is said of a file that can be a strategy by its text, but isn't one."""
    return why_not(Scenario(decision={"strategy": str(path)}))


# --- A file of one's own ---


def test_a_file_runs_and_is_equal_in_engine_and_reference(write):
    scenario = scenario_of(write(MINE))
    assert scenario.decision.parameters == {"weight": 2.0}
    assert_same(scenario, scenario)
    assert Swarm(scenario).opinions.size == 20


def test_a_constant_says_that_broadcasts_are_modulated(write):
    dissemination = "def dissemination(quality, gain):\n    return gain * quality"
    same = scenario_of(write(replaced(MINE, dissemination, "MODULATES = True")))
    assert_same(scenario_of(write(MINE, "function.py")), same)


def test_what_a_robot_knows_may_set_for_how_long_it_broadcasts(write):
    lasting = "def lasting(mind, gain):\n    return gain * mind.parameters[0] * mind.feasible_quality\n"
    scenario = scenario_of(write(f"{MINE}\n\n{lasting}"))
    assert_same(scenario, scenario)
    shorter = scenario.replace({"decision.parameters": {"weight": 0.0}})
    assert mean_bits(shorter) < mean_bits(scenario) / 3


def mean_bits(scenario):
    return simulate_record(scenario, Runs(5, 1)).bits_sent.mean()


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


LIARS = {"faults.byzantine": 0.2}
CREDENT = {"decision.parameters": {"credence": 0.8}}
COPIES = {
    "dmmd": [{}, {"robots.count": 40}, {**LIARS, "radio.loss": 0.1}],
    "bayes": [{}, {**LIARS, **CREDENT}],
}
SLOW = ("dc", "cross-inhibition", "k-unanimity")


@pytest.mark.parametrize("name", [*COPIES, *(pytest.param(each, marks=pytest.mark.slow) for each in SLOW)])
def test_a_copy_of_an_opinion_strategy_is_that_strategy(write, name):
    """Values, parameters, and robots without an opinion, all by the constants of the file."""
    path = write(copy_of(name))
    for changes in COPIES.get(name, [{}]):
        built_in = Scenario().replace({**SMALL, "decision.strategy": name, **changes})
        record = assert_same(built_in, scenario_of(path, **changes))
        assert (record.feasible_count.min(axis=1) < built_in.robots.count).all()


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


@pytest.mark.slow
def test_the_functions_have_what_the_contract_says(write):
    """The fields of mind and inbox, in the engine as in the reference."""
    text = MINE.replace(
        "    lead = ",
        "    if mind.quality + mind.feasible_quality + mind.own_vote + inbox.heard_value < 0.0:\n"
        "        return -1\n"
        "    if inbox.chance < 0.1 and inbox.heard_opinion >= 0 and inbox.mean_value < 0.9:\n"
        "        return inbox.heard_opinion\n"
        "    mind.memory[1] += 1.0\n"
        "    if mind.memory[1] > 3.0:\n"
        "        return -1\n"
        "    lead = ",
    )
    text += "\n\ndef say(mind):\n    return 1 if mind.memory[1] > 1.0 else mind.opinion\n"
    text += "\n\ndef value(mind):\n    return mind.memory[1] / 4.0\n"
    text += "\n\nMEMORY = 2\nVALUE_BITS = 3\nFORGETS = False\nSTARTS_NEUTRAL = False\n"
    path = write(text)
    assert_same(scenario_of(path), scenario_of(path), seed=3)
    record = simulate_record(scenario_of(path, **{"run.steps": 150}), Runs(1, 3), curves=True)
    assert (record.feasible_count + record.infeasible_count < 20).any()


# --- What is wrong with a file ---


@pytest.mark.parametrize("section", ["robots", "tasks"])
def test_a_strategy_for_one_class_is_refused_where_there_are_more(write, section):
    path = write(f"{MINE}\nONE_CLASS = True\n")
    own = {"robots": {"skills": ["x"]}, "tasks": {"needs": {"x": 1}}}[section]
    classes = [{"name": "a", "count": 3, **own}]
    with pytest.raises(ScenarioError) as caught:
        scenario_of(path, **{f"{section}.classes": classes})
    assert str(caught.value).startswith(f"{section}.classes = '1 classes': ")
    assert "compares one number of robots with one number of tasks" in str(caught.value)
    assert str(caught.value).endswith(f"leave it out and set {section}.count, or choose census")
    assert scenario_of(path, **{f"{section}.count": 5}).strategy.one_class


def test_a_missing_file_is_told(tmp_path):
    assert "can't be read: No such file or directory; name a file" in told(tmp_path / "none.py")
    (tmp_path / "folder.py").mkdir()
    assert "can't be read: it is a directory; name a file" in told(tmp_path / "folder.py")


def test_a_file_that_says_only_how_to_decide_rates_and_broadcasts_as_the_voter_does(write):
    path = write(inspect.getsource(STRATEGIES["voter"].decide))
    assert_same(Scenario().replace({**SMALL, "decision.strategy": "voter"}), scenario_of(path))


def test_text_that_is_no_python_at_all_is_told(write, tmp_path):
    assert "it contains a NUL" in told(write("\x00\x01"))
    (tmp_path / "bytes.py").write_bytes(b"\xff\xfe = 3")
    assert "it isn't UTF-8 text" in told(tmp_path / "bytes.py")
    assert "too many nested parentheses" in told(write("x = " + "(" * 5000))


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


def test_a_registered_strategy_that_fails_is_told_when_it_runs(package):
    package(["fable = fable_two"], fable_two="X = 1 / 0\n" + MINE)
    assert told_when_run("fable") == "fable, line 1: ZeroDivisionError: division by zero"


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

BITMAP = """

def layout(wire, message, sender, setting):
    for k in range(len(message)):
        message[k] = wire.number(message[k], 1)
    return -1
"""
ROLL_CALL = replaced(
    (Path(__file__).parents[2] / "examples" / "strategies" / "roll_call.py").read_text(),
    "    length = 2\n",
    "    return len(message)\n    length = 2\n",
)


def test_a_layout_makes_pack_and_unpack(write):
    strategy = load(str(write(ROLL_CALL + BITMAP)))
    setting = setting_from((3, 2), (0, 0), False, None, ())
    wire = Wire(strategy, 2, setting=setting)
    message = Message(-1, knowledge=(1, 0, 1, 0, 1))
    assert wire.is_exact
    assert wire.bits(2, message) == 5
    assert wire.decode(wire.encode(2, message)) == (-1, message)
    assert {"layout", "pack", "unpack"} <= strategy.functions


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (
            BITMAP.replace("1)", "2)"),
            "mine.py: layout writes 14 bits of .*, and bits returns 7; they must be",
        ),
        (BITMAP.replace("message[k] = wire", "wire"), "mine.py: layout reads .* from what layout wrote of"),
        (BITMAP.replace("-1", "-2"), r"mine.py, line 47: layout\(.* returns -2; must be the sender's id, or"),
        (BITMAP.replace("message)", "message) + 1"), r"mine.py, line 49: layout\(.* fails: IndexError"),
        (BITMAP.replace("message[k], 1", "message[k] + 1, 1"), "layout of .*: 2 doesn't fit 1 bits"),
        (
            BITMAP + BITMAP.replace("layout(wire", "pack(wire"),
            "has both layout and pack or unpack, .*; remove",
        ),
        (BITMAP.replace("(wire, ", "("), "layout must take 4; write def layout"),
    ],
)
def test_a_layout_is_tried(write, text, why):
    with pytest.raises(FeasibeeError, match=why):
        load(str(write(ROLL_CALL + text)))
