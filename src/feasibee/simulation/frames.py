"""Frames: pictures of a swarm at one step, drawn at twice their size and reduced, also for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from feasibee.base.codes import COLOURS, DECISIONS, FEASIBLE, INFEASIBLE, NO_OPINION, TASK, UNDECIDED
from feasibee.scenario.picture import Deeds, between, encoded, images, paint_plan, segments
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.shown import render

Shown = Any
"""A ``Swarm``, or a ``Recording`` of a field: both have the names that a `Painter` needs."""
DRAWN = 2
"""Scale at which a frame is drawn before it is reduced."""
FINE = 6
"""Further scale at which the picture of a robot or task is drawn."""
LEAST_RADIUS = 1 / 530  # of the frame's width: smaller robots would be invisible
DETAILED_RADIUS = 3.0  # pixels: smaller robots show their colour only
RING = 1.4  # radii: outer edge of the ring of a robot that disseminates
RIM = 1.12  # radii: outer edge of the rim of a robot that has declared
NOSE = 1.65  # radii: end of the tick that shows a robot's heading
TASK_SIDE = 0.9  # of a robot's diameter
DASH = 5  # pixels: length of the dashes of the curve of infeasible
STANDS = 0.35  # radii: width of the line to the task at which a robot stands
MOST: Final = 20_000
"""Largest number of robots, or of tasks, that is drawn for a notebook."""
SIZE: Final = 720
"""Width of that picture in pixels, twice that at which a notebook shows it."""


class Theme(NamedTuple):
    """Colours of all but robots and tasks."""

    paper: str
    ink: str
    faint: str


LIGHT = Theme("#FFFFFF", "#1F2328", "#B4BAC2")
DARK = Theme("#14171C", "#E8EAED", "#565D67")


class Painter:
    """Draws the frames of one run; arena and tasks are drawn once, and again when tasks have changed.

    Size, background and span are those of ``draw_frame`` in `feasibee.figures.animation`. Lines for the notes
    of all frames are kept free below the counts.
    """

    def __init__(
        self,
        scenario: Scenario,
        size: int,
        dark: bool = False,
        span: tuple[int, int] | None = None,
        notes: Sequence[Sequence[str]] = (),
    ) -> None:
        self.scenario, self.span = scenario, span
        self.theme = DARK if dark else LIGHT
        width, height = scenario.arena.size
        whole = DRAWN * (size + size % 2)
        self.margin = max(4 * DRAWN, whole // 40)
        inner = whole - 2 * self.margin
        self.scale = inner / max(width, height)
        self.arena = (max(1, round(width * self.scale)), max(1, round(height * self.scale)))
        self.corner = ((whole - self.arena[0]) // 2, self.margin)
        self.radius = max(LEAST_RADIUS * whole, scenario.robots.diameter / 2 * self.scale)
        self.font = self._font(inner, {note for each in notes for note in each})
        self.line = round(1.55 * self.font.size)
        self.lines = 2 + (scenario.declares or scenario.dynamic) + scenario.acts
        lines = self.lines + max(map(len, notes), default=0)
        self.words = self.corner[1] + self.arena[1] + self.margin // 2
        below = self.words + lines * self.line + self.margin // 2
        label = int(self.font.getlength("100 % "))
        bottom = below + (whole // 7 + self.line if span else 0)
        self.strip = (self.margin + label, below + self.margin // 2, whole - self.margin, bottom - self.line)
        self.size = (whole, -(-bottom // (2 * DRAWN)) * 2 * DRAWN)
        self.drawn_tasks: tuple[list[int], list[int]] | None = None

    def draw(
        self, swarm: Shown, notes: Sequence[str] = (), lost: NDArray[np.bool_] | None = None
    ) -> Image.Image:
        """Draw the present step of a swarm of this scenario, with notes and with lost robots in grey."""
        drawn = self._arena(swarm, lost)
        pen = ImageDraw.Draw(drawn)
        self._words(drawn, pen, swarm, notes)
        if self.span is not None:
            self._curves(drawn, pen, swarm, *self.span)
        return drawn.reduce(DRAWN)

    def draw_arena(self, swarm: Shown) -> Image.Image:
        """Draw the arena of the present step, without the words below it."""
        return self._arena(swarm).crop((0, 0, self.size[0], self.words)).reduce(DRAWN)

    def _arena(self, swarm: Shown, lost: NDArray[np.bool_] | None = None) -> Image.Image:
        """Draw the arena with all that is in it, and leave what is below it empty."""
        drawn = Image.new("RGB", self.size, self.theme.paper)
        acting = swarm.acting if self.scenario.acts else None
        looks = [1] * len(swarm.task_numbers) if acting is None else acting.looks.tolist()
        if self.drawn_tasks != (drawn_tasks := (swarm.tasks.tolist(), looks)):
            self.ground, self.drawn_tasks = self._ground(swarm.tasks, looks), drawn_tasks
        arena = self.ground.copy()
        if acting is not None:
            self._aims(arena, swarm, acting)
        self._robots(arena, swarm, np.zeros(len(swarm.present), np.bool_) if lost is None else lost)
        drawn.paste(arena, self.corner)
        self._edge(ImageDraw.Draw(drawn))
        return drawn

    def _font(self, inner: int, notes: Iterable[str]) -> ImageFont.FreeTypeFont:
        """Return the largest font in which the longest lines fit."""
        robots = self.scenario.robots.count
        last = max(self.scenario.run.steps, 100)
        longest = (
            f"step {last}    decided infeasible at step {last}: wrong",
            f"MM {robots} feasible  MM {robots} infeasible   truth: infeasible",
            *notes,
        )
        fitting = ImageFont.load_default(100)
        widest = max(fitting.getlength(each) for each in longest)
        font = ImageFont.load_default(min(inner / 28, 100 * inner / widest))
        assert isinstance(font, ImageFont.FreeTypeFont)  # Pillow's wheels have FreeType
        return font

    def _ground(self, tasks: NDArray[np.float64], looks: list[int]) -> Image.Image:
        """Draw the arena with its place, and with tasks, which never move, each with its look."""
        ground = Image.new("RGB", self.arena, self.theme.paper)
        small = self.font.font_variant(size=0.8 * self.font.size)
        paint_plan(ground, self.scenario, small, self.theme.paper, self.theme.ink)
        half = max(1.2 * DRAWN, TASK_SIDE * self.radius)
        for x, y, task in self._images(tasks, half * 1.3):
            _press(ground, _task(round(8 * half) / 8, self.theme, looks[task]), x, y)
        return ground

    def _robots(self, arena: Image.Image, swarm: Shown, lost: NDArray[np.bool_]) -> None:
        """Paste the robots, with their copies beyond the edges of a torus."""
        there = swarm.present
        flags = (swarm.opinions, swarm.disseminating, swarm.counted, swarm.declared >= 0, lost)
        looks = list(zip(*(each[there].tolist() for each in flags), strict=True))
        reach = NOSE * self.radius if self.radius >= DETAILED_RADIUS * DRAWN else RING * self.radius
        spots = self._images(swarm.positions[there], reach)
        if self.radius >= DETAILED_RADIUS * DRAWN:
            walks = swarm.acting.aims[there] < 0 if self.scenario.acts else True
            self._noses(arena, spots, swarm.headings[there] * walks)
        radius = round(8 * self.radius) / 8
        for x, y, robot in spots:
            _press(arena, _robot(radius, self.theme, *looks[robot]), x, y)

    def _noses(
        self, arena: Image.Image, spots: Sequence[tuple[float, float, int]], headings: NDArray[np.float64]
    ) -> None:
        """Draw each robot's heading as a tick, to a 64th of a turn; none if it stands or has a target."""
        turns = np.round(headings / np.pi * 32) * np.pi / 32
        reach = NOSE * self.radius * (headings != 0)
        ahead = np.stack([reach * np.cos(turns), -reach * np.sin(turns)], axis=1).round().tolist()
        pen = ImageDraw.Draw(arena)
        thick = max(2, round(0.28 * self.radius))
        for far_x, far_y, robot in spots:
            x, y = (DRAWN * round(each / DRAWN) for each in (far_x, far_y))
            pen.line((x, y, x + ahead[robot][0], y + ahead[robot][1]), self.theme.ink, thick)

    def _aims(self, arena: Image.Image, swarm: Shown, acting: Deeds) -> None:
        """Draw a line from each robot to the task to which it walks, and a thick one if it stands there."""
        bound, walls = np.flatnonzero(acting.aims >= 0), self.scenario.arena.boundary == "walls"
        ends = swarm.positions[bound], swarm.tasks[acting.aims[bound]]
        lines, found = segments(*ends, self.scenario.arena.size, walls)
        lines = np.stack([lines[..., 0] * self.scale, arena.height - lines[..., 1] * self.scale], axis=-1)
        pen, thick = ImageDraw.Draw(arena), max(2 * DRAWN, round(STANDS * self.radius))
        for line, stands in zip(lines.tolist(), acting.standing[bound][found].tolist(), strict=True):
            pen.line([tuple(end) for end in line], self.theme.ink, thick if stands else DRAWN)

    def _images(self, places: NDArray[np.float64], reach: float) -> list[tuple[float, float, int]]:
        """Return the places of things in the arena's picture, y downwards, and their numbers."""
        pixels = places * self.scale
        pixels[:, 1] = self.arena[1] - pixels[:, 1]
        spots, names = images(pixels, reach, self.arena, self.scenario.arena.boundary == "walls")
        return list(zip(*spots.T.tolist(), names.tolist(), strict=True))

    def _edge(self, pen: ImageDraw.ImageDraw) -> None:
        """Draw walls as a thick line, and the edges of a torus as a faint one."""
        walls = self.scenario.arena.boundary == "walls"
        thick = max(DRAWN, self.size[0] // (160 if walls else 480))
        left, top = self.corner
        box = (left - thick, top - thick, left + self.arena[0] + thick - 1, top + self.arena[1] + thick - 1)
        pen.rectangle(box, outline=self.theme.ink if walls else self.theme.faint, width=thick)

    def _words(
        self, drawn: Image.Image, pen: ImageDraw.ImageDraw, swarm: Shown, notes: Sequence[str]
    ) -> None:
        """Write step, decision, truth and notes; the robot before each count is the legend."""
        left, right = self.margin, self.size[0] - self.margin

        def write(x: float, line: int, text: str, anchor: str = "lm") -> float:
            pen.text((x, self.words + (line + 0.5) * self.line), text, self.theme.ink, self.font, anchor)
            return x + self.font.getlength(f"{text}   ")

        write(left, 0, f"step {swarm.step}")
        write(right, 0, self._outcome(swarm), "rm")
        write(right, 1, f"truth: {DECISIONS[swarm.truth]}", "rm")
        counts = {FEASIBLE: swarm.feasible_counts[-1], INFEASIBLE: swarm.infeasible_counts[-1]}
        texts = {opinion: f"{count} {DECISIONS[opinion]}" for opinion, count in counts.items()}
        none = swarm.counted_counts[-1] - sum(counts.values())
        at, radius = float(left), round(0.42 * self.font.size)
        for opinion, text in (texts | ({NO_OPINION: str(none)} if none else {})).items():
            _press(drawn, _robot(radius, self.theme, opinion), at + radius, self.words + 1.5 * self.line)
            at = write(at + 2.8 * radius, 1, text)
        if self.scenario.declares:
            feasible, infeasible = swarm.declared_counts
            write(left, 2, f"declared: {feasible} feasible, {infeasible} infeasible")
        if self.scenario.dynamic:
            write(left, 2, f"{int(swarm.present.sum())} robots, {len(swarm.tasks)} tasks")
        if self.scenario.acts:
            write(left, self.lines - 1, swarm.acting.achieved)
        for line, text in enumerate(notes, self.lines):
            write(left, line, text)

    def _outcome(self, swarm: Shown) -> str:
        """Return the decision and whether it is right.

        With a curve, this is the first decision and its step; in a world that changes, that of this step.
        """
        first = self.span is not None and not self.scenario.dynamic
        decision, step = swarm.first_decision if first else (swarm.decision, -1)
        if decision == UNDECIDED:
            return "not decided"
        verdict = "right" if decision == swarm.truth else "wrong"
        return f"decided {DECISIONS[decision]}{f' at step {step}' if step >= 0 else ''}: {verdict}"

    def _curves(
        self, drawn: Image.Image, pen: ImageDraw.ImageDraw, swarm: Shown, start: int, end: int
    ) -> None:
        """Draw the share of each opinion up to the present step, and the threshold."""
        left, top, right, bottom = self.strip

        def place(step: int, share: float) -> tuple[float, float]:
            across = (step - start) / max(1, end - start)
            return left + (right - left) * across, bottom - (bottom - top) * share

        small = self.font.font_variant(size=0.8 * self.font.size)
        threshold = self.scenario.decision.threshold
        for share, colour in ((0.0, self.theme.faint), (1.0, self.theme.faint), (threshold, self.theme.ink)):
            y = place(start, share)[1]
            dash = 4 * DRAWN if share == threshold else right - left
            for x in range(left, right, 2 * dash):
                pen.line((x, y, min(x + dash, right), y), colour, DRAWN)
            if share < 1:
                pen.text((left - DRAWN * 3, y), f"{100 * share:g} %", self.theme.ink, small, "rm")
        below = bottom + 0.35 * self.line
        pen.text((left, below), str(start), self.theme.ink, small, "lm")
        pen.text((right, below), f"{end} steps", self.theme.ink, small, "rm")
        known = np.arange(start, swarm.step + 1)
        every = max(1, (swarm.step + 1) // (2 * self.size[0]))
        known = np.append(known[::every], known[-1:])
        dash = max(1, round(DASH * DRAWN / (place(start + every, 0.0)[0] - left)))
        counted = swarm.counted_counts[known]
        if self.scenario.dynamic:
            ends = [*(np.flatnonzero(np.diff(swarm.truths[start:])) + start + 1).tolist(), swarm.step]
            self._band(pen, [place(each, 1.0)[0] for each in (start, *ends)], bool(swarm.truths[start]))
        radius = round(0.32 * self.font.size)
        for counts, opinion in ((swarm.infeasible_counts, INFEASIBLE), (swarm.feasible_counts, FEASIBLE)):
            colour = COLOURS[DECISIONS[opinion]]
            shares = counts[known] / np.maximum(1, counted)
            points = [place(step, share) for step, share in zip(known.tolist(), shares.tolist(), strict=True)]
            part = dash if opinion == INFEASIBLE else len(points)
            for first in range(0, len(points) - 1, 2 * part):
                pen.line(
                    points[first : first + part + 1], colour, max(DRAWN, self.size[0] // 240), joint="curve"
                )
            if points:
                _press(drawn, _robot(radius, self.theme, opinion), *points[-1])

    def _band(self, pen: ImageDraw.ImageDraw, ends: list[float], truth: bool) -> None:
        """Draw the truth above the curves, from change to change: full if feasible, hollow if not."""
        top, height = self.strip[1] - 5 * DRAWN, 4 * DRAWN
        for left, right in pairwise(ends):
            colour = COLOURS[DECISIONS[truth]]
            box = (left, top, max(left, right), top + height - 1)
            pen.rectangle(box, fill=colour if truth else None, outline=colour, width=DRAWN)
            truth = not truth


def show_swarm(swarm: Shown, run: int) -> str:
    """Return a `Swarm` as HTML without scripts: its arena, its counts, and its collapsed scenario."""
    outcome = f"{DECISIONS[swarm.decision]} (truth: {DECISIONS[int(swarm.truth)]})"
    if swarm.scenario.declares:
        outcome += "; declared: {} feasible, {} infeasible".format(*swarm.declared_counts)
    if swarm.scenario.acts:
        outcome += f"; {swarm.acting.achieved}"
    robots, tasks = int(swarm.present.sum()), len(swarm.tasks)
    few = max(robots, tasks) <= MOST
    return render(
        "swarm.html",
        swarm=swarm,
        run=run,
        counts={DECISIONS[FEASIBLE]: swarm.feasible_count, DECISIONS[INFEASIBLE]: swarm.infeasible_count},
        colours=COLOURS,
        outcome=outcome,
        picture=encoded(Painter(swarm.scenario, SIZE).draw_arena(swarm)) if few else None,
        robots=robots,
        tasks=tasks,
        most=MOST,
    )


class Stamp(NamedTuple):
    """A small picture with soft edges, whose centre is its anchor."""

    colour: Image.Image
    mask: Image.Image
    grain: int
    """It is pasted at multiples of this; on whole pixels copies are equal, which makes GIFs small."""


def _press(onto: Image.Image, stamp: Stamp, x: float, y: float) -> None:
    """Paste a stamp with its centre at a place."""
    half, grain = stamp.mask.width // 2, stamp.grain
    at = grain * round(x / grain) - half, grain * round(y / grain) - half
    onto.paste(stamp.colour, at, stamp.mask)


@cache
def _robot(
    radius: float,
    theme: Theme,
    opinion: int,
    disseminating: bool = False,
    counted: bool = True,
    declared: bool = False,
    lost: bool = False,
) -> Stamp:
    """Draw a robot: a disc in the colour of its opinion, pale if it doesn't count, grey if it is lost.

    In addition to the colour, feasible is full, infeasible hollow, and no opinion small. A ring means that
    the robot disseminates, a dark rim that it has declared.
    """
    detailed = radius >= DETAILED_RADIUS * DRAWN
    side = 2 * DRAWN * int(np.ceil((RING * radius + 1) / DRAWN))
    large = Image.new("RGBA", (side * FINE, side * FINE))
    pen = ImageDraw.Draw(large)
    full = theme.faint if lost else COLOURS[DECISIONS[opinion]]
    colour = between(theme.paper, full, 1.0 if counted or lost else 0.4)
    centre, unit = side * FINE / 2, radius * FINE

    def disc(radii: float, fill: str | tuple[int, ...]) -> None:
        reach = radii * unit
        pen.ellipse((centre - reach, centre - reach, centre + reach, centre + reach), fill)

    if detailed and disseminating:
        disc(RING, colour)
        disc(RING - 0.18, theme.paper)
    inner = 1.0
    if detailed and declared:
        disc(RIM, theme.ink if counted else theme.faint)
        inner = RIM - 0.26
    disc(0.7 if opinion == NO_OPINION else inner, colour)
    if opinion == INFEASIBLE:  # of a dot the hole is too small to see, and makes it lighter
        disc(0.48, theme.paper)
    return _stamp(large, radius)


@cache
def _task(half: float, theme: Theme, look: int = 1) -> Stamp:
    """Draw a task, a triangle with an outline: hollow if it is free, full, or pale if it is done."""
    side = 2 * DRAWN * int(np.ceil((1.3 * half + 1) / DRAWN))
    large = Image.new("RGBA", (side * FINE, side * FINE))
    centre, unit = side * FINE / 2, half * FINE
    pen = ImageDraw.Draw(large)
    fill = ((0.68, theme.paper), (0.78, TASK), (0.78, theme.faint))[look]
    detailed, dot = half >= DETAILED_RADIUS * DRAWN, (1.0, theme.faint if look else theme.ink)
    for size, colour in ((1.0, theme.ink), fill) if detailed else (dot,):
        corners = [(0.0, -1.05), (1.0, 0.75), (-1.0, 0.75)]
        pen.polygon([(centre + x * size * unit, centre + y * size * unit) for x, y in corners], colour)
    return _stamp(large, half)


def _stamp(large: Image.Image, radius: float) -> Stamp:
    small = large.reduce(FINE)
    grain = DRAWN if radius >= DETAILED_RADIUS * DRAWN else 1
    return Stamp(small.convert("RGB"), small.getchannel("A"), grain)
