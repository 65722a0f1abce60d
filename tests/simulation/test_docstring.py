"""The docstring of `simulate` names what it returns, and nothing else."""

from __future__ import annotations

import re

import pytest
from declaring import declaring

from feasibee import Scenario, simulate

RETURNS = re.sub(r"\s+", " ", simulate.__doc__.split("Returns\n")[1].split("Examples\n")[0])
PARTS = re.split("With curves|In a world that changes|Attributes:|of variables", RETURNS)
VARIABLES, CURVES, TRACES, ATTRIBUTES, OF_VARIABLES = PARTS
BY_VOTES = {"declare": {"rounds": 1, "heard": 1}}


def named(text):
    """Return the words of a text that are names."""
    return set(re.findall(r"``([a-z_]+)``", text))


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Results of robots that declare, by votes or a file, that give a probability, or act, with curves."""
    small = {"robots": {"count": 4}, "run": {"steps": 3}}
    declares = declaring(tmp_path_factory.mktemp("declaring"))
    declares = declares.replace({"run.steps": 3, "run.stop_at_declarations": True})
    by_votes, sure = (Scenario(**small, decision=each) for each in (BY_VOTES, {"strategy": "bayes"}))
    acting = Scenario(**small, acting={"start": 2}, tasks={"work": 2})
    return [simulate(each, 2, curves=True) for each in (by_votes, declares, sure, acting)]


def test_the_docstring_names_all_variables_and_dimensions(results):
    over_run = {name for each in results for name in each.data_vars if each[name].dims == ("run",)}
    assert named(VARIABLES) == over_run | {"run"}
    with_steps = {name for each in results for name in each.data_vars} - over_run
    assert named(CURVES) == with_steps | {"run", "step"} == with_steps | set(results[0].sizes)
    plain = simulate(Scenario(robots={"count": 4}, run={"steps": 3}))
    assert set(plain.sizes) == {"run"}


def test_the_docstring_names_what_worlds_that_change_have():
    changing = {"robots": {"count": 4}, "run": {"steps": 3}, "events": [{"step": 2, "tasks": 1}]}
    with_steps = {name for name, each in simulate(Scenario(**changing)).items() if "step" in each.dims}
    assert named(TRACES) == with_steps


def test_the_docstring_names_all_attributes(results):
    assert all(named(ATTRIBUTES) == set(each.attrs) for each in results)
    of_variables = {key for each in results for values in each.data_vars.values() for key in values.attrs}
    assert named(OF_VARIABLES) == of_variables
