"""feasibee run and reproduce: simulate one scenario many times, and saved results again."""

from __future__ import annotations

import sys
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from feasibee.cli.options import (
    Given,
    NamedPath,
    argument,
    command,
    console,
    count_type,
    flooding_lines,
    option,
    outputs_option,
    path_type,
    print_json,
    progress,
    with_flooding,
)
from feasibee.files import FIGURES, RESULTS
from feasibee.scenario.runs import Runs

if TYPE_CHECKING:
    from feasibee.model.record import Record
    from feasibee.scenario.scenario import Scenario


@command()
def run(
    *,
    given: Given,
    runs: int = option("Number of runs.", count_type, 100),
    seed: int,
    run: int,
    steps: int | None,
    workers: int | None,
    outputs: dict[str, Path] = outputs_option(
        "File to write, repeatable. All runs: .nc is NetCDF, with opinions over time and the scenario; .csv "
        "has one row per run. A figure (.png, .pdf, .svg): opinions over time, steps of decisions and of "
        "declarations; truth, if it changes.",
        runs=RESULTS,
        figure=FIGURES,
    ),
    as_json: bool,
) -> None:
    """Simulate one scenario many times, and print how often the swarms decided feasible or infeasible.

    FILE is a scenario in TOML; without it, the paper's swarm of 20 robots and 20 tasks.

    \b
    Examples:
      feasibee run --set tasks.count=50 --runs 1000 --seed 1
      feasibee run mine.toml --out mine.png --out mine.nc
      feasibee run mine.toml --runs 1000 --out mine.csv
    """
    from feasibee.simulation.ensemble import simulate_record

    wanted = Runs(runs, seed, run)
    scenario = with_flooding(given.read({"run.steps": steps}))
    curves = "figure" in outputs or ("runs" in outputs and outputs["runs"].suffix.lower() == ".nc")
    with progress("Simulating") as advance:
        record = simulate_record(scenario, wanted, curves=curves, threads=workers, progress=advance)
    if outputs:
        _write_results(record, scenario, seed, outputs)
    summary = _summary(record, scenario, seed)
    if as_json:
        print_json(summary)
    else:
        _print_summary(summary, scenario)


def _write_results(record: Record, scenario: Scenario, seed: int, outputs: dict[str, Path]) -> None:
    from feasibee.results.dataset import save_results, to_dataset

    dataset = to_dataset(record, scenario, seed)
    if "runs" in outputs:
        save_results(dataset, outputs["runs"])
    if "figure" in outputs:
        from feasibee.figures.decisions import draw_runs
        from feasibee.figures.style import save_figure

        save_figure(draw_runs(dataset), outputs["figure"])


def _summary(record: Record, scenario: Scenario, seed: int) -> dict[str, Any]:
    from feasibee.model.codes import DECISIONS, MODEL_VERSION
    from feasibee.results.measures import measured, together, tracked
    from feasibee.results.statistics import plain
    from feasibee.scenario.feasibility import truth
    from feasibee.simulation.flooding import within

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


def _print_summary(summary: dict[str, Any], scenario: Scenario) -> None:
    from rich.table import Table

    from feasibee.scenario.units import when_in_words

    robots = _counted(scenario.robots.count, "robot")
    tasks, runs = _counted(scenario.tasks.count, "task"), _counted(summary["runs"], "run")
    table = Table(title=f"{robots}, {tasks}, {scenario.decision.strategy}: {runs}")
    table.add_column("decision")
    for column in ("runs", "share", "95 % interval"):
        table.add_column(column, justify="right")
    for name, rate in (*summary["rates"].items(), ("accuracy", summary["accuracy"])):
        right = " (true)" if name == summary["truth"] and not scenario.dynamic else ""
        runs_of_it = str(round(rate["estimate"] * summary["runs"]))
        interval = f"{rate['low']:.1%} to {rate['high']:.1%}"
        share = f"{rate['estimate']:.1%}"
        table.add_row(name + right, runs_of_it, share, interval, end_section=name == "undecided")
    out = console(highlight=True)
    out.print(table)
    times = summary["decision_step"]
    shown = {key: when_in_words(scenario, step) for key, step in times.items()}
    lines = [
        f"Decided: a quarter of the runs {shown['q25']}, half {shown['median']}, "
        f"three quarters {shown['q75']} (of {scenario.run.steps}).",
        f"Right at the end: {_share(summary['right_at_end'])}.",
        *(_tracking_in_words(summary, scenario) if "right_share" in summary else ()),
        f"Sent: {summary['bits_per_robot_and_step']:.3g} bits per robot-step.",
        *flooding_lines(scenario),
        *([_declarations_in_words(summary["declared"], scenario)] if "declared" in summary else ()),
        *(_acting_in_words(summary["acting"], scenario) if "acting" in summary else ()),
        f"Seed {summary['seed']}, scenario {summary['scenario_hash'][:12]}.",
    ]
    for line in lines:
        out.print(line, highlight=False, soft_wrap=True)


