"""
Robots that bump: discs with two wheels, in another simulator
=============================================================

Twenty discs with two wheels each, in the rigid-body simulator pymunk, with walls. Each runs the controller
of :mod:`feasibee.robot`. A disc with anything within 0.6 units of its body stops one wheel, and so curves
away. The other two swarms are feasibee's, with ``robots.contact`` as ``deflect`` and as ``stand``. Discs go
less far in a step than robots that deflect, since turning takes them time, but meet nearly as many others.
The band is the 95 % Wilson interval of the 40 runs of the discs, which are few: both rules have curves near
it. :doc:`/worlds` compares both with 200 to 400 runs of another simulator.
"""

import math
import random
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pymunk

import feasibee
from feasibee.robot import Controller

ROBOTS, TASKS, SIDE, RADIUS, SIGHT = 20, 20, 20.0, 0.5, 2.0
TICKS, REACH, AXLE = 10, 0.6, 0.8  # ticks per step; units: how far a disc feels, and between its wheels


class Disc:
    """A disc that drives straight at speed 1, turns on the spot for a new heading, and curves away."""

    def __init__(self, space, chance, place):
        self.space, self.chance = space, chance
        self.body = pymunk.Body(1.0, pymunk.moment_for_circle(1.0, 0, RADIUS))
        self.body.position, self.body.angle = place, chance.uniform(-math.pi, math.pi)
        self.shape = pymunk.Circle(self.body, RADIUS)
        self.shape.friction = 0.3
        space.add(self.body, self.shape)
        self.turn, self.left = 0.0, self.duration(10.0)
        self.mind = Controller(
            feasibee.STRATEGIES["dmmd"],
            opinion=chance.getrandbits(1),
            draw_duration=self.duration,
            draw_choice=lambda: (chance.random(), chance.random()),
        )

    def duration(self, mean):
        return max(1, math.ceil(mean * self.chance.expovariate(1.0)))

    def drive(self):
        """Set the speeds of both wheels for a tick."""
        heading = self.body.rotation_vector
        felt = pymunk.Vec2d(0.0, 0.0)
        for found in self.space.point_query(self.body.position, RADIUS + REACH, pymunk.ShapeFilter()):
            if found.shape is not self.shape:
                way = (found.point - self.body.position).normalized()
                felt += way * math.exp(RADIUS - found.distance)
        if felt.length > 0:
            wheels = (1.0, 0.0) if heading.cross(felt) > 0 else (0.0, 1.0)
            self.turn = 0.0
        elif self.turn:
            rate = max(-2.0 / AXLE, min(2.0 / AXLE, self.turn * TICKS))
            self.turn -= rate / TICKS
            wheels = (-rate * AXLE / 2, rate * AXLE / 2)
        else:
            wheels = (1.0, 1.0)
        self.body.velocity = heading * (sum(wheels) / 2)
        self.body.angular_velocity = (wheels[1] - wheels[0]) / AXLE

    def end_step(self):
        self.left -= 1
        if self.left == 0:
            self.turn, self.left = self.chance.uniform(-math.pi, math.pi), self.duration(10.0)
        self.mind.end_step()


def arena(chance):
    """Return a space with four walls, and discs at random places that don't overlap."""
    space, places = pymunk.Space(), []
    corners = [(0, 0), (SIDE, 0), (SIDE, SIDE), (0, SIDE)]
    space.add(*(pymunk.Segment(space.static_body, corners[k - 1], corners[k], 0.0) for k in range(4)))
    while len(places) < ROBOTS:
        place = tuple(chance.uniform(RADIUS, SIDE - RADIUS) for _ in range(2))
        if all(math.dist(place, other) >= 2 * RADIUS for other in places):
            places.append(place)
    return space, [Disc(space, chance, place) for place in places]


def in_sight(places, others):
    return np.hypot(*(places[:, None] - others[None]).transpose(2, 0, 1)) <= SIGHT


