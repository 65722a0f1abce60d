"""A strategy of one's own on the command line: begun from a skeleton, translated to C, and checked."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from commands import invoke, json_of, output_of, refused_in_a_line

from feasibee import FeasibeeError, Scenario
from feasibee.field.brain import CompiledMind
from feasibee.robot.firmware import header, needs_double
from feasibee.robot.wire import WireError
from feasibee.scenario.html import render
from feasibee.scenario.plugins import load
from feasibee.studies import check

KINDS = pytest.mark.parametrize("options", [(), ("--knowledge",)], ids=["opinions", "knowledge"])
BAD = "def decide(mind, inbox):\n    return [1][0]\n"


PROGRAM = """
#include "feasibee.h"

int main(void)
{
    static struct feasibee_robot robot;
    struct feasibee_setting setting = {.parameters = feasibee_mine_parameters};
    struct feasibee_settings settings = feasibee_defaults(&feasibee_mine);
    struct feasibee_votes votes = {.feasible = 1};
    settings.setting = &setting;
    robot.settings = &settings;
    int decided = settings.strategy->decide(&robot, &votes);
    return settings.inbox_size != 32 || !feasibee_mine_name[7] || decided != WANTED;
}
"""


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


def test_a_skeleton_passes_on_names_as_the_example_does():
    """Both also have bits, which differ: messages of the example are as long as those of census."""
    example = (Path(__file__).parents[2] / "examples" / "strategies" / "roll_call.py").read_text(
        encoding="utf-8"
    )
    texts = example, render("strategy.txt", file="mine.py", knowledge=True)
    assert len({text[text.index("def words") : text.index("def bits")] for text in texts}) == 1


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
    own = (here / "mine.py").read_text().replace('"lead": 0.0', '"lead": 1.5')  # more than one vote
    (here / "mine.py").write_text(own)
    text = output_of("header", "mine.py", "--inbox", 32)
    assert text == header(load("mine.py"), 32)
    if shutil.which("cc") is None:
        pytest.skip("no cc; Debian has it in gcc")
    (here / "feasibee.h").write_text(text)
    (here / "main.c").write_text(PROGRAM)
    flags = ["-std=c99", "-Wall", "-Werror", "-DFEASIBEE_WORDS=40", f"-DWANTED={len(options)}"]
    subprocess.run(["cc", *flags, "main.c", "-o", "main", "-lm"], check=True)
    subprocess.run([here / "main"], check=True)


def test_several_strategies_may_be_named_in_both_ways(here):
    output_of("new", "strategy", "mine.py")
    text = output_of("header", "dmmd", "mine.py", "--strategy", "dc")
    assert "Strategies: dmmd, mine.py, dc." in text
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


# --- Checked ---

NEEDS_CC = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler: Debian's package gcc")
QUIET = (Path(__file__).parents[2] / "examples" / "strategies" / "quiet_census.py").read_text()


@NEEDS_CC
def test_a_check_says_all_of_a_strategy_in_one_screen(here):
    (here / "mine.py").write_text(QUIET)
    lines = output_of("check", "mine.py", "--runs", 20, "--seed", 1).splitlines()
    assert lines[:6] == [
        "Needs     the number of robots.",
        "Messages  1 to 661 bits.",
        "Memory    20 words known, 20 in a message, 2 floats.",
        "Engine    equal to Python in 6 random worlds.",
        "C         equal to Python in 6 random worlds.",
        "          needs FEASIBEE_DOUBLE.",
    ]
    assert "x86-64: " in lines[6]
    assert len(lines) <= 20
    row = next(line for line in lines if line.strip().startswith("20 (1.00)")).split()
    assert row[2] == "100.0"


@NEEDS_CC
def test_json_has_all_of_it(here):
    (here / "mine.py").write_text(render("strategy.txt", file="mine.py", knowledge=True))
    found = json_of("check", "mine.py", "--runs", 5)
    assert (found["bits"], found["words"], found["needs"]) == ({"first": 40, "full": 40}, 40, [])
    assert (found["engine"], found["c"], found["in_c"], found["needs_double"]) == (
        "agree",
        "agree",
        "",
        False,
    )
    assert {(each["contender"], each["runs"]) for each in found["outcomes"]} == {
        ("mine.py", 5),
        ("dmmd", 5),
        ("census", 5),
    }
    assert [each["tasks"] for each in found["outcomes"][:6]] == [10, 16, 20, 21, 25, 40]
    for flash, _ in (each for each in found["sizes"].values() if isinstance(each, list)):
        assert 3000 < flash < 20_000


def unread(*_):
    raise WireError("is no frame of this strategy")


@NEEDS_CC
def test_a_brain_that_differs_is_found(here, monkeypatch):
    """Each fault is one that a wrong translation could have."""
    (here / "mine.py").write_text(render("strategy.txt", file="mine.py", knowledge=True))
    (scenario, *_) = check._worlds("mine.py", 0)
    check._same_in_c(scenario, 0)
    with monkeypatch.context() as patch:
        patch.setattr(CompiledMind, "hear", lambda *_: None)
        with pytest.raises(FeasibeeError, match=r"step \d+: Python sends [0-9a-f]+, and C [0-9a-f]+"):
            check._same_in_c(scenario, 0)
    with monkeypatch.context() as patch:
        patch.setattr(CompiledMind, "decode", unread)
        with pytest.raises(FeasibeeError, match="which Python sends, isn't read: it is no frame"):
            check._same_in_c(scenario, 0)
    text = header(load("mine.py")).replace("part >= ", "part < ")
    monkeypatch.setattr("feasibee.robot.firmware.header", lambda *_: text)
    with pytest.raises(FeasibeeError, match=r"step \d+: opinion, .* in Python, and \(\d, .* in C"):
        check._same_in_c(scenario, 0)


def test_an_engine_that_differs_is_found(here, monkeypatch):
    (here / "mine.py").write_text(render("strategy.txt", file="mine.py", knowledge=False))
    assert check._agreement("mine.py", 0, check._same_in_engine) == "agree"
    simulate = check.simulate_record

    def other(scenario, runs, *, backend, **options):
        record = simulate(scenario, runs, backend=backend, **options)
        record.feasible_count[0, 3] += backend == "engine"
        return record

    monkeypatch.setattr(check, "simulate_record", other)
    found = check._agreement("mine.py", 0, check._same_in_engine)
    assert found.startswith("world 0 (")
    assert "feasible_count differs between engine and Python" in found


OVERFLOWS = "def decide(mind, inbox):\n    return 1 if (inbox.feasible_votes + 3037000000) ** 2 > 0 else 0\n"


def test_a_whole_number_that_leaves_64_bits_ends_a_check_with_status_1(here):
    (here / "mine.py").write_text(OVERFLOWS.replace("votes", "votes * 1000"))
    done = invoke("check", "mine.py", "--runs", 2)
    assert done.exit_code == 1
    assert re.fullmatch(r"feasibee: mine\.py, line 2: decide.* \d+ \*\* 2 leaves 64 bits\n", done.stderr)


@pytest.mark.parametrize("agrees", [True, False])
def test_a_difference_ends_a_check_with_status_1(here, monkeypatch, agrees):
    (here / "mine.py").write_text(render("strategy.txt", file="mine.py", knowledge=False))
    found = SimpleNamespace(agrees=agrees, to_dict=lambda seed: {"engine": "world 0"})
    monkeypatch.setattr(check, "check", lambda *_: found)
    assert invoke("check", "mine.py", "--json").exit_code == (not agrees)


def test_what_only_the_engine_takes_is_checked_without_c(here):
    (here / "mine.py").write_text("def decide(mind, inbox):\n    return round(inbox.chance)\n")
    told = "mine.py, line 2: round(...); write math.floor(number + 0.5)"
    assert refused_in_a_line("header", "mine.py") == f"feasibee: {told}"
    found = json_of("check", "mine.py", "--runs", 2)
    assert (found["engine"], found["c"], found["in_c"], found["sizes"]) == ("agree", told, told, {})


def test_a_large_strategy_does_not_fit_a_small_processor(here):
    if shutil.which("avr-gcc") is None:
        pytest.skip("no avr-gcc; Debian has it in gcc-avr and avr-libc")
    text = render("strategy.txt", file="mine.py", knowledge=True).replace(
        "+ setting.task_ids", "+ setting.task_ids + 3000", 1
    )
    (here / "mine.py").write_text(text)
    assert check._size("ATmega328P", check._paper("mine.py")) == "too large for its memory"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nothing.py", "nothing.py: can't be read: No such"),
        ("dmmd", "dmmd: is built in; name a file of your"),
    ],
)
def test_what_cannot_be_checked_is_told(here, name, words):
    assert words in refused_in_a_line("check", name)


# --- As the page says ---

PAGE = Path(__file__).parents[2] / "docs" / "strategy-robots.md"


def steps_of(heading):
    """Return a part of the page as the languages and texts of its blocks."""
    part = PAGE.read_text(encoding="utf-8").partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    return re.findall(r"^   ```(\w+)\n(.*?)^   ```$", part, re.MULTILINE | re.DOTALL)


def without_sizes(text):
    """Return lines without those on sizes in C, which depend on the compiler, and without indentation."""
    lines = [line.strip() for line in text.splitlines()]
    return [line for line in lines if line and not line.startswith(("x86-64: ", "ATmega328P: "))]


def test_a_reader_simulates_translates_and_flashes_a_strategy(here):
    """Each block of commands prints what stands below it."""
    for tool in ("cc", "avr-gcc", "simavr"):
        if shutil.which(tool) is None:
            pytest.skip(f"no {tool}; Debian has it in gcc, gcc-avr and avr-libc, or simavr")
    shutil.copy(PAGE.parents[1] / "examples" / "strategies" / "witness.py", "mine.py")
    (here / "feasibee").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m feasibee "$@"\n')
    (here / "feasibee").chmod(0o755)
    environment = {**os.environ, "PATH": f"{here}:{os.environ['PATH']}", "COLUMNS": "84", "NO_COLOR": "1"}
    ran, printed = 0, ""
    for language, text in steps_of("A strategy on a real robot, in C"):
        if language == "c":
            (here / "robot.c").write_text(re.sub(r"(?m)^   ", "", text))
        elif language == "sh":
            command = ["sh", "-c", text]
            done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
            printed = re.sub(r"\x1b\[\d*m", "", done.stdout + done.stderr * ("simavr" in text))
        else:
            assert set(without_sizes(text)) <= set(without_sizes(printed)), printed
            ran += 1
    assert ran == 3
