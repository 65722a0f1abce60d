"""The exported chain, solved by ourselves and by Storm; the differential equation, followed by ourselves."""

from __future__ import annotations

import math
import re
from itertools import product
from typing import ClassVar

import numpy as np
import pytest
from commands import output_of, refused

from feasibee import Scenario, ScenarioError
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.theory.export import to_exact_prism, to_ode, to_prism
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


def python_of(expression):
    """Return an expression of PRISM as one of Python, compiled."""
    text = re.sub(r"\((\w+)=(\S+) \? (\S+) : (\S+)\)", r"(\3 if \1==\2 else \4)", expression)
    text = re.sub(r"(?<![<>=])=(?!=)", "==", text)
    return compile(text.replace("&", " and ").replace("|", " or ").replace("!", " not ").strip(), "", "eval")


class State(dict):
    """Variables of a model; its formulas are computed as they are looked up."""

    formulas: ClassVar[dict] = {}

    def __missing__(self, name):
        return eval(self.formulas[name], {}, self)


def moves_of(state, commands):
    """Return the chances of what one module does next, by its command whose guard holds."""
    ((_, moves),) = [each for each in commands if eval(each[0], {}, state)]
    return [(chance, {name: eval(to, {}, state) for name, to in changes}) for chance, changes in moves]


def solved_exactly(text):
    """Return the same of a model of several modules, from its text alone."""
    State.formulas = {name: python_of(of) for name, of in re.findall(r"formula (\w+) = (.*);", text)}
    modules = []
    for body in re.findall(r"\nmodule (.*?)endmodule", text, re.S):
        commands = [
            (
                python_of(guard),
                [
                    (
                        float(move.partition(":")[0]),
                        [(name, python_of(to)) for name, to in re.findall(r"(\w+)'=([\w-]+)", move)],
                    )
                    for move in moves.split(" + ")
                ],
            )
            for guard, moves in re.findall(r"\[t\] (.*) -> (.*);", body)
        ]
        modules.append(commands)
    start = State((name, int(first)) for name, first in re.findall(r"(\w+) : \[.*\] init (\S+);", text))
    numbers, states, rows = {tuple(start.values()): 0}, [start], []
    for state in states:
        row = {}
        for parts in product(*(moves_of(state, each) for each in modules)) if not state["done"] else ():
            after = State(state)
            for _, changes in parts:
                after.update(changes)
            key = tuple(after.values())
            if key not in numbers:
                numbers[key] = len(states)
                states.append(after)
            row[numbers[key]] = row.get(numbers[key], 0.0) + math.prod(chance for chance, _ in parts)
        assert state["done"] or sum(row.values()) == pytest.approx(1)
        rows.append(row)
    stay = np.eye(len(states))
    for number, row in enumerate(rows):
        for to, chance in row.items():
            stay[number, to] -= chance
    wanted = [[each["feasible"], not each["done"] and each["p1"] < 2] for each in states]
    return np.linalg.solve(stay, np.array(wanted, float))[0]


FEW = Scenario(
    arena={"side": 2.0, "boundary": "walls"},
    robots={"count": 3, "speed": 0.1},
    tasks={"count": 5},
    sensing={"range": 3.0},
    radio={"range": 3.0},
)
EXACT = [FEW, FEW.replace({"decision.strategy": "dmvd", "tasks.count": 1})]


def test_the_exact_model_has_the_mean_time_of_another_chain():
    """The time is that of a chain in a prototype of the theory, written before the model."""
    share, steps = solved_exactly(to_exact_prism(FEW.replace({"tasks.count": 1})))
    assert (share, steps) == (pytest.approx(0.5), pytest.approx(22.35009, abs=1e-5))


@pytest.mark.parametrize(
    "changes",
    [
        {"decision.strategy": "dmvd"},
        {"decision.strategy": "dmvd", "sensing.count_self": True, "tasks.count": 1},
        {"decision.strategy": "k-unanimity", "decision.parameters.k": 2.0, "decision.gain": 40.0},
        {"robots.count": 2, "decision.strategy": "voter"},
        {"decision.own_vote": False},
        {"decision.own_vote": False, "decision.ties": "random-message"},
    ],
)
def test_the_engine_follows_the_exact_model(changes):
    scenario = FEW.replace(changes)
    share, steps = solved_exactly(to_exact_prism(scenario))
    record = simulate_record(
        scenario.replace({"run.steps": 3_000, "run.stop_at_decision": True}), Runs(8_000, 5)
    )
    assert (record.decision >= 0).all()
    assert (record.decision == 1).mean() == pytest.approx(share, abs=0.025)
    assert record.decision_step.mean() == pytest.approx(
        steps, abs=5 * record.decision_step.std() / 8_000**0.5
    )


def test_what_the_exact_model_leaves_out_is_refused():
    for changes, path in (
        ({"radio.range": 1.5}, "radio.range"),
        ({"robots.count": 4}, "robots.count"),
        ({"radio.loss": 0.1}, "radio.loss"),
        ({"decision.strategy": "cross-inhibition"}, "decision.strategy"),
        ({"decision.strategy": "census"}, "decision.strategy"),
    ):
        with pytest.raises(ScenarioError) as told:
            to_exact_prism(FEW.replace(changes))
        assert told.value.problems[0].path == path


@pytest.mark.slow
@pytest.mark.parametrize("scenario", [*CASES, *EXACT])
def test_storm_finds_the_same(scenario, tmp_path):
    stormpy = pytest.importorskip("stormpy")
    path = tmp_path / "swarm.pm"
    to_text, solve = (to_exact_prism, solved_exactly) if scenario in EXACT else (to_prism, solved)
    path.write_text(to_text(scenario), encoding="utf-8")
    program = stormpy.parse_prism_program(str(path))
    found = []
    for wanted in ('P=? [F "feasible"]', 'R{"steps"}=? [F "decided"]'):
        formulas = stormpy.parse_properties(wanted, program)
        model = stormpy.build_model(program, formulas)
        found.append(stormpy.model_checking(model, formulas[0]).get_value(model.initial_states[0]))
    assert found == pytest.approx(tuple(solve(path.read_text("utf-8"))), rel=1e-5)


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
    assert refused("scenario", "--to", "prism-exact")[0].startswith("feasibee: robots.count = 20")
    (line,) = refused("scenario", "--to", "prism", "--set", "decision.strategy=census")
    assert "decision.strategy" in line
