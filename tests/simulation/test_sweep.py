"""Sweeps: the same runs whoever does the work, and whatever ends it on the way."""

from __future__ import annotations

import importlib.util
import json
import math
import os
import re
import shutil
import signal
import sys
from collections import Counter
from concurrent.futures import Executor, Future
from dataclasses import replace
from functools import partial
from pathlib import Path
from threading import Timer
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from commands import WITHOUT_BYTECODE, json_of, output_of, python, refused_in_a_line
from stores import PLACES, counts, rows_in

from feasibee import FeasibeeError, Scenario, wilson
from feasibee.base.files import RESULTS
from feasibee.results.measures import together
from feasibee.results.statistics import confidence_sequence
from feasibee.scenario.runs import Runs
from feasibee.simulation import executors, schedule
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.executors import WorkerPool
from feasibee.simulation.plan import DesignPoint, StoppingRule, Study, study_of
from feasibee.simulation.schedule import Schedule, _piece_size, is_sure
from feasibee.simulation.store import Store, differences
from feasibee.simulation.sweep import Progress, complete
from feasibee.simulation.table import Summary, by_value, shares_by_line, summaries

SMALL = {"arena": {"side": 6.0}, "robots": {"count": 5}, "run": {"steps": 40}}
VARIED = {"tasks.count": [2, 5, 9], "decision.strategy": ["dmmd", "voter"]}
WORK = 200
"""Robot-steps of one of these runs."""

unix = pytest.mark.skipif(os.name == "nt", reason="no signals to send")


def study(**changes):
    """Return a study of six points."""
    return study_of({"runs": 24, "seed": 5, "scenario": SMALL, "sweep": VARIED, **changes}, Path())


def everything(folder):
    """Return all that a folder knows, by scenario and seed: truth, runs, and curves."""
    store = Store(folder)
    found = {}
    for row in store.points:
        curves = [each for each in store.records(row.key) if each.feasible_count.size]
        counts = {
            each.first_run + run: (each.feasible_count[run].tolist(), each.infeasible_count[run].tolist())
            for each in curves
            for run in range(each.runs)
        }
        found[row.hash, row.seed] = row.truth, rows_in(store, row).tolist(), sorted(counts.items())
    assert not store.damaged
    return found


def study_file(folder):
    """Write the study as a file."""
    (folder / "study.toml").write_text(TOML)
    return folder / "study.toml"


class Here(Executor):
    """Works at once, and keeps what it was asked for."""

    def __init__(self):
        self.asked = []

    def submit(self, work, scenarios, pieces, *arguments):
        self.asked.append(pieces)
        future = Future()
        future.set_result(work(scenarios, pieces, *arguments))
        return future


