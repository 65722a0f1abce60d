"""Images of cells: decoded with a limit, encoded, and identified by their cells, however they are encoded."""

from __future__ import annotations

import base64
import hashlib
import io
import struct
import warnings
import zlib
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Cells = NDArray[np.bool_]
MOST = 4096
"""Most columns, and most rows."""
_PNG, _MODES = b"\x89PNG\r\n\x1a\n", ("1", "L", "LA", "P", "RGB", "RGBA")


class ImageError(ValueError):
    """An image that isn't one of cells; its text is the rule that it breaks."""


def pixels_of(data: bytes) -> tuple[NDArray[np.uint8], Cells]:
    """Return the grey of each pixel of a PNG or PGM image, and whether it is opaque; the top row is first.

    Raise an `ImageError` if it is no such image, or is larger than ``MOST``: then nothing is decoded.
    """
    from PIL import Image

    formats = {_PNG[:2]: "PNG", b"P2": "PPM", b"P5": "PPM"}
    if data[:2] not in formats:
        raise ImageError("must be a PNG or PGM image")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            image = Image.open(io.BytesIO(data), formats=[formats[data[:2]]])
        with image:
            width, height = image.size
            if max(width, height) > MOST:
                raise ImageError(f"must be at most {MOST} x {MOST} pixels, not {width} x {height}")
            if image.mode not in _MODES:
                raise ImageError("must have at most 8 bits per colour")
            if not image.has_transparency_data:
                grey = np.asarray(image.convert("L"))
                return grey, np.ones(grey.shape, bool)
            colours = image.convert("RGBA")
            return np.asarray(colours.convert("L")), np.asarray(colours)[..., 3] == 255
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise ImageError(f"must be at most {MOST} x {MOST} pixels") from None
    except ImageError:
        raise
    except (OSError, ValueError, LookupError, SyntaxError, EOFError, struct.error, zlib.error):
        raise ImageError("is damaged: it can't be decoded") from None


@lru_cache(maxsize=4)
def cells_of(image: str) -> Cells:
    """Return which cells of a PNG in base64 are closed, in a read-only array whose row 0 has the lowest y.

    Raise an `ImageError` if it isn't such a text.
    """
    try:
        data = base64.b64decode(image, validate=True)
    except ValueError:
        raise ImageError("must be a PNG in base64") from None
    if not data.startswith(_PNG):
        raise ImageError("must be a PNG in base64")
    cells: Cells = (pixels_of(data)[0] < 128)[::-1]
    cells.flags.writeable = False
    return cells


def image_of(cells: Cells) -> str:
    """Return cells as a PNG in base64, a bit per cell, from which `cells_of` gives them again."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(~cells[::-1]).save(file, "PNG")
    return base64.b64encode(file.getvalue()).decode()


def digest_of(image: str) -> str:
    """Return a hash of the cells of an image; of its text, if it is no image."""
    try:
        cells = cells_of(image)
    except ImageError:
        return image
    return hashlib.sha256(repr(cells.shape).encode() + np.packbits(cells).tobytes()).hexdigest()
