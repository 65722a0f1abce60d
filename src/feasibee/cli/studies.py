"""feasibee paper, feasibee compare: studies with figures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from feasibee.cli.execution import executing, leave_if_stopped
from feasibee.cli.options import (
    Given,
    Workforce,
    command,
    count_type,
    folder_option,
    listed,
    numbered,
    option,
    percents,
    print_json,
    print_numbers,
    strategies_option,
)
from feasibee.files import make_folder
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario
    from feasibee.studies.comparison import Outcome
    from feasibee.studies.paper import Claim
    from feasibee.sweeps.sweep import Rounds

SUMS_CAPTION = (
    "right: share at the end (%), with its 95 % interval; difference: from {baseline}, in points, in the "
    "same runs; first: share of right first collective decisions (%); by: step by which half of the runs had "
    "decided; bits: per robot-step"
)
CALIBRATION_CAPTION = (
    "brier: mean squared distance of the probability of feasible from the truth, 1 or 0, with its interval; "
    "0 is best, 0.25 says nothing. The probability is the {by} that hold feasible at the end{own}. brier is "
    "rel - res + {uncertainty:.3f}. rel: reliability, 0 if tasks are feasible as often as said. res: "
    "resolution, the larger the better worlds are told apart. sure: swarms that are right (%), of those with "
    "90 % or more on one side"
)
TRACKING_CAPTION = (
    "right: share of steps at which the swarm held the truth (%), with its 95 % interval; delay: steps until "
    "a quarter, half and three quarters of the changes were followed; missed: changes that were not (%); "
    "alarms: false ones per 1,000 steps; bits: per robot-step"
)
DECLARED_CAPTION = (
    "in brackets: swarms with a robot that declared wrongly (%); below: steps by which more than the "
    "threshold's share of the robots had declared, in half of the swarms and in 95 %"
)


@command()
def compare(
    *,
    given: Given,
    strategies: tuple[str, ...] = strategies_option("all built-in ones"),
    presets: tuple[str, ...] = option(
        "Presets to compare, instead of strategies; 'default' is the paper.",
        callback=listed,
        metavar="A,B,...",
    ),
    tasks: tuple[int, ...] = option(
        "Numbers of tasks; by default nine, most of them near ratio 1; in a world that changes, "
        "the scenario's.",
        callback=numbered,
        metavar="M,N,...",
    ),
    runs: int = option("Number of runs of each contender at each number of tasks.", count_type, 200),
    seed: int,
    budget: float | None,
    workforce: Workforce,
    out: Path = folder_option("compare", "figures and data"),
    as_json: bool,
) -> None:
    """Compare strategies on the same worlds: accuracy, calibration, decision time, declarations, bits.

    FILE is a scenario in TOML; without one, the paper's defaults. A strategy may be the path of a .py file.
    After --budget, or at Ctrl-C on a terminal, it compares the runs that are there.

    \b
    Examples:
      feasibee compare
      feasibee compare --strategies dmmd,dmvd,census --tasks 10,20,21,40 --runs 1000
      feasibee compare mine.toml --strategies dmmd,my_strategy.py
      feasibee compare --presets default,valentini-2016 --runs 100
      feasibee compare mine.toml --runs 10000 --budget 2min
    """
    from feasibee.studies.comparison import as_dict, contenders_of, write_comparison
    from feasibee.studies.comparison import compare as simulate_all
    from feasibee.studies.needs import suitable

    scenario = given.read()
    numbers = _tasks_of(scenario, tasks, runs, seed)
    contenders = contenders_of(scenario, strategies, presets)
    for name, error in () if strategies or presets else suitable(scenario)[1].items():
        click.echo(f"feasibee: left out {name}: {error}", err=True)
    folder = make_folder(out)
    with _rounds(folder, workforce, budget) as rounds:
        outcomes = simulate_all(contenders, numbers, runs, seed, rounds)
    write_comparison(folder, outcomes)
    if as_json:
        print_json({**as_dict(outcomes, outcomes[0].runs, seed), "stopped": rounds.stopped})
    else:
        _print_comparison(outcomes)
        click.echo(f"Figures (PNG, PDF) and their data (CSV) are in {folder}/")
    _leave_if_stopped(rounds.stopped, outcomes, runs)


@contextmanager
def _rounds(folder: Path, workforce: Workforce, budget: float | None) -> Iterator[Rounds]:
    """Let a comparison run within, which answers early after its budget, and at Ctrl-C on a terminal."""
    from feasibee.sweeps.sweep import Rounds

    with (
        executing("Comparing", folder, workforce, budget=budget, answers=True) as execution,
        Rounds(execution, most=None) as rounds,
    ):
        yield rounds


def _leave_if_stopped(stopped: str, outcomes: Sequence[Outcome], runs: int) -> None:
    """Say which runs are missing if a comparison ended early; end the process as at Ctrl-C if that is why."""
    fewer = [each.runs for each in outcomes if each.runs < runs]
    if fewer:
        missing = f"{len(fewer)} of {len(outcomes)} have {min(fewer):,} instead of {runs:,} runs"
        click.echo(f"feasibee: {stopped}: {missing}; the same command goes on", err=True)
    leave_if_stopped(stopped)


def _tasks_of(scenario: Scenario, tasks: tuple[int, ...], runs: int, seed: int) -> Sequence[int]:
    """Validate the numbers of runs and tasks; return the latter, none if the scenario has its own."""
    from feasibee.studies.comparison import TASKS

    Runs.of_point(0, runs, seed)  # raises before the folder is made
    for number in tasks:
        scenario.replace({"tasks.count": number})  # likewise
    as_it_is = scenario.tasks.classes or scenario.tasks.points or scenario.dynamic
    return tasks or (() if as_it_is else TASKS)


@command()
def paper(
    *,
    out: Path = folder_option("paper", "figures, data and claims"),
    runs: int = option(
        "Number of runs at each ratio; the paper has 100, which leave some claims open.",
        click.IntRange(4),
        2000,
    ),
    seed: int,
    workforce: Workforce,
    beyond: bool = option("Instead, draw Fig. 3 again in six worlds unlike the paper's.", is_flag=True),
) -> None:
    """Reproduce the paper: its three figures, the data behind them, its claims checked.

    \b
    Examples:
      feasibee paper
      feasibee paper --runs 100 --out paper-100
      feasibee paper --beyond --runs 400
    """
    Runs.of_point(0, runs, seed)  # raises before the folder is made
    folder = make_folder(out)
    if beyond:
        _beyond(folder, runs, seed, workforce)
        return
    from feasibee.studies.paper import run_study, write_study

    with executing("Simulating the paper's study", folder, workforce) as execution:
        points = run_study(runs, seed, execution)
    _print_claims(write_study(folder, points, seed), runs)
    click.echo(f"Figures (PNG, PDF), their data (CSV) and claims.json are in {out}/")


def _beyond(folder: Path, runs: int, seed: int, workforce: Workforce) -> None:
    from feasibee.studies.paper import simulate_panels, summary, write_panels

    with executing("Simulating beyond the paper", folder, workforce) as execution:
        points = simulate_panels(runs, seed, execution)
    write_panels(folder, points)
    heads, *rows = summary(points)
    print_numbers(f"Share of right decisions, by ratio, from {runs} runs each", heads, rows)
    click.echo(f"beyond.png, beyond.pdf and their data, beyond.csv, are in {folder}/")


def _print_claims(claims: list[Claim], runs: int) -> None:
    from rich.console import Console
    from rich.table import Table

    colours = {"holds": "green", "fails": "red", "can't tell": "yellow"}
    table = Table(title=f"The paper's claims, from {runs} runs at each ratio", show_lines=True)
    table.add_column("verdict", no_wrap=True)
    table.add_column("claim, and what the runs say")
    for claim in claims:
        measured = f"{claim.estimate:.3g} ({claim.low:.3g} to {claim.high:.3g}); must be {claim.bar}"
        verdict = f"[{colours[claim.verdict]}]{claim.verdict}[/]"
        table.add_row(verdict, f"{claim.claim}\n[dim]{claim.statistic}:[/]\n{measured}")
    Console(highlight=False).print(table)


def _print_comparison(outcomes: list[Outcome]) -> None:
    from feasibee.studies.comparison import by_contender, overall

    if outcomes[0].tracking is not None:
        _print_tracking(outcomes)
    groups = by_contender(outcomes)
    ranked = sorted(groups, key=lambda name: -overall(groups[name]).estimate)
    some = next(iter(groups.values()))
    tasks = ["tasks m", *(str(each.tasks) for each in some)]
    title = f"Swarms that are right at the end (%), of {some[0].runs} each"
    shares = [[name, *(f"{100 * each.accuracy.estimate:.0f}" for each in groups[name])] for name in ranked]
    print_numbers(title, tasks, shares)
    first, baseline = next(iter(groups.items()))
    heads = ["over all m", "right", "interval", "difference", "first", "by", "bits"]
    sums = [[name, *_sums(groups[name], baseline)] for name in ranked]
    print_numbers("All together", heads, sums, SUMS_CAPTION.format(baseline=first))
    _print_calibration(outcomes)
    if declared := [_declared_cells(groups[name]) for name in ranked if groups[name][0].declared is not None]:
        title = f"Swarms that declared rightly (%), of {some[0].runs} each, and when"
        print_numbers(title, tasks, declared, DECLARED_CAPTION)


def _print_calibration(outcomes: Sequence[Outcome]) -> None:
    """Print how far the agreement of robots can be trusted, the best first; nothing without both truths."""
    from feasibee.results.calibration import OWN, SHARES
    from feasibee.studies.comparison import calibrations

    rows = []
    for name, found in sorted(calibrations(outcomes).items(), key=lambda pair: pair[1].brier.estimate):
        score, low, high = (f"{each:.3f}" for each in found.brier)
        parts = f"{found.reliability:.3f}", f"{found.resolution:.3f}"
        sure = percents(found.sure) if found.sure else ("", "")
        rows.append([name, score, f"{low} to {high}", *parts, *sure])
        uncertainty = found.uncertainty
    heads = ["over all m", "brier", "interval", "rel", "res", "sure", "interval"]
    if rows:
        own = dict.fromkeys(each.contender for each in outcomes if each.said_by == OWN)
        instead = f"; of {', '.join(own)} it is the {OWN}" if own else ""
        caption = CALIBRATION_CAPTION.format(by=SHARES, own=instead, uncertainty=uncertainty)
        print_numbers("How sure the swarms are", heads, rows, caption)


def _declared_cells(group: list[Outcome]) -> list[str]:
    """Return a contender, and for each number of tasks a line for the shares and one for the steps."""
    cells = [group[0].contender]
    for declared in (each.declared for each in group if each.declared is not None):
        wrong = f" ({100 * declared.wrong.estimate:.2g})" if declared.wrong.estimate else ""
        steps = "/".join(map(_step, declared.step_90[:2]))
        cells.append(f"{100 * declared.ok.estimate:.0f}{wrong}\n{steps}")
    return cells


def _print_tracking(outcomes: Sequence[Outcome]) -> None:
    """Print how swarms tracked the truth, by contender and number of tasks, the most often right first."""
    several = len({each.tasks for each in outcomes}) > 1
    found = [(each, each.tracking) for each in outcomes if each.tracking is not None]
    rows = [
        [
            each.contender,
            *[str(each.tasks)] * several,
            *percents(tracked.right_share),
            _delays(tracked.detection_delay),
            "" if tracked.missed is None else f"{100 * tracked.missed.estimate:.1f}",
            f"{tracked.false_alarms.estimate:.2g}",
            f"{each.bits.mean():.3g}",
        ]
        for each, tracked in sorted(found, key=lambda pair: -pair[1].right_share.estimate)
    ]
    title = f"How swarms track the truth, {outcomes[0].runs} runs each"
    heads = ["strategy", *["m"] * several, "right", "interval", "delay", "missed", "alarms", "bits"]
    print_numbers(title, heads, rows, TRACKING_CAPTION, narrow=True)


def _delays(steps: Sequence[int | None]) -> str:
    """Return the quartiles of delays; a single word if even the first is unknown."""
    return "never" if steps[0] is None else "/".join("-" if step is None else str(step) for step in steps)


def _sums(group: list[Outcome], baseline: list[Outcome]) -> list[str]:
    """Return the cells of a contender over all numbers of tasks."""
    from feasibee.studies.comparison import mean_bits, overall, overall_difference

    share, difference = overall(group), overall_difference(group, baseline)
    first = sum(each.first.estimate for each in group) / len(group)
    steps = sorted(each.found.times.median or float("inf") for each in group)
    return [
        *percents(share),
        f"{100 * difference.low:+.1f} to {100 * difference.high:+.1f}" if group is not baseline else "",
        f"{100 * first:.0f}",
        f"{steps[len(steps) // 2]:g}",
        f"{mean_bits(group):.3g}",
    ]


def _step(step: int | None) -> str:
    return "never" if step is None else str(step)