@pytest.fixture
def small_chunks(monkeypatch):
    """Chunks of two runs or so."""
    monkeypatch.setattr(schedule, "CHUNK_WORK", 2 * WORK)
    monkeypatch.setattr(schedule, "CHUNK_SECONDS", 1e9)  # or less, on a slow machine


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of the study, of 24 runs of each point with curves, without any interruption."""
    folder = tmp_path_factory.mktemp("whole")
    complete(study(curves=True), folder, executors.threads(1))
    return folder


# --- What is in the folder ---


def test_a_folder_holds_what_a_simulation_gives(whole):
    plan, store = study(curves=True), Store(whole)
    assert [row.values for row in store.points] == [point.values for point in plan.points]
    for row, point in zip(store.points, plan.points, strict=True):
        record = simulate_record(point.scenario, Runs(24, 5), curves=True)
        assert list(differences(record, store.record(row.key, 0, 24, curves=True))) == []


def test_nothing_is_computed_again(tmp_path):
    for runs, new in ((10, 60), (10, 0), (25, 90), (12, 0)):
        done = complete(study(runs=runs), tmp_path, executors.threads(1))
        assert (done.runs_new, done.runs_done, done.runs) == (new, 6 * runs, 6 * runs)
        assert (done.points_done, done.points) == (6, 6)
    assert counts(tmp_path) == [25] * 6
    fresh = tmp_path / "fresh"
    complete(study(runs=25), fresh, executors.threads(1))
    assert everything(tmp_path) == everything(fresh)


def test_only_what_is_missing_is_asked_for(tmp_path, small_chunks, monkeypatch):
    monkeypatch.setattr(schedule, "CHUNK_WORK", WORK)  # chunks of one run
    complete(study(runs=5), tmp_path, executors.threads(1))
    key = Store(tmp_path).points[1].key
    for run in (1, 2, 4):
        next(tmp_path.glob(f"runs/{key}.{run}-{run}.*")).unlink()
    here = Here()
    complete(study(runs=6), tmp_path, WorkerPool(lambda: here, 1))
    asked = Counter(
        (point, first + k) for pieces in here.asked for point, first, runs in pieces for k in range(runs)
    )
    assert asked == Counter([*((place, 5) for place in range(6)), (1, 1), (1, 2), (1, 4)])


@pytest.mark.slow
def test_a_half_done_sweep_is_balanced(tmp_path, small_chunks):
    """48 runs in pieces of 2: wherever it stops, no point is more than two pieces ahead of another."""
    told = []

    def tell(progress):
        told.append(progress)
        there = counts(tmp_path)
        assert sum(there) == progress.runs_done
        assert max(there) - min(there) <= 4
        if progress.runs_done >= 100:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        complete(study(runs=48), tmp_path, WorkerPool(Here, 1), progress=tell)
    assert 100 <= sum(counts(tmp_path)) < 110
    assert told[0].runs_done == told[0].runs_new == 0
    assert {(each.points, each.runs) for each in told} == {(6, 288)}


class Slow(Executor):
    """Has one chunk done, computes another, and has not begun with the rest."""

    def __init__(self):
        self.submitted = 0
        self.late = None

    def submit(self, work, *arguments):
        future = Future()
        self.submitted += 1
        if self.submitted < 3:
            future.set_running_or_notify_cancel()
        if self.submitted == 1:
            future.set_result(work(*arguments))
        elif self.submitted == 2:
            self.late = Timer(0.3, lambda: future.set_result(work(*arguments)))
            self.late.start()
        return future


def test_a_chunk_that_is_being_computed_is_kept(tmp_path, small_chunks):
    """Whatever ends the sweep; those that wait are cancelled."""

    def tell(progress):
        if progress.runs_new:
            raise error

    for number, error in enumerate((KeyboardInterrupt(), FeasibeeError("the log is full"))):
        slow = Slow()
        with pytest.raises(type(error)):
            complete(study(), tmp_path / str(number), WorkerPool(lambda slow=slow: slow, 3), progress=tell)
        slow.late.join()
        assert slow.submitted > 2
        assert sum(counts(tmp_path / str(number))) == 4


# --- Who does the work ---


class KilledWorker(Exception):  # noqa: N818
    """Called as Dask's."""


@pytest.mark.parametrize(
    ("error", "rule"), [(KilledWorker("task"), "workers died 3 times"), (None, "the cluster has gone")]
)
def test_what_a_cluster_may_say(tmp_path, error, rule):
    class Far(Executor):
        def submit(self, *arguments):
            future = Future()
            if error:
                future.set_exception(error)
            else:
                future.cancel()
                future.set_running_or_notify_cancel()
            return future

    with pytest.raises(FeasibeeError, match=rule):
        complete(study(), tmp_path, WorkerPool(Far, 2))
    assert sum(counts(tmp_path)) == 0


def test_an_error_of_the_work_isnt_hidden(tmp_path, monkeypatch):
    def fail(*arguments):
        raise MemoryError

    monkeypatch.setattr(executors, "play", fail)
    with pytest.raises(MemoryError):
        complete(study(), tmp_path, executors.threads(2))
    monkeypatch.undo()
    assert complete(study(), tmp_path, executors.threads(2)).runs_new == 144


def test_a_cluster_without_workers_or_without_dask_is_told(monkeypatch):
    empty = SimpleNamespace(nthreads=dict, scheduler=SimpleNamespace(address="tcp://10.0.0.1:8786"))
    with pytest.raises(FeasibeeError, match=r"tcp://10\.0\.0\.1:8786: the cluster has no workers"):
        executors.dask(empty)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(FeasibeeError, match="Dask: not installed; "):
        executors.dask("tcp://127.0.0.1:8786")


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="needs distributed")
@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://here:1", "tls://127.0.0.1:1"])
def test_a_cluster_that_doesnt_answer_is_told(tmp_path, address):
    """In a process of its own: what Dask leaves open there would be another test's warning, later."""
    more = "from feasibee.simulation import executors\nexecutors.PATIENCE = 1.0\n"
    code = f"{more}from feasibee.cli import main\nmain()"
    told = python("-c", code, "sweep", study_file(tmp_path), "--dask", address, cwd=tmp_path)
    assert told.returncode == 2
    (line,) = told.stderr.splitlines()
    assert f"--dask {address}: doesn't answer: " in line
    assert line.endswith("; give a scheduler's address")


