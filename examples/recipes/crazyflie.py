"""Fly Crazyflies that find out whether they are enough: python crazyflie.py radio://0/80/2M/E7E7E7E701 ...

They need positions in one frame, as by Lighthouse, and 3 by 3 m of free space.
"""

import math
import random
import sys
import time

import cflib.crtp
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.swarm import Swarm

from feasibee.robot import Controller
from feasibee.strategies import STRATEGIES

STEP = 1.0  # seconds
HALF, HEIGHT, WAY, RANGE, APART = 1.4, 0.5, 0.25, 0.9, 0.6  # of the arena; per step; all in metres
TASKS = [(-0.9, 0.4), (0.2, -1.1), (0.8, 0.9)]  # replace by what each drone sees
places, goals = {}, {}


def duration(mean):
    """Draw how many steps a phase or a straight flight lasts."""
    return int(mean * random.expovariate(1.0)) + 1


def begin(drone):
    """Log the drone's position ten times per second, and take off once it is known."""
    uri, log = drone.cf.link_uri, LogConfig("place", period_in_ms=100)
    log.add_variable("stateEstimate.x", "float")
    log.add_variable("stateEstimate.y", "float")
    drone.cf.log.add_config(log)
    log.data_received_cb.add_callback(lambda _, data, __: places.update({uri: tuple(data.values())}))
    log.start()
    while uri not in places:
        time.sleep(0.01)
    drone.cf.high_level_commander.takeoff(HEIGHT, 2 * STEP)


def go(drone):
    """Fly to the goal, or stay without one."""
    if goal := goals.get(drone.cf.link_uri):
        drone.cf.high_level_commander.go_to(*goal, HEIGHT, 0.0, 0.9 * STEP)


def choice():
    """Draw the chance and the message that are left to a decision."""
    return random.random(), random.random()


cflib.crtp.init_drivers()
uris = sys.argv[1:]
minds = {uri: Controller(STRATEGIES["dmmd"], random.getrandbits(1), duration, choice) for uri in uris}
flight = dict.fromkeys(uris, (0.0, 0))  # heading and steps until the next turn
with Swarm(uris) as swarm:
    swarm.parallel_safe(begin)
    time.sleep(2 * STEP)
    try:
        while len({mind.opinion for mind in minds.values()}) == 2:
            now = dict(places)
            near = {
                one: [u for u in uris if u != one and math.dist(now[one], now[u]) <= RANGE] for one in uris
            }
            for uri, mind in minds.items():
                mind.observe(len(near[uri]), sum(math.dist(now[uri], task) <= RANGE for task in TASKS))
            said = {uri: mind.message() for uri, mind in minds.items()}
            for uri, mind in minds.items():
                for sender in near[uri]:
                    if said[sender] and mind.listens:
                        mind.hear(uris.index(sender), said[sender])
                mind.end_step()
                heading, left = flight[uri]
                if not left:
                    heading, left = random.uniform(-math.pi, math.pi), duration(10.0)
                goal = now[uri][0] + WAY * math.cos(heading), now[uri][1] + WAY * math.sin(heading)
                free = all(math.dist(goal, now[each]) >= APART for each in near[uri])
                goals[uri] = goal if free and max(map(abs, goal)) <= HALF else None
                flight[uri] = heading, left - 1 if goals[uri] else 0  # blocked: turn
            swarm.parallel_safe(go)
            time.sleep(STEP)
    finally:
        swarm.parallel_safe(lambda drone: drone.cf.high_level_commander.land(0.0, 2 * STEP))
        time.sleep(2 * STEP)
print({1: "feasible", 0: "infeasible"}[next(iter(minds.values())).opinion])
