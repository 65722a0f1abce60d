"""The benchmark: its frozen suite, cards and whether they can be checked, and the board."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from commands import invoke

from feasibee import simulate, truth
from feasibee.base.codes import MODEL_VERSION
from feasibee.base.errors import FeasibeeError
from feasibee.results.statistics import declare_times
from feasibee.scenario.runs import Runs
from feasibee.simulation.sweep import Rounds
from feasibee.strategies import STRATEGIES
from feasibee.studies.benchmark import (
    SIDES,
    Card,
    Contender,
    Row,
    Suite,
    again,
    behind,
    benchmark,
    board,
    designs_of,
    gaps,
    in_words,
    rows_of,
    standings,
    write_board,
)

FROZEN = "784bb0a19e6de2c07bbb768cee8c03efbc505c1ee4871481a7d5fbf11cd4a73f"
"""SHA-256 of the first suite. Never change it: make a second suite."""

SMALL = """
[[world]]
name = "near"
group = "ratio"
about = "near"
known = 1.0
set = { run.steps = 60, robots.count = 6, arena.side = 8.0 }
sides = [{ tasks.count = 3 }, { tasks.count = 9 }]

[[world]]
name = "change"
group = "change"
about = "a change"
runs = 0.5
set = { run.steps = 40, robots.count = 4, arena.side = 6.0 }
sides = [
  { tasks.count = 3, events = [{ step = 20, tasks = 3 }] },
  { tasks.count = 6, events = [{ step = 20, tasks = -3 }] },
]
"""


@pytest.fixture
def small(monkeypatch):
    """Let the suite have two small worlds."""
    monkeypatch.setattr(Suite, "read", classmethod(lambda cls, version="1": cls(version, SMALL)))


@pytest.fixture
def mine(tmp_path):
    """Return the path of a strategy of one's own."""
    path = tmp_path / "mine.py"
    path.write_text(Path("examples/strategies/witness.py").read_text())
    return path


def test_the_first_suite_is_frozen():
    assert Suite.read("1").digest == FROZEN


def test_each_world_has_a_feasible_and_an_infeasible_side():
    """For the strategies of all kinds that take it, and it is taken by several."""
    for world in Suite.read().worlds:
        taken = 0
        for strategy in STRATEGIES:
            try:
                sides = [world.scenario(side, strategy) for side in SIDES]
            except FeasibeeError:
                continue
            taken += 1
            assert [bool(truth(each)) for each in sides] == [True, False], world.name
            assert [each.decision.strategy for each in sides] == [strategy, strategy]
        assert taken >= 5, world.name


def test_rows_are_what_simulate_says(small):
    card = benchmark(["tally", "quiet-census"], runs=30, seed=7)
    world = Suite.read().worlds[0]
    for strategy in ("tally", "quiet-census"):
        rows = {row.side: row for row in card.rows if (row.contender, row.world) == (strategy, "near")}
        for place, side in enumerate(SIDES):
            scenario = world.scenario(side, strategy)
            assert scenario.robots.know_count == STRATEGIES[strategy].needs_count
            found = simulate(scenario, runs=30, seed=7, first_run=Runs.of_point(place, 30, 7).first)
            held = found.feasible_at_end if side == "feasible" else found.infeasible_at_end
            row = rows[side]
            assert row.runs == 30
            assert row.right == (held.values > 0.9 * 6).sum()
            steps = found.decision_step.values
            assert row.median == declare_times(steps).median
            assert row.bits == pytest.approx(found.bits_sent.values.mean() / (6 * 60), abs=1e-6)
    assert card.contenders["tally"].given == ()
    assert set(card.contenders["quiet-census"].given) == {"names", "ids"}
    assert {row.ok for row in card.rows if row.contender == "tally"} == {None}


def test_a_world_takes_its_share_of_the_runs(small):
    card = benchmark(["tally"], runs=9, seed=1)
    assert {(row.world, row.runs) for row in card.rows} == {("near", 9), ("change", 4)}


def test_a_world_that_changes_is_judged_by_steps(small):
    row = next(row for row in benchmark(["dmmd"], runs=40, seed=3).rows if row.world == "change")
    assert row.right != round(row.right)
    assert row.brier is None


