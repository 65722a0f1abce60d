"""Runs kept in the cache: the second question needs no runs, and the folder stays small."""

from __future__ import annotations

import os

import pytest
from commands import json_of
from stores import counts

from feasibee import Scenario
from feasibee.simulation import kept
from feasibee.simulation.kept import kept_folder


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """Keep runs in a folder of the test; compiled code stays where it is."""
    monkeypatch.setattr(kept, "cache_root", lambda: tmp_path / "cache")
    return tmp_path / "cache"


def test_a_folder_is_that_of_a_scenario_a_seed_and_this_code(monkeypatch):
    scenario = Scenario()
    folder = kept_folder(scenario, 1)
    assert folder == kept_folder(Scenario(), 1)
    others = {kept_folder(scenario, 2), kept_folder(scenario.replace({"tasks.count": 9}), 1)}
    monkeypatch.setattr(kept, "_code", lambda: "other")
    assert len({folder, *others, kept_folder(scenario, 1)}) == 4


def test_the_second_question_needs_no_new_runs(cache):
    """Another command, on the same scenario and seed: `compare` tests with constraints what `assess` has."""
    words = ["--set", "run.steps=60", "--set", "arena.side=8", "--runs", 100, "--seed", 3, "--json"]
    before = json_of("assess", *words)
    (folder,) = (cache / "runs").iterdir()
    runs = counts(folder)
    assert json_of("assess", *words) == before
    assert counts(folder) == runs
    json_of("compare", "--right", 0.95, *words, "--strategies", "dmmd")
    assert len(list((cache / "runs").iterdir())) == 1


def test_a_cache_that_cant_be_written_keeps_nothing(cache):
    cache.write_text("a file")
    assert kept_folder(Scenario(), 1) is None


def test_the_folders_used_longest_ago_are_removed(monkeypatch):
    folders = []
    for seed in range(4):
        folders.append(kept_folder(Scenario(), seed))
        (folders[-1] / "runs").write_bytes(bytes(100_000))
        os.utime(folders[-1], (1000 + seed, 1000 + seed))
    monkeypatch.setattr(kept, "ROOM", 250_000)
    assert kept_folder(Scenario(), 0) == folders[0]  # used again, though the oldest
    assert [each.exists() for each in folders] == [True, False, False, True]
