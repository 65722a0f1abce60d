"""Rules in C, called as the engine does."""

from __future__ import annotations

import pytest

from tests.engine.compiled import CALLS, built_in_rules, declarations, library


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    """Return the declarations of the engine, and what calls a rule as the engine does."""
    ffi = declarations()
    return ffi, ffi.dlopen(str(library(tmp_path_factory.mktemp("calls"), "calls", CALLS)))


@pytest.fixture(scope="module")
def built_in(tmp_path_factory, calls):
    """Return the built-in strategies in C."""
    return calls[0].dlopen(str(built_in_rules(tmp_path_factory)))
