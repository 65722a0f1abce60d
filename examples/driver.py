"""Drive one real robot: python driver.py 3 mine.toml. Its messages travel by UDP broadcast."""

import json
import socket
import subprocess
import sys
import time
from contextlib import suppress

STEP, PORT = 0.1, 7401  # seconds per step; the swarm's radio
number, scenario = sys.argv[1:3]
command = ["feasibee", "robot", "join", scenario, "--id", number, "--senses", "/dev/stdin"]
mind = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
radio = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
for option in (socket.SO_REUSEPORT, socket.SO_BROADCAST):
    radio.setsockopt(socket.SOL_SOCKET, option, 1)
radio.bind(("", PORT))
radio.setblocking(False)

while mind.poll() is None:
    time.sleep(STEP)
    heard = []
    with suppress(BlockingIOError):  # no more packets
        while True:
            with suppress(ValueError):  # not a packet of the swarm
                heard.append(json.loads(radio.recv(65_507)))
    sensed = {"robots": 2, "tasks": 1, "heard": heard}  # ask your sensors here for those in sight
    print(json.dumps(sensed), file=mind.stdin, flush=True)
    if said := json.loads(mind.stdout.readline())["said"]:
        radio.sendto(json.dumps([int(number), said]).encode(), ("255.255.255.255", PORT))
