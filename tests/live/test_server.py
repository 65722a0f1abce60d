"""The live arena's server: it shows what `simulate` computes, and nothing that a page says breaks it."""

from __future__ import annotations

import asyncio
import socket
import time
from contextlib import ExitStack, suppress
from hashlib import sha256
from threading import Event

import commands
import numpy as np
import pytest
from journals import rows_in
from playing import swarm_at, swept
from serving import Page, serving_at
from starlette.responses import PlainTextResponse
from websockets.exceptions import ConnectionClosed, InvalidStatus

from feasibee import FeasibeeError, Scenario, Swarm, simulate
from feasibee.cli.watch import PICKS as OFFERED
from feasibee.cli.watch import _catalogue
from feasibee.live import guard, session
from feasibee.live import server as serving
from feasibee.live.catalogue import PICKS, Catalogue, read_catalogue
from feasibee.live.guard import Guard, check_host, is_loopback
from feasibee.live.prediction import prediction_of
from feasibee.simulation.snapshot import FLAGS
from feasibee.sweeps.journal import Journal
from feasibee.theory.predict import predict

pytestmark = pytest.mark.usefixtures("patient")

WORLDS = {
    "the paper's": {"tasks.count": 10},
    "beyond it": {
        "arena.boundary": "walls",
        "radio.loss": 0.3,
        "faults.stopped": 0.2,
        "faults.stop_step": 60,
    },
    "mixed": {
        "robots.classes": [{"name": "arm", "count": 9, "skills": ["lift"]}, {"name": "eye", "count": 4}],
        "tasks.classes": [{"name": "carry", "count": 3, "needs": {"lift": 2}}],
        "faults.byzantine": 0.1,
    },
    "of knowledge": {"decision.strategy": "census", "robots.count": 40},
    "without first opinions": {"decision.strategy": "cross-inhibition"},
}


@pytest.mark.parametrize("world", WORLDS)
def test_what_the_page_is_sent_is_what_simulate_computes(world):
    scenario = Scenario(run={"steps": 120}).replace(WORLDS[world])
    expected = simulate(scenario, 1, 7, first_run=3, curves=True)
    feasible, infeasible = [], []
    with serving_at(Catalogue(scenario, 7, 3)) as port, Page(port) as page:
        frame = page.open()
        for steps in (1, 1, 17, 100, 50):
            feasible += frame["feasibleCounts"].tolist()
            infeasible += frame["infeasibleCounts"].tolist()
            assert frame["first"] + frame["truths"].size == frame["step"] + 1 == len(feasible)
            assert frame["feasible"] == expected.feasible_count[0, frame["step"]]
            frame = page.answer("frame", type="advance", steps=steps)
        feasible += frame["feasibleCounts"].tolist()
        infeasible += frame["infeasibleCounts"].tolist()
    assert frame["step"] == 120  # and no further
    assert feasible == expected.feasible_count[0].values.tolist()
    assert infeasible == expected.infeasible_count[0].values.tolist()
    assert (frame["firstDecision"], frame["decisionStep"]) == (
        expected.decision[0],
        expected.decision_step[0],
    )
    assert frame["bits"] == expected.bits_sent[0]


