"""The command line: parse, call, print. Heavy libraries load inside the commands."""

from __future__ import annotations

import json
import os
import sys
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from feasibee.errors import FeasibeeError

if TYPE_CHECKING:
    from feasibee.claims import Claim
    from feasibee.feasibility import Verdict
    from feasibee.record import Record
    from feasibee.scenario import Scenario

INTERRUPTED = 130


class Commands(click.Group):
    """The commands, with feasibee's errors as lines and exit status 2."""

    def invoke(self, context: click.Context) -> Any:
        """Run a command."""
        try:
            return super().invoke(context)
        except FeasibeeError as error:
            _fail(str(error))
        except click.UsageError as error:
            path = error.ctx.command_path if error.ctx else context.command_path
            _fail(f"{error.format_message()} See '{path} --help'.")
        except MemoryError:
            _fail("not enough memory; ask for fewer runs, steps or robots")
        except KeyboardInterrupt:
            click.echo("feasibee: interrupted; no file was left half-written", err=True)
            sys.exit(INTERRUPTED)


def _fail(message: str) -> NoReturn:
    for line in message.splitlines():
        click.echo(f"feasibee: {line}", err=True)
    sys.exit(2)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(version("feasibee"), message="%(prog)s %(version)s")
def main() -> None:
    """Can this swarm do these tasks? Simulate how the swarm itself finds out.

    \b
    Examples:
      feasibee paper                              the paper's figures and claims, in paper/
      feasibee run --set tasks.count=50           one scenario, 100 runs
      feasibee scenario > mine.toml               a file to edit
    """


def _scenario_options(command: Callable[..., None]) -> Callable[..., None]:
    file = click.argument("file", required=False, type=click.Path(dir_okay=False, path_type=Path))
    changes = click.option(
        "--set",
        "changes",
        multiple=True,
        metavar="FIELD=VALUE",
        help="Change a field, such as tasks.count=50.",
    )
    return file(changes(command))


_seed = click.option(
    "--seed", type=int, default=0, show_default=True, help="64 bits; the same seed, the same runs."
)
_threads = click.option(
    "--threads", type=click.IntRange(1, 1024), help="Runs at a time; by default one for each processor."
)
_json = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")


@main.command()
@_scenario_options
@click.option("--runs", type=click.IntRange(1), default=100, show_default=True, help="How many swarms.")
@_seed
@click.option(
    "--first-run", type=click.IntRange(0), default=0, show_default=True, help="Number of the first run."
)
@click.option("--steps", type=int, help="Steps a run: short for --set run.steps=...")
@_threads
@click.option("--save", type=click.Path(path_type=Path), metavar="FILE.nc", help="Save all runs as NetCDF.")
@click.option(
    "--plot", type=click.Path(path_type=Path), metavar="FILE.png", help="Draw opinions and decision steps."
)
@_json
def run(
    file: Path | None,
    changes: tuple[str, ...],
    runs: int,
    seed: int,
    first_run: int,
    steps: int | None,
    threads: int | None,
    save: Path | None,
    plot: Path | None,
    as_json: bool,
) -> None:
    """Simulate one scenario many times and say what the swarms decided.

    FILE is a scenario in TOML; without one, the paper's defaults.

    \b
    Examples:
      feasibee run --set tasks.count=50 --runs 1000 --seed 1
      feasibee run mine.toml --plot mine.png --save mine.nc
    """
    from feasibee.simulation import simulate_record

    more = () if steps is None else (f"run.steps={steps}",)
    scenario = _read_scenario(file, (*changes, *more))
    _check_outputs(save, plot)
    with _progress("Simulating") as progress:
        record = simulate_record(
            scenario,
            runs,
            seed,
            first_run=first_run,
            curves=bool(save or plot),
            threads=threads,
            progress=progress,
        )
    if save or plot:
        _keep_matplotlib_in_cache()
        _write_results(record, scenario, seed, save, plot)
    summary = _summary(record, scenario, seed)
    if as_json:
        click.echo(json.dumps(summary, indent=2))
    else:
        _print_summary(summary, scenario)


