"""The layout of frames: what Python writes is what the page's decoder reads."""

from __future__ import annotations

import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from declaring import declaring
from playing import swarm_at

from feasibee import Scenario, Swarm
from feasibee.live.messages import PROTOCOL, encode_frame, encode_tasks
from feasibee.live.page import STATIC
from feasibee.simulation.snapshot import FLAGS

NODE = shutil.which("node")
DECODER = STATIC / "frames.js"
SCRIPT = """
import { readFileSync } from "node:fs";
const url = "data:text/javascript," + encodeURIComponent(readFileSync(process.argv[2], "utf-8"));
const { decode } = await import(url);
const read = (name) => {
  const bytes = readFileSync(name);
  return decode(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
};
const plain = (_, value) => (ArrayBuffer.isView(value) ? [...value] : value);
console.log(JSON.stringify(process.argv.slice(3).map(read), plain));
"""


def test_the_page_knows_the_flags_and_the_version():
    text = DECODER.read_text("utf-8")
    (flags,) = re.findall(r"export const (FEASIBLE[^;]+);", text)
    assert re.findall(r"(\w+) = (\d+)", flags) == [
        (name.upper(), str(1 << k)) for k, name in enumerate(FLAGS)
    ]
    assert f"const PROTOCOL = {PROTOCOL};" in text


@pytest.mark.skipif(NODE is None, reason="runs the page's code in Node")
def test_the_page_reads_what_python_writes(tmp_path):
    swarm = swarm_at(40, Scenario(robots={"count": 33}, tasks={"count": 7}, faults={"stubborn": 0.2}), seed=3)
    quiet = Swarm(declaring(tmp_path, quiet=20.0, faults={"byzantine": 0.2}), seed=3)
    while sum(quiet.declared_counts) < 9:
        quiet.advance()
    messages = {
        "frame": encode_frame(swarm, 65538, 5),
        "tasks": encode_tasks(swarm, 3),
        "sure": encode_frame(quiet, 0, 0),
    }
    for name, message in messages.items():
        (tmp_path / name).write_bytes(message)
    module = tmp_path / "read.mjs"
    module.write_text(SCRIPT)
    command = [NODE, module, DECODER, *(tmp_path / name for name in messages)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    frame, tasks, sure = json.loads(done.stdout)
    shown, places = swarm.snapshot(), swarm.task_places()
    first_decision, decision_step = swarm.first_decision
    expected = {
        **{"type": "frame", "generation": 2, "robots": 33, "step": 40, "first": 5, "bits": swarm.bits_sent},
        **{"feasible": swarm.feasible_count, "infeasible": swarm.infeasible_count},
        **{"decision": swarm.decision, "firstDecision": first_decision, "decisionStep": decision_step},
        **{"counted": swarm.counted.sum(), "disseminating": swarm.disseminating.sum(), "working": 33},
        "feasibleCounts": swarm.feasible_counts[5:].tolist(),
        "infeasibleCounts": swarm.infeasible_counts[5:].tolist(),
        **{name: each.tolist() for name, each in shown._asdict().items()},
    }
    assert {name: frame[name] for name in expected} == expected
    assert (sure["declaredFeasible"], sure["declaredInfeasible"]) == quiet.declared_counts
    assert (frame["declaredFeasible"], frame["declaredInfeasible"]) == (0, 0)
    flags = np.array(sure["flags"]) >> FLAGS.index("declared") & 1
    assert flags.tolist() == (quiet.declared >= 0).tolist()
    assert (sure["counted"], quiet.counted.sum()) == (16, 16)
    assert (tasks["type"], tasks["generation"]) == ("tasks", 3)
    assert (tasks["x"], tasks["y"]) == (places[0].tolist(), places[1].tolist())
