"""Text and figures on A4 pages of a PDF, from top to bottom."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from matplotlib import rc_context, style
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from feasibee.figures.style import STYLE
from feasibee.files import atomic_write

WIDTH, HEIGHT, MARGIN = 595.0, 842.0, 48.0
"""Size and margin of an A4 page in points, of which an inch has 72."""
SIZE: Final = 9.5
"""Size of text, in points."""
LEADING: Final = 1.35
"""Distance of two lines of text, in sizes of the text."""
LETTER, FIXED = 0.55, 0.61
"""Mean width of a letter of text, and width of one of tables, in sizes of the text."""
DOTS: Final = 200
"""Dots per inch of figures."""


class Sheets:
    """The pages of a document; ``foot`` stands at the foot of each, before its number."""

    def __init__(self, foot: str) -> None:
        self.foot = foot
        self.pages: list[Figure] = []
        self.turn()

    def turn(self) -> None:
        """Begin a page."""
        self.pages.append(Figure((WIDTH / 72, HEIGHT / 72)))
        self.y = MARGIN - 16
        self._put(f"{self.foot}; page {len(self.pages)}", 7)
        self.y = HEIGHT - MARGIN

    def heading(self, text: str) -> None:
        """Write a heading, on a new page if there is no room for it and three lines."""
        if self.y < MARGIN + 6 * SIZE * LEADING:
            self.turn()
        self.y -= 0.7 * SIZE
        self.text(text, 1.15 * SIZE, weight="bold")

    def text(self, text: str, size: float = SIZE, indent: float = 0.0, **look: Any) -> None:
        """Write a paragraph over the width of the page; further lines are indented."""
        letters = int((WIDTH - 2 * MARGIN - indent) / (LETTER * size))
        for number, line in enumerate(textwrap.wrap(text, letters)):
            self._line(line, size, indent if number else 0.0, **look)

    def table(self, rows: Sequence[Sequence[str]]) -> None:
        """Write a table in letters of fixed width, which are small enough for the page."""
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(map(str.ljust, row, widths)) for row in rows]
        size = min(7.5, (WIDTH - 2 * MARGIN) / (FIXED * max(map(len, lines))))
        for line in lines:
            self._line(line, size, family="monospace")

    def picture(self, drawn: Figure, caption: str, *, here: bool = False) -> None:
        """Put a figure at its size or smaller above its caption; ``here``: in the rest of this page."""
        width, height = (72 * float(each) for each in drawn.get_size_inches())
        scale, used = min(1.0, (WIDTH - 2 * MARGIN) / width), 4 * SIZE
        if here:
            scale = min(scale, (self.y - MARGIN - used) / height)
        elif self.y - scale * height - used < MARGIN:
            self.turn()
        self.y -= scale * height + SIZE
        canvas: Any = FigureCanvasAgg(drawn)
        drawn.set_dpi(DOTS)
        canvas.draw()
        box = (MARGIN / WIDTH, self.y / HEIGHT, scale * width / WIDTH, scale * height / HEIGHT)
        axes = self.pages[-1].add_axes(box)
        axes.set_axis_off()
        axes.imshow(canvas.buffer_rgba(), aspect="auto", interpolation="none")
        self.text(caption, 8)

    def _line(self, text: str, size: float, indent: float = 0.0, **look: Any) -> None:
        self.y -= size * LEADING
        if self.y < MARGIN:
            self.turn()
            self.y -= size * LEADING
        self._put(text, size, indent, **look)

    def _put(self, text: str, size: float, indent: float = 0.0, **look: Any) -> None:
        x, y = (MARGIN + indent) / WIDTH, self.y / HEIGHT
        self.pages[-1].text(x, y, text, size=size, parse_math=False, **look)


@contextmanager
def sheets(path: Path, foot: str) -> Iterator[Sheets]:
    """Yield the pages of a document, and save them atomically as PDF with embedded fonts."""
    with atomic_write(path) as temporary, style.context("default"), rc_context(STYLE):
        document = Sheets(foot)
        yield document
        with PdfPages(temporary, metadata={"CreationDate": None}) as pdf:
            for page in document.pages:
                pdf.savefig(page)
