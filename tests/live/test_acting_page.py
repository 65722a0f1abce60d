"""Robots that act in a real browser: did they do it, who walks where, and what is drawn."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from playing import swarm_at
from serving import serving_at
from visiting import change, expect_reasons, focus_nothing, picture_of, seek, unfolded

from feasibee import Scenario, simulate
from feasibee.live.catalogue import Catalogue

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect

FULL = (230, 159, 0)
"""Fill of a taken task."""
SCENARIO = Scenario(acting={"start": 30}, run={"steps": 150})


@pytest.fixture(scope="module")
def port():
    with serving_at(Catalogue(SCENARIO, 1)) as at:
        yield at


def test_the_page_asks_whether_they_did_it_and_answers(visit, port):
    page, step = visit(port, reduced_motion="reduce"), int(simulate(SCENARIO, 1, 1).all_taken_step[0])
    assert 40 < step < 150
    expect(page.locator("#question")).to_have_text("Did 20 robots do 20 tasks?")
    expect(page.locator("#done")).to_have_text("Not yet: robots stand at 0 of 20 tasks.")
    expect(page.locator("#marks-text")).to_contain_text(
        f"robots stand at all tasks that they can, at step {step}"
    )
    expect(page.locator("#legend-free")).to_be_visible()
    seek(page, step)
    expect(page.locator("#done")).to_have_text(f"Yes: robots stand at 20 of 20 tasks, from step {step} on.")
    expect(page.locator("#announcer")).to_contain_text("Yes: robots stand at 20 of 20")
    for tasks, answer in (("15", "Yes: robots stand at 15 of 15"), ("25", "No: robots stand at 20 of 25")):
        change(page, "tasks.count", tasks)
        expect(page.locator("#question")).to_have_text(f"Did 20 robots do {tasks} tasks?")
        seek(page, 150)
        expect(page.locator("#done")).to_contain_text(answer)
    expect(page.locator("#done")).to_contain_text("tasks, as many as they can, from step ")
    unfolded(page, "[data-path='acting.start']").fill("safe")
    page.locator("[data-path='acting.start']").press("Tab")
    expect(page.locator("#toml")).to_contain_text('start = "safe"')
    page.locator("#reset").click()
    unfolded(page, "[data-path='acting.start']").fill("")
    page.locator("[data-path='acting.start']").press("Tab")
    expect(page.locator("#question")).to_have_text("Can 20 robots do 20 tasks?")
    expect(page.locator("#done")).to_be_hidden()
    expect(page.locator("#legend-free")).to_be_hidden()


def test_a_robot_says_where_it_walks_and_tasks_fill(visit, port):
    page = visit(port, reduced_motion="reduce")
    swarm = swarm_at(33, SCENARIO, 1)
    robot = int(np.flatnonzero(swarm.targets >= 0)[0])
    seek(page, 33)
    page.locator("#robot").fill(str(robot))
    page.locator("#robot").press("Tab")
    expect_reasons(page, swarm, robot)
    expect(page.locator("#reasons-0")).to_contain_text(f"walks to task {swarm.targets[robot]}, ")
    focus_nothing(page)
    assert swarm.standing.any()
    for step, full in ((33, True), (20, False)):
        seek(page, step)
        with Image.open(BytesIO(picture_of(page))) as picture:
            assert (FULL in {colour for _, colour in picture.convert("RGB").getcolors(2**20)}) == full
