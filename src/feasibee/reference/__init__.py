"""The model in plain Python, to read next to the paper; the engine must equal it bit for bit.

It shares with the engine the scenario, the vocabulary, the record and the strategies, and no line of code
that computes. Every robot is an object, driven by the controller of ``robot.py``, the one for real robots.
"""

from __future__ import annotations

from feasibee.reference.swarm import Swarm, play, simulate

__all__ = ["Swarm", "play", "simulate"]
