"""Limits: equal to what numpy computes from a swarm's positions, and to worlds done by hand."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from commands import invoke, refused_in_a_line

from feasibee import FeasibeeError, Scenario, Swarm
from feasibee.figures.limits import LOOKS, draw_limits
from feasibee.model.purposes import LOSS, MISS_TASK, PAIR
from feasibee.reference.draws import philox
from feasibee.studies.limits import LIMITS, Limits, _quorum_step, limits, limits_at

WALLED = {"arena.boundary": "walls", "arena.side": [12.0, 9.0], "robots.avoid_collisions": True}
WORLDS = [
    {},
    {"tasks.count": 5, "arena.side": 12.0},
    {"tasks.count": 40},
    {"arena.side": [26.0, 11.0], "radio.range": 3.5, "sensing.range": 1.7},
    WALLED,
    {"robots.count": 40, "arena.side": 24.0, "tasks.count": 41, "decision.threshold": 0.55},
    {"faults.stopped": 0.4, "faults.stop_step": 25, "arena.side": 13.0, "tasks.count": 6},
    {"faults.byzantine": 0.2, "faults.byzantine_says": "colluding", "arena.side": 14.0},
    {"decision.start": "first-sight", "decision.listen": "dissemination", "decision.gain": 25.0},
    {"robots.speed": 0.5, "arena.side": 10.0, "radio.loss": 0.5, "sensing.miss": 0.4, "tasks.count": 9},
]


class Oracle:
    """What robots can know, by numpy alone, with all pairs and all cells at each step.

    The places are those of the scenario's own swarm, whatever its phases.
    """

    def __init__(self, scenario, seed, run):
        self.scenario = scenario
        self.swarm, self.run = Swarm(scenario, seed, run), (seed, run)
        self.size = np.array(scenario.arena.size)
        self.torus = scenario.arena.boundary == "torus"
        self.honest = self.swarm.counted
        sight = scenario.sensing.range
        across, down = (math.ceil(4 * side / sight) for side in scenario.arena.size)
        places = ((np.arange(n) + 0.5) * side / n for n, side in zip((across, down), self.size, strict=True))
        self.centres = np.stack([each.ravel() for each in np.meshgrid(*places)], axis=-1)
        robots = scenario.robots.count
        self.names = np.zeros((robots, scenario.tasks.count), bool)
        self.cells = np.zeros((robots, across * down), bool)
        self.own_names, self.own_cells = self.names.copy(), self.cells.copy()

    def distance(self, one, other):
        apart = np.abs(one[:, None] - other[None])
        if self.torus:
            apart = np.minimum(apart, self.size - apart)
        return np.hypot(apart[..., 0], apart[..., 1])

    def happens(self, shape, purpose, probability):
        """Return whether an event happens to each robot with each other, drawn as the reference does."""
        found = np.zeros(shape, bool)
        for i, k in np.ndindex(shape) if probability else ():
            word = philox(*self.run, i, self.swarm.step, purpose + PAIR * k)[0]
            found[i, k] = word < probability * 2**32
        return found

    def step(self):
        swarm, scenario = self.swarm, self.scenario
        swarm.advance()
        working = np.ones(len(self.honest), bool)
        if scenario.faults.stopped and swarm.step >= scenario.faults.stop_step:
            working = swarm.counted | ~self.honest
        at = swarm.positions
        told = (self.names.copy(), self.cells.copy())
        seen = (self.distance(at, swarm.tasks) <= scenario.sensing.range) & working[:, None]
        seen &= ~self.happens(seen.shape, MISS_TASK, scenario.sensing.miss)
        looked = (self.distance(at, self.centres) <= scenario.sensing.range) & working[:, None]
        self.own_names |= seen
        self.own_cells |= looked
        hears = (self.distance(at, at) <= scenario.radio.range) & (working & self.honest)[None, :]
        hears &= working[:, None] & ~self.happens(hears.shape, LOSS, scenario.radio.loss)
        for known, fresh, message in zip((self.names, self.cells), (seen, looked), told, strict=True):
            np.logical_or(known, fresh | (hears[:, :, None] & message[None]).any(axis=1), out=known)

    def limits(self):
        scenario = self.scenario
        enough = min(scenario.tasks.count, scenario.robots.count + 1)
        found = dict.fromkeys(LIMITS, -1)
        while -1 in found.values() and self.swarm.step < scenario.run.steps:
            self.step()
            counted = self.swarm.counted
            share = scenario.decision.threshold * counted.sum()
            reached = {
                "pooled": self.own_names[self.honest].any(axis=0).sum() >= enough,
                "flooding": (self.names.sum(axis=1) >= enough)[counted].sum() > share + 1e-9,
                "area": self.own_cells[self.honest].any(axis=0).all(),
                "complete_map": self.cells.all(axis=1)[counted].sum() > share + 1e-9,
            }
            for name, now in reached.items():
                if now and found[name] < 0:
                    found[name] = self.swarm.step
        return found


@pytest.mark.quick(3)
@pytest.mark.parametrize("changes", WORLDS, ids=str)
def test_limits_are_those_of_the_positions_step_by_step(changes):
    scenario = Scenario().replace({"run.steps": 400, **changes})
    found = limits(scenario, runs=2, seed=7)
    for run in range(2):
        assert {name: int(steps[run]) for name, steps in found.steps.items()} == Oracle(
            scenario, 7, run
        ).limits()


@pytest.mark.parametrize("changes", [WORLDS[k] for k in (0, 4, 6, 9)], ids=str)
def test_limits_of_several_numbers_of_tasks_are_those_of_each(changes):
    """All come from one swarm, with the largest number of tasks."""
    scenario = Scenario().replace(changes)
    numbers = (scenario.tasks.count, 0, scenario.robots.count + 1, 2)
    worlds = {number: scenario.replace({"tasks.count": number}) for number in numbers}
    for number, found in limits_at(worlds, 3, 5).items():
        alone = limits(worlds[number], 3, 5)
        assert found.scenario == alone.scenario
        assert found.cell == alone.cell
        assert {name: steps.tolist() for name, steps in found.steps.items()} == {
            name: steps.tolist() for name, steps in alone.steps.items()
        }


def test_without_tasks_all_names_are_known_at_the_start():
    found = limits(Scenario(tasks={"count": 0}), runs=3, seed=1)
    assert found.steps["pooled"].tolist() == found.steps["flooding"].tolist() == [0, 0, 0]
    assert (found.steps["area"] > 0).all()


def test_threads_strategy_and_phases_change_nothing():
    one = limits(Scenario(), runs=6, seed=3, threads=1)
    rule = {"quorum": 0.9, "rounds": 3, "heard": 3}
    other = Scenario(decision={"strategy": "tally", "declare": rule}, sensing={"false_tasks": 0.1})
    misnamed = Scenario(decision={"strategy": "census"}, sensing={"misname": 0.1})
    phases = {"decision.gain": 1.0, "decision.exploration": 40.0, "decision.listen": {"last": 1}}
    worlds = {other: 2, misnamed: None, Scenario().replace(phases): None}
    for two in (limits(each, runs=6, seed=3, threads=threads) for each, threads in worlds.items()):
        for name, steps in one.steps.items():
            np.testing.assert_array_equal(steps, two.steps[name])


def test_of_smaller_cells_there_is_more_to_see():
    coarse, fine = (limits(Scenario(), runs=20, seed=5, cells_per_range=cells) for cells in (4, 8))
    assert fine.cell == (0.25, 0.25)
    assert fine.steps["area"].mean() > coarse.steps["area"].mean()
    assert fine.steps["complete_map"].mean() > coarse.steps["complete_map"].mean()
    np.testing.assert_array_equal(fine.steps["flooding"], coarse.steps["flooding"])
    with pytest.raises(FeasibeeError, match="cells_per_range = 0: must be a whole number from 1 to 64"):
        limits(cells_per_range=0)


def test_progress_is_told_up_to_the_end():
    told = []
    limits(Scenario(), runs=4, seed=1, progress=told.append)
    assert told == [0.25, 0.5, 0.75, 1.0]


def test_a_run_that_never_gets_there_counts_as_infinite():
    steps = np.array([5, -1, 7, 6] * 5)
    found = Limits(Scenario(), 0, dict.fromkeys(LIMITS, steps), (0.5, 0.5))
    assert (found.times["area"].median, found.times["area"].p95) == (6, None)
    assert found.to_dict()["area"]["p95"] is None


@pytest.mark.parametrize(
    ("threshold", "knew", "step", "found"),
    [
        (0.5, [1, 1, 1, 49, 0, 0, 1, 1, 0, 0], 60, 49),
        (0.5, [1, 1, 1, 0, 0, 0, 1, 1, 50, 0], 60, -1),  # the sixth knows only when it doesn't count any more
        (0.5, [1, 1, 1, 1, 0, 0, 0, 0, 0, 0], 49, -1),
        (0.5, [1, 1, 1, 1, 0, 0, 0, 0, 0, 0], 50, 50),
        (0.5, [1, 1, 1, 55, 0, 0, 0, 0, 0, 0], 60, 55),
        (0.58, range(1, 51), 49, 30),  # 29 of 50 aren't more than 58 %; in floats, 0.58 * 50 is less than 29
    ],
)
def test_more_than_half_of_ten_robots_are_six_and_when_four_have_stopped_they_are_four(
    threshold, knew, step, found
):
    scenario = Scenario(decision={"threshold": threshold}, faults={"stopped": 0.4, "stop_step": 50})
    swarm = SimpleNamespace(scenario=scenario, step=step, counted=np.arange(len(knew)) < 6)
    assert _quorum_step(swarm, np.ones(len(knew), np.bool_), np.array(knew)) == found


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (
            {"robots.count": 2000, "arena.side": 200.0},
            "sensing.range = 2.0: 2000 robots with 160000 cells take",
        ),
        ({"tasks.classes": [{"name": "a", "count": 3, "needs": {"x": 1}}]}, "tasks.classes"),
        ({"robots.classes": [{"name": "a", "count": 3, "skills": ["x"]}]}, "use robots.count instead"),
    ],
)
def test_worlds_without_limits_are_refused(changes, told):
    with pytest.raises(FeasibeeError, match=told):
        limits(Scenario().replace(changes), runs=1)


def test_the_remedy_for_a_large_world_is_enough():
    wide = Scenario().replace({"sensing.range": 0.05, "radio.range": 2.0, "run.steps": 1})
    with pytest.raises(FeasibeeError, match="use fewer robots, a smaller arena, or a range of") as error:
        limits(wide, runs=1)
    fitting = float(str(error.value).rsplit(" ", 1)[1])
    assert limits(wide.replace({"sensing.range": fitting}), runs=1).runs == 1


def test_the_command_prints_a_table_json_and_a_figure(tmp_path):
    asked = ("compare", "--limits", "--strategies", "none", "--set", "run.steps=80")
    arguments = (*asked, "--runs", 10, "--seed", 1)
    done = invoke(*arguments, "--out", tmp_path)
    assert done.exit_code == 0, done.output
    assert "complete map" in done.stdout
    assert "never" in done.stdout
    assert "flooding" in done.stdout
    done = invoke(*arguments, "--json", "--out", tmp_path)
    (found,) = json.loads(done.stdout)
    assert found == limits(Scenario(run={"steps": 80}), runs=10, seed=1).to_dict()
    assert list(found)[:6] == [*LIMITS, "bounds", "cell"]
    assert (found["runs"], found["seed"]) == (10, 1)
    assert found["scenario_hash"] == Scenario(run={"steps": 80}).hash
    assert set(found["flooding"]) == {"median", "p95", "median_interval", "p95_interval"}
    assert found["bounds"] == {"infeasible": "flooding", "proved_feasible": "complete_map"}
    assert found["cell"] == [0.5, 0.5]
    assert (tmp_path / "limits-20.png").stat().st_size > 10_000


def test_the_command_refuses_before_it_computes():
    asked = ("compare", "--limits", "--strategies", "none")
    classes = 'robots.classes=[{name="a", count=3, skills=["x"]}]'
    assert "robots.classes" in refused_in_a_line(*asked, "--set", classes)
    assert "--limits" in refused_in_a_line("compare", "--strategies", "none")
    assert "--presets" in refused_in_a_line("compare", "--limits", "--presets", "default")


def test_a_curve_rises_at_the_steps_of_the_runs():
    steps = {name: np.array([10, 20, 30, -1]) + 10 * k for k, name in enumerate(LIMITS)}
    steps = {name: np.where(each < 10, -1, each) for name, each in steps.items()}
    drawn = draw_limits(steps, 100)
    (ax,) = drawn.axes
    shown = [name for name in LOOKS if name in LIMITS]  # others need acting
    curves = dict(zip(shown, ax.get_lines(), strict=True))
    for name, line in curves.items():
        reached = np.sort(steps[name][steps[name] >= 0])
        x, y = line.get_data()
        np.testing.assert_array_equal(x, [0, *reached, 100])
        np.testing.assert_allclose(y, 100 * np.array([*range(reached.size + 1), reached.size]) / 4)
    assert {text.get_text().strip() for text in ax.texts} == {name.replace("_", " ") for name in shown}
    (ax,) = draw_limits({**steps, "area": np.full(4, -1)}, 100).axes
    assert "area: never" in {text.get_text().strip() for text in ax.texts}


def test_limits_warn_where_quiet_times_were_not_tested(tmp_path):
    asked = ("compare", "--limits", "--strategies", "none", "--runs", "1", "--set", "run.steps=5")
    asked = (*asked, "--out", tmp_path, "--set")
    warning = "not tested here (mean run in steps 0.5, tested 1 to 100)"
    assert warning in invoke(*asked, "walk.mean_run=0.5").output
    assert "not tested" not in invoke(*asked, "walk.mean_run=1").output
