"""Measure how often whole numbers draw other durations than double precision does: docs/firmware.md."""

from __future__ import annotations

import json
import math
import random
import struct
import subprocess
import tempfile
from pathlib import Path

from feasibee.robot.firmware import header

SOURCE = Path(__file__).parents[2] / "tests" / "robot" / "durations.c"
DRAWS = 1_000_000
MEANS = [(10, 1, 20, 0), (2.5, 1, 1, 0), (10, 3, 7, 0), (10, 3, 7, 1), (100, 1, 1, 0), (1000, 1, 1, 0)]
"""Steps, and the share of them: part, whole, and whether it is the rest that counts."""


def main() -> None:
    """Print the largest number of draws that differ, and by how many steps, as JSON."""
    draw = random.Random(1)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "feasibee.h").write_text(header())
        program = Path(folder, "durations")
        subprocess.run(["cc", "-O2", "-I", folder, SOURCE, "-o", program], check=True)
        errors = [errors_of(program, mean, draw) for mean in MEANS]
    differing = [sum(error != 0 for error in each) for each in errors]
    largest = max(max(each) for each in errors)
    print(json.dumps({"draws": DRAWS, "means": len(MEANS), "differing": max(differing), "steps": largest}))


def errors_of(program: Path, mean: tuple[float, int, int, int], draw: random.Random) -> list[int]:
    """Return by how many steps the durations with a mean differ."""
    steps, part, whole, complement = mean
    words = [draw.getrandbits(32) for _ in range(DRAWS)]
    given = b"".join(struct.pack("<5I", int(steps * 65_536), part, whole, complement, word) for word in words)
    answer = subprocess.run([program], input=given, capture_output=True, check=True).stdout
    expected = steps * (1 - part / whole if complement else part / whole)
    return [
        abs(drawn - max(1, math.ceil(-expected * math.log((word + 1) / 2**32))))
        for drawn, word in zip(struct.unpack(f"<{DRAWS}I", answer), words, strict=True)
    ]


if __name__ == "__main__":
    main()
