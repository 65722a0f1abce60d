"""The decorators that compile, and what makes numba do it once. No other module of the package names numba's.

By itself, numba optimises every function with all that it calls, and makes machine code of it, before it
compiles the callers. A helper is then optimised again in each of its callers, and in theirs.
"""

from __future__ import annotations

import dis
import gc
import hashlib
import pickle
import re
import sys
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import FunctionType, SimpleNamespace
from typing import Any, Final

import llvmlite
import numba
import numpy
from llvmlite import binding, ir
from numba.core import (
    codegen,
    compiler,
    compiler_machinery,
    environment,
    inline_closurecall,
    serialize,
    typed_passes,
    types,
    untyped_passes,
)
from numba.core.registry import CPUDispatcher, cpu_target
from numba.core.typeinfer import register_dispatcher

from feasibee.errors import FeasibeeError
from feasibee.files import named
from feasibee.files.cache import cache_root, check_cache, own_folder, read_sealed, write_sealed

llvm: Any = binding
JITCodeLibrary: Any = codegen.JITCodeLibrary
Compiler: Any = compiler.Compiler
LEVEL: Final = 2
"""Level of LLVM's optimisation: at level 3, no step was faster."""
lookup_environment: Any = environment.lookup_environment
PassManager: Any = compiler_machinery.PassManager
BaseFunction: Any = types.functions.BaseFunction
splicing: Any = inline_closurecall
register_pass: Any = compiler_machinery.register_pass
InlineInlinables: Any = untyped_passes.InlineInlinables


@register_pass(mutates_CFG=True, analysis_only=False)
class Splice(InlineInlinables):  # type: ignore[misc]  # numba has no types
    """Splice functions in as they are, not a deep copy of a deep copy: nothing else uses them."""

    def run_pass(self, state: Any) -> Any:
        """Run the pass."""
        kept, splicing.copy = splicing.copy, SimpleNamespace(deepcopy=lambda blocks: blocks)
        try:
            return super().run_pass(state)
        finally:
            splicing.copy = kept


PASSES: Final = (
    untyped_passes.TranslateByteCode,
    untyped_passes.FixupArgs,
    untyped_passes.IRProcessing,
    untyped_passes.GenericRewrites,
    Splice,
    untyped_passes.ReconstructSSA,
    typed_passes.NopythonTypeInference,
    typed_passes.PreLowerStripPhis,
    typed_passes.InlineOverloads,
    typed_passes.NativeLowering,
    typed_passes.NoPythonBackend,
)
"""The passes of numba that the engine needs: no closures, no arithmetic of arrays, no reference counts."""
ENVIRONMENT: Final = "_ZN08NumbaEnv"
"""How names start of what functions that raise errors with values refer to."""


class Code(JITCodeLibrary):  # type: ignore[misc]  # numba has no types
    """Code of a function, not optimised yet."""

    def add_ir_module(self, ir_module: Any) -> None:
        """Add code. To load early what lies behind a pointer, LLVM must know that it may be loaded at all."""
        for function in ir_module.functions:
            for argument in function.args:
                behind: Any = getattr(argument.type, "pointee", None)
                if isinstance(getattr(behind, "element", None), ir.IntType):
                    argument.attributes.dereferenceable = behind.count * behind.element.width // 8
        super().add_ir_module(ir_module)

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout


class Part(Code):
    """Code of a function that only compiled code calls. It is linked into others, and not run by itself."""

    def finalize(self) -> None:
        """Leave the code as it is."""
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0, as numba does for a function without code for calls from Python."""
        return 0

    @property
    def codegen(self) -> Part:
        """Stand in for the code generator where numba sets the environment of loaded code."""
        return self

    def set_env(self, name: str, env: Any) -> None:
        """Set nothing: `Whole` does."""


class Whole(Code):
    """Code of a function that Python calls, and of all that it calls."""

    def finalize(self) -> None:
        """Link all that is called, optimise it together and make machine code."""
        self._linking_libraries: list[Any] = reached(self._linking_libraries)
        super().finalize()

    def _optimize_final_module(self) -> None:
        options = llvm.create_pipeline_tuning_options(LEVEL)
        options.loop_vectorization = True
        options.loop_interleaving = False  # several rounds of a loop at once: no step was faster
        passes = llvm.create_pass_builder(self._codegen._tm, options)
        passes.getModulePassManager().run(self._final_module, passes)

    def _finalize_specific(self) -> None:
        super()._finalize_specific()
        for variable in self._final_module.global_variables:
            if variable.name.startswith(ENVIRONMENT):
                found = lookup_environment(variable.name)
                if found is not None:
                    self._codegen.set_env(variable.name, found)


def reached(libraries: Iterable[Any]) -> list[Any]:
    """Return libraries and all that their parts call, each once."""
    found: dict[Any, None] = {}
    new = list(libraries)
    while new:
        each = new.pop()
        if each not in found:
            found[each] = None
            if isinstance(each, Part):
                new += each._linking_libraries
    return list(found)


class PartCompiler(Compiler):  # type: ignore[misc]
    """Compile a function that only compiled code calls."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a function into a `Part`."""
        self.state.library = Part(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)


