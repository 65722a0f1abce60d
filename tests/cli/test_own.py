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
from feasibee.scenario.plugins import load
from feasibee.scenario.shown import render
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
    assert "feasibee check mine.py" in output_of("new", "mine.py", *options)
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


def test_a_new_file_overwrites_nothing_and_is_of_a_known_kind(here):
    (here / "mine.py").write_text("x")
    for arguments, words in {
        ("mine.py",): "mine.py: exists already; use another name, or remove it",
        ("mine.txt",): "mine.txt: unknown file format; end the name with .toml or .py",
        ("other.py", "--set", "tasks.count=3"): "leave out --set",
        ("mine.toml", "--knowledge"): "leave out --knowledge",
        ("strategy", "mine.py"): "unexpected extra argument (mine.py). See 'main new --help'.",
        ("mine.toml", "--set"): "Option '--set' requires an argument. See 'main new --help'.",
    }.items():
        assert words in refused_in_a_line("new", *arguments)
    assert [(each.name, each.read_text()) for each in here.iterdir()] == [("mine.py", "x")]
    output_of("new", "mine.toml", "--set", "tasks.count=7")
    assert Scenario.read("mine.toml").tasks.count == 7


# --- In C ---


@KINDS
def test_a_file_is_translated_to_a_header_that_compiles(here, options):
    output_of("new", "mine.py", *options)
    own = (here / "mine.py").read_text().replace('"lead": 0.0', '"lead": 1.5')  # more than one vote
    (here / "mine.py").write_text(own)
    text = output_of("robot", "header", "mine.py", "--inbox", 32)
    assert text == header(load("mine.py"), 32)
    if shutil.which("cc") is None:
        pytest.skip("no cc; Debian has it in gcc")
    (here / "feasibee.h").write_text(text)
    (here / "main.c").write_text(PROGRAM)
    flags = ["-std=c99", "-Wall", "-Werror", "-DFEASIBEE_WORDS=40", f"-DWANTED={len(options)}"]
    subprocess.run(["cc", *flags, "main.c", "-o", "main", "-lm"], check=True)
    subprocess.run([here / "main"], check=True)


def test_several_strategies_may_be_named_in_both_ways(here):
    output_of("new", "mine.py")
    text = output_of("robot", "header", "dmmd", "mine.py", "dc")
    assert "Strategies: dmmd, mine.py, dc." in text
    assert output_of("robot", "header", "dmmd") == header("dmmd")


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
    assert words in refused_in_a_line("robot", "header", "dmmd", name)


# --- Checked ---

NEEDS_CC = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler: Debian's package gcc")
QUIET = (Path(__file__).parents[2] / "examples" / "strategies" / "quiet_census.py").read_text()


@NEEDS_CC
def test_a_check_says_all_of_a_strategy_in_one_screen_and_in_json(here, monkeypatch):
    """Catches what parts of a check do not: an answer left out, or one that stands in one form only."""
    (here / "mine.py").write_text(QUIET)
    real, kept = check.check, []
    monkeypatch.setattr(
        check, "check", lambda *given: kept[0] if kept else kept.append(real(*given)) or kept[0]
    )
    words = ("check", "mine.py", "--runs", 20, "--seed", 1)
    lines = output_of(*words).splitlines()
    assert lines[0] == "The engine, Python and C agree, in 6 random worlds."
    assert lines[1].startswith("mine.py is right in 100 % of the runs (97 to 100), dmmd in ")
    assert "It needs the number of robots; a message has 1 to 661 bits." in lines
    more = output_of(*words, "--details").splitlines()
    assert more[: len(lines)] == lines
    assert more[len(lines) : len(lines) + 4] == [
        "Memory    20 words known, 20 in a message, 2 floats.",
        "Engine    equal to Python in 6 random worlds.",
        "C         equal to Python in 6 random worlds.",
        "          needs FEASIBEE_DOUBLE.",
    ]
    assert "x86-64: " in more[len(lines) + 4]
    assert len(more) <= 22
    row = next(line for line in lines if line.strip().startswith("20 (1.00)")).split()
    assert row[2] == "100.0"
    found = json_of(*words)
    assert (found["bits"], found["words"], found["needs"]) == ({"first": 1, "full": 661}, 20, ["count"])
    assert [found[key] for key in ("engine", "c", "in_c", "needs_double")] == ["agree", "agree", "", True]
    assert {each["contender"] for each in found["outcomes"]} == {"mine.py", "dmmd", "census"}
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


