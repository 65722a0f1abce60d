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
from feasibee.engine.generate import RULES
from feasibee.strategies.contract import Inbox, Mind, Setting

C = Path(feasibee.engine.__file__).parent / "c"
FLAGS = ("-std=gnu11", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-Wall", "-Wextra", "-Werror")
SANITIZED = ("-fsanitize=undefined", "-fno-sanitize-recover=all")


def declarations() -> FFI:
    """Return what engine.h declares."""
    ffi = FFI()
    lines = (C / "engine.h").read_text(encoding="utf-8").splitlines()
    ffi.cdef("\n".join(line for line in lines if not line.startswith("#")))
    return ffi


def library(folder: Path, text: str, *flags: str) -> Path:
    """Compile a text in C to a library."""
    source, made = folder / "strategies.c", folder / "strategies.so"
    source.write_text(text, encoding="utf-8")
    command = [shutil.which("cc") or "gcc", *FLAGS, *flags, f"-I{C}", str(source), "-o", str(made)]
    subprocess.run(command, check=True)
    return made


class Rules:
    """The rules of a strategy in a library."""

    def __init__(self, ffi: FFI, loaded: Any, name: str) -> None:
        self.ffi, self.rules = ffi, loaded.feasibee_rules(name.encode())

    def __contains__(self, rule: str) -> bool:
        return bool(getattr(self.rules, rule))

    def __call__(self, rule: str, arguments: tuple[Any, ...]) -> Any:
        """Call a rule, whose mind's memory it may change."""
        given, kept, mind = [], [], None
        for each in arguments:
            if isinstance(each, Mind):
                mind = made = self._struct("struct mind", each, kept)
            elif isinstance(each, Inbox | Setting):
                made = self._struct(f"struct {type(each).__name__.lower()}", each, kept)
            else:
                made = each
            given.append(made)
        if rule == "probability":
            del given[1]  # what is known
        result = getattr(self.rules, rule)(*given)
        if mind is not None:
            arguments[0].memory[:] = list(mind.memory[0 : mind.memory_count])
        return result

    def _struct(self, kind: str, record: Any, kept: list[Any]) -> Any:
        made = self.ffi.new(f"{kind} *")
        for name, value in record._asdict().items():
            if name in ("memory", "parameters"):
                kept.append(self.ffi.new("double[]", [*map(float, value), 0.0]))
                setattr(made, name, kept[-1])
                setattr(made, f"{name.removesuffix('s')}_count", len(value))
            elif name == "plan":
                kept.append(self.ffi.new("uint8_t[]", [*value, 0]))
                made.plan, made.plan_length = kept[-1], len(value)
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
        others = {
            "decide": (self.inbox(),),
            "lasting": (gain,),
            "probability": ((), setting),
        }
        assert rule in RULES
        return (mind, *others.get(rule, ()))
