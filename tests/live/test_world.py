"""The world in a page against the engine: every robot's opinion and phase at every step, bit for bit."""

from __future__ import annotations

import base64
import importlib.util
import json
import math
import re
import subprocess
from functools import partial

import numpy as np
import pytest
from commands import invoke, refused

from feasibee import Scenario, Swarm
from feasibee.errors import how_to_install
from feasibee.live.world import build
from feasibee.live.world.build import WASM
from feasibee.live.world.lowering import ROBOTS_LIMIT, TASKS_LIMIT, check_scenario, numbers_of, variants_of
from feasibee.model import purposes
from feasibee.robot import firmware
from feasibee.scenario.feasibility import truth
from feasibee.simulation.snapshot import FLAGS
from feasibee.strategies import STRATEGIES
from tests.robot.swarms import VARIANTS

BITS = {name: 1 << k for k, name in enumerate(FLAGS)}
NAMES = list(STRATEGIES)
SHOWN = BITS["feasible"] | BITS["neutral"] | BITS["disseminating"] | BITS["declared"] | BITS["there"]


def simulated(scenario, seed, run):
    """Return what the engine has: flags of the robots there at each step, and the swarm at the end."""
    swarm = Swarm(scenario, seed, run)
    rows = []
    for step in range(scenario.run.steps + 1):
        if step:
            swarm.advance()
        sets = {
            "feasible": swarm.opinions == 1,
            "neutral": swarm.opinions == -1,
            "disseminating": swarm.disseminating,
            "declared": swarm.declared >= 0,
            "there": swarm.present,
        }
        rows.append(sum(BITS[name] * each for name, each in sets.items()) * swarm.present)
    return np.array(rows), swarm


def compare(play, runs):
    for (scenario, seed, run), (flags, places, missing) in zip(runs, play(runs), strict=True):
        expected, swarm = simulated(scenario, seed, run)
        where = f"{scenario.decision.strategy}, seed {seed}, run {run}"
        assert np.array_equal(flags & SHOWN, expected), where
        at = (places * numbers_of(scenario)["unit"])[swarm.present]
        assert np.array_equal(at, swarm.positions[swarm.present]), where
        assert (missing == 0) == (swarm.truth if scenario.events else truth(scenario)), where


def scenario_of(draw, number, steps, **tables):
    """Return a random swarm with one strategy after the other, and random parameters of knowledge."""
    name = NAMES[number % len(NAMES)]
    parameters = {key: float(draw.choice(values)) for key, values in VARIANTS.get(name, {}).items()}
    return Scenario(
        robots={
            "count": int(draw.integers(1, 60)),
            "know_count": STRATEGIES[name].needs_count or bool(draw.integers(2)),
            **tables.pop("robots", {}),
        },
        tasks={"count": int(draw.integers(0, 90))},
        decision={"strategy": name, "parameters": parameters, **tables.pop("decision", {})},
        run={"steps": steps},
        **tables,
    )


@pytest.mark.parametrize(("rounds", "steps"), [(1, 80), pytest.param(3, 300, marks=pytest.mark.slow)])
def test_runs_of_all_strategies_equal_the_engines(play, rounds, steps):
    draw = np.random.default_rng(17)
    compare(
        play,
        [
            (scenario_of(draw, k, steps), int(draw.integers(0, 2**63)) * 2 + k % 2, 7 * k)
            for k in range(rounds * len(NAMES))
        ],
    )


def changing(draw, scenario):
    """Return a scenario with random events, some of them at one step; None if its strategy declares."""
    robots, tasks, events = scenario.robots.count, scenario.tasks.count, []
    for step in sorted(draw.integers(0, scenario.run.steps + 1, draw.integers(1, 6)).tolist()):
        more = int(draw.integers(3 - robots, 30)), int(draw.integers(2 - tasks, 40))
        robots, tasks = robots + more[0] - 2, tasks + more[1] - 2  # named ones may go, too
        events += [{"step": step, "robots": more[0], "tasks": more[1]}] * any(more)
        events += [pointed(draw, scenario, step) for _ in range(draw.integers(3))]
    return None if scenario.declares else scenario.replace({"events": events})


def pointed(draw, scenario, step):
    """Return an event that says where, or which robot or task of the start."""
    kind = str(draw.choice(["robots", "tasks", "robot", "task"][: 3 + bool(scenario.tasks.count)]))
    which = 1 if kind in ("robots", "tasks") else int(draw.integers(scenario.get(f"{kind}s.count")))
    at = draw.uniform(0.6, 19.3, 2).round(int(draw.integers(6))).tolist()
    return {"step": step, kind: which} | ({"at": at} if kind.endswith("s") or draw.integers(2) else {})


