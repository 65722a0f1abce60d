"""The layout of the server's binary messages: one table, from which the page's decoder is generated.

A message is little-endian: a header, and then arrays that JavaScript reads without copying. After a change,
run ``python -m feasibee.live.layout`` to write the generated part of ``static/frames.js``.
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feasibee.simulation.snapshot import FLAGS

PROTOCOL: Final = 4
"""Version of the messages; raise it when a page of the previous version could not read them."""
MODULE: Final = Path(__file__).parent / "static" / "frames.js"
END: Final = "// End of the generated part.\n"
READERS: Final = {
    "B": "getUint8({})",
    "b": "getInt8({})",
    "H": "getUint16({}, true)",
    "I": "getUint32({}, true)",
    "i": "getInt32({}, true)",
    "Q": "getBigUint64({}, true)",
}
"""Methods of JavaScript's DataView for the type codes of `struct`."""
ARRAYS: Final = {"<i4": ("Int32Array", 4), "<u2": ("Uint16Array", 2), "u1": ("Uint8Array", 1)}
"""JavaScript's array and the bytes per item, for types of numpy."""


class Layout(NamedTuple):
    """The layout of one kind of message."""

    name: str
    """Name of the kind in JavaScript."""
    kind: int
    """Second byte of the message, after the protocol."""
    header: tuple[tuple[str, str], ...]
    """Name and `struct` type code of each number; the first are the protocol and the kind."""
    arrays: tuple[tuple[str, str, str], ...]
    """Name, numpy type, and name of the length in the header, of each array."""

    @property
    def struct(self) -> struct.Struct:
        """The header's packing, without padding."""
        return struct.Struct("<" + "".join(code for _, code in self.header))

    def encode(self, **values: int | NDArray[Any]) -> bytes:
        """Return a message with these numbers and arrays; padding, protocol and kind are filled in."""
        known = {"protocol": PROTOCOL, "kind": self.kind, "_": 0, **values}
        header = self.struct.pack(*(known[name] for name, _ in self.header))
        arrays = (np.asarray(values[name]).astype(kind).tobytes() for name, kind, _ in self.arrays)
        return b"".join([header, *arrays])


FRAME: Final = Layout(
    "frame",
    1,
    (
        ("protocol", "B"),
        ("kind", "B"),
        ("generation", "H"),
        ("robots", "I"),  # number of numbers that robots may have
        ("step", "I"),
        ("first", "I"),  # first step of the counts
        ("length", "i"),  # number of steps of the counts
        ("decision_step", "i"),  # step of the first decision; -1: none yet
        ("decision", "b"),  # at this step
        ("first_decision", "b"),
        ("lane", "B"),  # 0, or 1 for the second swarm
        ("jump", "B"),  # number of the page's last jump to a step, modulo 256
        ("feasible", "I"),  # number of robots, as are the next six
        ("infeasible", "I"),
        ("counted", "I"),
        ("disseminating", "I"),
        ("working", "I"),
        ("declared_feasible", "I"),  # counted robots only
        ("declared_infeasible", "I"),
        ("there", "I"),  # robots at this step
        ("tasks", "I"),  # tasks at this step
        ("placed", "I"),  # tasks whose positions follow: all in a world that changes, else none
        ("truth", "I"),  # at this step
        ("bits", "Q"),  # sent so far
        ("robot_steps", "Q"),  # number of robots, summed over the steps so far
    ),
    (
        ("feasible_counts", "<i4", "length"),
        ("infeasible_counts", "<i4", "length"),
        ("counted_counts", "<i4", "length"),
        ("x", "<u2", "robots"),
        ("y", "<u2", "robots"),
        ("flags", "<u2", "robots"),
        ("task_x", "<u2", "placed"),
        ("task_y", "<u2", "placed"),
        ("heading", "u1", "robots"),
        ("truths", "u1", "length"),
    ),
)
"""One step of a swarm."""
TASKS: Final = Layout(
    "tasks",
    2,
    (("protocol", "B"), ("kind", "B"), ("generation", "H"), ("count", "I")),
    (("x", "<u2", "count"), ("y", "<u2", "count")),
)
"""Positions of the tasks at the start."""


def javascript() -> str:
    """Return the generated part of ``frames.js``, in prettier's format."""
    flags = ",\n  ".join(f"{name.upper()} = {1 << bit}" for bit, name in enumerate(FLAGS))
    constants = f"export const PROTOCOL = {PROTOCOL};\nexport const {flags};\nconst FRAME = {FRAME.kind};\n"
    head = "// Made by `python -m feasibee.live.layout`. A test compares it with that module.\n"
    return head + constants + "".join(map(_decoder, (FRAME, TASKS))) + "\n" + END


def _decoder(layout: Layout) -> str:
    """Return JavaScript's function that decodes a message."""
    lengths = dict.fromkeys(length for _, _, length in layout.arrays)
    reads = dict(_reads(layout))
    shown = [f'kind: /** @type {{const}} */ ("{layout.name}")']
    shown += [
        each if each in lengths else f"{each}: {read}"
        for each, read in reads.items()
        if each not in ("protocol", "kind", "_", *(lengths if layout is TASKS else ("length",)))
    ]
    past: Counter[str] = Counter()  # bytes per unit of each length, of the arrays so far
    for name, kind, length in layout.arrays:
        array, size = ARRAYS[kind]
        at = " + ".join([str(layout.struct.size), *(f"{count} * {each}" for each, count in past.items())])
        shown.append(f"{_camel(name)}: new {array}(buffer, {at}, {length})")
        past[length] += size
    needed = ",\n    ".join(f"{length} = {reads[length]}" for length in lengths)
    body = "".join(f"    {each},\n" for each in shown)
    return (
        f"\n/**\n * @param {{ArrayBuffer}} buffer\n * @param {{DataView}} view\n */\n"
        f"function {layout.name}(buffer, view) {{\n  const {needed};\n  return {{\n{body}  }};\n}}\n"
    )


def _reads(layout: Layout) -> Iterator[tuple[str, str]]:
    """Yield the name in JavaScript of each number of a header, and the expression that reads it."""
    at = 0
    for name, code in layout.header:
        read = f"view.{READERS[code].format(at)}"
        yield _camel(name), f"Number({read})" if code == "Q" else read
        at += struct.calcsize(f"<{code}")


def _camel(name: str) -> str:
    first, *rest = name.split("_")
    return first + "".join(each.title() for each in rest) if first else name


def main() -> None:
    """Write the generated part of the page's decoder."""
    _, _, rest = MODULE.read_text("utf-8").partition(END)
    MODULE.write_text(javascript() + rest, "utf-8")


if __name__ == "__main__":
    main()
