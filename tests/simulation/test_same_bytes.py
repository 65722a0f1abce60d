"""The same scenario and seed give the same bytes as ever: hashes of a corpus, kept since model version 1.

A change of results is a new model version (CHANGELOG.md, "Results changed"). Then write the hashes anew:
``python tests/simulation/test_same_bytes.py``.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest

from feasibee import Scenario, ScenarioError
from feasibee.base.codes import MODEL_VERSION
from feasibee.base.record import COLUMNS
from feasibee.scenario.runs import Runs
from feasibee.simulation.ensemble import simulate_record
from feasibee.strategies import STRATEGIES

FIRST_ACCOUNT = ("bits_sent", "declare_step", "declared_feasible", "declared_infeasible")
"""The outcomes of the first corpus; the later ones follow from curves, unless robots declare."""
DECLARING_ACCOUNT = tuple(COLUMNS)[: COLUMNS["last_step"]]
"""The outcomes of the corpus of robots that declare; in worlds that don't change, the later ones are 0."""
HASHES = Path(__file__).parent / "same_bytes.json"
KEPT = json.loads(HASHES.read_text())
"""Hashes by scenario, and the seeds of those of the first corpus."""
TEAM = {
    "robots.classes": [
        {"name": "arm", "count": 9, "skills": ["lift"]},
        {"name": "eye", "count": 7, "skills": ["scan"]},
        {"name": "both", "count": 5, "skills": ["lift", "scan"]},
    ],
    "tasks.classes": [
        {"name": "carry", "count": 4, "needs": {"lift": 2}},
        {"name": "map", "count": 6, "needs": {"scan": 1, "lift": 1}},
    ],
}
WORLDS = {
    "paper": {},
    "many tasks": {"tasks.count": 60},
    "forty robots": {"robots.count": 40, "tasks.count": 35},
    "walls": {"arena.boundary": "walls", "arena.side": [14.0, 9.0]},
    "bodies": {"arena.boundary": "walls", "robots.avoid_collisions": True, "arena.side": 12.0},
    "bodies on a torus": {"robots.avoid_collisions": True, "arena.side": [11.0, 13.0], "robots.speed": 0.6},
    "unique": {"sensing.observation": "unique"},
    "unique, short": {"sensing.observation": "unique", "sensing.count_self": True},
    "misses": {"sensing.miss": 0.2, "sensing.range": 3.0},
    "loss": {"radio.loss": 0.3, "radio.range": 4.0},
    "faults": {
        "faults.stopped": 0.15,
        "faults.stop_step": 20,
        "faults.byzantine": 0.1,
        "faults.stubborn": 0.1,
    },
    "random liars": {"faults.byzantine": 0.2, "faults.byzantine_says": "random"},
    "clusters": {"robots.placement": "clusters", "tasks.placement": "clusters", "tasks.spread": 3.0},
    "short ids": {"radio.id_bits": 4, "decision.inbox_size": 3},
    "late listeners": {"decision.listen": {"last": 3}, "decision.dissemination_floor": 3},
    "commits": {"decision.declare": {"quorum": 0.75, "rounds": 2, "heard": 2}, "decision.own_vote": False},
    "team": TEAM,
    "preset": {
        "decision.exploration": 100.0,
        "decision.gain": 100.0,
        "decision.listen": "dissemination",
        "decision.inbox_size": 2,
        "decision.quality_floor": 1,
        "radio.id_bits": 8,
        "run.steps": 60,
    },
    "stops": {"run.stop_at_decision": True, "run.steps": 300, "tasks.count": 100},
    "colluders that invent tasks": {"faults.byzantine": 0.1, "faults.byzantine_says": "colluding"},
    "colluders that invent robots": {
        "faults.byzantine": 0.1,
        "faults.byzantine_says": "colluding",
        "tasks.count": 23,
    },
    "bodies that deflect": {
        "arena.boundary": "walls",
        "robots.avoid_collisions": True,
        "robots.contact": "deflect",
        "arena.side": 12.0,
    },
    "forty that deflect on a torus": {
        "robots.count": 40,
        "robots.avoid_collisions": True,
        "robots.contact": "deflect",
        "arena.side": [11.0, 13.0],
        "robots.speed": 0.6,
    },
}


def scenarios() -> Iterator[tuple[str, int, Scenario]]:
    """Yield all strategies in all worlds, as far as they can be together: name, seed and scenario."""
    for world, changes in WORLDS.items():
        for strategy in STRATEGIES:
            changed = {"run.steps": 60, "arena.side": 10.0, **changes, "decision.strategy": strategy}
            if STRATEGIES[strategy].needs_count:
                changed["robots.know_count"] = True
            name = f"{world}, {strategy}"
            with suppress(ScenarioError):
                yield name, KEPT["seeds"].get(name, crc32(name.encode())), Scenario().replace(changed)


def digest(scenario: Scenario, seed: int, backend: str = "engine", runs: int = 2) -> str:
    """Return a hash of all that some runs leave behind."""
    record = simulate_record(scenario, Runs(runs, seed), curves=True, backend=backend)
    text = hashlib.sha256()
    kept = DECLARING_ACCOUNT if scenario.strategy.declares else FIRST_ACCOUNT
    for array in (
        record.decision,
        record.decision_step,
        record.feasible_count,
        record.infeasible_count,
        record.account[:, [COLUMNS[name] for name in kept]],
    ):
        text.update(np.ascontiguousarray(array).tobytes())
    return text.hexdigest()[:16]


def test_every_scenario_of_the_corpus_gives_the_bytes_that_it_gave():
    assert KEPT["model_version"] == MODEL_VERSION
    found = {name: digest(scenario, seed) for name, seed, scenario in scenarios()}
    assert len(found) >= 200
    assert found == KEPT["hashes"]


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", ["paper, dmmd", "paper, tally", "team, census", "faults, census"])
def test_the_reference_gives_the_same_bytes(name):
    seed, scenario = next((seed, each) for own, seed, each in scenarios() if own == name)
    assert digest(scenario, seed, "reference") == KEPT["hashes"][name]


if __name__ == "__main__":
    hashes = {name: digest(scenario, seed) for name, seed, scenario in scenarios()}
    kept = {**KEPT, "model_version": MODEL_VERSION, "hashes": hashes}
    HASHES.write_text(json.dumps(kept, indent=1) + "\n")
