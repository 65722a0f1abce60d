"""What tests do on the page of the live arena, and how they wait for what it shows."""

from __future__ import annotations

import numpy as np
from playwright.sync_api import expect
from waiting import drawn, eventually

from feasibee.live.reasons import reasons_of

SHADE = """at => {
  const ratio = at.width / at.clientWidth, [x, y] = [at.clientWidth - 21, 0.35 * at.clientHeight];
  const copy = new OffscreenCanvas(1, 1).getContext("2d");
  copy.drawImage(at, -x * ratio, -y * ratio);
  return copy.getImageData(0, 0, 1, 1).data[3];
}"""


def step_of(page):
    return int(page.locator("#now").inner_text().replace(",", ""))


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


def play_to_the_end(page):
    """Play fast, until time stops."""
    while page.locator("#speed").inner_text() != "3,000 steps / s":
        page.keyboard.press("+")
    page.keyboard.press(" ")
    expect(page.locator("#now")).to_have_text(page.locator("#last").inner_text())
    expect(page.locator("#play")).to_have_attribute("aria-label", "Play")


def unfolded(page, selector):
    """Return an element, after all that is folded around it has been opened."""
    element = page.locator(selector)
    element.evaluate("at => { while (at = at.parentElement?.closest('details')) at.open = true; }")
    return element


def control_of(page, path):
    return unfolded(page, f"[data-path='{path}']")


def change(page, path, value):
    control = control_of(page, path)
    control.fill(value)
    control.press("Tab")
    return control


def focus_nothing(page):
    page.locator("h1").click()


def move(page, x, y):
    """Move the pointer to a place of the paper's arena, in units."""
    box = page.locator("#arena").bounding_box()
    page.mouse.move(box["x"] + x / 20 * box["width"], box["y"] + (1 - y / 20) * box["height"])


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


def expect_reasons(page, swarm, robot, lane=0):
    """Expect that the page says why a robot thinks what it does."""
    expected = reasons_of(swarm, robot)

    def check():
        assert lines_of(page, lane)[1] == expected

    eventually(page, check)


def lines_of(page, lane=0):
    """Return the step that is shown and the lines on a robot, both at one moment."""
    step, lines = page.evaluate(
        """lane => { const lines = document.querySelectorAll(`#reasons-${lane} dl > div`);
        return [document.querySelector("#now").innerText,
            [...lines].map(line => [...line.children].map(each => each.innerText))]; }""",
        lane,
    )
    return int(step.replace(",", "")), lines


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


def expect_picture(page, picture, selector="#arena"):
    """Expect that an element looks as in a picture."""

    def check():
        assert page.locator(selector).screenshot() == picture

    eventually(page, check)


def box_of(page, selector):
    """Return where an element is once it stays there."""
    boxes = []

    def check():
        drawn(page)
        boxes.append(page.locator(selector).bounding_box())
        assert len(boxes) > 1
        assert boxes[-1] == boxes[-2]

    eventually(page, check)
    return boxes[-1]


def point_at(page, swarm, robot, act):
    """Move the pointer to a robot or click it, by the mouse's function of that name."""
    width, height = swarm.scenario.arena.size
    x, y = swarm.positions[robot] / np.array([width, height])
    box = box_of(page, "#arena")
    getattr(page.mouse, act)(box["x"] + x * box["width"], box["y"] + (1 - y) * box["height"])


def seen_at(page, x, y):
    """Return the colour of the arena's canvas at shares of its width and height, from the upper left."""
    return page.locator("#arena").evaluate(
        """(at, [x, y]) => {
            const copy = new OffscreenCanvas(1, 1).getContext("2d");
            copy.drawImage(at, -Math.floor(x * at.width), -Math.floor(y * at.height));
            return [...copy.getImageData(0, 0, 1, 1).data].slice(0, 3);
        }""",
        [x, y],
    )


def colours_of(page, selector):
    """Return the opaque colours of a canvas."""
    found = page.evaluate(
        """selector => { const it = document.querySelector(selector), found = new Set();
        const data = it.getContext("2d").getImageData(0, 0, it.width, it.height).data;
        for (let k = 0; k < data.length; k += 4)
            if (data[k + 3] === 255) found.add(data.slice(k, k + 3).join());
        return [...found]; }""",
        selector,
    )
    return set(found)


def expect_no_scrolling(page, width):
    """Expect that the page is no wider than its window."""

    def check():
        assert page.evaluate("document.documentElement.scrollWidth") <= width

    eventually(page, check)


def expect_shade(page, canvas, shaded):
    """Wait until a plot has the shade of the theory at its end, above half of the robots; or hasn't."""

    def check():
        assert (page.locator(canvas).evaluate(SHADE) > 0) == shaded

    eventually(page, check)
