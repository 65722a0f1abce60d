"""The exported chain, solved by ourselves and by Storm; the differential equation, followed by ourselves."""

from __future__ import annotations

import re

import numpy as np
import pytest
from commands import output_of, refused

from feasibee import Scenario
from feasibee.theory.export import to_ode, to_prism
from feasibee.theory.predict import predict

CASES = [Scenario(tasks={"count": 10}), Scenario(tasks={"count": 16}, decision={"strategy": "dmvd"})]


def solved(text):
    """Return the share that decides feasible and the mean steps of a model, from its text alone."""
    last = int(re.search(r"x : \[0\.\.(\d+)\]", text)[1])
    ticks = int(re.search(r"ticks_per_step = (\d+)", text)[1])
    moves = np.zeros((last + 1, last + 1))
    for state, row in re.findall(r"\[\] x=(\d+) -> (.*);", text):
        for chance, to in re.findall(r"([\d.e-]+):\(x'=(\d+)\)", row):
            moves[int(state), int(to)] += float(chance)
    inner = [*range(1, last - 1), last]
    assert moves[inner].sum(1) == pytest.approx(1)
    stay = np.eye(len(inner)) - moves[np.ix_(inner, inner)]
    share = np.linalg.solve(stay, moves[inner, last - 1])[-1]
    steps = np.linalg.solve(stay, [1 / ticks] * (len(inner) - 1) + [0.0])[-1]
    return share, steps


@pytest.mark.parametrize("scenario", CASES)
def test_the_model_has_the_shares_and_the_mean_time_of_the_chain(scenario):
    chain = predict(scenario.replace({"run.steps": 8_000})).chain
    by_step = chain.over_time(8_000)
    share, steps = solved(to_prism(scenario))
    assert share == pytest.approx(by_step[-1, 0], abs=1e-5)
    assert steps == pytest.approx((1 - by_step[1:].sum(1)).sum(), abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("scenario", CASES)
def test_storm_finds_the_same(scenario, tmp_path):
    stormpy = pytest.importorskip("stormpy")
    path = tmp_path / "swarm.pm"
    path.write_text(to_prism(scenario), encoding="utf-8")
    program = stormpy.parse_prism_program(str(path))
    found = []
    for wanted in ('P=? [F "feasible"]', 'R{"steps"}=? [F "decided"]'):
        formulas = stormpy.parse_properties(wanted, program)
        model = stormpy.build_model(program, formulas)
        found.append(stormpy.model_checking(model, formulas[0]).get_value(model.initial_states[0]))
    assert found == pytest.approx(solved(path.read_text("utf-8")), rel=1e-5)


def test_the_equation_has_the_tipping_point_of_the_prediction():
    text = to_ode(CASES[0])
    drift = re.search(r"dx/dt = (.*)", text)[1].replace("^", "**")
    x = np.linspace(0.01, 0.99, 981)
    flow = eval(drift, {"x": x})
    (zero,) = x[:-1][np.diff(np.sign(flow)) != 0]
    assert zero == pytest.approx(predict(CASES[0]).tipping.point, abs=0.02)
    assert float(re.search(r"within ([\d.]+)%", text)[1]) < 4


def test_the_command_writes_both_and_refuses_what_is_beyond_reach():
    assert output_of("scenario", "--to", "prism").count("\n  [] x=") == 21
    assert "dx/dt" in output_of("scenario", "--to", "ode")
    (line,) = refused("scenario", "--to", "prism", "--set", "decision.strategy=census")
    assert "decision.strategy" in line
