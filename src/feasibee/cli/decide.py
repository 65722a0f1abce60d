"""feasibee assess, size, recommend: is a swarm right, how many robots are enough, and which strategy is."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.execution import executing, leave_if_stopped
from feasibee.cli.options import (
    JOURNAL,
    FiniteRange,
    Given,
    Workforce,
    command,
    complete_strategy,
    count_type,
    folder_type,
    named,
    option,
    outputs_option,
    print_json,
    strategies_option,
    wrapped,
)
from feasibee.files import FIGURES
from feasibee.scenario.paths import read_value
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.studies.recommend import Recommendation


@command()
def assess(
    *,
    given: Given,
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
        f"A folder: {JOURNAL} Repeatable.",
        folder=True,
        hint=", and print that page for PDF",
        page=(".html", ".htm"),
    ),
    as_json: bool,
) -> None:
    """Assess in plain words how often a swarm is right, how soon, what it takes, and what would help.

    FILE is a scenario in TOML; without one, the paper's defaults. The verdict comes first, and on standard
    error already while the rest is computed. All differences are of runs on the same worlds. After --budget,
    or at Ctrl-C on a terminal, it says what is there, and which parts are missing.

    \b
    Examples:
      feasibee assess mine.toml --out mine.html
      feasibee assess --robots 40 --tasks 30 --arena 50 --range 4
      feasibee assess mine.toml --budget 2min
    """
    from feasibee.studies.assess import assess as simulate_all
    from feasibee.studies.pages import write_report
    from feasibee.studies.report import sections
    from feasibee.sweeps.kept import kept_folder

    Runs(runs, seed)  # raises before the work
    short = {"robots.count": robots, "tasks.count": tasks, "arena.side": arena, "sensing.range": reach}
    scenario = given.read({**short, "run.steps": steps})
    folder = outputs.pop("folder", None) or kept_folder(scenario, seed)
    with executing("Assessing", folder, workforce, budget=budget, answers=True) as execution:
        assessment = simulate_all(scenario, runs, seed, execution, right)
    if page := outputs.get("page"):
        write_report(assessment, page, shlex.join(("feasibee", *sys.argv[1:])))
    if as_json:
        print_json(assessment.to_dict())
    for title, lines in sections(assessment).items() if not as_json else ():
        click.echo(title)
        for line in lines:
            click.echo(wrapped(line, "  ", "    "))
        click.echo()
    if page and not as_json:
        click.echo(f"The report is {page}")
    leave_if_stopped(assessment.stopped)


@command()
def size(
    *,
    given: Given,
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
        f"Draw the shares, with the blind band shaded: .png, .pdf or .svg. A folder: {JOURNAL} Repeatable.",
        folder=True,
        figure=FIGURES,
    ),
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
    from feasibee.figures.sizing import draw_sizing
    from feasibee.figures.style import save_figure
    from feasibee.studies.size import Rule, panels_of, sentences
    from feasibee.studies.size import size as search
    from feasibee.sweeps.kept import kept_folder

    scenario = given.read({"decision.strategy": strategy, "run.steps": steps})
    Runs(runs, seed)  # raises before the search
    folder = outputs.get("folder") or kept_folder(scenario, seed)
    with executing("Sizing", folder, workforce, budget=budget, answers=True) as execution:
        found = search(
            scenario, over, Rule(right, most=runs), seed, execution, lambda line: click.echo(line, err=True)
        )
    if plot := outputs.get("figure"):
        save_figure(draw_sizing(panels_of(found), found.rule.target), plot)
    told = [
        *sentences(found),
        f"Whole answer: {100 * found.rule.confidence:g} % confidence, if {found.assumption}.",
    ]
    if plot is not None:
        told.append(f"The figure is {plot}")
    if as_json:
        print_json(found.to_dict())
    for sentence in told if not as_json else ():
        click.echo(wrapped(sentence))
    leave_if_stopped(found.stopped)


FEW = click.IntRange(0, 1_000_000)


@command()
def recommend(
    *,
    given: Given,
    right: float,
    bits: float | None = option("Most bits per robot-step, on average.", FiniteRange(0, 1e9, min_open=True)),
    message_bits: int | None = option("Most bits in a message.", click.IntRange(1, 2**31)),
    no_ids: bool = option("Ids of robots may be mistaken: robots draw them at random.", is_flag=True),
    no_names: bool = option("Tasks have no names: all look alike.", is_flag=True),
    liars: int = option("Number of Byzantine robots to bear.", FEW, 0, show_default=False),
    stopped: int = option("Number of robots that break down to bear.", FEW, 0, show_default=False),
    steps: int | None,
    strategies: tuple[str, ...] = strategies_option("the built-in ones and the scenario's own"),
    runs: int = option(
        "Largest number of runs of a strategy in a world; a test begins with 100.", count_type, 1000
    ),
    seed: int,
    budget: float | None,
    workforce: Workforce,
    out: Path | None = option(f"Folder of {JOURNAL} By default in the cache.", folder_type),
    as_json: bool,
) -> None:
    """Recommend strategies that meet the constraints of a deployment, and say why others don't.

    FILE is a scenario in TOML; without one, the paper's defaults. Each strategy is tested in this world, with
    the faulty robots that it must bear, and with the number of tasks at which the truth is the opposite. What
    it needs is declared in its file; what it bears is measured.

    \b
    Examples:
      feasibee recommend mine.toml
      feasibee recommend mine.toml --liars 1 --message-bits 64 --steps 500
      feasibee recommend mine.toml --no-names --strategies dmmd,dc,mine.py
    """
    from feasibee.studies.recommend import Constraints
    from feasibee.studies.recommend import recommend as test_all
    from feasibee.sweeps.kept import kept_folder

    scenario = given.read({"run.steps": steps})
    constraints = Constraints(right, bits, message_bits, not no_ids, not no_names, liars, stopped)
    Runs(runs, seed)  # raises before the tests
    folder = out or kept_folder(scenario, seed)
    with executing("Testing strategies", folder, workforce, budget=budget, answers=True) as execution:
        found = test_all(scenario, constraints, strategies, runs, seed, execution)
    if as_json:
        print_json(found.to_dict())
    else:
        _print_recommendation(found)
    leave_if_stopped(found.stopped)


def _print_recommendation(found: Recommendation) -> None:
    from feasibee.studies.recommend import described

    if found.ranking:
        click.echo(f"Right in at least {100 * found.constraints.right:g} % of the swarms, the best first:")
    else:
        click.echo("No strategy is shown to meet all constraints.")
        for line in found.probably:
            click.echo(wrapped(line))
    for place, each in enumerate(found.ranking, start=1):
        best = found.best[each.strategy]
        title = f"{place}. {each.strategy}" + (f" ({', '.join(best)})" if best else "")
        click.echo(_entry(title, described(each)))
    for relaxed in found.relax:
        title = f"{relaxed.in_words}: {relaxed.candidate.strategy}"
        click.echo(_entry(title, described(relaxed.candidate)))
    if found.stopped:
        click.echo(f"The tests ended early ({found.stopped}). More time would complete them.")
    if found.excluded:
        click.echo("Excluded:")
    for name, reason in found.excluded.items():
        click.echo(wrapped(f"{name}: {reason}", "  ", "    "))


def _entry(title: str, text: str) -> str:
    return f"  {title}\n" + wrapped(text, "     ", "     ")