@pytest.mark.slow
@unix
@pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="needs distributed")
def test_a_dask_cluster_may_lose_a_worker(whole, tmp_path):
    """Two real worker processes, one of them killed while the sweep goes on.

    In a process of its own, since Dask leaves threads and open sockets behind.
    """
    code = """
import os, signal, sys
from pathlib import Path
from types import SimpleNamespace

from distributed import Client, LocalCluster

sys.path[:0] = [sys.argv[1], os.path.dirname(sys.argv[1])]

def main():
    from test_sweep import WORK, executors, schedule, study, complete

    schedule.CHUNK_WORK = WORK
    killed = []

    def tell(progress):
        if progress.runs_new >= 20 and not killed:
            pids = client.run(os.getpid)
            killed.append(min(pids.values()))
            os.kill(killed[0], signal.SIGKILL)

    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(**options, local_directory=sys.argv[2]) as cluster, Client(cluster) as client:
        done = complete(study(curves=True), Path(sys.argv[2]) / "out", executors.dask(client), progress=tell)
        left = set(client.run(os.getpid).values()) - set(killed)
        print(done.runs_new, done.runs_done, len(killed), len(left))

if __name__ == "__main__":
    main()
"""
    script = tmp_path / "script.py"
    script.write_text(code)
    told = python(script, Path(__file__).parent, tmp_path)
    assert told.returncode == 0, told.stderr
    new, done, killed, left = map(int, told.stdout.split())
    assert (new, done, killed) == (144, 144, 1)
    assert left >= 1
    assert everything(tmp_path / "out") == everything(whole)


# --- Parts ---


@pytest.mark.parametrize("parts", [3, 40])
def test_the_parts_of_a_sweep_make_the_whole(whole, tmp_path, parts):
    """Also if there are more parts than runs."""
    plan = study(curves=True)
    folders = [tmp_path / str(part) for part in range(parts)]
    if parts > 24:  # a few points are enough
        plan = replace(plan, points=plan.points[:1])
    total = 0
    for part, folder in enumerate(folders):
        if parts == 3:  # as a user says it
            output_of("sweep", study_file(tmp_path), "--out", folder, "--shard", f"{part + 1}/3")
            assert counts(folder) == [8] * 6
        else:
            done = complete(plan, folder, executors.threads(1), shard=(part, parts))
            assert done.runs_new == done.runs_done == done.runs == sum(counts(folder))
        total += sum(counts(folder))
    assert total == 24 * len(plan.points)
    for folder in folders:
        shutil.copytree(folder, tmp_path / "all", dirs_exist_ok=True)
    merged, expected = everything(tmp_path / "all"), everything(whole)
    assert merged == {key: expected[key] for key in merged}
    assert len(merged) == len(plan.points)
    assert complete(plan, tmp_path / "all", executors.threads(1)).runs_new == 0


# --- Until it is sure ---


def test_parts_cant_be_sure(tmp_path):
    plan = replace(study(), until=StoppingRule(0.1, None, 1000))
    with pytest.raises(FeasibeeError, match="leave out either"):
        complete(plan, tmp_path, executors.threads(1), shard=(0, 2))


class Kept:
    """A store that keeps what it was asked, and of whose runs half are right."""

    def __init__(self):
        self.last, self.asked = 0, []

    def missing(self, key, first, last, curves):
        return [(max(first, self.last), last)]

    def results(self, key):
        self.asked.append(self.last)
        run = np.arange(40, self.last)  # also those of another study
        return SimpleNamespace(run=run, decision=run % 2)

    def put(self, key, piece):
        self.last = piece.first_run + piece.runs


@pytest.mark.parametrize(
    ("most", "ends"), [(70, [120, 130, 145, 168, 170]), (68, [120, 130, 145, 168]), (20, [120])]
)
def test_a_point_that_stays_unsure_is_looked_at_after_half_as_many_runs_more(most, ends):
    """Its runs begin with number 100; after the most runs there is no look."""
    kept, seen = Kept(), []
    points = [DesignPoint({}, Scenario.from_tables(SMALL), 100)]
    schedule = Schedule(Study(points, 20, 0, until=StoppingRule(None, 0.5, most)), kept, [1])
    schedule.begin()
    while schedule.queue:
        pieces = schedule.chunk(1e12 if seen else 1)  # 1: less than a run takes
        seen.append(pieces[-1].first_run + pieces[-1].runs)
        schedule.enter(pieces, pieces)
    assert seen == [101, *ends]
    assert kept.asked == ends[:-1]
    assert not any(schedule.pending.values())
    totals = schedule.totals
    assert (totals.points_done, totals.runs, totals.runs_done, totals.runs_new) == (1, most, most, most)


@pytest.mark.parametrize(
    ("until", "right", "sure"),
    [
        (StoppingRule(0.2, None, 1), 50, False),
        (StoppingRule(0.35, None, 1), 50, True),
        (StoppingRule(None, 0.5, 1), 50, False),
        (StoppingRule(None, 0.7, 1), 50, True),
        (StoppingRule(None, 0.3, 1), 50, True),
    ],
)
def test_what_it_is_to_be_sure(until, right, sure):
    """50 of 100: from 0.34 to 0.66."""
    assert is_sure(until, right, 100) is sure