def exchange(discs, near, tasks):
    """Let the discs observe, send and receive, and end the step."""
    messages = [disc.mind.message() for disc in discs]
    for disc, others, seen in zip(discs, near, tasks, strict=True):
        if not disc.mind.disseminating:
            disc.mind.observe(robots=int(others.sum()), tasks=int(seen.sum()))
        for sender in np.flatnonzero(others):
            if messages[sender] and disc.mind.listens:
                disc.mind.hear(int(sender), messages[sender])
    for disc in discs:
        disc.end_step()


def run_discs(seed, steps=1000):
    """Return the step at which a swarm of discs decides, the decision, and the places at each step."""
    chance = random.Random(seed)
    space, discs = arena(chance)
    tasks = np.array([[chance.uniform(0, SIDE), chance.uniform(0, SIDE)] for _ in range(TASKS)])
    track = [np.array([disc.body.position for disc in discs])]
    for step in range(steps + 1):
        feasible = sum(disc.mind.opinion for disc in discs)
        if not 2 <= feasible <= ROBOTS - 2:
            return step, feasible > 2, track
        for _ in range(TICKS):
            for disc in discs:
                disc.drive()
            space.step(1.0 / TICKS)
        track.append(np.array([disc.body.position for disc in discs]))
        near = in_sight(track[-1], track[-1]) & ~np.eye(ROBOTS, dtype=bool)
        exchange(discs, near, in_sight(track[-1], tasks))
    return steps + 1, False, track


def motion(track):
    """Return distance and new contacts per robot and step of a run."""
    near = [in_sight(places, places) for places in track]
    new = sum((after & ~before).sum() for before, after in pairwise(near))
    gone = np.hypot(*np.diff(track, axis=0).transpose(2, 0, 1))
    return gone.mean(), new / gone.size


def track_of(world, run, steps=200):
    """Return the places at each step of a run of feasibee."""
    swarm, track = feasibee.Swarm(world, seed=1, run=run), []
    for _ in range(steps):
        track.append(swarm.positions)
        swarm.advance()
    return track


walls = {"arena.boundary": "walls", "robots.avoid_collisions": True, "run.stop_at_decision": True}
steps, decisions, tracks = zip(*(run_discs(seed) for seed in range(40)), strict=True)
found = {
    "discs in pymunk": (steps, np.mean(decisions), [motion(track) for track in tracks if len(track) > 1])
}
for contact in ("deflect", "stand"):
    world = feasibee.Scenario(tasks={"count": TASKS}).replace({**walls, "robots.contact": contact})
    results = feasibee.simulate(world, runs=2000, seed=1)
    decided = np.where(results.decision_step < 0, 1001, results.decision_step)
    moved = [motion(track_of(world, run)) for run in range(40)]
    found[f"feasibee, {contact}"] = (decided, float((results.decision == 1).mean()), moved)

_, (left, right) = plt.subplots(1, 2, figsize=(6.8, 3.2), layout="constrained", width_ratios=(1.6, 1))
grid = np.arange(0, 601)
for (name, (decided, feasible, moved)), colour in zip(
    found.items(), ("0.2", "#0072B2", "#D55E00"), strict=True
):
    share = np.searchsorted(np.sort(decided), grid, side="right")
    left.plot(grid, share / len(decided), color=colour, label=f"{name}: {100 * feasible:.0f} % feasible")
    if name.startswith("discs"):
        _, low, high = np.array([feasibee.wilson(int(count), len(decided)) for count in share]).T
        left.fill_between(grid, low, high, color=colour, alpha=0.15, linewidth=0)
    right.plot(*np.mean(moved, axis=0), "o", color=colour)
    right.annotate(name, np.mean(moved, axis=0), (0, 6), textcoords="offset points", fontsize=8, ha="center")
left.set(xlabel="time (steps)", ylabel="share of swarms that have decided", xlim=(0, 600), ylim=(0, 1))
left.legend(loc="lower right", fontsize=8)
right.set(xlabel="distance per step (units)", ylabel="new contacts per robot-step")
right.set(xlim=(0.65, 1.05), ylim=(0.15, 0.25))
