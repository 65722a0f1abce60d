"""Which variables of a function may be read before they have a value, and which functions end without one."""

from __future__ import annotations

import ast

import pytest

from feasibee.engine.flow import ends, unsure

UNSURE = {  # what follows "def f(a):", with ; for a new line of the same depth
    "return a": set(),
    "b = 1; return b": set(),
    "return b; b = 1": {"b"},
    "b += 1": {"b"},
    "b = 1; b += 1": set(),
    "b: int; return b": {"b"},
    "b: int = 1; return b": set(),
    "if b:\n  c = 1\n b = 1": {"b"},
    "if a:\n  b = 1\n return b": {"b"},
    "if a:\n  b = 1\n else:\n  b = 2\n return b": set(),
    "if a:\n  return a\n else:\n  b = 2\n return b": set(),
    "for k in a:\n  b = k\n return b": {"b"},
    "for k in a:\n  b = k\n return k": {"k"},
    "for k in k:\n  pass": {"k"},
    "for k in a:\n  if k:\n   continue\n  else:\n   b = 1\n  a = b": set(),
    "while b:\n  b = 1": {"b"},
    "while a:\n  b = 1\n return b": {"b"},
    "while True:\n  return a\n return b\n b = 1": set(),
    "while True:\n  if a:\n   break\n return b\n b = 1": {"b"},
}
ENDS = {
    "return a": False,
    "a = 1": True,
    "if a:\n  return a": True,
    "if a:\n  return a\n else:\n  return 1": False,
    "for k in a:\n  return k": True,
    "while a:\n  return a": True,
    "while True:\n  a = 1": False,
    "while 1:\n  if a:\n   return a": False,
    "while True:\n  if a:\n   break": True,
    "while 0:\n  return a": True,
}


def function(text):
    """Return the tree of a function of ``a``."""
    (tree,) = ast.parse("def f(a):\n " + text.replace("; ", "\n ")).body
    return tree


@pytest.mark.parametrize(("text", "names"), UNSURE.items())
def test_what_may_have_no_value_where_it_is_read_is_unsure(text, names):
    assert unsure(function(text)) == names


@pytest.mark.parametrize(("text", "may"), ENDS.items())
def test_a_function_ends_by_itself_unless_each_way_returns(text, may):
    assert ends(function(text)) is may
