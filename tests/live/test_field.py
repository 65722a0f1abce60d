"""The page of a field: its steps come from the log of its world, while it is written and later."""

from __future__ import annotations

import json
import os
import re
import time
from pathlib import Path

import numpy as np
import pytest
from commands import invoke
from serving import got, serving_at

from feasibee import FeasibeeError, Scenario
from feasibee.base.codes import FLAGS
from feasibee.cli import watch
from feasibee.field.plan import FieldPlan
from feasibee.field.recording import AT_ONCE, NO_TASK
from feasibee.field.supervisor import Field
from feasibee.live.field import routes_of_field
from feasibee.live.page import STATIC
from feasibee.reference import play

SILENT = "has logged nothing for more than 5 s"


def a_plan(scenario, seed=1):
    return FieldPlan(scenario, seed, 0, True, 20.0, 0.0, 0.0, 0.0, (), 20.0, 60.0)


def small(steps, **changes):
    counts = {"arena.side": 8.0, "robots.count": 4, "tasks.count": 4, "run.steps": steps}
    return Scenario().replace({**counts, "run.stop_at_decision": False, **changes})


def logged(folder, scenario, seed=1):
    folder.mkdir(exist_ok=True)
    Field(a_plan(scenario, seed), folder, lambda event: None).run()
    return folder


def asked(folder, start):
    return routes_of_field(folder)["GET", "/field"](f"from={start}".encode())


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """The folder of a field that has ended, and its scenario: robots act, come and go."""
    events = [{"step": 10, "tasks": 3, "robots": 2}, {"step": 20, "tasks": -5, "robots": -1}]
    scenario = small(AT_ONCE + 20, **{"acting.start": 5, "events": events})
    return logged(tmp_path_factory.mktemp("ended"), scenario), scenario


def numbers_of(steps):
    """Return the numbers of each step by name, as history.js lists them."""
    text = (STATIC / "history.js").read_text()
    names = re.findall(r'"(\w+)"', re.search(r"NUMBERS = .*?\]\);", text, re.DOTALL)[0])
    return [dict(zip(names, each, strict=True)) for each in np.reshape(steps["numbers"], (-1, len(names)))]


def test_the_steps_of_a_field_in_lockstep_are_those_of_the_run(ended):
    folder, scenario = ended
    first, second = (asked(folder, start) for start in (0, AT_ONCE))
    assert (first["steps"]["count"], first["steps"]["done"]) == (AT_ONCE, False)
    assert (second["steps"]["from"], second["steps"]["count"], second["steps"]["done"]) == (AT_ONCE, 21, True)
    state = {"problems": [], "silent": False, "ended": True, "last": AT_ONCE + 20}
    assert first["state"] == second["state"] == state
    steps, there = first["steps"], {}
    columns = {
        name: np.reshape(steps[name], (AT_ONCE, -1)) for name in ("x", "y", "flags", "heading", "aims")
    }
    for step, swarm in zip(range(AT_ONCE), play(scenario, 1, 0), strict=False):
        there = next((each for each in steps["there"] if each["step"] == step), there)
        numbers, flags = numbers_of(steps)[step], columns["flags"][step]
        held = {name: flags >> bit & 1 for bit, name in enumerate(FLAGS)}
        robots = [robot.number for robot in swarm.robots]
        assert np.flatnonzero(held["there"]).tolist() == robots
        assert (held["feasible"] - held["neutral"])[robots].tolist() == [r.mind.opinion for r in swarm.robots]
        counts = (len(robots), len(swarm.tasks), swarm.feasible_count, swarm.infeasible_count, swarm.decision)
        names = ("there", "tasks", "feasible", "infeasible", "decision")
        assert tuple(numbers[name] for name in names) == counts
        assert (numbers["missing"] == 0) == swarm.truth
        assert len(there["taskX"]) == len(there["taskNumbers"]) == len(there["taken"]) == len(swarm.tasks)
        tasks = there["taskNumbers"]
        aims = [
            tasks.index(aim) if (aim := max(r.errand.target, r.errand.task)) in tasks else NO_TASK
            for r in swarm.robots
        ]
        assert columns["aims"][step][robots].tolist() == aims
        assert held["standing"][robots].tolist() == [each.errand.task >= 0 for each in swarm.robots]
    assert columns["flags"].shape == (AT_ONCE, scenario.most.robots)
    assert columns["x"].max() < 2**16
    assert columns["heading"].max() < 2**8


