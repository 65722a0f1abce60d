"""Write C for the engine: the rules of strategies, translated from their Python when the package is built.

Standard library only, since pip builds the package without the packages that it needs when it runs.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from typing import Final

from feasibee.robot.language import ENGINE, Signature
from feasibee.robot.translate import Translation
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Strategy

RULES: Final = ("quality", "dissemination", "decide", "say", "value", "lasting", "probability")
"""The functions of ``struct rules``, in their order."""
ALWAYS: Final = RULES[:3]
"""Those that the engine always calls: without one in the file, the contract's."""
_QUIETLY: Final = """#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wunused-function"
"""
"""Python's numbers change their types without a word."""
_LOUDLY: Final = "#pragma GCC diagnostic pop\n"


def built_in_strategies() -> str:
    """Return ``strategies.c``: the rules of all built-in strategies that pass on opinions only.

    Examples
    --------
    >>> from feasibee.engine.generate import built_in_strategies
    >>> "feasibee_dmmd_decide" in built_in_strategies()
    True
    """
    translation = Translation(ENGINE)
    tables = {
        name: rules_of(name, _translated(strategy, translation))
        for name, strategy in STRATEGIES.items()
        if not strategy.knowledge
    }
    return "\n".join(
        [
            "/* The rules of the built-in strategies, by feasibee.engine.generate from their Python. */\n",
            '#include "translated.h"\n',
            _QUIETLY,
            *translation.structs(),
            *translation.functions,
            *tables.values(),
            *_found_by_name(tables),
            _LOUDLY,
        ]
    )


def _translated(strategy: Strategy, translation: Translation) -> dict[str, Signature]:
    """Translate the rules of a strategy; return each by its name in Python."""
    return {
        rule: translation.entry(rule, inspect.unwrap(getattr(strategy, rule)))
        for rule in RULES
        if rule in strategy.functions or rule in ALWAYS
    }


def rules_of(name: str, found: dict[str, Signature]) -> str:
    """Return the definition of a strategy's ``struct rules``."""
    table = constant(name)
    lines = []
    if "probability" in found:  # without knowledge, none is known
        lines += [
            f"static double {table}_probability(struct mind *mind, const struct setting *setting)",
            "{",
            f"    return {found['probability'].name}(mind, (struct feasibee_row){{0}}, setting);",
            "}",
            "",
        ]
    names = {rule: signature.name for rule, signature in found.items()}
    names |= {"probability": f"{table}_probability"} if "probability" in found else {}
    lines += [
        f"static const struct rules {table}_rules = {{",
        *(f"    .{rule} = {name}," for rule, name in names.items()),
        "};",
        "",
    ]
    return "\n".join(lines)


def constant(name: str) -> str:
    """Return what the names of a built-in strategy begin with in C."""
    return name.replace("-", "_")


def _found_by_name(names: Iterable[str]) -> Iterable[str]:
    """Yield the function that returns the rules of a strategy."""
    yield from (
        "static int is(const char *name, const char *other)",
        "{",
        "    for (; *name == *other; name++, other++)",
        "        if (*name == 0)",
        "            return 1;",
        "    return 0;",
        "}",
        "",
        "const struct rules *feasibee_rules(const char *name)",
        "{",
    )
    for name in names:
        yield from (f'    if (is(name, "{name}"))', f"        return &{constant(name)}_rules;")
    yield from ("    return 0;", "}", "")