# --- Whatever ends it ---

TOML = """
runs = 24
seed = 5
curves = true
[scenario]
arena.side = 6.0
robots.count = 5
run.steps = 40
[sweep]
"tasks.count" = [2, 5, 9]
"decision.strategy" = ["dmmd", "voter"]
"""

KILLING = """
import os, random, signal, sys, time
from pathlib import Path
from types import SimpleNamespace

sys.path[:0] = [sys.argv[1], os.path.dirname(sys.argv[1])]
from test_sweep import WORK, executors, everything, schedule, study, complete

schedule.CHUNK_WORK = WORK
folder, times = Path(sys.argv[2]), int(sys.argv[3])
plan = study(curves=True)
begin = time.monotonic()
complete(plan, folder / "whole", executors.threads(2))
long = time.monotonic() - begin
expected = everything(folder / "whole")
chance = random.Random(8)
killed = place = 0
while killed < times:
    out = folder / str(place)
    child = os.fork()
    if child == 0:
        complete(plan, out, executors.threads(2))
        os._exit(0)
    time.sleep(chance.choice([0.02, 0.7]) * long * chance.random())
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        killed += 1
        if list(out.glob("runs/[!.]*.json")) and killed % 2:  # a dot: not yet renamed
            everything(out)  # nothing is damaged
        continue
    assert os.WEXITSTATUS(status) == 0
    assert everything(out) == expected
    place += 1
done = complete(plan, folder / str(place), executors.threads(2))
assert everything(folder / str(place)) == expected
print(killed, place, done.runs_new)
"""


@unix
def test_an_interrupt_in_the_last_chunk_of_a_round_ends_the_study(tmp_path):
    """All runs of the round are kept; the next round must not begin."""

    def interrupt(progress):
        if progress.runs_done == progress.runs and not progress.stopping:
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored
    try:
        with pytest.raises(KeyboardInterrupt, match=r"^144 runs kept; the same command goes on$"):
            complete(study(), tmp_path, WorkerPool(Here, 1), progress=interrupt)
    finally:
        signal.signal(signal.SIGINT, before)


@unix
@pytest.mark.slow
def test_a_sweep_that_is_killed_often_goes_on(tmp_path):
    """At random moments; the same call goes on to the same runs."""
    told = python("-W", "ignore", "-c", KILLING, Path(__file__).parent, tmp_path, 20)
    assert told.returncode == 0, told.stderr


CHUNKED = """
import signal, sys
from feasibee.cli import main
from feasibee.simulation import schedule

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored in the background
schedule.CHUNK_WORK = 400
main(prog_name="feasibee")
"""


def test_a_log_that_ends_within_a_line_goes_on_in_the_next(tmp_path):
    """As a sweep leaves it that is killed."""
    log = tmp_path / "log"
    for before in ("", '{"time": 17', '{"time": 17}\n'):
        log.write_text(before)
        output_of("sweep", study_file(tmp_path), "--out", tmp_path / "out", "--log", log)
        lines = log.read_text().removeprefix(before.rstrip("\n")).strip().splitlines()
        told = list(map(json.loads, lines))
        assert {entry["runs"] for entry in told} == {144}
        assert all(set(entry) == {"time", *Progress.__dataclass_fields__} for entry in told)


@pytest.mark.slow
@unix
def test_a_real_shortage_of_memory_is_told(tmp_path):
    """A worker may have two gigabytes here; a census of 100,000 robots takes more than that."""
    code = f"import resource\nresource.setrlimit(resource.RLIMIT_AS, (2 * 10**9, 2 * 10**9))\n{CHUNKED}"
    sizes = "[scenario]\nrun.steps = 20\narena.side = 3000\ndecision.strategy = 'census'\n"
    (tmp_path / "study.toml").write_text(f"runs = 9\n{sizes}[sweep]\n'robots.count' = [20, 100000]\n")
    told = python("-c", code, "sweep", "study.toml", "--out", "out", "--workers", 1, cwd=tmp_path)
    assert told.returncode == 2, told.stderr
    assert (
        "robots.count = 100000: a worker has not enough memory for such a swarm"
        in told.stderr.splitlines()[-1]
    )
    assert "Traceback" not in told.stderr
    assert [count > 0 for count in counts(tmp_path / "out")] == [True, False]


