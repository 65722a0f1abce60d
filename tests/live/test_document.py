"""The file that `feasibee run --out` writes, also in the frame of a notebook, and what it can't show."""

from __future__ import annotations

import re
from html import unescape

import numpy as np
import pytest
from commands import invoke, refused
from serving import given

from feasibee import FeasibeeError, Scenario, ScenarioError
from feasibee.base.errors import how_to_install
from feasibee.engine import own
from feasibee.live.packet import check_scenario
from feasibee.live.page import page_of
from feasibee.live.prediction import prediction_of
from feasibee.live.scene import patches, variants_of
from feasibee.live.widget import Arena
from feasibee.strategies import STRATEGIES

OWN = "def decide(mind, inbox):\n    return mind.opinion\n"


def test_the_page_is_small_and_loads_nothing():
    text = page_of(Scenario(tasks={"count": 50}))
    assert len(text.encode()) < 450_000
    assert not re.search(r"""(src|href)=["'](?!data:|#)""", text)
    assert not re.search(r"(?m)^\s*(import|export)\b|https?:(?!//www\.w3\.org)", text)


def test_the_page_begins_with_the_scenario(tmp_path):
    file, out = tmp_path / "mine.toml", tmp_path / "mine.html"
    file.write_text("[robots]\ncount = 7\n[decision]\nstrategy = 'voter'\nthreshold = 0.8\n")
    said = invoke("run", str(file), "--set", "tasks.count=9", "--seed", str(2**64 - 1), "--out", str(out))
    assert (said.exit_code, said.stdout.splitlines()[-1]) == (0, f"Wrote {out}")
    found = given(out.read_text("utf-8"))
    assert found["name"] == "mine.toml"
    assert found["opened"]["threshold"] == 0.8
    counts = {"robots": 7, "tasks": 9, "strategy": list(STRATEGIES).index("voter"), "events": []}
    which, ranges = {"seed": str(2**64 - 1), "run": 0}, {"sight": 2.0, "radio": 2.0, "speed": 1.0}
    assert found["opened"]["settings"] == counts | which | ranges
    assert Scenario.from_toml(found["opened"]["toml"]).tasks.count == 9


def test_the_page_has_what_the_theory_says_of_the_scenario():
    scenario = Scenario(tasks={"count": 10})
    assert given(page_of(scenario))["prediction"] == prediction_of(scenario)


def test_no_name_can_end_the_data():
    name = "</script><script>alert(1)</script>$style"
    assert given(page_of(Scenario(), name=name))["name"] == name


def test_all_that_a_page_cannot_simulate_is_told_at_once(tmp_path):
    out = tmp_path / "run.html"
    out.write_text("before")
    said = refused("run", "--out", str(out), "--set", "tasks.count=20001", "--set", "run.steps=10001")
    assert said == [
        "feasibee: tasks.count = 20001: must be at most 20,000 in a page; use 20,000 or less",
        "feasibee: run.steps = 10001: must be at most 10,000 in a page; use 10,000 or less",
    ]
    assert out.read_text() == "before"


@pytest.mark.parametrize(
    ("changes", "path"),
    [
        ({"events": [{"step": 5, "robots": 19_981}]}, "robots.count"),
        ({"decision.strategy": "roster", "robots.count": 9000, "tasks.count": 9000}, "robots.count"),
    ],
)
def test_what_a_page_cannot_simulate(changes, path):
    with pytest.raises(ScenarioError) as told:
        check_scenario(Scenario().replace(changes))
    assert [problem.path for problem in told.value.problems] == [path]


@pytest.mark.parametrize("arena", [{"side": [20.0, 14.0]}, {"side": 9.0, "boundary": "walls"}])
def test_a_page_takes_ranges_and_speeds_up_to_those_that_a_scenario_may_have(arena):
    scenario = Scenario(arena=arena)
    most = given(page_of(scenario))["opened"]["most"]
    for path, name in (("sensing.range", "sight"), ("radio.range", "radio"), ("robots.speed", "speed")):
        check_scenario(scenario.replace({path: most[name]}))
        with pytest.raises(ScenarioError, match=path):
            scenario.replace({path: most[name] * 1.001})