def test_a_page_follows_a_log_that_grows_and_the_next_field(ended, tmp_path):
    lines = (ended[0] / "world.jsonl").read_text().splitlines(keepends=True)
    log = tmp_path / "world.jsonl"
    log.write_text(lines[0])
    with serving_at(routes_of_field(tmp_path)) as port:

        def after(known):
            return json.loads(got(port, f"/field?from={known}")[2])

        which = after(0)["which"]
        assert after(0)["steps"]["count"] == 0
        log.write_text("".join(lines[:8]) + lines[8][:9])  # a world may be in the middle of a line
        found = after(0)
        assert (found["which"], found["steps"]["count"]) == (which, 7)
        assert found["state"] == {"problems": [], "silent": False, "ended": False, "last": 6}
        log.write_text("".join(lines[:9]))
        found = after(7)
        assert (found["steps"]["from"], found["steps"]["count"], found["steps"]["done"]) == (7, 1, False)
        assert found["steps"] | {"from": 0} == asked(tmp_path, 7)["steps"] | {"from": 0}
        log.write_text(json.dumps(json.loads(lines[0]) | {"seed": 2}) + "\n" + lines[1])
        found = after(8)
        assert found["which"] != which
        assert found["steps"]["count"] == 0
        page = got(port)[2]
        assert found["which"] in page
        assert '"server":true' in page
        assert '"seed":"2"' in page
        wrong = ("", "from=-1", "from=x", "from=", "from=99999999999", "form=1", "from=1&x=2", "from=%ff")
        for query in wrong:
            assert got(port, f"/field?{query}")[0] == 400, query
        log.write_text(lines[0] + "{\n")
        assert got(port, "/field?from=0")[0] == 422


def test_a_browser_shows_a_field_that_has_ended(show, ended, tmp_path):
    lines = [json.loads(each) for each in (ended[0] / "world.jsonl").read_text().splitlines()]
    steps = [each | {"lost": [1]} if "lost" in each else each for each in lines]
    (tmp_path / "world.jsonl").write_text("".join(f"{json.dumps(each)}\n" for each in steps))
    with serving_at(routes_of_field(tmp_path)) as port:
        page = show(port)
        page.locator("#seek").fill(str(AT_ONCE + 20))
        for robot, told in ((1, "silent: the robot isn't counted"), (2, "the robot's own log has it")):
            page.locator("#robot").fill(str(robot))
            page.locator("#robot").press("Tab")
            page.locator("#reasons-0").filter(has_text=told).wait_for()
        assert page.locator("#state").inner_text() == "ended"
        assert page.locator("#last").inner_text() == str(AT_ONCE + 20)
        assert page.locator("#form").is_hidden()
        page.close()  # it would ask the server that ends now


def test_a_field_that_says_nothing_is_silent_and_so_are_its_robots(ended, tmp_path):
    lines = (ended[0] / "world.jsonl").read_text().splitlines(keepends=True)
    log = tmp_path / "world.jsonl"
    log.write_text("".join(lines[:6]) + json.dumps(json.loads(lines[6]) | {"lost": [1, 3]}) + "\n")
    found = asked(tmp_path, 0)
    assert found["state"]["problems"] == ["robots 1, 3 are silent"]
    assert found["steps"]["lost"] == [[]] * 5 + [[1, 3]]
    flags = found["steps"]["flags"][-6:]
    assert [bool(flags[1] >> FLAGS.index(each) & 1) for each in ("there", "neutral", "working")] == [1, 1, 0]
    routes = routes_of_field(tmp_path)["GET", "/field"]
    for gone in (lambda: os.utime(log, (time.time() - 9,) * 2), log.unlink):
        gone()
        state = routes(b"from=9")["state"]
        assert state["silent"]
        assert SILENT in state["problems"][-1]


def test_a_field_of_a_strategy_needs_no_compiler_and_runs_no_code(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("def decide(mind, inbox):\n    return mind.opinion\n")
    folder = logged(tmp_path / "logs", small(5, **{"decision.strategy": str(file)}))
    file.unlink()
    text = routes_of_field(folder)["GET", "/"](b"")
    assert str(file) in text
    assert not re.search('"(packets|patches|failures)":', text)


def test_the_command_watches_a_field(ended, monkeypatch):
    assert "can't change" in invoke("watch", ended[0], "--seed", 1).stderr
    assert ("GET", "/field") in watch._routes(ended[0], (), None, None, "wrong", False)
    with pytest.raises(FeasibeeError):
        routes_of_field(Path("nowhere"))
