"""Results carry names, meanings and their recipe, into a file and back."""

from __future__ import annotations

import gc
import json
import os
import random
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import h5netcdf
import numpy as np
import pytest
import xarray as xr
from commands import invoke
from declaring import declaring

from feasibee import FeasibeeError, Scenario, open_results, save_results, scenario_of, simulate
from feasibee.base.record import Record
from feasibee.results.dataset import recipe_of, to_dataset
from feasibee.strategies import dmmd

SCENARIO = Scenario(robots={"count": 5}, tasks={"count": 9}, run={"steps": 3})
RECORD = replace(
    Record.empty(40, 2, 4),
    decision=np.array([1, -1], np.int8),
    decision_step=np.array([2, -1], np.int32),
    feasible_count=np.array([[3, 4, 5, 5], [2, 2, 3, 2]], np.int32),
    infeasible_count=np.array([[2, 1, 0, 0], [3, 3, 2, 3]], np.int32),
    account=np.array([[70, -1, 0, 0, 5, 0], [65, 8, 2, 3, 2, 3]]),
)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


# --- Labels ---


def test_a_record_gets_names_dimensions_and_coordinates():
    dataset = to_dataset(RECORD, SCENARIO, seed=7)
    assert dataset.decision.dims == dataset.decision_step.dims == ("run",)
    assert dataset.feasible_count.dims == ("run", "step")
    assert dataset.run.values.tolist() == [40, 41]
    assert dataset.step.values.tolist() == [0, 1, 2, 3]
    assert dataset.decision.values.tolist() == [1, -1]
    assert dataset.decision_step.sel(run=40) == 2
    assert dataset.feasible_count.sel(run=41, step=2) == 3
    assert dataset.infeasible_count.sel(run=41, step=2) == 2
    assert dataset.bits_sent.values.tolist() == [70, 65]


@pytest.mark.parametrize("by_votes", [False, True])
def test_declarations_are_labelled_if_robots_declare(by_votes, tmp_path):
    own = declaring(tmp_path, robots={"count": 5})
    scenario = SCENARIO.replace({"decision.declare.rounds": 2}) if by_votes else own
    dataset = to_dataset(RECORD, scenario, seed=7)
    assert all(dataset[name].attrs["long_name"] for name in dataset.data_vars)
    assert dataset.declare_step.values.tolist() == [-1, 8]
    assert dataset.declared_feasible.values.tolist() == [0, 2]
    assert dataset.declared_infeasible.values.tolist() == [0, 3]
    assert dataset.declare_step.attrs["long_name"].endswith("; -1: never")
    assert "declare_step" not in to_dataset(RECORD, SCENARIO, seed=7)


def test_labels_say_meaning_type_and_unit():
    dataset = to_dataset(RECORD, SCENARIO, seed=7)
    assert all(variable.attrs["long_name"] for variable in dataset.variables.values())
    kinds = {name: (str(each.dtype), each.attrs.get("units")) for name, each in dataset.variables.items()}
    assert kinds == {
        "decision": ("int8", None),
        "decision_step": ("int32", "step"),
        **dict.fromkeys(("feasible_count", "infeasible_count"), ("int32", "robots")),
        **dict.fromkeys(("feasible_at_end", "infeasible_at_end"), ("int64", "robots")),
        "bits_sent": ("int64", "bit"),
        "run": ("int64", None),
        "step": ("int64", "step"),
    }
    meanings = dataset.decision.attrs["flag_meanings"].split()
    assert dict(zip(dataset.decision.attrs["flag_values"].tolist(), meanings, strict=True)) == {
        1: "feasible",
        0: "infeasible",
        -1: "undecided",
    }
    assert dataset.decision.attrs["flag_values"].dtype == dataset.decision.dtype


def test_without_curves_there_is_no_step():
    dataset = to_dataset(Record.empty(0, 3, 0), SCENARIO, seed=7)
    ends = {"feasible_at_end", "infeasible_at_end"}
    assert set(dataset.variables) == {"decision", "decision_step", "bits_sent", "run", *ends}


