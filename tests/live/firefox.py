"""Firefox without a window, driven by WebDriver BiDi, which it speaks itself: no driver is needed."""

from __future__ import annotations

import json
import socket
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path

from websockets.sync.client import connect

SETTINGS = {
    "remote.active-protocols": 1,
    "datareporting.policy.dataSubmissionEnabled": False,
    "browser.download.folderList": 2,  # that of browser.download.dir
    "ui.prefersReducedMotion": 1,
}


@contextmanager
def running(program, profile):
    """Run Firefox with a new profile in an empty folder, where downloads go, too; give its only tab."""
    settings = SETTINGS | {"browser.download.dir": str(profile)}
    lines = (f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in settings.items())
    Path(profile, "user.js").write_text("\n".join(lines), encoding="utf-8")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = str(free.getsockname()[1])
    options = ["--headless", "--no-remote", "--profile", str(profile), "--remote-debugging-port", port]
    streams = dict.fromkeys(("stdout", "stderr"), subprocess.DEVNULL)
    with subprocess.Popen([program, *options], **streams) as process:
        try:
            with connected(f"ws://127.0.0.1:{port}/session", process) as line:
                yield Tab(line)
        finally:
            process.terminate()


def connected(address, process):
    """Return a connection to Firefox, as soon as it listens."""
    for _ in range(600):
        assert process.poll() is None, "Firefox has ended"
        try:
            return connect(address, max_size=None, proxy=None, open_timeout=60)
        except OSError:
            time.sleep(0.1)
    raise AssertionError("Firefox doesn't listen")


class Tab:
    """A tab, and what its pages wrote to the console."""

    def __init__(self, line):
        self.line = line
        self.number = 0
        self.console = []
        self.call("session.new", capabilities={})
        self.call("session.subscribe", events=["log.entryAdded"])
        self.context = self.call("browsingContext.getTree")["contexts"][0]["context"]

    def call(self, method, **params):
        """Call a command and return its result; keep what pages wrote before."""
        self.number += 1
        self.line.send(json.dumps({"id": self.number, "method": method, "params": params}))
        while True:
            message = json.loads(self.line.recv(60))
            if message["type"] == "event":
                self.console.append(message["params"]["text"])
            else:
                assert message["type"] == "success", message
                return message["result"]

    def open(self, address):
        """Open a page, and wait until it is loaded."""
        self.call("browsingContext.navigate", context=self.context, url="about:blank")
        self.call("browsingContext.navigate", context=self.context, url=address, wait="complete")

    def run(self, code):
        """Run the body of an async function in the page; return its value."""
        text = f"(async () => {{ {code} }})().then((value) => JSON.stringify(value ?? null))"
        given = self.call(
            "script.evaluate", expression=text, target={"context": self.context}, awaitPromise=True
        )
        assert given["type"] == "success", given
        return json.loads(given["result"]["value"])