@pytest.mark.parametrize(("rounds", "steps"), [(1, 80), pytest.param(3, 300, marks=pytest.mark.slow)])
def test_runs_that_change_equal_the_engines(play, rounds, steps):
    draw = np.random.default_rng(19)
    errors = {"sensing": {"miss": 0.2}, "radio": {"loss": 0.1}}
    drawn = (changing(draw, scenario_of(draw, k, steps, **errors)) for k in range(rounds * len(NAMES)))
    runs = [(each, 3 * k, k) for k, each in enumerate(drawn) if each]
    compare(play, runs)


@pytest.mark.slow
def test_the_fewest_and_most_that_sliders_allow_equal_the_engines(play):
    runs = []
    for robots, tasks in [(1, 0), (1, 400), (2, 1), (3, 400), (ROBOTS_LIMIT, 0), (ROBOTS_LIMIT, TASKS_LIMIT)]:
        for each in variants_of(Scenario(run={"steps": 60})):
            runs.append((each.replace({"robots.count": robots, "tasks.count": tasks}), 5, 1))
    compare(play, runs)


@pytest.mark.slow  # it compiles the general engine
@pytest.mark.parametrize("boundary", ["torus", "walls"])
def test_any_fields_that_a_page_simulates_equal_the_engines(play, boundary):
    draw = np.random.default_rng(18)

    def any_of(*values):
        return values[draw.integers(len(values))]

    runs = []
    for k in range(4 * len(NAMES)):
        strategy = STRATEGIES[NAMES[k % len(NAMES)]]
        scenario = scenario_of(
            draw,
            k,
            300,
            arena={"side": any_of(20.0, 10.7, [20.0, 9.3], [8.1, 14.0]), "boundary": boundary},
            robots={"speed": any_of(1.0, 0.7, 2.2), "diameter": any_of(1.0, 0.3)},
            walk={"mean_run": any_of(10.0, 3.7)},
            sensing={
                "range": any_of(2.0, 1.3, 3.9),
                "count_self": any_of(True, False),
                "miss": any_of(0.0, 0.3),
            },
            radio={
                "range": any_of(2.0, 3.7),
                "id_bits": None if strategy.needs_ids else any_of(None, 4),
                "loss": any_of(0.0, 0.2, 1.0),
            },
            decision={
                "listen": any_of("always", "dissemination", {"last": 3}),
                "own_vote": any_of(True, False),
                "ties": any_of("keep", "random-message"),
                "start": "coin"
                if strategy.knowledge or strategy.starts_neutral
                else any_of("coin", "first-sight"),
                "exploration": any_of(10.0, 5.1),
                "gain": any_of(10.0, 3.3, 17.9),
                "declare": None if strategy.declares else any_of(None, {"quorum": 0.85}),
                "inbox_size": any_of(None, 2),
                "quality_floor": 0 if strategy.knowledge else any_of(0, 2),
                "dissemination_floor": any_of(0, 3),
            },
        )
        check_scenario(scenario)
        runs.append((scenario, int(draw.integers(0, 2**63)), k))
    compare(play, runs)


TRUSTING = '''"""Trusting: adopt an opinion that was heard, the more likely the more was heard in life."""

import math

PARAMETERS = {"trust": 0.3}
MEMORY = 1


def decide(mind, inbox):
    """Return an opinion heard with a probability that grows, or the robot's own."""
    mind.memory[0] += inbox.feasible_votes + inbox.infeasible_votes
    if inbox.heard_opinion >= 0 and inbox.chance > mind.parameters[0] ** math.sqrt(mind.memory[0] / 9):
        return inbox.heard_opinion
    return mind.opinion
'''
EASTERN = '''"""Eastern: the easternmost place where a robot began or saw something, which robots pass on."""


def words(setting):
    return 1


def start(known, me):
    known[0] = int(me.x * 1000.0)


def observe(known, thing, me):
    known[0] = max(known[0], int(thing.x * 998.0 + me.y))


def merge(known, message, sender, me):
    known[0] = max(known[0], message[0])


def count(known, counts, me):
    counts[0], counts[1] = known[0], 19_500


def bits(message, me):
    return 32


def decide(mind, inbox):
    return int(mind.feasible_quality > 0.5)
'''


@pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="ziglang isn't installed")
@pytest.mark.parametrize(
    "text",
    [TRUSTING, pytest.param(EASTERN, marks=pytest.mark.slow), pytest.param("", marks=pytest.mark.slow)],
    ids=["opinions", "positions", "skeleton"],
)
def test_a_users_own_strategy_equals_the_engines(play, tmp_path, text):
    file, out, world = tmp_path / "dmmd.py", tmp_path / "run.html", tmp_path / "world.wasm"
    if text:
        file.write_text(text, encoding="utf-8")
    else:
        assert invoke("new", "strategy", str(file), "--knowledge").exit_code == 0
    said = invoke("page", "--strategy", str(file), "--set", "run.steps=200", "--out", str(out))
    assert said.exit_code == 0, said.output
    given = json.loads(out.read_text("utf-8").partition('id="given">')[2].partition("</script>")[0])
    world.write_bytes(base64.b64decode(given["wasm"]))
    chosen = given["strategies"][given["settings"]["strategy"]]
    assert chosen["name"] == str(file)  # in place of the built-in one of this name
    assert [each["name"] for each in given["strategies"]][:2] == [str(file), "dmvd"]
    compare(
        partial(play, world=world),
        [
            (
                Scenario(decision={"strategy": str(file)}, tasks={"count": 14 + 4 * k}, run={"steps": 200}),
                k,
                3,
            )
            for k in range(4)
        ],
    )


def test_without_a_compiler_a_page_of_ones_own_strategy_says_how_to_get_it(tmp_path, monkeypatch):
    file = tmp_path / "mine.py"
    file.write_text(TRUSTING, encoding="utf-8")
    monkeypatch.setattr(build, "find_spec", lambda name: None)
    (said,) = refused("page", "--strategy", str(file), "--out", str(tmp_path / "run.html"))
    assert said == f"feasibee: ziglang: not installed; {how_to_install('c')}"


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "decision",
    [
        {"strategy": "k-unanimity", "parameters": {"k": 2.0}},
        {"strategy": "bayes", "parameters": {"credence": 0.8, "positive_feedback": 0.0}},
        {"inbox": "every-message"},
    ],
)
def test_parameters_and_inbox_equal_the_engines(play, decision):
    scenario = Scenario(tasks={"count": 19}, decision=decision, run={"steps": 300})
    compare(play, [(scenario, 3, run) for run in range(5)])


def test_durations_are_those_of_pythons_logarithm(node):
    """A draw where they differ would need -mean log u within 1e-15 of a whole number."""
    words = [0, 1, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1, *range(5, 2**32, 2**32 // 3000)]
    means = [10.0, 10 * (3 / 7), 0.3, 1e6]
    script = f"""
      const {{ readFileSync }} = require("fs");
      WebAssembly.instantiate(readFileSync({json.dumps(str(WASM))})).then(({{ instance }}) => {{
        const draw = instance.exports.world_duration;
        console.log(JSON.stringify({words}.map((word) => {means}.map((mean) => draw(word, mean)))));
      }});"""
    said = subprocess.run([node, "-"], input=script, capture_output=True, check=True, text=True).stdout
    expected = [[max(1, math.ceil(-mean * math.log((word + 1) / 2**32))) for mean in means] for word in words]
    assert json.loads(said) == expected


def constants(text, name):
    """Return the names of an enum in C, and its values if they are written."""
    (body,) = re.findall(rf"enum {name} \{{([^}}]+)\}}", text)
    pairs = [each.strip().partition(" = ") for each in body.split(",")]
    return {key: int(value) if value else k for k, (key, _, value) in enumerate(pairs)}


def test_the_page_and_the_package_agree_on_numbers_flags_and_purposes():
    world, draws = ((build.FOLDER / name).read_text("utf-8") for name in ("world.c", "draws.h"))
    strategy = {"strategy": "k-unanimity", "parameters": {"k": 2.0}}
    given = (firmware.FOLDER / "given.h").read_text("utf-8")
    numbers = [name.upper() for name in numbers_of(Scenario(decision=strategy))]
    own = [*constants(world, "number")][:-1]
    assert numbers == [*own, *[*constants(given, "feasibee_given")][:-1], "GIVEN_PARAMETER_0"]
    for name, bit in constants(world, "flag").items():
        assert bit == BITS[name.lower()]
    for name, number in constants(draws, "purpose").items():
        assert number == getattr(purposes, name)


def test_the_compiled_world_is_that_of_the_source(tmp_path):
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no ziglang: install the dependency group wasm of pyproject.toml, from PyPI")
    build.compile_world(tmp_path / "world.wasm", tuple(STRATEGIES.values()), *build.WARNINGS)
    assert (tmp_path / "world.wasm").read_bytes() == WASM.read_bytes()
