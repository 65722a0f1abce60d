"""A field's processes and temporary folders end with it, however it ends; a folder has one field."""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from commands import WITHOUT_BYTECODE, invoke, refused_in_a_line

from feasibee.base.errors import FeasibeeError
from feasibee.field.logs import LineLog

pytestmark = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
SLOW = pytest.mark.slow  # a second each, as the two before them
LONG = ("--hz", "100", "--set", "run.steps=100000", "--set", "robots.count=3", "--patience", "600")
"""A field that lasts a quarter of an hour, whose robots would wait ten minutes for a world that is silent."""
PATIENCE = 60
"""Seconds that a field has to begin and to end; the machine may be busy with other tests."""


class Running:
    """A field in a session of its own, with its temporary folder."""

    def __init__(self, folder, *options):
        folder.mkdir()
        self.folder = folder
        self.process = subprocess.Popen(
            [sys.executable, "-m", "feasibee", "robot", "launch", *LONG, *options],
            env={**os.environ, "TMPDIR": str(folder)},
            cwd=folder,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def wait_for(self, text):
        """Wait for a line on standard error."""
        assert any(text in line for line in self.process.stderr)
        return self

    def others(self):
        """Return its other processes that haven't ended, world and robots."""
        found = []
        for path in Path("/proc").glob("[0-9]*/stat"):
            try:
                number, rest = path.read_text().split(" ", 1)
            except OSError:
                continue
            state, _, _, session = rest.rpartition(")")[2].split()[:4]
            if int(session) == self.process.pid != int(number) and state not in "ZX":
                found.append(int(number))
        return found

    def robots(self):
        """Return the numbers of the processes of its robots."""
        commands = {number: Path(f"/proc/{number}/cmdline").read_bytes() for number in self.others()}
        return [number for number, command in commands.items() if b"field.robot" in command]

    def sees_all_end(self):
        """Wait until all processes have ended; return whether they do, and leave nothing temporary."""
        limit = time.monotonic() + PATIENCE
        while (self.others() or any(self.folder.iterdir())) and time.monotonic() < limit:
            time.sleep(0.05)
        return not self.others() and list(self.folder.iterdir()) == []

    def end(self):
        """Kill what is left after a test that fails."""
        for number in [self.process.pid, *self.others()]:
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                continue
        self.process.communicate()


@pytest.fixture
def start(tmp_path):
    fields = []

    def begin(*options):
        fields.append(Running(tmp_path / str(len(fields)), *options))
        return fields[-1]

    yield begin
    for field in fields:
        field.end()


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "name", ["SIGKILL", "SIGTERM", *(pytest.param(n, marks=SLOW) for n in ("SIGHUP", "SIGINT"))]
)
def test_all_processes_and_temporary_folders_end_with_the_field(start, name):
    """One robot is stopped: it can't notice anything by itself."""
    field = start("--pause", "1@2").wait_for("is stopped")
    assert len(field.others()) == 4
    assert len(list(field.folder.iterdir())) == 1
    number = getattr(signal, name)
    os.kill(field.process.pid, number)
    status = field.process.wait(PATIENCE)
    assert status == (-number if name == "SIGKILL" else 128 + number)
    assert field.sees_all_end()
    assert "Traceback" not in field.process.stderr.read()


def test_a_field_that_is_killed_before_its_robots_join_leaves_nothing(start):
    field = start("--no-robots").wait_for("The world is at")
    field.process.kill()
    field.process.wait()
    assert field.sees_all_end()


def test_a_field_whose_world_is_killed_ends_with_an_error(start):
    field = start("--pause", "1@2").wait_for("is stopped")
    (world,) = set(field.others()) - set(field.robots())
    os.kill(world, signal.SIGKILL)
    assert field.process.wait(PATIENCE) == 2
    assert field.sees_all_end()
    (line,) = [line for line in field.process.stderr.read().splitlines() if line.startswith("feasibee:")]
    assert line == "feasibee: the world's process ended without a result; run the field again"


def test_a_robot_that_dies_is_named_at_once_and_one_that_crashes_with_the_signal(start):
    """Its robots may be silent for ten minutes, so only their ends can say it."""
    field = start().wait_for("have joined")
    killed, crashed = sorted(field.robots())[:2]
    os.kill(killed, signal.SIGKILL)
    field.wait_for("has ended; it doesn't count")
    os.kill(crashed, signal.SIGSEGV)
    field.wait_for(": ended by SIGSEGV")
    field.process.terminate()
    assert field.process.wait(PATIENCE) == 128 + signal.SIGTERM
    assert field.sees_all_end()


def test_a_second_field_in_a_folder_is_refused_and_names_the_process(start, tmp_path):
    out = tmp_path / "logs"
    field = start("--out", out).wait_for("have joined")
    line = refused_in_a_line("robot", "launch", "--lockstep", "--set", "run.steps=1", "--out", out)
    assert line == (
        f"feasibee: {out}: process {field.process.pid} writes here; wait for it, or choose another folder"
    )
    field.process.kill()
    field.process.wait()
    assert field.sees_all_end()
    assert invoke("robot", "launch", "--lockstep", "--set", "run.steps=1", "--out", out).exit_code == 0
    assert invoke("robot", "replay", out).exit_code == 0


# --- A full disk ---

FULL = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)), resource.RLIM_INFINITY))
from feasibee.cli import main
main(prog_name="feasibee")
"""


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("size", "told"),
    [
        (0, "logs: can't be locked: .*; choose a folder that you may write to, with some free space"),
        (
            5_000,
            r"logs/world\.jsonl: can't be written: File too large; free some disk space, and run it again",
        ),
    ],
)
def test_a_full_disk_ends_a_field_with_one_line(tmp_path, size, told):
    """No file may grow beyond a size here. The lines of the logs are whole."""
    options = "robot launch --lockstep --set robots.count=3 --set run.steps=50 --out logs"
    ended = subprocess.run(
        [sys.executable, "-c", FULL, str(size), *options.split()],
        cwd=tmp_path,
        env=WITHOUT_BYTECODE,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert (ended.returncode, ended.stdout) == (2, "")
    (line,) = [line for line in ended.stderr.splitlines() if line.startswith("feasibee")]
    assert re.fullmatch(f"feasibee: {told}", line)
    assert all(path.read_bytes()[-1:] in (b"", b"\n") for path in (tmp_path / "logs").glob("*.jsonl"))


def test_a_robot_whose_log_cant_be_written_ends_its_field_with_one_line(tmp_path):
    (tmp_path / "robot-1.jsonl").mkdir()
    line = refused_in_a_line(
        "robot", "launch", "--lockstep", "--json", "--set", "run.steps=1", "--out", tmp_path
    )
    assert "robot 1: " in line
    assert "robot-1.jsonl: can't be written: Is a directory; name a file in a folder that you may" in line


def test_a_log_on_a_full_disk_keeps_its_whole_lines(tmp_path):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    log = LineLog(tmp_path / "log.jsonl")
    log.write({"a": 1})
    resource.setrlimit(resource.RLIMIT_FSIZE, (20, before[1]))
    try:
        with pytest.raises(FeasibeeError, match=r"log.jsonl: can't be written: .*; free some disk space"):
            log.write({"b": "c" * 100})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        log.close()
    assert (tmp_path / "log.jsonl").read_text() == '{"a":1}\n'
