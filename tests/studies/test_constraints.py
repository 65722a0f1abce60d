"""Recommendations under constraints: what is excluded and why, and what to relax."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from commands import json_of, output_of, refused, rows_of

from feasibee import FeasibeeError, Scenario, truth
from feasibee import compare as compare_as_table
from feasibee.results.statistics import Interval, confidence_sequence
from feasibee.simulation.sequential import Finding, SequentialDesign
from feasibee.studies.comparison import compare
from feasibee.studies.constraints import (
    Candidate,
    Constraints,
    _Trials,
    answer,
    compare_under,
    opposite_of,
    ranked,
    world_of,
)
from feasibee.studies.needs import Asked

ROOM = Scenario(
    arena={"side": [10.0, 6.0], "boundary": "walls"},
    robots={"count": 12},
    tasks={"count": 10},
    run={"steps": 300},
)
SOME = ("dmmd", "dc", "census", "quiet-census")


def recommended(constraints, **options):
    return compare_under(ROOM, constraints, SOME, 200, 1, **options)


@pytest.fixture(scope="module")
def free():
    return recommended(Constraints(0.9))


@pytest.fixture(scope="module")
def with_a_liar():
    return recommended(Constraints(0.9, liars=1))


def test_the_best_come_first_and_the_others_have_reasons(free):
    assert [each.strategy for each in free.ranking] == ["census", "quiet-census"]
    assert set(free.excluded) == {"dmmd", "dc"}
    assert free.best["census"] == ["right most", "soonest", "cheapest"] or free.best["quiet-census"]
    assert free.excluded["dmmd"].startswith("with 14 tasks right in ")
    assert free.relax == {}


def test_shares_are_those_of_a_comparison(free):
    best = free.ranking[0]
    worlds = {each.tasks: each for each in best.worlds}
    assert set(worlds) == {10, 14}
    for tasks, measured in worlds.items():
        (outcome,) = compare({"": best.scenario.replace({"tasks.count": tasks})}, (), measured.test.trials, 1)
        assert int(outcome.right.sum()) == measured.test.successes


def test_the_tests_of_all_strategies_in_two_worlds_share_the_error(free):
    """Four strategies, and so eight tests at 95 % together."""
    for each in free.ranking:
        for test in each.tests:
            expected = confidence_sequence(test.successes, test.trials, 1 - 0.05 / 8)
            assert test.interval == pytest.approx(expected, abs=1e-12)


def test_a_test_that_the_runs_that_are_left_would_hardly_decide_ends_open():
    found = compare_under(ROOM, Constraints(0.88), ["tally"], 130, 1)
    assert found.excluded["tally"].endswith(" of 100, too close to tell")


def test_a_strategy_that_fails_in_one_world_ends_in_the_others(free):
    """One that passes goes on where it isn't shown yet."""
    tests = {each.strategy: [(test.answer, test.trials) for test in each.tests] for each in free.tested}
    assert tests["dmmd"] == [("open", 20), ("too few", 20)]
    assert tests["census"] == 2 * [("enough", 100)]


def test_a_strategy_fails_where_it_is_settled_below_the_target():
    trials = _Trials(None, ROOM, Constraints(0.8), SequentialDesign(130), 0, (), tells=False)
    fails = {right: trials._fails(trials.design.tested(0.8, right, 100)) for right in (50, 79, 81, 98)}
    assert fails == {50: True, 79: True, 81: False, 98: False}
    assert not trials._fails(trials.design.tested(0.8, 35, 45))  # more runs may decide


def test_the_reason_is_the_world_that_excludes_a_strategy_before_one_that_is_open():
    early = candidate(0.7, 0.65, answer="open")
    tests = [early.tests[0]._replace(answer="too few"), early.tests[1]]
    for each, test in zip(early.worlds, tests, strict=True):
        each.test = test
    assert early.reasons(Constraints()) == {"--right": "right in 0 of 100"}
    early.worlds[0].test = early.tests[0]._replace(answer="enough")
    assert early.reasons(Constraints()) == {"--right": "with 21 tasks right in 0 of 100, too close to tell"}


def test_what_a_strategy_bears_is_measured(with_a_liar):
    assert [each.strategy for each in with_a_liar.ranking] == ["quiet-census"]
    assert with_a_liar.excluded["census"] == "right in 0 of 20"
    assert with_a_liar.scenario.faulty == (0, 1, 0)
    assert with_a_liar.ranking[0].scenario.decision.parameters["tolerates"] == 1


def test_the_scenarios_own_strategy_keeps_its_parameters():
    own = ROOM.replace({"decision.strategy": "quiet-census", "decision.parameters": {"tolerates": 2}})
    found = compare_under(own, Constraints(0.5, liars=1), ["quiet-census"], 100, 1)
    assert found.ranking[0].scenario.decision.parameters["tolerates"] == 2


