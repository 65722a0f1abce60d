"""Damaged journals: each gives what it gave before, or is refused in a line; a sweep mends what it can."""

from __future__ import annotations

import json
import os
import sqlite3
from collections import Counter
from contextlib import closing

import pytest
from commands import refused_in_a_line

from claims.measure.damages import KINDS, LOG, RUNS, copied, export, invoke, keep_journals, try_damages
from feasibee import FeasibeeError
from feasibee.sweeps import schema
from feasibee.sweeps.journal import RESCUE, Journal
from feasibee.sweeps.schema import NAME, SEAL, Entry


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A folder with a study, and its journal as some moments leave it."""
    folder = tmp_path_factory.mktemp("kept")
    keep_journals(folder)
    return folder


@pytest.fixture(scope="module")
def table(kept):
    """What an export gives."""
    tables = [export(copied(kept, kind, kept / "export")) for kind in KINDS]
    assert len(set(tables)) == 1
    assert tables[0].count(b"\n") == RUNS + 1
    return tables[0]


@pytest.fixture
def folder(kept, tmp_path):
    return copied(kept, "closed", tmp_path / "out")


def change(folder, *statements):
    """Change a journal by SQL, past its constraints."""
    with closing(sqlite3.connect(folder / NAME, isolation_level=None)) as database:
        database.execute("PRAGMA ignore_check_constraints = ON")
        for statement in statements:
            assert database.execute(statement).rowcount != 0, statement
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")


def swept(kept, folder):
    """Run the study's sweep again; return how many runs were computed, and what was told of the damage."""
    result = invoke("sweep", kept / "study.toml", "--out", folder, "--workers", 1)
    assert result.exit_code == 0, result.output
    return int(result.stdout.split()[0]), result.stderr


# --- At random ---


@pytest.mark.slow
def test_no_random_damage_changes_an_export(kept, table, tmp_path):
    """And a sweep mends all but what is damaged as a whole."""
    mended = Counter()

    def each(folder, is_refused):
        status = invoke("results", "status", folder, "--json")
        assert status.exit_code == 2 or not is_refused
        if status.exit_code == 0:
            assert sum(point["runs"] for point in json.loads(status.stdout)) == RUNS
        again = invoke("sweep", kept / "study.toml", "--out", folder, "--workers", 1)
        mended[again.exit_code] += 1
        if again.exit_code == 0:
            assert export(folder) == table
        else:
            assert is_refused
            (line,) = again.stderr.splitlines()
            assert "damaged as a whole" in line

    found = try_damages(kept, tmp_path / "out", 200, 2, each)
    assert found["another"] == 0
    assert min(found["same"], found["refused"]) > 200 / 6
    assert mended[0] > 0.8 * sum(mended.values())


# --- One by one ---

DAMAGES = {
    "a decision": ("UPDATE runs SET decision = 1 - decision WHERE point = 3 AND run = 9 AND decision >= 0",),
    "a step": ("UPDATE runs SET decision_step = decision_step + 1 WHERE point = 3 AND run = 9",),
    "a missing run": ("DELETE FROM runs WHERE point = 3 AND run = 9",),
    "a run too many": (
        "INSERT INTO runs VALUES (3, 99, 1, 5, 0, -1, 0, 0, 0, 0, 0, 0, -1, -1, 0, 0, 0, 0, -1)",
    ),
    "a run of another point": ("UPDATE runs SET point = 4, run = 77 WHERE point = 3 AND run = 9",),
    "a curve": (
        "UPDATE curves SET feasible = infeasible, infeasible = feasible WHERE point = 3 AND run = 9",
    ),
    "a missing curve": ("DELETE FROM curves WHERE point = 3 AND run = 9",),
    "a missing chunk": ("DELETE FROM chunks WHERE point = 3 AND kind = 0 AND first_run = 9",),
    "a chunk with its runs": (
        "DELETE FROM chunks WHERE point = 3 AND kind = 0 AND first_run = 9",
        "DELETE FROM runs WHERE point = 3 AND run BETWEEN 9 AND 11",
    ),
    "the first run of a chunk": (
        "UPDATE chunks SET first_run = 22 WHERE point = 3 AND kind = 0 AND first_run = 21",
    ),
    "a truth": ("UPDATE points SET truth = 1 - truth WHERE id = 3",),
    "what is varied": ("UPDATE points SET vary = replace(vary, 'own', 'our') WHERE id = 3",),
    "a scenario": (
        "UPDATE points SET scenario = replace(scenario, '\"steps\": 40', '\"steps\": 41') WHERE id = 3",
    ),
    "a seed": ("UPDATE points SET seed = '6' WHERE id = 3",),
    "a missing point": ("DELETE FROM points WHERE id = 3",),
    "a point too many": (
        "INSERT INTO points SELECT 44, 'x' || hash, seed, truth, vary, scenario, source, until, digest"
        " FROM points WHERE id = 3",
    ),
    "a strategy's text": ("UPDATE sources SET text = text || ' '",),
    "a version": ("UPDATE about SET value = '9' WHERE key = 'model_version'",),
    "the number of commits": ("UPDATE about SET value = value - 1 WHERE key = 'commits'",),
}
DAMAGES |= {
    f"{name} of two points, swapped with their digests": tuple(
        f"UPDATE {table} SET point = {new} WHERE point = {old} {condition}"
        for old, new in ((3, 99), (4, 3), (99, 4))
        for table, condition in ((name, ""), ("chunks", f"AND kind = {kind}"))
    )
    for kind, name in enumerate(("runs", "curves"))
}
HARMLESS = ("a curve", "a missing curve", "curves of two points, swapped with their digests")
"""To an export, which has no curves."""


