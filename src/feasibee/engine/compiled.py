"""Runs of the general engine: numba compiles its functions and those of a strategy."""

from __future__ import annotations

import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from numba import types
from numba.core.errors import NumbaError

from feasibee.engine import acting, dynamics, entrypoints
from feasibee.engine.compile import careful, entry, helpers_of, inlined, reads_only, with_helpers
from feasibee.engine.guards import GUARDS, guarded
from feasibee.engine.knowledge import built_in, update_nothing, updating
from feasibee.engine.layout import (
    Clock,
    Control,
    Functions,
    Lack,
    Lowered,
    Outcome,
    Player,
    Room,
    RunError,
    State,
    empty_state,
    first_room,
)
from feasibee.engine.params import Params, packed
from feasibee.engine.signatures import KNOWLEDGE, STRATEGY
from feasibee.engine.team import parts_of
from feasibee.errors import FeasibeeError
from feasibee.model.record import Record
from feasibee.strategies.contract import Strategy

FAILURES = (ArithmeticError, LookupError, TypeError, ValueError)
"""Exceptions that a user's strategy may raise."""


class Engine(NamedTuple):
    """The compiled functions for a scenario: start a run, advance it, and those of its strategy."""

    start: Callable[..., Any]
    advance: Callable[..., Any]
    functions: Functions


def engine_functions(strategy: Strategy, words: int, changes: bool = False, acts: bool = False) -> Engine:
    """Compile the functions that start and advance a run, and those that a scenario chooses."""
    start, advance = entrypoints.world_functions(words)
    functions = strategy_functions(strategy)._replace(change=change_function(changes), act=act_function(acts))
    return Engine(start, advance, functions)


@cache
def change_function(changes: bool) -> Callable[..., Any]:
    """Compile what changes the world before each step."""
    return entry(STRATEGY.change, in_python=False)(dynamics.change_world if changes else dynamics.stay)


@cache
def act_function(acts: bool) -> Callable[..., Any]:
    """Compile what robots that act do at the moments of a step."""
    return entry(STRATEGY.act, in_python=False)(acting.act if acts else acting.rest)


@cache
def strategy_functions(strategy: Strategy) -> Functions:
    """Compile the functions of a strategy; the kernels take them as typed function pointers."""
    compiled = {name: _compiled(strategy, name) for name in GUARDS}
    return Functions(**compiled, update=_update_of(strategy), change=None, act=None)


def _update_of(strategy: Strategy) -> Callable[..., Any]:
    """Compile `feasibee.engine.knowledge.update` with a strategy's functions in it."""
    if not strategy.knowledge:
        return entry(STRATEGY.update, in_python=False)(update_nothing)
    functions = {name: _for_update(strategy, name) for name in KNOWLEDGE.keys() & strategy.functions}
    passing = {} if strategy.source else built_in(len(strategy.parameters))
    function = updating(functions, _is_steady(strategy), passing)
    return entry(STRATEGY.update, _text_of(strategy), in_python=False)(function)


def _for_update(strategy: Strategy, name: str) -> Callable[..., Any]:
    """Compile a function of a strategy's knowledge, which `update` calls."""
    own, signature = _own_function(strategy, name), KNOWLEDGE[name]
    if not strategy.source:
        return inlined(with_helpers(own, inlined))
    try:
        compiled: Any = careful(with_helpers(own, careful), signature.args)
    except NumbaError as error:
        raise FeasibeeError(_explained(strategy, name, error)) from None
    (returned,) = (each.return_type for each in compiled.nopython_signatures)
    number = isinstance(signature.return_type, types.Integer)
    if not (returned == signature.return_type or (number and isinstance(returned, types.Integer))):
        must = "a whole number" if number else "nothing"
        line = own.__code__.co_firstlineno
        rule = f"{name} doesn't compile: it must return {must}, whatever it is given"
        raise FeasibeeError(f"{strategy.name}, line {line}: {rule}")
    function: Callable[..., Any] = compiled
    return function


def _is_steady(strategy: Strategy) -> bool:
    """Return whether ``bits`` reads nothing of a robot that changes in a run; in doubt, not."""
    return reads_only(_own_function(strategy, "bits"), "me", ("id", "kind", "hash", "setting"))


def _text_of(strategy: Strategy) -> str:
    """Return the text of the files that a strategy's functions come from.

    A built-in strategy's begins with its name: a user's copy of the file has compiled code of its own. Its
    functions' bytes follow, since a file may have changed after this process has imported it.
    """
    if strategy.source:
        return strategy.source
    functions = [getattr(strategy, name) for name in sorted(strategy.functions)]
    for each in functions:  # helpers join the list, and their own helpers after them
        functions += [helper for helper in helpers_of(each).values() if helper not in functions]
    files = dict.fromkeys(each.__code__.co_filename for each in functions)
    loaded = "".join(each.__code__.co_code.hex() for each in functions)
    return f"{strategy.name}\n{loaded}\n" + "".join(Path(file).read_text(encoding="utf-8") for file in files)


