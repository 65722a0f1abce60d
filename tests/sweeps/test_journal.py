"""The journal of a sweep: what goes in comes out, one writes at a time, and damage is told in a line."""

from __future__ import annotations

import json
import os
import re
import sqlite3
import zlib
from contextlib import closing
from hashlib import sha256

import numpy as np
import pytest
from commands import output_of, python, refused_in_a_line
from journals import rows_in, write

from feasibee import FeasibeeError, Scenario, truth
from feasibee.model.codes import MODEL_VERSION
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.sweeps import schema
from feasibee.sweeps.journal import Journal, merge
from feasibee.sweeps.plan import DesignPoint, StoppingRule
from feasibee.sweeps.schema import FORMAT, LOCK, NAME, PLACES, SCHEMA, SEAL, Entry, Kind

SMALL = Scenario(arena={"side": 6.0}, robots={"count": 5}, tasks={"count": 3}, run={"steps": 40})
STRATEGY = """
def decide(mind, inbox):
    return inbox.heard_opinion
"""


def point(changes=None):
    return DesignPoint(changes or {}, SMALL.replace(changes or {}))


def rows_of(record):
    """Return what a journal must hold of a record."""
    runs = np.arange(record.first_run, record.first_run + record.runs)
    return np.column_stack([runs, record.decision, record.decision_step, *record.account.T])


def test_the_tables_are_those_of_their_format():
    """If this fails, journals on disk can't be read: raise FORMAT, and write down the new digest here."""
    assert (FORMAT, sha256(SCHEMA.encode()).hexdigest()[:16]) == (10, "2974c44b643ccabe")


def database(folder):
    return closing(sqlite3.connect(folder / NAME, isolation_level=None))


@pytest.fixture
def filled(tmp_path):
    """A folder with a journal of 30 runs."""
    with Journal(tmp_path, write=True) as journal:
        (number,) = journal.add([point()], 7)
        write(journal, [(number, simulate_record(SMALL, Runs(30, 7)))])
    return tmp_path


# --- Digests ---


def test_the_digest_of_a_point_is_that_of_all_its_fields_and_of_both_versions(monkeypatch):
    entry = Entry(1, "hash", "7", 1, "{}", "{}", None, None, None)
    others = Entry(2, "other", "8", 0, '{"a": 1}', '{"b": 2}', "{}", 1, "text")
    entries = [entry, *(entry._replace(**{name: value}) for name, value in others._asdict().items())]
    digests = [schema.digest_of_entry(each) for each in entries]
    for name in ("FORMAT", "MODEL_VERSION"):
        with monkeypatch.context() as patch:
            patch.setattr(schema, name, 99)
            digests.append(schema.digest_of_entry(entry))
    assert len(set(digests)) == len(digests)


def test_a_seal_whose_digest_is_another_says_nothing(tmp_path):
    schema.write_seal(tmp_path, 12)
    assert schema.read_seal(tmp_path) == 12
    text = (tmp_path / SEAL).read_text()
    (tmp_path / SEAL).write_text(text.replace("12", "13", 1))
    assert schema.read_seal(tmp_path) == 0


# --- In and out ---


def test_what_goes_in_comes_out(tmp_path):
    by_votes = {"decision.declare": {"quorum": 0.6, "rounds": 1, "heard": 1}}
    points = [point(), point({"tasks.count": 9}), point(by_votes)]
    with Journal(tmp_path, write=True) as journal:
        numbers = journal.add(points, 2**64 - 1)
        records = [simulate_record(each.scenario, Runs(8, 2**64 - 1, 3), curves=True) for each in points]
        write(journal, zip(numbers, records, strict=True))
    assert (records[2].declare_step >= 0).any()
    with Journal(tmp_path) as journal:
        for number, row, each, record in zip(numbers, journal.points, points, records, strict=True):
            expected = (number, each.scenario.hash, 2**64 - 1, each.values, each.scenario)
            assert (row.id, row.hash, row.seed, row.values, row.scenario) == expected
            assert row.truth == truth(each.scenario)
            np.testing.assert_array_equal(rows_in(journal, number), rows_of(record))
            for (run, *counts), k in zip(journal.curves(number), range(8), strict=True):
                assert run == 3 + k
                np.testing.assert_array_equal(counts, [record.feasible_count[k], record.infeasible_count[k]])


def test_a_chunk_that_fails_leaves_nothing(filled):
    def parts():
        yield 1, simulate_record(SMALL, Runs(5, 7, 30))
        raise KeyboardInterrupt

    with Journal(filled, write=True) as journal:
        with pytest.raises(KeyboardInterrupt):
            write(journal, parts())
        assert len(rows_in(journal, 1)) == 30
        write(journal, [(1, simulate_record(SMALL, Runs(5, 7, 30)))])
        assert len(rows_in(journal, 1)) == 35
        assert len(journal.entries()) == 1  # the totals are those of what was written