def test_the_recipe_holds_the_text_of_a_users_strategy(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(Path(dmmd.__file__).read_text())
    mine = SCENARIO.replace({"decision.strategy": str(path)})
    assert json.loads(to_dataset(RECORD, mine, 0).attrs["recipe"])["strategy_source"] == path.read_text()
    assert "strategy_source" not in json.loads(to_dataset(RECORD, SCENARIO, 0).attrs["recipe"])


def test_the_recipe_says_all_that_made_the_record():
    recipe = json.loads(to_dataset(RECORD, SCENARIO, seed=2**64 - 1).attrs["recipe"])
    assert recipe == recipe_of(to_dataset(RECORD, SCENARIO, seed=2**64 - 1))
    names = "scenario scenario_hash seed first_run runs truth model_version version python libraries"
    assert list(recipe) == names.split()
    assert recipe["scenario"] == SCENARIO.to_dict()
    assert recipe["scenario_hash"] == SCENARIO.hash
    assert (recipe["seed"], recipe["first_run"], recipe["runs"]) == (2**64 - 1, 40, 2)
    assert recipe["truth"] == "infeasible"
    assert recipe_of(to_dataset(RECORD, SCENARIO.replace({"tasks.count": 5}), 0))["truth"] == "feasible"
    assert {"numpy", "xarray"} <= set(recipe["libraries"])


# --- Computed again ---


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"sensing.range": 3.0, "radio.range": 1.5, "decision.listen": "dissemination"},
        {"run.stop_at_decision": True, "tasks.count": 2, "decision.threshold": 0.55},
    ],
)
def test_the_recipe_suffices_to_compute_the_results_again(changes):
    scenario = Scenario(run={"steps": 40}).replace(changes)
    dataset = simulate(scenario, runs=6, seed=2**40 + 3, first_run=1000, curves=True)
    recipe = recipe_of(dataset)
    numbers = {name: recipe[name] for name in ("runs", "seed", "first_run")}
    again = simulate(Scenario.model_validate(recipe["scenario"]), **numbers, curves=True)
    assert again.identical(dataset)
    assert simulate(scenario, runs=6, seed=2**40 + 4, first_run=1000, curves=True).equals(dataset) is False


# --- Files ---


@pytest.mark.parametrize("curves", [False, True])
def test_saved_results_are_identical_when_opened(tmp_path, curves):
    scenario = Scenario(run={"steps": 30})
    dataset = simulate(scenario, runs=4, seed=1, first_run=9, curves=curves)
    save_results(dataset, tmp_path / "a.nc")
    opened = open_results(str(tmp_path / "a.nc"))
    assert opened.identical(dataset)
    assert {name: v.dtype for name, v in opened.variables.items()} == {
        name: v.dtype for name, v in dataset.variables.items()
    }
    assert scenario_of(opened) == scenario_of(dataset) == scenario
    assert names(tmp_path) == ["a.nc"]


def test_opened_results_do_not_hold_the_file(tmp_path):
    dataset = to_dataset(RECORD, SCENARIO, 0)
    save_results(dataset, tmp_path / "a.nc")
    opened = open_results(tmp_path / "a.nc")
    (tmp_path / "a.nc").unlink()
    assert opened.identical(dataset)
    save_results(opened, tmp_path / "a.nc")
    save_results(open_results(tmp_path / "a.nc"), tmp_path / "a.nc")
    assert open_results(tmp_path / "a.nc").identical(dataset)


def test_curves_are_packed(tmp_path):
    record = Record.empty(0, 100, 1001)
    record.feasible_count[:] = 0
    save_results(to_dataset(record, SCENARIO, 0), tmp_path / "a.nc")
    assert (tmp_path / "a.nc").stat().st_size < record.feasible_count.nbytes / 4


@pytest.mark.quick(1)
@pytest.mark.skipif(os.name == "nt", reason="no limits of the size of files")
@pytest.mark.parametrize("name", ["a.nc", "a.csv"])
def test_a_full_disk_is_an_error_and_leaves_nothing(tmp_path, name, capfd, monkeypatch):
    """No file may grow beyond some kilobytes here, nor a compiled module, which Python would keep cut off."""
    import resource

    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    dataset = to_dataset(Record.empty(0, 1000, 10), SCENARIO, 0)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (5_000, before[1]))
    try:
        with pytest.raises(FeasibeeError, match=rf"{name}: can't be written: .*; free disk space"):
            save_results(dataset, tmp_path / name)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    del dataset
    gc.collect()
    assert names(tmp_path) == []
    assert capfd.readouterr() == ("", "")


# --- What isn't ours ---