def _compiled(strategy: Strategy, name: str) -> Callable[..., Any]:
    function, signature = getattr(strategy, name), getattr(STRATEGY, name)
    own = _own_function(strategy, name)
    if own is function:
        return entry(signature, in_python=False)(with_helpers(function, inlined))
    try:
        checked = guarded(name, careful(with_helpers(own, careful)))
        return entry(signature, strategy.source, in_python=False)(checked)
    except NumbaError as error:
        raise FeasibeeError(_explained(strategy, name, error)) from None


def _own_function(strategy: Strategy, name: str) -> Callable[..., Any]:
    """Return a function as the user wrote it, without the check that wraps it for calls from Python."""
    function: Callable[..., Any] = getattr(strategy, name)
    return getattr(function, "__wrapped__", function)


def _explained(strategy: Strategy, name: str, error: Exception) -> str:
    """Return a message that says what doesn't compile, and in which line: the translator's, if it has one."""
    from feasibee.robot.translate import Translation

    function: Any = _own_function(strategy, name)
    try:
        Translation().entry(name, function, strategy.source)
    except FeasibeeError as told:
        before, _, what = str(told).partition(": ")
        return f"{strategy.name},{before.partition(',')[2]}: {name} doesn't compile: {what}"
    text = re.sub(r"\x1b\[[0-9;]*m", "", str(error))
    lines = [line.strip(" -") for line in text.splitlines() if line.strip(" -")]
    file = re.escape(Path(function.__code__.co_filename).name)
    place = re.search(rf'{file}(?:", line |:| \()(\d+)', text)
    empty = ("Failed in", "File", "During", "Resolution failure", "No implementation of function")
    what = next((line for line in lines if not line.startswith(empty)), lines[0])
    if "NRT required" in what:
        what = "it must not make lists, tuples of unknown length, or arrays"
    line = place[1] if place else function.__code__.co_firstlineno
    return (
        f"{strategy.name}, line {line}: {name} doesn't compile: {what}; "
        "a strategy computes with numbers and math only"
    )


def player_of(lowered: Lowered, team: int) -> Player:
    """Return what plays runs of a scenario, each by so many threads."""
    engine, rooms = engine_functions(*lowered.form), [first_room(lowered.params)]

    def play(record: Record, control: Control) -> None:
        _play(lowered, engine, record, control, rooms, team)

    return play


def outcome_of(record: Record) -> Outcome:
    """Return the arrays of a record."""
    return Outcome(*(getattr(record, each.name) for each in fields(Outcome)))


def _play(
    lowered: Lowered, engine: Engine, record: Record, control: Control, rooms: list[Room], team: int
) -> None:
    """Play one chunk; when an inbox has no room, play that run again with more.

    ``rooms[0]`` has sufficed so far, for all chunks; it changes no result.
    """
    complete, params = 0, packed(lowered.params)
    while complete < record.runs and not control.cancelled[0]:
        rest = record.part(complete, record.runs)
        state = empty_state(lowered.params, lowered.tables, rooms[0], lowered.strategy.memory, team)
        try:
            if team > 1:
                complete += _play_together(engine, lowered.params, params, state, rest, control)
            else:
                (part,) = parts_of(lowered.params)
                complete += entrypoints.play(
                    params, state, outcome_of(rest), rest.first_run, control, *engine, part
                )
        except FAILURES as error:
            if rest.runs == 1:
                raise RunError(rest.first_run, error) from error
            for row in range(rest.runs):  # one at a time, to find the run that fails
                _play(lowered, engine, rest.part(row, row + 1), control, rooms, team)
            raise
        if complete < record.runs:
            rooms[0] = enlarged(rooms[0], state)


def enlarged(room: Room, state: State) -> Room:
    """Return a room with twice as much of what an inbox lacked."""
    if state.clock[Clock.FULL] == Lack.SLOTS:
        return room._replace(slots=2 * room.slots)
    return room._replace(tables=2 * room.tables)


def _play_together(
    engine: Engine, numbers: Params, params: Any, state: State, record: Record, control: Control
) -> int:
    """Play runs one after another, each by as many threads as the state is for, as `play` does."""
    parts = parts_of(numbers, state.free_tables.shape[0])
    outcome = outcome_of(record)
    with ThreadPoolExecutor(len(parts)) as pool:
        for row in range(record.runs):
            engine.start(params, state, record.first_run + row)
            shared = (params, state, outcome, row, numbers.run.steps, control, engine.functions)
            futures = [pool.submit(_advance_part, engine, *shared, part) for part in parts]
            for future in futures:
                future.result()
            if state.clock[Clock.FULL] or control.cancelled[0]:
                return row
    return record.runs


def _advance_part(engine: Engine, *arguments: Any) -> None:
    """Simulate a thread's part of a run; if a strategy raises an error, end the run for all threads."""
    try:
        engine.advance(*arguments)
    except BaseException:
        entrypoints.abandon()(arguments[-1])
        raise