def test_what_is_missing(tmp_path):
    with Journal(tmp_path, write=True) as journal:
        (number,) = journal.add([point()], 0)
        assert journal.missing(number, 0, 10, False) == [(0, 10)]
        for first, runs, curves in ((2, 3, True), (5, 1, False), (8, 1, False)):
            write(journal, [(number, simulate_record(SMALL, Runs(runs, 0, first), curves=curves))])
        assert journal.missing(number, 0, 12, False) == [(0, 2), (6, 8), (9, 12)]
        assert journal.missing(number, 0, 9, False) == [(0, 2), (6, 8)]
        assert journal.missing(number, 0, 5, False) == [(0, 2)]
        assert journal.missing(number, 0, 12, True) == [(0, 2), (5, 12)]


def test_it_is_plain_sql(filled):
    with database(filled) as other:
        (runs,) = other.execute(
            "SELECT COUNT(*) FROM runs JOIN points ON point = id WHERE seed = '7' AND decision_step >= -1"
        ).fetchone()
        about = dict(other.execute("SELECT key, value FROM about"))
        ((text,),) = other.execute("SELECT scenario FROM points")
        (mode,) = other.execute("PRAGMA journal_mode").fetchone()
    assert runs == 30
    assert (int(about["format"]), int(about["model_version"])) == (FORMAT, MODEL_VERSION)
    assert json.loads(text) == SMALL.to_dict()  # the complete one
    assert mode == "wal"


# --- Keys ---


def test_scenarios_and_seeds_never_mix(tmp_path):
    with Journal(tmp_path, write=True) as journal:
        assert journal.add([point()], 0) == [1]
        assert journal.add([point({"tasks.count": 4}), point()], 0) == [2, 1]
        assert journal.add([point()], 1) == [3]
        assert journal.add([point({"robots.speed": 1.0})], 1) == [3]  # the default, and so the same scenario
        assert [row.values for row in journal.points] == [{}, {"tasks.count": 4}, {"robots.speed": 1.0}]


def test_a_strategys_text_is_kept_once_and_merged(tmp_path):
    own = tmp_path / "own.py"
    own.write_text(STRATEGY)
    points = [point({"tasks.count": count, "decision.strategy": str(own)}) for count in (2, 3)]
    (tmp_path / "other").mkdir()
    with Journal(tmp_path, write=True) as journal, Journal(tmp_path / "other", write=True) as other:
        journal.add([*points, point()], 0)
        merge(other, [tmp_path])
    for folder in (tmp_path, tmp_path / "other"):
        with database(folder) as opened:
            assert opened.execute("SELECT text FROM sources").fetchall() == [(STRATEGY,)]
            joined = "SELECT text FROM points LEFT JOIN sources ON sources.id = source ORDER BY points.id"
            assert opened.execute(joined).fetchall() == [(STRATEGY,), (STRATEGY,), (None,)]


def test_a_rule_that_chose_the_number_of_runs_stays(tmp_path):
    """What was looked at again and again stays so, when runs of a fixed number are added, or merged."""
    (tmp_path / "other").mkdir()
    with Journal(tmp_path, write=True) as journal, Journal(tmp_path / "other", write=True) as other:
        journal.add([point()], 0)
        assert journal.points[0].until is None
        journal.add([point()], 0, StoppingRule(0.1, None, 500))
        journal.add([point(), point({"tasks.count": 9})], 0)
        merge(other, [tmp_path])
        for each in (journal, other):
            rule = {"width": 0.1, "decided": None, "most": 500}
            assert [row.until for row in each.points] == [rule, None]


def test_taking_over_another_journal(filled, tmp_path):
    others = [tmp_path / "one", tmp_path / "two"]
    for number, other in enumerate(others):
        other.mkdir()
        with Journal(other, write=True) as journal:
            second, first = journal.add([point({"tasks.count": 9}), point()], 7)
            write(journal, [(first, simulate_record(SMALL, Runs(20, 7, 20 + 20 * number), curves=True))])
            write(journal, [(second, simulate_record(SMALL.replace({"tasks.count": 9}), Runs(5, 7)))])
    with Journal(filled, write=True) as journal:
        assert [merge(journal, [other]) for other in others for _ in range(2)] == [15, 0, 20, 0]
        assert [row.values for row in journal.points] == [{}, {"tasks.count": 9}]
        np.testing.assert_array_equal(rows_in(journal, 1), rows_of(simulate_record(SMALL, Runs(60, 7))))
        assert [run for run, *_ in journal.curves(1)] == list(range(20, 60))


# --- Journals that disagree ---