class OwnPasses:
    """Of a compiler of functions that this package defines: a user's may be of any form."""

    def define_pipelines(self) -> list[Any]:
        """Return the passes to run."""
        passes: Any = PassManager("feasibee")
        for each in PASSES:
            passes.add_pass(each, each.__name__)
        passes.finalize()
        return [passes]


class OwnPartCompiler(OwnPasses, PartCompiler):
    """Compile a function of this package that only compiled code calls."""


class WholeCompiler(OwnPasses, Compiler):  # type: ignore[misc]
    """Compile a function that Python calls."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a function into a `Whole`, which can be kept on disk."""
        self.state.library = Whole(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(func)


@contextmanager
def remembered_types() -> Iterator[None]:
    """Look up once which form of an operator fits which types, not at each of its uses.

    numba tries all forms, a dozen for ``+``, each time. That took a seventh of the time to compile.
    """
    look_up: Callable[..., Any] = BaseFunction.get_call_type
    found: dict[Any, Any] = {}

    def get_call_type(function: Any, context: Any, arguments: Any, keywords: Any) -> Any:
        key = (function, context, tuple(arguments), tuple(keywords.items()))
        if key not in found:
            found[key] = look_up(function, context, arguments, keywords)
        return found[key]

    BaseFunction.get_call_type = get_call_type
    try:
        yield
    finally:
        BaseFunction.get_call_type = look_up


CompileResult: Any = compiler.CompileResult
dumps: Any = serialize.dumps
unliteral: Any = types.unliteral
# Compiled code allocates nothing, so numba's reference counting is off. With it, passing the state to a
# function counts each array's references atomically, which doubled the time of a step.
OPTIONS: dict[str, Any] = {"nogil": True, "_nrt": False, "error_model": "numpy"}
# Functions that only compiled code calls need no code for calls from Python, which took longer to compile
# than the functions themselves: it converts each array of the state.
INNER: dict[str, Any] = {
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "pipeline_class": OwnPartCompiler,
}
on_compile: ContextVar[Callable[[str], None]] = ContextVar("on_compile", default=lambda name: None)
"""Called with the name of an entry whose code isn't on disk, before it is compiled."""
CAREFUL: dict[str, Any] = {**OPTIONS, "error_model": "python", "boundscheck": True}
USERS: dict[str, Any] = {**CAREFUL, **INNER, "pipeline_class": PartCompiler}


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a helper, inlined by LLVM where it is called.

    Passing the state costs more than most helpers do.
    """
    return one_copy(numba.njit(forceinline=True, **OPTIONS, **INNER)(function))


def spliced(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile as part of the one function that calls it, for long ones.

    Inlined by LLVM instead, a long function would be compiled twice.
    """
    compiled: Callable[..., Any] = numba.njit(inline="always", **OPTIONS, **INNER)(function)
    return compiled


def called(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a helper that is called: where a call costs little, one copy compiles sooner.

    Left open, it would be inlined if numba comes upon it in a helper that is.
    """
    return one_copy(numba.njit(forceinline=False, **OPTIONS, **INNER)(function))


def one_copy(compiled: Any) -> Callable[..., Any]:
    """Make calls with constants share one compiled copy.

    numba compiles another copy for each constant that is passed: ten of `draw`, for its purposes.
    """
    template_of = compiled.get_call_template

    def get_call_template(arguments: Any, keywords: Any) -> Any:
        plain = tuple(unliteral(each) for each in arguments)
        return template_of(plain, {name: unliteral(each) for name, each in keywords.items()})

    compiled.get_call_template = get_call_template
    function: Callable[..., Any] = compiled
    return function


def careful(function: Callable[..., Any], arguments: Any = None) -> Callable[..., Any]:
    """Compile a user's function, which raises what Python would; `entry` keeps what calls it.

    With types of its arguments it is compiled at once and for these only, and inlined where it is called.
    """
    if arguments is None:
        compiled: Callable[..., Any] = numba.njit(**USERS)(function)
    else:
        compiled = numba.njit(arguments, forceinline=True, **USERS)(function)
    return compiled


def rebound(function: Any, name: str = "", /, **names: Any) -> Callable[..., Any]:
    """Return a copy of a function, not compiled yet, in whose module some names stand for other things.

    A closure would do the same, but numba couldn't find its code on disk again. Copies that are entries need
    names of their own, by which their code is found.
    """
    copy = FunctionType(function.__code__, {**function.__globals__, **names}, name or function.__name__)
    copy.__qualname__ = name or function.__qualname__
    return copy


def with_helpers(
    function: Any, compiled: Callable[[Any], Callable[..., Any]], within: tuple[Any, ...] = ()
) -> Callable[..., Any]:
    """Return a function whose calls of plain functions are compiled, too, each by ``compiled``."""
    chain = (*within, function)
    helpers = {
        name: compiled(with_helpers(each, compiled, chain))
        for name, each in helpers_of(function).items()
        if each not in chain  # a function that calls itself is left to numba's error
    }
    return rebound(function, **helpers) if helpers else function


def helpers_of(function: Any) -> dict[str, Any]:
    """Return the plain functions that a function's text names, by name."""
    named = {name: function.__globals__.get(name) for name in function.__code__.co_names}
    return {name: each for name, each in named.items() if isinstance(each, FunctionType)}


def reads_only(function: Any, argument: str, fields: Collection[str]) -> bool:
    """Return whether a function uses an argument only to read some of its fields; in doubt, not."""
    for this, following in pairwise(dis.get_instructions(function)):
        names = this.argval if isinstance(this.argval, tuple) else (this.argval,)
        if argument in names:
            loaded = this.opname.startswith("LOAD_FAST") and names[-1] == argument
            if not (loaded and following.opname == "LOAD_ATTR" and following.argval in fields):
                return False
    return True


def entry(
    signature: Any, text: str = "", in_python: bool = True
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Compile a function that Python calls, for one signature, and keep its code on disk.

    Parameters
    ----------
    signature : numba signature
        Types of its arguments and of what it returns.
    text : str
        Text of the user's file that the function comes from, if any. It then raises what Python would.
    in_python : bool
        Whether Python may call it, in addition to handing it to other entries.
    """
    options = {**(CAREFUL if text else OPTIONS), "no_cpython_wrapper": not in_python}

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        kept = Kept(function, text)
        compiled: Any = numba.njit(pipeline_class=WholeCompiler, **options)(function)
        compiled._cache = kept
        named = _named(function, kept.digest)
        with (
            named,
            register_dispatcher(compiled),
            _without_collection(),
            remembered_types(),
        ):  # it may call itself
            compiled.compile(signature)
        compiled.disable_compile()
        compiled.__class__ = Entry
        dispatcher: Callable[..., Any] = compiled
        return dispatcher

    return decorate


@contextmanager
def _named(function: Any, digest: str) -> Iterator[None]:
    """Give a function, while it compiles, a name of its own, which its code keeps.

    The linker finds code by name, and numba numbers names within a process only. Code of two strategies that
    two processes had compiled could have one name, so that one strategy ran the code of the other.
    """
    own = function.__qualname__
    function.__qualname__ = f"{digest}.{own}"  # it may call itself by the last part
    try:
        yield
    finally:
        function.__qualname__ = own


@contextmanager
def _without_collection() -> Iterator[None]:
    """Suspend Python's cyclic garbage collection: it took 8 % of the time to compile an engine.

    What is left joins the oldest generation, since a collection would take half of that time.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            if not gc.get_freeze_count():  # nothing that a program has frozen joins as well
                gc.freeze()
                gc.unfreeze()
            gc.enable()


class Entry(CPUDispatcher):
    """A compiled function that Python calls, with the type of its signature.

    numba gives each compiled function a type of its own. Code kept on disk doesn't fit a tuple of those in
    another process, and converting them takes longer than a short call. A bare address, which
    `WrapperAddressProtocol` would do with, loses the errors that the function raises.
    """

    @property
    def _numba_type_(self) -> Any:
        (signature,) = self.nopython_signatures
        return types.FunctionType(signature)


_files: set[Path] = set()  # of the code that this process has loaded or compiled


class Kept:
    """Compiled code of a function on disk, in a sealed file per signature and kind of processor.

    It replaces numba's own cache, which runs any file that it finds: a damaged one crashed the process.

    Parameters
    ----------
    function : callable
        The function as Python has it.
    text : str
        Text of the user's file that the function comes from; by default that of the file that defines it.
    """

    def __init__(self, function: Callable[..., Any], text: str) -> None:
        code = function.__code__
        source = text.encode() or Path(code.co_filename).read_bytes()
        enclosed = tuple(cell.cell_contents for cell in function.__closure__ or ())
        self._name = function.__name__
        place = (function.__module__, code.co_firstlineno)  # loaded code looks its module up
        self._made_from = (source, bool(text), *place, code.co_code, dumps(enclosed))

    @property
    def digest(self) -> str:
        """Hash of what the code is made from, the same in every process."""
        return self._digest_of()

    @property
    def cache_path(self) -> str:
        """Folder of the files."""
        return str(cache_folder())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the code for a signature, or None if it is missing or damaged."""
        target_context.refresh()
        path = self._path(sig, target_context.codegen())
        data = read_sealed(path)
        if data is None:
            check_cache()
            on_compile.get()(self._name)
            return None
        _files.add(path)
        return CompileResult._rebuild(target_context, *pickle.loads(data))

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write the code for a signature, unless it holds addresses of this process."""
        if not data.library.has_dynamic_globals:
            path = self._path(sig, data.codegen)
            unannotated = data._replace(type_annotation="")  # the annotation holds the text of the function
            write_sealed(path, dumps(unannotated._reduce()))
            _files.add(path)

    def _path(self, signature: Any, codegen: Any) -> Path:
        """Return the file for a signature and this processor."""
        return cache_folder() / f"{self._name}-{self._digest_of(str(signature), codegen.magic_tuple())}.nbc"

    def _digest_of(self, *others: Any) -> str:
        digest = hashlib.sha256()
        for each in (*others, *self._made_from):
            digest.update(repr(each).encode())
        return digest.hexdigest()[:16]


IMPORTS: Final = re.compile(r"^from (feasibee(?:\.\w+)*) import (\([^)]*\)|[^#\n]*)", re.MULTILINE)
READABLE_FOLDER: Final = 0o755
READABLE_FILE: Final = 0o644
PACKAGE: Final = Path(__file__).parent.parent


def sources() -> list[Path]:
    """Return the files that the general engine is compiled from: those that `compiled` imports from here."""
    found: set[Path] = set()
    new = {PACKAGE / "engine" / "compiled.py"}
    while new:
        found |= new
        new = {each for file in new for each in _imported_by(file)} - found
    return sorted(found)


def _imported_by(file: Path) -> Iterator[Path]:
    """Yield the files of this package that a file imports, by its import statements."""
    for module, names in IMPORTS.findall(file.read_text(encoding="utf-8")):
        folder = PACKAGE.parent.joinpath(*module.split("."))
        files = (folder.with_suffix(".py"), *(folder / f"{name}.py" for name in re.findall(r"\w+", names)))
        yield from (each for each in files if each.is_file())


@cache
def cache_folder() -> Path:
    """Return the folder of the compiled code, named by a hash of its sources and of the compilers' versions.

    A strategy's own text is part of a file's name: see `Kept`. ``FEASIBEE_CACHE`` moves the folder.
    """
    digest = hashlib.sha256()
    for source in sources():
        digest.update(source.relative_to(PACKAGE).as_posix().encode())
        digest.update(source.read_bytes())
    for version in (sys.version, numba.__version__, llvmlite.__version__, numpy.__version__):
        digest.update(version.encode())
    return own_folder(own_folder(cache_root()) / digest.hexdigest()[:16])


def export(folder: Path) -> Path:
    """Copy the compiled code that this process uses to a folder that others may read; return where it is.

    Set ``FEASIBEE_CACHE`` to the folder, or to a copy of it, to use the code.
    """
    of_the_option: dict[str, Any] = {"setting": "--out"}
    own = cache_folder()
    target = own_folder(
        own_folder(folder, READABLE_FOLDER, **of_the_option) / own.name, READABLE_FOLDER, **of_the_option
    )
    for path in sorted(each for each in _files if each.parent == own):
        data = read_sealed(path)
        if data is None:
            raise FeasibeeError(f"{named(path)}: the file was deleted or damaged; run the command again")
        write_sealed(target / path.name, data, READABLE_FILE, **of_the_option)
    return target


def processor() -> str:
    """Return the kind of processor that code is compiled for, as LLVM names it."""
    name: str = cpu_target.target_context.codegen().magic_tuple()[1]
    return name
