"""The server of `feasibee watch`: what it answers, and that nothing that a page or another says breaks it."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import ExitStack

import commands
import pytest
from serving import given, got, posted, said, serving_at

from feasibee import FeasibeeError, Scenario
from feasibee.live import serve
from feasibee.live.catalogue import Catalogue
from feasibee.live.form import form
from feasibee.live.guard import Guard, is_loopback
from feasibee.live.packet import wasm_of
from feasibee.live.prediction import prediction_of
from feasibee.live.scene import opened_of
from feasibee.scenario.runs import Runs


def silent(port, text):
    line = socket.create_connection(("127.0.0.1", port), 60)
    line.sendall(text.encode())
    return line


def same(opened, scenario, *which, **own):
    return opened == json.loads(json.dumps(opened_of(scenario, Runs.single(*which)) | own))


def test_the_page_comes_whole_and_loads_nothing(port):
    status, headers, text = got(port)
    assert (status, headers["Content-Type"]) == (200, "text/html; charset=utf-8")
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]
    assert "default-src 'none'" in text
    assert "connect-src 'self'" in text
    assert not re.search(r"""\s(src|href)=["'](?!data:|#)""", text)
    page, scenario = given(text), Scenario()
    assert same(page["opened"], scenario, 1, 0, point=None)
    assert page["wasm"] == wasm_of(scenario)
    assert (page["server"], page["replays"], page["field"]) == (True, None, None)
    assert json.dumps(page["form"]) == json.dumps(form())


def test_a_page_opens_what_it_changes_and_asks_what_the_theory_says(port):
    changes = {"tasks.count": 10, "robots.classes": '[{name = "arm", count = 9}]', "arena.side": "30"}
    scenario = Scenario().replace(
        {**changes, "robots.classes": [{"name": "arm", "count": 9}], "arena.side": 30}
    )
    asked = {"changes": changes, "seed": str(2**64 - 1), "run": "7"}
    status, opened = posted(port, "/open", asked)
    assert status == 200
    assert same(opened, scenario, 2**64 - 1, 7, point=None, wasm=None)
    assert {"arena.side", "robots.classes", "tasks.count"} <= set(opened["changed"])
    answer = posted(port, "/predict", {"changes": {"tasks.count": 10}})
    assert answer == (200, prediction_of(Scenario(tasks={"count": 10})))


def test_all_problems_come_at_once_each_with_its_path(port):
    changes = {"robots.count": -1, "radio.loss": 2, "decision.strategy": "/tmp/evil.py"}
    status, answer = posted(port, "/open", {"changes": changes})
    assert status == 422
    assert {each["path"] for each in answer["problems"]} == set(changes)
    for asked, text in (
        ({"point": 3}, "point = 3: not found"),
        ({"seed": str(2**64)}, f"seed = {2**64}: must"),
    ):
        (problem,) = posted(port, "/open", asked)[1]["problems"]
        assert (problem["path"], problem["text"].startswith(text)) == ("", True), problem


def test_a_users_strategy_brings_its_engine_once_it_is_chosen(tmp_path):
    """Catches a module that is sent again, or not at all; compiling it takes seconds."""
    pytest.importorskip("ziglang", reason="ziglang isn't installed: it compiles WebAssembly")
    file = tmp_path / "mine.py"
    file.write_text('def decide(mind, inbox):\n    """Return *what* it had."""\n    return mind.opinion\n')
    with serving_at(Catalogue(mine := Scenario(decision={"strategy": str(file)}))) as port:
        text = got(port)[2]
        assert wasm_of(mine) in text
        own = posted(port, "/open", {"changes": {"decision.strategy": str(file)}})[1]
        strategy = own["strategies"][own["settings"]["strategy"]]
        assert (own["wasm"], strategy["decide"]) == (None, "what it had.")
        other = posted(port, "/open", {"changes": {"decision.strategy": "voter"}})[1]
        assert other["wasm"] == wasm_of(Scenario())


