"""The command line: what it prints, what it writes, how it fails, how it stops."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from importlib.metadata import version
from itertools import chain
from pathlib import Path

import pytest
from click.testing import CliRunner
from commands import invoke, json_of, output_of, refused, refused_in_a_line
from declaring import declaring

from feasibee import Scenario, decision_rates, decision_times, open_results, scenario_of, simulate, wilson
from feasibee.cli import main
from feasibee.cli.commands import RENAMED
from feasibee.cli.execution import _done
from feasibee.results.measures import declarations
from feasibee.results.statistics import plain
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.sweep import Progress

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


@pytest.mark.parametrize("command", [None, *main.commands])
def test_every_help_has_an_example(command):
    result = invoke(*([] if command is None else [command]), "--help" if command else "-h")
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
        ("feasibee robot re", "replay"),
        ("feasibee comp", "compare"),
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


@pytest.mark.parametrize("old", RENAMED)
def test_an_old_command_names_the_new_one(old):
    name = RENAMED[old]
    assert refused_in_a_line(old) == f"feasibee: {old}: is now feasibee {name}"
    assert invoke(*name.split(), "--help").exit_code == 0


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
    said = output_of("run", tmp_path / "quiet.toml", "--runs", 5, "--steps", 10)
    assert said.splitlines()[-1] == "Declared rightly in 0 % of the runs (0 to 43), wrongly in 0 % (0 to 43)."


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
    assert summary["version"] == version("feasibee") == invoke("--version").stdout.split()[-1]
    assert type(summary["model_version"]) is int


def test_the_truth_is_that_of_a_step_if_the_world_changes():
    events = ("show", "truth", "--set", "events=[{step = 30, tasks = 5}]")
    assert json_of(*events, "--step", 29)["feasible"]
    violator = json_of(*events, "--step", 30)["violator"]
    assert (violator["demand"], violator["robots"]) == (25, 20)
    assert "robots left over" not in invoke(*events).stdout
    (line,) = refused(*events, "--step", 1001)
    assert "step = 1001: must be a whole number from 0 to 1000" in line


def test_as_many_threads_are_used_as_asked_for(monkeypatch):
    asked = []
    monkeypatch.setattr("feasibee.engine.runner.simulate", lambda *given: asked.append(given[2]))
    for threads in (1, 3):
        assert invoke("run", "--runs", 5, "--workers", threads).exit_code == 0
    assert asked == [1, 3]


# --- run, for people ---


ANSWERS = {
    "": "Right in 54 % of the runs (44 to 63): feasible 54, infeasible 46, undecided 0.\n"
    "The tasks are feasible. Half of the runs decided by step 136 of 1,000.",
    "--steps 20 --runs 2000": "Right in 0 % of the runs (0 to 0.2): feasible 0, infeasible 1, "
    "undecided 1,999.\n"
    "The tasks are feasible. Fewer than half decided within 20 steps.",
    "--runs 1 --run 3": "Run 3 decided feasible, rightly, by step 293 of 1,000. The tasks are feasible.",
    "--runs 1 --steps 20": "Run 0 didn't decide within 20 steps. The tasks are feasible.",
    "--runs 200 --set robots.know_count=true --set decision.strategy=turns": "Right in 100 % of the runs (98 "
    "to 100): feasible 200, infeasible 0, undecided 0.\n"
    "The tasks are feasible. Half of the runs decided by step 34 of 1,000.\n"
    "Declared rightly in 100 % of the runs (98 to 100), wrongly in 0 % (0 to 2).",
    "--set acting.start=0 --set tasks.count=18 --set decision.strategy=census": "Right in 100 % of the runs "
    "(96 to 100): feasible 100, infeasible 0, undecided 0.\n"
    "The tasks are feasible. Half of the runs decided by step 38 of 1,000.\n"
    "All tasks were taken in 100 % of the runs (96 to 100), in half by step 92.",
    "--set acting.start=0 --set tasks.count=25": "Right in 0 % of the runs (0 to 4): "
    "feasible 0, infeasible 0, undecided 100.\n"
    "The tasks are infeasible. Fewer than half decided within 1,000 steps.\n"
    "Robots started in vain in 100 % of the runs (96 to 100).",
}
"""Options of run, and all that it prints then."""


@pytest.mark.parametrize("options", ANSWERS)
def test_the_answer_comes_first_in_few_lines_and_words(options):
    assert invoke("run", *options.split()).stdout == f"{ANSWERS[options]}\n"


def test_details_have_each_measure_of_json_with_its_interval():
    arguments = ("--set", "tasks.count=2", "--runs", 40, "--seed", 1, "--set", "acting.start=0")
    summary = summary_of(*arguments)
    lines = output_of("run", *arguments, "--details").partition("\n\n")[2].splitlines()
    said = dict(line.split(maxsplit=1) for line in lines)
    assert {name.partition(".")[0] for name in said} == set(summary) - {"scenario"}
    for name in ("runs", "seed", "scenario_hash"):
        assert said[name] == str(summary[name])
    for name, rate in (*summary["rates"].items(), ("acting.done", summary["acting"]["done"])):
        shown = said[name if name in said and "." in name else f"rates.{name}"]
        assert shown == f"{rate['estimate']:.3g} ({rate['low']:.3g} to {rate['high']:.3g})"
    taken = summary["acting"]["all_taken_step"]
    low, high = taken["median_interval"]
    assert said["acting.all_taken_step.median"] == f"{taken['median']} ({low} to {high})"
    assert said["acting.all_done_step"] == "none"


# --- Fields ---


def test_set_takes_every_type_changes_a_file_and_the_last_counts_but_steps_before_all(tmp_path):
    (path := tmp_path / "mine.toml").write_text("[tasks]\ncount = 7\n[sensing]\nrange = 1.5\n")
    changes = ("tasks.count=7", "tasks.count=8", "run.steps=9", "robots.speed = 0.5", "radio.range=3")
    more = ("decision.listen=dissemination", 'decision.inbox="every-message"', "decision.own_vote=false")
    words = chain(*(("--set", change) for change in changes + more))
    expected = Scenario(
        tasks={"count": 8},
        sensing={"range": 1.5},
        robots={"speed": 0.5},
        radio={"range": 3.0},
        decision={"listen": "dissemination", "inbox": "every-message", "own_vote": False},
        run={"steps": 2},
    )
    assert summary_of(path, *words, "--runs", 1, "--steps", 2)["scenario_hash"] == expected.hash


@pytest.mark.usefixtures("no_simulation")
def test_wrong_fields_and_numbers_are_refused_with_a_line_each(here):
    """What is wrong with each is in tests/scenario."""
    expected = {
        "robots.count=0": ("robots.count = 0", "20"),
        "tasks.cuont=5": ("tasks.cuont = 5", "did you mean tasks.count?"),
        "tasks.count=many": ("tasks.count = 'many'", "20"),
    }
    lines = refused("run", "--json", *(word for change in expected for word in ("--set", change)))
    assert len(lines) == len(expected)
    for path, remedy in expected.values():
        assert any(line.startswith(f"feasibee: {path}") and remedy in line for line in lines)
    for option, number, word in (
        ("--seed", 2**64, "seed"),
        ("--run", 2**32, "first_run"),
        ("--steps", 0, "steps"),
    ):
        assert word in refused("run", option, number)[-1]
    for option, text, rule in (
        ("--runs", "0", "'--runs': 0 must be at least 1."),
        ("--runs", "ten", "'--runs': 'ten' must be a whole number."),
        ("--workers", "1025", "'--workers': 1025 must be from 1 to 1024."),
    ):
        assert rule in refused("run", option, text)[-1]
    assert "'--right': 95.0 must be above 0 and below 1." in refused("size", "--right", "95")[-1]
    assert "FIELD=VALUE" in refused("run", "--set", "tasks.count")[-1]
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
@pytest.mark.parametrize("name", ["a.txt", "a", "a.nc.gz", ".nc"])
def test_an_unknown_kind_of_file_is_refused_before_the_work(here, name):
    (line,) = refused("run", "--out", name)
    known = ".nc, .csv, .png, .pdf, .svg, .gif, .webp, .mp4 or .html"
    assert line == f"feasibee: --out {name}: unknown file format; end the name with {known}"
    assert names(here) == []


@pytest.mark.usefixtures("no_simulation")
def test_a_report_as_pdf_is_printed_from_its_page(here):
    (line,) = refused("assess", "--out", "a.pdf")
    rule = "unknown file format; end the name with .html or .htm, and print that page for PDF"
    assert line == f"feasibee: --out a.pdf: {rule}"


@pytest.mark.parametrize(("name", "start"), [("a.pdf", b"%PDF"), ("A.PNG", b"\x89PNG")])
def test_a_plot_is_of_the_kind_of_its_suffix(here, name, start):
    assert invoke("run", "--runs", 3, "--steps", 5, "--out", name).exit_code == 0
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
    for command in (["run", "--runs", 2, "--steps", 5], ["show", "scenario"], ["--help"]):
        assert invoke(*command).exit_code == 0
    assert json.loads(invoke("show", "schema").stdout) == Scenario.model_json_schema()
    assert names(here) == []


# --- scenario, schema, paper ---


def test_scenario_prints_toml_that_run_accepts(tmp_path):
    printed = invoke("show", "scenario", "--set", "sensing.range=3.0", "--set", "tasks.count=7")
    assert printed.exit_code == 0
    assert "# Range of observation d, in units, from centre to centre.\nrange = 3.0\n" in printed.stdout
    expected = Scenario(sensing={"range": 3.0}, tasks={"count": 7})
    assert Scenario.from_toml(printed.stdout) == expected
    path = tmp_path / "mine.toml"
    path.write_text(printed.stdout)
    assert summary_of(path, "--runs", 1)["scenario_hash"] == expected.hash
    assert invoke("show", "scenario", path).stdout == printed.stdout
    assert Scenario.from_toml(invoke("show", "scenario").stdout) == Scenario()


def test_paper_writes_figures_and_says_of_each_claim_whether_it_holds(here):
    result = invoke("paper", "--out", "out/figures", "--runs", 4, "--seed", 3)
    assert result.exit_code == 0, result.stderr
    assert names(here) == ["out"]
    written = json.loads((here / "out/figures/claims.json").read_text())
    assert len([name for name in names(here / "out/figures") if name.endswith((".png", ".pdf"))]) == 8
    verdicts = [claim["verdict"] for claim in written["claims"]]
    cells = [cell.strip() for line in result.stdout.splitlines() for cell in line.split("│")]
    assert [cell for cell in cells if cell in {"holds", "fails", "can't tell"}] == verdicts
    counts = f"holds {verdicts.count('holds')}, fails {verdicts.count('fails')}, can't tell "
    assert result.stdout.startswith(f"The paper's 6 claims, from 4 runs at each ratio: {counts}")
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


def test_a_reader_that_goes_away_leaves_no_traceback():
    process = start("show", "schema")
    process.stdout.close()
    errors = process.stderr.read()
    process.stderr.close()
    process.wait(timeout=240)
    assert "Traceback" not in errors


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_output_that_finds_no_room_is_told():
    with Path("/dev/full").open("w") as full:
        process = start("show", "truth", stdout=full)
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
    told = invoke("run", "--set", change, "--runs", 2, "--steps", 5, "--details")
    assert (told.exit_code, told.stderr) == (0, "")
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

    told = run("show", "truth", b"\xff\xe9.toml")
    assert (told.returncode, told.stdout) == (2, b"")
    assert told.stderr.startswith(b"feasibee: \\udcff\\udce9.toml: can't be read: No such file")
    told = run("run", "--frames", "1", "--out", b"\xff.png")
    assert told.returncode == 0, told.stderr
    assert b"Wrote " in told.stdout
    assert (tmp_path / os.fsdecode(b"\xff.png")).is_file()


def test_progress_has_a_time_once_runs_are_done_and_never_less_than_is_sure():
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
