"""Whatever comes in, from a command line, a file or Python: lines that say what is wrong, no traceback."""

from __future__ import annotations

import resource
import subprocess
import sys
import time

import pytest
from click.testing import CliRunner
from hostile import calls, commands, contents, places

from feasibee import FeasibeeError, Scenario
from feasibee.cli import main
from feasibee.simulation.plan import Study

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no pipes, devices and limits of memory")

COMMANDS = dict(commands.cases())
STUDIES = dict(contents.studies())
CALLS = dict(calls.cases())
LONGEST = 10_000
"""Bytes of what is said of one input."""
SECONDS = 60
ROOM = 300 * 2**20
"""Bytes of memory that a command may take to refuse something."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with traps, a study and its results."""
    here = tmp_path_factory.mktemp("hostile")
    places.prepare(here)
    made = CliRunner().invoke(main, ["sweep", str(here / "study.toml"), "--out", str(here / "results")])
    assert made.exit_code == 0, made.output
    calls.swarm()
    return here


@pytest.fixture
def here(folder, monkeypatch):
    """The folder with traps; no work may begin there, and nothing may be left behind."""

    def began(*arguments, **options):
        pytest.fail("the work began")

    monkeypatch.chdir(folder)
    for name in ("engine.runner.simulate", "engine.state.State", "live.serve.Server"):
        monkeypatch.setattr(f"feasibee.{name}", began)
    before = {path.name for path in folder.iterdir()}
    yield folder
    assert {path.name for path in folder.iterdir()} - before <= {"hostile.toml", "hostile.csv"}


def groups(cases):
    """Return names of groups, and the names of the cases in each: a test for each case would take longer."""
    found = {}
    for name in cases:
        found.setdefault(name.partition(": ")[0], []).append(name)
    return found


def in_each(names, check_one):
    """Check one input after the other, and tell all that fail."""
    failures = []
    for name in names:
        before = time.monotonic()
        try:
            check_one(name)
            assert time.monotonic() - before < SECONDS
        except (Exception, pytest.fail.Exception) as error:
            failures.append(f"{name}: {type(error).__name__}: {error}"[:2000])
    assert not failures, "\n".join(failures)


def check_said(said):
    """Check the lines that are said of an input, each a problem of its own."""
    assert said.endswith("\n")
    lines = said[:-1].split("\n")
    assert all(line.startswith("feasibee: ") and line.isprintable() for line in lines), lines
    assert len(set(lines)) == len(lines)
    assert len(lines) <= 21
    assert len(said.encode()) <= LONGEST


def check_command(*arguments):
    """Check that a command is refused: exit status 2, nothing on standard output, lines of errors."""
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 2, (result.output, result.exception)
    assert result.stdout == ""
    check_said(result.stderr)


def check_read(read):
    """Check that the library refuses a file in the words of a command."""
    with pytest.raises(FeasibeeError) as caught:
        read("hostile.toml")
    check_said("".join(f"feasibee: {line}\n" for line in str(caught.value).split("\n")))


def write(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())


@pytest.mark.quick(4)
@pytest.mark.parametrize(("name", "names"), groups(COMMANDS).items())
def test_a_command_is_refused(here, name, names):
    in_each(names, lambda each: check_command(*COMMANDS[each]))


@pytest.mark.parametrize("name", contents.BY_HAND)
def test_a_scenario_is_refused(here, name):
    """Wrong values of single fields are in tests/scenario; the commands below read scenarios, too."""
    write(here / "hostile.toml", contents.BY_HAND[name])
    check_read(Scenario.read)


@pytest.mark.quick(5)
@pytest.mark.parametrize(("name", "names"), groups(STUDIES).items())
def test_a_study_is_refused(here, name, names):
    def check_one(each):
        write(here / "hostile.toml", STUDIES[each])
        check_read(Study.read)

    in_each(names, check_one)


@pytest.mark.parametrize("name", contents.TABLES)
def test_a_design_is_refused(here, name):
    write(here / "hostile.csv", contents.TABLES[name])
    write(here / "hostile.toml", 'design = "hostile.csv"\n')
    check_command("sweep", "hostile.toml")


@pytest.mark.parametrize("name", contents.POINTS)
def test_a_file_of_points_is_refused(here, name):
    write(here / "hostile.csv", contents.POINTS[name])
    check_command("show", "truth", "--set", "tasks.placement=points", "--set", "tasks.points=hostile.csv")


@pytest.mark.parametrize(("name", "names"), groups(CALLS).items())
def test_a_call_is_refused_with_sense(here, name, names):
    """With an error of feasibee, or one of Python about a type or a value."""

    def check_one(each):
        with pytest.raises((FeasibeeError, TypeError, ValueError)) as caught:
            CALLS[each]()
        assert isinstance(caught.value, FeasibeeError) or caught.type in (TypeError, ValueError)
        assert 0 < len(str(caught.value)) <= LONGEST

    in_each(names, check_one)


MEASURED = """
import re, sys
from pathlib import Path
from feasibee.cli import main
try:
    main(prog_name="feasibee")
finally:
    found = re.search(r"VmHWM:\\s+(\\d+) kB", Path("/proc/self/status").read_text())
    print(1024 * int(found[1]), file=sys.__stdout__)
"""
"""A command that says how many bytes it has taken at most."""

GREEDY = {
    "a terabyte": ["sweep", "sparse"],
    "60,000 keys": ["show", "truth", "keys.toml"],
    "a key of 500,000 parts": ["show", "truth", "parts.toml"],
    "20,000 wrong rows": ["sweep", "rows.toml"],
    "32 MB of words for points": ["show", "truth", "--set", "tasks.points=words.csv"],
    "a cluster without certificates": ["sweep", "study.toml", "--dask", "tls://127.0.0.1:1"],
}
"""What took gigabytes, or never ended, or leaves Dask's threads behind: in processes of their own."""


@pytest.mark.quick(3)
@pytest.mark.skipif(sys.platform != "linux", reason="no /proc to look up memory")
@pytest.mark.parametrize("name", GREEDY)
def test_what_is_greedy_gets_little_memory_and_time(folder, name):
    (folder / "keys.toml").write_text(contents.BY_HAND["60,000 keys"])
    (folder / "parts.toml").write_text(contents.BY_HAND["a key of 500,000 parts"])
    (folder / "rows.toml").write_text('design = "rows.csv"\n')
    (folder / "rows.csv").write_text(contents.TABLES["20,000 wrong rows"])
    (folder / "words.csv").write_text("nothing,but,words\n" * (2**25 // 18))
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, *GREEDY[name]],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (8 * ROOM, 8 * ROOM)),
    )
    assert done.returncode == 2, done.stderr[-2000:]
    check_said(done.stderr)
    assert 0 < int(done.stdout) < ROOM