@pytest.mark.parametrize("preset", ["valentini-2016", "minimize-surprise", "ros2swarm-majority"])
def test_a_page_simulates_the_presets(preset):
    check_scenario(Scenario(preset=preset))


def test_a_page_offers_all_strategies_that_go_with_its_scenario():
    def offered(**tables):
        return [each.decision.strategy for each in variants_of(Scenario(**tables))]

    assert offered() == list(STRATEGIES)
    assert offered(decision={"start": "first-sight"}) == [
        name for name, each in STRATEGIES.items() if not (each.knowledge or each.starts_neutral)
    ]
    strategies = given(page_of(Scenario()))["opened"]["strategies"]
    assert [each["knows"] for each in strategies] == [each.needs_count for each in STRATEGIES.values()]
    assert [each["declares"] for each in strategies] == [each.declares for each in STRATEGIES.values()]


def test_a_page_of_ones_own_strategy_offers_it_in_place_of_the_one_of_its_name(tmp_path):
    file = tmp_path / "dmmd.py"
    file.write_text(OWN, encoding="utf-8")
    mine = Scenario(decision={"strategy": str(file)})
    assert [each.decision.strategy for each in variants_of(mine)][:2] == [str(file), "dmvd"]


def test_without_a_compiler_a_page_of_ones_own_strategy_says_how_to_get_it(tmp_path, monkeypatch):
    file = tmp_path / "mine.py"
    file.write_text(OWN, encoding="utf-8")
    monkeypatch.setattr(own, "zig", lambda: None)
    (said,) = refused("run", "--set", f"decision.strategy={file}", "--out", str(tmp_path / "run.html"))
    assert said == f"feasibee: ziglang: not installed; {how_to_install('c')}"


def test_a_hall_of_forty_obstacles_makes_the_page_30_kb_larger_at_most():
    draw, walls = np.random.default_rng(4), []
    for _ in range(40):
        middle, (wide, high) = draw.uniform(2, 18, 2), draw.uniform(0.5, 2, 2)
        turn = draw.uniform(0, np.pi / 2)
        across = wide / 2 * np.array([np.cos(turn), np.sin(turn)])
        along = high / 2 * np.array([-np.sin(turn), np.cos(turn)])
        corners = (middle + i * across + j * along for i, j in ((1, 1), (-1, 1), (-1, -1), (1, -1)))
        walls.append([[round(x, 2), round(y, 2)] for x, y in corners])
    hall = Scenario(arena={"side": 20.0, "boundary": "walls"}, robots={"diameter": 0.5})
    shelves = hall.replace({"place.walls": walls, "place.cell": 0.05})
    assert shelves.plan.walls.shape == (400, 400)
    assert len(page_of(shelves).encode()) - len(page_of(hall).encode()) <= 30_000


def test_a_page_changes_ranges_by_itself_where_nothing_else_follows_from_them():
    others = ({"sensing.view": 180.0}, {"sensing.position_error": 0.1}, {"acting.start": 5})
    assert [patches(Scenario().replace(each)) for each in ({}, *others)] == [True, False, False, False]


def test_an_arena_is_a_frame_with_the_whole_page():
    scenario = Scenario(tasks={"count": 12})
    text = Arena(scenario, seed=3, run=5, height=600)._repr_html_()
    pattern = r'<iframe title="([^"]+)" sandbox="([^"]+)" srcdoc="([^"]+)" style="(.+)"></iframe>'
    title, sandbox, page, style = re.fullmatch(pattern, text).groups()
    assert (title, sandbox) == ("feasibee: a swarm", "allow-scripts")
    assert "height: 600px" in style
    assert unescape(page) == page_of(scenario, 3, 5)


def test_a_run_that_there_is_not_is_refused():
    with pytest.raises(FeasibeeError, match="seed = -1"):
        Arena(seed=-1)
