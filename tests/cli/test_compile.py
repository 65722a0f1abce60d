"""feasibee compile: what it prints."""

from __future__ import annotations

import json

import commands

from feasibee.engine.compile import cache_folder
from feasibee.simulation import loading
from feasibee.simulation.loading import Prepared


def invoke(*arguments):
    result = commands.invoke("compile", *arguments)
    assert result.exit_code == 0, result.output
    return result.stdout


def prepared(monkeypatch, *cached):
    names = ("fast-path engine", "general engine")
    parts = [Prepared(name, 12.34, each) for name, each in zip(names, cached, strict=True)]
    monkeypatch.setattr(loading, "prepare_engines", lambda: iter(parts))


def test_it_says_how_long_each_took_and_where_it_is(monkeypatch):
    prepared(monkeypatch, False, True)
    assert invoke().splitlines() == [
        "fast-path engine: compiled in 12.3 s",
        "general engine: loaded from disk in 12.3 s",
        f"The compiled code is in {cache_folder()}",
    ]


def test_it_says_when_there_was_nothing_to_do(monkeypatch):
    prepared(monkeypatch, True, True)
    assert invoke().splitlines()[-1] == "There was nothing to compile."


def test_json(monkeypatch):
    prepared(monkeypatch, False, True)
    assert json.loads(invoke("--json")) == {
        "cache": str(cache_folder()),
        "parts": [
            {"name": "fast-path engine", "seconds": 12.34, "cached": False},
            {"name": "general engine", "seconds": 12.34, "cached": True},
        ],
    }
