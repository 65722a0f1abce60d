"""A folder with all that isn't a plain file of text, and with what is right."""

from __future__ import annotations

import os
import socket
from pathlib import Path

SUFFIXES = ("", ".png", ".svg", ".pdf", ".gif", ".html", ".nc", ".csv", ".jsonl", ".py")


def prepare(here: Path) -> None:
    """Make pipes, loops, folders, a file of a terabyte that takes no room, a socket, and a study."""
    (here / "plain").write_text("x")
    (here / "bytes").write_bytes(b"\xff\xfe\0")
    for suffix in SUFFIXES:
        os.mkfifo(here / f"pipe{suffix}")
        (here / f"loop{suffix}").symlink_to(f"loop{suffix}")
        (here / f"folder{suffix}").mkdir()
    (here / "link-to-pipe").symlink_to("pipe")
    with (here / "sparse").open("wb") as file:
        file.truncate(2**40)
    with socket.socket(socket.AF_UNIX) as there:
        before = Path.cwd()
        os.chdir(here)  # the name of a socket is short
        there.bind("socket")
        os.chdir(before)
    (here / "study.toml").write_text('runs = 2\n[scenario]\nrun.steps = 3\n[sweep]\n"tasks.count" = [2, 3]\n')