@pytest.mark.parametrize(
    ("constraints", "reason"),
    [
        (Constraints(0.9, ids=False), "needs ids that are never misread"),
        (Constraints(0.9, names=False), "needs names of tasks"),
        (Constraints(0.9, message_bits=100), "messages of up to 392 bits"),
        (Constraints(0.9, bits=50), " bits per robot-step"),
    ],
)
def test_each_constraint_excludes_by_its_own_reason(constraints, reason):
    found = compare_under(ROOM, constraints, ["census"], 100, 1)
    assert not found.ranking
    assert reason in found.excluded["census"]


def test_without_a_strategy_it_says_which_constraint_to_leave_out_and_what_that_gives():
    found = recommended(Constraints(0.9, names=False))
    assert found.relax["--no-names"].strategy == "census"
    assert found.relax["--no-names"].worst.judged.estimate == 1.0
    assert found.relax["--right"].strategy in ("dmmd", "dc")
    (words,) = answer(found)
    assert "Without --no-names, census does: right in 100 % of the runs (" in words


def test_a_strategy_that_two_constraints_exclude_is_not_simulated():
    found = compare_under(ROOM, Constraints(0.9, ids=False, names=False), ["census", "dmmd"], 200, 1)
    assert [each.strategy for each in found.tested] == ["dmmd"]
    assert found.excluded["census"] == "needs ids that are never misread; needs names of tasks"


def test_given_numbers_of_tasks_take_the_place_of_the_opposite_truth():
    found = recommended(Constraints(0.9), tasks=[9, 16, 20])
    assert [each.tasks for each in found.ranking[0].worlds] == [9, 16, 20]
    level = 1 - 0.05 / (3 * len(SOME))
    test = found.ranking[0].tests[2]
    assert test.interval == confidence_sequence(test.successes, test.trials, level)


def test_every_strategy_has_a_row_with_its_reasons_the_best_first(free):
    rows = free.rows
    assert [row["strategy"] for row in rows[:2]] == [each.strategy for each in free.ranking]
    assert {row["strategy"] for row in rows} == {*SOME}
    assert rows[0]["reasons"] == "needs names of tasks, ids that are never misread"
    assert rows[-1]["reasons"] == free.excluded[rows[-1]["strategy"]]
    assert [row["meets_all"] for row in rows] == [True, True, False, False]
    assert rows[0]["right_low"] == free.ranking[0].worst.judged.low
    assert answer(free)[0].startswith(f"Use {free.ranking[0].strategy}: right in 100 % of the runs (")


def candidate(*shares, steps=(3, 5), bits=10.0, answer="enough"):
    """Return a candidate that is right with a share in each world, from a step on."""
    right_at = [np.array([0] * step + [100] * (9 - step)) for step in steps]
    sent = ([bits - 1, bits + 1], [99.0])  # of the scenario's world the mean counts
    tests = [Finding(0, 0, 100, Interval(share, 0, 1), answer) for share in shares]
    worlds = [
        SimpleNamespace(
            tasks=20 + place, bits=np.array(each), right_at=right, runs=100, test=test, judged=test.interval
        )
        for place, (each, right, test) in enumerate(zip(sent, right_at, tests, strict=False))
    ]
    return Candidate(Asked(ROOM), worlds, 0.95)


def test_a_candidate_may_reach_its_limits_and_is_judged_in_the_worse_world():
    found = candidate(0.99, 0.96)
    assert found.reasons(Constraints(message_bits=5, bits=10.0)) == {}
    assert list(found.reasons(Constraints(message_bits=4, bits=9.9))) == ["--message-bits", "--bits"]
    assert list(candidate(0.99, 0.96, answer="open").reasons(Constraints())) == ["--right"]
    assert (found.worst.tasks, found.step) == (21, 5)
    assert candidate(0.99, 0.96, steps=(3, 9)).step is None
    assert found.to_dict()["runs"] == 100


def test_candidates_are_ranked_by_whole_percent_then_by_step_then_by_bits():
    best, soon, cheap, dear, late = order = [
        candidate(0.99, 0.97),
        candidate(0.99, 0.956, steps=(3, 4)),
        candidate(0.99, 0.964, bits=9.0),
        candidate(0.99, 0.964),
        candidate(0.99, 0.964, steps=(3, 9)),
    ]
    assert ranked([late, dear, cheap, soon, best]) == order


def test_what_a_scenario_does_not_support_is_said():
    found = compare_under(ROOM, Constraints(0.5), ["dmmd", "map"], 100, 1)
    assert found.excluded["map"] == "needs the number of robots"


def test_ids_that_may_be_mistaken_are_drawn_at_random():
    assert world_of(ROOM, Constraints(ids=False)).radio.id_bits == 4
    assert world_of(ROOM.replace({"radio.id_bits": 9}), Constraints(ids=False)).radio.id_bits == 9


@pytest.mark.parametrize("faulty", [1, 3, 7])
def test_as_many_robots_are_faulty_as_asked_for(faulty):
    for robots in (11, 12, 13, 49):
        scenario = ROOM.replace({"robots.count": robots})
        assert world_of(scenario, Constraints(liars=faulty, stopped=2)).faulty == (2, faulty, 0)


