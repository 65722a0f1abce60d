"""Pages on robots: their programs run, their lists are complete; and users' files may define bytes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from feasibee import FeasibeeError, Scenario
from feasibee.robot import Message, Wire, WireError
from feasibee.robot.firmware import constant, header
from feasibee.robot.sizes import setting_in_c
from feasibee.robot.wire import name_of
from feasibee.scenario.plugins import load
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES
from tests.robot.driving import HERE, SANITIZED, built, run

ROOT = Path(__file__).parents[2]


def page(name):
    return (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")


def blocks_of(language, name="wire"):
    """Return the blocks of code on a page."""
    return re.findall(rf"```{language}\n(.*?)```", page(name), re.DOTALL)


BYTES = "\n\n" + next(block for block in blocks_of("python") if block.startswith("def pack"))


def roll_call(tmp_path, text):
    """Return the strategy of the docs with more functions."""
    path = tmp_path / "mine.py"
    path.write_text((ROOT / "examples" / "strategies" / "roll_call.py").read_text() + text)
    return load(str(path))


@pytest.mark.parametrize(
    ("text", "message", "bits", "sender"),
    [
        ("", Message(1, knowledge=(1, 0, 1, 0, -5)), 2 + 1 + 5 * 32, 2),
        (BYTES, Message(-1, knowledge=(1, 0, 1, 0, 1)), 2 * 3 + 33 + 2, -1),
    ],
    ids=["plain words", "packed"],
)
def test_a_users_pack_makes_frames_exact(text, message, bits, sender, tmp_path):
    wire = Wire(roll_call(tmp_path, text), 2, setting=setting_from((3, 2), (0, 0), False, None, ()))
    assert wire.is_exact == bool(text)
    assert wire.bits(2, message) == bits
    assert wire.decode(wire.encode(2, message)) == (sender, message)
    with pytest.raises(WireError):
        wire.decode(wire.encode(2, message)[:-1])


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (
            BYTES.replace("32)", "16)"),
            "mine.py: pack writes .* bits of .*, and bits returns .*; they must be equal",
        ),
        (
            BYTES.replace("= 1\n", "= 2\n"),
            "mine.py: unpack reads .* from what pack wrote of .*; they must be equal",
        ),
        (BYTES.replace("return -1", "return -2"), "unpack.* returns -2; must be the sender's id, or -1"),
        (BYTES.replace("range(len(message))", "range(len(message) + 1)"), "pack.* fails: IndexError"),
        (BYTES[: BYTES.index("def unpack")], "has pack, but no function unpack; write def unpack"),
        (BYTES[BYTES.index("def unpack") :], "has unpack, but no function pack; write def pack"),
    ],
)
def test_a_users_pack_is_tried(tmp_path, text, why):
    with pytest.raises(FeasibeeError, match=why):
        roll_call(tmp_path, text)


IN_C = """#define FEASIBEE_WORDS 5
#include "feasibee.h"
#include <stdio.h>
{setting}
int main(void)
{{
    struct feasibee_settings settings = feasibee_defaults(&{strategy});
    settings.setting = &setting;
    struct feasibee_wire wire = feasibee_wire_of(&settings, "{name}", 2);
    struct feasibee_message message = {{FEASIBEE_FEASIBLE, false, 0, {{1, 0, 1, 0, 1}}}}, heard;
    uint8_t frame[64];
    feasibee_id sender;
    size_t length = feasibee_encode(&wire, 2, &message, frame, sizeof frame);
    for (size_t k = 0; k < length; k++)
        printf("%02x", frame[k]);
    if (!feasibee_decode(&wire, frame, length, &sender, &heard))
        return 1;
    for (int k = 0; k < FEASIBEE_WORDS; k++)
        printf(" %d", (int)heard.words[k]);
    frame[4] ^= 1;
    return feasibee_decode(&wire, frame, length, &sender, &heard);
}}
"""


def test_a_users_pack_writes_the_same_bytes_in_c(tmp_path):
    strategy = roll_call(tmp_path, BYTES)
    setting = setting_from((3, 2), (0, 0), False, None, ())
    frame = Wire(strategy, 2, setting=setting).encode(2, Message(1, knowledge=(1, 0, 1, 0, 1)))
    names = {"strategy": constant(strategy), "name": name_of(strategy)}
    code = IN_C.format(setting=setting_in_c(setting), **names)
    assert run([built(tmp_path, code, header(strategy), *SANITIZED)]) == f"{frame.hex()} 1 0 1 0 1"


# --- The page ---


def test_the_programs_on_the_page_print_what_it_says(capsys):
    for block in blocks_of("python"):
        if "print(" in block:
            exec(compile(block, "wire.md", "exec"), {})
    assert capsys.readouterr().out.splitlines() == ["01 3c 30 3c 44 a0 ee f9", "(7, 1)"]


def test_the_program_on_bytes_runs(tmp_path):
    run([built(tmp_path, blocks_of("c")[0], header())])


def test_the_program_of_a_controller_runs(tmp_path):
    (code,) = blocks_of("c", "firmware")
    program = built(tmp_path, code, header("dmmd", inbox=32), HERE / "stubs.c", *SANITIZED)
    broadcasts, feasible = (int(number) for number in re.findall(r"\d+", run([program])))
    assert 200 < broadcasts < 800
    assert feasible > 900


def test_the_settings_of_a_deployed_robot_are_those_of_its_scenario(tmp_path):
    (settings,) = blocks_of("c", "deploying")
    rule = "settings.declare"
    values = f"{rule}.rounds, {rule}.heard, {rule}.quorum, {rule}.quorum_of"
    code = f"""#include "feasibee.h"
#include <stdio.h>
int main(void)
{{
    {settings}
    printf("%d %d %d/%d", {values});
    return 0;
}}
"""
    declare = Scenario().replace({"decision.declare.quorum": 0.9}).decision.declare
    said = run([built(tmp_path, code, header("dc", inbox=40))])
    assert said == f"{declare.rounds} {declare.heard} 9/10"
    assert declare.quorum == 0.9


def test_the_page_of_the_controller_names_all_strategies():
    text = page("firmware")
    assert all(f"`{name}`" in text for name in STRATEGIES)


def test_the_page_lists_the_layout_of_each_strategy():
    layouts = next(block for block in blocks_of("text") if "census" in block)
    with_knowledge = {name for name in STRATEGIES if STRATEGIES[name].knowledge}
    assert {line.split()[0] for line in layouts.splitlines() if line[0] != " "} == with_knowledge
