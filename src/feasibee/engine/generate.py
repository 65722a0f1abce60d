"""Write C for the engine: the rules of strategies, translated from their Python when the package is built.

Standard library only, since pip builds the package without the packages that it needs when it runs.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from typing import Final

from feasibee.engine.checked import CheckedTranslation
from feasibee.engine.failing import RESULT, enumeration
from feasibee.errors import FeasibeeError
from feasibee.robot.definitions import Text
from feasibee.robot.language import ARGUMENTS, ENGINE, INT, LONG, NUMBERS, Signature
from feasibee.robot.translate import Translation
from feasibee.strategies import STRATEGIES, contract
from feasibee.strategies.contract import LIMITS, MUST, Strategy

RULES: Final = ("quality", "dissemination", "decide", "say", "value", "lasting", "probability")
"""The functions of ``struct rules``, in their order."""
ALWAYS: Final = RULES[:3]
"""Those that the engine always calls: without one in the file, the contract's."""
TYPES: Final = {rule: tuple(INT if each == LONG else each for each in ARGUMENTS[rule]) for rule in RULES}
"""Types of the arguments of a user's functions: whole numbers all have 64 bits."""
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


def own_strategy(file: str, source: str) -> str:
    """Return the library of a user's strategy that passes on opinions only, in C with Python's checks.

    Parameters
    ----------
    file : str
        What errors call the file.
    source : str
        Its text, which isn't run.

    Raises
    ------
    FeasibeeError
        If it has what the language of strategies doesn't have: line, what was met, what to write.
    """
    names, translation = Text(file, source), CheckedTranslation()
    translation.texts[file] = "own", source
    found = {rule: _own(rule, names, translation) for rule in RULES if rule in names or rule in ALWAYS}
    lines = {rule: names[rule].tree.lineno for rule in found if rule in names}
    checks = [_checked(file, rule, found[rule], line) for rule, line in lines.items()]
    table = {rule: f"{rule}_of_rules" if rule in lines else found[rule].name for rule in found}
    return "\n".join(
        [
            "/* A user's strategy, translated from Python by feasibee.engine.generate. */\n",
            enumeration(),
            '#include "checked.h"\n',
            *translation.structs(),
            *translation.functions,
            *checks,
            "static const struct rules own_rules = {",
            *(f"    .{rule} = {name}," for rule, name in table.items()),
            "};\n",
            "const struct rules *feasibee_rules(const char *name)",
            "{",
            "    (void)name;",
            "    return &own_rules;",
            "}",
            "",
        ]
    )


def _own(rule: str, names: Text, translation: CheckedTranslation) -> Signature:
    """Translate a function of a user's file, or the contract's."""
    usual = "modulated" if rule == "dissemination" and names.get("MODULATES") else rule
    try:
        return translation.function(names.get(rule) or getattr(contract, usual), TYPES[rule])
    except FeasibeeError as error:
        where, _, what = str(error).partition(": ")
        raise FeasibeeError(f"{where}: {rule} doesn't compile: {what}") from None


_DECLARED: Final = {
    "quality": ("double", "int64_t robots_seen, int64_t tasks_seen", "robots_seen, tasks_seen"),
    "dissemination": ("double", "double quality, double gain", "quality, gain"),
    "decide": ("int64_t", "struct mind *mind, const struct inbox *inbox", "mind, inbox"),
    "say": ("int64_t", "struct mind *mind", "mind"),
    "value": ("double", "struct mind *mind", "mind"),
    "lasting": ("double", "struct mind *mind, double gain", "mind, gain"),
    "probability": (
        "double",
        "struct mind *mind, const struct setting *setting",
        "mind, (struct feasibee_row){0}, setting",
    ),
}
"""By function: its result in ``struct rules``, its arguments, and those that its translation is given."""


def _checked(file: str, rule: str, signature: Signature, line: int) -> str:
    """Return a function of ``struct rules`` that calls a user's, and checks what it returns."""
    result, arguments, given = _DECLARED[rule]
    if signature.result not in NUMBERS:
        raise FeasibeeError(
            f"{file}, line {line}: {rule} doesn't compile: it returns no number; {MUST[rule]}"
        )
    called = f"{line}, {RESULT + RULES.index(rule)}, (double){signature.name}({given})"
    limits = f", {LIMITS[rule][0]}, {LIMITS[rule][1]}" if result == "double" else ""
    check = "feasibee_result" if result == "double" else "feasibee_opinion"
    return "\n".join(
        [
            f"static {result} {rule}_of_rules({arguments})",
            "{",
            f"    return {check}({called}{limits});",
            "}",
            "",
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
