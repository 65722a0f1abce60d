"""The nursery of a field whose robots are nodes: that of `feasibee.field.robot`, with other robots.

It forks, so it must have one thread: rclpy, which has more, is loaded by its children.
"""

from __future__ import annotations

import gc
from typing import Any

from feasibee.field.robot import main


def take_part(*about: Any, **options: Any) -> tuple[int, str]:
    """Run a robot as `feasibee_ros.simulated.take_part` does."""
    from feasibee_ros.simulated import take_part

    try:
        return take_part(*about, **options)
    finally:
        gc.collect()  # lifecycle nodes are in cycles; the process ends at once, and would leave shared memory


if __name__ == "__main__":
    main(take_part)
