"""A folder of chunks: what goes in comes out, and a damaged file is a missing one."""

from __future__ import annotations

import io
import json
import os
import random
import re
import shutil

import numpy as np
import pytest
from commands import invoke, output_of, refused_in_a_line

from feasibee import FeasibeeError, Scenario, truth
from feasibee.base.outcomes import CURVES, OUTCOMES, TRACES
from feasibee.scenario.runs import Runs
from feasibee.simulation import executors, store
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.plan import DesignPoint, StoppingRule, Study
from feasibee.simulation.store import FORMAT, RUNS, Store, differences, key_of
from feasibee.simulation.sweep import complete
from feasibee.simulation.table import export

SMALL = Scenario(arena={"side": 6.0}, robots={"count": 5}, tasks={"count": 3}, run={"steps": 40})
CHANGING = SMALL.replace({"events": [{"step": 20, "tasks": 9}], "decision.exploration": 6})
BY_VOTES = SMALL.replace({"decision.declare": {"quorum": 0.6, "rounds": 1, "heard": 1}})
SEED = 2**64 - 1
STUDY = Study([DesignPoint({"tasks.count": m}, SMALL.replace({"tasks.count": m})) for m in (3, 9)], 12, SEED)


def point(scenario=SMALL, **values):
    return DesignPoint(values, scenario)


def same(ours, theirs):
    """Whether two records have the same runs and outcomes."""
    whole = (ours.first_run, ours.runs) == (theirs.first_run, theirs.runs)
    return whole and not list(differences(ours, theirs))


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A folder with 12 runs of two points, as a sweep on one thread writes it."""
    folder = tmp_path_factory.mktemp("kept")
    complete(STUDY, folder, executors.threads(1))
    return folder


@pytest.fixture
def folder(kept, tmp_path):
    return shutil.copytree(kept, tmp_path / "folder")


def files(folder, suffix=""):
    return sorted(each for each in (folder / RUNS).iterdir() if each.suffix.endswith(suffix))


def exported(folder, tmp_path):
    export(Store(folder), tmp_path / "runs.csv")
    return (tmp_path / "runs.csv").read_bytes()


def test_names_of_files_are_those_of_their_format(kept):
    """If this fails, folders on disk can't be read: raise FORMAT, and write down the new names here."""
    assert (FORMAT, key_of("hash", 7)) == (11, "af4222bdb3d4cf70")
    assert store.TABLE.itemsize == 125
    for key in (key_of(each.scenario.hash, SEED) for each in STUDY.points):
        (chunk,) = (kept / RUNS).glob(f"{key}.*.npz")
        assert re.fullmatch(r"[0-9a-f]{16}\.0-11\.[0-9a-f]{16}\.npz", chunk.name)
        assert json.loads((kept / RUNS / f"{key}.json").read_text())["seed"] == str(SEED)


@pytest.mark.parametrize("scenario", [SMALL, CHANGING, BY_VOTES])
@pytest.mark.parametrize("curves", [False, True])
@pytest.mark.parametrize("in_memory", [False, True])
def test_what_goes_in_comes_out(tmp_path, scenario, curves, in_memory):
    record = simulate_record(scenario, Runs(8, SEED, 3), curves=curves)
    written = Store(None if in_memory else tmp_path, write=True)
    (key,) = written.add([point(scenario, name="a")], SEED, StoppingRule(0.1, None, 30))
    for start, stop in ((5, 8), (0, 5)):
        written.put(key, record.part(start, stop))
    read = written if in_memory else Store(tmp_path)
    assert same(read.record(key, 3, 8, curves), record)
    assert same(read.record(key, 5, 4), record.without_curves().part(2, 6))
    results = read.results(key)
    assert results.run.tolist() == list(range(3, 11))
    for each in (*OUTCOMES, *(TRACES if scenario.dynamic else ())):
        np.testing.assert_array_equal(getattr(results, each.name), getattr(record, each.name))
        assert getattr(results, each.name).dtype == each.dtype
    (row,) = read.points
    assert (row.id, row.key, row.hash, row.seed) == (1, key, scenario.hash, SEED)
    assert (row.values, row.scenario, row.truth) == ({"name": "a"}, scenario, truth(scenario))
    assert row.until == {"width": 0.1, "decided": None, "most": 30}
    assert (read.count(key), read.damaged) == (8, [])


