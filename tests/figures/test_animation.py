"""Animations: what frames show, what files hold, what is refused."""

from __future__ import annotations

import shutil
import sys
import weakref

import commands
import imageio_ffmpeg
import numpy as np
import pytest
from click.testing import CliRunner
from declaring import declaring
from PIL import Image
from PIL.ImageColor import getrgb
from pixels import close, frames_of, seen_at

from feasibee import FeasibeeError, Scenario, Swarm, simulate
from feasibee.base.codes import COLOURS
from feasibee.cli import main
from feasibee.figures.animation import AFTER_DECISION, animate, draw_frame
from feasibee.simulation.frames import DARK, DRAWN, LIGHT, Painter

NAMES = {1: "feasible", 0: "infeasible", -1: "undecided"}
WORLDS = {
    "torus": Scenario(tasks={"count": 50}),
    "walls": Scenario(
        arena={"side": (30.0, 20.0), "boundary": "walls"},
        robots={"count": 30, "avoid_collisions": True},
        tasks={"count": 8},
    ),
    "tall": Scenario(arena={"side": (10.0, 25.0)}, faults={"byzantine": 0.2}),
}


def standing_at(*places, boundary="torus", **robots):
    """Make robots that stay where they are."""
    return Swarm(
        Scenario(
            arena={"boundary": boundary},
            robots={"placement": "points", "points": places, "speed": 0.0, **robots},
            tasks={"count": 0},
        )
    )


def agreement(picture, swarm):
    """Return the share of the robots, alone in their place, whose pixels have the colour of their opinion."""
    places, counted = swarm.positions, swarm.counted
    gaps = np.hypot(*np.moveaxis(places[:, None] - places[None], -1, 0)) + 9 * np.eye(len(places))
    side = np.array(swarm.scenario.arena.size)
    shown = [
        close(  # above the middle, where infeasible has its hole
            seen_at(picture, swarm.scenario, places[robot] + np.array([0, 0.36])),
            COLOURS[NAMES[int(swarm.opinions[robot])]],
        )
        for robot in range(len(places))
        if counted[robot] and gaps[robot].min() > 1.3 and (side - places[robot] > 1).all()
    ]
    assert len(shown) >= 3
    return np.mean(shown)


# --- What a frame shows ---


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("step", [0, 7, 60])
def test_the_frame_of_a_step_shows_the_engines_step(tmp_path, world, step):
    scenario = WORLDS[world]
    path = tmp_path / "frame.png"
    animate(scenario, path, seed=3, run=5, steps=(0, step), size=600)
    swarm = Swarm(scenario, seed=3, run=5)
    swarm.advance(step)
    with Image.open(path) as picture:
        assert agreement(picture, swarm) == 1
        swarm.advance(3)
        assert agreement(picture, swarm) < 0.7


@pytest.mark.parametrize("dark", [False, True])
def test_a_frame_of_a_swarm_of_ones_own(dark):
    swarm = Swarm(WORLDS["torus"], seed=1)
    swarm.advance(12)
    picture = draw_frame(swarm, size=501, dark=dark)
    assert picture.mode == "RGB"
    assert picture.width == 502
    assert picture.height % 2 == 0
    assert agreement(picture, swarm) == 1
    assert (sum(picture.getpixel((0, 0))) < 200) == dark
    with_curve = draw_frame(swarm, size=501, dark=dark, span=(12, 12))
    assert with_curve.height > picture.height


@pytest.mark.parametrize(("boundary", "copies"), [("torus", True), ("walls", False)])
def test_a_robot_near_an_edge_of_a_torus_shows_on_both_sides(boundary, copies):
    swarm = standing_at((0.5, 19.5), boundary=boundary, diameter=2.0 if copies else 1.0)
    picture = draw_frame(swarm)
    paper = picture.getpixel((0, 0))
    for place in ((19.8, 19.8), (0.4, 0.2), (19.8, 0.2)):
        assert (not close(seen_at(picture, swarm.scenario, place), paper)) == copies


