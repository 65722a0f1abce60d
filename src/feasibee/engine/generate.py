"""Write C for the engine: the rules of strategies, translated from their Python when the package is built.

Standard library only, since pip builds the package without the packages that it needs when it runs.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterable, Mapping
from typing import Any, Final

from feasibee.base.codes import BITS_LIMIT, COUNT_LIMIT
from feasibee.base.errors import FeasibeeError
from feasibee.engine.checked import OWN, CheckedTranslation
from feasibee.engine.failing import RESULT, enumeration
from feasibee.robot.definitions import Definition, Text
from feasibee.robot.language import (
    ARGUMENTS,
    COUNTS,
    ENGINE,
    INT,
    LONG,
    MESSAGE,
    NUMBERS,
    REAL,
    RESULTS,
    ROW,
    VOID,
    Signature,
    Type,
)
from feasibee.robot.translate import Translation
from feasibee.strategies import GOSSIP, STRATEGIES, contract
from feasibee.strategies.contract import LIMITS, MUST, Strategy

RULES: Final = ("quality", "dissemination", "decide", "say", "value", "lasting", "probability")
"""The functions of ``struct rules``, in their order."""
ALWAYS: Final = RULES[:3]
"""Those that the engine always calls: without one in the file, the contract's."""
KNOWLEDGE: Final = ("start", "observe", "encode", "lie", "merge", "count", "bits", "declare", "judge")
"""The functions of knowledge that the engine calls, inlined into update.h."""
RETURNING: Final = (*RULES, "count", "bits", "declare", "judge")
"""The functions whose results are checked, as failures number them."""
TYPES: Final[Mapping[str, tuple[Type, ...]]] = {
    **{name: tuple(INT if each == LONG else each for each in kinds) for name, kinds in ARGUMENTS.items()},
    "probability": ("mind", MESSAGE, "setting"),
    "merge": (ROW, MESSAGE, INT, "me"),
    "count": (MESSAGE, COUNTS, "me"),
    "bits": (MESSAGE, "me"),
}
"""Types of the arguments of a user's functions: whole numbers all have 64 bits."""
SIZES: Final = ("words", "message_words")
"""Functions of knowledge that only pages call: elsewhere, Python does before a run."""
STEADY: Final = ("id", "kind", "hash", "setting")
"""What of a robot never changes in a run."""
_QUIETLY: Final = """#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wunused-function"
"""
"""Python's numbers change their types without a word."""
_LOUDLY: Final = "#pragma GCC diagnostic pop\n"


def built_in_strategies() -> str:
    """Return ``strategies.c``: the functions of all built-in strategies.

    Examples
    --------
    >>> from feasibee.engine.generate import built_in_strategies
    >>> "feasibee_dmmd_decide" in built_in_strategies()
    True
    """
    translation = Translation(ENGINE)
    tables = {each.name: _built_in(each, translation) for each in (*STRATEGIES.values(), GOSSIP)}
    return "\n".join(
        [
            "/* The built-in strategies, translated from Python by feasibee.engine.generate. */\n",
            '#include "unchecked.h"\n',
            _QUIETLY,
            *translation.structs(),
            *translation.functions,
            *tables.values(),
            *_found_by_name(tables),
            _LOUDLY,
        ]
    )


def _built_in(strategy: Strategy, translation: Translation) -> str:
    """Translate the functions of a strategy; return its part of update.h and its ``struct rules``."""
    names: dict[str, str] = {
        each: translation.entry(each, inspect.unwrap(getattr(strategy, each))).name
        for each in (*RULES, *KNOWLEDGE, *SIZES)
        if each in strategy.functions or each in ALWAYS
    }
    prefix = constant(strategy.name)
    if not strategy.knowledge:
        return _rules(prefix, names)
    bits: Any = strategy.bits
    repeats = "encode" not in names and is_steady(translation.definition(bits))
    return _update(prefix, names, repeats, len(strategy.parameters)) + _rules(prefix, names, prefix)


def own_strategy(file: str, source: str, *, pages: bool = False) -> str:
    """Return the library of a user's strategy, in C with Python's checks.

    Parameters
    ----------
    file : str
        What errors call the file.
    source : str
        Its text, which isn't run.
    pages : bool
        Whether it is for pages, which also call `SIZES`.

    Raises
    ------
    FeasibeeError
        If it has what the language of strategies doesn't have: line, what was met, what to write.
    """
    names, translation = Text(file, source), CheckedTranslation()
    translation.texts[file] = "own", source
    table, checks = _own_functions(file, names, translation, SIZES if pages else ())
    knows = "merge" in names
    repeats = knows and "encode" not in names and is_steady(names["bits"])
    return "\n".join(
        [
            "/* A user's strategy, translated from Python by feasibee.engine.generate. */\n",
            enumeration(),
            '#include "checked.h"\n',
            *translation.structs(),
            *translation.functions,
            *checks,
            _update("rules", table, repeats) if knows else "",
            _rules("own", table, "rules" if knows else ""),
            "const struct rules *feasibee_rules(const char *name)",
            "{",
            "    (void)name;",
            "    return &own_rules;",
            "}",
            "",
        ]
    )


