"""One robot on an ESP32 with MicroPython: ESP-NOW as radio, one step per second."""

import math
import random
import time

import espnow
import network
from dmmd import Robot

EVERYONE = b"\xff" * 6
STEP_MS = 1000


def draw_duration(mean):
    """Draw an exponential duration, rounded up to whole steps."""
    return int(-mean * math.log(1.0 - random.random())) + 1


def in_sight():
    """Return the numbers of robots and tasks in sight; replace this by your camera or sensor."""
    return 0, 0


def receive(radio, robot):
    """Give the robot all messages that arrived since the last step."""
    while True:
        sender, payload = radio.recv(0)
        if sender is None:
            return
        if len(payload) == 1 and payload[0] < 4:
            robot.hear(bytes(sender), payload[0] & 1)


def run(steps=None):
    """Run the robot for ``steps`` steps, by default for ever, and return it."""
    network.WLAN(network.WLAN.IF_STA).active(True)
    radio = espnow.ESPNow()
    radio.active(True)
    radio.add_peer(EVERYONE)
    robot = Robot(random.getrandbits(1), draw_duration, quorum=(9, 10))
    done = 0
    while steps is None or done < steps:
        began = time.ticks_ms()
        robot.observe(*in_sight())
        receive(radio, robot)
        opinion = robot.message()
        if opinion is not None:
            radio.send(EVERYONE, bytes([opinion | (robot.declared != -1) << 1]), False)
        robot.end_step()
        done += 1
        time.sleep_ms(max(0, STEP_MS - time.ticks_diff(time.ticks_ms(), began)))
    return robot


if __name__ == "__main__":
    run()
