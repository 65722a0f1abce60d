"""A small world that changes: 5 tasks for 10 robots, and 20 more from step 120 on."""

from __future__ import annotations

TOML = """
[arena]
side = 12.0
[robots]
count = 10
[tasks]
count = 5
[run]
steps = 240
[[events]]
step = 120
tasks = 20
"""
