"""The model in plain Python, to read next to the paper; the engine must equal it bit for bit.

It shares with the engine the scenario, the vocabulary, the record and the strategies, and no line of code
that computes. Every robot is an object, driven by the controller of ``robot.py``, the one for real robots.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from feasibee.reference.swarm import Swarm, play, simulate

__all__ = ["Swarm", "play", "simulate"]


def __getattr__(name: str) -> Any:
    """Import a name on first use: a robot's process needs the draws, and nothing of scenarios."""
    if name in __all__:
        from feasibee.reference import swarm

        return getattr(swarm, name)
    raise AttributeError(f"module 'feasibee.reference' has no attribute {name!r}")
