"""Code for a processor without wide registers or special instructions gives the same bytes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

FAST = ["paper, dmmd", "many tasks, dmmd", "forty robots, dmmd", "stops, dmmd"]
GENERAL = ["bodies, dmmd", "loss, dc", "unique, dc", "unique, census"]
SCRIPT = """
import json, sys
from test_same_bytes import digest, scenarios
names = json.loads(sys.argv[1])
print(json.dumps({name: digest(each, seed) for name, seed, each in scenarios() if name in names}))
"""


@pytest.mark.slow
@pytest.mark.parametrize("names", [FAST, GENERAL])
def test_the_same_bytes_on_a_processor_with_the_least_instructions(names, tmp_path):
    """On x86 with SSE2 only, on ARM with NEON only: the oldest of both that run 64 bits."""
    least = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": "", "FEASIBEE_CACHE": str(tmp_path / "cache")}
    command = [sys.executable, "-c", SCRIPT, json.dumps(names)]
    here = Path(__file__).parent
    done = subprocess.run(
        command, env={**os.environ, **least}, cwd=here, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    kept = json.loads((here / "same_bytes.json").read_text())["hashes"]
    assert json.loads(done.stdout) == {name: kept[name] for name in names}


@pytest.mark.slow
def test_code_for_another_processor_has_a_file_of_its_own(tmp_path):
    script = tmp_path / "double.py"
    script.write_text(
        "from feasibee.engine.compile import cache_folder, entry\n"
        "def double(number):\n    return 2 * number\n"
        "entry('int64(int64)')(double)\n"
        "print(len(list(cache_folder().glob('double-*'))))\n"
    )
    kept = [
        subprocess.check_output(
            [sys.executable, script],
            env={**os.environ, "FEASIBEE_CACHE": str(tmp_path / "cache"), **processor},
            text=True,
        )
        for processor in ({}, {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}, {})
    ]
    assert kept == ["1\n", "2\n", "2\n"]
