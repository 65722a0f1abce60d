"""feasibee compare, assess, size, paper: questions that many runs answer."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.base.errors import FeasibeeError
from feasibee.base.files import FIGURES, make_folder
from feasibee.cli.execution import executing, leave_if_stopped
from feasibee.cli.options import (
    RUNS,
    FiniteRange,
    GivenScenario,
    Workforce,
    command,
    complete_strategy,
    count_type,
    folder_option,
    folder_type,
    listed,
    named,
    numbered,
    option,
    outputs_option,
    print_json,
    print_lines,
    print_numbers,
)
from feasibee.scenario.paths import read_value
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario
    from feasibee.studies.comparison import Comparison
    from feasibee.studies.constraints import Constrained

FEW = click.IntRange(0, 1_000_000)
SHARE = FiniteRange(0, 1, min_open=True, max_open=True)
BITS = FiniteRange(0, 1e9, min_open=True)


@command()
def compare(
    *,
    given: GivenScenario,
    strategies: tuple[str, ...] = option(
        "Strategies to compare; by default all built-in ones.",
        callback=listed,
        metavar="A,B,...",
        shell_complete=complete_strategy,
    ),
    presets: tuple[str, ...] = option(
        "Presets to compare, instead of strategies; 'default' is the paper.",
        callback=listed,
        metavar="A,B,...",
    ),
    tasks: tuple[int, ...] = option(
        "Numbers of tasks; by default nine, most of them near ratio 1; in a world that changes, "
        "the scenario's; with constraints, the scenario's and the opposite one.",
        callback=numbered,
        metavar="M,N,...",
    ),
    steps: int | None,
    right: float | None = option("Constraint: share of swarms that must be right; else 0.95.", SHARE),
    bits: float | None = option("Constraint: most bits per robot-step, on average.", BITS),
    message_bits: int | None = option("Constraint: most bits in a message.", click.IntRange(1, 2**31)),
    no_ids: bool = option("Constraint: ids may be mistaken; robots draw them at random."),
    no_names: bool = option("Constraint: tasks have no names, all look alike."),
    liars: int = option("Constraint: number of Byzantine robots to bear.", FEW, 0, show_default=False),
    stopped: int = option("Constraint: number of broken robots to bear.", FEW, 0, show_default=False),
    runs: int | None = option(
        "Number of runs of each contender at each number of tasks, by default 200; with constraints the "
        "largest number, by default 1000.",
        count_type,
    ),
    seed: int,
    budget: float | None,
    workforce: Workforce,
    out: Path | None = option(f"Folder for figures and data, and {RUNS}", folder_type),
    details: bool = option("Also print shares and declarations by number of tasks."),
    as_json: bool,
) -> None:
    """Compare strategies on the same worlds: which is right most often, or meets your constraints.

    FILE is a scenario in TOML; without one, the paper's defaults. A strategy may be the path of a .py file.
    After --budget, or at Ctrl-C on a terminal, it compares the runs that are there.

    With a constraint, each strategy is tested in this world, with the faulty robots that it must bear, and
    with the number of tasks at which the truth is the opposite. What it needs is declared in its file. A
    column says why a strategy is excluded, or what it needs.

    \b
    Examples:
      feasibee compare
      feasibee compare mine.toml --strategies dmmd,my_strategy.py --tasks 10,20,21,40 --runs 1000
      feasibee compare --presets default,valentini-2016 --runs 100
      feasibee compare mine.toml --right 0.95 --message-bits 64 --no-names --liars 1
    """
    from feasibee.simulation.kept import kept_folder
    from feasibee.simulation.sweep import Rounds
    from feasibee.studies import comparison
    from feasibee.studies.constraints import Constraints, compare_under

    scenario = given.read({"run.steps": steps})
    wanted = Constraints(right or 0.95, bits, message_bits, not no_ids, not no_names, liars, stopped)
    is_constrained = right is not None or wanted != Constraints()
    if is_constrained and presets:
        raise FeasibeeError("--presets: can't be tested under constraints; name --strategies instead")
    runs = runs or (1000 if is_constrained else 200)
    numbers = _tasks_of(scenario, tasks, runs, seed)
    contenders = {} if is_constrained else _contenders(scenario, strategies, presets)
    folder = kept_folder(scenario, seed) if out is None else out
    with executing("Comparing", folder, workforce, budget=budget, answers=True) as execution:
        found: Comparison | Constrained
        if is_constrained:
            found = compare_under(scenario, wanted, strategies, runs, seed, execution, tasks=tasks)
        else:
            with Rounds(execution, most=None) as rounds:
                outcomes = comparison.compare(contenders, numbers, runs, seed, rounds)
            found = comparison.Comparison(outcomes, runs, seed, rounds.stopped)
    _answer(found, out, details, as_json)


def _contenders(
    scenario: Scenario, strategies: tuple[str, ...], presets: tuple[str, ...]
) -> dict[str, Scenario]:
    """Return what is compared; say which built-in strategies are left out."""
    from feasibee.studies.comparison import contenders_of
    from feasibee.studies.needs import suitable

    contenders = contenders_of(scenario, strategies, presets)
    for name, error in () if strategies or presets else suitable(scenario)[1].items():
        click.echo(f"feasibee: left out {name}: {error}", err=True)
    return contenders


def _answer(found: Comparison | Constrained, out: Path | None, details: bool, as_json: bool) -> None:
    """Print what a comparison found, and what is missing; write it into a folder, if one is asked for."""
    from feasibee.cli.answers import print_comparison, print_constrained
    from feasibee.studies.constraints import Constrained

    if as_json:
        print_json(found.to_dict())
    elif isinstance(found, Constrained):
        print_constrained(found)
    else:
        print_comparison(found.outcomes, details)
    if out is not None:  # after the answer: it loads matplotlib, and takes seconds
        from feasibee.studies.files import write_comparison

        write_comparison(out, found)
        if not (as_json or isinstance(found, Constrained)):
            click.echo(f"Figures (PNG, PDF) and their data (CSV) are in {out}/")
    if found.missing:
        click.echo(f"feasibee: {found.stopped}: {found.missing}; the same command goes on", err=True)
    leave_if_stopped(found.stopped)


def _tasks_of(scenario: Scenario, tasks: tuple[int, ...], runs: int, seed: int) -> Sequence[int]:
    """Validate the numbers of runs and tasks; return the latter, none if the scenario has its own."""
    from feasibee.studies.comparison import TASKS

    Runs.of_point(0, runs, seed)  # raises before the folder is made
    for number in tasks:
        scenario.replace({"tasks.count": number})  # likewise
    as_it_is = scenario.tasks.classes or scenario.tasks.points or scenario.dynamic
    return tasks or (() if as_it_is else TASKS)


@command()
def assess(
    *,
    given: GivenScenario,
    robots: int | None = option("Short for --set robots.count=...", int),
    tasks: int | None = option("Short for --set tasks.count=...", int),
    arena: Any = option("Side of the arena: short for --set arena.side=...", read_value, metavar="LENGTH"),
    reach: Any = option("Short for --set sensing.range=...", read_value, name="--range", metavar="LENGTH"),
    steps: int | None,
    runs: int = option("Number of runs of each variant.", count_type, 400),
    right: float,
    seed: int,
    budget: float | None,
    workforce: Workforce,
    outputs: dict[str, Path] = outputs_option(
        "Write the assessment as one .html file; printed, its first page has the answer. "
        f"A folder: {RUNS} Repeatable.",
        folder=True,
        hint=", and print that page for PDF",
        page=(".html", ".htm"),
    ),
    details: bool = option("Also say what to expect, how many robots are enough, and what helps."),
    as_json: bool,
) -> None:
    """Assess whether a swarm is right often enough, what to do, and how soon, how safe and how dear that is.

    FILE is a scenario in TOML; without one, the paper's defaults. Standard error has a first verdict after
    10 runs. Without --details, --json or a page, only what the answer rests on is simulated. All differences
    are of runs on the same worlds. After --budget, or at Ctrl-C on a terminal, it says what is there, and
    which parts are missing.

    \b
    Examples:
      feasibee assess mine.toml
      feasibee assess mine.toml --details --out mine.html
      feasibee assess --robots 40 --tasks 30 --arena 50 --range 4
      feasibee assess mine.toml --budget 2min
    """
    from feasibee.cli.answers import print_assessment
    from feasibee.simulation.kept import kept_folder
    from feasibee.studies.assess import assess as simulate_all

    Runs(runs, seed)  # raises before the work
    short = {"robots.count": robots, "tasks.count": tasks, "arena.side": arena, "sensing.range": reach}
    scenario = given.read({**short, "run.steps": steps})
    folder = outputs.pop("folder", None) or kept_folder(scenario, seed)
    page, every = outputs.get("page"), details or as_json or "page" in outputs
    with executing("Assessing", folder, workforce, budget=budget, answers=True) as execution:
        assessment = simulate_all(scenario, runs, seed, execution, right, details=every)
    if page:
        from feasibee.studies.files import write_report

        write_report(assessment, page, shlex.join(("feasibee", *sys.argv[1:])))
    if as_json:
        print_json(assessment.to_dict())
    else:
        print_assessment(assessment, details)
        if page:
            click.echo(f"The report is {page}")
    leave_if_stopped(assessment.stopped)


@command()
def size(
    *,
    given: GivenScenario,
    right: float,
    steps: int | None,
    over: str = option(
        "Field to search, such as radio.range, run.steps or decision.parameters.quiet.",
        default="robots.count",
        callback=named,
        metavar="FIELD[=LOW:HIGH]",
    ),
    strategy: str | None = option(
        "Short for --set decision.strategy=...", callback=named, shell_complete=complete_strategy
    ),
    runs: int = option("Largest number of runs at each value; the search begins with 100.", count_type, 2000),
    seed: int,
    budget: float | None,
    workforce: Workforce,
    outputs: dict[str, Path] = outputs_option(
        f"Draw the shares, with the blind band shaded: .png, .pdf or .svg. A folder: {RUNS} Repeatable.",
        folder=True,
        figure=FIGURES,
    ),
    details: bool = option("Also print the tested values, and what the answer assumes."),
    as_json: bool,
) -> None:
    """Find out how many robots are enough for a swarm to be right often enough.

    FILE is a scenario in TOML; without one, the paper's defaults. The answer is the least number of robots
    for these tasks, or the least value of another field. It also has the blind band: the numbers of tasks for
    which this swarm is not right often enough. The search tests few values, each by as many runs as it takes;
    the whole answer holds with a probability of 95 %. It assumes that the share of right swarms doesn't fall
    as the field grows. With a longer radio.range it may: the last value is tested, and a fall is reported.

    \b
    Examples:
      feasibee size mine.toml
      feasibee size mine.toml --strategy dc --right 0.99 --steps 600 --out size.png
      feasibee size mine.toml --over radio.range=1:8
    """
    from feasibee.cli.answers import print_sizing
    from feasibee.simulation.kept import kept_folder
    from feasibee.studies.size import Rule
    from feasibee.studies.size import size as search

    scenario = given.read({"decision.strategy": strategy, "run.steps": steps})
    Runs(runs, seed)  # raises before the search
    folder = outputs.get("folder") or kept_folder(scenario, seed)
    with executing("Sizing", folder, workforce, budget=budget, answers=True) as execution:
        found = search(
            scenario, over, Rule(right, most=runs), seed, execution, lambda line: click.echo(line, err=True)
        )
    if as_json:
        print_json(found.to_dict())
    else:
        print_sizing(found, details)
    if plot := outputs.get("figure"):
        from feasibee.figures.comparison import draw_sizing
        from feasibee.figures.style import save_figure
        from feasibee.studies.size import panels_of

        save_figure(draw_sizing(panels_of(found), found.rule.target), plot)
        if not as_json:
            print_lines([f"The figure is {plot}"])
    leave_if_stopped(found.stopped)


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
    beyond: bool = option("Instead, draw Fig. 3 again in six worlds unlike the paper's."),
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
    from feasibee.cli.answers import print_claims
    from feasibee.studies.paper import run_study, write_study

    with executing("Simulating the paper's study", folder, workforce) as execution:
        points = run_study(runs, seed, execution)
    print_claims(write_study(folder, points, seed), runs)
    click.echo(f"Figures (PNG, PDF), their data (CSV) and claims.json are in {out}/")


def _beyond(folder: Path, runs: int, seed: int, workforce: Workforce) -> None:
    from feasibee.studies.paper import simulate_panels, summary, write_panels

    with executing("Simulating beyond the paper", folder, workforce) as execution:
        points = simulate_panels(runs, seed, execution)
    write_panels(folder, points)
    heads, *rows = summary(points)
    print_numbers(f"Share of right decisions, by ratio, from {runs} runs each", heads, rows)
    click.echo(f"beyond.png, beyond.pdf and their data, beyond.csv, are in {folder}/")
