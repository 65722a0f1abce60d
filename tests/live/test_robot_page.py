"""A robot of the page: chosen by pointer or keyboard, why it holds its opinion, and its strip."""

from __future__ import annotations

import numpy as np
import pytest
from playing import swarm_at
from visiting import at, choose, control_of, expect_run, focus_nothing, point_at, press, seek
from waiting import eventually

from feasibee import Scenario, Swarm

expect = pytest.importorskip("playwright.sync_api", reason="playwright isn't installed").expect

STRIP = """(at, steps) => steps.map((step) => [1, 5].map((down) => {
  const { left, top, width } = at.getBoundingClientRect(), x = left + step / 1000 * width, y = top + 9 + down;
  const looks = [...at.querySelectorAll("rect")].filter((each) => {
    const box = each.getBoundingClientRect();
    return box.left <= x && x < box.right && box.top <= y && y < box.bottom;
  });
  return looks.map((each) => getComputedStyle(each).fill).at(-1) ?? null;
}))"""
BLUE, VERMILION = "rgb(0, 114, 178)", "rgb(213, 94, 0)"


def expect_rows(page, holds, lane=0):
    """Expect that what a page says of a robot, by title, holds."""

    def check():
        rows = page.locator(f"#reasons-{lane} dl > div").evaluate_all(
            "all => all.map(each => [...each.children].map(part => part.innerText))"
        )
        assert holds(dict(rows)), rows

    eventually(page, check)


def begins(**words):
    return lambda rows: all(rows.get(title, "").startswith(each) for title, each in words.items())


def moments_of(scenario, robot, steps, seed=1):
    """Return the phases of a robot: since when each lasts, whether it broadcasts, and its opinion then."""
    swarm, found = Swarm(scenario, seed), []
    for step in range(steps + 1):
        swarm.advance(step - swarm.step)
        sends, opinion = bool(swarm.disseminating[robot]), int(swarm.opinions[robot])
        if not found or found[-1][1] != sends:
            found.append((step, sends, opinion))
    return found


def test_a_robot_says_what_it_does_and_what_comes_next(show):
    scenario, robot, words = Scenario(), 5, ("infeasible", "feasible")
    page, phases = show(scenario), moments_of(scenario, robot, 300)
    choose(page, robot)
    for k in range(1, 5):
        (begun, sends, opinion), (end, _, following), (then, *_) = phases[k : k + 3]
        step = begun + k % 2
        seek(page, step)
        swarm = swarm_at(step, scenario, 1)
        now = swarm.robot(robot)
        left, lasts = counted(now.phase_left, "step"), counted(then - end, "step")
        own = "" if opinion else f", so {1 - now.feasible_quality:.2f} for its opinion"
        heard = [f"{votes} {word}" for votes, word in zip(now.votes, ("feasible", "infeasible"), strict=True)]
        expected = {
            "Phase": f"disseminating, {left} left; broadcasts {words[opinion]}"
            if sends
            else f"exploring, {left} left",
            "Saw": f"{counted(now.robots_seen[0], 'robot')} and {counted(now.tasks_seen[0], 'task')} ",
            "Heard": heard[0] if any(now.votes) else "nobody since its last decision",
            "Quality": f"{now.feasible_quality:.2f} for feasible{own}, as it last rated it",
            "Next": f"at step {end} it decides: {words[following]}, and explores again for {lasts}"
            if sends
            else f"at step {end} it begins to broadcast for {lasts}, and holds {words[following]}",
            "Rule of dmmd": "",
        }
        expect_rows(page, begins(**expected))
        point_at(page, swarm, robot)
        since = next((phases[j + 1][0] for j in range(k - 1, -1, -1) if phases[j][2] != opinion), "the start")
        told = f"Holds {words[opinion]} since {'step ' * (since != 'the start')}{since} and "
        told += f"{'broadcasts' if sends else 'explores'} since step {begun}. Heard "
        told += ", ".join(each for each in heard if each[0] != "0") or "nobody"
        expect(page.locator("#tip")).to_contain_text(f"{told} since its last decision.")


def counted(count, word):
    return f"{count} {word}{'' if count == 1 else 's'}"


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("changes", "step", "title", "words"),
    [
        ({"decision.strategy": "census", "robots.know_count": True}, 60, "Knows", " tasks, by name"),
        ({"acting.start": 30}, 10, "Acts", "acts from step 30 on"),
        ({"acting.start": 30}, 100, "Acts", "stands at task "),
        ({"acting.start": 30, "units.metres": 0.5}, 31, "Acts", "to task 12, 3.1 units (1.559 m) away"),
        ({"faults.stopped": 0.5, "faults.stop_step": 5}, 10, "Phase", "stopped"),
        ({"units.seconds": 45.5}, 10, "Next", "at step 12 (9 min 6 s)"),
        ({"faults.byzantine": 0.5}, 10, "Special", "Byzantine: it broadcasts what is false"),
    ],
)
def test_a_robot_of_any_kind_says_what_it_is(show, changes, step, title, words):
    page = show(Scenario(run={"steps": 200}).replace(changes))
    seek(page, step)
    choose(page, 0)
    expect_rows(page, lambda rows: words in rows.get(title, ""))


