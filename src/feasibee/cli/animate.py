"""feasibee animate: one run as an animation."""

from __future__ import annotations

from pathlib import Path

import click

from feasibee.cli.options import path_type, progress, read_scenario, scenario_options, seed_option
from feasibee.errors import FeasibeeError


@click.command()
@scenario_options
@seed_option
@click.option("--run", type=click.IntRange(0), default=0, show_default=True, help="Number of the run.")
@click.option(
    "--steps",
    metavar="[FIRST:]LAST",
    help="Steps to show; by default to 30 or more after the decision, or all if the world changes.",
)
@click.option("--every", type=click.IntRange(1), default=1, show_default=True, help="Steps per frame.")
@click.option(
    "--fps",
    type=click.IntRange(1, 120),
    default=20,
    show_default=True,
    help="Frames per second; for a GIF 1, 2, 4, 5, 10, 20, 25 or 50.",
)
@click.option(
    "--size", type=click.IntRange(240, 4096), default=480, show_default=True, help="Width in pixels."
)
@click.option("--dark", is_flag=True, help="Use a dark background.")
@click.option(
    "--out",
    type=path_type,
    default="run.gif",
    show_default=True,
    help="File to write: .gif, .webp, .mp4 (needs the extra 'video'), or .png for the last frame.",
)
def animate(
    file: Path | None,
    changes: tuple[str, ...],
    seed: int,
    run: int,
    steps: str | None,
    every: int,
    fps: int,
    size: int,
    dark: bool,
    out: Path,
) -> None:
    """Draw one run step by step: robots, their opinions, and tasks.

    FILE is a scenario in TOML; without one, the paper's defaults. The run is that of `feasibee run` with the
    same seed and number.

    \b
    Examples:
      feasibee animate --set tasks.count=50 --seed 1 --out fifty.gif
      feasibee animate mine.toml --run 417 --steps 200:300 --fps 10 --out wrong.mp4
      feasibee animate mine.toml --run 417 --steps 38 --out step38.png
    """
    from feasibee.figures.animation import animate as write_animation

    scenario = read_scenario(file, changes)
    with progress("Drawing") as advance:
        write_animation(
            scenario,
            out,
            seed,
            run,
            steps=_span(steps),
            every=every,
            fps=fps,
            size=size,
            dark=dark,
            progress=advance,
        )
    click.echo(f"Wrote {out}")


def _span(text: str | None) -> tuple[int, int] | None:
    """Parse LAST, or FIRST:LAST."""
    if text is None:
        return None
    first, _, last = text.rpartition(":")
    try:
        return int(first or 0), int(last)
    except ValueError:
        raise FeasibeeError(
            f"--steps {text}: must be a step, or two; such as --steps 100 or --steps 50:100"
        ) from None
