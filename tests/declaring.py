"""A strategy whose robots declare, for tests: the roll call of the examples, and a time without news."""

from __future__ import annotations

from pathlib import Path

from feasibee import Scenario

DECLARE = '''

PARAMETERS = {"quiet": 25.0}
MEMORY = 2


def declare(known, me):
    """Declare by what is known as soon as nothing new was heard of for some steps."""
    robots = 0
    tasks = 0
    for k in range(len(known)):
        if k < me.setting.robot_ids:
            robots += known[k]
        else:
            tasks += known[k]
    if robots + tasks != me.memory[0]:
        me.memory[0] = robots + tasks
        me.memory[1] = me.step
    if me.step - me.memory[1] < me.setting.parameters[0]:
        return -1
    return 1 if robots >= tasks else 0
'''


def declaring(folder, quiet=60.0, **sections):
    """Return a scenario whose robots declare after a number of steps without news, by a file of its own."""
    path = folder / "quiet.py"
    example = Path(__file__).parents[1] / "examples" / "strategies" / "roll_call.py"
    path.write_text(example.read_text(encoding="utf-8") + DECLARE, encoding="utf-8")
    decision = {"strategy": str(path), "parameters": {"quiet": quiet}}
    return Scenario(decision=decision, **sections)
