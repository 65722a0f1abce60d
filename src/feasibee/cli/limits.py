"""feasibee compare --limits: how soon any strategy could be sure, and how soon strategies are."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.execution import executing
from feasibee.cli.options import Workforce, console, numbers_table, progress

if TYPE_CHECKING:
    from rich.table import Table

    from feasibee.scenario.scenario import Scenario
    from feasibee.studies.limits import Limits, Spoken

ALONE = ("none",)
"""What stands for strategies if only the limits are asked for."""
NOTE = (
    "By the median, half of the runs got there. Whatever their strategy, robots that are never wrong declare "
    "infeasible no sooner than flooding, and feasible no sooner than complete map."
)


def compare_with_limits(
    scenario: Scenario,
    strategies: tuple[str, ...],
    tasks: Sequence[int],
    runs: int,
    seed: int,
    cells: int,
    workforce: Workforce,
    out: Path,
    as_json: bool,
) -> None:
    """Simulate strategies and limits of their worlds; write and print both."""
    from feasibee.files import make_folder
    from feasibee.scenario.runs import Runs
    from feasibee.studies.limits import contenders_named, designs_of, limits_near, oracle_world, tasks_near
    from feasibee.studies.limits import frontier as simulate_all

    alone = strategies == ALONE
    numbers = [scenario.tasks.count] if alone and not tasks else tasks_near(scenario, tasks)
    contenders = [] if alone else contenders_named(strategies)
    Runs.of_point(len(numbers) - 1, runs, seed)
    for number in numbers:  # raises before the folder is made
        oracle_world(scenario.replace({"tasks.count": number}), cells)
    designs_of(scenario, contenders, numbers, runs, seed)  # likewise
    folder = make_folder(out)
    found: list[Spoken] = []
    if contenders:
        with executing("Comparing", folder, workforce) as execution:
            found = simulate_all(scenario, contenders, numbers, runs, seed, execution)
    with progress("Computing the limits") as advance:
        bounds = limits_near(scenario, numbers, runs, seed, cells, workforce.workers, advance)
    _write(folder, found, bounds)
    if as_json:
        click.echo(json.dumps([_as_dict(found, limits) for limits in bounds.values()], indent=2))
        return
    if found:
        _print_frontier(found)
    else:
        _print_limits(list(bounds.values()))
    click.echo(f"Figures (PNG, PDF) and their data (CSV) are in {folder}/")


def _write(folder: Path, found: Sequence[Spoken], bounds: dict[int, Limits]) -> None:
    from feasibee.figures.limits import draw_limits
    from feasibee.figures.style import save_both
    from feasibee.studies.limits import write_frontier, write_limits

    write_limits(folder / "limits.csv", bounds)
    if found:
        write_frontier(folder, found, bounds)
        return
    for number, limits in bounds.items():
        save_both(draw_limits(limits.steps, limits.scenario.run.steps), folder / f"limits-{number}")


def _as_dict(found: Sequence[Spoken], limits: Limits) -> dict[str, Any]:
    """Return the limits at a number of tasks, and what the strategies' robots said there."""
    group = [each for each in found if each.tasks == limits.scenario.tasks.count]
    return {**limits.to_dict(), **({"strategies": [each.to_dict() for each in group]} if group else {})}


def _print_limits(bounds: Sequence[Limits]) -> None:
    from feasibee.studies.limits import LIMITS
    from feasibee.studies.needs import quiet_times_in_words

    out = console()
    for each in bounds:
        out.print(_limits_table(each))
    for name, words in LIMITS.items():
        out.print(f"{_named(name)}: {words}.", soft_wrap=True)
    for line in (NOTE, *quiet_times_in_words(bounds[0].scenario)):
        out.print(line, soft_wrap=True)


def _limits_table(found: Limits) -> Table:
    robots, tasks = found.scenario.robots.count, found.scenario.tasks.count
    title = f"{robots} robots, {tasks} tasks, {found.runs} runs"
    table = numbers_table(title, "limit", ("median", "interval", "95 %", "interval"))
    for name, times in found.times.items():
        steps = ((times.median, times.median_interval), (times.p95, times.p95_interval))
        cells = [text for step, ends in steps for text in (_shown(step), " to ".join(map(_shown, ends)))]
        table.add_row(_named(name), *cells)
    return table


def _named(limit: str) -> str:
    return limit.replace("_", " ")


def _shown(step: int | None) -> str:
    return "never" if step is None else str(step)


def _print_frontier(found: list[Spoken]) -> None:
    title = f"Right by their own word (%), of {found[0].runs} swarms; steps of half and 95 %"
    groups: dict[str, list[Spoken]] = {}
    for each in found:
        groups.setdefault(each.contender, []).append(each)
    numbers = [f"m = {each.tasks}" for each in next(iter(groups.values()))]
    table = numbers_table(title, "", [*numbers, "bits"])
    for name, group in groups.items():
        cells = [
            f"{100 * each.ok.estimate:.1f}\n{_shown(each.times.median)}/{_shown(each.times.p95)}"
            for each in group
        ]
        table.add_row(name, *cells, f"{sum(each.bits for each in group) / len(group):.3g}")
    console().print(table)
