"""The command line: what it prints, what it writes, how it fails, how it stops."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from click.testing import CliRunner
from commands import invoke, json_of, refused
from declaring import declaring

from feasibee import (
    Scenario,
    decision_rates,
    decision_times,
    open_results,
    scenario_of,
    simulate,
    wilson,
)
from feasibee.cli import main
from feasibee.results.measures import declarations
from feasibee.results.statistics import plain
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record

KEYS = {
    "runs",
    "feasible",
    "infeasible",
    "undecided",
    "decision_step",
    "truth",
    "accuracy",
    "right_at_end",
    "bits_per_robot_and_step",
    "seed",
    "first_run",
    "scenario",
    "scenario_hash",
    "version",
    "model_version",
    "rates",
}
"""What issues 2 and 4 promise of --json, and the number of the first run."""


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def summary_of(*arguments):
    return json_of("run", *arguments)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def no_simulation(monkeypatch):
    """The engine, which must not be asked."""

    def work(*arguments, **options):
        pytest.fail("the simulation began")

    monkeypatch.setattr("feasibee.engine.runner.simulate", work)


# --- Help and version ---


@pytest.mark.parametrize("option", ["--help", "-h"])
@pytest.mark.parametrize("command", [None, *main.commands])
def test_every_help_has_an_example(command, option):
    result = invoke(*([] if command is None else [command]), option)
    assert result.exit_code == 0
    assert "Example" in result.stdout
    assert f"feasibee {command or 'run'}" in result.stdout.split("Example")[1]


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("feasibee run --set tasks.c", "tasks.count="),
        ("feasibee predict --over radio.lo", "radio.loss"),
        ("feasibee results plot --x arena.s", "arena.side"),
        ("feasibee compare --strategies dmmd,cen", "dmmd,census"),
        ("feasibee rec", "recommend"),
    ],
)
def test_the_shell_is_offered_what_may_come(words, offered):
    told = CliRunner().invoke(
        main,
        prog_name="feasibee",
        env={
            "_FEASIBEE_COMPLETE": "bash_complete",
            "COMP_WORDS": words,
            "COMP_CWORD": str(len(words.split()) - 1),
        },
    )
    assert f"plain,{offered}" in told.stdout.splitlines()


def test_the_version_is_the_packages():
    result = invoke("--version")
    assert result.exit_code == 0
    assert result.stdout.split()[-1] == version("feasibee")


# --- run, for programs ---


def test_json_has_declarations_only_if_robots_declare(tmp_path):
    scenario = declaring(tmp_path, quiet=20.0, tasks={"count": 20}, run={"steps": 150})
    (tmp_path / "quiet.toml").write_text(scenario.to_toml())
    summary = summary_of(tmp_path / "quiet.toml", "--runs", 40, "--seed", 1)
    assert set(summary) == KEYS | {"declared"}
    record = simulate_record(scenario, Runs(40, 1))
    found = declarations(record, scenario)
    assert 0 < found.wrong.estimate < 1
    assert summary["bits_per_robot_and_step"] == record.bits_sent.sum() / (40 * 20 * 150)
    assert summary["declared"] == plain(found)
    ended = int((record.feasible_at_end >= 19).sum())
    assert summary["right_at_end"] == wilson(ended, 40)._asdict()
    lines = invoke("run", tmp_path / "quiet.toml", "--runs", 5, "--steps", 10).stdout.splitlines()
    assert (
        "Declared: 0.0% of the robots feasible, 0.0% infeasible; rightly in 0.0% (0.0% to 43.4%), "
        "a robot wrongly in 0.0% (0.0% to 43.4%); half of the swarms never, 95% never." in lines
    )
    assert any(line.startswith("Right at the end: ") for line in lines)


@pytest.mark.parametrize(("tasks", "truth"), [(10, "feasible"), (40, "infeasible")])
def test_json_says_what_the_library_says(tasks, truth):
    summary = summary_of("--set", f"tasks.count={tasks}", "--runs", 30, "--seed", 2**64 - 1, "--run", 100)
    assert set(summary) == KEYS
    scenario = Scenario(tasks={"count": tasks})
    dataset = simulate(scenario, runs=30, seed=2**64 - 1, first_run=100)
    counts = [summary[name] for name in ("feasible", "infeasible", "undecided")]
    assert counts == [int((dataset.decision == code).sum()) for code in (1, 0, -1)]
    assert all(type(count) is int for count in counts)
    assert sum(counts) == summary["runs"] == 30
    assert summary["decision_step"] == decision_times(dataset.decision_step.values.astype(int))._asdict()
    assert all(type(step) in (int, type(None)) for step in summary["decision_step"].values())
    assert summary["rates"] == {
        name: rate._asdict() for name, rate in decision_rates(dataset.decision).items()
    }
    assert (summary["seed"], summary["first_run"]) == (2**64 - 1, 100)
    assert (summary["truth"], summary["accuracy"]) == (truth, summary["rates"][truth])
    assert summary["scenario"] == scenario.to_dict()
    assert summary["scenario_hash"] == scenario.hash
    assert Scenario.model_validate(summary["scenario"]) == scenario
    assert summary["version"] == version("feasibee")
    assert type(summary["model_version"]) is int


def test_a_quartile_that_is_not_reached_is_null():
    arguments = ("--set", "tasks.count=2", "--runs", 40, "--seed", 1)
    whole = summary_of(*arguments)["decision_step"]
    cut = summary_of(*arguments, "--steps", whole["median"])
    assert cut["decision_step"] == {"q25": whole["q25"], "median": whole["median"], "q75": None}
    assert cut["scenario"]["run"]["steps"] == whole["median"]


def test_the_truth_is_that_of_a_step_if_the_world_changes():
    events = ("truth", "--set", "events=[{step = 30, tasks = 5}]")
    assert json_of(*events, "--step", 29)["feasible"]
    violator = json_of(*events, "--step", 30)["violator"]
    assert (violator["demand"], violator["robots"]) == (25, 20)
    assert "robots left over" not in invoke(*events).stdout
    (line,) = refused(*events, "--step", 1001)
    assert "step = 1001: must be a whole number from 0 to 1000" in line


def test_as_many_threads_are_used_as_asked_for(monkeypatch):
    asked = []

    def watch(lowered, record, threads, *more):
        asked.append(threads)

    monkeypatch.setattr("feasibee.engine.runner.simulate", watch)
    for threads in (1, 2, 3):
        assert invoke("run", "--runs", 5, "--workers", threads).exit_code == 0
    assert asked == [1, 2, 3]


# --- run, for people ---


def test_a_table_says_counts_shares_and_steps():
    arguments = ("--set", "tasks.count=2", "--runs", 40, "--seed", 1)
    summary = summary_of(*arguments)
    result = invoke("run", *arguments)
    assert (result.exit_code, result.stderr) == (0, "")
    words = " ".join(result.stdout.split())
    rates = {**summary["rates"], "accuracy": summary["accuracy"]}
    for name, rate in rates.items():
        row = next(line for line in result.stdout.splitlines() if f" {name}" in line)
        assert str(summary.get(name, "")) in row or name == "accuracy"
        assert f"{rate['estimate']:.1%}" in row
        assert f"{rate['low']:.1%} to {rate['high']:.1%}" in row
    for step in summary["decision_step"].values():
        assert f"step {step}" in words
    assert "feasible (true)" in words
    assert "infeasible (true)" not in words
    assert summary["scenario_hash"][:12] in words


def test_one_robot_is_a_robot_and_a_quartile_that_was_not_reached_is_never():
    one = ("--set", "robots.count=1", "--set", "tasks.count=1", "--runs", 1)
    assert "1 robot, 1 task, dmmd: 1 run " in invoke("run", *one).stdout
    words = " ".join(invoke("run", "--steps", 1, "--runs", 5).stdout.split())
    assert words.count("never") == 3
    assert "step -1" not in words


# --- Fields ---


def test_set_takes_every_type():
    summary = summary_of(
        *("--set", "tasks.count=7"),
        *("--set", "sensing.range=3"),
        *("--set", "robots.speed = 0.5"),
        *("--set", "decision.listen=dissemination"),
        *("--set", 'decision.inbox="every-message"'),
        *("--set", "decision.own_vote=false"),
        *("--runs", 2, "--steps", 3),
    )
    scenario = Scenario(
        tasks={"count": 7},
        sensing={"range": 3.0},
        robots={"speed": 0.5},
        decision={"listen": "dissemination", "inbox": "every-message", "own_vote": False},
        run={"steps": 3},
    )
    assert summary["scenario_hash"] == scenario.hash
    assert summary["scenario"]["radio"]["range"] == 3.0


def test_a_file_and_changes_to_it_of_which_the_last_counts_and_steps_before_all(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[tasks]\ncount = 7\n[sensing]\nrange = 1.5\n")
    changes = ("--set", "tasks.count=7", "--set", "tasks.count=8", "--set", "run.steps=9")
    summary = summary_of(path, *changes, "--runs", 1, "--steps", 2)
    expected = Scenario(tasks={"count": 8}, sensing={"range": 1.5}, run={"steps": 2})
    assert summary["scenario_hash"] == expected.hash


@pytest.mark.usefixtures("no_simulation")
@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (["tasks.count"], [("tasks.count", "FIELD=VALUE")]),
        (["tasks.count=many"], [("tasks.count = 'many'", "20")]),
        (["tasks.cuont=5"], [("tasks.cuont = 5", "did you mean tasks.count?")]),
        (["tasks=5"], [("tasks = 5", "tasks.count")]),
        (
            ["robots.count=0", "radio.range=-2.0", "decision.threshold=1.0"],
            [
                ("robots.count = 0", "20"),
                ("radio.range = -2.0", "default"),
                ("decision.threshold = 1.0", "0.9"),
            ],
        ),
    ],
)
def test_bad_fields_are_refused_with_a_line_each(here, changes, expected):
    lines = refused("run", "--json", *(word for change in changes for word in ("--set", change)))
    assert len(lines) == len(expected)
    for line, (path, remedy) in zip(sorted(lines), sorted(expected), strict=True):
        assert line.startswith("feasibee: ")
        assert path in line
        assert remedy in line
    assert names(here) == []


@pytest.mark.usefixtures("no_simulation")
def test_a_bad_file_is_refused_with_its_name(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[tasks]\ncount = -1\ncuont = 1\n[robots]\ncount = 0\n")
    lines = refused("run", path)
    assert [line.startswith(f"feasibee: {path}: ") for line in lines] == [True] * 3
    path.write_text("[tasks\n")
    (line,) = refused("run", path)
    assert f"{path}: not TOML" in line
    (line,) = refused("run", tmp_path / "missing.toml")
    assert "missing.toml: can't be read" in line
    assert str(tmp_path) in refused("run", tmp_path)[-1]


@pytest.mark.usefixtures("no_simulation")
@pytest.mark.parametrize(
    ("option", "number", "word"),
    [
        ("--seed", 2**64, "seed"),
        ("--runs", 0, "runs"),
        ("--runs", 2**32 + 1, "runs"),
        ("--run", 2**32, "first_run"),
        ("--steps", 0, "run.steps"),
    ],
)
def test_impossible_numbers_are_refused(here, option, number, word):
    assert word in refused("run", option, number)[-1]
    assert "curves" in refused("run", "--out", "a.nc", "--runs", 100_000_000)[-1]
    assert names(here) == []


# --- Files ---


def test_save_and_plot_write_whole_files_and_nothing_else(here):
    result = invoke(
        "run", "--runs", 6, "--seed", 2, "--steps", 50, "--out", "a.nc", "--out", "b.png", "--json"
    )
    assert result.exit_code == 0, result.stderr
    assert names(here) == ["a.nc", "b.png"]
    scenario = Scenario(run={"steps": 50})
    assert json.loads(result.stdout) == summary_of("--runs", 6, "--seed", 2, "--steps", 50)
    opened = open_results(here / "a.nc")
    assert opened.identical(simulate(scenario, runs=6, seed=2, curves=True))
    assert scenario_of(opened).hash == json.loads(result.stdout)["scenario_hash"]
    picture = (here / "b.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert picture.rstrip().endswith(b"IEND\xaeB`\x82")


def test_runs_saved_as_csv_are_those_saved_as_netcdf(here):
    arguments = ("--runs", 6, "--seed", 2, "--run", 3, "--set", "decision.declare.rounds=2")
    for name in ("a.csv", "a.nc"):
        assert invoke("run", *arguments, "--out", name).exit_code == 0
    header, *rows = (line.split(",") for line in (here / "a.csv").read_text().splitlines())
    assert header[:4] == ["run", "decision", "decision_step", "bits_sent"]
    opened = open_results("a.nc")
    assert sorted(header[1:]) == sorted(name for name, each in opened.data_vars.items() if each.ndim == 1)
    for name, values in zip(header, zip(*rows, strict=True), strict=True):
        assert [int(value) for value in values] == opened[name].values.tolist()


@pytest.mark.usefixtures("no_simulation")
@pytest.mark.parametrize("name", ["a.txt", "a", "a.nc.gz", ".nc", "a.nc4", "a.docx", "a.pgf", "a.png.txt"])
def test_an_unknown_kind_of_file_is_refused_before_the_work(here, name):
    (line,) = refused("run", "--out", name)
    known = ".nc, .csv, .png, .pdf or .svg"
    assert line == f"feasibee: --out {name}: unknown file format; end the name with {known}"
    assert names(here) == []


@pytest.mark.usefixtures("no_simulation")
def test_a_report_as_pdf_is_printed_from_its_page(here):
    (line,) = refused("assess", "--out", "a.pdf")
    rule = "unknown file format; end the name with .html or .htm, and print that page for PDF"
    assert line == f"feasibee: --out a.pdf: {rule}"


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", ["a.png", "a.pdf", "a.svg", "A.PNG"])
def test_a_plot_is_of_the_kind_of_its_suffix(here, name):
    assert invoke("run", "--runs", 3, "--steps", 5, "--out", name).exit_code == 0
    start = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[name.lower().rpartition(".")[2]]
    assert (here / name).read_bytes().startswith(start)
    assert names(here) == [name]


@pytest.mark.usefixtures("no_simulation")
def test_one_file_for_results_and_plot_is_refused_before_the_work(here):
    (here / "a.nc").symlink_to("a.png")
    (line,) = refused("run", "--out", "a.nc", "--out", f"../{here.name}/a.png")
    assert "a.png: can't both be written" in line
    assert names(here) == ["a.nc"]


@pytest.mark.parametrize("name", ["a.nc", "a.png"])
def test_a_link_stays_a_link_and_its_file_is_replaced(here, name):
    """Matplotlib would write beside a temporary file without a suffix, and leave that one empty."""
    (here / "real").write_text("old")
    (here / name).symlink_to("real")
    assert invoke("run", "--runs", 2, "--steps", 5, "--out", name).exit_code == 0
    assert (here / name).is_symlink()
    assert (here / "real").read_bytes()[:4] in (b"\x89PNG", b"\x89HDF")
    assert names(here) == [name, "real"]


def test_without_options_nothing_is_written(here):
    for command in (["run", "--runs", 2, "--steps", 5], ["scenario"], ["schema"], ["--help"]):
        assert invoke(*command).exit_code == 0
    assert names(here) == []


# --- scenario, schema, paper ---


def test_scenario_prints_toml_that_run_accepts(tmp_path):
    printed = invoke("scenario", "--set", "sensing.range=3.0", "--set", "tasks.count=7")
    assert printed.exit_code == 0
    assert "# Range of observation d, in units, from centre to centre.\nrange = 3.0\n" in printed.stdout
    expected = Scenario(sensing={"range": 3.0}, tasks={"count": 7})
    assert Scenario.from_toml(printed.stdout) == expected
    path = tmp_path / "mine.toml"
    path.write_text(printed.stdout)
    assert summary_of(path, "--runs", 1)["scenario_hash"] == expected.hash
    assert invoke("scenario", path).stdout == printed.stdout
    assert Scenario.from_toml(invoke("scenario").stdout) == Scenario()


def test_schema_prints_the_schema_of_scenarios():
    result = invoke("schema")
    assert result.exit_code == 0
    assert json.loads(result.stdout) == Scenario.model_json_schema()


def test_paper_writes_figures_and_says_of_each_claim_whether_it_holds(here):
    result = invoke("paper", "--out", "out/figures", "--runs", 4, "--seed", 3)
    assert result.exit_code == 0, result.stderr
    assert names(here) == ["out"]
    written = json.loads((here / "out/figures/claims.json").read_text())
    assert len([name for name in names(here / "out/figures") if name.endswith((".png", ".pdf"))]) == 8
    verdicts = [claim["verdict"] for claim in written["claims"]]
    cells = [cell.strip() for line in result.stdout.splitlines() for cell in line.split("│")]
    assert [cell for cell in cells if cell in {"holds", "fails", "can't tell"}] == verdicts
    assert "out/figures" in result.stdout
    # enough that the claims can be told
    assert "[default: 2000;" in " ".join(invoke("paper", "--help").stdout.split())


def test_too_little_memory_is_told(monkeypatch):
    def work(*arguments, **options):
        raise MemoryError

    monkeypatch.setattr("feasibee.engine.runner.simulate", work)
    (line,) = refused("run")
    assert "memory" in line


# --- Real processes ---


def start(*arguments, **options):
    return subprocess.Popen(
        [sys.executable, "-m", "feasibee", *map(str, arguments)],
        text=True,
        **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options},
    )


def test_as_a_module_standard_output_is_one_json_object_and_nothing_else(tmp_path):
    expected = summary_of("--runs", 40, "--seed", 3, "--workers", 1)
    process = start("run", "--json", "--runs", 40, "--seed", 3, "--workers", 2, cwd=tmp_path)
    output, errors = process.communicate(timeout=240)
    assert (process.returncode, errors, json.loads(output)) == (0, "", expected)
    assert names(tmp_path) == []


def test_a_reader_that_goes_away_leaves_no_traceback():
    process = start("schema")
    process.stdout.close()
    errors = process.stderr.read()
    process.stderr.close()
    process.wait(timeout=240)
    assert "Traceback" not in errors


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize("command", ["scenario", "truth"])
def test_output_that_finds_no_room_is_told(command):
    with Path("/dev/full").open("w") as full:
        process = start(command, stdout=full)
        _, errors = process.communicate(timeout=240)
    assert process.returncode == 2
    assert errors.splitlines() == [
        "feasibee: the output: can't be written: No space left on device; free some disk space"
    ]


@pytest.mark.slow
def test_names_that_look_like_markup_are_printed_as_they_are(here):
    """Rich's tables take [/red] for the end of a colour, and :bee: for a bee."""
    (here / "study.toml").write_text('runs = 2\n[scenario]\nrun.steps = 3\n[sweep]\n"tasks.count" = [2]\n')
    for folder in ("[", "[red]a", ":bee:"):
        (here / folder).mkdir()
        assert invoke("sweep", "study.toml", "--out", f"{folder}/red]").exit_code == 0
        told = invoke("results", "status", f"{folder}/red]")
        assert told.exit_code == 0
        assert f"{folder}/red]: 2 runs" in told.stdout.replace("\n", " ")
    shutil.copy(Path(__file__).parents[2] / "examples" / "strategies" / "witness.py", here / "[" / "b].py")
    change = "decision.strategy=[/b].py"
    told = invoke("run", "--set", change, "--runs", 2, "--steps", 5)
    assert "[/b].py: 2 runs" in told.stdout
    told = invoke(
        "compare", "--strategies", "dmmd,[/b].py", "--tasks", "5", "--runs", 2, "--set", "run.steps=5"
    )
    assert "b].py" in told.stdout


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="no names of files in any bytes")
@pytest.mark.parametrize("locale", ["C", "C.UTF-8"])
def test_a_name_that_isnt_text_is_printed_somehow(tmp_path, locale):
    """Whether it is wrong or right, and whatever the terminal can show."""
    environment = {**os.environ, "LC_ALL": locale, "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}

    def run(*words):
        command = [sys.executable, "-m", "feasibee", *words]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, check=False)

    told = run("truth", b"\xff\xe9.toml")
    assert (told.returncode, told.stdout) == (2, b"")
    assert told.stderr.startswith(b"feasibee: \\udcff\\udce9.toml: can't be read: No such file")
    told = run("animate", "--frames", "1", "--out", b"\xff.png")
    assert told.returncode == 0, told.stderr
    assert told.stdout.startswith(b"Wrote ")
    assert (tmp_path / os.fsdecode(b"\xff.png")).is_file()


def test_progress_has_a_time_once_runs_are_done_and_never_less_than_is_sure():
    from dataclasses import replace

    from feasibee.cli.execution import _done
    from feasibee.sweeps.sweep import Progress

    begun = Progress(runs=27_600, runs_done=56, work=27_600, work_done=56, most=27_600, seconds=10.0)
    assert _done(begun) == "56 of 27,600 runs"
    slow = replace(begun, runs_new=4, work_new=4)
    assert _done(slow) == "56 of 27,600 runs, 0.4 runs/s, about 19 h left"
    fast = replace(begun, runs_done=20_000, work_done=20_000, runs_new=10_000, work_new=10_000)
    assert _done(fast) == "20,000 of 27,600 runs, 1,000 runs/s, about 8 s left"
    assert _done(replace(fast, most=200_000)).endswith(
        " of 27,600 or more runs, 1,000 runs/s, 8 s to 3 min left"
    )
    assert _done(replace(fast, is_bounded=False)).endswith(
        " of 27,600 or more runs, 1,000 runs/s, at least 8 s left"
    )
