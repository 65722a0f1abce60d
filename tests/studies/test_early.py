"""Studies that end early, by their budget or an interrupt: the answer so far, and what is missing."""

from __future__ import annotations

import json
import signal
import sys

import pytest
from click.testing import CliRunner

from feasibee import Scenario
from feasibee.cli import main
from feasibee.cli.execution import leave_if_stopped
from feasibee.results.statistics import OF_THE_RUNS, in_percent, wilson
from feasibee.simulation.executors import threads
from feasibee.simulation.plan import DesignPoint, Study
from feasibee.simulation.sweep import Enough, Execution, Rounds
from feasibee.studies.assess import assess
from feasibee.studies.comparison import compare
from feasibee.studies.constraints import Constraints, answer, compare_under
from feasibee.studies.files import write_report
from feasibee.studies.report import sections
from feasibee.studies.size import Rule, size

SMALL = Scenario(arena={"side": 8.0}, robots={"count": 6}, tasks={"count": 5}, run={"steps": 60})
OVER = Execution(pool=threads(1), budget=1e-9)
SHORT = ("--robots", "6", "--tasks", "5", "--arena", "8", "--steps", "60", "--runs", "20")


def runs_of(rounds, runs):
    return list(rounds.run(Study([DesignPoint({}, SMALL)], runs, 1)))


def test_a_budget_ends_a_study_only_once_it_has_an_answer():
    with Rounds(OVER) as rounds:
        runs_of(rounds, 10)
        rounds.so_far = "an answer"
        runs_of(rounds, 10)  # they are there
        with pytest.raises(Enough):
            runs_of(rounds, 4000)
        assert (rounds.stopped, rounds.stops) == ("out of time", 1)
        with pytest.raises(Enough):
            runs_of(rounds, 4000)


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
@pytest.mark.parametrize(
    ("answers", "so_far", "within", "error"),
    [
        (True, "x", True, Enough),
        (True, "x", False, Enough),
        (True, None, True, KeyboardInterrupt),
        (True, None, False, KeyboardInterrupt),
        (False, "x", True, KeyboardInterrupt),
    ],
)
def test_an_interrupt_ends_a_study_with_its_answer_if_it_has_one(answers, so_far, within, error):
    def interrupt(progress):
        if within and not progress.stopping:
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored
    try:
        with Rounds(Execution(None, threads(1), interrupt, answers=answers)) as rounds:
            rounds.so_far = so_far
            if not within:
                signal.raise_signal(signal.SIGINT)
            with pytest.raises(error):
                runs_of(rounds, 400)
        assert rounds.stopped == ("interrupted" if error is Enough else "")
    finally:
        signal.signal(signal.SIGINT, before)


def test_an_assessment_so_far_has_its_verdict_and_says_what_is_missing(tmp_path):
    found = assess(SMALL, 150, 1, OVER)
    assert found.outcome.runs == 10
    assert found.stopped == "out of time"
    phases = ["running the swarm", "testing strategies", "comparing changes", "comparing faults"]
    assert list(found.missing) == [*phases, "searching sizes"]
    verdict, _, early = sections(found)["Answer"]
    assert "right in" in verdict
    assert early.startswith(
        "The assessment ended early (out of time). More time would complete: running the "
    )
    assert json.loads(json.dumps(found.to_dict()))["missing"] == list(found.missing)
    write_report(found, tmp_path / "page.html")
    assert "ended early" in (tmp_path / "page.html").read_text()


def test_a_recommendation_so_far_has_one_look_at_each_strategy():
    found = compare_under(SMALL, Constraints(0.9), ["dc", "census", "roster"], 1000, 1, OVER)
    assert [[world.runs for world in each.worlds] for each in found.tested] == [[20, 20]] * 3
    assert (found.ranking, found.stopped) == ([], "out of time")
    assert answer(found)[-1] == "The tests ended early (out of time); more time would complete them."


def test_a_search_so_far_says_how_far_it_came():
    told = []
    found = size(SMALL, rule=Rule(0.95, most=200), seed=1, execution=OVER, tell=told.append)
    assert (len(told), found.band, found.stopped) == (1, None, "out of time")
    assert found.to_dict()["stopped"] == "out of time"


def test_a_comparison_so_far_has_as_many_runs_of_each():
    found = compare({"dmmd": SMALL, "dc": SMALL.replace({"decision.strategy": "dc"})}, (5, 7), 250, 1, OVER)
    assert [each.runs for each in found] == 4 * [20]
    assert found[0].right_at.size == 61
    assert found[0].right.tolist() == compare({"dmmd": SMALL}, (5,), 20, 1)[0].right.tolist()