def test_an_opinion_has_a_shape_beside_its_colour():
    swarm = Swarm(Scenario(robots={"count": 40}, tasks={"count": 0}), seed=1)
    picture, seen = draw_frame(swarm, size=1000), set()
    for robot, place in enumerate(swarm.positions):
        others = np.hypot(*(np.delete(swarm.positions, robot, 0) - place).T)
        if others.min() > 1.5:
            opinion = int(swarm.opinions[robot])
            seen.add(opinion)
            middle = LIGHT.paper if opinion == 0 else COLOURS[NAMES[opinion]]
            assert close(seen_at(picture, swarm.scenario, place), middle)
    assert seen == {0, 1}


def test_the_curve_of_infeasible_is_dashed():
    swarm = Swarm(Scenario(), seed=3)
    swarm.advance(20)
    painter = Painter(swarm.scenario, 480, span=(0, 30))
    picture = np.asarray(painter.draw(swarm))
    left, top, right, bottom = (each // DRAWN for each in painter.strip)
    columns = slice(left + 4, left + (right - left) * 20 // 30 - 10)  # without the robots at the curves' ends
    for name, gaps in {"feasible": False, "infeasible": True}.items():
        there = np.abs(picture[top:bottom, columns] - np.array(getrgb(COLOURS[name]))).sum(axis=2) < 60
        assert there.any()
        assert (~there.any(axis=0)).any() == gaps


def test_a_robot_has_a_tick_where_it_goes_and_none_if_it_stands_still_for_good():
    faults = {"stopped": 0.5, "stop_step": 10}
    swarm = Swarm(Scenario(arena={"side": 40.0}, tasks={"count": 0}, faults=faults), seed=1)
    swarm.advance(10)
    there = swarm.positions
    swarm.advance(1)
    moved = (swarm.positions - there + 20) % 40 - 20  # round the torus
    picture, seen = draw_frame(swarm, size=1200), []
    for place, (dx, dy), disseminates in zip(swarm.positions, moved, swarm.disseminating, strict=True):
        others = np.sort(np.hypot(*(swarm.positions - place).T))
        if disseminates or others[1] < 2 or not (place > 1).all() or not (place < 39).all():
            continue  # its ring has the colour of its opinion, or something else is near
        turn = np.arctan2(dy, dx) + np.pi / 2 * np.arange(4)
        around = place + 0.72 * np.stack([np.cos(turn), np.sin(turn)], axis=1)  # beyond the disc
        paper = [close(seen_at(picture, swarm.scenario, each), picture.getpixel((0, 0))) for each in around]
        assert paper == [not (dx or dy), True, True, True]
        seen.append(paper[0])
    assert set(seen) == {True, False}


@pytest.mark.parametrize("dark", [False, True])
def test_a_robot_that_has_declared_has_a_rim(tmp_path, dark):
    swarm = Swarm(declaring(tmp_path, quiet=20.0, tasks={"count": 21}), seed=3)
    swarm.advance(61)
    frame, ink = draw_frame(swarm, size=1000, dark=dark), (DARK if dark else LIGHT).ink
    rims = {}
    for robot, place in enumerate(swarm.positions):
        if np.sort(np.hypot(*(swarm.positions - place).T))[1] > 1.5:
            rims[robot] = close(seen_at(frame, swarm.scenario, place + np.array([0, 0.47])), ink)
    assert rims == {robot: swarm.declared[robot] >= 0 for robot in rims}
    assert set(rims.values()) == {True, False}
    # their counts have a line of their own
    assert frame.height > draw_frame(Swarm(Scenario()), size=1000).height


def test_robots_that_are_not_counted_are_pale():
    swarm = Swarm(Scenario(tasks={"count": 0}, faults={"byzantine": 0.5}), seed=1)
    picture = draw_frame(swarm, size=600)
    for place, counted in zip(swarm.positions, swarm.counted, strict=True):
        seen = seen_at(picture, swarm.scenario, place + np.array([0, 0.36]))
        full = any(close(seen, each) for each in COLOURS.values())
        assert full == counted


# --- What files hold ---


def test_a_gif_holds_every_frame_for_its_time(tmp_path):
    path = tmp_path / "run.gif"
    animate(WORLDS["torus"], path, seed=1, steps=(4, 16), every=4, fps=25, size=240)
    shown, durations, loop = frames_of(path)
    assert durations == [40, 40, 40, 2000]
    assert loop == 0
    swarm = Swarm(WORLDS["torus"], seed=1)
    painter = Painter(swarm.scenario, 240, span=(4, 16))
    for step in range(1, 17):
        swarm.advance()
        if step % 4 == 0:
            drawn = np.asarray(painter.draw(swarm)).astype(int)
            assert np.abs(drawn - shown[step // 4 - 1]).max(axis=2).mean() < 3  # but for soft edges
            assert np.abs(drawn - shown[step // 4 - 1]).max() < 100


def test_the_same_arguments_give_the_same_gif(tmp_path):
    for name in ("one.gif", "two.gif"):
        animate(WORLDS["walls"], tmp_path / name, seed=2, run=7, steps=(0, 20), size=240, dark=True)
    assert (tmp_path / "one.gif").read_bytes() == (tmp_path / "two.gif").read_bytes()
    animate(WORLDS["walls"], tmp_path / "two.gif", seed=2, run=8, steps=(0, 20), size=240, dark=True)
    assert (tmp_path / "one.gif").read_bytes() != (tmp_path / "two.gif").read_bytes()


def test_a_still_swarm_is_a_gif_too(tmp_path):
    path = tmp_path / "still.gif"
    scenario = Scenario(robots={"speed": 0.0}, tasks={"count": 0})
    animate(scenario, path, steps=(0, 1), size=240)
    assert len(frames_of(path)[0]) == 2


def test_a_webp_holds_what_a_gif_does(tmp_path):
    for name in ("run.gif", "run.webp"):
        animate(WORLDS["torus"], tmp_path / name, seed=1, steps=(0, 6), size=240)
    ours, theirs = frames_of(tmp_path / "run.gif")[0], frames_of(tmp_path / "run.webp")[0]
    np.testing.assert_array_equal(ours, theirs)
    with Image.open(tmp_path / "run.webp") as film:
        assert film.info["loop"] == 0


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # from imageio's reader
@pytest.mark.parametrize("robots", [20, 10_000])
def test_an_mp4_plays_everywhere(tmp_path, robots):
    side = 20.0 * (robots / 20) ** 0.5
    scenario = Scenario(arena={"side": side}, robots={"count": robots}, tasks={"count": robots // 2})
    path = tmp_path / "run:1.mp4"
    animate(scenario, path, seed=1, steps=(0, 3), fps=4, size=300)
    reader = imageio_ffmpeg.read_frames(str(path))
    meta = next(reader)
    swarm = Swarm(scenario, seed=1)
    drawn = draw_frame(swarm, size=300, span=(0, 0))
    assert (meta["codec"], meta["fps"], meta["size"]) == ("h264", 4, drawn.size)
    assert meta["pix_fmt"].startswith("yuv420p")
    shown = [np.frombuffer(each, np.uint8).reshape(drawn.height, drawn.width, 3) for each in reader]
    assert len(shown) == 4 + 2 * 4 - 1
    arena = slice(0, 280)
    assert np.abs(np.asarray(drawn, int)[arena] - shown[0][arena]).mean() < 8
    assert np.abs(shown[3].astype(int) - shown[-1]).mean() < 1  # the last one stays


def test_by_default_a_run_is_shown_until_a_while_after_its_decision(tmp_path):
    path = tmp_path / "run.gif"
    scenario = WORLDS["torus"].replace({"run.stop_at_decision": True})
    decided = int(simulate(scenario, 1, seed=1).decision_step[0])
    animate(scenario, path, seed=1, every=10, size=240)
    assert len(frames_of(path)[0]) == (decided + max(AFTER_DECISION, decided // 4)) // 10 + 1
    undecided = scenario.replace({"run.steps": 20})
    assert simulate(undecided, 1, seed=1).decision[0] == -1
    animate(undecided, path, seed=1, size=240)
    assert len(frames_of(path)[0]) == 21


@pytest.mark.parametrize("suffix", ["gif", "webp", "mp4"])
def test_frames_are_not_kept(tmp_path, monkeypatch, suffix):
    alive, draw = [], Painter.draw

    def watched(self, *arguments):
        drawn = draw(self, *arguments)
        alive.append(weakref.ref(drawn))
        assert sum(each() is not None for each in alive) <= 3
        return drawn

    monkeypatch.setattr(Painter, "draw", watched)
    animate(WORLDS["torus"], tmp_path / f"run.{suffix}", steps=(0, 15), size=240)
    assert len(alive) == 16


# --- What is refused, and how it ends ---


def refused(*arguments):
    return "\n".join(commands.refused("run", *arguments))


@pytest.fixture
def no_simulation(monkeypatch):
    """The engine, which must not be asked."""

    def work(*arguments, **options):
        pytest.fail("the simulation began")

    monkeypatch.setattr("feasibee.figures.animation.simulate_record", work)
    monkeypatch.setattr("feasibee.figures.animation.Swarm", work)


REFUSED = {
    "end the name with .nc, .csv, .png, .pdf, .svg, .gif, .webp, .mp4 or .html": ("--out", "run.avi"),
    "must be one of 1, 2, 4, 5, 10, 20, 25, 50": ("--fps", 30),
    "can't be written": ("--out", "nowhere/run.gif"),
    "0 and run.steps = 1000": ("--frames", "0:1001"),
    "must not begin after its end": ("--frames", "7:3"),
    "such as 100 or 50:100": ("--frames", "7:x"),
    "use every = 4": ("--frames", "0:70000", "--set", "run.steps=100000"),
    "--size": ("--size", 100),
    'pip install ".[video]"': ("--out", "run.mp4"),
}


@pytest.mark.usefixtures("no_simulation")
def test_what_cannot_be_written_is_refused_before_the_work(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    for told, options in REFUSED.items():
        assert told in refused(*(() if "--out" in options else ("--out", "run.gif")), *options)
    with pytest.raises(FeasibeeError, match="size = 5000"):
        animate(Scenario(), "run.gif", size=5000)
    with pytest.raises(FeasibeeError, match=r"size = 4096: a GIF of 301 frames .* write \.webp"):
        animate(Scenario(), "run.gif", size=4096, steps=(0, 300))
    assert list(tmp_path.iterdir()) == []


def test_an_encoder_that_fails_leaves_no_file(tmp_path, monkeypatch):
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", lambda: shutil.which("false"))
    assert "ffmpeg ended with 1" in refused("--out", tmp_path / "run.mp4", "--frames", 3)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", ["gif", "webp", "mp4", "png"])
def test_an_interruption_leaves_what_was_there(tmp_path, monkeypatch, suffix):
    out = tmp_path / f"run.{suffix}"
    out.write_text("before")
    draw = Painter.draw

    def interrupted(self, swarm):
        if swarm.step == 5:
            raise KeyboardInterrupt
        return draw(self, swarm)

    monkeypatch.setattr(Painter, "draw", interrupted)
    arguments = ["run", "--frames", "5", "--size", "240", "--out", str(out)]
    assert CliRunner().invoke(main, arguments).exit_code == 130
    assert [each.name for each in tmp_path.iterdir()] == [out.name]
    assert out.read_text() == "before"


@pytest.mark.parametrize("suffix", ["gif", "png"])
def test_the_command_writes_what_the_function_does(tmp_path, suffix):
    one, two = tmp_path / f"one.{suffix}", tmp_path / f"two.{suffix}"
    options = "--set tasks.count=50 --seed 1 --run 3 --frames 2:9 --every 2 --fps 10 --size 240 --dark"
    result = CliRunner().invoke(main, ["run", *options.split(), "--out", str(one)])
    assert result.exit_code == 0, result.output
    assert result.stdout.endswith(f"\nWrote {one}\n")
    animate(WORLDS["torus"], two, 1, 3, steps=(2, 9), every=2, fps=10, size=240, dark=True)
    assert one.read_bytes() == two.read_bytes()
    assert {each.name for each in tmp_path.iterdir()} == {one.name, two.name}


def test_with_an_animation_a_png_is_the_figure_of_all_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = "run --runs 3 --steps 20 --frames 2:9 --size 240 --out one.gif --out one.png --out two.nc"
    assert CliRunner().invoke(main, words.split()).exit_code == 0
    assert CliRunner().invoke(main, ["run", "--again", "two.nc", "--again", "one.png"]).exit_code == 0
    animate(Scenario(run={"steps": 20}), "two.gif", steps=(2, 9), size=240)
    assert (tmp_path / "one.gif").read_bytes() == (tmp_path / "two.gif").read_bytes()