def other_journal(folder, statement=None, curves=False):
    """Make a journal with runs 20 to 39 of the point of ``filled``, one of them changed with its digest."""
    folder.mkdir()
    with Journal(folder, write=True) as journal:
        (number,) = journal.add([point()], 7)
        write(journal, [(number, simulate_record(SMALL, Runs(20, 7, 20), curves=curves))])
    if statement:
        with database(folder) as other:
            other.execute(statement)
            for kind in Kind:
                rows = other.execute(f"SELECT {kind.columns} FROM {kind.table} ORDER BY run").fetchall()
                digest = schema.digest_of_rows(kind, number, rows)
                other.execute("UPDATE chunks SET digest = ? WHERE kind = ?", (digest, kind))
    return folder


def state(folder):
    """Return all that a journal holds, but how many commits it has had."""
    with database(folder) as opened:
        tables = ("sources", "points", "chunks", "runs", "curves")
        return {table: opened.execute(f"SELECT * FROM {table}").fetchall() for table in tables}


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ("decision_step = decision_step + 7", r"decision_step is (\d+) in {0} and (\d+) in {1}"),
        ("bits_sent = bits_sent + 1", r"bits_sent is (\d+) in {0} and (\d+) in {1}"),
        ("decision = (decision + 2) % 3 - 1", r"decision is (-?\d) in {0} and (-?\d) in {1}"),
    ],
)
def test_a_run_that_differs_is_named_and_nothing_is_merged(filled, tmp_path, changed, named):
    """Also nothing of the parts before."""
    good, bad = (
        other_journal(tmp_path / "good"),
        other_journal(tmp_path / "bad", f"UPDATE runs SET {changed} WHERE run = 25"),
    )
    before = state(filled)
    line = refused_in_a_line("results", "merge", filled, good, bad)
    assert line.startswith("feasibee: point 1, seed 7, run 25: ")
    here, there = re.search(named.format(filled, bad), line).groups()
    assert int(here) == int(rows_in(Journal(filled), 1)[25, PLACES[changed.split()[0]]])
    assert here != there
    assert state(filled) == before
    assert f"{filled}/ has 40 runs" in output_of("results", "merge", filled, good)


def test_a_truth_that_differs_is_named(filled, tmp_path):
    other = other_journal(tmp_path / "other")
    with database(other) as opened:
        columns = "id, hash, seed, 1 - truth, vary, scenario, until, source, NULL"
        entry = Entry._make(opened.execute(f"SELECT {columns} FROM points").fetchone())
        digest = schema.digest_of_entry(entry)
        opened.execute("UPDATE points SET truth = 1 - truth, digest = ?", (digest,))
    rule = f"point 1, seed 7, its truth is 1 in {filled} and 0 in {other}, and only one can be right"
    with Journal(filled, write=True) as journal, pytest.raises(FeasibeeError, match=re.escape(rule)):
        merge(journal, [other])


def test_a_curve_that_differs_is_named(tmp_path):
    """Its bytes may: another zlib packs them otherwise."""
    good, bad = other_journal(tmp_path / "good", curves=True), tmp_path / "bad"
    other_journal(bad, curves=True)
    with database(bad) as other:
        ((blob,),) = other.execute("SELECT feasible FROM curves WHERE run = 25")
    counts = np.frombuffer(zlib.decompress(blob), "<i4").copy()
    for name, step, change in (("packed", 0, 0), ("worse", 17, 1)):
        counts[step] += change
        text = zlib.compress(counts.tobytes(), 1).hex()
        folder = other_journal(
            tmp_path / name, f"UPDATE curves SET feasible = x'{text}' WHERE run = 25", curves=True
        )
        with Journal(good, write=True) as journal:
            if change == 0:
                assert merge(journal, [folder]) == 0
                continue
            rule = f"run 25: the count of feasible opinions at step 17 is {counts[17] - 1} in {good} and "
            with pytest.raises(FeasibeeError, match=re.escape(f"{rule}{counts[17]} in {folder}")):
                merge(journal, [folder])


def test_what_is_computed_again_must_be_the_same(filled):
    """As when curves are asked for later."""
    record = simulate_record(SMALL, Runs(30, 7), curves=True)
    before = state(filled)
    with Journal(filled, write=True) as journal:
        record.account[3, 0] += 1
        with pytest.raises(FeasibeeError, match=r"run 3: bits_sent is \d+ in .* and \d+ in this sweep"):
            write(journal, [(1, record)])
        assert state(filled) == before
        record.account[3, 0] -= 1
        write(journal, [(1, record)])
        assert len(list(journal.curves(1))) == 30
        longer = simulate_record(SMALL, Runs(40, 7, 10))
        longer.account[3, 0] += 1  # also where only some of the runs are there
        with pytest.raises(FeasibeeError, match=r"run 13: bits_sent is \d+ in .* and \d+ in this sweep"):
            write(journal, [(1, longer)])


