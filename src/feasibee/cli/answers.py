"""What feasibee compare, assess, size and paper print. It loads their studies, and no figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click
from rich.console import Console
from rich.table import Table

from feasibee.cli.options import in_brackets, percents, print_lines, print_numbers
from feasibee.simulation.sequential import IN_WORDS
from feasibee.studies import constraints
from feasibee.studies.comparison import (
    Outcome,
    answer,
    by_contender,
    half_by,
    in_bits,
    mean_bits,
    overall,
    overall_difference,
)
from feasibee.studies.report import Assessment, sections
from feasibee.studies.size import Sizing, sentences

if TYPE_CHECKING:
    from feasibee.studies.paper import Claim

SUMS_CAPTION = (
    "right: swarms that are right at the end (%), of {runs} with each number of tasks, and the interval; "
    "least: the lowest share, and with how many tasks; difference: from {baseline}, in points, in the same "
    "runs; by: step by which half of the runs had decided; bits: per robot-step"
)
TRACKING_CAPTION = (
    "right: share of steps at which the swarm held the truth (%), with its 95 % interval; delay: steps until "
    "a quarter, half and three quarters of the changes were followed; missed: changes that were not (%); "
    "alarms: false ones per 1,000 steps; bits: per robot-step"
)
CONSTRAINED_CAPTION = (
    "right: % of the runs in the worse world (interval for all tests together); by: step from which enough "
    "are; bits: per robot-step; longest: message; names: of tasks; ids: never misread"
)
SHORT_REASONS = {" of tasks": "", " that are never misread": "", " more": "", "messages of up to": "longest:"}
"""What the caption says once, in place of each row."""
DECLARED_CAPTION = (
    "in brackets: swarms with a robot that declared wrongly (%); below: steps by which more than the "
    "threshold's share of the robots had declared, in half of the swarms and in 95 %"
)


def print_comparison(outcomes: Sequence[Outcome], details: bool) -> None:
    """Print who is right most often, and a table; all others if details are asked for."""
    print_lines(answer(outcomes))
    groups = by_contender(outcomes)
    ranked = sorted(groups, key=lambda name: -overall(groups[name]).estimate)
    first, baseline = next(iter(groups.items()))
    if outcomes[0].tracking is not None:
        _print_tracking(outcomes)
    else:
        heads = ["strategy", "right", "interval", "least", "difference", "by", "bits"]
        sums = [[name, *_sums(groups[name], baseline)] for name in ranked]
        print_numbers("", heads, sums, SUMS_CAPTION.format(baseline=first, runs=baseline[0].runs))
    if not details:
        return
    tasks = ["tasks m", *(str(each.tasks) for each in baseline)]
    title = f"Swarms that are right at the end (%), of {baseline[0].runs} each"
    shares = [[name, *(f"{100 * each.accuracy.estimate:.0f}" for each in groups[name])] for name in ranked]
    print_numbers(title, tasks, shares)
    if declared := [_declared_cells(groups[name]) for name in ranked if groups[name][0].declared is not None]:
        title = f"Swarms that declared rightly (%), of {baseline[0].runs} each, and when"
        print_numbers(title, tasks, declared, DECLARED_CAPTION)


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
            in_bits(each.bits.mean()),
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
    difference = overall_difference(group, baseline)
    worst = min(group, key=lambda each: each.accuracy.estimate)
    return [
        *percents(overall(group)),
        f"{100 * worst.accuracy.estimate:.0f} at {worst.tasks}",
        f"{100 * difference.low:+.1f} to {100 * difference.high:+.1f}" if group is not baseline else "",
        f"{half_by(group):g}".replace("inf", "never"),
        in_bits(mean_bits(group)),
    ]


def _step(step: int | None) -> str:
    return "never" if step is None else str(step)


def print_constrained(found: constraints.Constrained) -> None:
    """Print which strategy to use, and a row for each, with the reasons why others are excluded."""
    print_lines(constraints.answer(found))
    heads = ["strategy", "right", "by", "bits", "longest", "meets all?"]
    rows = [_constrained_cells(row) for row in found.rows]
    print_numbers("", heads, rows, CONSTRAINED_CAPTION, words=True)


def _constrained_cells(row: Mapping[str, Any]) -> list[str]:
    reasons = f"{'yes' if row['meets_all'] else 'no'}, {row['reasons']}"
    for long, short in SHORT_REASONS.items():
        reasons = reasons.replace(long, short)
    if row["right"] is None:
        return [row["strategy"], *[""] * 4, reasons]
    share = in_brackets([row[name] for name in ("right", "right_low", "right_high")], 0)
    step = "" if row["step"] is None else str(row["step"])
    bits = in_bits(row["bits_per_robot_and_step"])
    return [row["strategy"], share, step, bits, str(row["message_bits"]), reasons]


def print_assessment(assessment: Assessment, details: bool) -> None:
    """Print the verdict, what to do, and a table; all other sections if details are asked for."""
    first, *others = sections(assessment).items()
    print_lines(first[1])
    print_numbers("", *assessment.table)
    print_lines(assessment.warnings)
    for title, lines in others if details else ():
        click.echo(f"\n{title}")
        print_lines(lines, "  ", "    ")


def print_sizing(found: Sizing, details: bool) -> None:
    """Print how much is enough, and the blind band; the tested values if details are asked for."""
    print_lines(sentences(found))
    if not details:
        return
    band = () if found.band is None else (found.band.below, found.band.above)
    rows = [
        [f"{edge.path} = {value}", *percents(each.interval), str(each.trials), IN_WORDS[each.answer]]
        for edge in (found.edge, *band)
        for value, each in edge.tested
    ]
    print_numbers("", ["value", "right (%)", "interval", "runs", "verdict"], rows, words=True)
    print_lines(
        [f"The whole answer has {100 * found.rule.confidence:g} % confidence, if {found.assumption}."]
    )


def print_claims(claims: list[Claim], runs: int) -> None:
    """Print the verdict on each claim of the paper."""
    colours = {"holds": "green", "fails": "red", "can't tell": "yellow"}
    found = [claim.verdict for claim in claims]
    told = ", ".join(f"{verdict} {found.count(verdict)}" for verdict in colours)
    click.echo(f"The paper's {len(claims)} claims, from {runs:,} runs at each ratio: {told}.")
    table = Table(show_lines=True)
    table.add_column("verdict", no_wrap=True)
    table.add_column("claim, and what the runs say")
    for claim in claims:
        measured = f"{claim.estimate:.3g} ({claim.low:.3g} to {claim.high:.3g}); must be {claim.bar}"
        verdict = f"[{colours[claim.verdict]}]{claim.verdict}[/]"
        table.add_row(verdict, f"{claim.claim}\n[dim]{claim.statistic}:[/]\n{measured}")
    Console(highlight=False).print(table)