@pytest.mark.parametrize("boundary", ["torus", "walls"])
def test_places_headings_and_marks_are_the_swarms(port, boundary):
    changes = {
        "arena.boundary": boundary,
        "faults.stopped": 0.2,
        "faults.byzantine": 0.2,
        "faults.stubborn": 0.1,
        "arena.side": [30.0, 18.0],
    }
    swarm = swarm_at(30, Scenario().replace(changes), 1, 5)
    with Page(port) as page:
        tasks = page.answer("tasks", type="open", changes=changes, run=5, step=30)
        frame = page.until("frame")
    pixel = 30 / 65536
    assert np.abs(np.stack([frame["x"], frame["y"]], 1) * pixel - swarm.positions).max() <= pixel
    assert np.abs(np.stack([tasks["x"], tasks["y"]], 1) * pixel - swarm.tasks).max() <= pixel
    turned = np.exp(1j * (frame["heading"] * np.pi / 128 - swarm.headings))
    assert np.abs(np.angle(turned)).max() <= np.pi / 250
    flags = {name: (frame["flags"] >> bit & 1).astype(bool) for bit, name in enumerate(FLAGS)}
    assert (flags["feasible"] == (swarm.opinions == 1)).all()
    assert (flags["disseminating"] == swarm.disseminating).all()
    assert (flags["working"] & ~flags["byzantine"] == swarm.counted).all()
    assert [flags[name].sum() for name in ("working", "byzantine", "stubborn")] == [16, 4, 2]
    assert (frame["counted"], frame["disseminating"], frame["working"]) == (12, swarm.disseminating.sum(), 16)


def test_the_theory_says_what_to_expect_of_each_swarm(port):
    changes = {"tasks.count": 10}
    with Page(port) as page:
        page.answer("frame", type="open", changes=changes, against="census")
        page.until("frame")
        first = page.answer("predicted", type="predict")
        second = page.answer("predicted", type="predict", lane=1)
    found = predict(Scenario().replace(changes))
    assert first["opinions"][-1] == found.opinions[-1].round(3).tolist()
    assert np.allclose(first["opinions"], found.opinions[: len(first["opinions"])], atol=0.001)
    assert first["tips"] == round(found.tipping.point, 3)
    assert (first["lane"], first["tasks"], second["lane"]) == (0, 20, 1)
    assert f"{100 * found.feasible:.0f} % of such swarms decide feasible" in first["text"]
    assert second["text"].startswith("No predicted curve: decision.strategy = 'census': the theory doesn't")
    assert "opinions" not in second


def test_the_swarm_goes_on_while_the_theory_is_computed(port, monkeypatch):
    done = Event()
    monkeypatch.setattr(session, "prediction_of", lambda _: {"text": str(done.wait(60))})
    with Page(port) as page:
        page.open()
        page.say(type="predict")
        assert page.answer("frame", type="advance", steps=3)["step"] == 3
        page.say(type="predict", lane=1)
        done.set()
        assert page.until("predicted")["text"] == "True"
        assert page.until("error")["problems"][0]["text"].startswith("message: no swarm 1 is open")


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"robots.count": 201}, "robots.count = 201: pages predict up to 200 robots"),
        ({"arena.boundary": "walls"}, "arena.boundary = 'walls': the theory doesn't cover it"),
    ],
)
def test_beyond_reach_the_page_says_why(changes, text):
    found = prediction_of(Scenario().replace(changes))
    assert found["text"].startswith(f"No predicted curve: {text}; ")
    assert list(found) == ["text"]


def test_a_prediction_is_short_however_long_a_run_may_be():
    found = prediction_of(Scenario(run={"steps": 10**9}))
    assert "by step 10,000, " in found["text"]
    assert len(found["opinions"]) < 1000


def test_headings_are_where_robots_go():
    swarm = Swarm(Scenario(walk={"mean_run": 1e6}), seed=2)
    before, headings = swarm.positions, swarm.headings
    swarm.advance()
    moved = (swarm.positions - before + 10) % 20 - 10
    assert np.allclose(np.stack([np.cos(headings), np.sin(headings)], 1), moved, atol=1e-6)


def test_a_page_that_wants_another_run_doesnt_wait_for_a_far_step(port, monkeypatch):
    monkeypatch.setattr(serving, "PATIENCE", 0.05)
    with Page(port) as page:
        changes = {"robots.count": 2000, "run.steps": 200_000}
        page.answer("going", type="open", changes=changes, step=200_000)
        frame = page.open(changes={"robots.count": 3})
        while frame["robots"] != 3:
            frame = page.receive()
        assert frame["step"] == 0


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    tables = {
        "runs": 30,
        "seed": 5,
        "scenario": {"run": {"steps": 130}},
        "sweep": {"tasks.count": [16, 24], "radio.loss": [0.0, 0.2]},
    }
    return swept(tables, folder)


