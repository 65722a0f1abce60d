"""Each test has nodes of its own, on this machine only; the helpers of tests/field are there, too."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor

sys.path[:0] = [str(Path(__file__).parents[2] / folder) for folder in ("tests/field", ".")]
DOMAINS = 100
"""Number of domains that test runs choose from, by their processes, so that they don't meet."""


@pytest.fixture(autouse=True)
def domain(monkeypatch):
    """Give the number of a domain that another process hardly has."""
    number = 1 + os.getpid() % DOMAINS
    monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    return number


class Nodes:
    """Nodes that one thread runs, until what a test waits for has happened."""

    def __init__(self):
        self.executor = SingleThreadedExecutor()
        self.all = []

    def add(self, node):
        self.all.append(node)
        self.executor.add_node(node)
        return node

    def until(self, holds):
        """Run the nodes until something holds; the test's time limit is that of the whole run."""
        while not holds():
            self.executor.spin_once(0.2)


@pytest.fixture
def nodes(domain):
    """Give what runs the nodes of a test."""
    with rclpy.init():
        given = Nodes()
        yield given
        for node in given.all:
            node.destroy_node()
