"""Every study goes on where it was killed, and gives the same bytes whoever computes its runs."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
import pytest
from click.testing import CliRunner
from stores import counts

from feasibee import FeasibeeError, Scenario
from feasibee.cli import main
from feasibee.scenario.runs import RUNS_APART
from feasibee.simulation import executors, schedule
from feasibee.simulation.plan import DesignPoint, StoppingRule, Study
from feasibee.simulation.sweep import Execution, Rounds
from feasibee.studies.assess import assess
from feasibee.studies.comparison import compare, contenders_of
from feasibee.studies.constraints import Constraints, compare_under
from feasibee.studies.paper import PLACES, TASKS, WORLDS, run_study, simulate_panels
from feasibee.studies.size import Rule, size

SMALL = Scenario(arena={"side": 6.0}, robots={"count": 5}, tasks={"count": 4}, run={"steps": 40})


def plain(results):
    """Return dataclasses with arrays as their fields, and the bytes of the arrays."""
    return [
        {
            name: value.tobytes() if isinstance(value, np.ndarray) else value
            for name, value in vars(each).items()
        }
        for each in results
    ]


CONTENDERS = contenders_of(SMALL, ["dmmd", "voter", "bayes"])
RULE, BEARING = Rule(0.5, first=4, most=12), Constraints(0.5, liars=1)
STUDIES = {
    "paper": lambda given: plain(run_study(3, 1, given)),
    "robustness": lambda given: plain(simulate_panels(1, 1, given)),
    "comparison": lambda given: plain(compare(CONTENDERS, (2, 5, 9), 12, 1, given)),
    "assessment": lambda given: json.dumps(assess(SMALL, 12, 1, given).to_dict()),
    "sizing": lambda given: json.dumps(size(SMALL, rule=RULE, seed=1, execution=given).to_dict()),
    "constraints": lambda given: json.dumps(compare_under(SMALL, BEARING, (), 12, 1, given).to_dict()),
}
each_study = pytest.mark.parametrize("study", STUDIES)
each_kind = pytest.mark.parametrize("study", ["comparison", "sizing"])
"""Runs that are known beforehand, and that go on until a rule is met."""


@dataclass
class Player:
    """Plays chunks, counts their runs, and fails after some of them."""

    limit: float = float("inf")
    error: BaseException = field(default_factory=lambda: RuntimeError("crashed"))
    runs: Counter = field(default_factory=Counter)
    play: object = executors.play

    def __call__(self, scenarios, pieces, seed, curves):
        if sum(self.runs.values()) >= self.limit:
            raise self.error
        found = self.play(scenarios, pieces, seed, curves)
        for scenario, piece in zip(scenarios, pieces, strict=True):
            for run in range(piece.first_run, piece.first_run + piece.runs):
                self.runs[scenario.hash, seed, run] += 1
        return found


@pytest.fixture
def played(monkeypatch):
    """Small chunks; a call replaces what plays them."""
    monkeypatch.setattr(schedule, "CHUNK_WORK", 1000)
    monkeypatch.setattr(schedule, "CHUNK_SECONDS", 1e9)

    def by(player):
        monkeypatch.setattr(executors, "play", player)
        return player

    return by


@pytest.fixture(scope="module")
def undisturbed():
    """The result of each study in memory, and how often it computed each run."""
    kept = {}

    def of(study):
        if study not in kept:
            with pytest.MonkeyPatch.context() as patch:
                player = Player()
                patch.setattr(executors, "play", player)
                execution = Execution(pool=executors.threads(1))
                kept[study] = STUDIES[study](execution), player.runs
        return kept[study]

    return of


@pytest.mark.quick(1)
@each_kind
def test_what_was_ended_halfway_goes_on(undisturbed, played, tmp_path, study):
    """To the same bytes, and no run is computed twice; an interrupt is an error as any other."""
    error = KeyboardInterrupt() if study == "comparison" else RuntimeError("crashed")
    expected, all_runs = undisturbed(study)
    assert set(all_runs.values()) == {1}
    execution = Execution(tmp_path / "runs", executors.threads(1))
    first = played(Player(len(all_runs) / 2, error))
    with pytest.raises(type(error)):
        STUDIES[study](execution)
    assert len(all_runs) / 2 <= len(first.runs) < len(all_runs)
    second = played(Player())
    assert STUDIES[study](execution) == expected
    assert first.runs + second.runs == all_runs
    third = played(Player(0))
    assert STUDIES[study](execution) == expected
    assert third.runs == Counter()


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    ("study", "total", "numbers"),
    [
        ("paper", 3 * len(TASKS), {(1, tasks * RUNS_APART + run) for tasks in TASKS for run in range(3)}),
        ("robustness", len(WORLDS) * len(PLACES), {(1, places * RUNS_APART) for places in PLACES}),
        ("comparison", 108, {(1, place * RUNS_APART + run) for place in range(3) for run in range(12)}),
        ("assessment", None, {(1, run) for run in range(225)}),
        ("sizing", None, {(1, run) for run in range(4)}),
        ("constraints", None, {(1, run) for run in range(12)}),
    ],
)
def test_runs_have_the_seeds_and_numbers_that_they_always_had(undisturbed, study, total, numbers):
    runs = undisturbed(study)[1]
    assert {(seed, run) for _, seed, run in runs} == numbers
    assert total in (None, len(runs))


# --- On the command line ---

DASK = "tcp://10.0.0.1:8786"

SETTINGS = ("--set", "arena.side=6", "--set", "robots.count=5", "--set", "run.steps=40")
COMMANDS = {
    "paper": ("paper", "--runs", "4"),
    "robustness": ("paper", "--beyond", "--runs", "4"),
    "comparison": ("compare", "--strategies", "dmmd,voter", "--tasks", "2,5", "--runs", "8", *SETTINGS),
    "assessment": ("assess", "--runs", "8", "--json", "--set", "tasks.count=4", *SETTINGS),
    "sizing": ("size", "--runs", "8", "--json", "--set", "tasks.count=4", *SETTINGS),
    "constraints": ("compare", "--right", "0.9", "--runs", "8", "--json", "--set=tasks.count=4", *SETTINGS),
}


@pytest.mark.slow
@each_study
def test_the_same_command_computes_nothing_again(monkeypatch, tmp_path, study):
    """With --out; without, the numbers are the same."""
    monkeypatch.chdir(tmp_path)
    arguments = [*COMMANDS[study], "--out", "out"]
    first = CliRunner().invoke(main, arguments)
    assert first.exit_code == 0, first.output
    monkeypatch.setattr(executors, "play", Player(0))
    again = CliRunner().invoke(main, [*arguments, "--workers", "1"])
    assert (again.exit_code, again.stdout) == (0, first.stdout)
    assert sum(counts(tmp_path / "out")) > 0
    assert "runs of" in CliRunner().invoke(main, ["results", "status", "out"]).stdout
    monkeypatch.setattr(executors, "play", Player.play)
    if study not in ("paper", "robustness"):
        told = first.stdout.removesuffix("Figures (PNG, PDF) and their data (CSV) are in out/\n")
        assert CliRunner().invoke(main, COMMANDS[study]).stdout == told
        assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize(
    ("study", "options", "asked"),
    [
        *((study, ("--workers", "3"), "threads(3)") for study in STUDIES),
        ("comparison", (), "threads(None)"),
        ("comparison", ("--dask", DASK), f"dask('{DASK}')"),
        ("comparison", ("--dask", DASK, "--workers", "2"), "--dask: brings its own workers; leave out"),
    ],
)
def test_every_command_takes_threads_and_dask(monkeypatch, tmp_path, study, options, asked):
    def refuse(name):
        def make(*given):
            raise FeasibeeError(f"{name}({', '.join(map(repr, given))})")

        return make

    monkeypatch.chdir(tmp_path)
    for name in ("threads", "dask"):
        monkeypatch.setattr(executors, name, refuse(name))
    done = CliRunner().invoke(main, [*COMMANDS[study], *options])
    assert done.exit_code == 2
    assert done.stderr.startswith(f"feasibee: {asked}")


# --- Rounds ---


def test_points_that_are_the_same_are_computed_once(played):
    player = played(Player())
    points = [DesignPoint({"name": name}, SMALL) for name in "ab"]
    points.append(DesignPoint({"name": "c"}, SMALL, first_run=5))
    with Rounds() as rounds:
        one, two, later = rounds.run(Study(points, 5, 1))
        (both,) = rounds.run(Study([DesignPoint({}, SMALL)], 10, 1))
    assert player.runs == Counter({(SMALL.hash, 1, run): 1 for run in range(10)})
    assert one.decision_step.tolist() == two.decision_step.tolist() == both.decision_step[:5].tolist()
    assert later.first_run == 5
    assert later.decision_step.tolist() == both.decision_step[5:].tolist()


def test_progress_counts_the_work_of_all_rounds_against_the_most(tmp_path):
    told = []
    execution = Execution(tmp_path, executors.threads(1), told.append)
    for new in (30, 0):
        told.clear()
        with Rounds(execution, most=40) as rounds:
            for seed in (1, 2, 3):
                rounds.phase = str(seed)
                list(rounds.run(Study([DesignPoint({}, SMALL)], 10, seed)))
        assert {(each.phase, each.runs) for each in told} == {("1", 10), ("2", 20), ("3", 30)}
        assert (told[-1].runs_done, told[-1].runs_new) == (30, new)
        assert told[-1].work_done / told[-1].most == 0.75
        assert [each.work_done for each in told] == sorted(each.work_done for each in told)
    with Rounds(execution, most=None) as rounds:
        list(rounds.run(Study([DesignPoint({}, SMALL)], 10, 1)))
    assert not told[-1].is_bounded


def test_a_rule_counts_as_the_most_runs_until_it_is_met(tmp_path):
    told = []
    rule = StoppingRule(width=0.2, decided=None, most=400)
    with Rounds(Execution(tmp_path, executors.threads(1), told.append)) as rounds:
        rounds.complete(Study([DesignPoint({}, SMALL)], 10, 1, until=rule))
    each = SMALL.robots.count * SMALL.run.steps
    assert told[0].most == 400 * each > told[-1].most == told[-1].work_done == told[-1].runs_done * each
    assert all(progress.work <= progress.most for progress in told)


def test_curves_that_do_not_fit_are_refused_before_the_work(played):
    played(Player(0))
    large = SMALL.replace({"run.steps": 10_000_000})
    with Rounds() as rounds, pytest.raises(FeasibeeError, match="curves of 1000 runs x 10000000 steps: must"):
        list(rounds.run(Study([DesignPoint({}, large)], 1000, 1, curves=True)))
