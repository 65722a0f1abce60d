"""Ctrl-C at any moment: one line, status 130, and what was finished is kept."""

from __future__ import annotations

import os
import random
import re
import signal
import subprocess
import sys
import time
from threading import Timer

import pytest
from commands import python
from stores import counts

from feasibee.simulation.schedule import CHUNK_WORK, FIRST_WORK, LEAST_SECONDS, chunk_work, next_budget

pytestmark = pytest.mark.skipif(os.name == "nt", reason="no signals to send")
PROGRAM = """
import signal
from feasibee.cli import interrupts, main

def begin(begin=interrupts.begin):
    begin()
    print("ready", flush=True)

interrupts.begin = begin
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored in the background
main(prog_name="feasibee")
"""
STUDY = """
runs = 1_000_000
seed = 5
[scenario]
run.steps = 300
[sweep]
"tasks.count" = [2, 20]
"decision.strategy" = ["dmmd", "census"]
"""
LONG = """
runs = 2
[scenario]
run.steps = 50_000_000
[sweep]
"tasks.count" = [2]
"""


def start(folder, *arguments, study=STUDY):
    """Start a command in a session of its own, as a terminal does; return when its main begins."""
    folder.mkdir(exist_ok=True)
    (folder / "study.toml").write_text(study)
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *map(str, arguments)],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    alarm = Timer(240, process.kill)
    alarm.start()
    assert process.stdout.readline() == "ready\n"
    alarm.cancel()
    return process


def interrupt(process):
    """Send Ctrl-C to all of its processes, as a terminal does."""
    os.killpg(process.pid, signal.SIGINT)


def end(process):
    """See that it ends in a line, perhaps after answers so far; return that."""
    alarm = Timer(240, process.kill)
    alarm.start()
    output, errors = process.communicate()
    alarm.cancel()
    assert (process.returncode, output) == (130, ""), errors
    *answers, line = errors.splitlines()
    assert all(each.startswith("feasibee: ") and re.search("so far|runs of each", each) for each in answers)
    assert line.startswith("feasibee: interrupted; ")
    return line


def until(condition, seconds=240.0):
    limit = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < limit
        time.sleep(0.02)


def kept(folder):
    return sum(counts(folder)) if list(folder.glob("runs/*.json")) else 0


@pytest.mark.slow
def test_interrupts_are_clean_at_any_moment(tmp_path):
    """At the start, and at moments drawn at random; of what was computed, nothing is lost."""
    chance = random.Random(11)
    for number, moment in enumerate([0.0, *(chance.uniform(0, 3) for _ in range(3))]):
        process = start(tmp_path / str(number), "sweep", "study.toml", "--workers", 2)
        time.sleep(moment)
        interrupt(process)
        found = re.search(r"(\d+) runs kept; the same command goes on$", end(process))
        if found:
            assert kept(tmp_path / str(number) / "results") == int(found[1])


def last_line(path):
    """Return the last line of a log; before there is any, one that tells of no runs."""
    lines = path.read_text().splitlines() if path.exists() else []
    return lines[-1] if lines else '"runs_new": 0'


@pytest.mark.slow
def test_a_second_interrupt_ends_at_once(tmp_path):
    """The run that is computed would take minutes."""
    process = start(tmp_path, "sweep", "study.toml", "--workers", 1, "--log", "log", study=LONG)
    until(lambda: (tmp_path / "log").exists() and len((tmp_path / "log").read_text().splitlines()) > 1)
    interrupt(process)
    until(lambda: '"stopping": true' in last_line(tmp_path / "log"))
    assert process.poll() is None
    begin = time.monotonic()
    interrupt(process)
    assert end(process) == "feasibee: interrupted; the runs so far are kept; the same command goes on"
    assert time.monotonic() - begin < 60  # on a busy machine
    assert kept(tmp_path / "results") == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments",
    [
        ("compare", "--strategies", "dmmd,voter", "--runs", 1_000_000),
        ("run", "--runs", 200_000, "--out", "runs.nc", "--out", "runs.png", "--workers", 1),
        ("run", "--json", "--runs", 2, "--steps", 100_000_000),
    ],
)
def test_other_commands_end_in_a_line(tmp_path, arguments):
    kept = r"no file was left half-written|(the|\d+) runs .*kept; the same command goes on"
    for moment in (0.0, 2.0):
        process = start(tmp_path, *arguments)
        time.sleep(moment)
        interrupt(process)
        assert re.fullmatch(f"feasibee: interrupted; ({kept})", end(process))
    assert {path.suffix for path in tmp_path.rglob("*") if path.is_file()} <= {".toml", ".json", ".npz"}


