"""The MicroPython example decides as the controller does."""

from __future__ import annotations

import json
import random
import shutil
import subprocess
from fractions import Fraction
from pathlib import Path

import pytest

from feasibee.robot import Controller, Declare, Message, Settings
from feasibee.strategies import STRATEGIES

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "micropython"
MICROPYTHON = ROOT / "node_modules" / "@micropython" / "micropython-webassembly-pyscript" / "micropython.mjs"

# Runs in both: feeds a robot, and yields its state after each step.
FEED = """
def states(robot, steps):
    for robots, tasks, messages in steps:
        robot.observe(robots, tasks)
        for sender, opinion in messages:
            robot.hear(sender, opinion)
        said = robot.message()
        robot.end_step()
        said = -1 if said is None else said
        yield [said, robot.opinion, int(robot.disseminating), robot.phase_left, robot.declared]
"""

LOAD = """
import {{ loadMicroPython }} from {module};
import {{ readFileSync }} from "node:fs";
const stdout = (line) => console.log(line);
const mp = await loadMicroPython({{ heapsize: 64 << 20, stdout, linebuffer: true }});
const files = JSON.parse(readFileSync(0, "utf8"));
for (const [name, text] of Object.entries(files)) mp.FS.writeFile("/" + name, text);
mp.runPython("import sys; sys.path.append('/'); import test");
"""


def in_micropython(files, folder):
    """Run ``test.py`` among these files in MicroPython; return what it printed, one JSON text per line."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node; Debian has it as nodejs")
    if not MICROPYTHON.exists():
        pytest.skip("no MicroPython: run npm ci")
    script = folder / "run.mjs"
    script.write_text(LOAD.format(module=json.dumps(MICROPYTHON.as_uri())))
    done = subprocess.run(
        [node, str(script)], input=json.dumps(files), capture_output=True, text=True, timeout=240, check=False
    )
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def cases(steps):
    """Return steps with what a robot sees and hears in each, and unit exponential draws."""
    rng = random.Random(17)
    heard = [[[rng.randrange(9), rng.randrange(2)] for _ in range(rng.randrange(3))] for _ in range(steps)]
    seen = [[rng.randrange(4), rng.randrange(4), messages] for messages in heard]
    return seen, [rng.expovariate(1.0) for _ in range(steps)]


SETTINGS = [
    {"opinion": 1},
    {"opinion": 0, "exploration": 3.0, "gain": 25.0, "inbox_size": 4},
    {"opinion": 1, "exploration": 2.0, "gain": 3.0, "quorum": [3, 5], "rounds": 4, "heard": 2},
]


class Told(Controller):
    """The controller of ``feasibee.robot``, with messages as the example has them."""

    def hear(self, sender, opinion):
        super().hear(sender, Message(opinion))

    def message(self):
        said = super().message()
        return None if said is None else said.opinion


def expected(setting, steps, draws):
    """Return the states of the controller of ``feasibee.robot``."""
    draw = iter(draws)
    rest = dict(setting)
    quorum, rounds, heard = rest.pop("quorum", None), rest.pop("rounds", 3), rest.pop("heard", 3)
    robot = Told(
        STRATEGIES["dmmd"],
        draw_duration=lambda mean: int(mean * next(draw)) + 1,
        draw_choice=lambda: (0.0, 0.0),
        opinion=rest.pop("opinion"),
        settings=Settings(
            declare=Declare(Fraction(*quorum), rounds, heard) if quorum else None,
            inbox_size=rest.pop("inbox_size", 32),
            **rest,
        ),
    )
    feed = {}
    exec(FEED, feed)
    return list(feed["states"](robot, steps))


def test_the_example_equals_the_controller(tmp_path):
    steps, draws = cases(2000)
    test = f"""{FEED}
import json
from dmmd import Robot
with open('/cases.json') as file:
    cases = json.load(file)
for setting in cases['settings']:
    draw = iter(cases['draws'])
    robot = Robot(draw_duration=lambda mean: int(mean * next(draw)) + 1, **setting)
    print(json.dumps(list(states(robot, cases['steps']))))
"""
    given = {"settings": SETTINGS, "steps": steps, "draws": draws}
    files = {"dmmd.py": (EXAMPLE / "dmmd.py").read_text(), "test.py": test, "cases.json": json.dumps(given)}
    states = [expected(each, steps, draws) for each in SETTINGS]
    assert in_micropython(files, tmp_path) == states
    assert all(len({opinion for _, opinion, *_ in each}) == 2 for each in states)
    declared = [any(each[-1] != -1 for each in found) for found in states]
    assert declared == ["quorum" in each for each in SETTINGS]


# The parts of MicroPython's boards that the example uses, and nothing else.
BOARD = {
    "network.py": """
class WLAN:
    IF_STA = 0
    def __init__(self, interface): assert interface == WLAN.IF_STA
    def active(self, on): assert on
""",
    "espnow.py": """
sent = []
class ESPNow:
    def __init__(self): self.arrived, self.peers = [], []
    def active(self, on): assert on
    def add_peer(self, mac): self.peers.append(mac)
    def recv(self, timeout_ms):
        assert timeout_ms == 0
        return self.arrived.pop(0) if self.arrived else [None, None]
    def send(self, mac, message, sync):
        assert mac in self.peers and len(mac) == 6 and not sync
        sent.append(message)
        self.arrived += [[bytes([2, 0, 0, 0, 0, k]), b"\\x00"] for k in range(5)] + [[bytes(6), b"noise"]]
""",
    "time.py": """
now = 0
def ticks_ms(): return now
def ticks_diff(end, start): return end - start
def sleep_ms(ms):
    global now
    assert 0 <= ms <= 1000
    now += ms
""",
}


def test_the_program_for_the_board_runs_on_a_stand_in_for_the_board(tmp_path):
    """Five robots say infeasible whenever it speaks: so it declares that, and sends it."""
    example = {path.name: path.read_text() for path in EXAMPLE.glob("*.py")}
    test = """
import json, espnow, main
robot = main.run(400)
print(json.dumps([robot.opinion, robot.declared, espnow.sent[-1][0], main.time.ticks_ms()]))
"""
    assert in_micropython({**BOARD, **example, "test.py": test}, tmp_path) == [[0, 0, 2, 400_000]]
