"""Optimise the functions that Python calls once, each together with all that it calls.

By itself, numba optimises every function with all that it calls, and makes machine code of it, before it
compiles the callers. A helper is then optimised again in each of its callers, and in theirs.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from numba.core import codegen, compiler, environment

JITCodeLibrary: Any = codegen.JITCodeLibrary
Compiler: Any = compiler.Compiler
LEVEL: Final = 2
"""Level of LLVM's optimisation: at level 3, no step was faster."""
lookup_environment: Any = environment.lookup_environment
ENVIRONMENT: Final = "_ZN08NumbaEnv"
"""How names start of what functions that raise errors with values refer to."""


class Part(JITCodeLibrary):  # type: ignore[misc]  # numba has no types
    """Code of a function that only compiled code calls. It is linked into others, and not run by itself."""

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout

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


class Whole(JITCodeLibrary):  # type: ignore[misc]
    """Code of a function that Python calls, and of all that it calls."""

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout

    def finalize(self) -> None:
        """Link all that is called, optimise it together and make machine code."""
        self._linking_libraries: list[Any] = reached(self._linking_libraries)
        super().finalize()

    def _optimize_final_module(self) -> None:
        passes = self._codegen._pass_builder(opt=LEVEL)
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


class WholeCompiler(Compiler):  # type: ignore[misc]
    """Compile a function that Python calls."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a function into a `Whole`, which can be kept on disk."""
        self.state.library = Whole(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(func)
