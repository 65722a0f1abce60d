"""feasibee new on a terminal: eight questions, checked at once, and how long commands take."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from feasibee import Scenario
from feasibee.cli import asking, main
from feasibee.scenario.fields import fields
from tests.commands import output_of

HALL = "1 0.5\n60 25\nwalls\n35 28\n3 0.05\n6, 0.1\n1 0.03\n1200\n"


@pytest.fixture
def answering(tmp_path, monkeypatch):
    """Return a function that gives answers to a new file's questions, and returns the output and the path."""
    monkeypatch.setattr(asking, "on_terminal", lambda: True)
    monkeypatch.setattr(asking, "_seconds_per_run", lambda scenario: 0.01)
    path = tmp_path / "mine.toml"

    def answer(text, *options):
        result = CliRunner().invoke(main, ["new", str(path), *options], input=text)
        return result, path

    return answer


def test_there_are_eight_questions_about_fields():
    assert len(asking.QUESTIONS) == 8
    assert {field for each in asking.QUESTIONS.values() for field in each} <= set(fields())


def test_all_answers_are_in_the_scenario(answering):
    result, path = answering(HALL)
    assert result.exit_code == 0, result.output
    assert Scenario.read(path) == Scenario(
        arena={"side": [60.0, 25.0], "boundary": "walls"},
        robots={"count": 35},
        tasks={"count": 28},
        sensing={"range": 3.0, "miss": 0.05},
        radio={"range": 6.0, "loss": 0.1},
        faults={"stopped": {"count": 1}, "byzantine": 0.03},
        run={"steps": 1200},
        units={"metres": 1.0, "seconds": 0.5},
    )
    assert Scenario.read(path).units.seconds == 0.5  # which equal scenarios may differ in
    assert "recommend 2 min 50 s, assess 3 min 40 s, size 6 min 40 s, compare 9 min 40 s." in result.output


def test_enter_keeps_the_defaults_as_yes_does_and_a_pipe(answering, tmp_path, monkeypatch):
    result, asked = answering(8 * "\n", "--set", "robots.speed=0.5")
    assert "sensing.range sensing.miss [2 0]: " in result.output
    output_of("new", tmp_path / "yes.toml", "--yes", "--set", "robots.speed=0.5")
    monkeypatch.undo()
    output_of("new", tmp_path / "pipe.toml", "--set", "robots.speed=0.5")
    assert asked.read_text() == (tmp_path / "yes.toml").read_text() == (tmp_path / "pipe.toml").read_text()


def test_an_invalid_answer_is_asked_again_and_says_the_rule(answering):
    result, path = answering("\n\nwall\ntorus\n\n1 2 3\n-1\n\n\n\n\n")
    assert result.exit_code == 0, result.output
    assert "arena.boundary = 'wall': must be 'torus' or 'walls'" in result.output
    assert "sensing.range = '1 2 3': must be at most 2 values; type fewer" in result.output
    assert "sensing.range = -1: must be > 0" in result.output
    assert Scenario.read(path) == Scenario()


def test_what_a_later_answer_must_mend_is_not_asked_before(answering):
    result, path = answering("\n3\n\n\n\n1\n\n\n\n")
    assert result.exit_code == 0, result.output
    assert result.output.index("sensing.miss [2 0]") < result.output.index(
        "sensing.range = 2.0: must be at most half"
    )
    assert Scenario.read(path) == Scenario(arena={"side": 3}, sensing={"range": 1})


def test_answers_may_have_units(answering):
    result, path = answering("0.5 2\n20 m 10m\nwalls\n\n1.5 m .1\n3 m\n\n10 min\n")
    assert result.exit_code == 0, result.output
    found = Scenario.read(path)
    assert (found.arena.size, found.sensing.range, found.sensing.miss) == ((40.0, 20.0), 3.0, 0.1)
    assert (found.radio.range, found.run.steps) == (6.0, 300)


def test_set_answers_a_question_beforehand(answering):
    result, path = answering("\n\n\n\n\n\n", "--set", "arena.side=40", "--set", "radio.loss=0.5")
    assert result.exit_code == 0, result.output
    assert "6 of 6. " in result.output
    assert "arena.side" not in result.output
    assert Scenario.read(path) == Scenario(arena={"side": 40}, radio={"loss": 0.5})


def test_an_end_of_the_input_leaves_no_file(answering):
    result, path = answering("\n\n")
    assert result.exit_code == 2
    assert "feasibee: the answers end too early; answer all questions, or use --yes" in result.stderr
    assert not path.exists()


def test_the_time_of_a_run_is_measured():
    assert 0 < asking._seconds_per_run(Scenario(run={"steps": 20}, events=[{"step": 9, "tasks": 1}])) < 10
