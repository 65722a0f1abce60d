"""
The controller runs without the simulator
=========================================

Twenty controllers of :mod:`feasibee.robot`, which needs the standard library only. In place of the world, a
robot meets another in six steps of ten and a task in three. On real robots, ``observe`` gets the camera's
counts and ``hear`` the messages from the radio. :doc:`/deploying` has the rest.
"""

import random

import matplotlib.pyplot as plt

import feasibee
from feasibee.robot import Controller

random.seed(3)
robots = [
    Controller(
        feasibee.STRATEGIES["dmmd"],
        opinion=random.getrandbits(1),
        draw_duration=lambda mean: int(mean * random.expovariate(1.0)) + 1,
        draw_choice=lambda: (random.random(), random.random()),
    )
    for _ in range(20)
]
feasible = []
for _ in range(300):
    messages = [robot.message() for robot in robots]
    for me, robot in enumerate(robots):
        robot.observe(robots=random.random() < 0.6, tasks=random.random() < 0.3)
        sender = random.randrange(20)  # a random neighbour
        if sender != me and messages[sender] and robot.listens:
            robot.hear(sender, messages[sender])
    for robot in robots:
        robot.end_step()
    feasible.append(sum(robot.opinion == 1 for robot in robots))

_, ax = plt.subplots(figsize=(6.4, 3), layout="constrained")
ax.step(range(1, 301), feasible)
ax.set(xlabel="time (steps)", ylabel="robots with opinion feasible", ylim=(-0.5, 20.5))
