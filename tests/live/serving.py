"""A server of the live arena, for tests."""

from __future__ import annotations

import threading
from contextlib import contextmanager

from feasibee.live import server as serving


@contextmanager
def serving_at(catalogue, port=0):
    """Run a server in a thread; give its port."""
    with serving.listen("127.0.0.1", port) as listening:
        server = serving.server_of(catalogue, "127.0.0.1")
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
        thread.start()
        try:
            yield listening.getsockname()[1]
        finally:
            server.should_exit = True
            thread.join(10)
            assert not thread.is_alive()
