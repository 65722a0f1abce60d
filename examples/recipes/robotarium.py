"""Let 10 robots of the Robotarium find out whether they are enough: python robotarium.py [TASKS [SEED]]."""

import random
import sys

import numpy as np
from rps.robotarium import Robotarium
from rps.utilities.barrier_certificates import create_uni_barrier_certificate_with_boundary
from rps.utilities.transformations import create_si_to_uni_dynamics

sys.path.append("feasibee.zip")  # upload it with this file
from feasibee.robot import Controller
from feasibee.strategies import STRATEGIES

ROBOTS, STEPS, ITERATIONS, SPEED, RANGE = 10, 600, 40, 0.15, 0.5  # 40 iterations a step; m/s; m
TASKS, *seed = [int(each) for each in sys.argv[1:]] or [3]
random.seed(*seed)
np.random.seed(random.getrandbits(32))  # noqa: NPY002, as the simulator draws from it


def duration(mean):
    """Draw how many steps a phase or a straight walk lasts."""
    return int(mean * random.expovariate(1.0)) + 1


def choice():
    """Draw the chance and the message that are left to a decision."""
    return random.random(), random.random()


tasks = np.array([(random.uniform(-1.6, 1.6), random.uniform(-1.0, 1.0)) for _ in range(TASKS)]).T
grid = [(0.45 * x, 0.47 * y, random.uniform(-3.1, 3.1)) for x in range(-3, 4) for y in (-1.5, -0.5, 0.5, 1.5)]
start = np.array(random.sample(grid, ROBOTS)).T
swarm = Robotarium(
    number_of_robots=ROBOTS, show_figure=False, sim_in_real_time=False, initial_conditions=start
)
unicycle, certified = create_si_to_uni_dynamics(), create_uni_barrier_certificate_with_boundary()
minds = [Controller(STRATEGIES["dmmd"], random.getrandbits(1), duration, choice) for _ in range(ROBOTS)]
heading, left, blocked = np.zeros(ROBOTS), np.zeros(ROBOTS), np.zeros(ROBOTS, bool)
opinions = [sum(mind.opinion for mind in minds)]
while len(opinions) <= STEPS and 0 < opinions[-1] < ROBOTS:
    for robot in np.flatnonzero((left < 1) | blocked):
        heading[robot], left[robot] = random.uniform(-np.pi, np.pi), duration(10.0)
    left -= 1
    for _ in range(ITERATIONS):
        poses = swarm.get_poses()
        wanted = unicycle(SPEED * np.array([np.cos(heading), np.sin(heading)]), poses)
        driven = certified(wanted, poses)
        swarm.set_velocities(np.arange(ROBOTS), driven)
        swarm.step()
    blocked = np.abs(driven[0]) < np.abs(wanted[0]) / 2
    near = np.linalg.norm(poses[:2, :, None] - poses[:2, None], axis=0) <= RANGE
    seen = np.linalg.norm(poses[:2, :, None] - tasks[:, None], axis=0) <= RANGE
    for mind, robots, things in zip(minds, near.sum(axis=1) - 1, seen.sum(axis=1), strict=True):
        mind.observe(int(robots), int(things))
    said = [mind.message() for mind in minds]
    for hearer, sender in zip(*near.nonzero(), strict=True):
        if hearer != sender and said[sender] and minds[hearer].listens:
            minds[hearer].hear(int(sender), said[sender])
    for mind in minds:
        mind.end_step()
    opinions.append(sum(mind.opinion for mind in minds))
np.savetxt("opinions.csv", opinions, "%d")  # robots that hold feasible, by step
print({0: "infeasible", ROBOTS: "feasible"}.get(opinions[-1], "undecided"), len(opinions) - 1)
swarm.debug()