def test_what_is_missing():
    kept = Store(write=True)
    (key,) = kept.add([point()], 0)
    assert kept.missing(key, 0, 10, False) == [(0, 10)]
    for first, runs, curves in ((8, 1, False), (2, 3, True), (5, 1, False)):
        kept.put(key, simulate_record(SMALL, Runs(runs, 0, first), curves=curves))
    assert kept.missing(key, 0, 12, False) == [(0, 2), (6, 8), (9, 12)]
    assert kept.missing(key, 0, 9, False) == [(0, 2), (6, 8)]
    assert kept.missing(key, 0, 5, False) == [(0, 2)]
    assert kept.missing(key, 0, 12, True) == [(0, 2), (5, 12)]
    assert kept.count(key) == 5


def test_a_later_study_says_what_varies_and_a_rule_stays(tmp_path):
    for values, rule in (({"a": 1}, StoppingRule(0.1, None, 30)), ({"b": 2}, None)):
        Store(tmp_path, write=True).add([point(**values)], 0, rule)
    (row,) = Store(tmp_path).points
    assert row.values == {"b": 2}
    assert row.until == {"width": 0.1, "decided": None, "most": 30}


def test_merging_is_copying(kept, tmp_path):
    for part in range(3):
        complete(STUDY, tmp_path / f"part{part}", executors.threads(1), shard=(part, 3))
        shutil.copytree(tmp_path / f"part{part}", tmp_path / "whole", dirs_exist_ok=True)
    assert len(files(tmp_path / "whole", ".npz")) == 6
    assert exported(tmp_path / "whole", tmp_path) == exported(kept, tmp_path)
    shutil.copytree(kept, tmp_path / "whole", dirs_exist_ok=True)  # every run twice
    assert exported(tmp_path / "whole", tmp_path) == exported(kept, tmp_path)


@pytest.mark.parametrize(
    ("scenario", "outcome", "what"),
    [
        (SMALL, "decision", "decision is"),
        (SMALL, "bits_sent", "bits_sent is"),
        (SMALL, "feasible_count", "feasible_count at step 17 is"),
        (CHANGING, "held", "held at step 17 is"),
    ],
)
def test_a_run_that_is_there_twice_and_differs_is_named(tmp_path, scenario, outcome, what):
    record = simulate_record(scenario, Runs(12, 7), curves=True)
    there = Store(tmp_path, write=True)
    (key,) = there.add([point(scenario, name="a")], 7)
    for first, last in ((0, 12), (2, 3), (4, 8)):
        there.put(key, record.part(first, last))
    assert same(there.record(key, 0, 12, curves=True), record)
    other = simulate_record(scenario, Runs(3, 7, 4), curves=True)
    values = getattr(other, outcome)
    values[(1, 17) if values.ndim == 2 else 1] += 1
    there.put(key, other)
    with pytest.raises(FeasibeeError, match=rf"point 1 \(name = a\), run 5: {what} -?\d+ in one file and"):
        there.record(key, 0, 12, curves=True)


# --- Damage ---


