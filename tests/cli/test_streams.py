"""Closed standard streams, and characters that nobody sees: no traceback, and nothing hidden is printed."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from commands import invoke, refused_in_a_line

from feasibee import Scenario
from feasibee.cli.streams import visible

unix = pytest.mark.skipif(os.name == "nt", reason="a shell that closes streams")
STRATEGY = (
    '"""Say yes."""\n'
    "def quality(robots_seen, tasks_seen):\n    return 0.6\n"
    "def dissemination(quality, gain):\n    return gain * quality\n"
    "def decide(mind, inbox):\n    return 1\n"
)
HIDDEN = ("\u202e", "\u2066", "\u200f", "\u00ad", "\u2028", "\x9b", "\U000e0041")


def run_with(closing, *arguments):
    """Run a command with streams that a shell has closed; return its status, output and errors."""
    script = f'exec "$@" {closing}'
    done = subprocess.run(
        ["sh", "-c", script, "sh", sys.executable, "-m", "feasibee", *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


@unix
def test_closed_output_is_a_reader_that_has_gone():
    assert run_with(">&-", "show", "strategies") == (1, "", "")


@unix
@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        *(("show", "schema"), ("--help",)),
        ("run", "--runs", "2", "--json"),
        ("robot", "launch", "--lockstep", "--set", "run.steps=2"),
    ],
    ids=" ".join,
)
def test_each_command_takes_closed_streams(command, tmp_path):
    """Four commands, two starts each."""
    status, output, errors = run_with(">&-", *command)
    assert (status, output) == (1, "")
    assert "Traceback" not in errors
    status, output, errors = run_with("2>&- <&-", *command)
    assert (status, errors) == (0, "")
    assert output


@unix
def test_a_file_never_takes_the_place_of_a_closed_stream(tmp_path):
    """What a library writes to standard error would go into it."""
    page = tmp_path / "a.html"
    assert run_with(">&- 2>&- <&-", "run", "--out", page)[0] == 1
    assert page.read_text().endswith("</html>\n")


@unix
def test_an_error_with_closed_streams_has_its_usual_status():
    assert run_with(">&- 2>&- <&-", "run", "missing.toml") == (2, "", "")


def test_hidden_characters_are_printed_as_toml_writes_them():
    assert visible("é\u202eb\U000e0041 ± „…“ 日本 \u3000") == "é\\u202eb\\U000e0041 ± „…“ 日本 \u3000"
    assert all(visible(each).isascii() for each in HIDDEN)


@pytest.mark.parametrize("hidden", HIDDEN[:2])
def test_hidden_characters_in_names_are_printed_as_escapes(tmp_path, hidden, monkeypatch):
    """In a file's name, a strategy's name, a key, a preset and a command."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / f"a{hidden}b.py").write_text(STRATEGY)
    (tmp_path / f"a{hidden}b.toml").write_text("tasks.count = 2\n")
    strategy = ("--set", f"decision.strategy=a{hidden}b.py")
    outputs = [
        invoke("show", "scenario", f"a{hidden}b.toml", *strategy).output,
        invoke("show", "strategies", *strategy).output,
        invoke("run", "--out", f"a{hidden}b.html").output,
        invoke("show", "truth", "--set", f"tas{hidden}.x=1").output,
        invoke("show", "truth", "--set", f"preset=a{hidden}b").output,
        invoke("show", "truth", f"missing{hidden}").output,
        invoke(f"truth{hidden}").output,
    ]
    for output in outputs:
        assert hidden not in output
        assert f"\\u{ord(hidden):04x}" in output
    (tmp_path / "again.toml").write_text(outputs[0])
    assert invoke("show", "scenario", "again.toml").output == outputs[0]


def test_the_live_page_shows_a_files_name_with_escapes():
    from feasibee.live.catalogue import Catalogue
    from feasibee.live.serve import routes_of

    text = routes_of(Catalogue(Scenario(), title="a\u202eb.toml"))["GET", "/"](b"")
    assert '"name":"a\\\\u202eb.toml"' in text


@pytest.mark.parametrize("hidden", ["\x1b[31m", "\n", "\x07"])
def test_control_characters_in_names_are_refused_and_printed_as_escapes(tmp_path, hidden, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if os.name != "nt":
        (tmp_path / f"a{hidden}b.py").write_text(STRATEGY)
    code = hidden.encode("unicode_escape").decode()
    text = json.dumps(f"a{hidden}b.py")
    lines = [
        refused_in_a_line("show", "truth", "--set", f"decision.strategy={text}"),
        refused_in_a_line("show", "truth", "--set", f"tas{hidden}k.x=1"),
        refused_in_a_line("show", "truth", "--set", f"preset=a{hidden}b"),
        refused_in_a_line("show", "truth", f"missing{hidden}.toml"),
        refused_in_a_line("run", "--out", f"a{hidden}b.html"),
    ]
    for line in lines:
        assert line.isprintable()
        assert code.removesuffix("[31m") in line
