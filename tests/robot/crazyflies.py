"""Stand-ins for Crazyflies at UDP ports: they answer by Bitcraze's protocol CRTP, and fly at once."""

from __future__ import annotations

import socket
import struct
import threading
from typing import NamedTuple

LOGGING, MEMORY, PARAMETERS, HIGH_LEVEL, PLATFORM, LINK = 5, 4, 2, 8, 13, 15
TAKE_OFF, LAND, GO_TO = 7, 8, 12
VARIABLES = ("stateEstimate\0x", "stateEstimate\0y")
FLOAT = 7
PROTOCOL = 8
"""The version of the protocol: the first in which a goal says whether the way is straight."""


class Flight(NamedTuple):
    """A command to fly, and where the drone is then."""

    command: int
    x: float
    y: float
    height: float


class Crazyflie:
    """A drone that is at its goal at once.

    Parameters
    ----------
    place : tuple of float
        Position before the take-off, in metres.
    """

    def __init__(self, place):
        self.place, self.flights = list(place), []
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.005)
        self.uri = f"udp://127.0.0.1:{self.socket.getsockname()[1]}"
        self.block = None
        self.peer = None
        self.stopped = threading.Event()
        self.thread = threading.Thread(target=self.live)
        self.thread.start()

    def stop(self):
        self.stopped.set()
        self.thread.join()
        self.socket.close()

    def live(self):
        while not self.stopped.is_set():
            try:
                packet, self.peer = self.socket.recvfrom(64)
            except TimeoutError:
                if self.block is not None:
                    self.send(LOGGING, 2, struct.pack("<B3xff", self.block, *self.place))
                continue
            if packet != b"\xff" and len(packet) > 1:
                self.answer(packet[0] >> 4, packet[0] & 3, packet[1:])

    def send(self, port, channel, data):
        self.socket.sendto(bytes([port << 4 | channel]) + data, self.peer)

    def answer(self, port, channel, data):
        if (port, channel) == (LINK, 1):
            self.send(port, channel, b"Bitcraze Crazyflie\0")
        elif (port, channel) == (PLATFORM, 1):
            self.send(port, channel, bytes([data[0], PROTOCOL]))
        elif port in (LOGGING, PARAMETERS) and channel == 0:
            self.contents(port, data)
        elif (port, channel) == (LOGGING, 1):
            self.log(data)
        elif (port, channel) == (MEMORY, 0):
            self.send(port, channel, bytes([data[0], 0]))  # no memories
        elif port == HIGH_LEVEL:
            self.fly(data)

    def contents(self, port, data):
        """Answer what variables there are: those of VARIABLES, and one parameter."""
        names = VARIABLES if port == LOGGING else ("kalman\0resetEstimation",)
        if data[0] == 3:
            self.send(port, 0, struct.pack("<BHI", 3, len(names), port))
        else:
            number = int.from_bytes(data[1:3], "little")
            kind = FLOAT if port == LOGGING else 8
            self.send(port, 0, struct.pack("<BHB", 2, number, kind) + names[number].encode() + b"\0")

    def log(self, data):
        """Create, start and reset blocks; they have both variables as floats."""
        if data[0] == 6:
            assert data[2:] == bytes([FLOAT | FLOAT << 4, 0, 0, FLOAT | FLOAT << 4, 1, 0])
        self.block = {3: data[1] if data[0] == 3 else None}.get(data[0])
        self.send(LOGGING, 1, bytes([data[0], data[1] if len(data) > 1 else 0, 0]))

    def fly(self, data):
        if data[0] == GO_TO:
            *_, relative, straight, x, y, height, yaw, _ = struct.unpack("<BBBBfffff", data)
            assert (relative, straight, yaw) == (0, 0, 0.0)
            self.place = [x, y]
        else:
            *_, height, _, _, _ = struct.unpack("<BBff?f", data)
        self.flights.append(Flight(data[0], *self.place, height))
