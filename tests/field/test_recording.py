"""A field's animation equals that of the run; it shows faults and lost robots; a damaged log is an error."""

from __future__ import annotations

import pytest
from commands import invoke, refused_in_a_line
from fields import MINE, NEEDS_GROUPS, PUT, STREAMS, a_plan, change_line, run, small
from nets import play
from PIL import ImageColor
from pixels import frames_of

from feasibee import Swarm
from feasibee.base.errors import FeasibeeError
from feasibee.field.plan import Fault, fault_in_words, numbers_in_words
from feasibee.field.recording import Recording
from feasibee.figures.animation import animate, animate_field
from feasibee.simulation.frames import DRAWN, LIGHT, Painter

pytestmark = NEEDS_GROUPS

PLAIN = small(steps=80)
WORLDS = {
    "the paper's strategy": PLAIN,
    "walls, collisions and faulty robots": small(
        robots=8,
        **{
            "arena.boundary": "walls",
            "robots.avoid_collisions": True,
            "robots.contact": "deflect",
            "faults.stopped": 0.5,
            "faults.stop_step": 20,
            "faults.byzantine": 0.2,
            "faults.stubborn": 0.2,
        },
    ),
    "declarations": small(**{"decision.strategy": "quiet-census", "robots.know_count": True}),
    "robots and tasks that come and go": small(**STREAMS),
    "robots and tasks that are put at points": small(events=PUT),
}
FAULTS = (Fault(10, "kill", 2, (4, 5)), Fault(20, "partition", lasts=5.0))


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The folder of a field in lockstep without faults."""
    folder = tmp_path_factory.mktemp("plain")
    play(a_plan(PLAIN), folder)
    return folder


@pytest.fixture(scope="module")
def faulty(tmp_path_factory):
    """The folder of a field whose robots 4 and 5 are killed, and whose radio is cut."""
    folder = tmp_path_factory.mktemp("faulty")
    run(a_plan(small(robots=6), faults=FAULTS, patience=3.0), folder)
    return folder


def changed(folder, tmp_path, at, **fields):
    """Return a copy of a log with a changed line; the first line is number 1."""
    log = tmp_path / "world.jsonl"
    log.write_text((folder / log.name).read_text())
    change_line(log, at, **fields)
    return tmp_path


def check_equal(scenario, folder):
    """Check that all frames, the captions included, are those of the run."""
    field, swarm = Recording(folder), Swarm(scenario, 1, 0)
    ours, theirs = (Painter(each.scenario, 240, span=(0, field.last)) for each in (field, swarm))
    for step in range(field.last + 1):
        assert field.step == swarm.step == step
        frames = [ours.draw(field, field.notes_at(step), field.lost), theirs.draw(swarm)]
        assert frames[0] == frames[1], step
        field.advance()
        swarm.advance()


@pytest.mark.quick(1)
@pytest.mark.parametrize("world", list(WORLDS)[1:])
def test_each_frame_of_a_field_in_lockstep_equals_that_of_the_run(world, tmp_path):
    play(a_plan(WORLDS[world]), tmp_path)
    check_equal(WORLDS[world], tmp_path)


@pytest.mark.slow
def test_a_file_of_a_field_in_lockstep_equals_that_of_the_run(plain, tmp_path):
    check_equal(PLAIN, plain)
    for suffix in (".gif", ".png"):
        one, two = tmp_path / f"one{suffix}", tmp_path / f"two{suffix}"
        animate_field(plain, one, every=5, size=240)
        animate(PLAIN, two, seed=1, every=5, size=240)
        assert one.read_bytes() == two.read_bytes()


def test_the_command_writes_what_the_function_does(plain, tmp_path):
    one, two = tmp_path / "one.gif", tmp_path / "two.gif"
    told = invoke("robot", "replay", plain, "--frames", "3:9", "--every", 3, "--dark", "--out", one)
    assert told.exit_code == 0, told.output
    animate_field(plain, two, steps=(3, 9), every=3, dark=True)
    assert one.read_bytes() == two.read_bytes()
    assert len(frames_of(one)[0]) == 3


@pytest.mark.slow
def test_lost_robots_are_grey_and_faults_are_in_words(faulty):
    field = Recording(faulty)
    told = [field.notes_at(step) for step in range(field.last + 1)]
    killed, lost = "step 10: robots 4 to 5 are killed", "lost: 4 to 5"
    cut = "step 20: the radio is cut in two for 5 steps"
    assert told[8] == []
    assert [told[step] for step in (10, 20, 24, 25)] == [
        [killed, lost],
        [killed, cut, lost],
        [killed, cut, lost],
        [killed, lost],
    ]
    painter = Painter(field.scenario, 600, notes=told)
    field.advance(40)
    assert painter.draw(field, told[40], field.lost).size == painter.draw(field).size
    x, y = field.positions[5] + (0.0, 0.36)  # above the middle, where infeasible has its hole
    at = (painter.corner[0] + x * painter.scale, painter.corner[1] + painter.arena[1] - y * painter.scale)
    for lost_robots, is_grey in ((field.lost, True), (None, False)):
        colour = painter.draw(field, told[40], lost_robots).getpixel([int(each / DRAWN) for each in at])
        assert (colour == ImageColor.getrgb(LIGHT.faint)) == is_grey
    assert field.counted.tolist() == [True] * 4 + [False] * 2
    assert (field.headings == 0).tolist() == [False] * 4 + [True] * 2


def test_a_field_with_faults_gives_frames_of_one_size(faulty, tmp_path):
    animate_field(faulty, tmp_path / "run.gif", every=5, size=300)
    assert len({frame.shape for frame in frames_of(tmp_path / "run.gif")[0]}) == 1
    plainer = Painter(small(robots=6), 300, span=(0, 40)).size[1] // 2
    assert frames_of(tmp_path / "run.gif")[0][0].shape[0] > plainer


def test_numbers_of_robots_are_ranges():
    assert numbers_in_words([3]) == "3"
    assert numbers_in_words([0, 2, 3, 4, 9]) == "0, 2 to 4, 9"
    assert numbers_in_words([0, 2, 4, 6, 8, 9]) == "0, 2, 4 and 3 more"
    assert fault_in_words(Fault(1, "resume", 1, (7,))._asdict()) == "robot 7 goes on"


def test_a_log_of_a_killed_world_is_shown_without_its_last_line(plain, tmp_path):
    text = (plain / "world.jsonl").read_text().splitlines(keepends=True)
    (tmp_path / "world.jsonl").write_text("".join(text[:12]) + text[12][:30])
    assert Recording(tmp_path).last == 10
    with pytest.raises(FeasibeeError, match="0 and the log's last step = 10; such as 0:10"):
        animate_field(tmp_path, tmp_path / "run.gif", steps=(0, 11))


@pytest.mark.parametrize(
    "fields",
    [
        {"step": 7},
        {"bodies": []},
        {"robots": [0, 1, 2, 4]},
        {"processes": [0, 1, 2]},
        {"tasks": None},
        {"bodies": [[10**400, 0, 0, 0]] * 4},
        {"minds": None},
        {"lost": None},
        {"decision": 1},
        {"event": "fault"},
    ],
)
def test_a_damaged_line_is_named(plain, tmp_path, fields):
    folder = changed(plain, tmp_path, 5, **fields)
    line = refused_in_a_line("robot", "replay", folder, "--out", tmp_path / "run.gif")
    assert "line 5: can't be read (" in line
    assert "the log is damaged: use an intact copy" in line
    assert not (tmp_path / "run.gif").exists()


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"version": 1}, "isn't the world's log of a field, version 6; run the field again with --out"),
        ({"feasibee": "robot"}, "isn't the world's log of a field"),
        ({"scenario": 5}, "line 1: can't be read"),
        ({"scenario": "robots = 5"}, "robots = 5"),
        ({"seed": -1}, "seed = -1"),
    ],
)
def test_a_first_line_that_cant_be_is_an_error(plain, tmp_path, fields, told):
    folder = changed(plain, tmp_path, 1, **fields)
    assert told in refused_in_a_line("robot", "replay", folder, "--out", tmp_path / "run.gif")


def test_a_strategys_text_comes_with_the_log_and_is_never_run(plain, tmp_path):
    text = f"X = 1 / 0\n{MINE}"
    toml = PLAIN.to_toml().replace('strategy = "dmmd"', 'strategy = "/nowhere/theirs.py"')
    folder = changed(plain, tmp_path, 1, scenario=toml, source=text)
    animate_field(folder, tmp_path / "run.png", size=240)
    assert not Recording(folder).scenario.manifest.trusted


def test_a_folder_without_a_log_or_steps_is_an_error(plain, tmp_path):
    out = tmp_path / "run.gif"
    line = refused_in_a_line("robot", "replay", tmp_path, "--out", out)
    assert "world.jsonl: can't be read: No such file" in line
    assert "feasibee robot launch --out FOLDER" in line
    log = tmp_path / "world.jsonl"
    log.write_text("")
    assert "line 1: can't be read" in refused_in_a_line("robot", "replay", tmp_path, "--out", out)
    log.write_text((plain / "world.jsonl").read_text().splitlines(keepends=True)[0])
    assert "has no step; run the" in refused_in_a_line("robot", "replay", tmp_path, "--out", out)
    log.write_text("[" * 100_000 + "\n")
    assert "line 1: can't be read" in refused_in_a_line("robot", "replay", tmp_path, "--out", out)


def test_one_field_is_drawn_and_nothing_else_is_asked(plain, tmp_path):
    words = ("robot", "replay", plain, "--out", tmp_path / "run.gif")
    assert "leave out --json" in refused_in_a_line(*words, "--json")
    assert "name one folder" in refused_in_a_line(*words, plain)
