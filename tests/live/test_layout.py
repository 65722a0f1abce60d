"""The layout of frames: what Python writes is what the page's decoder reads."""

from __future__ import annotations

import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from declaring import declaring

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
    swarm = Swarm(Scenario(robots={"count": 33}, tasks={"count": 7}, faults={"stubborn": 0.2}), seed=3)
    swarm.advance(40)
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
    assert (frame["type"], frame["generation"], frame["robots"], frame["step"]) == ("frame", 2, 33, 40)
    assert (frame["first"], frame["feasible"]) == (5, swarm.feasible_count)
    assert (frame["firstDecision"], frame["decisionStep"]) == swarm.first_decision
    assert (frame["infeasible"], frame["decision"]) == (swarm.infeasible_count, swarm.decision)
    for name, values in (
        ("counted", swarm.counted),
        ("disseminating", swarm.disseminating),
        ("working", np.ones(33)),
    ):
        assert frame[name] == values.sum()
    assert frame["bits"] == swarm.bits_sent
    assert frame["feasibleCounts"] == swarm.feasible_counts[5:].tolist()
    assert frame["infeasibleCounts"] == swarm.infeasible_counts[5:].tolist()
    assert {name: frame[name] for name in shown._fields} == {
        k: v.tolist() for k, v in shown._asdict().items()
    }
    assert (sure["declaredFeasible"], sure["declaredInfeasible"]) == quiet.declared_counts
    assert (frame["declaredFeasible"], frame["declaredInfeasible"]) == (0, 0)
    flags = np.array(sure["flags"]) >> FLAGS.index("declared") & 1
    assert flags.tolist() == (quiet.declared >= 0).tolist()
    assert (sure["counted"], quiet.counted.sum()) == (16, 16)
    assert (tasks["type"], tasks["generation"]) == ("tasks", 3)
    assert (tasks["x"], tasks["y"]) == (places[0].tolist(), places[1].tolist())