def test_a_comparison_counts_no_run_twice_although_it_looks_several_times():
    told = []
    found = compare({"dmmd": SMALL}, (5, 7), 250, 1, Execution(pool=threads(1), progress=told.append))
    work = 2 * 250 * SMALL.robots.count * SMALL.run.steps
    assert [each.runs for each in found] == [250, 250]
    assert (told[-1].runs, told[-1].runs_done, told[-1].runs_new) == (500, 500, 500)
    assert {each.most for each in told} == {work} == {told[-1].work_done}
    assert [*dict.fromkeys(each.phase for each in told)] == [
        f"runs of each, {number} of 250" for number in (20, 40, 80, 160, 250)
    ]
    assert told[0].so_far == ""
    right = in_percent(wilson(sum(int(each.right[:160].sum()) for each in found), 320), OF_THE_RUNS)
    assert told[-1].so_far == f"after 160 runs of each: dmmd is right in {right}, with 5 to 7 tasks."


def test_a_comparison_of_worlds_that_change_names_the_best_so_far():
    told, world = [], SMALL.replace({"tasks.arrival_rate": 0.05, "tasks.lifetime": 60.0})
    contenders = {name: world.replace({"decision.strategy": name}) for name in ("dmmd", "roster")}
    found = compare(contenders, (), 30, 1, Execution(pool=threads(1), progress=told.append))
    best = max(found, key=lambda each: each.shares[:20].mean())
    right = f"{best.contender} is right most often: in {100 * best.shares[:20].mean():.0f} % of the steps ("
    assert told[-1].so_far.startswith(f"after 20 runs of each: {right}")


def test_the_most_work_of_phases_never_grows_and_includes_later_ones():
    told = []
    with Rounds(Execution(None, threads(1), told.append), most=None) as rounds:
        rounds.phases = {"one": 9000, "two": 18000}
        for rounds.phase, seed in (("one", 1), ("two", 2)):
            list(rounds.run(Study([DesignPoint({}, SMALL)], 20, seed)))
    each = SMALL.robots.count * SMALL.run.steps
    assert (told[0].phase, told[0].most, told[0].is_bounded) == ("one", 27_000, True)
    assert (told[-1].phase, told[-1].most) == ("two", 20 * each + 18_000)
    assert all(progress.work <= progress.most for progress in told)


def test_commands_say_the_verdict_so_far_on_standard_error_and_take_a_budget(tmp_path):
    done = CliRunner().invoke(main, ["assess", *SHORT, "--budget", "0.01s"])
    assert done.exit_code == 0, done.output
    assert "feasibee: " in done.stderr
    assert " so far: " in done.stderr
    assert "ended early (out of time)" in done.stdout
    few = ["--strategies", "dmmd,dc", "--tasks", "5", "--set", "run.steps=60", "--out", str(tmp_path)]
    done = CliRunner().invoke(main, ["compare", *few, "--runs", "400", "--budget", "0.01s"])
    assert done.exit_code == 0, done.output
    assert "of 20 with each" in " ".join(done.stdout.split())
    assert "feasibee: out of time: 2 of 2 have 20 instead of 400 runs" in done.stderr
    wrong = CliRunner().invoke(main, ["compare", "--budget", "2"])
    assert wrong.exit_code == 2
    assert "must be a time such as 90s, 2min or 1h" in wrong.stderr


def test_an_answer_after_ctrl_c_has_its_exit_status():
    leave_if_stopped("out of time")
    with pytest.raises(SystemExit) as ended:
        leave_if_stopped("interrupted")
    assert ended.value.code == 130


def test_progress_says_how_many_strategies_are_left_and_which_is_best():
    told = []
    execution = Execution(pool=threads(1), progress=told.append)
    compare_under(SMALL, Constraints(0.9), ["dmmd", "tally", "census"], 400, 1, execution, relax=False)
    phases = [*dict.fromkeys(each.phase for each in told)]
    assert phases[0] == "testing strategies, 3 of 3"
    assert set(phases[1:]) <= {"testing strategies, 1 of 3", "testing strategies, 2 of 3"}
    assert told[0].so_far == ""
    so_far = [*dict.fromkeys(each.so_far for each in told)][1:]
    assert so_far[0].endswith(" with 7 tasks, by 20 runs")  # the worse world of the best
    assert all(each.startswith("right most often so far: ") for each in so_far)