WRONG = {
    "nothing": b"",
    "not JSON": b"{",
    "a list": b"[]",
    "bytes": b"\x00\xff\x17",
    "half a character": b'{"changes": {"decision.strategy": "\\ud800"}}',
    "more than asked": b'{"path": "/etc/passwd"}',
    "a point of text": b'{"point": "1"}',
    "a bit": b'{"seed": true}',
    "a seed of words": b'{"seed": "x"}',
    "a run below 0": b'{"run": "-1"}',
    "changes in a list": b'{"changes": []}',
    "65 changes": json.dumps({"changes": dict.fromkeys(map(str, range(65)))}).encode(),
    "too deep": b'{"changes": {"a.b": ' + b"[" * 3000 + b"]" * 3000 + b"}}",
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_no_request_is_answered_in_a_line(port, what):
    for path in ("/open", "/predict"):
        status, answer = posted(port, path, WRONG[what])
        assert (status, answer.count("\n")) == (400, 1), answer


def test_a_body_that_is_too_long_or_of_unknown_length_is_refused(port):
    assert posted(port, "/open", b" " * 16_385) == (413, "must be at most 16384 bytes\n")
    assert posted(port, "/open", b" " * 16_384)[0] == 400
    assert posted(port, "/open", b" " * 2_000_000, "")[0] == 413
    head = "POST /open HTTP/1.1\r\nHost: localhost\r\nOrigin: http://localhost\r\n"
    for more in ("", "Content-Length: -1\r\n", "Content-Length: x\r\n", "Transfer-Encoding: chunked\r\n"):
        assert said(port, f"{head}{more}\r\n{{}}")[0] == 400, more


def test_nothing_else_is_served(port):
    for path in ("/open", "/field", "/static/app.js", "/../serve.py", "/%2e%2e/serve.py", "//etc/passwd"):
        assert got(port, path)[0] == 404, path
    for path in ("/", "/field", "/x"):
        assert posted(port, path, {})[0] == 404, path
    assert said(port, "PUT / HTTP/1.1\r\nHost: localhost\r\n\r\n")[0] == 501
    with silent(port, "\x00\xff\r\n\r\n") as line:
        assert line.recv(99).startswith(b"Bad request")


OWN = ["127.0.0.1", "127.0.0.1:80", "localhost:80", "[::1]:80", "LOCALHOST"]
OTHERS = [
    *("evil.example", "evil.example:80", "192.168.0.7", "[", "", "127.0.0.1.evil.example"),
    *("evil.example@127.0.0.1", "evil.example@127.0.0.1:80", "localhost@localhost"),
    *("127.0.0.1/x", "127.0.0.1:80/x", "127.0.0.1?x", "127.0.0.1#x", "127.0.0.1\\x", "//127.0.0.1"),
    *("127.0.0.1:abc", "127.0.0.1:", "127.0.0.1:1", "127.0.0.1:080", "127.0.0.1:+80", "127.0.0.1:80:80"),
    *("127.0.0.1:80,evil.example", "127.0.0.1 evil.example", "127.1", "127.0.0.01", "2130706433"),
    *("0x7f000001", "localhost.", "\uff4cocalhost", "localhost%00", "::1", "[::1", "[::1]x", "[::1%lo]:80"),
    *("[127.0.0.1]", "[localhost]"),
]
FOREIGN = [
    *("null", "http://evil.example", "http://127.0.0.1:1", "http://localhost:80", "file://127.0.0.1:80"),
    *("127.0.0.1:80", "http://127.0.0.1", "http://127.0.0.1:80/", "http://evil.example@127.0.0.1:80"),
    "http://127.0.0.1:80@evil.example",
]


def test_only_pages_of_this_server_are_answered():
    guard = Guard("127.0.0.1", 80)
    assert [each for each in OWN + OTHERS if not guard.refusal([each], [], needs_origin=False)] == OWN
    assert all(guard.refusal(hosts, [], needs_origin=False) for hosts in ([], OWN[:2]))
    host, right = ["127.0.0.1:80"], "http://127.0.0.1:80"
    assert not guard.refusal(host, [right], needs_origin=True)
    for origins in ([], [right, right], *([each] for each in FOREIGN)):
        assert guard.refusal(host, origins, needs_origin=True).startswith("Origin: not a page"), origins
        assert bool(guard.refusal(host, origins, needs_origin=False)) == bool(origins)


def test_beyond_loopback_the_machines_names_and_all_addresses_are_its_own():
    guard = Guard("Lab.example", 80)
    own = ["lab.example", "lab.example:80", "192.168.0.7:80", "[2001:db8::1]:80", socket.gethostname()]
    others = [
        "evil.example",
        *(f"lab.example{each}" for each in (":1", "/x", ":80@evil.example")),
        "x@lab.example",
    ]
    assert [each for each in own + others if not guard.refusal([each], [], needs_origin=False)] == own


def test_the_server_asks_its_guard(port):
    right, wrong = f"127.0.0.1:{port}", "evil.example"
    for host, origin, status in (
        (wrong, "", 403),
        (right, wrong, 403),
        (right, right, 400),
        (right, "", 403),
    ):
        more = f"Origin: http://{origin}\r\n" if origin else ""
        status_said, headers, text = said(port, f"POST /open HTTP/1.1\r\nHost: {host}\r\n{more}\r\n")
        assert (status_said, headers["Content-Type"]) == (status, "text/plain; charset=utf-8"), text
    assert said(port, f"GET / HTTP/1.1\r\nHost: {wrong}\r\n\r\n")[0] == 403


def test_an_error_of_the_program_does_not_end_the_server(caplog):
    def fails(error):
        def route(_):
            raise error

        return route

    errors = {"/bug": KeyError("x"), "/room": MemoryError(), "/told": FeasibeeError("told")}
    with serving_at({("GET", path): fails(each) for path, each in errors.items()}) as port:
        assert got(port, "/bug")[::2] == (500, "internal error of feasibee; see the terminal for details\n")
        for path, text in (("/room", "not enough memory; use fewer robots or tasks"), ("/told", "told")):
            status, _, answer = got(port, path)
            assert (status, json.loads(answer)) == (422, {"problems": [{"path": "", "text": text}]})
    assert caplog.text.count("internal error in answering a page") == 1


def test_only_so_many_requests_are_answered_at_once(monkeypatch):
    monkeypatch.setattr(serve, "WORKERS", 2)
    began, done = threading.Semaphore(0), threading.Event()

    def slow(_):
        began.release()
        return str(done.wait(60))

    with serving_at({("GET", "/"): slow}) as port:
        answers = []
        threads = [threading.Thread(target=lambda: answers.append(got(port)[0])) for _ in range(2)]
        for each in threads:
            each.start()
            assert began.acquire(timeout=60)
        assert got(port)[0] == 503
        done.set()
        for each in threads:
            each.join(60)
        assert answers == [200, 200]
        assert got(port)[0] == 200


@pytest.mark.parametrize("text", ["", "GET / HTTP/1.1\r\nHost: 127.0.0.1"])
def test_connections_that_never_ask_keep_no_page_out(text):
    with serving_at({("GET", "/"): lambda _: "a page"}) as port, ExitStack() as lines:
        for _ in range(300):
            lines.enter_context(silent(port, text))
        assert got(port)[2] == "a page\n"


BODY = "POST / HTTP/1.1\r\nHost: localhost\r\nOrigin: http://localhost\r\nContent-Length: 9\r\n\r\n12"


@pytest.mark.parametrize("text", ["", "GET / HTTP/1.1\r\nHost: localhost", BODY])
def test_a_connection_that_says_nothing_ends(text, monkeypatch):
    assert serve._Handler.timeout == serve.LIFETIME
    monkeypatch.setattr(serve._Handler, "timeout", 0.2)
    with serving_at({("POST", "/"): lambda _: "a page"}) as port, silent(port, text) as line:
        assert b"200" not in line.recv(999)


def test_a_port_that_is_taken(port):
    with pytest.raises(FeasibeeError, match=f"--port {port}: in use; use another, or leave --port out"):
        serve.listen("127.0.0.1", port)
    with serve.listen("127.0.0.1", None) as first, serve.listen("127.0.0.1", None) as second:
        assert first.getsockname()[1] != second.getsockname()[1]


@pytest.mark.parametrize(
    "host", ["", " ", "a b", "256.0.0.1", "[::1]", "127.0.0.1:80", "x@localhost", "\x00", "\ud800", "é" * 300]
)
def test_a_host_that_is_neither_address_nor_name_is_refused_in_a_line(host):
    with pytest.raises(FeasibeeError) as told:
        serve.listen(host, 0)
    line = str(told.value)
    assert line.startswith("--host = ")
    assert line.endswith("must be an address or a name of this machine; use 127.0.0.1, or leave it out")
    assert len(line) < 250


@pytest.mark.parametrize(
    ("host", "name"), [("0.0.0.0", "127.0.0.1"), ("::", "[::1]"), ("10.0.0.1", "10.0.0.1")]
)
def test_a_browser_of_this_machine_finds_the_page(host, name):
    assert serve.address_of(host, 8765) == f"http://{name}:8765/"


def test_only_loopback_is_loopback():
    own, others = ["127.0.0.1", "127.9.9.9", "::1", "LocalHost"], ["127.evil.example", "0.0.0.0", "::", "0"]
    assert [each for each in own + others if is_loopback(each)] == own


def test_what_the_command_refuses(tmp_path):
    cases = {
        "tasks.count = -1": ("--set", "tasks.count=-1"),
        "seed = -1": ("--seed", "-1"),
        "has no results": (tmp_path,),
        "--host 203.0.113.7 --port 8765: can't listen": ("--host", "203.0.113.7", "--no-open"),
        "use 10,000 or less": ("--set", "run.steps=10001"),
        "none: not found; name a scenario in TOML, or the folder of a sweep or field": (tmp_path / "none",),
    }
    for text, asked in cases.items():
        (line,) = commands.refused("watch", *asked)
        assert text in line


def test_ctrl_c_ends_it_at_once_whatever_pages_do():
    command = [sys.executable, "-m", "feasibee", "watch", "--no-open", "--port", "0"]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, start_new_session=os.name == "posix", **streams) as process:
        port = int(re.search(r":(\d+)/", process.stdout.readline())[1])
        with silent(port, "POST /open HTTP/1.1\r\n"):
            assert got(port)[0] == 200
            began = time.monotonic()
            process.send_signal(signal.SIGINT)
            assert process.wait(60) == 0
        assert time.monotonic() - began < serve.LIFETIME / 2
        assert process.stderr.read() == ""