@pytest.mark.parametrize(
    ("constraints", "words"),
    [
        (Constraints(liars=12), "must be fewer together than the 12 robots"),
        (Constraints(liars=6, stopped=6), "must be fewer together than the 12 robots"),
        (Constraints(message_bits=4), "an id and an opinion alone take 5 bits; use 5 or more"),
    ],
)
def test_constraints_that_nothing_can_meet_are_errors(constraints, words):
    with pytest.raises(FeasibeeError, match=words):
        compare_under(ROOM, constraints)


def test_a_users_file_is_tested_too(tmp_path):
    rule = tmp_path / "yes.py"
    rule.write_text("def decide(mind, inbox):\n    return 1\n")
    found = compare_under(ROOM, Constraints(0.9), [str(rule)], 100, 1)
    (why,) = found.excluded.values()
    assert why == "with 14 tasks right in 0 of 20"  # it always says feasible


@pytest.mark.parametrize(("robots", "tasks", "others"), [(20, 20, 21), (20, 21, 19), (2, 9, 1), (3, 0, 9)])
def test_the_opposite_is_at_the_reciprocal_ratio(robots, tasks, others):
    here = Scenario(robots={"count": robots}, tasks={"count": tasks})
    there = opposite_of(here)
    assert there.tasks.count == others
    assert truth(there) != truth(here)


def test_a_mixed_team_has_no_opposite():
    team = Scenario(tasks={"classes": [{"name": "lift", "count": 3, "needs": {"arm": 1}}]})
    assert opposite_of(team) is None


def test_the_command_prints_what_to_use_and_why_others_are_excluded(tmp_path):
    (tmp_path / "room.toml").write_text(ROOM.to_toml())
    few = ("--strategies", "dmmd,census", "--runs", 200, "--right", 0.9)
    command = ("compare", tmp_path / "room.toml", *few)
    shown = output_of(*command, "--out", tmp_path / "out")
    assert shown.startswith("Use census: right in 100 % of the runs (")
    assert "yes, needs names, ids" in shown
    assert {path.name for path in (tmp_path / "out").glob("compare*")} == {
        "compare.csv",
        "compare_bits.png",
        "compare_bits.pdf",
    }
    csv = rows_of(tmp_path / "out" / "compare.csv")
    assert [row["reasons"].split()[0] for row in csv] == ["needs", "right"]
    first = json_of(*command)["ranking"][0]
    assert set(first["right"]) == {"estimate", "low", "high"}
    assert first["message_bits"] == int(csv[0]["message_bits"]) == 392
    assert first["needs"] == ["names of tasks", "ids that are never misread"]
    found = json_of(*command, "--no-names")
    assert found["ranking"] == []
    assert {each["strategy"] for each in found["excluded"]} == {"dmmd", "census"}
    assert {each["constraint"] for each in found["relax"]} == {"--no-names", "--right"}


def test_the_public_function_has_a_row_for_each_strategy():
    table = compare_as_table(ROOM, ["dmmd", "census"], (), 100, 1, right=0.9, names=False)
    columns = ["strategy", "meets_all", "reasons"]
    assert table[columns].values.tolist()[0] == ["census", False, "needs names of tasks"]


def test_constraints_are_of_strategies_and_the_old_command_names_the_new_one():
    (line,) = refused("compare", "--presets", "default", "--liars", 1)
    assert line.startswith("feasibee: --presets: can't be tested under constraints; name --strategies")
    (line,) = refused("recommend", "--liars", 1)
    assert "compare --right 0.95" in line


def test_strategies_that_cant_meet_a_constraint_are_simulated_only_if_none_meets_all():
    world = ROOM.replace({"decision.strategy": "dc"})
    found = compare_under(world, Constraints(0.01, names=False), ["dc", "census"], 100, 1)
    assert [each.strategy for each in found.ranking] == ["dc"]
    assert [each.strategy for each in found.tested] == ["dc"]
    assert found.excluded == {"census": "needs names of tasks"}
    none = compare_under(world, Constraints(0.99, names=False), ["dc", "census"], 100, 1)
    assert {each.strategy for each in none.tested} == {"dc", "census"}
    assert not compare_under(world, Constraints(0.99, names=False), ["census"], 100, 1, relax=False).tested


def test_a_strategy_that_is_close_is_named_with_the_runs_that_would_settle_it():
    """100 of 100 are not enough to show 99 %; the world of the opposite truth is run, too."""
    found = compare_under(ROOM, Constraints(0.98), ["census"], 100, 1)
    assert not found.ranking
    assert found.excluded["census"].endswith("right in 100 of 100, too close to tell")
    (line,) = found.probably
    assert line.startswith("census probably is: 100.0 % (")
    assert line.endswith(" more runs would settle it.")
    assert found.to_dict()["probably"] == [line]
    assert len(found.tested[0].worlds) == 2
    assert compare_under(ROOM, Constraints(0.98), ["dmmd"], 100, 1).probably == []
