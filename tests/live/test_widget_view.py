"""The arena in notebooks in a real browser: a page that plays the notebook, and the widget's own Python."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest
from declaring import declaring
from PIL import Image
from playing import swarm_at
from waiting import eventually, expect_rest
from walled import PLACE

from feasibee import Scenario, Swarm, simulate
from feasibee.live.widget import Arena

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect

SCENARIO = Scenario(tasks={"count": 50}, run={"steps": 200})
NOTEBOOK = """async ({ esm, state }) => {
  const within = (text) => {  // like Jupyter's buffers, part of a larger one
    const bytes = Uint8Array.from(atob(text), (each) => each.charCodeAt(0));
    const all = new Uint8Array(bytes.length + 3);
    all.set(bytes, 3);
    return new DataView(all.buffer, 3);
  };
  const handlers = new Map();
  window.model = {
    get: (name) => state[name],
    set(name, value) {
      state[name] = value;
      handlers.get(`change:${name}`)?.();
    },
    save_changes: () => window.save({ step: state.step, speed: state.speed, changes: state.changes }),
    on: (what, does) => handlers.set(what, does),
    off: (what, does) => handlers.get(what) === does && handlers.delete(what),
    async send(content) {
      const [answer, buffers] = await window.ask(content);
      handlers.get("msg:custom")?.(answer, buffers.map(within));
    },
  };
  window.handlers = handlers;
  const blob = URL.createObjectURL(new Blob([esm], { type: "text/javascript" }));
  const widget = (await import(blob)).default, el = document.createElement("div");
  window.end = widget.render({ model, el });
  await new Promise((done) => setTimeout(done, 50));  // notebooks show it later
  document.body.append(el);
}"""
GROUNDS = {"light": (253, 253, 252), "dark": (12, 15, 17)}
FEASIBLE, TASKS = (0, 114, 178), (230, 159, 0)


@pytest.fixture
def show(new_page):
    """Give a function that shows an arena."""

    def shown(arena, **options):
        page = new_page(**options)

        def ask(content):
            answers = []
            arena.send = lambda message, buffers=(): answers.append((message, buffers))
            arena._handle_custom_msg(content, [])
            ((message, buffers),) = answers
            return [message, [base64.b64encode(each).decode() for each in buffers]]

        page.expose_function("ask", ask)
        page.expose_function("save", arena.set_state)
        state = {name: getattr(arena, name) for name in ("_world", "_strategies", "changes", "step", "speed")}
        page.evaluate(NOTEBOOK, {"esm": Arena._esm, "state": state})
        return page

    return shown


def share(canvas, colour):
    """Return how much of a canvas has a colour."""
    picture = np.asarray(Image.open(io.BytesIO(canvas.screenshot())).convert("RGB"))
    return (picture == colour).all(axis=2).mean()


def step_of(page):
    return page.locator("[data-count=step]")


def shown_step(page):
    return int(step_of(page).inner_text())


def expect_step(page, arena, step=None):
    """Expect that Python knows the step that is shown."""

    def check():
        assert arena.step == (shown_step(page) if step is None else step)

    eventually(page, check)


def expect_speed(arena, speed):
    assert arena.speed == speed


def expect_share(page, colour, holds):
    """Expect that a share of the canvas has a colour, once it is drawn."""

    def check():
        assert holds(share(page.locator("canvas"), colour))

    eventually(page, check)


def test_buttons_and_keys_step_play_pause_and_restart(show):
    arena = Arena(SCENARIO, seed=1)
    page = show(arena)
    expect(step_of(page)).to_have_text("0")
    page.get_by_role("button", name="Step").click()
    expect(step_of(page)).to_have_text("1")
    page.locator(".frame").focus()
    for key, step in ((".", "2"), ("ArrowRight", "3")):
        page.keyboard.press(key)
        expect(step_of(page)).to_have_text(step)
    expect_step(page, arena, 3)
    page.keyboard.press(" ")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    expect(step_of(page)).not_to_have_text("3")
    page.get_by_role("button", name="Pause").click()
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    expect_rest(page, shown_step)
    expect_step(page, arena)
    page.keyboard.press("r")
    expect(step_of(page)).to_have_text("0")


def test_it_says_what_is_seen_and_what_a_robot_holds(show):
    page = show(Arena(SCENARIO, seed=1))
    expect(step_of(page)).to_have_text("0")
    page.get_by_text("What am I looking at?").click()
    expect(page.locator("dd")).to_have_count(5)
    swarm = Swarm(SCENARIO, 1)
    page.locator("canvas").scroll_into_view_if_needed()
    box = page.locator("canvas").bounding_box()
    x, y = swarm.positions[4] / 20
    expect(page.locator(".tip")).to_be_hidden()
    page.mouse.move(box["x"] + x * box["width"], box["y"] + (1 - y) * box["height"])
    word = ("infeasible", "feasible")[swarm.opinions[4]]
    said = f"Robot 4: {word}, exploring\nHolds {word} since the start. Heard nobody since the start."
    expect(page.locator(".tip")).to_have_text(said)


def slider(page, name):
    return page.get_by_role("slider", name=f"{name}, slider", exact=True)


def test_its_sliders_change_the_swarm(show):
    arena = Arena(SCENARIO, seed=1)
    page = show(arena, reduced_motion="reduce")
    expect(step_of(page)).to_have_text("0")
    page.get_by_text("Change the swarm").click()
    expect(slider(page, "Tasks")).to_have_value("50")
    slider(page, "Sensing range").fill("3.5")  # the run starts again
    expect(page.locator("[data-path='sensing.range']")).to_have_value("3.5")
    for _ in range(2):
        page.get_by_role("button", name="Step").click()
    expect(step_of(page)).to_have_text("2")
    slider(page, "Tasks").fill("12")  # from the next step on
    expect(step_of(page)).to_have_text("3")
    slider(page, "Robots").fill("24")
    expect(step_of(page)).to_have_text("4")
    slider(page, "Robots").fill("25")  # at the same step, as time stands still
    events = [{"step": 3, "tasks": -38}, {"step": 4, "robots": 5}]
    scenario = SCENARIO.replace({"sensing.range": 3.5, "events": events})
    said = page.get_by_role("img", name="25 robots and 12 tasks")
    expect(said).to_be_visible()
    expect(page.locator("[data-count=feasible]")).to_have_text(str(swarm_at(4, scenario, 1).feasible_count))
    expect_step(page, arena, 4)
    eventually(page, lambda: expect_changes(arena, {"sensing.range": 3.5, "events": events}))
    page.get_by_role("button", name="Copy as scenario").click()
    expect(page.get_by_role("button", name="Selected")).to_be_visible()  # as in a page without a clipboard
    assert Scenario.from_toml(page.evaluate("getSelection().toString()")) == scenario
    page.get_by_label("Strategy").select_option("turns")
    expect(page.locator("#problem")).to_contain_text("turns needs the number of robots")
    expect(said).to_be_visible()  # the previous swarm continues
    page.get_by_role("button", name="Step").click()
    expect(step_of(page)).to_have_text("5")
    page.get_by_label("Strategy").select_option("census")
    expect(step_of(page)).to_have_text("0")
    eventually(page, lambda: expect_changes(arena, {**arena.changes, "decision.strategy": "census"}))


def test_hands_put_move_and_take_away_what_is_in_its_arena(show):
    arena = Arena(SCENARIO, seed=1)
    page = show(arena, reduced_motion="reduce")
    page.get_by_text("Change the swarm").click()

    def point(x, y):
        box = page.locator("canvas").bounding_box()  # the page may have scrolled
        page.mouse.move(box["x"] + x / 20 * box["width"], box["y"] + (1 - y / 20) * box["height"])

    def use(tool, *points):
        page.get_by_role("button", name=tool, exact=True).click()
        point(*points[0])
        page.mouse.down()
        point(*points[-1])
        page.mouse.up()

    for tool, points, told in (
        ("Add tasks", [(5, 7)], "20 robots and 51 tasks"),  # at the start
        ("Move", [(5, 7), (12, 11)], "20 robots and 51 tasks"),
        ("Add robots", [(15, 3)], "21 robots and 51 tasks"),
        ("Remove", [(12, 11)], "21 robots and 50 tasks"),
    ):
        use(tool, *points)
        expect(page.get_by_role("img", name=told)).to_be_visible()
    put, moved, joined, gone = arena.changes["events"]
    assert (put["tasks"], moved["task"], joined["robots"], gone) == (1, 50, 1, {"step": 0, "task": 50})
    assert [*put["at"], *moved["at"], *joined["at"]] == pytest.approx([5, 7, 12, 11, 15, 3], abs=0.1)
    page.get_by_role("button", name="Add robots", exact=True).click()
    page.locator("canvas").evaluate("""at => {
      const box = at.getBoundingClientRect();
      at.parentElement.setPointerCapture = () => {};
      for (const x of [30, 90, 150]) for (const type of ["pointerdown", "pointerup"]) {
        const place = { clientX: box.left + x, clientY: box.top + 90 };
        at.dispatchEvent(new PointerEvent(type, { bubbles: true, ...place }));
      }
    }""")  # two of them before the kernel has answered
    expect(page.get_by_role("img", name="24 robots and 50 tasks")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.locator(".tools p")).to_be_empty()


def expect_changes(arena, changes):
    assert arena.changes == changes


def test_it_plays_to_the_end_and_says_what_simulate_says(show):
    arena = Arena(SCENARIO, seed=1)
    expected = simulate(SCENARIO, 1, 1, curves=True)
    page = show(arena)
    expect(page.locator(".outcome")).to_have_text("not decided (truth: infeasible)")
    slider = page.get_by_role("slider", name="Speed")
    slider.focus()
    for _ in range(12):
        page.keyboard.press("ArrowRight")
    expect(slider).to_have_attribute("aria-valuetext", "3,000 steps / s")
    page.get_by_role("button", name="Play").click()
    expect(step_of(page)).to_have_text("200")
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    eventually(page, lambda: expect_speed(arena, 3000))
    assert expected.decision[0] == 0
    decided = f"decided infeasible at step {int(expected.decision_step[0])}: right"
    expect(page.locator(".outcome")).to_have_text(decided)
    expect(page.locator("[data-count=feasible]")).to_have_text(str(int(expected.feasible_count[0, -1])))
    page.get_by_role("button", name="Play").click()
    expect(step_of(page)).not_to_have_text("200")


@pytest.mark.slow
def test_declarations_are_counted_if_robots_declare(show, tmp_path):
    scenario = declaring(tmp_path, quiet=20.0, tasks={"count": 21}, run={"steps": 60})
    swarm = swarm_at(60, scenario, 3)
    arena = Arena(scenario, seed=3)
    arena.step = 60
    page = show(arena)
    expect(step_of(page)).to_have_text("60")
    feasible, infeasible = swarm.declared_counts
    text = f"declared: {feasible} feasible, {infeasible} infeasible"
    assert feasible
    expect(page.locator(".declared")).to_have_text(text)
    expect(page.locator(".declared")).to_be_visible()
    plain = show(Arena(SCENARIO))
    expect(step_of(plain)).to_have_text("0")
    expect(plain.locator(".declared")).to_be_hidden()


@pytest.mark.quick(1)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_arena_is_drawn_in_the_colours_of_the_system(show, scheme):
    arena = Arena(SCENARIO, seed=1)
    arena.step = 9  # where a view begins
    page = show(arena, color_scheme=scheme, reduced_motion="reduce")
    expect(step_of(page)).to_have_text("9")
    canvas = page.locator("canvas")
    expect_share(page, GROUNDS[scheme], lambda share: share > 0.8)
    expect_share(page, TASKS, lambda share: share > 0.005)
    expect_share(page, FEASIBLE, lambda share: (share > 0.005) == (scheme == "light"))
    before = canvas.screenshot()
    page.get_by_role("button", name="Step").click()
    expect(step_of(page)).to_have_text("10")
    eventually(page, lambda: expect_another(canvas, before))
    page.evaluate("document.body.dataset.jpThemeLight = 'false'")  # as JupyterLab says it
    expect_share(page, GROUNDS["dark"], lambda share: share > 0.8)


def expect_another(canvas, before):
    assert canvas.screenshot() != before


def test_a_problem_or_a_lost_kernel_is_told_and_a_view_that_is_gone_does_nothing(show):
    page = show(Arena(SCENARIO))
    expect(step_of(page)).to_have_text("0")
    page.evaluate("model.send({ step: -1 })")
    expect(page.locator(".kernel")).to_contain_text("message = {'step': -1}: must be")
    page.get_by_role("button", name="Step").click()
    expect(page.locator(".kernel")).to_have_text("")
    expect(step_of(page)).to_have_text("1")
    page.evaluate("() => { model.send = () => { throw new Error('Cannot send'); }; }")
    page.get_by_role("button", name="Step").click()
    expect(page.locator(".kernel")).to_contain_text("Waiting for the kernel")
    page.evaluate("window.end()")
    assert page.evaluate("handlers.size") == 0


def expect_narrow(page):
    box = page.locator("canvas").bounding_box()
    assert box["x"] + box["width"] <= 360
    assert box["width"] == pytest.approx(2 * box["height"], rel=0.02)
    assert page.locator("html").evaluate("each => each.scrollWidth") <= 360


def test_it_fits_a_narrow_page_and_everything_has_a_name(show):
    page = show(Arena(Scenario(arena={"side": (40.0, 20.0)})), viewport={"width": 360, "height": 600})
    expect(step_of(page)).to_have_text("0")
    eventually(page, lambda: expect_narrow(page))
    for role, name in (("img", "20 robots and 20 tasks"), ("slider", "Speed"), ("group", "Swarm")):
        expect(page.get_by_role(role, name=name)).to_be_visible()


@pytest.mark.slow
def test_a_world_that_changes_says_the_truth_of_the_step_and_draws_its_tasks(show):
    events = [{"step": 3, "tasks": 40}, {"step": 6, "tasks": -60}]
    scenario = Scenario(tasks={"count": 20}, events=events, run={"steps": 10})
    page = show(Arena(scenario, seed=1), reduced_motion="reduce")
    expect(step_of(page)).to_have_text("0")
    shown = []
    for step, said in (
        (0, "truth at this step: feasible; 20 robots, 20 tasks"),
        (3, "truth at this step: infeasible; 20 robots, 60 tasks"),
        (6, "truth at this step: feasible; 20 robots, 0 tasks"),
    ):
        while (now := shown_step(page)) < step:
            page.get_by_role("button", name="Step").click()
            expect(step_of(page)).to_have_text(str(now + 1))
        expect(page.locator(".outcome")).to_contain_text(said)
        least = 2 * shown[-1] if shown else 0.0
        expect_share(
            page, TASKS, lambda share, least=least, step=step: share > least if step < 6 else not share
        )
        shown.append(share(page.locator("canvas"), TASKS))


def test_it_draws_walls(show):
    page = show(Arena(PLACE), color_scheme="light")
    wall = 12 / (PLACE.arena.size[0] * PLACE.arena.size[1])
    expect_share(page, (29, 33, 37), lambda share: share > 0.9 * wall)
