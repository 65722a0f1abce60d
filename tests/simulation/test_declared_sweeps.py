"""Sweeps of robots that declare: what a folder holds, and what is shown of it."""

from __future__ import annotations

import numpy as np
import pytest
from commands import invoke, json_of
from declaring import declaring
from stores import filled

from feasibee.base.outcomes import ACTS
from feasibee.results.measures import MEASURES, TRACKED, declarations, ended_right, measured, together
from feasibee.results.statistics import confidence_sequence, declare_times, plain, wilson
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.simulation.plan import DesignPoint, StoppingRule
from feasibee.simulation.store import Store
from feasibee.simulation.table import summaries, to_dataframe

TRUTHS = {"quiet": True, "crowded": False, "dmmd": True}


@pytest.fixture(scope="module")
def scenarios(tmp_path_factory):
    quiet = declaring(tmp_path_factory.mktemp("own"), quiet=15.0, run={"steps": 120})
    plain = quiet.replace({"decision.strategy": "dmmd", "decision.parameters": {}})
    return {"quiet": quiet, "crowded": quiet.replace({"tasks.count": 30}), "dmmd": plain}


@pytest.fixture(scope="module")
def folder(scenarios, tmp_path_factory):
    """A folder with 30 runs of two scenarios whose robots declare, and of one whose robots can't."""
    points = [DesignPoint({"name": name}, each) for name, each in scenarios.items()]
    records = [simulate_record(each, Runs(30, 5)) for each in scenarios.values()]
    return filled(tmp_path_factory.mktemp("sweep"), points, records, 5)


def test_status_has_the_declarations_of_each_point(folder, scenarios):
    told = {each["values"]["name"]: each for each in json_of("results", "status", folder)}
    assert told["dmmd"]["declared"] is None
    for name, scenario in scenarios.items():
        record = simulate_record(scenario, Runs(30, 5))
        right = ended_right(record, scenario, TRUTHS[name])
        assert told[name]["right_at_end"] == wilson(int(right.sum()), 30)._asdict()
        if name != "dmmd":
            found = declarations(record, scenario)
            assert 0 < found.wrong.estimate < 1
            assert told[name]["declared"] == plain(found)


def test_a_stopping_rule_makes_the_intervals_valid_at_every_look(scenarios, tmp_path):
    quiet = scenarios["quiet"]
    record = simulate_record(quiet, Runs(30, 5))
    filled(tmp_path, [DesignPoint({}, quiet)], [record], 5, StoppingRule(0.5, None, 30))
    found = summaries(Store(tmp_path))[0].found
    runs = int((record.declared_infeasible > 0).sum())
    assert found.declared.wrong == confidence_sequence(runs, 30)
    both = together([found, measured(record, quiet)], "declared_wrong")
    assert both == confidence_sequence(2 * runs, 60)  # a rule chose the runs of one of the two points
    assert found.declared.step_90 == declare_times(record.declare_step)


def test_a_figure_and_an_export_have_declarations(folder, tmp_path):
    points = [each.found for each in summaries(Store(folder))]
    table = to_dataframe(Store(folder))
    assert (table[table.name == "dmmd"].declare_step == -1).all()
    assert (table[table.name == "quiet"].declared_feasible >= 0).all()
    assert set(table.columns) > {"declared_infeasible", "feasible_at_end", "infeasible_at_end"}
    acted = {name for name, each in MEASURES.items() if each.needs == ACTS}
    for show in MEASURES.keys() - set(TRACKED) - acted:
        words = ("--x", "tasks.count", "--show", show, "--out", tmp_path / "a.png")
        assert invoke("results", "plot", folder, *words).exit_code == 0
        known = [each for each in points if show in each.counts]
        total = sum(each.counts[show] for each in known)
        assert together(points, show) == wilson(total, 30 * len(known))
        assert len(known) == (2 if show.startswith("declared") else 3)
    assert np.isnan(together(points[2:], "declared_ok").estimate)
