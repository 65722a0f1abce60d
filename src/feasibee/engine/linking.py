"""Optimise the functions that Python calls once, each together with all that it calls.

By itself, numba optimises every function with all that it calls, and makes machine code of it, before it
compiles the callers. A helper is then optimised again in each of its callers, and in theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any, Final

from llvmlite import binding, ir
from numba.core import (
    codegen,
    compiler,
    compiler_machinery,
    environment,
    inline_closurecall,
    typed_passes,
    types,
    untyped_passes,
)

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
