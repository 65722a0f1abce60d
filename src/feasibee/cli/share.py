"""feasibee page, lesson and animate: swarms as an HTML file that simulates, or as pictures that move."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Any, Final

import click
from click.core import ParameterSource

from feasibee.cli.options import (
    Given,
    command,
    complete_strategy,
    count_type,
    folder_type,
    named,
    option,
    path_type,
    progress,
    with_flooding,
)
from feasibee.errors import FeasibeeError

FIELDS: Final = {"file": "FILE", "changes": "--set", "seed": "--seed", "run": "--run"}
"""Parameters that say which run of which scenario, as a field's log does."""


@command()
def page(
    *,
    given: Given,
    strategy: str | None = option(
        "Short for --set decision.strategy=...", callback=named, shell_complete=complete_strategy
    ),
    seed: int,
    run: int,
    out: Path = option("HTML file to write; about 250 KB.", path_type, "run.html"),
    opens: bool = option("Open the file in the browser.", name="--open", is_flag=True),
) -> None:
    """Write one HTML file that simulates swarms, without server or network.

    FILE is a scenario in TOML; without one, the paper's defaults. The page begins with its values, and has
    sliders for robots, tasks, strategy, seed and run. Its opinions are those of `feasibee run` at every step.
    It has all strategies and worlds, with up to 20,000 robots and tasks. Your own strategy is compiled, which
    needs the extra 'c'.

    \b
    Examples:
      feasibee page --set tasks.count=50 --seed 1 --out fifty.html
      feasibee page mine.toml --open
      feasibee page --strategy mine.py
    """
    from feasibee.files import check_output
    from feasibee.live.page import write_page

    check_output(out, (".html",), "--out")
    scenario = given.read({"decision.strategy": strategy})
    write_page(scenario, out, seed, run, name=given.file.name if given.file else "")
    _wrote(out, opens)


@command()
def lesson(
    *,
    out: Path = option("HTML file to write; about 210 KB.", path_type, "lesson.html"),
    opens: bool = option("Open the file in the browser.", name="--open", is_flag=True),
) -> None:
    """Write a lesson as one HTML file: predict what swarms decide, then watch them.

    Its questions lead from twenty robots among fifty tasks to names, lies, rooms, and robots that ask first
    or start. The page simulates its swarms without server or network.

    \b
    Example:
      feasibee lesson --open
    """
    from feasibee.files import check_output
    from feasibee.live.lesson import write_lesson

    check_output(out, (".html",), "--out")
    write_lesson(out)
    _wrote(out, opens)


def _wrote(out: Path, opens: bool) -> None:
    click.echo(f"Wrote {out}")
    if opens:
        webbrowser.open(out.resolve().as_uri())


@command()
def animate(
    *,
    given: Given,
    seed: int,
    run: int,
    field: Path | None = option(
        "Show the field whose logs feasibee launch --out has written to a folder.",
        folder_type,
        metavar="FOLDER",
    ),
    frames: str | None = option(
        "Steps to show; by default to 30 or more after the decision, or all if the world changes.",
        metavar="[FIRST:]LAST",
    ),
    every: int = option("Steps per frame.", count_type, 1),
    fps: int = option(
        "Frames per second; for a GIF 1, 2, 4, 5, 10, 20, 25 or 50.", click.IntRange(1, 120), 20
    ),
    size: int = option("Width in pixels.", click.IntRange(240, 4096), 480),
    dark: bool = option("Use a dark background.", is_flag=True),
    out: Path = option(
        "File to write: .gif, .webp, .mp4 (needs the extra 'video'), or .png for the last frame.",
        path_type,
        "run.gif",
    ),
) -> None:
    """Draw one run step by step: robots, their opinions, and tasks.

    FILE is a scenario in TOML; without one, the paper's defaults. The run is that of `feasibee run` with the
    same seed and number.

    \b
    Examples:
      feasibee animate --set tasks.count=50 --seed 1 --out fifty.gif
      feasibee animate mine.toml --run 417 --frames 200:300 --fps 10 --out wrong.mp4
      feasibee animate mine.toml --run 417 --frames 38 --out step38.png
      feasibee animate --field logs --out field.gif
    """
    from feasibee.figures.animation import animate as write_animation
    from feasibee.figures.animation import animate_field

    if field is not None:
        _check_unused()
    scenario = with_flooding(given.read())
    look: dict[str, Any] = {"every": every, "fps": fps, "size": size, "dark": dark}
    with progress("Drawing") as advance:
        look |= {"steps": _steps(frames), "progress": advance}
        if field is not None:
            animate_field(field, out, **look)
        else:
            write_animation(scenario, out, seed, run, **look)
    click.echo(f"Wrote {out}")


def _check_unused() -> None:
    """Raise an error if parameters are given that say which run to draw: a field's log has them."""
    source = click.get_current_context().get_parameter_source
    given = [shown for name, shown in FIELDS.items() if source(name) not in (ParameterSource.DEFAULT, None)]
    if given:
        named = " and ".join(given)
        raise FeasibeeError(f"--field with {named}: the log has scenario, seed and run; leave out {named}")


def _steps(text: str | None) -> tuple[int, int] | None:
    """Parse LAST, or FIRST:LAST."""
    if text is None:
        return None
    first, _, last = text.rpartition(":")
    try:
        return int(first or 0), int(last)
    except ValueError:
        raise FeasibeeError(
            f"--frames {text}: must be a step, or two; such as --frames 100 or --frames 50:100"
        ) from None
