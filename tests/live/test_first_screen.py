"""What is seen of the page without scrolling, on screens of all sizes, and that nothing moves by itself."""

from __future__ import annotations

import pytest
import visiting as on
from playing import swarm_at
from waiting import drawn, eventually

from feasibee import Scenario

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect

SCREENS = [(1280, 800), (1440, 900), (1920, 1080), (390, 844)]
BELOW = 60  # pixels that the plot may end below the first screen of a telephone
READINGS = ("#question", "#truth", "#decision", "#many", "#plot", "#arena", "#transport", "#robot")
MIDDLE = """() => {
    const { arena: { px, py, ratio }, frame } = feasibee.lanes[0];
    const { scrollLeft, scrollTop, clientWidth, clientHeight } = frame;
    return [px[4] / ratio - scrollLeft - clientWidth / 2, py[4] / ratio - scrollTop - clientHeight / 2];
}"""
"""How far robot 4 is from the middle of its frame."""
FOLDS = "all => all.map(each => each.open)"


def boxes_of(page, *selectors):
    """Return where elements are, within the window."""
    assert page.evaluate("scrollY") == 0
    return {each: page.locator(each).bounding_box() for each in selectors}


def expect_seen(page, width, height, *selectors, below=0):
    """Expect that elements lie wholly in the first screen."""

    def check():
        for name, box in boxes_of(page, *selectors).items():
            assert box, name
            assert box["x"] >= 0, name
            assert box["y"] >= 0, name
            assert box["x"] + box["width"] <= width, name
            assert box["y"] + box["height"] <= height + below * (name == "#plot"), name

    eventually(page, check)


@pytest.mark.quick(4)
@pytest.mark.parametrize("against", ["", "#against=census"])
@pytest.mark.parametrize("size", SCREENS)
def test_the_answer_is_on_the_first_screen(show, size, against):
    page = show(Scenario(), against, *size)
    below = BELOW if size[0] == 390 else 0
    seen = ["#question", "#decision", "#many", "#plot", "#arena", "#transport", "#now"]
    if against:
        expect(page.locator("#arena-1")).to_be_visible()
        seen += ["#decision-second", "#many-second", "#arena-1", "#caption", "#caption-1"]
    expect(page.locator("#swarms")).to_have_attribute("aria-busy", "false")
    expect_seen(page, *size, *seen, below=below)
    least = {1280: 480, 1440: 560, 1920: 700, 390: 250}[size[0]] // (2 if against else 1)
    assert page.locator("#arena").bounding_box()["width"] >= least
    on.expect_no_scrolling(page, size[0])


@pytest.mark.quick(2)
@pytest.mark.parametrize("width", [360, 390, 740, 760, 900, 1100])
def test_playback_is_in_one_row_and_nothing_is_wider_than_the_window(show, width):
    page = show(Scenario(), width=width)
    for speed in ("20 steps / s", "3,000 steps / s"):
        expect(page.locator("#speed")).to_have_text(speed)
        boxes = [each.bounding_box() for each in page.locator("#transport button").all()]
        assert max(each["y"] for each in boxes) == min(each["y"] for each in boxes)
        assert max(each["x"] + each["width"] for each in boxes) <= width
        for _ in range(8):
            page.keyboard.press("+")
    on.expect_no_scrolling(page, width)
    page.locator("#settings-fold").evaluate("it => (it.open = true)")
    for each in page.locator("#more > details").all():
        each.evaluate("it => (it.open = true)")
    on.expect_no_scrolling(page, width)


@pytest.mark.quick(1)
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("served", [False, True])
def test_a_slider_moves_the_answer_and_no_reading(show, port, width, served):
    page = show(port if served else Scenario(), width=width)
    on.unfolded(page, "#form")
    page.evaluate("scrollTo(0, 0)")
    on.press(page, (".", 1))
    on.seek(page, 30)
    before, folds = boxes_of(page, *READINGS), page.locator("details").evaluate_all(FOLDS)
    moved = "(at, tasks) => { at.value = tasks; at.dispatchEvent(new Event('input')); }"  # and isn't let go
    for tasks in (21, 33, 60, 100, 0, 1, 20):
        on.slider(page, "tasks.count").evaluate(moved, tasks)
        on.asked(page, 20, tasks)
        on.expect_run(page)
        drawn(page, 5)
        on.at(page, 30)
        for name, box in boxes_of(page, *READINGS).items():
            assert abs(box["y"] - before[name]["y"]) <= 30, name
            assert abs(box["x"] - before[name]["x"]) <= 30, name
    assert page.locator("details").evaluate_all(FOLDS) == folds


@pytest.mark.parametrize("size", SCREENS)
@pytest.mark.quick(2)
def test_the_card_of_a_robot_comes_up_where_it_is_seen(show, size):
    page = show(Scenario(), "", *size)
    on.seek(page, 50)
    on.click(page, swarm_at(50, Scenario(), 1).positions[3])
    expect(page.locator("#reasons-0")).to_be_visible()

    def check():
        box = page.locator("#inspector").bounding_box()
        assert box["y"] >= 0
        assert box["y"] + box["height"] <= size[1] + 1
        row = page.locator("#reasons-0 dl > div").nth(2).bounding_box()
        assert box["y"] <= row["y"] < row["y"] + row["height"] <= size[1] + 1
        assert page.locator("#arena").bounding_box()["y"] >= -1  # still beside it

    eventually(page, check)
    page.get_by_role("button", name="Close").first.click()
    expect(page.locator("#reasons-0")).to_be_hidden()


def test_full_screen_hides_the_form(show):
    page = show(Scenario())
    expect(page.locator("#form")).to_be_visible()
    on.focus_nothing(page)
    page.keyboard.press("f")
    for each in ("#settings", "#more", "#arena", "#decision", "#plot", "#transport"):
        expect(page.locator(each)).to_be_visible(visible=each not in ("#settings", "#more"))
    page.keyboard.press("f")
    expect(page.locator("#form")).to_be_visible()


def test_a_zoomed_arena_scrolls_in_its_frame_and_the_page_stays(show):
    page = show(Scenario(run={"steps": 60}))
    before = on.box_of(page, "#frame")
    assert page.locator("#frame").evaluate("({ scrollWidth, clientWidth }) => scrollWidth - clientWidth") == 0
    on.choose(page, 4)
    on.focus_nothing(page)
    page.keyboard.press("z")
    expect(page.locator("#closer")).to_have_attribute("aria-pressed", "true")
    wide = page.locator("#arena").bounding_box()["width"]
    assert wide == pytest.approx(3 * before["width"], rel=0.1)
    assert page.locator("#frame").bounding_box() == before
    drawn(page)
    assert page.evaluate(MIDDLE) == pytest.approx([0, 0], abs=3)
    page.keyboard.press("z")
    expect(page.locator("#closer")).to_have_attribute("aria-pressed", "false")
    assert page.locator("#arena").bounding_box()["width"] == pytest.approx(wide / 3, rel=0.1)