OVERFLOWS = BAD.replace("[1][0]", "1 if (inbox.feasible_votes * 1000 + 3037000000) ** 2 > 0 else 0")


@pytest.mark.parametrize("agrees", [True, False])
def test_a_difference_or_a_failure_ends_a_check_with_status_1(here, monkeypatch, agrees):
    (here / "mine.py").write_text(OVERFLOWS)
    done = invoke("check", "mine.py", "--runs", 2)
    assert done.exit_code == 1
    assert re.fullmatch(r"feasibee: mine\.py, line 2: decide.* \d+ \*\* 2 leaves 64 bits\n", done.stderr)
    (here / "mine.py").write_text(BAD.replace("[1][0]", "1"))
    found = SimpleNamespace(agrees=agrees, to_dict=lambda seed: {"engine": "world 0"})
    monkeypatch.setattr(check, "check", lambda *_: found)
    assert invoke("check", "mine.py", "--json").exit_code == (not agrees)


def test_what_only_the_engine_takes_is_checked_without_c(here):
    (here / "mine.py").write_text("def decide(mind, inbox):\n    return round(inbox.chance)\n")
    told = "mine.py, line 2: round(...); write math.floor(number + 0.5)"
    assert refused_in_a_line("robot", "header", "mine.py") == f"feasibee: {told}"
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


def test_what_cannot_be_checked_or_translated_is_told_with_its_path(here):
    missing = "nothing.py: can't be read: No such file or directory; name a file of Python"
    assert missing in refused_in_a_line("check", "nothing.py")
    assert refused_in_a_line("robot", "header", "nothing.py") == f"feasibee: {missing}"
    assert "must be one of dmmd" in refused_in_a_line("robot", "header", "mine")
    assert "dmmd: is built in; name a file of your" in refused_in_a_line("check", "dmmd")


# --- As the page says ---

PAGE = Path(__file__).parents[2] / "docs" / "add-a-strategy.md"


def steps_of(heading):
    """Return a part of the page as the languages and texts of its blocks."""
    part = PAGE.read_text(encoding="utf-8").partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    return re.findall(r"^   ```(\w+)\n(.*?)^   ```$", part, re.MULTILINE | re.DOTALL)


def without_sizes(text):
    """Return lines without those on sizes in C, which depend on the compiler, and without indentation."""
    lines = [line.strip() for line in text.splitlines()]
    return [line for line in lines if line and not line.startswith(("x86-64: ", "ATmega328P: "))]


@pytest.mark.slow
def test_a_reader_simulates_translates_and_flashes_a_strategy(here):
    """Each block of commands prints what stands below it: nothing else runs those of that page."""
    for tool in ("cc", "avr-gcc", "simavr"):
        if shutil.which(tool) is None:
            pytest.skip(f"no {tool}; Debian has it in gcc, gcc-avr and avr-libc, or simavr")
    shutil.copy(PAGE.parents[1] / "examples" / "strategies" / "witness.py", "mine.py")
    shutil.copy(PAGE.parents[1] / "examples" / "robot.c", "robot.c")
    (here / "feasibee").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m feasibee "$@"\n')
    (here / "feasibee").chmod(0o755)
    environment = {**os.environ, "PATH": f"{here}:{os.environ['PATH']}", "COLUMNS": "84", "NO_COLOR": "1"}
    ran, printed = 0, ""
    for language, text in steps_of("A strategy on a real robot, in C"):
        if language == "sh":
            command = ["sh", "-c", text]
            done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
            printed = re.sub(r"\x1b\[\d*m", "", done.stdout + done.stderr * ("simavr" in text))
        else:
            assert set(without_sizes(text)) <= set(without_sizes(printed)), printed
            ran += 1
    assert ran == 3
