"""Animations: one run, step by step, as GIF, WebP or MP4, or its last frame as PNG.

Each frame is drawn when it is written. Only a GIF keeps its frames until the end, at a byte per pixel.

Examples
--------
>>> import feasibee
>>> from feasibee.figures.animation import animate
>>> animate(feasibee.Scenario(), "run.gif", seed=1)  # doctest: +SKIP
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path

from PIL import Image, ImageColor

from feasibee.base.codes import COLOURS, TASK, UNDECIDED
from feasibee.base.errors import FeasibeeError, how_to_install, quoted
from feasibee.base.files import atomic_write, check_output
from feasibee.scenario.picture import between
from feasibee.scenario.runs import Runs, check_integer
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.ensemble import check_progress, check_scenario, check_span, simulate_record
from feasibee.simulation.frames import DARK, LIGHT, Painter, Shown
from feasibee.simulation.swarm import Swarm

__all__ = ["animate", "animate_field", "draw_frame"]

SUFFIXES = (".gif", ".mp4", ".png", ".webp")
GIF_RATES = (1, 2, 4, 5, 10, 20, 25, 50)
"""Frames per second of a GIF, which counts in 0.01 s; browsers slow down more than 50."""
LAST = 2
"""Duration of the last frame, in seconds."""
FRAMES_LIMIT = 20_000
GIF_LIMIT = 4e9
"""Largest number of pixels in all frames of a GIF, which Pillow keeps at a byte each."""
AFTER_DECISION = 30
"""Least number of steps that are shown after the decision, or after all tasks are taken."""


def draw_frame(
    swarm: Swarm, *, size: int = 480, dark: bool = False, span: tuple[int, int] | None = None
) -> Image.Image:
    """Draw a swarm at its present step.

    Parameters
    ----------
    swarm : Swarm
        The swarm to draw.
    size : int
        Width of the picture in pixels.
    dark : bool
        Whether its background is dark.
    span : tuple of int, optional
        First and last step of the curve below the arena; by default there is no curve.

    Returns
    -------
    PIL.Image.Image
        An RGB picture; width and height are even numbers.

    Examples
    --------
    >>> import feasibee
    >>> from feasibee.figures.animation import draw_frame
    >>> draw_frame(feasibee.Swarm(), size=300).width
    300
    """
    if not isinstance(swarm, Swarm):
        raise FeasibeeError(f"swarm = {quoted(swarm)}: must be a Swarm; write Swarm(scenario, seed=1)")
    size = check_integer("size", size, 24, 8192)
    span = None if span is None else check_span("span", span)
    return Painter(swarm.scenario, size, dark, span).draw(swarm)


def animate(
    scenario: Scenario,
    path: str | Path,
    seed: int = 0,
    run: int = 0,
    *,
    steps: tuple[int, int] | None = None,
    every: int = 1,
    fps: int = 20,
    size: int = 480,
    dark: bool = False,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write one run as an animation; the same arguments give the same GIF, byte for byte.

    Parameters
    ----------
    scenario : Scenario
        The swarm's scenario.
    path : path
        Ends with ``.gif``, ``.webp``, ``.mp4`` (needs the extra 'video'), or ``.png`` for the last frame.
    seed, run : int
        Seed, and number of the run.
    steps : tuple of int, optional
        First and last step; by default from 0 to 30 steps or more after the decision, or if robots act, after
        they stand at all tasks that they can. In a world that changes it is to the end.
    every : int
        Number of steps per frame.
    fps : int
        Frames per second; for a GIF 1, 2, 4, 5, 10, 20, 25 or 50.
    size : int
        Width in pixels, 240 to 4096; an odd one is rounded up.
    dark : bool
        Whether the background is dark.
    progress : callable, optional
        Called with the share of the work done.

    Raises
    ------
    FeasibeeError
        If an argument is invalid, or the file can't be written.
    """
    path, scenario = Path(path), check_scenario(scenario)
    check_progress(progress)
    one = Runs.single(seed, run)
    _check(path, every, fps, size)
    start, end = _span(scenario, one, steps)
    shown = _shown(path, start, end, every, size)
    swarm = Swarm(scenario, one.seed, one.first)
    painter = Painter(scenario, size, dark, (start, shown[-1]))
    _write(path, _frames(swarm, lambda: painter.draw(swarm), shown, progress), len(shown), fps)