@pytest.mark.quick(5)
@pytest.mark.parametrize("what", DAMAGES)
def test_each_damage_is_refused_and_mended(kept, table, folder, what):
    change(folder, *DAMAGES[what])
    if what in HARMLESS:
        assert export(folder) == table
    else:
        line = refused_in_a_line("results", "export", folder)
        assert f"{folder / NAME}: damaged: " in line
        assert "run the command that wrote it again: it computes what is damaged" in line
    assert "damaged: " in refused_in_a_line("results", "merge", folder.parent / "all", folder)
    assert "damaged: " in refused_in_a_line("results", "merge", folder, kept / "closed")
    assert "damaged: " in invoke("results", "status", folder).stderr
    new, told = swept(kept, folder)
    assert f"feasibee: {folder / NAME}: damaged: " in told
    assert new <= 3 * 24
    assert export(folder) == table
    with Journal(folder, write=True) as journal:
        assert all(len(list(journal.curves(row.id))) == 24 for row in journal.points)
    assert swept(kept, folder) == (0, "")


def test_every_reader_names_the_damaged_points_and_counts_the_others(folder):
    change(folder, *DAMAGES["a decision"], "UPDATE points SET hash = 'no' WHERE id = 7")
    for command in (("results", "plot", folder, "--x", "tasks.count"), ("watch", folder)):
        assert f"{folder / NAME}: damaged: point 3" in refused_in_a_line(*command)
    result = invoke("results", "status", folder, "--json")
    assert result.exit_code == 2  # what comes after it in a script must not go on
    assert len(json.loads(result.stdout)) == 7
    (line,) = result.stderr.splitlines()
    assert "damaged: point 3 (tasks.count = 2, decision.strategy = " in line
    assert "own.py), point 7; 168 runs of 7 other points are undamaged" in line


def test_what_is_damaged_of_another_study_is_told(kept, folder, tmp_path):
    """The sweep that mends the journal doesn't compute it, and the damaged file is gone then."""
    change(folder, *DAMAGES["a decision"])
    (tmp_path / "other.toml").write_text("runs = 2\n[sweep]\n'tasks.count' = [30]\n")
    told = invoke("sweep", tmp_path / "other.toml", "--out", folder, "--workers", 1)
    assert "damaged: point 3 (tasks.count = 2, " in told.stderr
    assert swept(kept, folder) == (3, "")


@pytest.mark.parametrize("change", ["truth = 1 - truth", "hash = 'x' || hash"])
def test_what_isnt_the_scenarios_is_refused_though_its_digest_is_right(folder, change):
    """Whoever wrote that row, no figure is drawn from it."""
    with closing(sqlite3.connect(folder / NAME, isolation_level=None)) as database:
        database.execute(f"UPDATE points SET {change} WHERE id = 3")
        columns = "points.id, hash, seed, truth, vary, scenario, until, source, text"
        joined = f"SELECT {columns} FROM points JOIN sources ON sources.id = source WHERE points.id = 3"
        entry = Entry._make(database.execute(joined).fetchone())
        database.execute("UPDATE points SET digest = ? WHERE id = 3", (schema.digest_of_entry(entry),))
    assert "damaged: point 3" in refused_in_a_line("results", "export", folder)


@pytest.mark.parametrize("kind", ["open", "halfway"])
def test_a_journal_whose_log_was_left_behind_is_refused(kept, table, tmp_path, kind):
    """Such as one that was copied without it; the runs in the log aren't just fewer."""
    folder = copied(kept, kind, tmp_path / "out")
    (folder / LOG).unlink()
    assert "damaged: commits missing at its end: " in refused_in_a_line("results", "export", folder)
    swept(kept, folder)
    assert export(folder) == table


def test_a_seal_alone_is_no_damage(kept, table, folder):
    """It only adds to what is found: without it, or if it says nothing, the journal is as good."""
    for text in ("", "nonsense", "00000000000000000099 00", "x" * 10_000):
        (folder / SEAL).write_text(text)
        assert export(folder) == table
    (folder / SEAL).unlink()
    assert export(folder) == table


