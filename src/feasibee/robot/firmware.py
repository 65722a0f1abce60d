"""The controller in C99: one header for robots, made of the parts in `c/` and of translated strategies."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterable, Sequence
from importlib.metadata import version
from pathlib import Path

from feasibee.base.errors import FeasibeeError, quoted
from feasibee.robot.language import ARGUMENTS, Signature
from feasibee.robot.translate import Translation
from feasibee.robot.wire import name_of
from feasibee.strategies import STRATEGIES
from feasibee.strategies.contract import Strategy

__all__ = ["acting_header", "header"]

MOST_SENDERS = 65_535
"""Largest capacity of an inbox in C."""
FOLDER = Path(__file__).parent / "c"
_LOCAL_INCLUDE = re.compile(r'#include "(\w+\.h)"\n+')

_QUIETLY = """/* --- Translated from Python --- */

#ifdef __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#endif
"""
"""Python's numbers change their types without a word."""
_LOUDLY = """#ifdef __GNUC__
#pragma GCC diagnostic pop
#endif
"""


def header(
    strategy: str | Strategy | Sequence[str | Strategy] | None = None, inbox: int | None = None
) -> str:
    """Return the text of ``feasibee.h``.

    Parameters
    ----------
    strategy : str, Strategy or sequence of them, optional
        The strategies to include, by name or as they are; by default all built-in ones.
    inbox : int, optional
        Number of senders whose latest message a robot keeps; by default 64. A program may define
        ``FEASIBEE_INBOX`` before it includes the file.

    Raises
    ------
    FeasibeeError
        If there is no such strategy, it can't be translated, or the inbox is not from 1 to 65535.

    Examples
    --------
    >>> from feasibee.robot.firmware import header
    >>> "feasibee_dmmd" in header("dmmd", inbox=32)
    True
    """
    given = [strategy] if isinstance(strategy, str | Strategy) else list(strategy or STRATEGIES)
    chosen = list(dict.fromkeys(_strategy(each) for each in given))
    if inbox is not None and not 1 <= inbox <= MOST_SENDERS:
        raise FeasibeeError(f"inbox = {inbox}: must be from 1 to {MOST_SENDERS} senders; use 32")
    translation = Translation()
    constants = [_translated(each, translation) for each in chosen]
    made = [_QUIETLY, *translation.structs(), *translation.functions, *constants, _LOUDLY]
    text = "".join([_beginning(chosen, inbox), *_parts(), *(f"\n{each}" for each in made), "\n#endif\n"])
    _check_names(chosen, text)
    return text


def acting_header() -> str:
    """Return the text of ``acting.h``: the errand of a robot that acts, which needs no other file.

    Examples
    --------
    >>> from feasibee.robot.firmware import acting_header
    >>> "feasibee_choose_task" in acting_header()
    True
    """
    return (FOLDER / "acting.h").read_text(encoding="utf-8")


def _check_names(strategies: Sequence[Strategy], text: str) -> None:
    """Raise an error if a strategy's name in C is that of another one, or of a function of the controller."""
    for place, each in enumerate(strategies):
        name = constant(each)
        others = [other.name for other in strategies[:place] if constant(other) == name]
        if others or re.search(rf"\b{name}\(", text):
            owner = f"also {others[0]}" if others else "also a function of the controller"
            raise FeasibeeError(f"{each.name}: {name} in C is {owner}; give the file another name")


def constant(strategy: Strategy) -> str:
    """Return the name of a strategy in C."""
    stem = strategy.name.replace("\\", "/").rpartition("/")[2].removesuffix(".py")
    return f"feasibee_{re.sub(r'[^0-9A-Za-z]', '_', stem)}"


def _strategy(given: str | Strategy) -> Strategy:
    if isinstance(given, Strategy):
        return given
    if given not in STRATEGIES:
        raise FeasibeeError(f"strategy = {quoted(given)}: must be one of {', '.join(STRATEGIES)}")
    return STRATEGIES[given]


