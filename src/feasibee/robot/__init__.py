"""The mind of one robot, as it is simulated and as it runs on real robots. Standard library only."""

from __future__ import annotations

from feasibee.robot.controller import Controller, Declare, Message, Settings
from feasibee.robot.wire import Wire, WireError

__all__ = ["Controller", "Declare", "Message", "Settings", "Wire", "WireError"]
