"""Rules of strategies in C, called as Python's functions are, and arguments to try them with."""

from __future__ import annotations

import random
import shutil
import struct
import subprocess
from pathlib import Path
from typing import Any

from cffi import FFI

import feasibee.engine
from feasibee.engine import build
from feasibee.engine.generate import RULES
from feasibee.engine.given import struct_of
from feasibee.engine.own import Failure
from feasibee.strategies.contract import ARGUMENTS, Inbox, Mind, Setting
from tests.once import made_once

C = Path(feasibee.engine.__file__).parent / "c"
CALLS = Path(__file__).with_name("calls.c")
FLAGS = ("-std=gnu11", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-Wall", "-Wextra", "-Werror")
EDGES = (62, 63, 64, 65, -63, 2**31, -(2**31), 2**32 - 1, 3_037_000_500)
"""Where a shift, a power or a product leaves 64 bits."""
SANITIZED = ("-fsanitize=undefined", "-fno-sanitize-recover=all")


def declarations() -> FFI:
    """Return what the engine declares, and what calls.c does."""
    ffi = FFI()
    ffi.cdef(build.declarations())
    calls = CALLS.read_text(encoding="utf-8")
    ffi.cdef(calls[calls.index("struct call {") : calls.index("static int64_t work")])
    ffi.cdef("int64_t call_once(struct call *call, struct failure *failure);")
    return ffi


def library(folder: Path, name: str, source: str, *flags: str) -> Path:
    """Compile a text in C to a library, which has this name in the whole session."""

    def make(made: Path) -> None:
        own = made.parent
        (own / "source.c").write_text(source, encoding="utf-8")
        (own / "params.h").write_text(build.params_header(), encoding="utf-8")
        command = [shutil.which("cc") or "gcc", *FLAGS, *flags, f"-I{own}", f"-I{C}", str(own / "source.c")]
        subprocess.run([*command, "-o", str(made), "-lm"], check=True)

    return made_once(folder, f"{name}.so", make)


class Rules:
    """The rules of a strategy in a library."""

    def __init__(self, ffi: FFI, calls: Any, rules: Any) -> None:
        self.ffi, self.calls, self.rules = ffi, calls, rules

    def __contains__(self, rule: str) -> bool:
        return bool(getattr(self.rules, rule))

    def __call__(self, rule: str, arguments: tuple[Any, ...]) -> Any:
        """Call a rule; return its result or its failure, and write its mind's memory."""
        kept: list[Any] = []
        call, failure = self.ffi.new("struct call *"), self.ffi.new("struct failure *")
        call.rules, call.rule = self.rules, RULES.index(rule)
        for name, each in zip(ARGUMENTS[rule], arguments, strict=True):
            field = {"robots_seen": "robots", "tasks_seen": "tasks"}.get(name, name)
            if isinstance(each, Mind | Inbox):
                each = self._struct(f"struct {name}", each, kept)  # noqa: PLW2901
            elif isinstance(each, Setting):
                each, arrays = struct_of(self.ffi, each)  # noqa: PLW2901
                kept += [each, arrays]
            if name == "known":
                kept.append(self.ffi.new("int32_t[]", [*each, 0]))
                each = {"words": kept[-1], "length": len(each)}  # noqa: PLW2901
            setattr(call, field, each)
        if self.calls.call_once(call, failure) != 0:
            return Failure(failure.what, failure.line, failure.first, failure.second)
        if call.mind:
            arguments[0].memory[:] = list(call.mind.memory[0 : call.mind.memory_count])
        return call.whole if rule in ("decide", "say") else call.real

    def _struct(self, kind: str, record: Any, kept: list[Any]) -> Any:
        made = self.ffi.new(f"{kind} *")
        kept.append(made)
        for name, value in record._asdict().items():
            if name in ("memory", "parameters"):
                kept.append(self.ffi.new("double[]", [*map(float, value), 0.0]))
                setattr(made, name, kept[-1])
                setattr(made, f"{name.removesuffix('s')}_count", len(value))
            else:
                setattr(made, name, value)
        return made


def bits(value: Any) -> Any:
    """Return what tells two numbers apart to the last bit, a float's sign of zero included."""
    return struct.pack("<d", value) if isinstance(value, float) else int(value)


class Draws:
    """Random arguments for the rules of a strategy."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)

    def share(self) -> float:
        """Return a number from 0 to 1, often one of few."""
        draw = self.random
        return draw.choice([0.0, 0.5, 1.0, draw.random(), draw.randint(0, 9) / 9, draw.random() * 1e-9])

    def count(self) -> int:
        """Return a number of things."""
        return self.random.choice([0, 1, 2, 3, self.random.randint(0, 30), self.random.randint(0, 3000)])

    def wide(self) -> tuple[float, float]:
        """Return the upper and the lower half of a whole number, often a small one or one at a limit."""
        draw = self.random
        low = draw.choice([draw.randint(-4, 12), draw.randint(-(10**5), 10**5), draw.choice(EDGES)])
        high = draw.choice([0, 0, 0, -(2**31), 2**31 - 1, draw.randint(-(2**31), 2**31 - 1)])
        return float(high), float(low)

    def real(self) -> float:
        """Return a real number, often one at a limit."""
        draw = self.random
        few = draw.choice([0.0, -0.0, 1.0, -1.0, 0.5, 2.0, -2.5, 3.5, 700.0, 5e-324, 1e18, 9.3e18, -1e19])
        sizes = [draw.uniform(-1, 1), draw.uniform(-10, 10), 1e300 * draw.random(), 1e-300 * draw.random()]
        return draw.choice([few, draw.choice(sizes), float(draw.randint(-(2**63), 2**63)), 2.0**53 + 2])

    def mind(self, memory: int, parameters: list[float]) -> Mind:
        """Return the mind of a robot."""
        draw = self.random
        opinion, rated = draw.choice([1, 0, -1]), self.share()
        quality = {1: rated, 0: 1.0 - rated, -1: 0.5}[opinion]
        own = [draw.choice([0.0, 1.0, float(self.count()), draw.uniform(-3, 3)]) for _ in range(memory)]
        return Mind(opinion, quality, rated, draw.randint(0, 1), own, parameters, draw.randint(0, 1))

    def inbox(self) -> Inbox:
        """Return what a robot heard."""
        feasible, infeasible = self.count(), self.count()
        heard = self.random.choice([1, 0]) if feasible + infeasible else -1
        value, mean = (self.share(), self.share()) if feasible + infeasible else (0.0, 0.0)
        return Inbox(feasible, infeasible, heard, value, mean, self.random.random())

    def arguments(self, rule: str, memory: int, parameters: list[float], setting: Setting) -> tuple[Any, ...]:
        """Return arguments for a rule."""
        if rule == "quality":
            return self.count(), self.count()
        gain = self.random.choice([10.0, 1e-3, 1e6, self.random.uniform(0, 100)])
        if rule == "dissemination":
            return self.share(), gain
        mind = self.mind(memory, parameters)
        others = {"decide": (self.inbox(),), "lasting": (gain,), "probability": ((), setting)}
        assert rule in RULES
        return (mind, *others.get(rule, ()))