def test_the_runs_that_decided_wrong_are_replayed_as_they_were(results):
    catalogue = read_catalogue(results, "wrong")
    with Journal(results) as journal:
        wrong = {
            (row.id, run): (decision, step)
            for row in journal.points
            for run, decision, step in rows_in(journal, row.id)[:, :3].tolist()
            if decision not in (-1, int(row.truth))
        }
    assert catalogue.found == len(wrong) > 5
    with serving_at(catalogue) as port, Page(port) as page:
        listed = page.welcome["replays"]
        assert {(each["point"], int(each["run"])) for each in listed} == set(wrong)
        for each in listed[:: len(listed) // 5]:
            frame = page.open(
                point=each["point"], seed=each["seed"], run=each["run"], step=each["decision_step"]
            )
            assert (frame["firstDecision"], frame["decisionStep"]) == wrong[each["point"], int(each["run"])]
            assert frame["step"] == each["decision_step"]
            assert frame["decision"] == frame["firstDecision"]


def test_a_long_list_has_as_many_runs_of_each_point(results, monkeypatch):
    monkeypatch.setattr("feasibee.live.catalogue.LISTED", 10)
    catalogue = read_catalogue(results, "all")
    assert catalogue.found > 10
    with Journal(results) as journal:
        expected = {row.id: [0, 1] for row in journal.points}  # four points: ten runs are two of each
    listed = {point: [each.run for each in catalogue.replays if each.point == point] for point in expected}
    assert listed == expected


def test_every_pick_is_offered_and_they_share_out_the_runs(results):
    assert OFFERED == PICKS
    with Journal(results) as journal:
        assert any((rows_in(journal, row.id)[:, 1] == -1).any() for row in journal.points)
    found = {}
    for pick in PICKS:
        try:
            found[pick] = read_catalogue(results, pick).found
        except FeasibeeError as error:
            assert f"has no runs that are {pick}; use another --pick" in str(error)  # noqa: PT017
            found[pick] = 0
    assert found["all"] == 120 == found["wrong"] + found["right"] + found["undecided"]
    assert found["all"] == found["feasible"] + found["infeasible"] + found["undecided"]


OWN = """def decide(mind, inbox):
    return mind.opinion
"""


def test_the_values_of_a_sweep_have_metres_and_seconds_if_its_scenario_has_them(tmp_path):
    scenario = {"units": {"metres": 0.5, "seconds": 2.0}, "tasks": {"count": 3}}
    fields = {"sensing.range": ["1.5 m"], "run.steps": [30], "radio.loss": [0.5]}
    (replay,) = read_catalogue(
        swept({"runs": 1, "scenario": scenario, "sweep": fields}, tmp_path), "all"
    ).to_dict()["replays"]
    assert replay["values"] == {
        "sensing.range": "3.0 (1.5 m)",
        "run.steps": "30 (1 min)",
        "radio.loss": "0.5",
    }


@pytest.fixture
def own_sweep(tmp_path):
    """A sweep of a strategy in a file, and that file."""
    file = tmp_path / "mine.py"
    file.write_text(OWN)
    tables = {"runs": 3, "scenario": {"run": {"steps": 10}, "decision": {"strategy": "mine.py"}}}
    return swept(tables, tmp_path), file


def test_a_strategys_text_of_a_journal_is_replayed_if_it_is_the_users_own_or_trusted(own_sweep):
    folder, file = own_sweep
    catalogue = read_catalogue(folder, "all")
    assert str(file) in catalogue.strategies
    with serving_at(catalogue) as port, Page(port) as page:
        assert page.open(changes={"decision.strategy": str(file)})["step"] == 0
    file.write_text(f"X = 1 / 0\n{OWN}")
    catalogue = read_catalogue(folder, "all")
    assert catalogue.scenario_of(None).manifest.source == OWN
    with serving_at(catalogue) as port, Page(port) as page:
        told = page.answer("error", type="open")["problems"][0]["text"]
        assert "isn't that of a file of yours" in told
        assert "--trust" in told
        assert page.open(changes={"decision.strategy": "dmmd"})["step"] == 0
    with serving_at(read_catalogue(folder, "all", trust=True)) as port, Page(port) as page:
        assert page.open(changes={"decision.strategy": str(file)})["step"] == 0
        page.open(changes={"tasks.count": 30})


def test_watch_names_the_texts_that_are_not_the_users_own(own_sweep, capsys):
    folder, file = own_sweep
    _catalogue(folder, (), None, None, "all", False)
    assert capsys.readouterr().err == ""
    file.unlink()
    digest = sha256(OWN.encode()).hexdigest()
    told = {False: "isn't replayed without --trust", True: "runs from the text in the journal"}
    for trust, what in told.items():
        _catalogue(folder, (), None, None, "all", trust)
        assert capsys.readouterr().err == f"feasibee: {file}, SHA-256 {digest}: {what}\n"


def test_a_strategy_that_fails_in_a_run_is_an_error_and_the_page_goes_on(tmp_path):
    file = tmp_path / "mine.py"
    quality = "def quality(robots_seen, tasks_seen):\n    return 1.0 / (robots_seen - 4.0) ** 2 / 9.0\n"
    file.write_text(quality + OWN)
    with serving_at(Catalogue(Scenario(decision={"strategy": str(file)}))) as port, Page(port) as page:
        page.open()
        told = page.answer("error", type="advance", steps=1000)["problems"][0]["text"]
        assert told.startswith("mine.py, line 2: quality(4, ")
        assert "fails: ZeroDivisionError" in told
        assert page.open(changes={"decision.strategy": "dmmd"})["step"] == 0


def test_an_error_of_the_program_ends_neither_page_nor_server(port, monkeypatch, caplog):
    with Page(port) as page:
        monkeypatch.setattr(serving.Session, "begin", lambda *_: {}["nothing"])
        assert page.problems(type="open") == [""]
        monkeypatch.undo()
        assert page.open()["step"] == 0
    assert "internal error in answering a page" in caplog.text


def test_an_answer_repeats_the_number_of_its_request(port):
    with Page(port) as page:
        assert page.answer("opened", type="open", request=7)["request"] == 7
        assert [page.receive()["type"] for _ in range(2)] == ["tasks", "frame"]
        told = page.answer("error", type="open", request=8, changes={"robots.count": -1})
        assert told["request"] == 8
        assert page.answer("error", type="inspect", robot=99)["request"] is None


WRONG = {
    "not JSON": "{",
    "no text": "",
    "a list": "[]",
    "no type": "{}",
    "another type": '{"type": "format"}',
    "more than asked": '{"type": "advance", "steps": 1, "path": "/etc/passwd"}',
    "text for a number": '{"type": "advance", "steps": "1"}',
    "no steps": '{"type": "advance", "steps": 0}',
    "NaN": '{"type": "advance", "steps": NaN}',
    "a step that never was": '{"type": "open", "step": -1}',
    "a bit": '{"type": "open", "seed": true}',
    "too deep": '{"type": "open", "changes": {"a.b": ' + "[" * 3000 + "]" * 3000 + "}}",
    "bytes": b"\x00\xff\x17",
    "a seek to nowhere": '{"type": "seek", "to": "the end", "jump": 1}',
    "a seek back beyond the start": '{"type": "seek", "to": -1, "jump": 1}',
    "a seek without a number": '{"type": "seek", "to": 1}',
    "a seek with too large a number": '{"type": "seek", "to": 1, "jump": 256}',
    "a third swarm": '{"type": "look", "lane": 2}',
    "a swarm that is not there": '{"type": "look", "lane": 1}',
    "the decision of one that is not there": '{"type": "seek", "to": "decision", "lane": 1, "jump": 1}',
    "a robot that is not there": '{"type": "inspect", "robot": 20}',
    "a robot before the first": '{"type": "look", "robot": -1}',
    "half a robot": '{"type": "inspect", "robot": 0.5}',
    "half a character": '{"type": "open", "changes": {"decision.strategy": "\\ud800"}}',
}


@pytest.mark.quick(6)
@pytest.mark.parametrize("what", WRONG)
def test_nonsense_gets_an_error_and_the_swarm_goes_on(port, what):
    with Page(port) as page:
        page.open()
        page.socket.send(WRONG[what])
        answer = page.receive()
        assert answer["type"] == "error", answer
        assert answer["problems"][0]["text"]
        assert page.answer("frame", type="advance", steps=2)["step"] == 2


REFUSED = {
    "robots.count": [0, -1, 1.5, "many", None, 10**9, 20_001, 10**30, float("nan"), float("inf"), [], {}],
    "tasks.count": [-1, 20_001, True],
    "radio.loss": [1.01, float("nan"), "a lot"],
    "robots.points": ["/etc/passwd", "points.csv"],
    "tasks.points": ["/dev/zero", "points.csv", '"/etc/passwd"', "[[1]]", "[[1, 2], 3]"],
    "place.map": ["/etc/passwd", "hall.yaml"],
    "place.keepout": ["/dev/zero"],
    "place.zones": [{"dock": "/etc/passwd"}],
    "place.zones.dock": ["/etc/passwd"],
    "decision.strategy": ["/tmp/evil.py", "../mine.py", "os", "", 3, ["dmmd"]],
    "decision.listen": ["{last = 0}", "{last = ", "[1]", "never"],
    "decision.declare": ["{quorum = 2}", "yes", "[1, 2"],
    "decision.parameters": ["{nothing = 1}", "x"],
    "arena.side": ["[1, 2, 3]", "wide", "-1"],
    "robots": [{"points": "/etc/passwd"}],
    "decision": [{"strategy": "/tmp/evil.py"}],
    "a": [1],
    "tasks.": [1],
    "robots.classes": [2, "x", "3", '[{name = "x"}]', "[" * 500],
    "preset": ["none", 3, "mine"],
    "seed": [-1, "x", 1.5, str(2**64), "9" * 1000],
    "run": ["-1", 2**32, 0.5],
}


@pytest.mark.parametrize("path", REFUSED)
def test_a_wrong_value_is_refused_at_its_control_and_the_swarm_goes_on(port, path):
    with Page(port) as page:
        page.open()
        for value in REFUSED[path]:
            asked = {path: value} if path in ("seed", "run") else {"changes": {path: value}}
            paths = page.problems(type="open", **asked)
            assert paths[0].startswith(path), (value, paths)
        assert page.answer("frame", type="advance", steps=2)["step"] == 2


def test_a_page_may_name_no_file(port):
    """Not even one that is a map: whoever opens the page would learn what is on this machine."""
    wrong = {
        path: REFUSED[path][0]
        for path in REFUSED
        if path.startswith(("place.", "tasks.points", "robots.points"))
    }
    with Page(port) as page:
        page.open()
        for path, value in wrong.items():
            problems = page.answer("error", type="open", changes={path: value})["problems"]
            assert "can't be a file on this page" in problems[0]["text"], path


def test_all_problems_are_told_at_once(port):
    with Page(port) as page:
        changes = {"robots.count": -1, "radio.loss": 2, "decision.strategy": "/tmp/evil.py"}
        assert set(page.problems(type="open", seed="x", changes=changes)) == {*changes, "seed"}


def test_no_code_is_loaded_that_a_page_names(port, tmp_path):
    file = tmp_path / "evil.py"
    file.write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\n")
    with Page(port) as page:
        page.problems(type="open", changes={"decision.strategy": str(file)})
        page.problems(type="open", changes={"decision": {"strategy": str(file)}})
    assert not (tmp_path / "ran").exists()


def test_a_swarm_that_takes_too_much_room_is_refused(port):
    with Page(port) as page:
        changes = {"robots.count": 20_000, "decision.strategy": "tally"}
        assert page.answer("error", type="open", changes=changes)["problems"]
        assert page.open()["step"] == 0


def test_a_point_of_no_sweep_and_an_advance_before_the_swarm_are_errors(port):
    with Page(port) as page:
        assert page.problems(type="open", point=3) == [""]
        assert page.problems(type="advance", steps=1) == [""]


def test_a_message_that_is_too_large_ends_that_page_only(port):
    with Page(port) as page, Page(port) as other:
        page.socket.send(" " * 20_000)
        with pytest.raises(ConnectionClosed) as closed:
            page.receive()
        assert closed.value.rcvd.code == 1009
        assert other.open()["step"] == 0


def test_only_so_many_pages(monkeypatch):
    monkeypatch.setattr(serving, "SESSIONS_LIMIT", 2)
    with serving_at(Catalogue(Scenario())) as port:
        with Page(port), Page(port) as second:
            with Page(port) as third:
                assert third.welcome["type"] == "full"
                with pytest.raises(ConnectionClosed) as closed:
                    third.receive()
                assert closed.value.rcvd.code == 1013
            assert second.open()["step"] == 0
        kind, end = "full", time.monotonic() + 60
        while kind == "full" and time.monotonic() < end:  # until the server has seen that they are gone
            with Page(port) as fourth:
                kind = fourth.welcome["type"]
        assert kind == "welcome"


@pytest.mark.parametrize(
    "origin",
    [
        None,
        "null",
        "http://evil.example",
        "http://127.0.0.1:1",
        "http://localhost:{port}",
        "file://127.0.0.1:{port}",
        "127.0.0.1:{port}",
        "http://127.0.0.1",
        "http://127.0.0.1:{port}/",
        "http://evil.example@127.0.0.1:{port}",
        "http://127.0.0.1:{port}@evil.example",
    ],
)
def test_pages_of_others_are_refused(port, origin):
    origin = origin and origin.format(port=port)
    with pytest.raises(InvalidStatus) as refused, Page(port, origin=origin):
        pass
    assert refused.value.response.status_code == 403


def asked(port, host, path="/", *lines):
    """Return what the server says to a plain request, header by header."""
    text = "\r\n".join([f"GET {path} HTTP/1.1", f"Host: {host}", "Connection: close", *lines, "", ""])
    with socket.create_connection(("127.0.0.1", port)) as line:
        line.sendall(text.encode())
        received = b""
        while more := line.recv(65536):
            received += more
    return received.decode("utf-8", "replace")


@pytest.mark.parametrize(
    "host",
    [
        *("evil.example", "evil.example:{port}", "192.168.0.7", "[", "", "127.0.0.1.evil.example"),
        *("evil.example@127.0.0.1", "evil.example@127.0.0.1:{port}", "localhost@localhost"),
        *("127.0.0.1/x", "127.0.0.1:{port}/x", "127.0.0.1?x", "127.0.0.1#x", "127.0.0.1\\x", "//127.0.0.1"),
        *("127.0.0.1:abc", "127.0.0.1:", "127.0.0.1:1", "127.0.0.1:0{port}", "127.0.0.1:+{port}"),
        *("127.0.0.1:{port}:{port}", "127.0.0.1:{port},evil.example", "127.0.0.1 evil.example"),
        *("127.1", "127.0.0.01", "2130706433", "0x7f000001", "localhost.", "\uff4cocalhost", "localhost%00"),
        *("::1", "[::1", "[::1]x", "[::1%lo]:{port}", "[127.0.0.1]", "[localhost]"),
    ],
)
def test_names_of_others_are_refused(port, host):
    answer = asked(port, host.format(port=port))
    assert answer.startswith("HTTP/1.1 403"), answer
    lines = [*UPGRADE.splitlines(), f"Origin: http://{host}"]
    assert asked(port, host, "/swarm", *lines).split()[1] in ("403", "400")


@pytest.mark.parametrize("host", ["127.0.0.1:{port}", "localhost:{port}", "[::1]:{port}", "LOCALHOST"])
def test_own_names_get_the_page_with_strict_headers(port, host):
    answer = asked(port, host.format(port=port))
    assert answer.startswith("HTTP/1.1 200")
    assert "default-src 'none'; script-src 'self'" in answer
    assert "x-content-type-options: nosniff" in answer.lower()


def test_beyond_loopback_the_machines_names_and_all_addresses_are_its_own():
    own = ("lab.example", "lab.example:8765", "192.168.0.7:8765", "[2001:db8::1]:8765", socket.gethostname())
    assert {answered_beyond_loopback(name) for name in own} == {200}
    wrong = ("x@lab.example", "lab.example:1", "lab.example/x", "lab.example:8765@evil.example")
    others = ("evil.example", *wrong)
    assert {answered_beyond_loopback(name) for name in others} == {403}


def answered_beyond_loopback(name):
    """Return the status for a Host, of a server that listens on lab.example, port 8765."""
    statuses = []

    async def send(message):
        statuses.append(message.get("status"))

    scope = {"type": "http", "headers": [(b"host", name.encode())], "server": ("192.168.0.7", 8765)}
    asyncio.run(Guard(PlainTextResponse("a page"), "Lab.example")(scope, None, send))
    return statuses[0]


def expect_another_page(port):
    """Expect that the server gives another page its file and its swarm."""
    assert asked(port, f"127.0.0.1:{port}").startswith("HTTP/1.1 200")
    with Page(port) as page:
        assert page.open()["step"] == 0


def silent(port, count, text=b""):
    lines = [socket.create_connection(("127.0.0.1", port)) for _ in range(count)]
    for line in lines:
        line.sendall(text)
    return lines


@pytest.mark.parametrize("text", [b"", b"GET / HTTP/1.1\r\nHost: 127.0.0.1"])
def test_connections_that_never_ask_for_anything_keep_no_page_out(port, text, monkeypatch):
    monkeypatch.setattr(guard, "LIFETIME", 600.0)  # they end because of newer ones
    with Page(port) as page, ExitStack() as lines:
        for line in silent(port, 400, text):
            lines.enter_context(line)
        expect_another_page(port)
        assert page.open()["step"] == 0  # nor do they end one


UPGRADE = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
UPGRADE += "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
HEADERS = "X: y\r\n" * 300
UNFINISHED = {
    "nothing": "",
    "half a request": "GET / HTTP/1.1\r\nHost: localhost",
    "a page and no more": "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
    "a body that is announced": "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n",
    "an upgrade with a body": f"GET /swarm HTTP/1.1\r\nHost: localhost\r\n{UPGRADE}Content-Length: 9\r\n\r\n",
    "an upgrade of 300 lines": f"GET /swarm HTTP/1.1\r\nHost: localhost\r\n{UPGRADE}{HEADERS}\r\n",
}


@pytest.mark.quick(2)
@pytest.mark.parametrize("what", UNFINISHED)
def test_a_connection_that_asks_for_nothing_whole_ends_and_a_page_goes_on(what, monkeypatch):
    monkeypatch.setattr(guard, "LIFETIME", 0.5)
    with serving_at(Catalogue(Scenario())) as port, Page(port) as page:
        (line,) = silent(port, 1, UNFINISHED[what].encode())
        with line:
            line.settimeout(0.1)
            end = time.monotonic() + 60
            with suppress(ConnectionError):
                while time.monotonic() < end:
                    with suppress(TimeoutError):
                        if not line.recv(65536):
                            break
                    line.sendall(b"x")  # one byte now and then: no sign of life
            assert time.monotonic() < end
        assert page.open()["step"] == 0


@pytest.mark.slow
def test_malformed_requests_leave_a_line_in_the_terminal_at_most(capfd):
    upgrade = b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: h2c\r\nConnection: Upgrade\r\n\r\n"
    chunked = b"POST / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n"
    with serving_at(Catalogue(Scenario())) as port:
        for text in (b"\x00\xff\r\n\r\n", upgrade, chunked):
            for line in silent(port, 100, text):
                with line, suppress(ConnectionError):
                    line.recv(100)
        expect_another_page(port)
    told = capfd.readouterr().err
    assert told.count("Exception in ASGI application") <= 1
    assert "Invalid HTTP" not in told
    assert "Unsupported" not in told


def test_nothing_but_the_page_is_served(port):
    above = ("/../server.py", "/..%2fserver.py", "/%2e%2e/server.py")
    for path in (*above, "/static/", "/swarm", "//etc/passwd"):
        assert asked(port, "localhost", path).split()[1] in ("404", "400", "403"), path


def test_the_page_takes_nothing_from_elsewhere_and_writes_no_markup():
    for path in serving.STATIC.glob("*.*"):
        text = path.read_text()
        own = text.replace("http://www.w3.org/2000/svg", "")
        assert "http://" not in own, path
        assert "https://" not in own, path
        assert not any(word in text for word in ("innerHTML", "outerHTML", "insertAdjacentHTML", "eval(")), (
            path
        )
        assert " style=" not in text, path


def test_a_port_that_is_taken(port):
    with pytest.raises(FeasibeeError, match=f"--port {port}: in use; use another, or leave --port out"):
        serving.listen("127.0.0.1", port)
    with serving.listen("127.0.0.1", None) as first, serving.listen("127.0.0.1", None) as second:
        assert first.getsockname()[1] != second.getsockname()[1]


@pytest.mark.parametrize(
    "host",
    [
        *("", " ", "a b", "0", "1.2", "127.1", "0x7f000001", "256.0.0.1", "1.2.3.4.5"),
        *("[::1]", "::1%lo", "::x", "*", "-x", "a..b", ".", "<broadcast>"),
        *("127.0.0.1:80", "http://localhost", "localhost/x", "x@localhost"),
        *("localhost\n", "\x00", "\ud800", "é" * 300, "a" * 64, "a." * 200 + "a"),
    ],
)
def test_a_host_that_is_neither_address_nor_name_is_refused_in_a_line(host):
    line = refused("--host", host, "--no-open")
    assert line.startswith("feasibee: --host = "), line
    assert line.endswith("must be an address or a name of this machine; use 127.0.0.1, or leave it out\n")
    assert line.count("\n") == 1
    assert len(line) < 250


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "::1", "0.0.0.0", "::", "localhost", "LocalHost", "lab-7.example", "3d"]
)
def test_a_host_may_be_an_address_or_a_name(host):
    check_host(host)


def test_a_name_that_begins_as_a_loopback_address_is_not_this_machine_only():
    own, others = ("127.0.0.1", "127.9.9.9", "::1", "LocalHost"), ("127.evil.example", "0.0.0.0", "::")
    assert [each for each in (*own, *others) if is_loopback(each)] == [*own]


def refused(*arguments):
    result = commands.invoke("watch", *arguments)
    assert result.exit_code == 2, result.output
    return result.stderr


def test_what_the_command_refuses(results, tmp_path):
    assert "tasks.count = -1" in refused("--set", "tasks.count=-1")
    assert "seed = -1" in refused("--seed", "-1")
    assert "no journal.sqlite" in refused(tmp_path)
    assert "leave out --set, --seed and --run" in refused(results, "--seed", "3")
    assert "--host 203.0.113.7" in refused("--host", "203.0.113.7", "--no-open")