def animate_field(
    folder: str | Path,
    path: str | Path,
    *,
    steps: tuple[int, int] | None = None,
    every: int = 1,
    fps: int = 20,
    size: int = 480,
    dark: bool = False,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write what happened in a field as an animation, from the log of its world.

    Without faults, a field in lockstep gives the same frames as `animate` with its scenario, seed and run.
    Lost robots are grey. Lines below the counts name faults and lost robots.

    Parameters
    ----------
    folder : path
        The folder that ``feasibee robot launch --out`` has written.
    path : path
        The file to write, as in `animate`.
    steps : tuple of int, optional
        First and last step; by default from 0 to 30 steps or more after the decision, or to the log's end.
    every, fps, size, dark, progress
        As in `animate`.

    Raises
    ------
    FeasibeeError
        If an argument is invalid, the log is damaged, or the file can't be written.
    """
    from feasibee.base.files import named
    from feasibee.field.recording import Recording

    path = Path(path)
    check_progress(progress)
    _check(path, every, fps, size)
    field = Recording(Path(folder))
    if field.last < 0:
        raise FeasibeeError(f"{named(folder)}: has no step; run the field again, longer")
    field.step = field.last
    if steps is None:
        start, end = 0, field.last if field.scenario.dynamic else _after(*field.first_decision, field.last)
    else:
        start, end = check_span("steps", steps, field.last, "the log's last step")
    shown = _shown(path, start, end, every, size)
    notes = {step: field.notes_at(step) for step in shown}
    painter = Painter(field.scenario, size, dark, (start, shown[-1]), list(notes.values()))
    frames = _frames(field, lambda: painter.draw(field, notes[field.step], field.lost), shown, progress)
    _write(path, frames, len(shown), fps)


def _write(path: Path, frames: Iterator[Image.Image], count: int, fps: int) -> None:
    """Write frames in the format of the path's suffix."""
    write = {".gif": _write_gif, ".webp": _write_webp, ".mp4": _write_mp4, ".png": _write_png}
    with atomic_write(path) as temporary:
        write[path.suffix.lower()](temporary, frames, count, fps)


def _shown(path: Path, start: int, end: int, every: int, size: int) -> range:
    """Return the steps to draw; for a PNG only the last one."""
    shown = range(end, end + 1) if path.suffix.lower() == ".png" else range(start, end + 1, every)
    if len(shown) > FRAMES_LIMIT:
        least = -(-len(shown) * every // FRAMES_LIMIT)
        raise FeasibeeError(
            f"steps = {start}:{end}: {len(shown)} frames; must be at most {FRAMES_LIMIT}; "
            f"show fewer steps, or use every = {least}"
        )
    if path.suffix.lower() == ".gif" and len(shown) * size**2 > GIF_LIMIT:
        rule = f"a GIF of {len(shown)} frames of this size needs over {GIF_LIMIT / 1e9:.0f} GB of memory"
        raise FeasibeeError(f"size = {size}: {rule}; write .webp or .mp4, or use a smaller size")
    return shown


def _check(path: Path, every: int, fps: int, size: int) -> None:
    """Validate the arguments before the work."""
    suffix = check_output(path, SUFFIXES)
    check_integer("fps", fps, 1, 120)
    check_integer("size", size, 240, 4096)
    check_integer("every", every, 1, 10**9)
    if suffix == ".mp4":
        _ffmpeg(path)
    if suffix == ".gif" and fps not in GIF_RATES:
        known = ", ".join(map(str, GIF_RATES))
        rule = f"a GIF counts in hundredths of a second: must be one of {known}"
        raise FeasibeeError(f"fps = {fps}: {rule}; use one of these, or write .mp4 or .webp")


def _span(scenario: Scenario, run: Runs, steps: tuple[int, int] | None) -> tuple[int, int]:
    """Return the first and the last step to show."""
    last = scenario.run.steps
    if steps is not None:
        return check_span("steps", steps, last, "run.steps")
    if scenario.dynamic:
        return 0, last
    record = simulate_record(scenario, run)
    if scenario.acts:
        step = int(record.all_taken_step[0])
        return 0, last if step < 0 else min(last, step + AFTER_DECISION)
    return 0, _after(int(record.decision[0]), int(record.decision_step[0]), last)


def _after(decision: int, step: int, last: int) -> int:
    """Return the step until which a run is shown: a while after its decision."""
    return last if decision == UNDECIDED else min(last, step + max(AFTER_DECISION, step // 4))


def _frames(
    swarm: Shown,
    draw: Callable[[], Image.Image],
    shown: range,
    progress: Callable[[float], None] | None,
) -> Iterator[Image.Image]:
    """Go through the run and draw its frames, one at a time."""
    for step in shown:
        swarm.advance(step - swarm.step)
        yield draw()
        if progress is not None:
            progress((step + 1) / (shown[-1] + 1))


def _write_png(path: Path, frames: Iterator[Image.Image], count: int, fps: int) -> None:
    next(frames).save(path, optimize=True)


def _write_gif(path: Path, frames: Iterator[Image.Image], count: int, fps: int) -> None:
    pictures = _in_few_colours(frames)
    durations = [1000 // fps] * (count - 1) + [1000 * LAST]
    with path.open("wb") as file:
        next(pictures).save(
            file, "GIF", save_all=True, append_images=pictures, duration=durations, loop=0, optimize=True
        )


def _in_few_colours(frames: Iterator[Image.Image]) -> Iterator[Image.Image]:
    """Yield the frames in one palette, which makes files small."""
    palette = Image.new("P", (1, 1))
    for number, picture in enumerate(frames):
        if number == 0:
            palette.putpalette(_colours_of(picture))
        yield picture.quantize(palette=palette, dither=Image.Dither.NONE)


def _colours_of(picture: Image.Image) -> list[int]:
    """Return the palette of a picture's theme: all its colours, and those of soft edges between them."""
    theme = LIGHT if picture.getpixel((0, 0)) == ImageColor.getrgb(LIGHT.paper) else DARK
    pairs = [(theme.paper, each) for each in (theme.ink, theme.faint, TASK, *COLOURS.values())]
    pairs.append((theme.ink, TASK))
    mixed = dict.fromkeys(between(*pair, part / 3) for pair in pairs for part in range(4))
    return [value for colour in mixed for value in colour]


class _Reel(Image.Image):
    """Frames that are drawn when Pillow asks for them."""

    def __init__(self, frames: Iterator[Image.Image], count: int) -> None:
        super().__init__()
        self._frames, self.n_frames, self._at = frames, count, -1
        self.seek(0)

    def seek(self, frame: int) -> None:
        """Go on to a later frame; Pillow never goes back."""
        while self._at < frame:
            shown = next(self._frames)
            self.im, self._mode, self._size = shown.im, shown.mode, shown.size
            self._at += 1

    def tell(self) -> int:
        """Return the number of the present frame."""
        return self._at


def _write_webp(path: Path, frames: Iterator[Image.Image], count: int, fps: int) -> None:
    durations = [1000 / fps] * (count - 1) + [1000.0 * LAST]
    reel = _Reel((picture.convert("RGB") for picture in _in_few_colours(frames)), count)
    with path.open("wb") as file:  # a file that Pillow opens would stay open after an interrupt
        reel.save(
            file,
            "WEBP",
            save_all=True,
            duration=durations,
            loop=0,
            lossless=True,
            quality=50,
            method=3,
            kmin=0,  # only the first frame is complete: a tenth of the size
            kmax=0,
        )


def _write_mp4(path: Path, frames: Iterator[Image.Image], count: int, fps: int) -> None:
    """Write H.264 in a widely supported format, which needs even widths and heights."""
    first = next(frames)
    size = "{}x{}".format(*first.size)
    given = f"-f rawvideo -pix_fmt rgb24 -s {size} -r {fps} -i -".split()
    wanted = ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-movflags", "+faststart"]
    command = [_ffmpeg(path), "-y", "-v", "error", *given, *wanted, "-fflags", "+bitexact", f"file:{path}"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None
        try:
            for picture in chain([first], frames):
                pixels = picture.tobytes()
                process.stdin.write(pixels)
            for _ in range(LAST * fps - 1):
                process.stdin.write(pixels)
        except BrokenPipeError:
            pass  # its message is raised below
        except BaseException:
            process.kill()
            raise
        said = process.communicate()[1].decode(errors="replace")
    if process.returncode:
        raise OSError(said.strip().rpartition("\n")[2] or f"ffmpeg ended with {process.returncode}")


def _ffmpeg(path: Path) -> str:
    """Return the path of the program that writes MP4."""
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError) as error:
        raise FeasibeeError(
            f"{path}: MP4 can't be written here: {error}; write a .gif, or {how_to_install('video')}"
        ) from None
