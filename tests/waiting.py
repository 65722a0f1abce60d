"""How tests wait for what a page in a browser shows."""

from __future__ import annotations

import time

PATIENCE = 60
"""Seconds that a check is tried again: the machine may be busy with other tests."""


def eventually(page, check):
    """Try a check again until it holds; return what it returns."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return check()
        except AssertionError:
            if time.monotonic() > end:
                raise
        page.wait_for_timeout(50)  # not a sleep: the page may call Python meanwhile


def drawn(page, frames=2):
    """Wait until the page may have drawn so many times more."""
    page.evaluate(
        """frames => new Promise(done => {
        const count = () => frames-- ? requestAnimationFrame(count) : done();
        count(); })""",
        frames,
    )
