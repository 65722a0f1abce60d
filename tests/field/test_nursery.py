"""Robots are forked from a process with one thread and the standard library only, as forks need on macOS."""

from __future__ import annotations

import json
import subprocess
import sys

STRATEGY = (
    "def quality(robots_seen, tasks_seen):\n    return 0.6\n"
    "def dissemination(quality, gain):\n    return gain * quality\n"
    "def decide(mind, inbox):\n    return 1 if inbox.chance < 0.5 else 0\n"
)
LOOK = """
import json, sys, threading
before = set(sys.modules)
import feasibee.field.robot
from feasibee.scenario.plugins import load
load(sys.argv[1])
loaded = {name.partition(".")[0] for name in set(sys.modules) - before}
print(json.dumps([threading.active_count(), sorted(loaded - sys.stdlib_module_names)]))
"""


def test_what_is_forked_has_one_thread_and_no_package_but_this_one(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(STRATEGY)
    done = subprocess.run([sys.executable, "-c", LOOK, path], capture_output=True, text=True, check=True)
    threads, packages = json.loads(done.stdout)
    assert threads == 1
    assert [each for each in packages if not each.startswith("feasibee")] == []