def test_robots_are_inspected_by_keyboard_alone(show):
    page = show(Scenario())
    for _ in range(20):
        if page.evaluate("document.activeElement.id") == "arena":
            break
        page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "arena"
    keys = {"Enter": 0, "ArrowLeft": 19, "ArrowUp": 18, "ArrowRight": 19}
    keys |= {"ArrowDown": 0, "PageDown": 1, "PageUp": 0}
    for key, robot in keys.items():
        page.keyboard.press(key)
        expect(page.locator("#robot")).to_have_value(str(robot))
    at(page, 0)  # arrows went from robot to robot, not from step to step
    press(page, (".", 1))
    expect_rows(page, lambda rows: rows["Phase"])
    page.keyboard.press("Escape")
    expect(page.locator("#reasons-0")).to_be_hidden()
    expect(page.locator("#robot")).to_have_value("")


def test_the_changes_of_a_robot_are_a_strip_and_keys_go_to_them(show):
    page = show(Scenario())
    choose(page, 5)
    swarm, flags = Swarm(Scenario(), 1), []
    for step in range(1001):
        swarm.advance(step - swarm.step)
        flags.append(int(swarm.snapshot().flags[5]) & 7)
    steps = [0, *(step for step in range(1, 1001) if flags[step] != flags[step - 1])]
    expect(page.locator("#marks-text")).to_contain_text(
        f"robot 5 changes opinion or phase {len(steps) - 1} times."
    )
    focus_nothing(page)
    press(page, ("]", steps[1]), ("]", steps[2]), ("[", steps[1]), ("[", 0), ("]", steps[1]))
    ends = [*steps[1:], 1000]
    middles = [(a + b) // 2 for a, b in zip(steps, ends, strict=True) if b - a > 20]
    expected = [[BLUE, BLUE] if flags[each] & 1 else [VERMILION, None] for each in middles]
    assert page.locator("#marks").evaluate(STRIP, middles) == expected
    assert {flags[each] & 5 for each in middles} >= {0, 4}  # it explores and broadcasts with the same look


def test_a_robot_is_clicked_and_stays_in_the_next_run(show):
    page, swarm = show(Scenario()), Swarm(Scenario(), 1)
    expect(page.locator("#tip")).to_be_hidden()
    point_at(page, swarm, 11)
    word = ("infeasible", "feasible")[swarm.opinions[11]]
    expect(page.locator("#tip")).to_contain_text(f"Robot 11: {word}, exploring")
    said = f"Holds {word} since the start and explores since the start. Heard nobody since its last decision."
    expect(page.locator("#tip")).to_contain_text(said)
    page.mouse.down()
    page.mouse.up()
    expect(page.locator("#robot")).to_have_value("11")
    expect_rows(page, begins(Phase="exploring, "))
    page.keyboard.press("n")
    expect(control_of(page, "run")).to_have_value("1")
    expect_run(page)
    left = Swarm(Scenario(), 1, 1).robot(11).phase_left
    expect_rows(page, begins(Phase=f"exploring, {left} step"))
    page.locator("#robot-none").click()
    expect(page.locator("#reasons-0")).to_be_hidden()


def test_a_robot_that_leaves_is_passed_over(show):
    scenario = Scenario(events=[{"step": 40, "robots": -8}], run={"steps": 100})
    before, after = swarm_at(39, scenario, 1), swarm_at(41, scenario, 1)
    gone = int(np.flatnonzero(before.present & ~after.present)[0])
    page = show(scenario)
    seek(page, 39)
    choose(page, gone)
    expect_rows(page, lambda rows: rows["Phase"])
    focus_nothing(page)
    press(page, (".", 40))
    gone_words = {"Phase": "no robot has this number at this step"}
    expect_rows(page, lambda rows: rows == gone_words)
    page.locator("#arena").focus()
    numbers = np.flatnonzero(after.present)
    for key in ("PageDown", *(3 * ("ArrowLeft", "ArrowUp", "ArrowRight", "PageUp", "ArrowDown"))):
        page.keyboard.press(key)
        assert int(page.locator("#robot").input_value()) in numbers  # as soon as the key is down
