"""Measure the length of a frame of the live arena in thousands of bytes: docs/watch.md."""

from __future__ import annotations

import json

import feasibee
from feasibee.live.messages import encode_frame

large = feasibee.Scenario().replace({"robots.count": 10_000, "arena.side": 450.0})
print(json.dumps({"kilobytes": len(encode_frame(feasibee.Swarm(large), 0, 0)) / 1000}))