@unix
def test_a_full_disk_is_told_and_the_sweep_goes_on(whole, tmp_path):
    """No file may grow beyond some kilobytes here: those of 24 runs fit, and of 2,000 don't."""
    code = f"import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (5_000, 5_000))\n{CHUNKED}"
    words = ("sweep", study_file(tmp_path), "--out", "out")
    process = partial(python, cwd=tmp_path, env=WITHOUT_BYTECODE)
    assert process("-c", code, *words).returncode == 0
    told = process("-c", code.replace("= 400", "= 10**9"), *words, "--runs", 2000)
    assert told.returncode == 2, told.stderr
    (line,) = told.stderr.splitlines()
    assert "free disk space, and run the same command again: all runs so far are kept" in line
    assert {path.suffix for path in (tmp_path / "out/runs").iterdir()} == {".json", ".npz"}
    assert everything(tmp_path / "out") == everything(whole)
    told = output_of("sweep", tmp_path / "study.toml", "--out", tmp_path / "out", "--runs", 2000)
    assert f"{6 * 1976} runs in" in told


def test_two_sweeps_at_once_into_one_folder(whole, tmp_path, small_chunks):
    """Each computes what it lacked when it began; looking is allowed."""
    out, seen = tmp_path / "out", []

    def tell(progress):
        if progress.runs_done in (0, 50, 100):
            seen.append(sum(each["runs"] for each in json_of("results", "status", out)))
        if progress.runs_done == 50:
            assert complete(study(curves=True), out, executors.threads(1)).runs_new == 144 - 50

    complete(study(curves=True), out, WorkerPool(Here, 1), progress=tell)
    assert seen == [0, 50, 144]
    assert everything(out) == everything(whole)


# --- On the command line ---


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A folder with a study, swept."""
    folder = tmp_path_factory.mktemp("results")
    told = output_of("sweep", study_file(folder), "--out", folder / "out", "--workers", 1)
    assert "144 runs in" in told
    assert f"the study's 144 runs of 6 points are in {folder / 'out'}/" in told
    return folder / "out"


def test_status_in_numbers_says_what_the_folder_holds(results, whole):
    told = json_of("results", "status", results)
    expected = everything(whole)
    assert len(told) == 6
    for each in told:
        truth, runs, _ = expected[each["hash"], each["seed"]]
        decisions = Counter(row[1] for row in runs)
        assert set(each["values"]) == set(VARIED)
        assert each["truth"] == ("feasible" if truth else "infeasible")
        assert each["runs"] == 24
        assert [each[name] for name in ("feasible", "infeasible", "undecided")] == [
            decisions[code] for code in (1, 0, -1)
        ]
        assert each["accuracy"] == wilson(decisions[truth], 24)._asdict()
        assert set(each["decision_step"]) == {"q25", "median", "q75"}
        assert each["bits_per_robot_and_step"] == pytest.approx(sum(row[3] for row in runs) / (24 * WORK))


@pytest.fixture
def twice(tmp_path):
    """A folder with the same study twice, the second with fewer steps and another seed."""
    for changes in ({}, {"scenario": {**SMALL, "run": {"steps": 30}}}, {"seed": 6}):
        complete(study(runs=2, sweep={"tasks.count": [2, 5]}, **changes), tmp_path, executors.threads(1))
    return tmp_path


def test_what_tells_two_points_apart_has_a_column(twice, monkeypatch):
    """Two studies may vary the same fields, and differ in another."""
    monkeypatch.setenv("COLUMNS", "80")
    rows = [line.split() for line in output_of("results", "status", twice).splitlines() if "feasible" in line]
    assert [row[:3] for row in rows] == [
        [tasks, steps, seed] for steps, seed in (("40", "5"), ("30", "5"), ("40", "6")) for tasks in "25"
    ]
    output_of("results", "export", twice)
    assert exported(twice / "runs.csv")["run.steps"].tolist() == [40] * 4 + [30] * 4 + [40] * 4
    dataset = opened(twice)
    assert dict(dataset.sizes) == {"point": 6, "run": 2}
    assert dataset["seed"].values.tolist() == [5, 5, 5, 5, 6, 6]


def test_a_figure_says_which_runs_it_takes_together(twice, results):
    told = output_of("results", "plot", twice, "--x", "tasks.count")
    assert told.endswith("averaged over run.steps\n")
    assert "averaged" not in output_of("results", "plot", twice, "--x", "tasks.count", "--hue", "run.steps")
    told = output_of("results", "plot", results, "--x", "tasks.count")
    assert told.endswith("averaged over decision.strategy\n")
    assert "averaged" not in output_of(
        "results", "plot", results, "--x", "tasks.count", "--hue", "decision.strategy"
    )
    both = study(runs=2, sweep={"tasks.count": [2, 5], "run.steps": [8, 9]}, combine="zip")
    complete(both, twice / "zip", executors.threads(1))
    assert "averaged" not in output_of("results", "plot", twice / "zip", "--x", "tasks.count")


def test_a_strategy_that_was_edited_is_another(tmp_path):
    file = Path(__file__).parents[2] / "src/feasibee/strategies/dc.py"
    own, folder = tmp_path / "own.py", tmp_path / "out"
    for more in ("", "# edited\n"):
        own.write_text(file.read_text() + more)
        varied = {"decision.strategy": ["dmmd", str(own)]}
        complete(study(runs=2, sweep=varied), folder, executors.threads(1))
    output_of("results", "export", folder)
    frame = exported(folder / "runs.csv").drop_duplicates("point")
    assert frame["source"].fillna(0).tolist() == [0, 1, 2]
    told = output_of("results", "plot", folder, "--x", "decision.strategy")
    assert told.endswith("averaged over source\n")
    assert "averaged" not in output_of(
        "results", "plot", folder, "--x", "decision.strategy", "--hue", "source"
    )


def test_an_unbegun_point_has_a_status(tmp_path):
    Store(tmp_path, write=True).add(study().points, 5)
    assert {each["runs"] for each in json_of("results", "status", tmp_path)} == {0}
    assert "0 runs of 6 points" in " ".join(output_of("results", "status", tmp_path).split())
    assert "has no runs yet; run feasibee sweep first" in refused_in_a_line(
        "results", "plot", tmp_path, "--x", "tasks.count"
    )


def test_a_point_that_ran_until_sure_has_an_interval_that_holds_however_often_one_looked(tmp_path):
    """Wilson's would be narrower than the truth allows."""
    plan = replace(study(), until=StoppingRule(0.4, None, 200))
    assert [complete(plan, tmp_path, executors.threads(1)).runs_new > 0 for _ in "12"] == [True, False]
    told = json_of("results", "status", tmp_path)
    assert [each["runs"] for each in told] == [54, 36, 36, 36, 81, 36]  # looks are at 24, 36, 54, 81, ...
    for each in told:
        right = each[each["truth"]]
        assert each["accuracy"] == confidence_sequence(right, each["runs"])._asdict()
        assert each["until"] == {"width": 0.4, "decided": None, "most": 200}
        assert each["accuracy"]["high"] - each["accuracy"]["low"] <= 0.4
    assert "is valid at every look" in " ".join(output_of("results", "status", tmp_path).split())
    points = [each.found for each in summaries(Store(tmp_path))]
    right, runs = sum(each.counts["accuracy"] for each in points), sum(each.runs for each in points)
    assert together(points, "accuracy") == confidence_sequence(right, runs)


