"""The answer of feasibee run: a summary of the runs for programs, a few lines for people, and the details."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.metadata import version
from typing import Any

import click

from feasibee.base.codes import DECISIONS, MODEL_VERSION
from feasibee.base.record import Record
from feasibee.cli.options import print_lines
from feasibee.results.measures import measured, together, tracked
from feasibee.results.statistics import Interval, in_percent, plain
from feasibee.scenario.dimensions import LENGTH, TIME
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.units import in_brackets, steps_in_words, when_in_words
from feasibee.simulation.flooding import within


def summary_of(record: Record, scenario: Scenario, seed: int) -> dict[str, Any]:
    """Return what is printed of runs, by the names that programs get."""
    found = measured(record, scenario)
    return {
        "runs": found.runs,
        **{name: found.counts[name] for name in DECISIONS.values()},
        "decision_step": {name: getattr(found.times, name) for name in ("median", "q25", "q75")},
        "truth": "feasible" if truth(scenario) else "infeasible",
        **{name: together([found], name)._asdict() for name in ("accuracy", "right_at_end")},
        "bits_per_robot_and_step": found.bits,
        **tracked(record, scenario),
        **({"flooding": within(scenario)} if scenario.waits_for_names else {}),
        **({} if found.declared is None else {"declared": plain(found.declared)}),
        **({} if found.acting is None else {"acting": plain(found.acting)}),
        "seed": seed,
        "first_run": record.first_run,
        "scenario": scenario.to_dict(),
        "scenario_hash": scenario.hash,
        "version": version("feasibee"),
        "model_version": MODEL_VERSION,
        "rates": {name: rate._asdict() for name, rate in found.rates.items()},
    }


def print_answer(summary: dict[str, Any], scenario: Scenario, details: bool) -> None:
    """Print how often the swarms were right and when, in up to three lines; then all measures, if wanted."""
    lines = _tracked(summary, scenario) if "right_share" in summary else _decided(summary, scenario)
    if "acting" in summary:
        lines.append(_acted(summary, scenario))
    elif "declared" in summary:
        declared = summary["declared"]
        right = _said(declared["ok"], " of the runs")
        lines.append(f"Declared rightly in {right}, wrongly in {_said(declared['wrong'])}.")
    print_lines(lines)
    if details:
        click.echo("\n".join(("", *_details(summary, scenario))))


def _decided(summary: dict[str, Any], scenario: Scenario) -> list[str]:
    """Return how often swarms in a world that stays were right, and when they decided."""
    counts = {name: summary[name] for name in ("feasible", "infeasible", "undecided")}
    step, steps = summary["decision_step"]["median"], f"{scenario.run.steps:,}"
    when = "" if step is None else f"{when_in_words(scenario, step)} of {steps}"
    tasks = f"The tasks are {summary['truth']}."
    if summary["runs"] == 1:
        decision = next(name for name, count in counts.items() if count)
        how = "rightly" if decision == summary["truth"] else "wrongly"
        what = f"decided {decision}, {how}, {when}" if when else f"didn't decide within {steps} steps"
        return [f"Run {summary['first_run']} {what}. {tasks}"]
    listed = ", ".join(f"{name} {count:,}" for name, count in counts.items())
    half = f"Half of the runs decided {when}." if when else f"Fewer than half decided within {steps} steps."
    return [f"Right in {_said(summary['accuracy'], ' of the runs')}: {listed}.", f"{tasks} {half}"]


def _tracked(summary: dict[str, Any], scenario: Scenario) -> list[str]:
    """Return how often swarms in a world that changes were right, and how they followed its changes."""
    alarms, delay, missed = (summary[name] for name in ("false_alarms", "detection_delay", "missed"))
    right = f"Right in {_said(summary['right_share'], ' of the steps')}"
    lines = [f"{right}, with {alarms['estimate']:.2g} false alarms per 1,000 steps."]
    if missed is None:
        return [*lines, "No swarm was right just before a change, so none could follow one."]
    half = "fewer than half were followed"
    if delay["median"] is not None:
        half = f"half were followed within {steps_in_words(scenario, delay['median'])}"
    return [*lines, f"Of {delay['changes']:,} changes, {half}; {_said(missed)} were missed."]


def _acted(summary: dict[str, Any], scenario: Scenario) -> str:
    """Return how often robots took or did all tasks; if they can't, how often they started in vain."""
    acting = summary["acting"]
    if summary["truth"] == "infeasible" and not scenario.dynamic:
        return f"Robots started in vain in {_said(acting['started_in_vain'], ' of the runs')}."
    word = "taken" if acting["all_done_step"] is None else "done"
    steps = acting[f"all_{word}_step"]
    half = "" if steps["median"] is None else f", in half {when_in_words(scenario, steps['median'])}"
    return f"All tasks were {word} in {_said(acting['done'], ' of the runs')}{half}."


def _said(share: dict[str, float], of: str = "") -> str:
    return in_percent(Interval(**share), of)


def _details(summary: dict[str, Any], scenario: Scenario) -> Iterator[str]:
    """Yield a line for each value of a summary but the fields, with its name and interval."""
    for name, (value, *interval) in _flat(summary):
        if not name.startswith("scenario."):
            ends = f" ({_shown(interval[0])} to {_shown(interval[1])})" if interval else ""
            yield f"{name:31} {_shown(value)}{_in_units(name, value, scenario)}{ends}"


def _flat(table: dict[str, Any], above: str = "") -> Iterator[tuple[str, list[Any]]]:
    """Yield the values of tables in tables, each with the ends of its interval, if any."""
    for name, value in table.items():
        if isinstance(value, dict) and "low" not in value:
            yield from _flat(value, f"{above}{name}.")
        elif not name.endswith("_interval"):
            ends = table.get(f"{name}_interval", ())
            yield above + name, [*value.values()] if isinstance(value, dict) else [value, *ends]


def _shown(value: Any) -> str:
    """Return a value as text."""
    if isinstance(value, list):
        return ", ".join(f"{each['truth']} in steps {each['first']} to {each['last']}" for each in value)
    return "none" if value is None else f"{value:.3g}" if isinstance(value, float) else str(value)


def _in_units(name: str, value: Any, scenario: Scenario) -> str:
    """Return a step or a length in seconds or metres, if the scenario has them, in brackets."""
    if name.endswith("distance"):
        return in_brackets(scenario, LENGTH, value)
    is_step = re.search(r"(step\w*|delay)\.(median|q|p)", name)
    return in_brackets(scenario, TIME, value) if is_step else ""
