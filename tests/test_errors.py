"""Errors are short lines that any terminal can show, and come whole from another process."""

from __future__ import annotations

import pickle
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from feasibee.base.errors import (
    LINE_LIMIT,
    PART_LIMIT,
    PROBLEMS_LIMIT,
    PROBLEMS_SHOWN,
    FeasibeeError,
    Problem,
    ScenarioError,
    one_line,
    quoted,
)
from feasibee.base.files import UnreadableError, read_text


def problems(number):
    return [Problem(f"tasks.field{i}", i, "must be 5", "write 5") for i in range(number)]


@given(st.text(st.characters(), max_size=2000))
def test_any_text_becomes_one_printable_line(text):
    line = one_line(text)
    assert line.isprintable()
    assert len(line) <= LINE_LIMIT
    assert line.encode().decode() == line


def test_a_long_line_keeps_its_beginning_and_its_remedy():
    line = str(FeasibeeError(f"design = {'x' * 10_000}: can't be read; name a CSV file"))
    assert line.startswith("design = xxx")
    assert "..." in line
    assert line.endswith("xxx: can't be read; name a CSV file")


VALUES = {
    "a long word": "x" * 10**6,
    "5,000 digits": 10**5000,
    "a long list": [1] * 10**6,
    "a long table": {i: i for i in range(10**5)},
    "a deep list": [[[[[[[[[[]]]]]]]]]],
    "control characters": "\n\x1b[2J\u202e\ud800",
    "no number": float("nan"),
}


@pytest.mark.parametrize("name", VALUES)
def test_a_value_is_quoted_in_a_few_characters(name):
    shown = quoted(VALUES[name])
    assert 0 < len(shown) <= PART_LIMIT
    assert shown.isprintable()


def test_a_value_however_deep_is_quoted():
    deep = []
    for _ in range(10 * sys.getrecursionlimit()):
        deep = [deep]
    assert quoted(deep) == "[[[[...]]]]"
    while deep:  # Python's own end of it would need the stack
        deep = deep.pop()


def test_a_table_is_quoted_in_its_order():
    assert quoted({"last": 3, "first": 1}) == "{'last': 3, 'first': 1}"


def test_of_many_problems_some_are_shown_and_the_others_counted():
    few, many, most = (ScenarioError(problems(number), "a.toml") for number in (20, 33, 10**5))
    assert [str(each).count("\n") + 1 for each in (few, many, most)] == [PROBLEMS_SHOWN, 21, 21]
    assert str(many).endswith("\na.toml: and 13 more")
    assert str(most).endswith(f"\na.toml: and at least {PROBLEMS_LIMIT - PROBLEMS_SHOWN} more")


def test_problems_without_end_are_not_all_looked_at():
    def endless():
        while True:
            yield Problem("tasks.count", 5, "must be 6", "write 6")

    assert len(ScenarioError(endless()).problems) == PROBLEMS_LIMIT


@pytest.mark.parametrize(
    "make",
    [
        lambda: FeasibeeError("radio.range = -2: must be > 0; the paper uses 2.0"),
        lambda: ScenarioError(problems(3), "a.toml"),
        lambda: ScenarioError(problems(200)),
        lambda: unreadable("nope.toml"),
    ],
)
def test_an_error_comes_whole_from_another_process(make):
    """A worker's error is pickled: one whose parts were lost said nothing, or raised another error."""
    error = make()
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def unreadable(path):
    with pytest.raises(UnreadableError) as caught:
        read_text(path, "a scenario in TOML")
    return caught.value