@pytest.mark.parametrize("columns", [40, 80])
def test_status_breaks_no_word(results, tmp_path, monkeypatch, columns):
    """Words that are printed in a wide terminal are whole in a narrow one, and no line is too long for it."""
    complete(
        study(runs=2, sweep={**VARIED, "radio.loss": [0.125, 0.25], "walk.mean_run": [10.5]}),
        tmp_path,
        executors.threads(1),
    )
    for folder in (results, tmp_path):
        monkeypatch.setenv("COLUMNS", str(columns))
        told = output_of("results", "status", folder)
        head, *lines = told.splitlines()
        assert str(folder) in head
        assert all(len(line) <= columns for line in lines)
        assert "…" not in told
        words = set(re.split(r"[\s,;()=]+|(?<=[.])(?=\w)", told))
        monkeypatch.setenv("COLUMNS", "300")
        wide = set(re.split(r"[\s,;()=]+|(?<=[.])(?=\w)", output_of("results", "status", folder)))
        rules = {word for word in words | wide if "─" in word}
        assert words - wide - rules <= {
            *["by", "half", "step", "%", "tasks.count", "runs", "right", "undecided"]
        }
        assert {"voter", "infeasible"} <= words


def exported(path):
    if path.suffix == ".csv":
        return pd.read_csv(path)
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        recipe = json.loads(dataset.attrs["recipe"])
        frame = dataset.load().to_dataframe().reset_index()
    assert {point["hash"] for point in recipe["points"]} == {key for key, _ in RECIPES}
    return frame[["point", *VARIED, "seed", "truth", "right", "right_at_end", *PLACES]]


RECIPES = [(point.scenario.hash, 5) for point in study().points]


