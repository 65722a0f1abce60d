"""Figures show what the data say: read back from the Axes."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from declaring import declaring
from matplotlib import pyplot, rcParams
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Wedge

from feasibee import (
    FeasibeeError,
    Scenario,
    Swarm,
    plot_arena,
    plot_decision_steps,
    plot_decisions,
    plot_opinions,
    wilson,
)
from feasibee.base.codes import COLOURS
from feasibee.base.record import Record
from feasibee.figures.comparison import draw_against_ratio
from feasibee.figures.decisions import Panel, draw_panels, plot_declare_steps, plot_right_steps
from feasibee.figures.style import figure, save_figure
from feasibee.results.dataset import to_dataset
from feasibee.results.statistics import opinion_quartiles

SCENARIO = Scenario(robots={"count": 10}, run={"steps": 5})


def results_of(decisions, steps, curves, scenario=SCENARIO):
    """Make results of runs of ten robots, each with an opinion, from curves that end with -1."""
    curves = np.array(curves, np.int32)
    record = replace(
        Record.empty(0, len(curves), 0),
        decision=np.array(decisions, np.int8),
        decision_step=np.array(steps, np.int32),
        feasible_count=curves,
        infeasible_count=np.where(curves < 0, -1, 10 - curves).astype(np.int32),
    )
    return to_dataset(record, scenario, seed=0)


RESULTS = results_of(
    [1, 0, 1, -1], [4, 2, 0, -1], [[5, 6, 7, 8, 10, 10], [4, 2, 0, 0, 0, 0], [10] * 6, [5] * 6]
)


def swarm_at(places, targets=((1.0, 2.0),), opinions=None, declared=None, **scenario):
    """Make what plot_arena looks at, at places of our choice."""
    return SimpleNamespace(
        scenario=Scenario(**scenario),
        positions=np.array(places, float),
        present=np.ones(len(places), bool),
        headings=np.zeros(len(places)),
        tasks=np.array(targets, float).reshape(-1, 2),
        opinions=np.array(opinions or [1] * len(places), np.int8),
        declared=np.array(declared or [-1] * len(places), np.int8),
    )


def discs(ax, radius):
    return [patch for patch in ax.patches if isinstance(patch, Circle) and patch.radius == radius]


def shown_numbers(ax):
    return sorted(int(text.get_text()) for text in ax.texts)


def legend_labels(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def texts(ax):
    return {text.get_text().strip() for text in ax.texts}


def lines_by_label(ax):
    return {line.get_label(): line for line in ax.lines}


def band(collection):
    """Return lower and upper edge of a filled band, by step."""
    edges = {}
    for x, y in collection.get_paths()[0].vertices:
        edges.setdefault(x, set()).add(round(float(y), 9))
    return {x: (min(ys), max(ys)) for x, ys in sorted(edges.items())}


# --- The arena ---


def test_a_view_is_drawn_about_each_heading():
    scenario = Scenario(arena={"boundary": "walls"}, robots={"count": 3}, sensing={"view": 90})
    swarm = Swarm(scenario, seed=2)
    views = [patch for patch in plot_arena(swarm).patches if isinstance(patch, Wedge)]
    assert [patch.r for patch in views] == [2.0] * 3
    middles = [(patch.theta1 + patch.theta2) / 2 for patch in views]
    assert middles == pytest.approx(np.degrees(swarm.headings))
    assert [patch.theta2 - patch.theta1 for patch in views] == pytest.approx([90] * 3)


def test_the_arena_shows_each_task_and_each_robot_with_number_range_and_opinion():
    places, targets = [(5.0, 5.0), (10.0, 12.0), (17.0, 3.0)], [(1.0, 2.0), (19.0, 0.5)]
    swarm = swarm_at(places, targets, opinions=[1, 0, 1], sensing={"range": 2.5})
    ax = plot_arena(swarm)
    (tasks,) = ax.collections
    np.testing.assert_array_equal(tasks.get_offsets(), targets)
    assert len(tasks.get_paths()[0].vertices) == 4  # a closed triangle
    assert [[patch.center for patch in discs(ax, radius)] for radius in (0.5, 2.5)] == [places, places]
    colours = [to_hex(patch.get_facecolor()).upper() for patch in discs(ax, 0.5)]
    assert colours == [COLOURS["feasible"], COLOURS["infeasible"], COLOURS["feasible"]]
    assert [(text.get_text(), text.xy) for text in ax.texts] == list(zip("123", places, strict=True))


def test_an_opinion_has_a_shape_in_addition_to_its_colour():
    places = [(5.0, 5.0), (10.0, 12.0), (17.0, 3.0)]
    ax = plot_arena(swarm_at(places, opinions=[1, 0, -1]))
    bodies = [patch for patch in ax.patches if isinstance(patch, Circle) and patch.radius <= 0.5]
    looks = [(patch.center, to_hex(patch.get_facecolor()).upper(), patch.radius < 0.5) for patch in bodies]
    full, outer, hole, small = looks
    assert full == (places[0], COLOURS["feasible"], False)
    assert (outer, hole) == ((places[1], COLOURS["infeasible"], False), (places[1], "#FFFFFF", True))
    assert small == (places[2], COLOURS["undecided"], True)
    assert [text.get_color() == "white" for text in ax.texts] == [True, False, True]
    assert legend_labels(ax) == ["feasible", "infeasible", "no opinion", "task", "range"]


def test_a_robot_that_has_declared_has_a_rim():
    ax = plot_arena(swarm_at([(5, 5), (9, 9), (15, 5)], opinions=[1, 0, 1], declared=[1, 0, -1]))
    rims = {patch.center: patch.get_linewidth() > 0 for patch in discs(ax, 0.5)}
    assert rims == {(5, 5): True, (9, 9): True, (15, 5): False}


def test_a_range_that_reaches_over_the_edge_comes_in_on_the_other_side():
    ax = plot_arena(swarm_at([(19.5, 0.5)]))
    expected = sorted([(19.5, 0.5), (-0.5, 0.5), (19.5, 20.5), (-0.5, 20.5)])
    assert sorted(patch.center for patch in discs(ax, 2.0)) == expected
    assert sorted(patch.center for patch in discs(ax, 0.5)) == expected
    ax = plot_arena(swarm_at([(10.0, 1.0)]))
    assert sorted(patch.center for patch in discs(ax, 2.0)) == [(10.0, 1.0), (10.0, 21.0)]
    ax = plot_arena(swarm_at([(0.5, 11.5)], arena={"side": [30.0, 12.0]}))
    expected = [(0.5, -0.5), (0.5, 11.5), (30.5, -0.5), (30.5, 11.5)]
    assert sorted(patch.center for patch in discs(ax, 2.0)) == expected


@pytest.mark.parametrize("side", [20.0, 7.3, 13.37, 0.7, 1e-3, 1e6])
def test_the_axes_end_where_the_arena_ends(side):
    scaled = {"arena": {"side": side}, "sensing": {"range": side / 10}, "robots": {"speed": side / 20}}
    ax = plot_arena(swarm_at([(side / 2, side / 3)], targets=[(side / 4, side / 4)], **scaled))
    assert ax.get_xlim() == ax.get_ylim() == (0, side)
    assert ax.get_aspect() == 1
    np.testing.assert_array_equal(ax.get_xticks(), ax.get_yticks())
    assert len([tick for tick in ax.get_xticks() if 0 <= tick <= side]) >= 3


def test_the_arena_has_units_and_a_legend_with_declarations_only_if_robots_can_declare(tmp_path):
    ax = plot_arena(swarm_at([(5.0, 5.0)]))
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x (units)", "y (units)")
    assert legend_labels(ax) == ["feasible", "infeasible", "task", "range"]
    ax = plot_arena(Swarm(declaring(tmp_path)))
    assert legend_labels(ax) == ["feasible", "infeasible", "declared", "task", "range"]


SHAPES = [
    {"side": [30.0, 12.0]},
    {"side": [12.0, 30.0]},
    {"side": [30.0, 12.0], "boundary": "walls"},
    {"side": [12.0, 30.0], "boundary": "walls"},
    {"side": [500.0, 10.0], "boundary": "walls"},
    {"boundary": "walls"},
]


@pytest.mark.quick(2)
@pytest.mark.parametrize("arena", [{}, *SHAPES])
def test_an_arena_of_any_shape_is_drawn_whole(arena, tmp_path):
    """It failed on every rectangle, and cut the legend off."""
    swarm = Swarm(Scenario(arena=arena), seed=1)
    ax = plot_arena(swarm)
    width, height = swarm.scenario.arena.size
    assert (ax.get_xlim(), ax.get_ylim()) == ((0, width), (0, height))
    assert ax.get_aspect() == 1
    assert shown_numbers(ax)[:20] == sorted(shown_numbers(ax))[:20]
    assert set(shown_numbers(ax)) == set(range(1, 21))
    save_figure(ax.figure, tmp_path / "arena.png")
    legend = ax.get_legend().get_window_extent()
    assert ax.figure.bbox.x0 <= legend.x0
    assert legend.x1 <= ax.figure.bbox.x1
    assert legend.y1 <= ax.figure.bbox.y1


@pytest.mark.parametrize("arena", [each for each in SHAPES if "boundary" in each])
def test_nothing_comes_in_through_a_wall(arena):
    width, height = Scenario(arena=arena).arena.size
    places = [(0.5, 0.5), (width - 0.5, height - 0.5), (0.5, height / 2)]
    ax = plot_arena(swarm_at(places, arena=arena))
    assert [patch.center for patch in discs(ax, 2.0)] == places
    assert ax.spines["left"].get_linewidth() > 2


def test_robots_are_as_large_as_they_are():
    ax = plot_arena(swarm_at([(5.0, 5.0)], robots={"diameter": 3.0}))
    assert [patch.center for patch in discs(ax, 1.5)] == [(5.0, 5.0)]


# --- What isn't a swarm, results or axes ---

ONE = {"feasible": [wilson(1, 2)]}
DRAWINGS = {
    "arena": lambda ax: plot_arena(Swarm(seed=1), ax),
    "opinions": lambda ax: plot_opinions(RESULTS, ax),
    "decisions": lambda ax: plot_decisions([1.0], ONE, ax),
    "steps": lambda ax: plot_decision_steps(RESULTS, ax),
}
NO_RATIOS = [[], [0.0], [-1.0], [np.nan], [np.inf], ["x"], None, 5, [[1.0]], [10**400]]
NO_RATES = [None, {}, {"nope": []}, {"feasible": []}, {"feasible": [1]}, {"feasible": None}, [wilson(1, 2)]]
INVALID = [
    ([plot_arena], [None, 5, "x", [], {}, Scenario(), SimpleNamespace(scenario=None)], "must be a Swarm"),
    (DRAWINGS.values(), [5, "x", [], Figure()], "must be Axes of matplotlib"),
    ([plot_opinions, plot_decision_steps], [None, 5, "x", [RESULTS], {"a": 5}], "must be a Dataset"),
    ([lambda each: plot_opinions(RESULTS, until=each)], [0, -1, 1.5, "x", [5]], "until = .* must be a whole"),
    ([lambda each: plot_decisions(each, ONE)], NO_RATIOS, "must be numbers above 0"),
    ([lambda each: plot_decisions([1.0], each)], NO_RATES, "rates"),
    ([plot_opinions], [RESULTS.drop_vars("feasible_count")], "curves"),
    ([plot_declare_steps], [RESULTS], "no declarations"),
    ([plot_right_steps], [RESULTS], "no truth of each step"),
]


@pytest.mark.parametrize(("uses", "values", "told"), INVALID)
def test_what_cant_be_drawn_is_told(uses, values, told):
    for use, value in product(uses, values):
        with pytest.raises(FeasibeeError, match=told):
            use(value)


# --- Opinions over time ---


def test_opinions_are_the_median_and_the_quartile_band():
    ax = plot_opinions(RESULTS)
    low, median, high = opinion_quartiles(RESULTS.feasible_count.values, 10)
    (line,) = ax.lines
    np.testing.assert_array_equal(line.get_xdata(), np.arange(6))
    np.testing.assert_array_equal(line.get_ydata(), median)
    assert line.get_ydata()[0] == 50  # of 4, 5, 5, 10
    expected = {step: (low[step], high[step]) for step in range(6)}
    assert band(ax.collections[0]) == expected
    assert "steps" in ax.get_xlabel()
    assert "%" in ax.get_ylabel()
    assert ax.get_xlim() == (0, 5)
    assert ax.get_ylim()[0] <= 0
    assert ax.get_ylim()[1] >= 100


def test_several_results_are_several_lines_told_apart():
    other = results_of([0], [1], [[9, 8, 7, 6, 5, 4]])
    ax = plot_opinions({"first": RESULTS, "second": other})
    assert [line.get_label() for line in ax.lines] == ["first", "second"]
    np.testing.assert_allclose(lines_by_label(ax)["second"].get_ydata(), [90, 80, 70, 60, 50, 40])
    assert len({to_hex(line.get_color()) for line in ax.lines}) == 2
    assert len({str(line._unscaled_dash_pattern) for line in ax.lines}) == 2
    for line, filled in zip(ax.lines, ax.collections, strict=True):
        assert to_hex(line.get_color()) == to_hex(filled.get_facecolor()[0])


def test_bands_of_different_lengths_are_all_in_view():
    scenarios = {steps: SCENARIO.replace({"run.steps": steps}) for steps in (4, 8, 6)}
    several = {steps: results_of([1], [0], [[5] * (steps + 1)], each) for steps, each in scenarios.items()}
    assert plot_opinions(several).get_xlim() == (0, 8)
    assert plot_opinions(RESULTS, until=3).get_xlim() == (0, 3)


def test_a_run_that_stopped_at_its_decision_keeps_its_opinion_in_the_figure():
    scenario = SCENARIO.replace({"run.stop_at_decision": True})
    ax = plot_opinions(results_of([1], [2], [[5, 8, 10, -1, -1, -1]], scenario))
    np.testing.assert_allclose(ax.lines[0].get_ydata(), [50, 80, 100, 100, 100, 100])


# --- Decisions against the ratio ---

RATIOS = [0.1, 0.5, 1.0, 2.0, 10.0]
RATES = {
    "feasible": [wilson(count, 100) for count in (0, 20, 50, 70, 100)],
    "infeasible": [wilson(count, 100) for count in (97, 75, 45, 25, 0)],
    "undecided": [wilson(count, 100) for count in (3, 5, 5, 5, 0)],
}


def test_decisions_are_the_rates_with_their_intervals():
    ax = plot_decisions(RATIOS, RATES)
    assert [container.get_label() for container in ax.containers] == list(RATES)
    for container, intervals in zip(ax.containers, RATES.values(), strict=True):
        line, _, (bars,) = container.lines
        np.testing.assert_array_equal(line.get_xdata(), RATIOS)
        np.testing.assert_allclose(line.get_ydata(), [100 * interval.estimate for interval in intervals])
        ends = [[(x, 100 * i.low), (x, 100 * i.high)] for x, i in zip(RATIOS, intervals, strict=True)]
        np.testing.assert_allclose(bars.get_segments(), ends, atol=1e-9)
    looks = [(to_hex(each.lines[0].get_color()), each.lines[0].get_marker()) for each in ax.containers]
    assert [len(set(each)) for each in zip(*looks, strict=True)] == [3, 3]


def test_decisions_are_named_at_the_ends_of_their_lines():
    ax = plot_decisions(RATIOS, RATES)
    assert "%" in ax.get_ylabel()
    assert texts(ax) == {"feasible", "infeasible", "undecided"}
    assert ax.get_legend() is None


OVER_RATIOS = {
    "decisions": lambda: plot_decisions(RATIOS, RATES).figure,
    "panels": lambda: draw_panels([Panel("one", RATIOS, RATES, 1.0)]),
    "contenders": lambda: draw_against_ratio(20, [100, 2, 200], {"a": RATES["feasible"][:3]}),
}


@pytest.mark.parametrize("name", OVER_RATIOS)
def test_the_axis_of_ratios_is_the_same_in_all_figures(name):
    drawn = OVER_RATIOS[name]()
    drawn.canvas.draw()
    ax = drawn.axes[0]
    label = ax.get_xlabel() or drawn._supxlabel.get_text()
    assert label.partition(";")[0] == "robots per task $n/m$"
    assert ax.get_xscale() == "log"
    assert ax.get_xlim()[0] < ax.get_xlim()[1]
    shown = [text.get_text() for text in ax.get_xticklabels()]
    assert {"0.1", "0.5", "10"} <= set(shown)
    assert [float(text) for text in shown] == sorted(map(float, shown))
    assert not any(text.get_text() for text in ax.get_xticklabels(minor=True))


def test_contenders_stand_at_their_ratios_in_any_order_of_tasks():
    tasks, shares = [40, 0, 10, 20], [wilson(number, 10) for number in (1, 2, 3, 4)]
    ax = draw_against_ratio(20, tasks, {"a": shares}).axes[0]
    line = ax.lines[0]
    assert line.get_xdata().tolist() == [0.5, 1, 2, 40]  # no task: as if half a task
    np.testing.assert_allclose(line.get_ydata(), [10, 40, 30, 20])
    (above,) = ax.child_axes
    assert [text.get_text() for text in above.get_xticklabels()] == ["40", "20", "10", "0"]
    assert above.get_xlabel() == "number of tasks $m$"


# --- Decisions over time ---


def test_decision_steps_climb_at_each_decision_to_its_share_of_all_runs():
    ax = plot_decision_steps(RESULTS)
    lines = lines_by_label(ax)

    def height(name, step):
        """Read a staircase: its last value at or before a step."""
        x, y = lines[name].get_data()
        return y[np.flatnonzero(x <= step)[-1]]

    assert [height("feasible", step) for step in range(6)] == [25, 25, 25, 25, 50, 50]
    assert [height("infeasible", step) for step in range(6)] == [0, 0, 25, 25, 25, 25]
    assert {lines[name].get_drawstyle() for name in ("feasible", "infeasible")} == {"steps-post"}
    assert {name: to_hex(lines[name].get_color()).upper() for name in ("feasible", "infeasible")} == {
        name: COLOURS[name] for name in ("feasible", "infeasible")
    }
    assert ax.get_xlim() == (0, 5)
    assert "steps" in ax.get_xlabel()
    assert "%" in ax.get_ylabel()


def test_the_step_by_which_half_of_the_runs_had_decided_is_marked():
    ax = plot_decision_steps(RESULTS)
    (marked,) = [line for line in ax.lines if "half" in line.get_label()]
    assert list(marked.get_xdata()) == [2, 2]
    assert "step 2" in marked.get_label()
    assert texts(ax) == {"feasible", "infeasible", marked.get_label()}


def test_no_half_is_marked_when_less_than_half_decided():
    undecided = RESULTS.isel(run=[0, 3, 3])
    ax = plot_decision_steps(undecided)
    assert texts(ax) == {"feasible", "infeasible"}
    assert max(lines_by_label(ax)["feasible"].get_ydata()) == pytest.approx(100 / 3)


# --- Axes and files ---


@pytest.mark.parametrize("name", DRAWINGS)
def test_a_figure_is_drawn_into_the_axes_given_or_into_new_ones(name):
    given_ = Figure().subplots()
    assert DRAWINGS[name](given_) is given_
    made = DRAWINGS[name](None)
    assert isinstance(made, Axes)
    assert made is not given_
    assert len(made.get_figure().axes) == 1


@pytest.mark.parametrize(("name", "suffix"), [("decisions", "png"), ("steps", "pdf"), ("opinions", "svg")])
def test_the_same_figure_is_the_same_bytes_without_a_date(tmp_path, name, suffix):
    files = [tmp_path / f"{number}.{suffix}" for number in range(2)]
    for path in files:
        with figure(3, 2.5) as (drawn, ax):
            DRAWINGS[name](ax)
        save_figure(drawn, path)
    first, second = (path.read_bytes() for path in files)
    assert first == second
    assert first.startswith({"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[suffix])
    assert b"CreationDate" not in first
    assert b"<dc:date>" not in first
    assert sorted(path.name for path in tmp_path.iterdir()) == [path.name for path in files]


def test_a_figure_for_a_missing_folder_is_told(tmp_path):
    with figure(3, 2.5) as (drawn, _), pytest.raises(FeasibeeError, match="can't be written"):
        save_figure(drawn, tmp_path / "missing" / "a.png")


def test_figures_need_no_window_and_leave_the_users_settings():
    before = dict(rcParams)
    for draw in DRAWINGS.values():
        draw(None)
    assert dict(rcParams) == before
    assert pyplot.get_fignums() == []