@main.command()
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("paper"),
    show_default=True,
    help="Folder for figures, data and claims.",
)
@click.option("--runs", type=click.IntRange(4), default=100, show_default=True, help="Swarms at each ratio.")
@_seed
@_threads
@click.option("--beyond", is_flag=True, help="Instead, draw Fig. 3 again in seven worlds unlike the paper's.")
def paper(out: Path, runs: int, seed: int, threads: int | None, beyond: bool) -> None:
    """Reproduce the paper: its three figures, the data behind them, its claims checked.

    \b
    Examples:
      feasibee paper
      feasibee paper --runs 2000 --out paper-2000
      feasibee paper --beyond --runs 400
    """
    _keep_matplotlib_in_cache()
    if beyond:
        from feasibee.beyond import reproduce_beyond, summary

        with _progress("Simulating beyond the paper") as progress:
            rows = reproduce_beyond(out, runs, seed, threads, progress)
        _print_beyond(summary(rows), runs)
        click.echo(f"beyond.png, beyond.pdf and their data, beyond.csv, are in {out}/")
        return
    from feasibee.paper import reproduce

    with _progress("Simulating the paper's study") as progress:
        claims = reproduce(out, runs, seed, threads, progress)
    _print_claims(claims, runs)
    click.echo(f"Figures (PNG, PDF), their data (CSV) and claims.json are in {out}/")


@main.command()
@_scenario_options
@_json
def truth(file: Path | None, changes: tuple[str, ...], as_json: bool) -> None:
    """Say exactly whether the tasks are feasible, and why.

    If so, which robots do what; if not, for which skills there are too few. A robot serves one place at most.

    \b
    Examples:
      feasibee truth mine.toml
      feasibee truth --set robots.count=20 --set tasks.count=21 --json
    """
    from feasibee.feasibility import explain

    scenario = _read_scenario(file, changes)
    verdict = explain(scenario)
    if as_json:
        click.echo(json.dumps(verdict.to_dict(), indent=2))
    else:
        _print_verdict(verdict, scenario)


@main.command()
@_scenario_options
def scenario(file: Path | None, changes: tuple[str, ...]) -> None:
    """Print a scenario in full, as TOML.

    \b
    Example:
      feasibee scenario --set robots.count=40 > forty.toml
    """
    click.echo(_read_scenario(file, changes).to_toml(), nl=False)


@main.command()
def schema() -> None:
    """Print the JSON Schema of scenarios, for editors and other tools.

    \b
    Example:
      feasibee schema > scenario.schema.json
    """
    from feasibee.scenario import Scenario

    click.echo(json.dumps(Scenario.model_json_schema(), indent=2))


def _keep_matplotlib_in_cache() -> None:
    """Let matplotlib keep its list of fonts in our folder; it would make one in the user's home."""
    from feasibee.files import cache_root

    os.environ.setdefault("MPLCONFIGDIR", str(cache_root() / "matplotlib"))


def _read_scenario(file: Path | None, changes: tuple[str, ...]) -> Scenario:
    from feasibee.scenario import Scenario

    base = Scenario() if file is None else Scenario.read(file)
    return base.replace(dict(_parse_change(change) for change in changes))


def _parse_change(change: str) -> tuple[str, Any]:
    """Read FIELD=VALUE, the value being TOML or else plain text."""
    path, equals, text = change.partition("=")
    if not equals:
        raise FeasibeeError(f"--set {change}: must be FIELD=VALUE; such as --set tasks.count=50")
    try:
        return path.strip(), tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return path.strip(), text.strip()


def _check_outputs(save: Path | None, plot: Path | None) -> None:
    """Find out before a long computation that its outcome couldn't be written."""
    from feasibee.files import check_writable

    if plot is not None and plot.suffix.lower() not in (".png", ".pdf", ".svg"):
        raise FeasibeeError(f"--plot {plot}: unknown kind of figure; end it with .png, .pdf or .svg")
    if save is not None and plot is not None and save.resolve() == plot.resolve():
        raise FeasibeeError(f"--save and --plot {plot}: can't be the same file; name two")
    for path in (save, plot):
        if path is not None:
            check_writable(path)