LOST = {
    "as an object is freed": """
class Freed:
    def __del__(self):
        interrupt()
Freed()
""",
    "in a module that goes on without it": """
with suppress(KeyboardInterrupt):
    interrupt()
with interrupts.leaving(interrupts.UNHARMED):
    print("simulated")
""",
    "in C that shows it and goes on": """
try:
    interrupt()
except KeyboardInterrupt:
    sys.excepthook(*sys.exc_info())
""",
}
"""Programs that lose Ctrl-C, by where it comes."""


@pytest.mark.parametrize("where", LOST)
def test_an_interrupt_isnt_lost(where):
    code = f"""
import os, signal, sys
from contextlib import suppress
import click
from feasibee.cli import interrupts, main

def interrupt():
    os.kill(os.getpid(), signal.SIGINT)
    for _ in range(1000):
        pass

def invoke(*arguments):
    exec({LOST[where]!r}, globals())
    print("went on")

click.Group.invoke = invoke
signal.signal(signal.SIGINT, signal.default_int_handler)
main(prog_name="feasibee")
"""
    told = python("-c", code, "show", "truth")
    assert (told.returncode, told.stdout) == (130, "")
    assert told.stderr == "feasibee: interrupted; no file was left half-written\n"


IMPORTED = """
import os, runpy, signal, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == wanted and "feasibee.cli.interrupts" in sys.modules:
            os.kill(os.getpid(), signal.SIGINT)

wanted = sys.argv.pop(1)
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Finder())
runpy.run_module("feasibee", run_name="__main__", alter_sys=True)
"""
"""Runs a command that gets Ctrl-C when it imports a module."""


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    "module",
    [
        *("feasibee.cli.commands", "feasibee.cli.run", "feasibee.scenario.scenario", "click.core", "numpy"),
        *("pydantic_core", "feasibee.engine.library", "rich.progress"),
    ],
)
def test_an_interrupt_while_a_module_is_imported_ends_in_a_line(module):
    told = python("-c", IMPORTED, module, "run", "--runs", "2", "--steps", "2")
    line = "feasibee: interrupted; no file was left half-written\n"
    assert (told.returncode, told.stderr) == (130, line)


@pytest.mark.parametrize(("name", "status"), [("SIGTERM", 143), ("SIGHUP", 129)])
def test_other_signals_end_a_command_in_a_line_and_remove_what_is_half_written(name, status, tmp_path):
    code = f"""
import os, signal
import click
from feasibee.cli import main
from feasibee.base.files import atomic_write

def invoke(*arguments):
    with atomic_write("out.csv"):
        os.kill(os.getpid(), signal.{name})
    print("went on")

click.Group.invoke = invoke
main(prog_name="feasibee")
"""
    told = python("-c", code, "show", "truth", cwd=tmp_path)
    line = f"feasibee: ended by {name}; no file was left half-written\n"
    assert (told.returncode, told.stdout, told.stderr) == (status, "", line)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_who_ignores_interrupts_goes_on():
    """As a command in the background of a shell."""
    process = subprocess.Popen(
        ["sh", "-c", f'trap "" INT; exec "{sys.executable}" -m feasibee run --runs 2000'],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    for _ in range(20):
        time.sleep(0.1)
        if process.poll() is None:
            interrupt(process)
    _, errors = process.communicate(timeout=240)
    assert (process.returncode, errors) == (0, "")


# --- Chunks of about a second ---


@pytest.mark.parametrize("speed", [1e6, 4e7, 1e9])
def test_the_first_commit_is_soon_on_any_machine_and_chunks_grow_to_a_second(speed):
    """40 million robot-steps a second are usual; one chunk, in which the machine slept, takes hours."""
    budget, works = FIRST_WORK, []
    for number in range(20):
        works.append(chunk_work(budget, 10**12, 4))
        budget = next_budget(budget, int(works[-1]), 30_000 if number == 9 else works[-1] / speed)
    assert works[0] / speed <= 1
    assert [works[8], works[-1]] == pytest.approx([min(CHUNK_WORK, speed)] * 2, rel=0.01)


def test_the_last_chunks_shrink_so_that_all_workers_end_together():
    left = [10**9, 200_000_000, 40_000_000, 1_000_000]
    works = [chunk_work(30_000_000, each, 4) for each in left]
    assert works == [30_000_000, 25_000_000, 5_000_000, 30_000_000 * LEAST_SECONDS]
    assert chunk_work(10**12, 10**12, 4) == CHUNK_WORK