def test_worlds_that_a_strategy_cannot_take_have_no_rows():
    worlds = {point.values["world"] for point, _ in designs_of(Suite.read().worlds, {"quiet-census": ""}, 0)}
    everything = {world.name for world in Suite.read().worlds}
    assert everything - worlds == {
        "false robots", "false tasks", "bursts", "lost robots", "one change", "stream", "skills"
    }  # fmt: skip


def test_a_card_is_the_same_when_it_is_simulated_again(small, mine, tmp_path):
    card = benchmark(["tally", str(mine)], runs=12, seed=5)
    card.write(tmp_path / "card.json")
    read = Card.read(tmp_path / "card.json")
    assert read == card
    assert read.contenders["mine.py"].source == mine.read_text()
    mine.unlink()  # the card has its text
    with pytest.raises(FeasibeeError, match=r"mine\.py: its text came with these results.*--trust"):
        again(read, trust=False)
    assert again(read, trust=True) == []


def test_what_differs_from_a_card_is_named(small, tmp_path):
    card = benchmark(["tally"], runs=6, seed=5)
    one, *others, last = card.rows
    false = card.model_copy(
        update={
            "rows": (one._replace(right=one.right - 1), *others),
            "contenders": {"tally": card.contenders["tally"].model_copy(update={"given": ("names",)})},
        }
    )
    lines = again(false, trust=False)
    assert lines[0] == f"tally, near, feasible: right was {one.right - 1}, is {one.right}"
    assert lines[1] == f"tally, {last.world}, {last.side}: isn't on the card"
    assert lines[2].startswith("tally: given ('names',)")
    assert len(lines) == 3


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        (lambda card: card | {"rows": [["a", "b"]]}, "rows.0"),
        (lambda card: card | {"seed": -1}, "seed"),
        (lambda card: card | {"more": 1}, "more"),
        (lambda card: card | {"\x1b[2J": 1}, r"benchmark: [^\x1b]*2J"),
        (lambda card: card | {"contenders": {"\u202ex": {"source": "x"}}}, "contenders"),
        (lambda card: card | {"rows": [["\x1b[2J", *card["rows"][0][1:]]]}, "rows.0"),
        (lambda card: card | {"contenders": {"secret.py": {}}}, "neither built in, nor is its text there"),
        (lambda card: card | {"rows": [[*card["rows"][0][:4], "NaN", *card["rows"][0][5:]]]}, "rows.0"),
    ],
)
def test_a_file_that_is_no_card_is_an_error(small, tmp_path, change, rule):
    path = tmp_path / "card.json"
    benchmark(["tally"], runs=1).write(path)
    path.write_text(json.dumps(change(json.loads(path.read_text()))))
    with pytest.raises(FeasibeeError, match=rule) as raised:
        Card.read(path)
    assert "\x1b" not in str(raised.value)


def test_a_card_of_another_suite_is_refused(small, tmp_path):
    card = benchmark(["tally"], runs=1).model_copy(update={"suite_sha256": "0" * 64})
    with pytest.raises(FeasibeeError, match=r"suite 1 .0000000000000000., which this version lacks"):
        again(card, trust=False)


def made(rows, given=()):
    """Return a card of the two small worlds with rows by contender: right runs of 100 of each side."""
    return Card(
        suite="1",
        suite_sha256=Suite.read().digest,
        version="0",
        model_version=MODEL_VERSION,
        seed=0,
        runs=100,
        contenders={name: Contender(source="x", given=given) for name in rows},
        rows=tuple(
            Row(name, world, side, 100, right, None, None, 10, None, 2.0, None if world == "change" else 0.25)
            for name, found in rows.items()
            for (world, side), right in found.items()
        ),
    )


BOTH = [(world, side) for world in ("near", "change") for side in SIDES]


def test_a_world_that_is_not_taken_counts_as_a_coin(small):
    card = made({"a": dict.fromkeys(BOTH[:2], 100.0)})
    ((found,),) = standings(card).values()
    assert found.right.estimate == pytest.approx((1 + 1 + 0.5 + 0.5) / 4)
    assert found.worlds == {"near": 1.0, "change": None}
    assert (found.word, found.median, found.p95, found.brier) == (None, 10, None, 0.25)


