"""What tests read from pictures of swarms: colours at places, and the frames of a film."""

from __future__ import annotations

import base64
import io
import re

import numpy as np
from PIL import Image, ImageColor

from feasibee.figures.animation import draw_frame
from feasibee.simulation.frames import DARK, DRAWN, LIGHT, Painter


def seen_at(picture, scenario, place):
    """Return the colour of a place in units, from the arena's corner and scale."""
    painter = Painter(scenario, picture.width)
    left, top = (each / DRAWN for each in painter.corner)
    height, scale = painter.arena[1] / DRAWN, painter.scale / DRAWN
    return picture.getpixel((int(left + place[0] * scale), int(top + height - place[1] * scale)))


def shown_by(swarm):
    """Return the picture of a swarm in a notebook."""
    data = re.search(r'<img [^>]*src="data:image/png;base64,([^"]+)"', swarm._repr_html_())[1]
    with Image.open(io.BytesIO(base64.b64decode(data))) as picture:
        return picture.convert("RGB")


DRAWINGS = [
    (LIGHT, lambda swarm: draw_frame(swarm, size=1000)),
    (DARK, lambda swarm: draw_frame(swarm, size=1000, dark=True)),
    (LIGHT, shown_by),
]
"""Themes, and functions that draw a swarm with them."""


def close(one, other, most=12):
    """Return whether two colours differ by so much at most; the other one may be a name."""
    other = ImageColor.getrgb(other) if isinstance(other, str) else other
    return max(abs(a - b) for a, b in zip(one, other, strict=True)) <= most


def frames_of(path):
    """Return the frames of a film, with their durations and its loops."""
    with Image.open(path) as film:
        shown, durations = [], []
        for number in range(film.n_frames):
            film.seek(number)
            shown.append(np.asarray(film.convert("RGB")))
            durations.append(film.info.get("duration"))
        return shown, durations, film.info.get("loop")
