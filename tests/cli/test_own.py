"""A strategy of one's own on the command line: begun from a skeleton, translated to C, and checked."""

from __future__ import annotations

import shutil
import subprocess

import pytest
from commands import json_of, output_of, refused_in_a_line

from feasibee import Scenario
from feasibee.robot.firmware import header, needs_double
from feasibee.scenario.plugins import load

KINDS = pytest.mark.parametrize("options", [(), ("--knowledge",)], ids=["opinions", "knowledge"])
BAD = "def decide(mind, inbox):\n    return [1][0]\n"


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


# --- A skeleton ---


@KINDS
def test_a_skeleton_runs_as_it_is_and_with_what_its_comments_offer(here, options):
    assert "feasibee check mine.py" in output_of("new", "strategy", "mine.py", *options)
    text = (here / "mine.py").read_text()
    assert 0 <= json_of("run", "--set", "decision.strategy=mine.py", "--runs", 5)["accuracy"]["estimate"] <= 1
    assert not needs_double(load("mine.py"))
    begin = text.index("# Optional")
    offered = text[begin:].replace("\n# ", "\n").replace("\n#\n", "\n\n")
    (here / "more.py").write_text(text[:begin] + offered)
    assert load("more.py").functions > load("mine.py").functions
    assert header(load("more.py"))


def test_a_skeleton_overwrites_nothing(here):
    (here / "mine.py").write_text("x")
    line = refused_in_a_line("new", "strategy", "mine.py")
    assert line == "feasibee: mine.py: exists already; use another name, or remove it"
    assert (here / "mine.py").read_text() == "x"


def test_a_scenario_is_written_as_ever(here):
    output_of("new", "mine.toml", "--set", "tasks.count=7")
    assert Scenario.read("mine.toml").tasks.count == 7


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("strategy", "mine.toml"), "mine.toml: unknown file format; end the name with .py"),
        (
            ("strategy", "mine.py", "--set", "tasks.count=3"),
            "--set with strategy: is for fields of a scenario",
        ),
        (("mine.toml", "--knowledge"), "write feasibee new strategy mine.py"),
        (("one.toml", "two.toml"), "one.toml: can't be written with two.toml; name one file"),
    ],
)
def test_what_a_new_file_cannot_be_is_told(here, arguments, words):
    assert words in refused_in_a_line("new", *arguments)
    assert not list(here.iterdir())


# --- In C ---


@KINDS
def test_a_file_is_translated_to_a_header_that_compiles(here, options):
    output_of("new", "strategy", "mine.py", *options)
    text = output_of("header", "mine.py", "--inbox", 32)
    assert text == header(load("mine.py"), 32)
    if shutil.which("cc") is None:
        pytest.skip("no cc; Debian has it in gcc")
    (here / "feasibee.h").write_text(text)
    (here / "main.c").write_text(
        '#include "feasibee.h"\nint main(void)\n{\n    struct feasibee_settings settings = '
        "feasibee_defaults(&feasibee_mine);\n"
        "    return settings.inbox_size != 32 || !feasibee_mine_name[7];\n}\n"
    )
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-DFEASIBEE_WORDS=40"]
    subprocess.run(["cc", *flags, "main.c", "-o", "main", "-lm"], check=True)
    subprocess.run([here / "main"], check=True)


def test_several_strategies_may_be_named_in_both_ways(here):
    output_of("new", "strategy", "mine.py")
    text = output_of("header", "dmmd", "mine.py", "--strategy", "average")
    assert "Strategies: dmmd, mine.py, average." in text
    assert output_of("header", "--strategy", "dmmd") == header("dmmd") == output_of("header", "dmmd")


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("sub/mine.py", BAD, "sub/mine.py, line 2: [1]; write it with numbers, rows and calls of functions"),
        ("sub/mine.py", "", "sub/mine.py: mine.py: has no function decide; write def decide(mind, inbox)"),
        (
            "sub/message.py",
            BAD.replace("[1][0]", "1"),
            "also a function of the controller; give the file anoth",
        ),
        ("sub/dmmd.py", BAD.replace("[1][0]", "1"), "feasibee_dmmd in C is also dmmd; give the file another"),
    ],
)
def test_what_cannot_be_translated_is_told_with_its_path(here, name, text, words):
    (here / "sub").mkdir()
    (here / name).write_text(text)
    assert words in refused_in_a_line("header", "dmmd", name)


def test_a_missing_file_is_told_with_its_path(here):
    line = refused_in_a_line("header", "mine.py")
    assert line == "feasibee: mine.py: can't be read: No such file or directory; name a file of Python"
    assert "must be one of dmmd" in refused_in_a_line("header", "mine")