def test_a_damaged_index_changes_nothing_and_is_mended(kept, table, folder):
    """The index of points by hash lies in pages of its own, which only a writer uses."""
    with closing(sqlite3.connect(folder / NAME)) as database:
        query = "SELECT rootpage FROM sqlite_master WHERE name = 'sqlite_autoindex_points_1'"
        ((page,),) = database.execute(query)
    data = bytearray((folder / NAME).read_bytes())
    data[4096 * (page - 1) : 4096 * page] = bytes(4096)
    (folder / NAME).write_bytes(bytes(data))
    assert export(folder) == table
    assert "damaged: its pages or indices" in refused_in_a_line("results", "merge", folder, kept / "closed")
    new, told = swept(kept, folder)
    assert new == 0
    assert f"damaged: its pages or indices; {RUNS} undamaged runs are kept" in told
    assert export(folder) == table


def test_a_file_that_sqlite_wouldnt_write_to_is_mended(kept, table, folder):
    """One bit of its header makes it one of a later version, which can be read only."""
    data = bytearray((folder / NAME).read_bytes())
    data[18] ^= 16
    (folder / NAME).write_bytes(bytes(data))
    assert export(folder) == table
    assert swept(kept, folder)[0] == 0
    assert export(folder) == table
    assert swept(kept, folder) == (0, "")


def test_a_file_that_was_cut_short_loses_only_its_end(kept, table, folder):
    """SQLite refuses such a file as a whole."""
    os.truncate(folder / NAME, (folder / NAME).stat().st_size - 5000)
    result = invoke("results", "status", folder, "--json")
    assert result.exit_code in (0, 2)
    good = sum(point["runs"] for point in json.loads(result.stdout))
    assert good > RUNS / 3
    if result.exit_code:
        assert f"; {good} runs of " in result.stderr
    assert swept(kept, folder)[0] < RUNS - good + 1
    assert export(folder) == table


def test_what_is_no_database_any_more_is_lost_as_a_whole(kept, folder):
    data = (folder / NAME).read_bytes()
    (folder / NAME).write_bytes(bytes(100) + data[100:])
    for command in (
        ("results", "export", folder),
        ("results", "status", folder),
        ("sweep", kept / "study.toml", "--out", folder),
    ):
        line = refused_in_a_line(*command)
        assert "damaged as a whole (file is not a database): none of its runs can be rescued" in line
        assert "move it away, and run the command that wrote it again" in line
    (folder / NAME).unlink()
    assert swept(kept, folder) == (RUNS, "")


def test_a_rescue_that_was_killed_is_begun_again(kept, table, folder):
    """Only the damaged chunk is computed again, of 3 runs."""
    change(folder, *DAMAGES["a decision"])
    (folder / RESCUE).mkdir()
    (folder / RESCUE / NAME).write_text("half")
    new, told = swept(kept, folder)
    assert new == 3
    assert f"{RUNS - 3} undamaged runs are kept" in told
    assert export(folder) == table
    assert not (folder / RESCUE).exists()


def test_a_rescue_without_room_leaves_the_journal_as_it_is(kept, folder, monkeypatch):
    change(folder, *DAMAGES["a decision"])
    before = (folder / NAME).read_bytes()

    def fail(*arguments):
        raise FeasibeeError("no room")

    monkeypatch.setattr(Journal, "store", fail)
    assert "no room" in refused_in_a_line("sweep", kept / "study.toml", "--out", folder, "--workers", 1)
    assert (folder / NAME).read_bytes() == before


def test_a_journal_that_is_read_stays_as_it_is(kept, tmp_path):
    """Also its log, which a reader that may write would copy into the file."""
    folder = copied(kept, "open", tmp_path / "out")
    before = {name: (folder / name).read_bytes() for name in (NAME, LOG, SEAL)}
    assert invoke("results", "status", folder).exit_code == 0
    assert {name: (folder / name).read_bytes() for name in before} == before


@pytest.mark.parametrize(
    "row",
    [
        "runs VALUES (3, 99, 2, 5, 0, -1, 0, 0, 0, 0, 0, 0, -1, -1, 0, 0, 0, 0, -1)",
        "runs VALUES (3, 99, 1, -2, 0, -1, 0, 0, 0, 0, 0, 0, -1, -1, 0, 0, 0, 0, -1)",
        "runs VALUES (3, -1, 1, 5, 0, -1, 0, 0, 0, 0, 0, 0, -1, -1, 0, 0, 0, 0, -1)",
        "runs VALUES (3, 99, 1, 5, -1, -1, 0, 0, 0, 0, 0, 0, -1, -1, 0, 0, 0, 0, -1)",
        "points SELECT 44, 'x', seed, 2, vary, scenario, source, until, digest FROM points WHERE id = 3",
        "chunks VALUES (3, 3, 99, 1, x'00')",
    ],
)
def test_no_tool_can_enter_what_cant_be(folder, row):
    with closing(sqlite3.connect(folder / NAME)) as database, pytest.raises(sqlite3.IntegrityError):
        database.execute(f"INSERT INTO {row}")
