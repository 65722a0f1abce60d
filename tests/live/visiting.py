"""What tests do on the page, and how they wait for what it shows."""

from __future__ import annotations

import numpy as np
from playing import swarm_at
from playwright.sync_api import expect
from waiting import drawn, eventually

from feasibee import Scenario

DONE = "() => globalThis.feasibee?.lanes.every(each => !each.coming && each.history?.done !== false)"
FRAMES = """steps => feasibee.history && steps.map(step => Object.fromEntries(
    Object.entries(feasibee.history.frame(step)).map(([key, all]) => [key, all?.length ? [...all] : all])))"""


def expect_run(page):
    """Wait until a page shows a run, and knows all of it."""
    expect(page.locator("#arena[data-drawn]")).to_be_visible()
    page.wait_for_function(DONE)


def frames_of(page, steps):
    """Return some steps of the run that a page shows, as its arena draws them."""
    return page.evaluate(FRAMES, list(steps))


def at(page, step):
    """Wait until a page shows a step."""
    expect(page.locator("#now")).to_have_text(f"{step:,}")
    expect(page.locator("#seek")).to_have_value(str(step))


def seek(page, step):
    """Move the slider to a step, and wait until the page shows it."""
    page.locator("#seek").fill(str(step))
    at(page, step)


def press(page, *keys):
    """Press keys, each given with the step that the page then shows."""
    for key, step in keys:
        page.keyboard.press(key)
        at(page, step)


def unfolded(page, selector):
    """Return an element, after all that is folded around it has been opened."""
    element = page.locator(selector)
    element.evaluate("at => { while (at = at.parentElement?.closest('details')) at.open = true; }")
    return element


def control_of(page, path):
    return unfolded(page, f"[data-path='{path}']")


def slider(page, path):
    return page.locator(f"[data-slides='{path}']")


def type_into(page, path, text):
    control = control_of(page, path)
    control.fill(text)
    control.press("Tab")
    return control


def choose(page, robot):
    page.locator("#robot").fill(str(robot))
    page.locator("#robot").press("Tab")
    expect(page.locator("#reasons-0")).to_be_visible()


def focus_nothing(page):
    page.locator("h1").click()


def asked(page, robots, tasks):
    """Wait until a page asks whether so many robots can do so many tasks."""
    words = [
        f"{count} {word}{'' if count == 1 else 's'}" for count, word in ((robots, "robot"), (tasks, "task"))
    ]
    expect(page.locator("#question")).to_have_text(f"Can {words[0]} do {words[1]}?")


def scenario_of(page):
    """Return the scenario that a page shows."""
    return Scenario.from_toml(page.locator("#toml").text_content())


def expect_scenario(page, scenario):
    def check():
        assert scenario_of(page) == scenario, page.locator("#notice").text_content()

    eventually(page, check)


def expect_swarm(page, step, scenario, seed=1):
    """Expect that a page shows a step of a scenario's run, and has its scenario."""
    swarm = swarm_at(step, scenario, seed)
    at(page, step)
    asked(page, int(swarm.present.sum()), len(swarm.tasks))
    expect(page.locator("#truth")).to_contain_text("Truth: Yes" if swarm.truth else "Truth: No")
    expect(page.locator("#feasible")).to_have_text(str(swarm.feasible_count))
    expect(page.locator("#infeasible")).to_have_text(str(swarm.infeasible_count))
    expect_scenario(page, scenario)
    (frame,) = frames_of(page, [step])
    assert [frame["x"], frame["y"]] == [each.tolist() for each in swarm.snapshot()[:2]]


def use(page, tool):
    """Choose one of the page's tools, so that the pointer uses it."""
    unfolded(page, "#tools")
    page.locator("#tools").get_by_role("button", name=tool, exact=True).click()


def move(page, x, y, side=(20, 20)):
    """Move the pointer to a place of the arena, in units."""
    box = box_of(page, "#arena")
    page.mouse.move(box["x"] + x / side[0] * box["width"], box["y"] + (1 - y / side[1]) * box["height"])


def click(page, *places):
    for place in places:
        move(page, *place)
        page.mouse.down()
        page.mouse.up()


def drag(page, start, end):
    move(page, *start)
    page.mouse.down()
    move(page, *end)
    page.mouse.up()


def box_of(page, selector):
    """Return where an element is once it stays there; scroll there if the pointer couldn't get there."""
    page.locator(selector).scroll_into_view_if_needed()
    boxes = []

    def check():
        drawn(page)
        boxes.append(page.locator(selector).bounding_box())
        assert len(boxes) > 1
        assert boxes[-1] == boxes[-2]

    eventually(page, check)
    return boxes[-1]


def point_at(page, swarm, robot):
    """Move the pointer to a robot."""
    move(page, *swarm.positions[robot], swarm.scenario.arena.size)


def picture_of(page, selector="#arena"):
    """Return a picture of an element once it stays as it is."""
    element, seen = page.locator(selector), []

    def check():
        drawn(page)
        seen.append(element.screenshot())
        assert len(seen) > 1
        assert seen[-1] == seen[-2]

    eventually(page, check)
    return seen[-1]


def colours_at(page, *places, side=(20, 20)):
    """Return the colours of the arena's canvas at places in units."""
    shares = [[x / side[0], 1 - y / side[1]] for x, y in places]
    return page.locator("#arena").evaluate(
        """(at, places) => places.map(([x, y]) => {
            const copy = new OffscreenCanvas(1, 1).getContext("2d");
            copy.drawImage(at, -Math.floor(x * at.width), -Math.floor(y * at.height));
            return [...copy.getImageData(0, 0, 1, 1).data].slice(0, 3);
        })""",
        shares,
    )


def expect_colours(page, colours, side=(20, 20)):
    """Expect colours at places of the arena, in units."""

    def check():
        found = colours_at(page, *colours, side=side)
        for place, colour, expected in zip(colours, found, colours.values(), strict=True):
            assert np.allclose(colour, expected, atol=3), place

    eventually(page, check)


def expect_no_scrolling(page, width):
    """Expect that the page is no wider than its window."""

    def check():
        assert page.evaluate("document.documentElement.scrollWidth") <= width

    eventually(page, check)