def _beginning(strategies: Sequence[Strategy], inbox: int | None) -> str:
    """Return the comment at the top, and the macros that the chosen strategies need."""
    macros = {} if inbox is None else {"FEASIBEE_INBOX": inbox}
    if not any(each.value_bits for each in strategies):
        macros["FEASIBEE_VALUES"] = 0
    macros["FEASIBEE_MEMORY"] = max(1, *(each.memory for each in strategies))
    macros["FEASIBEE_PARAMETERS"] = max(1, *(len(each.parameters) for each in strategies))
    names = ", ".join(Path(each.name).name for each in strategies)
    lines = [
        f"/* feasibee {version('feasibee')}: the controller of one robot of a swarm, in C99. Apache-2.0.",
        f" * Strategies: {names}. Written by `feasibee robot header`. */",
        "",
        "#ifndef FEASIBEE_H",
        "#define FEASIBEE_H",
        "",
    ]
    for macro, value in macros.items():
        lines += [f"#ifndef {macro}", f"#define {macro} {value}", "#endif"]
    return "\n".join(lines) + "\n"


def _parts() -> Iterable[str]:
    """Yield each part of the controller once, after the parts that it includes."""
    done: set[str] = set()

    def with_included(name: str) -> Iterable[str]:
        if name in done:
            return
        done.add(name)
        text = (FOLDER / name).read_text(encoding="utf-8")
        for included in _LOCAL_INCLUDE.findall(text):
            yield from with_included(included)
        yield "\n" + _LOCAL_INCLUDE.sub("", text)

    for name in ("controller.h", "phases.h", "wire.h"):
        yield from with_included(name)


# --- Translated strategies ---


def needs_double(strategy: Strategy) -> bool:
    """Whether a strategy exists in C with ``FEASIBEE_DOUBLE`` only."""
    return _needs_double(functions(strategy, Translation()))


def functions(strategy: Strategy, translation: Translation) -> dict[str, Signature]:
    """Translate a strategy's functions; return each by its name in Python."""
    skipped = {"probability"} | ({"pack", "unpack"} if "layout" in strategy.functions else set())
    try:
        return {
            each: translation.entry(
                each, inspect.unwrap(getattr(strategy, each)), constant(strategy), strategy.source
            )
            for each in ARGUMENTS
            if each in strategy.functions - skipped
        }
    except FeasibeeError as error:  # which begins with the file's name
        folder = strategy.name[: -len(Path(strategy.name).name)]
        raise FeasibeeError(f"{folder}{error}") from None


def _needs_double(found: dict[str, Signature]) -> bool:
    needs = any(each.needs.position or each.needs.floating for each in found.values())
    return needs or not found.keys().isdisjoint({"quality", "dissemination", "value"})


def _translated(strategy: Strategy, translation: Translation) -> str:
    """Translate a strategy's functions; return its constants in C."""
    name, found = constant(strategy), functions(strategy, translation)
    glue = [*_ratings(strategy, found), *_knowledge(strategy, found)]
    glue += [
        f"static const struct feasibee_strategy {name} = {{",
        f"    {_flag(strategy.forgets)}, {_flag(strategy.starts_neutral)}, {strategy.value_bits}, "
        f"{_flag(strategy.modulates)},",
        f"    {f'{name}_rated' if 'quality' in found else 'feasibee_share_of_robots'},",
        f"    {f'{name}_says' if 'say' in found else 'NULL'},",
        f"    {f'{name}_sends' if _sends(strategy, found) else 'NULL'},",
        f"    {f'{name}_lasts' if _lasts(found) else 'NULL'}, {name}_decides,",
        f"    {f'&{name}_knowledge' if strategy.knowledge else 'NULL'},",
        "};",
    ]
    conditions = [
        *(["FEASIBEE_WORDS > 0"] if strategy.knowledge else []),
        *(["defined(FEASIBEE_DOUBLE)"] if _needs_double(found) else []),
    ]
    if conditions:
        glue = [f"#if {' && '.join(conditions)}", "", *glue, "", "#endif"]
    return "\n".join([*_said(strategy), *_own(strategy, name), *glue, ""])


def _own(strategy: Strategy, name: str) -> Iterable[str]:
    """Yield macros: the name of a user's strategy in frames, and a strategy's parameters by default."""
    parameters = ", ".join(f"FEASIBEE_REAL({value!r})" for value in strategy.parameters.values())
    if strategy.source:
        yield f'#define {name}_name "{name_of(strategy)}" /* for feasibee_wire_of */'
    if strategy.source or parameters:
        yield f"#define {name}_parameters {{{parameters or 0}}} /* for struct feasibee_setting */"
        yield ""