def _tracking_in_words(summary: dict[str, Any], scenario: Scenario) -> list[str]:
    """Return when the truth changed, and how the swarms tracked it."""
    from feasibee.scenario.units import steps_in_words

    alarms, delay, missed = (summary[name] for name in ("false_alarms", "detection_delay", "missed"))
    stretches = summary["truth_intervals"]
    known = (f"{each['truth']} in steps {each['first']} to {each['last']}" for each in stretches or ())
    lines = [
        f"Truth: {', '.join(known)}." if stretches else "The truth changes at other steps in each run.",
        f"Right: in {_share(summary['right_share'])} of the steps, {alarms['estimate']:.3g} "
        f"({alarms['low']:.3g} to {alarms['high']:.3g}) false alarms per 1,000 steps.",
    ]
    if missed is None:
        return [*lines, "Changes: none just before which a swarm was right."]
    followed = "fewer than a quarter"
    if delay["q25"] is not None:
        steps = (delay[name] for name in ("q25", "median", "q75"))
        shown = ("never" if step is None else f"within {steps_in_words(scenario, step)}" for step in steps)
        followed = "a quarter {}, half {}, three quarters {}".format(*shown)
    return [*lines, f"Changes: {delay['changes']:,}. Followed: {followed}. Missed: {_share(missed)}."]


def _declarations_in_words(declared: dict[str, Any], scenario: Scenario) -> str:
    from feasibee.scenario.units import when_in_words

    steps = declared["step_90"]
    half, most = (when_in_words(scenario, steps[name]) for name in ("median", "p95"))
    return (
        f"Declared: {declared['feasible']:.1%} of the robots feasible, "
        f"{declared['infeasible']:.1%} infeasible; rightly in {_share(declared['ok'])}, "
        f"a robot wrongly in {_share(declared['wrong'])}; half of the swarms {half}, 95% {most}."
    )


def _acting_in_words(acting: dict[str, Any], scenario: Scenario) -> list[str]:
    """Return whether and when all tasks were taken, and at what cost."""
    from feasibee.scenario.units import length_in_words, when_in_words

    is_work = acting["all_done_step"] is not None
    steps, word = acting["all_done_step" if is_work else "all_taken_step"], "done" if is_work else "taken"
    half, most = (when_in_words(scenario, steps[name]) for name in ("median", "p95"))
    names = ("tasks_taken", "distance", "vain_arrivals")
    taken, distance, vain = (f"{acting[name]['estimate']:.3g}" for name in names)
    walked = length_in_words(scenario, float(distance))
    return [
        f"Done: all tasks taken in {_share(acting['done'])}; {word} in half of the swarms {half}, "
        f"95% {most}. "
        f"Started in vain: {_share(acting['started_in_vain'])}.",
        f"Per run: {taken} tasks taken, {walked} walked per robot, {vain} arrivals in vain.",
    ]


def _share(rate: dict[str, float]) -> str:
    """Return a share of the runs with its interval, in percent."""
    return f"{rate['estimate']:.1%} ({rate['low']:.1%} to {rate['high']:.1%})"


def _counted(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


@command()
def reproduce(
    *,
    path: Path = argument(path_type, metavar="FILE|FOLDER"),
    figure: tuple[Path, ...] = option(
        "Figure to draw again, repeatable; by default those named as FILE, such as mine.png, or in FOLDER.",
        NamedPath(exists=True, dir_okay=False, path_type=Path),
        multiple=True,
        metavar="FILE",
    ),
    trust: bool = option("Run a strategy from the text in the results; read it before.", is_flag=True),
    workers: int | None,
    as_json: bool,
) -> None:
    """Simulate saved results again, and compare every byte of all runs and figures with what was saved.

    FILE is one that feasibee run --out has written, .nc, or a card of feasibee benchmark, .json. FOLDER is
    that of a journal, as of feasibee sweep; its figures are those of feasibee results plot, whose files say
    what they show.
    The exit status is 0 if all bytes are the same, 1 if some differ, and 2 after an error.

    \b
    Examples:
      feasibee reproduce mine.nc
      feasibee reproduce mine.nc --figure paper/mine.pdf
      feasibee reproduce results --figure paper/ratio.pdf
      feasibee reproduce benchmark.json --trust
    """
    from feasibee.studies.reproduce import reproduce_card, reproduce_file, reproduce_journal

    kinds = {".json": reproduce_card}
    again = reproduce_journal if path.is_dir() else kinds.get(path.suffix.lower(), reproduce_file)
    with progress("Simulating again") as advance:
        found = again(path, figure, trust, workers, advance)
    if as_json:
        print_json(found._asdict())
    else:
        changed = [
            f"{name} {now} (was {then})" for name, (then, now) in found.versions.items() if now != then
        ]
        for line in (
            f"{path}: {found.runs:,} runs, written by feasibee {found.versions['feasibee'][0]}; now: "
            f"{', '.join(changed) or 'the same versions'}.",
            *(f"Different: {each}." for each in found.differences or ()),
            *([] if found.differences else ["All results are the same, byte for byte."]),
            *(
                f"{each}: {'the same, byte for byte' if same else 'differs'}."
                for each, same in found.figures.items()
            ),
        ):
            click.echo(line)
    if found.differences or not all(found.figures.values()):
        sys.exit(1)
