"""The mind of one robot, as it is simulated and as it runs on real robots. Standard library only."""

from __future__ import annotations

from feasibee.robot.controller import Commit, Controller, Message, Settings
from feasibee.robot.wire import Wire, WireError

__all__ = ["Commit", "Controller", "Message", "Settings", "Wire", "WireError"]