def _write_results(
    record: Record, scenario: Scenario, seed: int, save: Path | None, plot: Path | None
) -> None:
    from feasibee.results import label, save_results

    dataset = label(record, scenario, seed)
    if save is not None:
        save_results(dataset, save)
    if plot is not None:
        from feasibee.plots import figure, plot_decision_steps, plot_opinions, save_figure

        with figure(7.2, 2.8, columns=2) as (drawn, (left, right)):
            plot_opinions(dataset, left)
            plot_decision_steps(dataset, right)
            left.set_title("Median and quartiles over the runs")
            right.set_title("Collective decisions")
        save_figure(drawn, plot)


def _summary(record: Record, scenario: Scenario, seed: int) -> dict[str, Any]:
    from feasibee.feasibility import truth
    from feasibee.stats import accuracy, decision_counts, decision_rates, decision_times
    from feasibee.vocabulary import MODEL_VERSION

    times = decision_times(record.decision_step)
    feasible = truth(scenario)
    return {
        "runs": record.runs,
        **decision_counts(record.decision),
        "decision_step": {"median": times.median, "q25": times.q25, "q75": times.q75},
        "truth": "feasible" if feasible else "infeasible",
        "accuracy": accuracy(record.decision, feasible)._asdict(),
        "seed": seed,
        "first_run": record.first_run,
        "scenario": scenario.to_dict(),
        "scenario_hash": scenario.hash,
        "version": version("feasibee"),
        "model_version": MODEL_VERSION,
        "rates": {name: rate._asdict() for name, rate in decision_rates(record.decision).items()},
    }


def _print_summary(summary: dict[str, Any], scenario: Scenario) -> None:
    from rich.console import Console
    from rich.table import Table

    robots, tasks = scenario.robots.count, scenario.tasks.count
    table = Table(
        title=f"{robots} robots, {tasks} tasks, {scenario.decision.strategy}: {summary['runs']} runs"
    )
    table.add_column("decision")
    for column in ("runs", "share", "95 % interval"):
        table.add_column(column, justify="right")
    counts = {**summary, "accuracy": summary[summary["truth"]]}
    for name, rate in (*summary["rates"].items(), ("accuracy", summary["accuracy"])):
        right = " (true)" if name == summary["truth"] else ""
        interval = f"{rate['low']:.1%} to {rate['high']:.1%}"
        share = f"{rate['estimate']:.1%}"
        table.add_row(name + right, str(counts[name]), share, interval, end_section=name == "undecided")
    console = Console()
    console.print(table)
    times = summary["decision_step"]
    shown = {key: "not reached" if step is None else f"step {step}" for key, step in times.items()}
    console.print(
        f"Decided: a quarter of the runs by {shown['q25']}, half by {shown['median']}, "
        f"three quarters by {shown['q75']} (of {scenario.run.steps}).",
        highlight=False,
        soft_wrap=True,
    )
    console.print(f"Seed {summary['seed']}, scenario {summary['scenario_hash'][:12]}.", highlight=False)


def _print_verdict(verdict: Verdict, scenario: Scenario) -> None:
    from rich.console import Console
    from rich.table import Table

    if verdict.violator is not None:
        skills, demand, robots = verdict.violator
        named = " or ".join(skills)
        asking, able = f"places that ask for {named}", f"robots that can {named}"
        if not scenario.tasks.classes:
            asking, able = "tasks, each for any one robot", "robots"
        click.echo(f"Infeasible: {asking}: {demand}; {able}: {robots}.")
        return
    free = scenario.robots.count - sum(verdict.assignment.values())
    click.echo(f"Feasible: each place has a robot of its own; robots left over: {free}.")
    table = Table("robots", "tasks", "skill")
    table.add_column("count", justify="right")
    for names, count in verdict.assignment.items():
        table.add_row(*names, str(count))
    if verdict.assignment:
        Console(markup=False, emoji=False).print(table)


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


def _print_beyond(lines: list[list[str]], runs: int) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(*lines[0], title=f"Share of right decisions, by ratio, from {runs} runs each")
    for line in lines[1:]:
        table.add_row(*line)
    Console(highlight=False).print(table)


@contextmanager
def _progress(what: str) -> Iterator[Callable[[float], None]]:
    """Show a bar on a terminal, and nothing elsewhere; standard output stays clean."""
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)