@pytest.mark.parametrize("suffix", RESULTS)
def test_an_export_has_a_row_a_run(results, tmp_path, suffix):
    path = tmp_path / f"runs{suffix}"
    assert f"144 runs are in {path}" in output_of("results", "export", results, "--out", path)
    frame = exported(path)
    assert len(frame) == 144
    assert list(frame.columns)[:8] == ["point", *VARIED, "seed", "truth", "right", "right_at_end", "run"]
    store = Store(results)
    for row in store.points:
        part = frame[frame["point"] == row.id]
        np.testing.assert_array_equal(part.iloc[:, 7:], rows_in(store, row))
        np.testing.assert_array_equal(part["right"], part["decision"] == int(row.truth))
        held = part["feasible_at_end" if row.truth else "infeasible_at_end"]
        np.testing.assert_array_equal(part["right_at_end"], held > 0.9 * row.scenario.robots.count)
        for path, value in row.values.items():
            assert set(part[path]) == {value}
        assert (set(part["seed"]), set(part["truth"])) == ({5}, {int(row.truth)})


@pytest.mark.parametrize("suffix", RESULTS)
def test_several_studies_in_one_folder_are_exported_together(tmp_path, suffix):
    """Where a study doesn't vary a field, its scenarios' own value stands; kinds that differ become text."""
    for varied in (
        {"tasks.count": [3, 4]},
        {"radio.loss": [0.1], "robots.avoid_collisions": [True]},
        {"arena.side": [7.0, [6.0, 5.0]], "radio.id_bits": [4]},
    ):
        complete(study(runs=2, sweep=varied), tmp_path, executors.threads(1))
    path = tmp_path / f"runs{suffix}"
    output_of("results", "export", tmp_path, "--out", path)
    if suffix == ".nc":
        dataset = opened(tmp_path)
        assert dict(dataset.sizes) == {"point": 5, "run": 2}
        frame = dataset.to_dataframe()
    else:
        frame = exported(path)
    assert frame["tasks.count"].tolist() == [3, 3, 4, 4, *[20] * 6]
    np.testing.assert_allclose(frame["radio.loss"], [0, 0, 0, 0, 0.1, 0.1, 0, 0, 0, 0])
    assert frame["robots.avoid_collisions"].astype(bool).tolist() == [*[False] * 4, True, True, *[False] * 4]
    assert frame["arena.side"].tolist() == [*["6.0"] * 6, "7.0", "7.0", "[6.0, 5.0]", "[6.0, 5.0]"]
    np.testing.assert_array_equal(frame["radio.id_bits"], [*[np.nan] * 6, 4, 4, 4, 4])


def opened(folder):
    """Export a folder as NetCDF, and read it."""
    output_of("results", "export", folder, "--out", folder / "runs.nc")
    with xr.open_dataset(folder / "runs.nc", engine="h5netcdf") as dataset:
        return dataset.load()


def test_a_netcdf_file_has_a_dimension_per_field(results):
    dataset = opened(results)
    assert dataset["right"].dims == (*VARIED, "run")
    assert dataset["right"].dtype == bool
    assert dict(dataset.sizes) == {**{path: len(VARIED[path]) for path in VARIED}, "run": 24}
    assert dataset["tasks.count"].values.tolist() == sorted(VARIED["tasks.count"])
    assert all("long_name" in variable.attrs for variable in dataset.data_vars.values())
    shares = dataset["right"].mean("run")
    for each in json_of("results", "status", results):
        assert float(shares.sel(each["values"])) == pytest.approx(each["accuracy"]["estimate"])


def test_a_run_that_a_point_lacks_is_missing_in_the_file(tmp_path):
    for runs, tasks in ((2, 5), (5, 3)):
        complete(study(runs=runs, sweep={"tasks.count": [tasks]}), tmp_path, executors.threads(1))
    dataset = opened(tmp_path)
    assert dict(dataset.sizes) == {"tasks.count": 2, "run": 5}
    assert dataset["tasks.count"].values.tolist() == [3, 5]
    assert dataset["right"].count("run").values.tolist() == [5, 2]
    assert dataset["decision"].isnull().sum("run").values.tolist() == [0, 3]
    assert set(np.unique(dataset["right"].sel({"tasks.count": 3}))) <= {0.0, 1.0}
    assert dataset["declare_step"].min() == -1  # never, which isn't missing


def test_points_with_runs_of_other_numbers_stand_side_by_side(tmp_path):
    worlds = {m: Scenario(**SMALL, tasks={"count": m}) for m in (2, 3)}
    points = [DesignPoint({"tasks.count": m}, world, 10 * m) for m, world in worlds.items()]
    complete(Study(points, 4, 5), tmp_path, executors.threads(1))
    dataset = opened(tmp_path)
    assert dict(dataset.sizes) == {"tasks.count": 2, "run": 4}
    assert dataset["run_number"].values.tolist() == [[20, 21, 22, 23], [30, 31, 32, 33]]


