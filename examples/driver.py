"""Drive one real robot: python driver.py 3 mine.toml. Its messages travel by UDP broadcast."""

import json
import socket
import subprocess
import sys
import time

STEP, PORT = 0.1, 7401  # seconds per step; the swarm's radio
number, scenario = sys.argv[1:3]


def in_sight() -> tuple[int, int]:
    """Return the numbers of robots and tasks in sight: ask your sensors here."""
    return 2, 1


radio = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
radio.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
radio.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
radio.bind(("", PORT))
command = ["feasibee", "robot", scenario, "--id", number, "--senses", "/dev/stdin"]
mind = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
while mind.poll() is None:
    heard, until = [], time.monotonic() + STEP
    while (left := until - time.monotonic()) > 0:
        radio.settimeout(left)
        try:
            sender, _, message = radio.recv(65_507).decode().partition(" ")
        except TimeoutError:
            break
        if sender != number:
            heard.append([int(sender), message])
    robots, tasks = in_sight()
    print(json.dumps({"robots": robots, "tasks": tasks, "heard": heard}), file=mind.stdin, flush=True)
    state = json.loads(mind.stdout.readline())
    if state["said"]:
        radio.sendto(f"{number} {state['said']}".encode(), ("255.255.255.255", PORT))
