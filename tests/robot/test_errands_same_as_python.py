"""The errand of a robot in C is that in Python, after each thing that happens to it."""

from __future__ import annotations

import random
import subprocess
from pathlib import Path

import pytest

import feasibee.robot.firmware
from feasibee.robot.acting import GONE, NONE, Errand, Rules
from tests.robot.driving import HERE, SANITIZED, STRICT, needs, run

HEADER = Path(feasibee.robot.firmware.__file__).parent / "c" / "acting.h"
TASKS, LIFE = 12, 400


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    needs("cc", "gcc")
    made = tmp_path_factory.mktemp("errands") / "errands"
    options = [*STRICT, *SANITIZED, "-DFEASIBEE_TASKS=12"]
    run(["cc", "-std=c99", *options, "-I", HEADER.parent, HERE / "errands.c", "-o", made])
    return made


def rules_of(draw):
    return Rules(
        start=draw.choice([0, 30, GONE]),
        by_word=draw.random() < 0.5,
        by_rank=draw.random() < 0.4,
        tags=draw.random() < 0.4,
        comes_free=draw.random() < 0.5,
        number=draw.randint(0, 4),
        rank=draw.randint(1, 3),
        ranks=3,
        count=draw.choice([None, 5, 9]),
    )


class Life:
    """The lines of one robot's life, and what the program must print of it."""

    def __init__(self, seed):
        self._draw = random.Random(seed)
        self.lines, self.answers = [], []
        self.errand, self.away, self.kinds = Errand(rules_of(self._draw)), {}, set()
        rules = self.errand.rules
        numbers = rules.start, rules.number, rules.count or 0, rules.rank, rules.ranks
        flags = rules.by_word, rules.by_rank, rules.tags, rules.comes_free
        self._note("b", *numbers, *map(int, flags))
        for task in range(TASKS):
            far = self._draw.choice([NONE, *range(6)])
            self.away[task] = None if far == NONE else far
            self._note("w", task, far, 0)
        for step in range(1, LIFE):
            self._live(step)

    def _note(self, what, *numbers, answer=False):
        errand = self.errand
        self.lines.append(" ".join(map(str, (what, *numbers))))
        known = [f"{task}:{version}" for task, version in sorted(errand.known.items())]
        held = int(answer), errand.target, errand.task, errand.mark, errand.began
        self.answers.append(" ".join([*map(str, held), *known]))

    def _live(self, step):
        draw, errand = self._draw, self.errand
        what = draw.choice("sshhhhccalj")
        task, status = draw.randrange(TASKS), draw.randint(0, 3)
        version = draw.choice([status, draw.randint(0, 40), GONE] if draw.random() < 0.3 else [status])
        self.kinds.add(what)
        if what == "s":
            errand.see(task, status)
            self._note("s", task, status, 0)
        elif what == "h":
            errand.hear({task: version})
            self._note("h", task, version, 0)
        elif what == "c":
            declared = draw.choice([-1, -1, -1, 0, 1])
            errand.choose(step, declared, self.away.get)
            self._note("c", step, declared, 0)
        elif what == "a" and errand.target != NONE:
            found = draw.choice([NONE, 0, 0, status])
            self._note("a", found, 0, 0, answer=errand.arrive(None if found == NONE else found))
        elif what == "l" and errand.task != NONE:
            errand.lose()
            self._note("l", 0, 0, 0)
        elif what == "j":
            errand.announce(step % 20)
            self._note("j", step % 20, 0, 0)


def test_lives_in_c_are_those_in_python(program):
    lives = [Life(seed) for seed in range(60)]
    given = "".join(f"{line}\n" for life in lives for line in life.lines)
    done = subprocess.run([program], input=given, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    found, expected = done.stdout.splitlines(), [line for life in lives for line in life.answers]
    assert next((pair for pair in zip(found, expected, strict=True) if pair[0] != pair[1]), None) is None
    stood = [line.split() for line in expected]
    for column in (1, 2, 3):  # targets, tasks and marks do occur
        assert sum(line[column] != "-1" for line in stood) > 100
    assert sum(line[0] == "1" for line in stood) > 100


def test_a_robot_without_room_for_a_task_goes_on(program):
    lines = ["b 0 0 0 1 1 0 0 0 0", *(f"w {k} 1 0" for k in range(14)), *(f"s {k} 0 0" for k in range(14))]
    done = subprocess.run([program], input="\n".join(lines), capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1].split()[5:] == [f"{k}:0" for k in range(12)]
