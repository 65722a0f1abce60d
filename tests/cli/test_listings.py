"""`feasibee show strategies` and `feasibee show presets`: a line each, needs and bits."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import invoke, json_of

from feasibee import Scenario, simulate
from feasibee.scenario.messages import message_bits
from feasibee.scenario.tables import ABOUT, PRESETS
from feasibee.strategies import STRATEGIES


def test_each_strategy_has_a_line_with_what_its_file_declares():
    head, *lines, _, own = invoke("show", "strategies").stdout.splitlines()
    assert (Path(__file__).parents[2] / own.split()[-4]).is_dir()
    assert head.split() == ["strategy", "needs", "declares", "bits", "rule"]
    assert [line.split()[0] for line in lines] == list(STRATEGIES)
    for row in json_of("show", "strategies"):
        manifest = STRATEGIES[row["strategy"]]
        assert ("names" in row["needs"], "n" in row["needs"]) == (manifest.needs_names, manifest.needs_count)
        assert row["declares"] == manifest.declares
        assert row["rule"].endswith(".")


def test_needs_and_bits_are_those_of_the_scenario():
    options = ["--set", "decision.strategy=turns", "--set", "robots.know_count=true"]
    plain, tolerant, hundred = (
        {row["strategy"]: row for row in json_of("show", "strategies", *options, *more)}
        for more in ((), ("--set", "decision.parameters.tolerates=1.0"), ("--set", "robots.count=100"))
    )
    assert plain["turns"]["needs"] == ["names", "n"]
    assert tolerant["turns"]["needs"] == ["names", "ids", "n"]
    assert tolerant["map"]["needs"] == ["names", "n"]
    assert (plain["dmmd"]["bits"], plain["dc"]["bits"], hundred["dmmd"]["bits"]) == ([6, 6], [22, 22], [8, 8])
    assert message_bits(Scenario(decision={"declare": {}})).full == 7


def test_the_longest_message_of_a_census_is_that_of_a_simulation():
    """Each robot sees and hears all others, and sends what it knows in every step."""
    scenario = Scenario(
        robots={"count": 4},
        tasks={"count": 3},
        arena={"side": 4.0, "boundary": "walls"},
        decision={"strategy": "census", "gain": 1e6, "exploration": 1.0},
        sensing={"range": 6.0},
    )
    before, after = (
        int(simulate(scenario.replace({"run.steps": steps}), backend="reference").bits_sent[0])
        for steps in (59, 60)
    )
    assert after - before == 4 * message_bits(scenario).full


def test_a_scenario_that_a_strategy_does_not_support_leaves_its_bits_open(tmp_path):
    words = ("--set", 'robots.classes=[{name="a",count=3,skills=["x"]}]', "--set",
             'tasks.classes=[{name="t",count=2,needs={x=1}}]')  # fmt: skip
    rows = {row["strategy"]: row for row in json_of("show", "strategies", *words)}
    assert rows["map"]["bits"] is None
    assert (rows["map"]["needs"], rows["map"]["one_class"]) == (["names", "n"], True)
    assert rows["census"]["bits"] is not None
    assert invoke("show", "strategies", *words).exit_code == 0


def test_a_file_of_ones_own_is_listed_with_its_rule(tmp_path):
    file = tmp_path / "own.py"
    source = Path(__file__).parents[2] / "src/feasibee/strategies/dc.py"
    file.write_text(source.read_text())
    row = json_of("show", "strategies", "--set", f"decision.strategy={file}")[-1]
    assert row["strategy"] == str(file)
    assert row["rule"] == "DC, direct comparison of qualities."


def test_each_preset_has_a_line():
    _, *lines = invoke("show", "presets").stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(PRESETS) == list(ABOUT)
    rows = {row["preset"]: row for row in json_of("show", "presets")}
    assert rows["ros2swarm-voter"]["bits"] == 6
    assert rows["ros2swarm-voter"]["steps"] == 10_000
    assert rows["valentini-2016"]["values"]["decision"]["inbox_size"] == 2


@pytest.mark.parametrize("name", STRATEGIES)
def test_a_message_never_shrinks_with_knowledge(name):
    scenario = Scenario(decision={"strategy": name}, robots={"know_count": True})
    first, full = message_bits(scenario)
    assert 0 < first <= full
