"""Translate the functions of a strategy from Python to C99, by their syntax trees.

A function is translated once for each combination of types that it is called with, those of other modules
included. What the language of strategies doesn't have is an error: file, line, what was met, what to write.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from types import FunctionType

from feasibee.robot.definitions import Definition, definition_of
from feasibee.robot.expressions import FLAT, Expressions, c_name
from feasibee.robot.language import (
    ARGUMENTS,
    COUNTS,
    ELEMENTS,
    INT,
    NUMBERS,
    REAL,
    REALS,
    RESULTS,
    ROBOT,
    ROW,
    SMALL,
    TABLE,
    TEXT,
    VOID,
    Needs,
    Signature,
    Target,
    Type,
    Value,
    maker_of,
    text_of,
)


@dataclass
class Translation:
    """Functions in C, each once for each combination of types."""

    target: Target = ROBOT
    """The program that they are for."""
    texts: dict[str, tuple[str, str]] = field(default_factory=dict)
    """With what the functions of modules that aren't files begin in C, and the texts of these modules."""
    functions: list[str] = field(default_factory=list)
    """Definitions, each after those that it calls."""
    tuples: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Types of tuples, by their names in C."""
    _done: dict[tuple[str, int, tuple[Type, ...]], Signature] = field(default_factory=dict)
    _under_way: list[tuple[str, int, tuple[Type, ...]]] = field(default_factory=list)
    _trees: dict[str, ast.Module] = field(default_factory=dict)

    @property
    def body(self) -> type[FunctionBody]:
        """Return what translates the body of one function."""
        return FunctionBody

    def entry(self, name: str, function: FunctionType, prefix: str = "", source: str = "") -> Signature:
        """Translate a function of the contract; its module's text is needed if that isn't a file."""
        if source:
            self.texts[function.__module__] = prefix, source
        return self.function(function, ARGUMENTS[name], RESULTS.get(name, INT))

    def function(
        self, function: FunctionType | Definition, arguments: tuple[Type, ...], result: Type | None = None
    ) -> Signature:
        """Translate a function for arguments of these types; return it as it is in C.

        Raise a FeasibeeError if it has what the language of strategies doesn't have.
        """
        definition = self.definition(function)
        key = (*definition.key, arguments)
        done = self._done.get(key)
        if done is not None and result in (None, done.result):
            return done
        body = self.body(self, definition)
        if key in self._under_way:
            body.fail(body.tree, f"{definition.name} calls itself", "write a loop")
        self._under_way.append(key)
        try:
            signature = body.translate(self._name(definition), arguments, result)
        finally:
            self._under_way.pop()
        self._done[key] = signature
        self.functions.append(body.text(signature))
        return signature

    def structs(self) -> list[str]:
        """Return the definitions of the tuples, and of the functions that make them."""
        return [
            "\n".join(
                [
                    f"{name} {{",
                    *(f"    {kind} m{k};" for k, kind in enumerate(kinds)),
                    "};\n",
                    f"static inline {name} {maker_of(kinds)}({_arguments(kinds)})",
                    "{",
                    f"    {name} made = {{{', '.join(f'm{k}' for k in range(len(kinds)))}}};",
                    "    return made;",
                    "}\n",
                ]
            )
            for name, kinds in self.tuples.items()
        ]

    def _name(self, function: Definition) -> str:
        module = function.module
        prefix, _ = self.texts.get(module, (f"feasibee_{module.rpartition('.')[2]}", ""))
        base = f"{prefix}_{c_name(function.name)}"
        taken = {signature.name for signature in self._done.values()}
        return next(each for each in (base, *(f"{base}_{n}" for n in range(2, 100))) if each not in taken)

    def definition(self, function: FunctionType | Definition) -> Definition:
        """Return a function with its syntax tree."""
        if isinstance(function, Definition):
            return function
        name = function.__module__
        if name not in self._trees:
            text = self.texts[name][1] if name in self.texts else inspect.getsource(sys.modules[name])
            self._trees[name] = ast.parse(text)
        return definition_of(function, self._trees[name])


class FunctionBody(Expressions):
    """The body of one function, in C."""

    def __init__(self, translation: Translation, function: Definition) -> None:
        super().__init__(translation, function)
        self.tree = function.tree
        self.loops: set[str] = set()
        self.result: Type | None = None
        self.lines: list[str] = []
        self.temporary = 0

    def translate(self, name: str, arguments: tuple[Type, ...], result: Type | None) -> Signature:
        """Translate until no type changes: a variable may be whole at first, and real later on."""
        parameters = self.function.arguments
        self.types, self.result, self.wanted = dict(zip(parameters, arguments, strict=True)), result, result
        self.own_loops = self._variables_of_loops()
        while True:
            before, self.lines, self.temporary = (dict(self.types), self.result), [], 0
            self.block(self.tree.body, 1)
            if before == (self.types, self.result):
                break
        return Signature(name, arguments, self.result or VOID, Needs(self.position, self.floating))

    def text(self, signature: Signature) -> str:
        """Return the definition."""
        parameters = self.function.arguments
        written = [
            f"{self.translation.target.text_of(kind)} {c_name(each)}".replace("* ", "*")
            for each, kind in zip(parameters, (self.types[each] for each in parameters), strict=True)
        ]
        said = (ast.get_docstring(self.tree) or "").split("\n")[0].replace("*/", "* /")
        lines = [f"/* {said} */"] if said else []
        result = text_of(signature.result)
        lines += [
            f"{self.translation.target.inlined} {result} {signature.name}({', '.join(written) or 'void'})",
            "{",
        ]
        if signature.needs.floating and not signature.needs.position:
            lines += ["#ifndef FEASIBEE_DOUBLE", *(f"    (void){c_name(each)};" for each in parameters)]
            lines += ["    FEASIBEE_STOP();"]
            lines += [f"    return {_zero(signature.result)};"] if signature.result != VOID else []
            lines += ["#else"]
        lines += [
            f"    {self.translation.target.text_of(kind)} {c_name(each)} = {_zero(kind, begins=True)};"
            for each, kind in self.types.items()
            if each not in parameters and each not in self.loops
        ]
        lines += [f"    (void){c_name(each)};" for each in parameters if self._may_be_unread(each)]
        lines += self.lines
        if signature.needs.floating and not signature.needs.position:
            lines += ["#endif"]
        lines += ["}", ""]
        return "\n".join(
            ["#ifdef FEASIBEE_DOUBLE", *lines, "#endif", ""] if signature.needs.position else lines
        )

    def _may_be_unread(self, name: str) -> bool:
        """Whether C may not read an argument: it isn't read here, or only for what is a constant there."""
        read = any(isinstance(node, ast.Name) and node.id == name for node in ast.walk(self.tree))
        return not read or self.types[name] in ("me", "setting")

    def _variables_of_loops(self) -> set[str]:
        """Return the variables that only loops set, and that only their bodies read."""
        inside: dict[str, int] = {}
        for loop in ast.walk(self.tree):
            if isinstance(loop, ast.For) and isinstance(loop.target, ast.Name):
                used = [
                    each
                    for each in ast.walk(loop)
                    if isinstance(each, ast.Name) and each.id == loop.target.id
                ]
                if sum(isinstance(each.ctx, ast.Store) for each in used) == 1:
                    inside[loop.target.id] = inside.get(loop.target.id, 0) + len(used)
        everywhere = [node.id for node in ast.walk(self.tree) if isinstance(node, ast.Name)]
        return {name for name, times in inside.items() if everywhere.count(name) == times}

    # --- Statements ---

    def block(self, statements: Sequence[ast.stmt], depth: int) -> None:
        """Translate statements."""
        for statement in statements:
            write = getattr(self, f"_{type(statement).__name__.lower()}", None)
            if write is None:
                what = type(statement).__name__.lower()
                self.fail(
                    statement, f"a statement of the kind {what!r}", "write assignments, if, for and while"
                )
            write(statement, depth)

    def put(self, depth: int, line: str) -> None:
        """Add a line."""
        self.lines.append("    " * depth + line)

    def _pass(self, statement: ast.Pass, depth: int) -> None:
        self.put(depth, ";")

    def _break(self, statement: ast.Break, depth: int) -> None:
        self.put(depth, "break;")

    def _continue(self, statement: ast.Continue, depth: int) -> None:
        self.put(depth, "continue;")

    def _expr(self, statement: ast.Expr, depth: int) -> None:
        if not isinstance(statement.value, ast.Constant):
            self.put(depth, f"{self.value(statement.value).text};")

    def _return(self, statement: ast.Return, depth: int) -> None:
        if statement.value is None:
            self.put(depth, "return;")
            return
        value = self.plain(statement.value, self.value(statement.value))
        if self.wanted is None or self.result is None or value.type not in NUMBERS:
            self.result = self._join(statement, value.type, self.result or value.type)
        self.put(depth, f"return {self._cast(value, self.result).text};")

    def _if(self, statement: ast.If, depth: int) -> None:
        self.put(depth, f"if ({self.truth(statement.test)}) {{")
        self.block(statement.body, depth + 1)
        if statement.orelse:
            self.put(depth, "} else {")
            self.block(statement.orelse, depth + 1)
        self.put(depth, "}")

    def _while(self, statement: ast.While, depth: int) -> None:
        self._no_else(statement)
        begins = self.begins_pass(statement, depth)
        self.put(depth, f"while ({self.truth(statement.test)}) {{")
        self.lines += begins
        self.block(statement.body, depth + 1)
        self.put(depth, "}")

    def begins_pass(self, loop: ast.For | ast.While, depth: int) -> list[str]:
        """Return the lines with which each pass of a loop begins."""
        return []

    def _no_else(self, statement: ast.For | ast.While) -> None:
        if statement.orelse:
            self.fail(statement, "a loop with else", "write if after it")

    def _for(self, statement: ast.For, depth: int) -> None:
        self._no_else(statement)
        over = statement.iter
        if isinstance(over, ast.Call) and isinstance(over.func, ast.Name) and over.func.id == "range":
            self._count_up(statement, over.args, depth)
            return
        items = self.items(over)
        if items is None:
            remedy = "write for k in range(number), and take what is at k"
            self.fail(statement, f"a loop over {ast.unparse(over)}", remedy)
        for item in items:  # each pass of the loop for itself
            self.assign(statement.target, item, depth)
            self.block(statement.body, depth)
        if any(isinstance(each, ast.Break | ast.Continue) for each in ast.walk(statement)):
            self.fail(statement, "a loop over numbers written out, with break or continue", "use range")

    def _limits(self, statement: ast.For, limits: list[ast.expr], depth: int) -> tuple[Value, Value, Value]:
        """Return first, last and step of a range."""
        if not isinstance(statement.target, ast.Name) or not 1 <= len(limits) <= 3:
            self.fail(statement, f"{ast.unparse(statement.target)} in a range", "use one name")
        values = [self.limit(each, depth) for each in limits]
        first, last = (Value("0", INT, 0), values[0]) if len(values) == 1 else values[:2]
        return first, last, values[2] if len(values) > 2 else Value("1", INT, 1)

    def limit(self, node: ast.expr, depth: int) -> Value:
        """Translate a limit of a range, or its step."""
        return self.number(node)

    def _count_up(self, statement: ast.For, limits: list[ast.expr], depth: int) -> None:
        first, last, step = self._limits(statement, limits, depth)
        kind = self._join(statement, _smallest(first), _smallest(last))
        name = ast.unparse(statement.target)
        own = name in self.own_loops
        if own:
            self.loops.add(name)
        self.types[name] = self._join(statement, self.types.get(name, kind), kind)
        counter = c_name(name) if own else self.new()
        # Without a number written out, steps go up, as they do in all strategies so far.
        sign = ">" if step.known is not None and step.known < 0 else "<"
        steps = {1: "++", -1: "--"}.get(step.known, f" += {step.text}")
        head = f"{text_of(kind)} {counter} = {first.text}, {counter}_end = {last.text}"
        self.put(depth, f"for ({head}; {counter} {sign} {counter}_end; {counter}{steps}) {{")
        if not own:
            self.put(depth + 1, f"{c_name(name)} = {counter};")
        else:
            self.put(depth + 1, f"(void){counter};")
        self.block(statement.body, depth + 1)
        self.put(depth, "}")

    def _annassign(self, statement: ast.AnnAssign, depth: int) -> None:
        if statement.value is not None:
            self.assign(statement.target, statement.value, depth)

    def _augassign(self, statement: ast.AugAssign, depth: int) -> None:
        old = _loaded(statement.target)
        for each in ast.walk(old):
            ast.copy_location(each, statement)
        new = ast.BinOp(left=old, op=statement.op, right=statement.value)
        self.assign(statement.target, ast.copy_location(new, statement), depth)

    def _assign(self, statement: ast.Assign, depth: int) -> None:
        if len(statement.targets) == 1:
            self.assign(statement.targets[0], statement.value, depth)
            return
        held = self.hold(self.value(statement.value), depth)
        for target in statement.targets:
            self.assign(target, held, depth)

    def assign(self, target: ast.expr, given: ast.expr | Value, depth: int) -> None:
        """Assign an expression to a name, a place in a row, or several of them."""
        if isinstance(target, ast.Tuple | ast.List):
            self._assign_several(target, given, depth)
            return
        counts = isinstance(target, ast.Subscript) and self.value(target.value).type == COUNTS
        read = self.wide if counts else self.value
        value = given if isinstance(given, Value) else read(given)
        if isinstance(target, ast.Name) and target.id == "_":
            return
        if isinstance(target, ast.Name):
            if isinstance(given, ast.expr):
                self.plain(given, value)
            kind = self._join(target, self.types.get(target.id, value.type), value.type)
            if kind == VOID:
                self.fail(target, f"{target.id} is given nothing", "call a function that returns a number")
            self.types[target.id] = kind
            self.put(depth, f"{c_name(target.id)} = {self._cast(value, kind).text};")
        elif isinstance(target, ast.Subscript) and not isinstance(target.slice, ast.Slice):
            self.put(depth, f"{self._place(target)} = {self._stored(target, value)};")
        else:
            self.fail(target, f"an assignment to {ast.unparse(target)}", "assign to a name, or to row[place]")

    def _stored(self, target: ast.Subscript, value: Value) -> str:
        row = self.value(target.value).type
        if value.type not in NUMBERS or (value.type == REAL and row != REALS):
            self.fail(target, f"{ast.unparse(target)} is given a value of another type", "write int(...)")
        return f"(int32_t)({value.text})" if row == ROW else f"({ELEMENTS[str(row)]})({value.text})"

    def _assign_several(self, target: ast.Tuple | ast.List, given: ast.expr | Value, depth: int) -> None:
        if isinstance(given, ast.Tuple) and len(given.elts) == len(target.elts):
            values: list[Value] = [self.value(each) for each in given.elts]
            written = {node.id for node in ast.walk(target) if isinstance(node, ast.Name)}
            read = {node.id for node in ast.walk(given) if isinstance(node, ast.Name)}
            if written & read:
                values = [self.hold(value, depth) for value in values]
        else:
            whole = given if isinstance(given, Value) else self.value(given)
            if whole.type == TABLE:
                values = [self.known(each) or self.fail(target, repr(each), FLAT) for each in whole.known]
            else:
                whole = self.hold(whole, depth)
                kinds = whole.type if isinstance(whole.type, tuple) else ()
                values = [Value(f"{whole.text}.m{k}", kind) for k, kind in enumerate(kinds)]
        if len(values) != len(target.elts):
            self.fail(target, f"{len(target.elts)} names for another number of values", "give each one")
        for each, value in zip(target.elts, values, strict=True):
            self.assign(each, value, depth)

    def plain(self, node: ast.AST, value: Value) -> Value:
        """Return a value that C can hold in a variable."""
        if value.type in (TABLE, TEXT):
            self.fail(node, ast.unparse(node), "write it where a number of it is taken")
        return value

    def hold(self, value: Value, depth: int) -> Value:
        """Keep a value in a variable of its own."""
        if value.known is not None:
            return value
        name = self.new()
        self.put(depth, f"{self.translation.target.text_of(value.type)} {name} = {value.text};")
        return Value(name, value.type)

    def new(self) -> str:
        """Return a new name."""
        self.temporary += 1
        return f"t{self.temporary}_"


def _zero(kind: Type, begins: bool = False) -> str:
    """Return nothing of a type, for a definition or as a value."""
    if kind in NUMBERS:
        return "0"
    if begins or not isinstance(kind, tuple):
        return "{0}"
    return f"{maker_of(kind)}({', '.join('0' for _ in kind)})"


def _smallest(value: Value) -> Type:
    """Return the type of a limit of a loop."""
    return SMALL if value.known is not None and abs(value.known) < 2**15 else value.type


def _arguments(kinds: tuple[str, ...]) -> str:
    return ", ".join(f"{kind} m{k}" for k, kind in enumerate(kinds))


def _loaded(target: ast.expr) -> ast.expr:
    return ast.parse(ast.unparse(target), mode="eval").body
