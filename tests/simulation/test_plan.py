"""Study files: which points they make, in which order of values, and how mistakes are told."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import BaseModel

from feasibee import FeasibeeError, Scenario, ScenarioError
from feasibee.base.codes import RUN_LIMIT
from feasibee.scenario import scenario as scenario_module
from feasibee.simulation import plan
from feasibee.simulation.plan import POINTS_LIMIT, StoppingRule, Study

STRATEGY = """
def decide(mind, inbox):
    return inbox.heard_opinion
"""


@pytest.fixture
def study(tmp_path):
    """Read a study from its text."""

    def read(text):
        path = tmp_path / "study.toml"
        path.write_text(text, encoding="utf-8")
        return Study.read(path)

    return read


@pytest.fixture
def refused(study):
    """Return the lines of the error of a study that must be refused; each names the file."""

    def read(text):
        with pytest.raises(FeasibeeError) as caught:
            study(text)
        lines = str(caught.value).splitlines()
        assert all("study.toml: " in line for line in lines)
        return [line.partition("study.toml: ")[2] for line in lines]

    return read


def values(study, path):
    return [point.values[path] for point in study.points]


# --- What a file may leave out ---


def test_an_empty_study_is_the_papers_swarm(study):
    found = study("")
    (point,) = found.points
    assert (found.runs, found.seed, found.curves, found.until) == (100, 0, False, None)
    assert (point.values, point.scenario) == ({}, Scenario())
    found = study("runs = 7\nseed = 18446744073709551615\ncurves = true")
    assert (found.runs, found.seed, found.curves) == (7, 2**64 - 1, True)


# --- Values of a field ---


def test_a_list_is_taken_as_it_stands(study):
    found = study('[sweep]\n"decision.strategy" = ["dmmd", "voter"]')
    assert values(found, "decision.strategy") == ["dmmd", "voter"]
    assert [point.scenario.decision.strategy for point in found.points] == ["dmmd", "voter"]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("{linspace = [0.0, 1.0, 5]}", [0.0, 0.25, 0.5, 0.75, 1.0]),
        ("{linspace = [0, 1, 1]}", [0.0]),
        ("{range = [0.1, 0.5, 0.1]}", [0.1, 0.2, 0.3, 0.4, 0.5]),
        ("{range = [0.1, 0.45, 0.1]}", [0.1, 0.2, 0.3, 0.4]),
        ("{range = [0, 0.38, 0.1]}", [0, 0.1, 0.2, 0.3]),
        ("{range = [0.5, 0, -0.25]}", [0.5, 0.25, 0.0]),
        ("{range = [0, 0.7, 0.1]}", [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]),  # 0.7 / 0.1 is below 7
        ("{logspace = [0.01, 1, 3]}", [0.01, 0.1, 1.0]),
    ],
)
def test_ranges_of_numbers(study, given, expected):
    np.testing.assert_allclose(values(study(f'[sweep]\n"radio.loss" = {given}'), "radio.loss"), expected)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("{linspace = [1, 4, 7]}", [1, 2, 3, 4]),  # 1.5, 2.5, 3.5 are rounded to 2, 2, 4
        ("{linspace = [1, 2.7, 2]}", [1, 3]),
        ("{range = [10, 40, 10]}", [10, 20, 30, 40]),
        ("{range = [1, 2, 0.5]}", [1, 2]),
        ("{logspace = [2, 200, 5]}", [2, 6, 20, 63, 200]),
        ("{logspace = [1, 4, 20]}", [1, 2, 3, 4]),
    ],
)
def test_whole_numbers_are_rounded_and_made_unique(study, given, expected):
    found = values(study(f'[sweep]\n"tasks.count" = {given}'), "tasks.count")
    assert found == expected
    assert all(type(each) is int for each in found)


def test_whole_numbers_within_a_list_of_classes(study):
    text = """
    [[scenario.robots.classes]]
    name = "small"
    count = 3
    [sweep]
    "robots.classes.0.count" = {linspace = [2, 8, 3]}
    """
    found = study(text)
    assert values(found, "robots.classes.0.count") == [2, 5, 8]
    assert [point.scenario.robots.count for point in found.points] == [2, 5, 8]


@pytest.mark.parametrize(
    "text",
    [
        '[sweep]\n"radio.range" = [1.0, 2.0, 4.0]',
        "[sweep]\nradio.range = [1.0, 2.0, 4.0]",
        "[sweep.radio]\nrange = [1.0, 2.0, 4.0]",
        "[sweep.radio]\nrange = {logspace = [1, 4, 3]}",
    ],
)
def test_a_field_called_range_is_a_field_however_it_is_written(study, text):
    np.testing.assert_allclose(values(study(text), "radio.range"), [1.0, 2.0, 4.0])


def test_a_field_that_holds_nothing_yet_and_a_table_among_the_values(study):
    found = study("[sweep]\ndecision.declare.quorum = [0.8, 0.9]\nradio.id_bits = [4, 8]")
    assert [point.scenario.decision.declare.quorum for point in found.points] == [0.8, 0.8, 0.9, 0.9]
    assert values(found, "radio.id_bits") == [4, 8, 4, 8]
    found = study('[sweep]\n"decision.listen" = ["always", {last = 3}]')
    assert [point.scenario.decision.listen for point in found.points] == ["always", {"last": 3}]


# --- Points ---

TWO = '"tasks.count" = [10, 20]\n"radio.loss" = [0.0, 0.1, 0.2]'


def test_a_grid_has_each_with_each(study):
    pairs = [(p.scenario.tasks.count, p.scenario.radio.loss) for p in study(f"[sweep]\n{TWO}").points]
    assert pairs == [(count, loss) for count in (10, 20) for loss in (0.0, 0.1, 0.2)]
    assert study(f'combine = "grid"\n[sweep]\n{TWO}') == study(f"[sweep]\n{TWO}")


def test_zipped_fields_go_in_step(study):
    """A range has as many values as there are whole numbers in it."""
    text = 'combine = "zip"\n[sweep]\n"tasks.count" = {linspace = [1, 4, 7]}\n"robots.count" = [5, 6, 7, 8]'
    assert [dict(point.values) for point in study(text).points] == [
        {"tasks.count": count, "robots.count": 4 + count} for count in (1, 2, 3, 4)
    ]


def test_a_design_table_has_a_point_a_row(study, tmp_path):
    """Written as other tools do: a byte order mark, floats for whole numbers, spaces, an empty line."""
    (tmp_path / "design.csv").write_text(
        "tasks.count, radio.loss,decision.strategy,robots.avoid_collisions\n"
        "1.2e+01,.5,dmmd,False\n\n20.0, 0.25 ,voter,true\n",
        encoding="utf-8-sig",
    )
    fields = ("tasks.count", "radio.loss", "decision.strategy", "robots.avoid_collisions")
    assert [dict(point.values) for point in study('design = "design.csv"').points] == [
        dict(zip(fields, row, strict=True)) for row in ((12, 0.5, "dmmd", False), (20, 0.25, "voter", True))
    ]


def test_equal_scenarios_are_one_point(study):
    """10 is there twice; 2 is 2.0, and the range that the radio has from the sensors anyway."""
    assert len(study('[sweep]\n"tasks.count" = [10, 20, 10]').points) == 2
    assert len(study('[sweep]\n"radio.range" = [2.0, 2]\n"sensing.range" = [2.0]').points) == 1


def test_a_scenarios_file_lies_below_what_the_study_says(study, tmp_path):
    (tmp_path / "base.toml").write_text(
        'run.steps = 50\n[decision]\nlisten = "dissemination"\ngain = 7.0\ndeclare = {rounds = 9}\n'
    )
    text = """
    file = "base.toml"
    [scenario.decision]
    listen = {last = 2}
    declare.quorum = 0.8
    [sweep]
    "tasks.count" = [3, 4]
    """
    for point in study(text).points:
        decision = point.scenario.decision
        assert (point.scenario.run.steps, decision.gain) == (50, 7.0)
        assert decision.listen == {"last": 2}
        assert (decision.declare.rounds, decision.declare.quorum) == (9, 0.8)


def test_files_are_found_from_the_studys_folder(study, tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(STRATEGY)
    (tmp_path / "places.csv").write_text("x,y\n1,2\n3,4\n")
    (tmp_path / "base.toml").write_text("run.steps = 50")
    (tmp_path / "design.csv").write_text("decision.strategy\nmine.py\n")
    monkeypatch.chdir("/")
    strategy = 'decision.strategy = "mine.py"'
    for text in (
        f"[scenario]\n{strategy}",
        f'file = "base.toml"\n[scenario]\n{strategy}',
        '[sweep]\n"decision.strategy" = ["mine.py"]',
        'design = "design.csv"',
    ):
        assert study(text).points[0].scenario.strategy.source == STRATEGY
    swept = study('[sweep]\n"tasks.placement" = ["points"]\n"tasks.points" = ["places.csv"]')
    assert swept.points[0].scenario.tasks.points == ((1.0, 2.0), (3.0, 4.0))


# --- StoppingRule ---


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("{width = 0.05}", StoppingRule(0.05, None, 100_000)),
        ("{decided = 0.75}", StoppingRule(None, 0.75, 100_000)),
        ("{width = 0.1, most = 500}", StoppingRule(0.1, None, 500)),
        (f"{{width = 0.1, most = {RUN_LIMIT}}}", StoppingRule(0.1, None, RUN_LIMIT)),
        ("{width = 0.1, most = 5}", StoppingRule(0.1, None, 100)),  # no fewer than the study's runs
    ],
)
def test_until(study, given, expected):
    assert study(f"until = {given}").until == expected


# --- Mistakes ---


SWEPT = '[sweep]\n"tasks.count" = '


@pytest.mark.parametrize(
    ("text", "start", "rule"),
    [
        ("rums = 5", "rums", "unknown key; a study has runs, seed, curves, combine"),
        ("runs = 0", "runs = 0", "whole number from 1"),
        ("runs = 1.5", "runs = 1.5", "whole number"),
        ("seed = -1", "seed = -1", "whole number from 0"),
        ("curves = 1", "curves = 1", "true or false"),
        ("scenario = 3", "scenario = 3", "write [scenario]"),
        ("sweep = 3", "sweep = 3", "write [sweep]"),
        ("design = 3", "design = 3", "must be a file name, such as"),
        ("file = 3", "file = 3", "must be a file name, such as"),
        ('combine = "cross"', "combine = 'cross'", "must be 'grid' or 'zip'"),
        ("combine = ['zip']", "combine = ['zip']", "must be 'grid' or 'zip'"),
        ('combine = "zip"\n[sweep]\n' + TWO, "sweep", "{'tasks.count': 2, 'radio.loss': 3} differ"),
        ('design = "d.csv"\n[sweep]\n' + TWO, "design and sweep", "leave out one of them"),
        ("runs = = 3", "not TOML", "line 1"),
        *(
            (f"until = {given}", "until = ", "{width = 0.05} or {decided = 0.75}")
            for given in (
                "{}",
                "0.05",
                "{width = 0.1, decided = 0.5}",
                "{width = 1.0}",
                '{decided = "0.5"}',
                "{size = 0.1}",
            )
        ),
        *(
            (f"until = {{width = 0.1, most = {most}}}", "until.most = ", "must be a whole number from 1 to")
            for most in ("0", "1.5", "true", '"many"', RUN_LIMIT + 1)
        ),
        *(
            (SWEPT + given, "sweep.tasks.count = ", "a list of values, or {linspace = [first, last, count]}")
            for given in (
                "3",
                '"10 to 20"',
                "{linspace = [1, 2, true]}",
                "{linspace = [1, 2, 3], range = [1, 2, 1]}",
                "{range = [0, inf, 1]}",
            )
        ),
        (SWEPT + "{range = [1, 5, 0]}", "sweep.tasks.count: ", "step of a range can't be 0"),
        (SWEPT + "{range = [5, 1, 1]}", "sweep.tasks.count: ", "is empty"),
        (SWEPT + "{logspace = [0, 5, 3]}", "sweep.tasks.count: ", "must be > 0"),
        (SWEPT + "{linspace = [0, 5, 2.5]}", "sweep.tasks.count: ", "whole number of values"),
        (
            SWEPT + "{linspace = [0, 5, 1e9]}",
            "sweep.tasks.count: ",
            "linspace = [0, 5, 1000000000.0]: must have a whole number of",
        ),
        ('[sweep]\n"radio.loss" = {range = [0, 1e12, 1]}', "sweep: ", f"must be at most {POINTS_LIMIT}"),
        (
            SWEPT + '{linspace = [1, 1000, 1000]}\n"radio.loss" = {linspace = [0, 1, 1001]}',
            "sweep: ",
            f"must be at most {POINTS_LIMIT}",
        ),
    ],
)
def test_mistakes_of_a_study_say_where_and_what(refused, text, start, rule):
    (line,) = refused(text)
    assert line.startswith(start)
    assert rule in line


def test_as_many_values_as_there_is_room_for_are_allowed():
    given = {"linspace": [0, 1, POINTS_LIMIT]}
    assert len(plan._values("radio.loss", given, Scenario())) == POINTS_LIMIT
    plan._check_size(POINTS_LIMIT)
    with pytest.raises(FeasibeeError, match=f"must be at most {POINTS_LIMIT}"):
        plan._check_size(POINTS_LIMIT + 1)


def test_all_problems_of_all_points_at_once(refused):
    lines = refused(
        '[sweep]\n"tasks.coun" = [1]\n"radio.loss" = [0.1, 1.5, -1.0]\n"radio.range" = [2.0, 0.0]'
    )
    assert len(lines) == 4
    joined = "\n".join(lines)
    for problem in (
        "tasks.coun = 1: unknown key",
        "radio.loss = 1.5",
        "radio.loss = -1.0",
        "radio.range = 0.0",
    ):
        assert joined.count(problem) == 1


def test_a_problem_of_the_common_scenario_is_told_once_with_its_file(study, tmp_path):
    with pytest.raises(ScenarioError) as caught:
        study('[scenario]\ntasks.count = -1\n[sweep]\n"radio.loss" = [0.1, 0.2]')
    assert [problem.path for problem in caught.value.problems] == ["tasks.count"]
    (tmp_path / "base.toml").write_text("tasks.count = -1")
    with pytest.raises(ScenarioError, match=r"base\.toml: tasks\.count = -1"):
        study('file = "base.toml"')


@pytest.mark.parametrize(
    ("table", "rule"),
    [
        ("", "has no points"),
        ("tasks.count\n", "has no points"),
        ("tasks.count,radio.loss\n3,0.1\n\n4\n", "line 4 has 1 values, not 2"),
        ("tasks.count\n3,0.1\n", "line 2 has 2 values, not 1"),
        ("tasks.count,tasks.count\n3,4\n", "names a field twice"),
        ("tasks.count;radio.loss\n3;0,5\n", "must be separated by commas"),
        ("tasks.count\tradio.loss\n3\t0\n", "must be separated by commas"),
        (f"tasks.count\n{'1' * 200_000}\n", "not CSV: field larger"),
        ("tasks.count\n\xff\n".encode("latin-1"), "it isn't UTF-8 text"),
        (None, "d.csv': can't be read: No such file"),
        ("tasks.coun\n3\n", "tasks.coun = 3: unknown key; did you mean tasks.count?"),
        ("tasks.count\ninf\n", "tasks.count = inf: must be a whole number"),
        ("tasks.count\n[[[\n", "tasks.count = '[[[': must be a whole number"),
        ("radio.loss\nsome\n", "radio.loss = 'some': must be a number"),
        ("radio.loss\n2024-01-01\n", "radio.loss = datetime.date(2024, 1, 1): must be a number"),
    ],
)
def test_design_tables_that_cant_be_read(refused, tmp_path, table, rule):
    if table is not None:
        (tmp_path / "d.csv").write_bytes(table if isinstance(table, bytes) else table.encode())
    (line,) = refused('design = "d.csv"')
    assert line.startswith(("design = ", "tasks.count = ", "tasks.coun = ", "radio.loss = "))
    assert rule in line


def test_a_study_that_isnt_there(tmp_path):
    with pytest.raises(FeasibeeError, match=r"nope\.toml: can't be read: No such file"):
        Study.read(tmp_path / "nope.toml")
    (tmp_path / "latin.toml").write_bytes(b'file = "\xff"')
    with pytest.raises(FeasibeeError, match=r"latin\.toml: can't be read: it isn't UTF-8 text"):
        Study.read(tmp_path / "latin.toml")


def test_a_point_is_validated_once_and_dumped_twice(study, monkeypatch):
    """Once to change the base, once to compute the hash, which the journal asks for again."""
    text = '[sweep]\n"tasks.count" = {range = [1, 50, 1]}\n"radio.loss" = [0.0, 0.1]\n'
    study(text)  # what is computed once per process
    counts = dict.fromkeys(("conflicts", "model_dump", "hash_of"), 0)

    def count(owner, name):
        original = getattr(owner, name)

        def counted(*given, **options):
            counts[name] += 1
            return original(*given, **options)

        monkeypatch.setattr(owner, name, counted)

    count(scenario_module, "conflicts")
    count(scenario_module, "hash_of")
    count(BaseModel, "model_dump")
    points = study(text).points
    hashes = {point.scenario.hash for point in points}
    assert len(hashes) == 100
    assert counts == {"conflicts": 101, "model_dump": 200, "hash_of": 100}  # the base is validated, too