@pytest.mark.parametrize("content", [None, b"", b"decision,step\n1,2\n", b"CDF\x01" + bytes(40), "half"])
def test_what_is_not_netcdf_is_told(tmp_path, content):
    """No file, none of ours, and one cut short."""
    if content == "half":
        save_results(to_dataset(RECORD, SCENARIO, 0), tmp_path / "a.nc")
        whole = (tmp_path / "a.nc").read_bytes()
        content = whole[: len(whole) // 2]
    if content is not None:
        (tmp_path / "a.nc").write_bytes(content)
    with pytest.raises(FeasibeeError, match=r"a\.nc: can't be read as NetCDF"):
        open_results(tmp_path / "a.nc")
    assert names(tmp_path) == ["a.nc"] * (content is not None)


# --- Saving as CSV, and kinds that aren't known ---


@pytest.mark.parametrize("name", ["a.txt", "a", "a.parquet"])
def test_results_are_saved_in_known_kinds_only(tmp_path, name):
    with pytest.raises(FeasibeeError, match=r"unknown file format; end the name with \.nc or \.csv"):
        save_results(to_dataset(RECORD, SCENARIO, 0), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_one_run_alone_has_no_table(tmp_path):
    with pytest.raises(FeasibeeError, match="results without the dimension run"):
        save_results(to_dataset(RECORD, SCENARIO, 0).isel(run=0), tmp_path / "a.csv")


@pytest.mark.parametrize("wrong", [None, 5, "a.nc", {"recipe": "{}"}, xr.DataArray([1])])
def test_what_isnt_a_dataset_is_told(tmp_path, wrong):
    for use in (scenario_of, lambda each: save_results(each, tmp_path / "a.nc")):
        with pytest.raises(FeasibeeError, match=r"must be a Dataset; use one that"):
            use(wrong)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "recipe",
    [None, "pancakes", "{}", "[" * 100_000, '{"scenario": ' * 50_000, "[]", '{"scenario": 5}', 5, [1.0, 2.0]],
    ids=lambda recipe: str(recipe)[:20],  # pytest puts it into the environment of the process that reads
)
def test_a_recipe_that_isnt_one_is_told(tmp_path, recipe):
    """Deep nesting ended in a RecursionError."""
    attributes = {} if recipe is None else {"recipe": recipe}
    xr.Dataset({"a": ("x", [1, 2])}, attrs=attributes).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    with pytest.raises(FeasibeeError, match=r"a\.nc: results without a recipe in their attributes"):
        open_results(tmp_path / "a.nc")


def test_a_small_file_that_claims_to_be_huge_is_told(tmp_path):
    with h5netcdf.File(tmp_path / "a.nc", "w") as file:
        file.attrs["recipe"] = to_dataset(RECORD, SCENARIO, 0).attrs["recipe"]
        file.dimensions = {"run": 10**6, "step": 10**6}
        file.create_variable("feasible_count", ("run", "step"), "i4", chunks=(1000, 1000))
    assert (tmp_path / "a.nc").stat().st_size < 10_000
    with pytest.raises(FeasibeeError, match="it has 3725 GiB, above the limit of 20 GiB; name a file"):
        open_results(tmp_path / "a.nc")


@pytest.mark.parametrize("path", ["/dev/zero", "/dev/null", "a\0b", "x" * 5000, "http://localhost:1/a.nc"])
def test_what_isnt_a_plain_file_is_never_opened(path):
    with pytest.raises(FeasibeeError, match=r"NetCDF: (it isn't a plain|there is no such) file") as caught:
        open_results(path)
    assert len(str(caught.value)) <= 400


@pytest.mark.slow
def test_a_file_of_something_else_is_told_in_a_line_and_no_more(tmp_path):
    """h5netcdf printed a traceback beside the error, from where it gives up what it hadn't opened."""
    (tmp_path / "a.nc").write_text("run,decision\n")
    script = """
import feasibee
try:
    feasibee.open_results("a.nc")
except feasibee.FeasibeeError as error:
    print(error)
"""
    told = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert told.stdout.startswith("a.nc: can't be read as NetCDF: ")
    assert told.stderr == ""


def looping(data):
    """Return a file in which HDF5 loops forever: the next object of its heap is the same one again."""
    heap = data.index(b"GCOL")
    size = heap + 24  # of its first object, whose header has 16 bytes
    return data[:size] + (2**64 - 16).to_bytes(8, "little") + data[size + 8 :]


def reproducing(folder, limit_s):
    """Start `feasibee run --again` with a file in which HDF5 loops; return when its reading begins."""
    save_results(to_dataset(RECORD, SCENARIO, 7), folder / "a.nc")
    (folder / "a.nc").write_bytes(looping((folder / "a.nc").read_bytes()))
    script = f"""
from feasibee.cli import main
from feasibee.results import reading

def parts(stream, parts=reading._parts):
    print("ready", flush=True)
    return parts(stream)

reading._parts = parts
reading.LIMIT_S = {limit_s}
main(prog_name="feasibee")
"""
    words = [sys.executable, "-c", script, "run", "--again", "a.nc"]
    process = subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    return process


def test_a_file_in_which_hdf5_loops_is_told_within_a_limit(tmp_path):
    process = reproducing(tmp_path, 0.1)
    told = process.communicate(timeout=100)[1]
    assert process.returncode == 2
    assert told.startswith(
        "feasibee: a.nc: can't be read as NetCDF: HDF5 crashed, or was stopped after 0.1 s"
    )
    assert told.count("\n") == 1


@pytest.mark.skipif(os.name == "nt", reason="no signals to send")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_a_command_while_hdf5_loops(tmp_path, number):
    process = reproducing(tmp_path, 900)
    process.send_signal(number)
    told = process.communicate(timeout=100)[1]
    assert process.returncode == 128 + number
    assert told.count("\n") == 1


def damaged(data, case):
    """Return a file damaged in a fixed way, mostly where its structure is."""
    draw = random.Random(case)
    place, size = draw.randrange(min(8000, len(data))), draw.choice((1, 8, 64, 512))
    before, after = data[:place], data[place + size :]
    flipped = bytes(each ^ 1 << draw.randrange(8) for each in data[place : place + size])
    return (before + flipped + after, before + bytes(size) + after, before, before + data[size:])[case % 4]


@pytest.mark.slow
def test_damaged_files_are_read_or_told_in_a_line(tmp_path):
    save_results(simulate(SCENARIO, runs=20, seed=1, curves=True), tmp_path / "a.nc")
    data = (tmp_path / "a.nc").read_bytes()
    for case in range(16):
        (tmp_path / "b.nc").write_bytes(damaged(data, case))
        result = invoke("run", "--again", tmp_path / "b.nc")
        assert result.exit_code in (0, 1, 2), (case, result.output, result.exception)
        assert result.exit_code != 2 or len(result.stderr.splitlines()) == 1, (case, result.stderr)


def test_no_flipped_bit_of_saved_results_changes_a_number(tmp_path):
    """Where HDF5 itself sees nothing wrong: in values that aren't compressed."""
    dataset = simulate(SCENARIO, runs=40, seed=1)
    save_results(dataset, tmp_path / "a.nc")
    assert open_results(tmp_path / "a.nc").identical(dataset)
    data = (tmp_path / "a.nc").read_bytes()
    starts = [
        data.find(dataset[name].values.tobytes()) for name in ("decision", "decision_step", "bits_sent")
    ]
    assert min(starts) > 0
    for place in (*starts, data.find(b'"seed": 1') + 8):
        damaged = bytearray(data)
        damaged[place] ^= 1
        (tmp_path / "b.nc").write_bytes(damaged)
        with pytest.raises(FeasibeeError, match=r"b.nc: differs from what save_results wrote; name"):
            open_results(tmp_path / "b.nc")


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    "change",
    [
        lambda saved: saved.assign_attrs(recipe=saved.attrs["recipe"].replace('"runs": 2', '"runs": 3')),
        lambda saved: saved.assign_coords(run=saved.run + 1),
        lambda saved: saved.rename(bits_sent="bits_spent"),
        lambda saved: saved.assign(decision=("robot", saved.decision.values)),
        lambda saved: saved.assign(decision_step=saved.decision_step.astype(np.uint32)),
        lambda saved: saved.drop_vars("bits_sent"),
    ],
)
def test_what_is_saved_by_another_program_with_the_old_digest_is_told(tmp_path, change):
    """Names, dimensions and types are part of the digest, as the values and the recipe are."""
    save_results(to_dataset(RECORD, SCENARIO, 7), tmp_path / "a.nc")
    with xr.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as saved:
        changed = change(saved.load())
    changed.to_netcdf(tmp_path / "b.nc", engine="h5netcdf")
    with pytest.raises(FeasibeeError, match=r"b.nc: differs from what save_results wrote; name"):
        open_results(tmp_path / "b.nc")
