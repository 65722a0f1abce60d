"""A swarm in C and in Python whose robots only know, see, hear and say: both do the same, step by step."""

from __future__ import annotations

import random
from enum import IntEnum
from typing import Any

import numpy as np

from feasibee.engine.given import struct_of
from feasibee.robot.knowledge import Knowledge
from feasibee.strategies.contract import Me, Setting, Strategy, Thing
from feasibee.strategies.words import Words
from tests.engine.compiled import Rules

WORDS, UNIT = 1, 2.0**-31
"""Words of sets of robots; unit of positions."""
Action = IntEnum("Action", "START SPEAK OBSERVE MERGE COUNT DECLARE JUDGE", start=0)
UNSENT = -(2**62)


class Swarm:
    """Robots in C, and the same in Python."""

    def __init__(self, ffi: Any, rules: Rules, strategy: Strategy, setting: Setting, seed: int) -> None:
        self.ffi, self.rules, self.strategy, self.setting = ffi, rules, strategy, setting
        self.random, self.misnamed = random.Random(seed), setting.task_ids >= 2 * setting.tasks > 0
        self.kept: list[Any] = []
        self._allocate(ffi.new("struct state *"))
        self.minds: list[Knowledge] = []
        self.messages = [Words([0] * strategy.row_lengths(setting)[1]) for _ in range(setting.robots)]
        for i in range(setting.robots):
            self.minds.append(Knowledge(strategy, self._me(i, [0.0] * strategy.memory)))
            self._update(Action.START, [(i, 0, 0, 0)])

    # --- In C ---

    def _allocate(self, state: Any) -> None:
        ffi, setting, padded = self.ffi, self.setting, 32 * WORDS
        known, told = self.strategy.row_lengths(setting)
        robots, tasks, classes = setting.robots, setting.tasks, setting.robot_classes + setting.task_classes
        self.params = ffi.new("struct params *")
        self.params.robots.count, self.params.robots.classes, self.params.tasks.count = (
            robots,
            setting.robot_classes,
            tasks,
        )
        self.params.arena.unit, self.params.arena.sides.width = setting.width * UNIT / 2, setting.width
        self.params.faults.colluding = setting.colluding
        knowledge = self.params.strategy.knowledge
        knowledge.words, knowledge.message_words, knowledge.task_ids = known, told, setting.task_ids
        self.clock = self._one("struct clock")
        state.params, state.rules, state.clock = self.params, self.rules.rules, self.clock
        given, arrays = struct_of(ffi, setting)
        state.setting = given
        self.kept += [given, arrays]
        state.words, state.padded, state.copy_words = WORDS, padded, max(known, told)
        state.memory_length, state.tables.classes = self.strategy.memory, classes
        self.robots = self._rows(state.robots, 24, padded, np.int32, "int32_t")
        self.sets = self._rows(state.sets, 32, WORDS, np.uint32, "uint32_t")
        self.counts = self._rows(state.counts, 5, padded, np.int64, "int64_t")
        self.tasks = self._rows(state.tasks, 3, tasks, np.int32, "int32_t")
        self.knowledge = self._rows(state.knowledge, 2, padded * state.copy_words, np.int32, "int32_t")
        self.pending = []
        for name in ("who", "number", "column", "mark"):
            self.pending.append(self._array(state, f"pending_{name}", 256, np.int32, "int32_t"))
        self.seen = self._array(state, "seen", padded * classes, np.int64, "int64_t").reshape(padded, classes)
        memory = self._array(state, "memory", padded * self.strategy.memory, np.float64, "double")
        self.memory = memory.reshape(padded, -1) if self.strategy.memory else np.zeros((padded, 0))
        self.hashes = self._array(state, "hashes", robots + 2 * tasks + robots + 1, np.uint32, "uint32_t")
        self.class_of = self._array(state, "class_of", robots + tasks, np.int32, "int32_t")
        self.state, draw = state, self.random
        self.robots[self._row("IDENTITY"), :robots] = range(robots)
        self.robots[self._row("X"), :] = [draw.randrange(-(2**31), 2**31) for _ in range(padded)]
        self.robots[self._row("Y"), :] = [draw.randrange(-(2**31), 2**31) for _ in range(padded)]
        self.tasks[:2] = [[draw.randrange(-(2**31), 2**31) for _ in range(tasks)] for _ in range(2)]
        self.hashes[:] = [draw.randrange(2**32) for _ in self.hashes]
        self.class_of[:robots] = [draw.randrange(setting.robot_classes) for _ in range(robots)]
        self.class_of[robots:] = [draw.randrange(setting.task_classes) for _ in range(tasks)]
        self.sets[self._row("WORKING")] = 2**robots - 1
        self.sets[self._row("NEUTRAL")] = 2**robots - 1

    def _one(self, kind: str) -> Any:
        self.kept.append(self.ffi.new(f"{kind} *"))
        return self.kept[-1]

    def _rows(self, pointers: Any, rows: int, length: int, kind: Any, name: str) -> Any:
        made = np.zeros((rows, max(length, 1)), kind)
        self.kept.append(made)
        for k in range(len(pointers)):
            pointers[k] = self.ffi.cast(f"{name} *", self.ffi.from_buffer(made[k]))
        return made[:, :length] if length else made

    def _array(self, state: Any, field: str, length: int, kind: Any, name: str) -> Any:
        made = np.zeros(max(length, 1), kind)
        self.kept.append(made)
        setattr(state, field, self.ffi.cast(f"{name} *", self.ffi.from_buffer(made)))
        return made[:length]

    def _row(self, name: str) -> int:
        return int(getattr(self.rules.calls, name))

    def _update(self, action: Action, calls: list[tuple[int, int, int, int]]) -> Any:
        for row, numbers in zip(self.pending, zip(*calls, strict=True), strict=True):
            row[: len(calls)] = numbers
        return self.rules.update(self.state, action, len(calls))

    # --- What both do ---

    def _me(self, i: int, memory: list[float]) -> Me:
        half = self.setting.width / 2 * UNIT
        x, y = (float(np.uint32(self.robots[self._row(each), i])) * half for each in "XY")
        away = int(self.sets[self._row("DISSEMINATING"), 0]) >> i & 1
        kind, mark = int(self.class_of[i]), int(self.hashes[i])
        return Me(i, kind, mark, int(self.clock.step), memory, self.setting, not away, x, y)

    def step(self) -> None:
        """Begin a step: robots are elsewhere, and some begin another phase."""
        draw = self.random
        self.clock.step += draw.choice([1, 1, 2, 7, 60])
        for row in ("X", "Y"):
            self.robots[self._row(row), :] = [draw.randrange(-(2**31), 2**31) for _ in range(32 * WORDS)]
        self.sets[self._row("DISSEMINATING"), 0] = draw.getrandbits(32)
        for i, mind in enumerate(self.minds):
            mind.me = self._me(i, mind.me.memory)

    def observe(self, calls: int) -> Any:
        """Let robots see things, some of which aren't there, or are named wrongly."""
        setting, draw, given = self.setting, self.random, []
        robots, tasks = setting.robots, setting.tasks
        for _ in range(calls):
            i, mark = draw.randrange(robots), draw.randrange(2**31)
            number = draw.randrange(robots + tasks * (2 if self.misnamed else 1))
            column = draw.randrange(setting.robot_classes + setting.task_classes)
            if not self.strategy.by_name and draw.random() < 0.2:
                number = -1
            given.append((i, number, column, mark))
        found = self._update(Action.OBSERVE, given)
        for i, number, column, mark in given:
            self.minds[i].observe([self._thing(number, column, mark)])
        return found

    def _thing(self, number: int, column: int, mark: int) -> Thing:
        setting = self.setting
        robots, tasks, half = setting.robots, setting.tasks, setting.width / 2 * UNIT
        if number < 0:
            is_robot = column < setting.robot_classes
            return Thing(is_robot, -1, column if is_robot else column - setting.robot_classes, mark)
        named, number = number < robots + tasks, number if number < robots + tasks else number - tasks
        places = self.robots[:2, number] if number < robots else self.tasks[:2, number - robots]
        x, y = (float(np.uint32(each)) * half for each in places)
        kind, own = int(self.class_of[number]), int(self.hashes[number])
        if named:
            return Thing(number < robots, number if number < robots else number - robots, kind, own, x, y)
        x += setting.width / 2 if x < setting.width / 2 else -setting.width / 2
        return Thing(False, setting.task_ids - tasks + number - robots, kind, mark, x, y)

    def speak(self, liars: int) -> tuple[Any, int]:
        """Let each robot make a message, the first ones false ones; return the bits in C and in Python."""
        robots, tasks = self.setting.robots, self.setting.tasks
        self.clock.invented_robots, self.clock.invented_tasks = tasks, robots + 1
        says = [self.random.randrange(2) if i < liars else -1 for i in range(robots)]
        found = self._update(Action.SPEAK, [(i, lie, 0, 0) for i, lie in enumerate(says)])
        total = 0
        for i, (mind, lie) in enumerate(zip(self.minds, says, strict=True)):
            first, marks, number = (
                (robots, robots + tasks, tasks) if lie else (tasks, robots + 2 * tasks, robots + 1)
            )
            things = [Thing(lie == 1, first + k, 0, int(self.hashes[marks + k])) for k in range(number)]
            message: Any = self.messages[i]  # what `encode` doesn't write stays
            if self.strategy.encode:
                self.strategy.encode(message, mind.words, mind.me)
            else:
                message[:] = mind.words
            if lie >= 0:
                message[:] = mind.lie(message, lie, things)
            total += mind.bits(message)
        return found, total

    def merge(self, calls: int) -> Any:
        """Let robots hear each other."""
        given = [(*self.random.sample(range(self.setting.robots), 2), 0, 0) for _ in range(calls)]
        found = self._update(Action.MERGE, given)
        for i, sender, *_ in given:
            self.minds[i].merge(tuple(self.messages[sender]), sender)
        return found

    def count(self) -> tuple[Any, list[list[int]], list[list[int]]]:
        """Return what robots count, in C and in Python."""
        robots = range(self.setting.robots)
        found = self._update(Action.COUNT, [(i, 0, 0, 0) for i in robots])
        return (
            found,
            self.seen[: len(robots)].tolist(),
            [[*each.counted()[0], *each.counted()[1]] for each in self.minds],
        )

    def ask(self) -> tuple[Any, list[int], list[int]]:
        """Return what robots declare or judge, in C and in Python."""
        declares = self.strategy.declare is not None
        self.sets[self._row("NEUTRAL")] = 2**self.setting.robots - 1
        for row in ("FOR_FEASIBLE", "DECLARED", "FOR_FEASIBLE_DECLARED"):
            self.sets[self._row(row)] = 0
        found = self._update(Action.DECLARE if declares else Action.JUDGE, [(0, 0, 0, 0)])
        said = [each.declare() if declares else each.judge() for each in self.minds]
        neutral, feasible = (int(self.sets[self._row(each), 0]) for each in ("NEUTRAL", "FOR_FEASIBLE"))
        return found, [-1 if neutral >> i & 1 else feasible >> i & 1 for i in range(len(said))], said

    def fail(self, name: str) -> Any:
        """Call a function of robot 0 in C; return the failure."""
        actions = {
            "start": Action.START,
            "observe": Action.OBSERVE,
            "merge": Action.MERGE,
            "count": Action.COUNT,
        }
        actions |= {"bits": Action.SPEAK, "judge": Action.JUDGE}
        number = {"observe": 1, "merge": 1, "bits": -1}.get(name, 0)
        if name == "bits":
            self.knowledge[0, 2] ^= 1  # else its message and its length would stay
        return self._update(actions[name], [(0, number, 0, 0)])

    def fail_in_python(self, name: str) -> None:
        """Call a function of robot 0 in Python."""
        robot = self.minds[0]
        given: dict[str, Any] = {
            "start": lambda: self.strategy.start(robot.words, robot.me),
            "observe": lambda: robot.observe([self._thing(1, 0, 0)]),
            "merge": lambda: robot.merge(tuple(self.messages[1]), 1),
            "count": robot.counted,
            "bits": lambda: robot.bits(robot.message()),
            "judge": robot.judge,
        }
        given[name]()

    def known(self, i: int) -> list[int]:
        """Return the words that a robot knows in C."""
        length = self.state.copy_words
        return self.knowledge[0, i * length : (i + 1) * length].tolist()

    def assert_same(self) -> None:
        """Compare all that robots know, have sent and keep."""
        length = self.state.copy_words
        for i, mind in enumerate(self.minds):
            rows = [self.knowledge[copy, i * length :].tolist() for copy in range(2)]
            assert rows[0][: len(mind.words)] == list(mind.words), (i, mind.me)
            assert rows[1][: len(self.messages[i])] == list(self.messages[i]), (i, mind.me)
            assert repr(self.memory[i].tolist()) == repr([float(each) for each in mind.me.memory])