def _own_functions(
    file: str, names: Text, translation: CheckedTranslation, more: tuple[str, ...]
) -> tuple[dict[str, str], list[str]]:
    """Translate a user's functions, ``more`` of those for knowledge, and what the file lacks of the contract.

    Return their names in C by those of the contract, and the functions that check what they return.
    """
    wanted = (*RULES, *KNOWLEDGE, *more) if "merge" in names else RULES
    found = {each: _own(each, names, translation) for each in wanted if each in names or each in ALWAYS}
    lines = {each: names[each].tree.lineno for each in found if each in names}
    checks = [_checked(file, each, found[each], line) for each, line in lines.items()]
    checked = lines.keys() & set(RETURNING)
    table = {each: f"{each}_of_rules" if each in checked else found[each].name for each in found}
    return table, checks


def _own(name: str, names: Text, translation: CheckedTranslation) -> Signature:
    """Translate a function of a user's file, or the contract's."""
    usual = "modulated" if name == "dissemination" and names.get("MODULATES") else name
    try:
        return translation.function(names.get(name) or getattr(contract, usual), TYPES[name])
    except FeasibeeError as error:
        where, _, what = str(error).partition(": ")
        raise FeasibeeError(f"{where}: {name} doesn't compile: {what}") from None


_TYPES: Final[Mapping[Type | None, str]] = {None: "int64_t", INT: "int64_t", REAL: "double"}
"""Types of numbers as engine.h writes them; a result of no other type is whole."""


def _declared(name: str) -> tuple[str, str, str]:
    """Return a function's result and arguments in C, and what its translation is given of them."""
    names = ["known" if each == "message" else each for each in contract.ARGUMENTS[name]]
    kinds = (_TYPES.get(kind) or OWN.text_of(kind) for kind in TYPES[name])
    written = (f"{kind} {each}".replace("* ", "*") for kind, each in zip(kinds, names, strict=True))
    result = RESULTS.get(name)
    return _TYPES.get(result) or str(result), ", ".join(written), ", ".join(names)


def _checked(file: str, name: str, signature: Signature, line: int) -> str:
    """Return a function that calls a user's, and checks what it returns; nothing if there is nothing."""
    told = _mistake(name, signature)
    if told:
        raise FeasibeeError(f"{file}, line {line}: {name} doesn't compile: {told}")
    if name not in RETURNING:
        return ""
    result, arguments, given = _declared(name)
    called, where = f"{signature.name}({given})", f"{line}, {RESULT + RETURNING.index(name)}"
    if name == "count":
        body = [
            f"    {called};",
            "    for (int64_t k = 0; k < counts.length; k++)",
            f"        feasibee_whole_result({where}, counts.numbers[k], {COUNT_LIMIT});",
        ]
    elif name == "bits":
        body = [f"    return feasibee_whole_result({where}, {called}, {BITS_LIMIT});"]
    elif result == "double":
        least, most = LIMITS[name]
        body = [f"    return feasibee_result({where}, (double){called}, {least}, {most});"]
    else:
        body = [f"    return feasibee_opinion({where}, (double){called});"]
    return "\n".join([f"static {result} {name}_of_rules({arguments})", "{", *body, "}", ""])


def _mistake(name: str, signature: Signature) -> str:
    """Return what is wrong with the type of a function's result, if anything."""
    if name in RULES:
        return "" if signature.result in NUMBERS else f"it returns no number; {MUST[name]}"
    if RESULTS.get(name) == VOID:
        return "" if signature.result == VOID else "it must return nothing, whatever it is given"
    return "" if signature.result == INT else "it must return a whole number, whatever it is given"


def is_steady(bits: Definition) -> bool:
    """Return whether the length of a message depends on the message only; in doubt, not."""
    me, nodes = bits.arguments[1], list(ast.walk(bits.tree))
    met = sum(isinstance(each, ast.Name) and each.id == me for each in nodes)
    read = sum(
        isinstance(each, ast.Attribute)
        and isinstance(each.value, ast.Name)
        and each.value.id == me
        and each.attr in STEADY
        for each in nodes
    )
    return met == read


def _update(prefix: str, names: Mapping[str, str], repeats: bool, parameters: int | None = None) -> str:
    """Return a copy of update.h for the functions of a strategy."""
    functions = {each: names[each] for each in KNOWLEDGE if each in names}
    return "\n".join(
        [
            f"#define PART(name) {prefix}_##name",
            *([f"#define PARAMETERS {parameters}"] if parameters is not None else []),
            *(["#define REPEATS"] if repeats else []),
            *(f"#define {each.upper()}_BY {name}" for each, name in functions.items()),
            '#include "update.h"\n\n',
        ]
    )


def _rules(prefix: str, names: Mapping[str, str], updates: str = "") -> str:
    """Return the definition of a strategy's ``struct rules``."""
    rules = {each: names[each] for each in (*RULES, *SIZES) if each in names}
    rules |= {"update": f"{updates}_update"} if updates else {}
    return "\n".join(
        [
            f"static const struct rules {prefix}_rules = {{",
            *(f"    .{each} = {name}," for each, name in rules.items()),
            "};\n",
        ]
    )


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
        alone = name == GOSSIP.name  # it times how names flood a place: no page shows it
        yield from ("#ifndef __wasm__",) * alone
        yield from (f'    if (is(name, "{name}"))', f"        return &{constant(name)}_rules;")
        yield from ("#endif",) * alone
    yield from ("    return 0;", "}", "")
