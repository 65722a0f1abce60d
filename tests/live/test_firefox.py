"""The page in Firefox, whose WebAssembly and canvas aren't Chromium's."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import pytest
from playing import swarm_at
from waiting import PATIENCE

from feasibee import Scenario, decision_counts, simulate
from feasibee.live.page import write_page

pytest.importorskip("websockets", reason="websockets isn't installed")
pytest.importorskip("playwright", reason="playwright isn't installed")
from firefox import running
from visiting import DONE, FRAMES

FIREFOXES = ("firefox-esr", "firefox")
SCENARIO = Scenario(tasks={"count": 50})
SEEN = f"""
const $ = (id) => document.getElementById(id), text = (id) => $(id).textContent;
const until = async (ready) => {{
  for (let k = 0; k < {100 * PATIENCE} && !ready(); k++) await new Promise((done) => setTimeout(done, 10));
}};
await until({DONE});
await until(() => $("swarms").ariaBusy === "false");
"""


@pytest.fixture(scope="module")
def folder():
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as found:
        yield Path(found)


@pytest.fixture(scope="module")
def tab(folder):
    program = next(filter(None, map(shutil.which, FIREFOXES)), None)
    if program is None:
        pytest.skip("no Firefox: install the Debian package firefox-esr")
    write_page(SCENARIO, folder / "run.html", seed=1)
    with running(program, folder) as found:
        yield found
    assert found.console == []


def test_steps_decision_and_hundred_swarms_are_the_engines(tab, folder):
    swarms = simulate(SCENARIO, runs=100, seed=1, curves=True)
    tab.open((folder / "run.html").as_uri())
    frames = tab.run(f"{SEEN} return ({FRAMES})([...Array(151).keys()])")
    assert [each["feasible"] for each in frames] == swarms.feasible_count.values[0, :151].tolist()
    for step in (0, 40, 150):
        assert frames[step]["x"] == swarm_at(step, SCENARIO, 1).snapshot().x.tolist()
    word = ("infeasible", "feasible")[int(swarms.decision[0])]
    decided = f"The swarm decides {word} at step {int(swarms.decision_step[0])}."
    ours = decision_counts(swarms.decision)
    said = tab.run(f"{SEEN} return [text('decision'), text('sentences')]")
    assert said[0].startswith(decided)
    assert f"100 swarms: {ours['feasible']} feasible, {ours['infeasible']} infeasible." in said[1]


def test_an_address_with_two_swarms_comes_back_and_a_clip_is_saved(tab, folder):
    tab.open(f"{(folder / 'run.html').as_uri()}#tasks=24&sight=3&against=census")
    wide = "$('frame').scrollWidth - $('frame').clientWidth"
    shown = f"return [text('question'), text('caption-1').slice(0, 7), {wide}]"
    assert tab.run(f"{SEEN} {shown}") == ["Can 20 robots do 24 tasks?", "census:", 0]
    click = "$('clip').click()"
    tab.run(f"{SEEN} {click}; $('play').click(); await until(() => Number(text('now')) > 9); {click}")
    for _ in range(100):
        tab.run("await new Promise((done) => setTimeout(done, 100))")
        films = list(folder.glob("feasibee-20-robots-24-tasks.webm"))
        if films and films[0].stat().st_size:
            break
    assert films[0].read_bytes()[:4] == b"\x1aE\xdf\xa3"
