"""What strategies declare that they need: without it they fail, and what isn't declared isn't used."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee import FeasibeeError, Scenario
from feasibee.robot.knowledge import Knowledge
from feasibee.scenario.plugins import manifest_of
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Me, Thing
from feasibee.studies.comparison import compare
from feasibee.studies.needs import IDS, NAMES, Asked, needs_of

KNOWING = [name for name, each in STRATEGIES.items() if each.knowledge]
FEW_IDS = {"radio.id_bits": 3}


def scenario_of(name, **changes):
    strategy = STRATEGIES[name]
    scenario = Scenario(robots={"know_count": strategy.needs_count}, decision={"strategy": name})
    return scenario.replace(changes) if changes else scenario


def things(draws, named):
    """Yield what a robot sees in 60 steps; without names, all tasks look the same."""
    for step in range(60):
        number = int(draws.integers(20))
        is_robot = step % 3 == 0
        known = named or is_robot
        yield Thing(
            is_robot,
            number if known else 0,
            0,
            1000003 * number % 2**31 if known else 7,
            number * 1.0 if known else 1.0,
            number * 0.5 if known else 1.0,
        )


def counted_after(name, named, parameters=()):
    """Return what a robot counts after 60 sightings, and what its message says."""
    scenario = scenario_of(name)
    defaults = {**STRATEGIES[name].parameters, **dict(parameters)}
    setting = scenario.setting._replace(parameters=tuple(defaults.values()))
    memory = [0.0] * STRATEGIES[name].memory
    knowledge = Knowledge(STRATEGIES[name], Me(3, 0, 12345, 0, memory, setting, x=4.0, y=4.0))
    for thing in things(np.random.default_rng(1), named):
        knowledge.observe([thing])
        knowledge.end_step(True)
    return knowledge.counted(), knowledge.words


@pytest.mark.parametrize("name", KNOWING)
def test_names_are_used_only_if_they_are_declared(name):
    uses = counted_after(name, True) != counted_after(name, False)
    needs = NAMES in needs_of(scenario_of(name))
    assert uses == needs


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", STRATEGIES)
def test_swarms_whose_ids_are_mistaken_fail_only_if_ids_are_declared(name):
    """Of 20 robots with ids of 3 bits, at most 8 seem to be different ones.

    At some number of tasks, strategies that need ids lose 33 points or more, and others at most 20. Another
    seed would move these by about 10 points.
    """
    scenario = scenario_of(name, **{"run.steps": 600})
    lost = 0.0
    for tasks in (19, 24):
        exact, mistaken = (
            compare({"": scenario.replace({"tasks.count": tasks, **changes})}, (), 60, 3)[0].right.mean()
            for changes in ({}, FEW_IDS)
        )
        lost = max(lost, exact - mistaken)
    assert (lost > 0.27) == (IDS in needs_of(scenario)), lost


def test_needs_of_a_file_are_read_without_running_it(tmp_path):
    text = "NEEDS_NAMES = True\nNEEDS_IDS = 'looks'\nPARAMETERS = {'looks': 1.0}\n"
    text += "def decide(mind, inbox):\n    return 1\n"
    file = tmp_path / "mine.py"
    file.write_text(text)
    assert manifest_of(str(file)).needs({"looks": 1.0}) == ("names", "ids")
    assert manifest_of(str(file)).needs({"looks": 0.0}) == ("names",)
    file.write_text(text.replace("'looks'\n", "'times'\n", 1))
    with pytest.raises(FeasibeeError, match=r"NEEDS_IDS = 'times' must be True, False or .* parameter"):
        manifest_of(str(file))
    file.write_text(text.replace("NEEDS_NAMES = True", "NEEDS_NAMES = 'looks'"))
    with pytest.raises(FeasibeeError, match="NEEDS_NAMES = 'looks' must be True or False"):
        manifest_of(str(file))


@pytest.mark.parametrize(("name", "bits"), [("dmmd", 6), ("dc", 22), ("turns", 26)])
def test_messages_of_constant_length(name, bits):
    assert Asked(scenario_of(name), 1).message_bits == bits


def test_the_longest_message_of_a_census_has_all_names():
    """20 robots of 5 bits and 30 tasks of 32 bits, a bit more for each, and one at the end of either list."""
    assert Asked(scenario_of("census", **{"tasks.count": 30}), 1).message_bits == 20 * 6 + 30 * 33 + 2


@pytest.mark.parametrize("name", KNOWING)
def test_no_message_is_longer_than_the_longest(name):
    scenario = scenario_of(name, **{"run.steps": 200})
    record = simulate_record(scenario, Runs(20, 1))
    sent = record.bits_sent.max() / (scenario.robots.count * scenario.run.steps)
    assert sent < Asked(scenario, 1).message_bits < 2000


def test_memory_grows_with_what_is_known():
    few, many = (Asked(scenario_of("census", **{"tasks.count": tasks})).memory_bits for tasks in (5, 50))
    assert many > 5 * few / 2
    for size, senders in ((None, 19), (3, 3), (30, 19)):
        assert Asked(scenario_of("dmmd", **{"decision.inbox_size": size})).memory_bits == senders * 6
