"""The page in Firefox, whose WebAssembly and canvas aren't Chromium's."""

from __future__ import annotations

import shutil
import tempfile

import pytest
from playing import swarm_at

from feasibee import Scenario, decision_counts, simulate
from feasibee.live.page import write_page

pytest.importorskip("websockets", reason="websockets isn't installed")
from firefox import running

FIREFOXES = ("firefox-esr", "firefox")
SEEN = """
const text = (id) => document.getElementById(id).textContent;
const until = async (ready) => {
  for (let tries = 0; tries < 2000 && !ready(); tries++) await new Promise((done) => setTimeout(done, 10));
};
"""


@pytest.fixture(scope="module")
def tab():
    program = next(filter(None, map(shutil.which, FIREFOXES)), None)
    if program is None:
        pytest.skip("no Firefox: install the Debian package firefox-esr")
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile,
        running(program, profile) as found,
    ):
        yield found


@pytest.mark.slow
def test_steps_decision_and_hundred_swarms_are_the_engines(tab, tmp_path):
    scenario, file = Scenario(tasks={"count": 50}), tmp_path / "run.html"
    write_page(scenario, file, seed=1)
    swarms = simulate(scenario, runs=100, seed=1, curves=True)
    tab.open(file.as_uri())
    tab.run(f"{SEEN} await until(() => Number(text('now')) > 1)")  # it plays by itself
    tab.run("document.getElementById('play').click(); document.getElementById('restart').click()")
    shown = tab.run(
        f"""{SEEN}
        const shown = [];
        for (let step = 1; step <= 40; step++) {{
          document.getElementById("step").click();
          await until(() => text("now") === String(step));
          shown.push([Number(text("feasible")), Number(text("infeasible"))]);
        }}
        return shown;"""
    )
    counts = swarms.feasible_count.values[0, 1:41].tolist()
    assert shown == [[count, 20 - count] for count in counts]
    frames = tab.run("return [0, 40, 150].map(step => [...feasibee.history.frame(step).x])")
    assert frames == [swarm_at(step, scenario, 1).snapshot().x.tolist() for step in (0, 40, 150)]
    word = ("infeasible", "feasible")[int(swarms.decision[0])]
    decided = f"The swarm decides {word} at step {int(swarms.decision_step[0])}."
    assert tab.run(f"{SEEN} return text('decision')").startswith(decided)
    many = tab.run(
        f"""{SEEN} await until(() => document.getElementById("swarms").ariaBusy === "false");
        return text("sentences");"""
    )
    ours = decision_counts(swarms.decision)
    assert f"100 swarms: {ours['feasible']} feasible, {ours['infeasible']} infeasible." in many
    assert tab.console == []
    assert [each for each in tab.asked if not each.startswith(("file:", "data:", "blob:"))] == []
