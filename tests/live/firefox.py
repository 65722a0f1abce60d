"""Firefox without a window, driven by WebDriver BiDi, which it speaks itself: no driver is needed."""

from __future__ import annotations

import json
import re
import subprocess
from contextlib import contextmanager
from pathlib import Path

from websockets.sync.client import connect

SETTINGS = {"remote.active-protocols": 1, "datareporting.policy.dataSubmissionEnabled": False}


@contextmanager
def running(program, profile):
    """Run Firefox with a new profile in an empty folder; give its only tab."""
    lines = (f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in SETTINGS.items())
    Path(profile, "user.js").write_text("\n".join(lines), encoding="utf-8")
    options = ["--headless", "--no-remote", "--profile", str(profile), "--remote-debugging-port", "0"]
    said = Path(profile, "said.txt")
    with (
        said.open("w", encoding="utf-8") as errors,
        subprocess.Popen([program, *options], stdout=subprocess.DEVNULL, stderr=errors) as process,
    ):
        try:
            address = address_in(said, process)
            with connect(f"{address}/session", max_size=None, proxy=None, open_timeout=60) as socket:
                yield Tab(socket)
        finally:
            process.terminate()


def address_in(said, process):
    """Wait until Firefox says at which address it listens."""
    for _ in range(600):
        if found := re.search(r"BiDi listening on (ws://\S+)", said.read_text(encoding="utf-8")):
            return found[1]
        try:
            process.wait(0.1)
        except subprocess.TimeoutExpired:
            continue
        break
    raise AssertionError(f"Firefox doesn't listen: {said.read_text(encoding='utf-8')}")


class Tab:
    """A tab, and what its pages wrote to the console or asked for."""

    def __init__(self, socket):
        self.socket = socket
        self.number = 0
        self.console, self.asked = [], []
        self.call("session.new", capabilities={})
        self.call("session.subscribe", events=["log.entryAdded", "network.beforeRequestSent"])
        self.context = self.call("browsingContext.getTree")["contexts"][0]["context"]

    def call(self, method, **params):
        """Call a command and return its result; keep the events that come before."""
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": params}))
        while True:
            message = json.loads(self.socket.recv(60))
            if message["type"] == "event":
                self.keep(message["method"], message["params"])
            else:
                assert message["type"] == "success", message
                return message["result"]

    def keep(self, event, params):
        """Keep what a page wrote or asked for."""
        if event == "log.entryAdded":
            self.console.append(params["text"])
        elif params["context"] == self.context:
            self.asked.append(params["request"]["url"])

    def open(self, address):
        """Open a page, and wait until it is loaded."""
        self.call("browsingContext.navigate", context=self.context, url=address, wait="complete")

    def run(self, code):
        """Run the body of an async function in the page; return its value."""
        text = f"(async () => {{ {code} }})().then((value) => JSON.stringify(value ?? null))"
        given = self.call(
            "script.evaluate", expression=text, target={"context": self.context}, awaitPromise=True
        )
        assert given["type"] == "success", given
        return json.loads(given["result"]["value"])
