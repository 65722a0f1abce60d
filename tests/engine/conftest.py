"""Rules in C, called as the engine does."""

from __future__ import annotations

import pytest

from feasibee.engine.generate import built_in_strategies
from tests.engine.compiled import CALLS, SANITIZED, declarations, library


@pytest.fixture(scope="session")
def calls(tmp_path_factory):
    """Return the declarations of the engine, and what calls a rule as the engine does."""
    ffi, text = declarations(), CALLS.read_text(encoding="utf-8")
    return ffi, ffi.dlopen(str(library(tmp_path_factory.mktemp("calls"), "calls", text)))


@pytest.fixture(scope="session")
def built_in(tmp_path_factory, calls):
    """Return the built-in strategies in C, with a sanitizer; without optimizing: 6 s."""
    folder, text = tmp_path_factory.mktemp("built_in"), built_in_strategies()
    return calls[0].dlopen(str(library(folder, "strategies", text, *SANITIZED, "-O0")))