def test_a_missing_point_without_runs_is_damage(tmp_path):
    with Journal(tmp_path, write=True) as journal:
        journal.add([point(), point({"tasks.count": 9})], 7)
    with database(tmp_path) as other:
        other.execute("DELETE FROM points WHERE id = 2")
    with Journal(tmp_path) as journal, pytest.raises(FeasibeeError, match="damaged: points missing: 1; "):
        journal.entries()


# --- One writer ---


def test_a_writer_of_another_process_is_refused(filled):
    code = "import sys; from feasibee.sweeps.journal import Journal; Journal(sys.argv[1], write=True)"
    with Journal(filled, write=True):
        other = python("-c", code, filled)
    assert other.returncode == 1
    assert f"process {os.getpid()} writes here" in other.stderr
    assert python("-c", code, filled).returncode == 0


def test_a_journal_that_was_refused_lets_go(tmp_path):
    """Also of the lock, at once."""
    (tmp_path / NAME).write_text("garbage " * 1000)
    for _ in range(2):
        with pytest.raises(FeasibeeError, match="damaged"):
            Journal(tmp_path, write=True)
    (tmp_path / NAME).unlink()
    Journal(tmp_path, write=True).close()


# --- Damage ---


def refuse(folder, rule):
    """See that a folder's journal is refused, by a writer and by a reader, and isn't touched."""
    before = (folder / NAME).read_bytes()
    for writes in (True, False):
        with pytest.raises(FeasibeeError, match=rule) as caught:
            Journal(folder, writes)
        assert str(caught.value).startswith(str(folder))
        assert "\n" not in str(caught.value)
    assert (folder / NAME).read_bytes() == before


@pytest.mark.parametrize(
    ("key", "number", "rule"),
    [
        ("format", FORMAT + 1, f"format {FORMAT + 1}, this feasibee has {FORMAT}; install the newer"),
        ("format", FORMAT - 1, "choose another folder"),
        ("model_version", MODEL_VERSION + 1, "has model version .*; install the newer feasibee"),
        ("model_version", MODEL_VERSION - 1, "has model version .*; choose another folder"),
        ("model_version", "one", "isn't a journal of feasibee"),
    ],
)
def test_other_versions_are_refused(filled, key, number, rule):
    with database(filled) as other:
        about = dict(other.execute("SELECT key, value FROM about"))
        about[key] = str(number)
        about["digest"] = schema.digest_of_about(about)
        other.execute("DELETE FROM about")
        other.executemany("INSERT INTO about VALUES (?, ?)", about.items())
        other.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    refuse(filled, rule)


def test_a_journal_of_the_format_before_is_refused(tmp_path):
    """It had no digests, not even of its versions."""
    with database(tmp_path) as other:
        other.execute("CREATE TABLE about (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID")
        rows = [("format", "2"), ("model_version", str(MODEL_VERSION)), ("version", "0.1.0")]
        other.executemany("INSERT INTO about VALUES (?, ?)", rows)
    refuse(tmp_path, f"has format 2, this feasibee has {FORMAT}; choose another folder")


def test_any_other_database_or_an_empty_one_is_refused(tmp_path):
    """An empty one is a new journal to a writer: a process was killed before it had made the tables."""
    (tmp_path / NAME).touch()
    with pytest.raises(FeasibeeError, match="isn't a journal"):
        Journal(tmp_path)
    with database(tmp_path) as other:
        other.execute("CREATE TABLE photographs (id INTEGER)")
    refuse(tmp_path, "isn't a journal of feasibee; choose another folder")
    (tmp_path / NAME).write_bytes(b"")
    with Journal(tmp_path, write=True) as journal:
        assert journal.points == []


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder_is_told(filled):
    filled.chmod(0o555)
    try:
        with pytest.raises(FeasibeeError, match="choose a folder that you may write to"):
            Journal(filled, write=True)
    finally:
        filled.chmod(0o755)


def test_a_journal_in_a_read_only_folder_can_be_read(filled, monkeypatch):
    """SQLite would make files beside it."""
    (filled / LOCK).unlink()
    asked = []
    monkeypatch.setattr(os, "access", lambda path, mode: asked.append((path, mode)))
    with Journal(filled) as journal:
        assert len(rows_in(journal, 1)) == 30
        assert {path.name for path in filled.iterdir()} == {NAME, SEAL}
    assert asked == [(filled, os.W_OK)]


@pytest.mark.parametrize("name", [NAME, LOCK])
def test_a_folder_in_the_way_is_told(tmp_path, name):
    (tmp_path / name).mkdir()
    with pytest.raises(FeasibeeError, match="choose a folder that you may write to"):
        Journal(tmp_path, write=True)
