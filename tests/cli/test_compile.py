"""feasibee compile: what it prints."""

from __future__ import annotations

import os

import pytest
from commands import json_of, output_of, python

from feasibee.engine.compile import cache_folder, processor
from feasibee.simulation import loading
from feasibee.simulation.loading import Prepared


def prepared(monkeypatch, *cached):
    names = ("fast-path engine", "general engine")
    parts = [Prepared(name, 12.34, each) for name, each in zip(names, cached, strict=True)]
    monkeypatch.setattr(loading, "prepare_engines", lambda files: iter(parts))


def test_it_says_how_long_each_took_and_where_it_is(monkeypatch):
    prepared(monkeypatch, False, True)
    assert output_of("compile").splitlines() == [
        "fast-path engine: compiled in 12.3 s",
        "general engine: loaded from disk in 12.3 s",
        f"The compiled code is in {cache_folder()}",
    ]
    prepared(monkeypatch, True, True)
    assert output_of("compile").splitlines()[-1] == "There was nothing to compile."


def test_json(monkeypatch):
    prepared(monkeypatch, False, True)
    assert json_of("compile") == {
        "cache": str(cache_folder()),
        "out": None,
        "processor": processor(),
        "parts": [
            {"name": "fast-path engine", "seconds": 12.34, "cached": False},
            {"name": "general engine", "seconds": 12.34, "cached": True},
        ],
    }


STRATEGY = """
def decide(mind, inbox):
    return inbox.heard_opinion
"""
USE = """
import sys
from feasibee import Scenario, simulate
from feasibee.engine.compile import on_compile

def fail(name):
    raise AssertionError(f"{name} is compiled")

on_compile.set(fail)
for strategy in sys.argv[1:]:
    record = simulate(Scenario(decision={"strategy": strategy}, run={"steps": 50}), runs=3, seed=1)
    print(record.decision.to_numpy().tolist())
"""


@pytest.mark.slow
def test_a_moved_folder_serves_a_fresh_process_that_compiles_nothing(tmp_path):
    """As in a container: the folder is a copy that can't be written; the strategy's file moved, too."""
    mine = tmp_path / "mine.py"
    mine.write_text(STRATEGY)
    scenario = tmp_path / "scenario.toml"
    scenario.write_text("[decision]\nstrategy = 'dmmd'\n")
    files = [str(mine), str(scenario)]
    answer = json_of("compile", *files, "--out", tmp_path / "out")
    assert [each["name"] for each in answer["parts"]] == files
    assert answer["out"].startswith(str(tmp_path / "out"))
    there = (tmp_path / "out").rename(tmp_path / "there")
    moved = mine.rename(tmp_path / "moved.py")
    before = sorted(there.rglob("*"))
    assert {oct(each.stat().st_mode & 0o777) for each in before if each.is_file()} == {"0o644"}
    for each in (*before, there):
        each.chmod(each.stat().st_mode & 0o555)
    environment = {**os.environ, "FEASIBEE_CACHE": str(there)}
    try:
        done = python("-c", USE, moved, "dmmd", env=environment)
    finally:
        for each in (there, *filter(type(there).is_dir, before)):
            each.chmod(0o755)
    assert done.stderr == ""
    assert done.stdout.count("\n") == 2
    assert sorted(there.rglob("*")) == before