@pytest.mark.parametrize(
    ("suffix", "arguments"),
    [
        (".png", ("--x", "tasks.count")),
        (".svg", ("--x", "decision.strategy", "--hue", "tasks.count", "--show", "undecided")),
        (".png", ("--x", "robots.count", "--y", "tasks.count", "--show", "feasible")),
    ],
)
def test_figures(results, tmp_path, arguments, suffix):
    path = tmp_path / f"figure{suffix}"
    assert str(path) in output_of("results", "plot", results, *arguments, "--out", path)
    assert path.read_bytes()[:5] in (b"\x89PNG\r", b"<?xml")


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        (("--x", "tasks.coun"), "tasks.coun: isn't a field of the scenarios"),
        (("--x", "tasks.count", "--hue", "nope"), "nope: isn't a field"),
        (("--x", "tasks.count", "--y", "tasks.classes.0"), "tasks.classes.0: isn't a field"),
        (("--x", "tasks.count", "--hue", "robots.count", "--y", "run.steps"), "leave out one of them"),
        (("--x", "tasks.count", "--out", "figure.gif"), "end the name with .png, .pdf or .svg"),
        (("--x", "tasks.count", "--show", "declared_ok"), "no robots of"),
        ((), "--x"),
    ],
)
def test_figures_that_cant_be_drawn(results, arguments, rule):
    before = sorted(results.iterdir())
    assert rule in refused_in_a_line("results", "plot", results, *arguments)
    assert sorted(results.iterdir()) == before


def test_a_figure_shows_all_runs_of_a_value(whole):
    points = summaries(Store(whole))
    lines = shares_by_line(points, "tasks.count", None, "accuracy")
    assert list(lines) == [""]
    assert list(lines[""]) == [2, 5, 9]
    for tasks, interval in lines[""].items():
        right = [
            point.found.counts["accuracy"] for point in points if point.row.values["tasks.count"] == tasks
        ]
        assert interval == wilson(sum(right), 48)
    cells = shares_by_line(points, "tasks.count", "decision.strategy", "undecided")
    assert sum(map(len, cells.values())) == 6
    for point in points:
        cell = cells[point.row.values["decision.strategy"]]
        assert cell[point.row.values["tasks.count"]] == wilson(point.found.counts["undecided"], 24)
    assert math.isnan(together([], "accuracy").estimate)


def test_a_word_among_times_has_no_unit():
    base = Scenario(decision={"strategy": "quiet-census"})
    rows = [SimpleNamespace(scenario=base.replace({"acting.start": start})) for start in ("declared", 5)]
    groups = by_value([Summary(row, None) for row in rows], "acting.start", {"acting.start": 0.5})
    assert list(groups) == ["declared", 2.5]


def test_axes_are_in_metres_and_seconds_if_all_points_have_the_same_units(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr("feasibee.figures.style.save_figure", lambda figure, *_: drawn.append(figure))
    base = Scenario(**SMALL, units={"metres": 0.5, "seconds": 2.0}, tasks={"arrival_rate": 0.1})
    worlds = [base.replace({"sensing.range": size, "run.steps": 9}) for size in (1.0, 3.0)]
    for other, ends, labels in (
        (base.units, [0.5, 1.5], ("sensing range $d$ (m)", "task arrival rate (per s)")),
        (None, [1.0, 3.0], ("sensing range $d$ (units)", "task arrival rate (per step)")),
    ):
        folder = tmp_path / labels[0]
        last = worlds[1].replace({"units.metres": other and other.metres})
        complete(
            Study([DesignPoint({}, each) for each in (worlds[0], last)], 2, 5), folder, executors.threads(1)
        )
        for more in ("hue", "y"):
            arguments = ("--x", "sensing.range", f"--{more}", "tasks.arrival_rate", "--show", "right_share")
            output_of("results", "plot", folder, *arguments)
        lines, cells = (each.axes[0] for each in drawn[-2:])
        assert lines.lines[0].get_xdata().tolist() == ends
        assert [each.get_text() for each in cells.get_xticklabels()] == [f"{each:g}" for each in ends]
        assert (cells.get_xlabel(), cells.get_ylabel()) == labels
        assert lines.get_xlabel() == labels[0]


def test_a_piece_is_small_enough_for_the_memory(monkeypatch):
    """A step of a run with curves takes 8 bytes; a piece has room for an eighth of a gigabyte."""
    scenario = study(scenario={**SMALL, "run": {"steps": 10_000_000}}).points[0].scenario
    assert _piece_size(scenario, 100, False) == 1
    monkeypatch.setattr(schedule, "CHUNK_WORK", 10**12)
    assert _piece_size(scenario, 1000, False) == 125
    assert _piece_size(scenario, 1000, True) == 1
    assert _piece_size(scenario, 0, True) == 1