def flipped(data, rng):
    changed = bytearray(data)
    changed[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(changed)


@pytest.mark.parametrize("suffix", [".npz", ".json"])
def test_each_of_150_flipped_bits_is_noticed(folder, suffix):
    rng = random.Random(1)
    for _ in range(150):
        path = rng.choice(files(folder, suffix))
        before = path.read_bytes()
        path.write_bytes(flipped(before, rng))
        read = Store(folder)
        for key in (each.key for each in read.points):
            read.results(key)
        assert read.damaged == [path.name]
        path.write_bytes(before)


DAMAGES = {
    "changed": lambda path: path.write_bytes(flipped(path.read_bytes(), random.Random(2))),
    "cut": lambda path: path.write_bytes(path.read_bytes()[:-100]),
    "empty": lambda path: path.write_bytes(b""),
    "folder": lambda path: (path.unlink(), path.mkdir()),
    "other": lambda path: path.write_bytes(next(p for p in path.parent.iterdir() if p != path).read_bytes()),
}


@pytest.mark.parametrize("what", DAMAGES)
@pytest.mark.parametrize("suffix", [".npz", ".json"])
def test_a_damaged_file_is_told_by_who_reads_and_computed_again_by_who_writes(
    kept, folder, tmp_path, suffix, what
):
    path = files(folder, suffix)[0]
    DAMAGES[what](path)
    line = refused_in_a_line("results", "export", folder)
    assert f"1 file is damaged and counted as missing: {path.name}; run the command that wrote" in line
    assert not (folder / "runs.csv").exists()
    if what == "folder":
        path.rmdir()
    done = complete(STUDY, folder, executors.threads(1))
    assert done.runs_new == (12 if suffix == ".npz" else 0)
    assert exported(folder, tmp_path) == exported(kept, tmp_path)


def test_a_file_that_is_gone_is_computed_again_and_nothing_else(kept, folder, tmp_path):
    files(folder, ".npz")[1].unlink()
    assert complete(STUDY, folder, executors.threads(1)).runs_new == 12
    assert [each.name for each in files(folder)] == [each.name for each in files(kept)]


def test_status_shows_the_rest_and_says_what_is_damaged(folder):
    path = files(folder, ".npz")[0]
    path.write_bytes(b"")
    result = invoke("results", "status", folder)
    assert result.exit_code == 2
    assert "12 runs of 2 points" in result.stdout
    assert path.name in result.stderr


def packed(**arrays):
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()


def fits():
    return np.zeros(12, store.TABLE)


class Trap:
    def __reduce__(self):
        return os.mkdir, ("trapped",)


FORGED = {
    "code": lambda: packed(runs=np.array([Trap()], object)),
    "fewer": lambda: packed(runs=fits()[:5]),
    "other columns": lambda: packed(runs=np.zeros(12)),
    "nothing": packed,
    "no archive": lambda: b"PK\x03\x04",
}


@pytest.mark.parametrize("what", FORGED)
def test_a_file_of_another_content_whose_name_fits_is_damaged(folder, what, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    key = key_of(STUDY.points[0].scenario.hash, SEED)
    data = FORGED[what]()
    name = f"{key}.12-23.{store._digest(data)}.npz"
    (folder / RUNS / name).write_bytes(data)
    read = Store(folder)
    assert read.results(key).run.size == 12
    assert read.damaged == [name]
    assert not (tmp_path / "trapped").exists()


@pytest.mark.parametrize(
    "change", [{"hash": "x"}, {"seed": "8"}, {"number": "1"}, {"scenario": {}}, {"source": 3}]
)
def test_a_description_that_isnt_its_scenarios_is_damaged(folder, change):
    path = files(folder, ".json")[0]
    about = {**json.loads(path.read_text()), **change}
    about.pop("digest")
    path.write_text(json.dumps({**about, "digest": store._digest_of(about)}))
    assert Store(folder).damaged == [path.name]


# --- Other folders ---


@pytest.mark.parametrize(
    ("name", "number", "rule"),
    [
        ("format", 10, "has format 10, this feasibee has 11; choose another folder"),
        ("model_version", 10**6, "has model version 1000000, this feasibee has"),
    ],
)
def test_other_versions_are_refused(folder, name, number, rule):
    path = files(folder, ".json")[0]
    path.write_text(json.dumps({**json.loads(path.read_text()), name: number}))
    assert rule in refused_in_a_line("results", "status", folder)


@pytest.mark.parametrize(
    ("make", "rule"),
    [
        (lambda path: None, "isn't a folder; name the folder of a sweep or study"),
        (lambda path: path.write_text("text"), "is a file"),
        (lambda path: path.mkdir(), "has no results; name the folder of a sweep or study"),
        (
            lambda path: (path.mkdir(), (path / "journal.sqlite").write_text("")),
            "has results of an earlier version; convert them with examples/convert_journal.py",
        ),
    ],
)
def test_what_is_no_folder_of_results_is_told(tmp_path, make, rule):
    make(tmp_path / "there")
    assert rule in refused_in_a_line("results", "status", tmp_path / "there")


def test_other_files_in_the_folder_are_left_alone(folder, kept, tmp_path):
    for name in ("notes.txt", "0.json", "a.npz", "0123456789abcdef.9-3.0123456789abcdef.npz"):
        (folder / RUNS / name).write_text("mine")
    complete(STUDY, folder, executors.threads(1))
    assert exported(folder, tmp_path) == exported(kept, tmp_path)
    assert {(folder / RUNS / name).read_text() for name in ("notes.txt", "0.json")} == {"mine"}


def test_a_folder_that_is_read_stays_as_it_is(folder):
    before = {each.name: (each.read_bytes(), each.stat().st_mtime_ns) for each in files(folder)}
    output_of("results", "status", folder)
    assert {each.name: (each.read_bytes(), each.stat().st_mtime_ns) for each in files(folder)} == before


def test_runs_that_vanish_meanwhile_are_told(folder):
    read = Store(folder)
    key = read.points[0].key
    next((folder / RUNS).glob(f"{key}*.npz")).unlink()
    with pytest.raises(FeasibeeError, match="12 of 12 runs were removed or damaged meanwhile; run the same"):
        read.record(key, 0, 12)


def test_curves_are_a_part_of_what_differs():
    one, two = (simulate_record(SMALL, Runs(3, seed), curves=True) for seed in (1, 2))
    assert {outcome.partition(" ")[0] for _, outcome, *_ in differences(one, two)} <= {
        each.name for each in (*OUTCOMES, *CURVES)
    }
    assert len(list(differences(one, two))) == 3