def _said(strategy: Strategy) -> Iterable[str]:
    """Yield the docstring of a user's file as a comment; those of built-in ones are in the documentation."""
    told = ast.get_docstring(ast.parse(strategy.source))
    if told:
        yield from ("/* " + told.replace("*/", "* /").replace("\n", "\n * ") + " */", "")


def _flag(flag: bool) -> str:
    return "true" if flag else "false"


def _lasts(found: dict[str, Signature]) -> str:
    """Return for how long a robot broadcasts, in steps, "" if that is its gain."""
    gain = "(feasibee_real)robot->settings->gain / (feasibee_real)FEASIBEE_STEP"
    if "lasting" in found:
        return f"{found['lasting'].name}(robot, {gain})"
    if "dissemination" in found:
        return f"{found['dissemination'].name}(feasibee_own_quality(robot), {gain})"
    return ""


def _sends(strategy: Strategy, found: dict[str, Signature]) -> bool:
    """Whether a strategy has a rule of its own for the value in its messages."""
    return strategy.value_bits > 0 and "value" in found


def _ratings(strategy: Strategy, found: dict[str, Signature]) -> Iterable[str]:
    """Yield the functions that rate, broadcast and choose opinions, as the controller calls them."""
    name, robot = constant(strategy), "struct feasibee_robot *robot"

    def function(result: str, what: str, arguments: str, value: str) -> list[str]:
        return [f"static {result} {name}_{what}({arguments})", "{", f"    return {value};", "}", ""]

    if "quality" in found:
        rated = f"feasibee_whole_of({found['quality'].name}((int64_t)robots, (int64_t)tasks))"
        yield from function(
            "struct feasibee_ratio", "rated", "feasibee_amount robots, feasibee_amount tasks", rated
        )
    if "say" in found:
        yield from function("int8_t", "says", robot, f"feasibee_opinion({found['say'].name}(robot))")
    if _sends(strategy, found):
        value = f"feasibee_sent({found['value'].name}(robot), {strategy.value_bits})"
        yield from function("uint16_t", "sends", robot, value)
    if _lasts(found):
        lasts = f"(feasibee_steps)(({_lasts(found)}) * FEASIBEE_REAL(FEASIBEE_STEP))"
        yield from function("feasibee_steps", "lasts", robot, lasts)
    votes = f"{robot}, const struct feasibee_votes *votes"
    decided = f"feasibee_opinion({found['decide'].name}(robot, votes))"
    yield from function("int8_t", "decides", votes, decided)


def _knowledge(strategy: Strategy, found: dict[str, Signature]) -> Iterable[str]:
    """Yield the table of the functions for knowledge."""
    if not strategy.knowledge:
        return
    name = constant(strategy)
    if "pack" in found:
        yield from _both_ways(name, found)
    laid = found["layout"].name if "layout" in found else f"{name}_layout" if "pack" in found else ""
    table = [found[each].name if each in found else "NULL" for each in _TABLE]
    yield from (
        f"static const struct feasibee_knowledge {name}_knowledge = {{",
        f"    {len(strategy.parameters)}, {_flag(strategy.by_name)}, {_flag(bool(laid))},",
        *(f"    {each}," for each in [*table, f"FEASIBEE_LAYOUT({laid or 'feasibee_as_they_are'})"]),
        "};",
        "",
    )


_TABLE = ("words", "message_words", "start", "observe", "encode", "merge", "count", "declare", "judge")
"""The functions of ``struct feasibee_knowledge``, in their order."""


def _both_ways(name: str, found: dict[str, Signature]) -> Iterable[str]:
    """Yield the one function that a robot has for ``pack`` and ``unpack``."""
    yield from (
        f"static feasibee_int {name}_layout(struct feasibee_layout *wire, struct feasibee_row message,",
        "    feasibee_int sender, const struct feasibee_setting *setting)",
        "{",
        "    if (wire->reader)",
        f"        return {found['unpack'].name}(message, wire->reader, setting);",
        f"    {found['pack'].name}(wire->writer, message, sender, setting);",
        "    return -1;",
        "}",
        "",
    )
