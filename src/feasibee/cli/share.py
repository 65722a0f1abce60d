"""feasibee page and animate: swarms as one HTML file that simulates, or as pictures that move."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Any

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
)
from feasibee.errors import FeasibeeError


@command()
def page(
    *,
    given: Given,
    strategy: str | None = option(
        "Short for --set decision.strategy=...", callback=named, shell_complete=complete_strategy
    ),
    seed: int,
    run: int,
    out: Path = option("HTML file to write; about 200 KB.", path_type, "run.html"),
    opens: bool = option("Open the file in the browser.", name="--open", is_flag=True),
) -> None:
    """Write one HTML file that simulates swarms, without server or network.

    FILE is a scenario in TOML; without one, the paper's defaults. The page begins with its values, and has
    sliders for robots, tasks, strategy, seed and run. Its opinions are those of `feasibee run` at every step.
    It has all strategies, on a torus or within walls, with up to 200 robots and 400 tasks. Your own strategy
    is compiled, which needs the extra 'c'.

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
        _check_field()
    scenario = given.read()
    look: dict[str, Any] = {"every": every, "fps": fps, "size": size, "dark": dark}
    with progress("Drawing") as advance:
        look |= {"steps": _steps(frames), "progress": advance}
        if field is not None:
            animate_field(field, out, **look)
        else:
            write_animation(scenario, out, seed, run, **look)
    click.echo(f"Wrote {out}")


def _check_field() -> None:
    """Raise an error if options say what a field's log says."""
    context = click.get_current_context()
    names = {"file": "FILE", "changes": "--set", "seed": "--seed", "run": "--run"}
    given = [
        shown
        for name, shown in names.items()
        if context.get_parameter_source(name) not in (ParameterSource.DEFAULT, None)
    ]
    if given:
        rule = "the log has scenario, seed and run"
        raise FeasibeeError(f"--field with {' and '.join(given)}: {rule}; leave out {' and '.join(given)}")


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
