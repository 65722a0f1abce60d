"""The C on docs/deploying.md compiles, and declares by the rule of the scenario there."""

from __future__ import annotations

import re

from feasibee import Scenario
from feasibee.robot.firmware import header
from tests.robot import boards

ROOT = boards.SOURCES.parents[2]


def test_the_settings_on_the_page_are_those_of_the_scenario(tmp_path):
    page = (ROOT / "docs" / "deploying.md").read_text()
    (settings,) = re.findall(r"```c\n(.*?)```", page, re.DOTALL)
    values = (
        "settings.declare.rounds, settings.declare.heard, settings.declare.quorum, settings.declare.quorum_of"
    )
    program = f"""#include "feasibee.h"
#include <stdio.h>
int main(void)
{{
    {settings}
    printf("%d %d %d/%d", {values});
    return 0;
}}
"""
    boards.needs("cc", "gcc")
    (tmp_path / "feasibee.h").write_text(header("average", inbox=40))
    (tmp_path / "program.c").write_text(program)
    boards.run(
        [
            "cc",
            "-std=c99",
            "-Wall",
            "-Werror",
            str(tmp_path / "program.c"),
            "-lm",
            "-o",
            str(tmp_path / "run"),
        ]
    )
    rule = Scenario().replace({"decision.declare.quorum": 0.9}).decision.declare
    assert boards.run([str(tmp_path / "run")]) == f"{rule.rounds} {rule.heard} 9/10"
    assert rule.quorum == 0.9