def test_contenders_rank_within_their_class(small):
    weak = made({"b": dict(zip(BOTH, (50.0, 50.0, 20.0, 80.0), strict=True))})
    strong = made({"a": dict.fromkeys(BOTH, 90.0)}, given=("names",))
    between = made({"c": dict(zip(BOTH, (60.0, 60.0, 20.0, 20.0), strict=True))})
    classes = standings(weak.joined(strong).joined(between))
    assert [[each.contender for each in group] for group in classes.values()] == [["a"], ["b", "c"]]
    group = classes["nothing"]
    assert gaps(group, "c") == [("change", pytest.approx(0.2), "b", 0.5)]
    assert gaps(group, "b") == [("near", 0.5, "c", pytest.approx(0.6))]
    (place,) = in_words(classes, ["c"])
    assert place.startswith("c is number 2 of 2 that are given nothing: right in 40 % of the runs (")
    assert [*behind(classes, ["c"])] == ["c is furthest behind in change (20 %, b 50 %)."]
    assert [line.split()[0] for line in in_words(classes, ())] == ["a", "b"]


def test_intervals_are_wide_enough(small):
    """Of cards whose runs are drawn, at least 95 % of the intervals hold the true share."""
    draw, rates = np.random.default_rng(1), (0.02, 0.9, 0.5, 1.0)
    inside = 0
    for _ in range(400):
        rights = draw.binomial(100, rates)
        ((found,),) = standings(made({"a": dict(zip(BOTH, map(float, rights), strict=True))})).values()
        inside += found.right.low <= math.fsum(rates) / 4 <= found.right.high
    assert inside / 400 >= 0.94


def test_the_board_of_built_in_strategies_is_of_this_model():
    card = board()
    assert (card.suite_sha256, card.model_version) == (Suite.read().digest, MODEL_VERSION), "make it again"
    assert list(card.contenders) == list(STRATEGIES)


@pytest.mark.parametrize(
    "world",
    ["near", *(pytest.param(name, marks=pytest.mark.slow) for name in ("five", "bursts", "stream", "rooms"))],
)
def test_the_board_of_built_in_strategies_can_be_checked(world):
    card = board()
    names = [name for name in STRATEGIES if name in ("dmmd", "quiet-census", "tally", "roster")]
    designs = [
        each for each in designs_of(card.worlds, dict.fromkeys(names, ""), card.seed)
        if each[0].values["world"] == world
    ]  # fmt: skip
    with Rounds() as rounds:
        found = rows_of(rounds, designs, card.runs, card.seed)
    assert found == [row for row in card.rows if row.world == world and row.contender in names]


def test_the_command_writes_a_page_and_a_card_that_reproduce_checks(small, mine, tmp_path, monkeypatch):
    monkeypatch.setattr("feasibee.studies.benchmark.board", lambda: benchmark(["tally", "dmmd"], runs=4))
    out = tmp_path / "out"
    answer = invoke("benchmark", mine, "--runs", 8, "--out", out)
    assert "mine.py is number" in answer.output
    page = (out / "benchmark.html").read_text()
    assert page.index('<th scope="row">mine.py') > 0
    assert "tally" in page
    assert "could be known" in page
    card = out / "benchmark.json"
    assert "All results are the same" in invoke("run", "--again", card, "--trust").output
    text = card.read_text()
    card.write_text(
        text.replace('["mine.py", "near", "feasible", 8, ', '["mine.py", "near", "feasible", 8, 1')
    )
    found = invoke("run", "--again", card, "--trust")
    assert found.exit_code == 1
    assert "mine.py, near, feasible: right was" in found.output


def test_the_seed_is_drawn(small, tmp_path):
    seeds = set()
    for name in "ab":
        invoke("benchmark", "tally", "--runs", 1, "--out", tmp_path / name)
        seeds.add(Card.read(tmp_path / name / "benchmark.json").seed)
    assert len(seeds) == 2


def test_the_page_puts_named_contenders_first(small, tmp_path):
    card = made({"a": dict.fromkeys(BOTH, 90.0)}, given=("names",)).joined(
        made({"b": dict.fromkeys(BOTH, 50.0)})
    )
    write_board(tmp_path / "page.html", card, ["b"], "feasibee benchmark b")
    page = (tmp_path / "page.html").read_text()
    assert page.index("Given nothing") < page.index("Given names of tasks")


@pytest.mark.parametrize("name", ["a\u202eb.py", "caf\udce9.py", "a\nb.py"])
def test_a_name_that_no_card_may_have_is_refused_before_any_run(name):
    with pytest.raises(FeasibeeError, match=r"\.py: must be a printable line.*; rename the file"):
        benchmark([f"folder/{name}"])
