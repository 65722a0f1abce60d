"""The cases of the benchmark: short functions that return rows of the table."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from history import YARDSTICK
from measure import (
    NS_OF_WALL,
    NS_PER_ROBOT_STEP,
    Row,
    Sample,
    command_cpu_seconds,
    in_turn,
    peak_mebibytes,
    ratios,
    seconds,
)
from rivals import ByHand, brute_force_sample, has_mesa, mesa_sample
from worlds import (
    BEYOND,
    HALL,
    PAPER_ROBOTS,
    PAPER_STEPS,
    PAPER_TASKS,
    Tables,
    paper,
    robots_of,
    scenario,
    steps_only,
    whole_runs,
    world,
)

import feasibee
from feasibee.simulation.sweep import Execution, Rounds
from feasibee.strategies import STRATEGIES
from feasibee.studies.assess import assess
from feasibee.studies.comparison import compare, contenders_of
from feasibee.studies.report import Assessment

LARGE = 10_000
VAST = 1_000_000
MANY = 2000
LEAST_WORDS = 400
"""Runs of strategies by their own word: the first 100 go on to the last step, later ones may end early."""
KNOWLEDGE_STEPS = 300
KNOWLEDGE_TARGETS = {"tally": 3.0, "census": 3.0}  # million robot-steps per second and core
OPINIONS_TARGET = 20.0

RUN = ["-m", "feasibee", "run", "--set", f"tasks.count={PAPER_TASKS}", "--runs", "100", "--seed", "1"]
BEYOND_RUN = [*RUN, "--set", "arena.boundary=walls", "--set", "robots.avoid_collisions=true"]

PLAY = """
import feasibee
scenario = feasibee.Scenario(**{tables}, run={{"steps": {steps}}})
swarms = feasibee.simulate(scenario, runs={runs}, seed=1, threads=1, curves={curves})
"""


@dataclass(frozen=True)
class Plan:
    """The sizes and numbers of measurements."""

    repeats: int = 9
    large_repeats: int = 5
    vast_repeats: int = 3
    runs: int = 800
    robot_steps: int = 4_000_000
    steps: int = 50
    """Steps of a sample in the tables of growth."""
    sizes: tuple[int, ...] = (20, 32, 33, 64, 100, 316, 1000, 3162, LARGE, 31_623, 100_000, 316_228, VAST)
    rival_sizes: tuple[int, ...] = (20, 100, 316, 1000, 3162, LARGE)
    thread_sizes: tuple[int, ...] = (20, LARGE, 100_000, VAST)
    memory_robots: int = VAST
    processes: int = 2
    answer_runs: int = 400
    """Most runs of a variant in an assessment."""
    rival_robot_steps: int = 10_000
    """Least number of robot-steps of a sample of another program."""


QUICK = Plan(
    repeats=3,
    large_repeats=1,
    vast_repeats=1,
    runs=100,
    robot_steps=400_000,
    steps=20,
    sizes=(20, 32, 33, 100, 1000, LARGE, 100_000),
    rival_sizes=(20, 1000),
    thread_sizes=(20, LARGE),
    memory_robots=100_000,
    processes=1,
    answer_runs=100,
    rival_robot_steps=1000,
)


def paper_swarm(plan: Plan) -> list[Row]:
    """Measure the paper's swarm of 20 robots in feasibee and in other programs."""
    samples = {
        "feasibee": whole_runs(paper(), PAPER_STEPS, plan.runs),
        YARDSTICK: brute_force_sample(plan.runs // 4),
    }
    by_hand = ByHand()
    if by_hand.why:
        print(f"  left out: C by hand, because {by_hand.why}")
    else:
        samples["C by hand, AVX-512, no ids"] = by_hand.sample(plan.runs)
    if has_mesa():
        samples["Mesa"] = mesa_sample()
    else:
        print("  left out: Mesa, because it isn't installed")
    rows = compared(in_turn(samples, plan.repeats), NS_PER_ROBOT_STEP)
    return [row.aiming("ratio", least=6.0 if row.name == YARDSTICK else None) for row in rows]


def compared(taken: dict[str, list[float]], unit: str, to: str | None = None) -> list[Row]:
    """Return a row for each thing that was measured, with its ratio to one of them, by default the first."""
    to = to or next(iter(taken))
    rows = []
    for name, values in taken.items():
        row = Row.of(name, unit, values)
        rows.append(row if name == to else row.compared(ratios(values, taken[to]), to))
    return rows


def strategies(plan: Plan) -> list[Row]:
    """Measure every strategy on the paper's swarm, against the paper's strategy and the target speeds."""
    samples = {}
    for name, strategy in STRATEGIES.items():
        runs = max(1, plan.runs // 8) if strategy.knowledge else plan.runs
        changes: Tables = {"decision": {"strategy": name}, "robots": {"know_count": strategy.needs_count}}
        samples[name] = whole_runs(paper(changes), PAPER_STEPS, runs)
    rows = compared(in_turn(samples, plan.large_repeats), NS_PER_ROBOT_STEP, "dmmd")
    return [row.aiming("speed", least=_target(row.name)) for row in rows]


def _target(name: str) -> float | None:
    return KNOWLEDGE_TARGETS.get(name) if STRATEGIES[name].knowledge else OPINIONS_TARGET


def growth(plan: Plan) -> list[Row]:
    """Measure swarms of all sizes, at the paper's density and with as many tasks as robots."""
    taken = in_turn({_name(each): _steps(plan, world(each, each)) for each in plan.sizes}, plan.vast_repeats)
    rows = []
    for robots in plan.sizes:
        values, base = taken[_name(robots)], 20 if robots <= LARGE else LARGE
        row = Row.of(_name(robots), NS_PER_ROBOT_STEP, values, robots)
        if robots != base:
            row = row.compared(ratios(values, taken[_name(base)]), f"{base:,} robots")
        rows.append(row.aiming("ratio", most=2.0 if robots == VAST else None))
    return rows


def _name(robots: int) -> str:
    return f"{robots:,} robots, {robots:,} tasks"


def _steps(plan: Plan, tables: Tables, robot_steps: int | None = None) -> Sample:
    """Return a sample of enough runs of so many steps that they can be timed."""
    runs = (robot_steps or plan.robot_steps) // (robots_of(tables) * plan.steps)
    return steps_only(tables, plan.steps, max(1, runs))


def others(plan: Plan) -> list[Row]:
    """Measure the other programs at several sizes, in the worlds of the table of growth."""
    rows = []
    for robots in plan.rival_sizes:
        runs = max(1, plan.rival_robot_steps // robots)
        steps = max(2, min(100, 10 * runs))
        ours = "feasibee"
        samples = {ours: _steps(plan, world(robots, robots), plan.robot_steps // 4)}
        samples["brute-force loop"] = brute_force_sample(max(1, runs // steps), robots, robots, steps)
        if has_mesa():
            samples["Mesa"] = mesa_sample(robots, robots, min(steps, max(1, runs)))
        taken = in_turn(samples, max(1, plan.large_repeats // 2))
        for name in list(samples)[1:]:
            row = Row.of(f"{name}, {robots:,} robots", NS_PER_ROBOT_STEP, taken[name], robots)
            rows.append(row.compared(ratios(taken[name], taken[ours]), ours))
    return rows


def threads(plan: Plan) -> list[Row]:
    """Measure one swarm on one thread and on two, in wall time."""
    rows = []
    for robots in plan.thread_sizes:
        steps = max(20, 2 * plan.robot_steps // robots)
        samples = {
            f"{robots:,} robots, {count} thread{'s' * (count > 1)}": steps_only(
                world(robots, robots), steps, 1, count, time.perf_counter
            )
            for count in (1, 2)
        }
        taken = in_turn(samples, plan.large_repeats if robots < VAST else plan.vast_repeats)
        one, two = taken
        row = Row.of(two, NS_OF_WALL, taken[two], robots)
        row = row.compared(ratios(taken[one], taken[two]), "as fast as 1 thread")
        rows += [Row.of(one, NS_OF_WALL, taken[one], robots)]
        rows += [row.aiming("ratio", least=1.8 if robots >= LARGE else 0.95)]
    return rows


def beyond(plan: Plan) -> list[Row]:
    """Measure the worlds beyond the paper: its 20 robots among 100 tasks, and large swarms."""
    samples = {"the paper's world, 20 robots": whole_runs(paper(), PAPER_STEPS, plan.runs // 4)}
    for name, changes in BEYOND.items():
        samples[f"{name}, 20 robots"] = whole_runs(paper(changes), PAPER_STEPS, plan.runs // 8)
    for name, changes in {"the paper's world": {}, **BEYOND}.items():
        large = world(LARGE, LARGE, changes)
        samples[f"{name}, {LARGE:,} robots"] = _steps(plan, large, plan.robot_steps // 4)
    taken = in_turn(samples, plan.large_repeats)
    rows = []
    for name, values in taken.items():
        row, size = Row.of(name, NS_PER_ROBOT_STEP, values), name.partition(", ")[2]
        to = f"the paper's world, {size}"
        rows.append(row if name == to else row.compared(ratios(values, taken[to]), to))
    return rows


def knowledge(plan: Plan) -> list[Row]:
    """Measure strategies that pass on knowledge with 2,000 robots against 20, and their memory."""
    rows = []
    for strategy in ("census", "tally"):
        changes: Tables = {"decision": {"strategy": strategy}}
        few, many = (world(robots, robots, changes) for robots in (PAPER_ROBOTS, MANY))
        names = [f"{strategy}, {robots:,} robots" for robots in (PAPER_ROBOTS, MANY)]
        runs = plan.robot_steps // 4 // (PAPER_ROBOTS * KNOWLEDGE_STEPS)
        samples = {
            names[0]: whole_runs(few, KNOWLEDGE_STEPS, runs),
            names[1]: whole_runs(many, KNOWLEDGE_STEPS, 1),
        }
        small, large = compared(in_turn(samples, max(1, plan.large_repeats // 2)), NS_PER_ROBOT_STEP)
        rows += [small, large.aiming("ratio", most=10.0 if strategy == "census" else None)]
        peak = peak_mebibytes(playing(many, KNOWLEDGE_STEPS)) - peak_mebibytes(playing(few, 1))
        row = Row.of(f"{names[1]}, memory", "MiB", [peak])
        rows.append(row.aiming("best", most=2048.0 if strategy == "census" else None))
    return rows


def playing(tables: Tables, steps: int, runs: int = 1, curves: bool = False) -> str:
    """Return code that simulates some runs on one thread."""
    return PLAY.format(tables=tables, steps=steps, runs=runs, curves=curves)


def start_up(plan: Plan) -> list[Row]:
    """Measure commands: the help, and simulations with an empty cache, and the next one."""
    asked = [command_cpu_seconds(["-m", "feasibee", "--help"]) for _ in range(plan.repeats)]
    first, second, wider = [], [], []
    for _ in range(plan.processes):
        with tempfile.TemporaryDirectory() as folder:
            first.append(command_cpu_seconds(RUN, {"FEASIBEE_CACHE": folder}))
            second.append(command_cpu_seconds(RUN, {"FEASIBEE_CACHE": folder}))
        if plan.processes > 1:
            with tempfile.TemporaryDirectory() as folder:
                wider.append(command_cpu_seconds(BEYOND_RUN, {"FEASIBEE_CACHE": folder}))
    rows = [
        Row.of("feasibee --help", "s", asked),
        Row.of("feasibee run, for the first time", "s", first).aiming("best", most=2.0),
        Row.of("feasibee run, again", "s", second),
    ]
    if wider:
        name = "feasibee run with walls and collisions, for the first time"
        rows.append(Row.of(name, "s", wider).aiming("best", most=2.0))
    return rows


def memory(plan: Plan) -> list[Row]:
    """Measure the memory of processes: one run, the curves of 1,000 runs, and each robot of a large swarm."""
    peaks = partial(_peaks, plan.processes)
    one, many = peaks(playing(paper(), PAPER_STEPS)), peaks(playing(paper(), PAPER_STEPS, 1000, True))
    robots = plan.memory_robots
    large = peaks(playing(world(robots, robots), 5))
    each = [(peak - base) * 2**20 / robots for peak, base in zip(large, one, strict=True)]
    name = f"each of {robots:,} robots, with its task"
    return [
        Row.of("1 run", "MiB", one),
        Row.of("1,000 runs with curves", "MiB", many),
        Row.of(name, "bytes", each, robots).aiming("best", most=300.0),
    ]


def _peaks(processes: int, code: str) -> list[float]:
    """Measure the peak memory of a process that runs some code, several times."""
    return [peak_mebibytes(code) for _ in range(processes)]


def start(plan: Plan) -> list[Row]:
    """Measure how long a large swarm takes until its first step is done, in wall time on one thread."""
    rows = []
    for robots in {LARGE, plan.memory_robots}:
        play = partial(feasibee.simulate, scenario(world(robots, robots), 1), seed=1, threads=1)
        taken = [seconds(play, time.perf_counter) for _ in range(plan.large_repeats)]
        rows.append(Row.of(f"{robots:,} robots", "s", taken, robots))
    return sorted(rows, key=lambda row: row.robots or 0)


def answers(plan: Plan) -> list[Row]:
    """Count the robot-steps of answers, against those of a grid with equal whole runs of all they name."""
    rows = []
    for name, tables in {"the paper's swarm": {}, "a hall": HALL}.items():
        swarm, done = feasibee.Scenario.from_tables(tables), []
        found = assess(swarm, plan.answer_runs, execution=Execution(progress=done.append))
        row = Row.of(f"assess, {name}", "million robot-steps", [done[-1].work_new / 1e6])
        grid = _robots_in_grid(found) * plan.answer_runs * swarm.run.steps / 1e6
        rows.append(row.compared([row.best / grid], "a grid").aiming("ratio", most=0.5))
    swarm, done, near = feasibee.Scenario(robots={"know_count": True}), [], (19, 20, 21, 22)
    contenders = contenders_of(swarm, ["turns", "quiet-census", "map"])
    with Rounds(Execution(progress=done.append), most=None) as rounds:
        compare(contenders, near, LEAST_WORDS, 0, rounds, curves=False)
    row = Row.of("compare, three strategies that declare", "million robot-steps", [done[-1].work_new / 1e6])
    grid = len(contenders) * len(near) * LEAST_WORDS * swarm.robots.count * swarm.run.steps / 1e6
    rows.append(row.compared([row.best / grid], "a grid").aiming("ratio", most=0.5))
    return rows


def _robots_in_grid(found: Assessment) -> int:
    """Return the robots of one run of each variant, and of each number of robots and tasks in a search."""
    robots = found.scenario.robots.count
    trials = [found, *found.limits, *found.strategies, *found.faults]
    variants = sum(1 + (each.opposite is not None) for each in trials)
    bands = [each for each in (found.sizing and found.sizing.band, found.recommended_band) if each]
    tasks = sum(len(edge.values) for band in bands for edge in (band.below, band.above))
    return robots * (variants + tasks) + sum(found.sizing.edge.values if found.sizing else ())


CASES: dict[str, Callable[[Plan], list[Row]]] = {
    f"The paper's swarm: 20 robots, {PAPER_TASKS} tasks, {PAPER_STEPS} steps": paper_swarm,
    "Strategies: the paper's swarm; target speeds in millions of robot-steps/s": strategies,
    "Growth: equal density, as many tasks as robots, without the start": growth,
    "Other programs: the worlds of the table of growth": others,
    "Threads: one swarm of that kind, wall time": threads,
    "First step: such a swarm, wall time on one thread": start,
    f"Beyond the paper: 20 robots among {PAPER_TASKS} tasks, {LARGE:,} among as many": beyond,
    f"Knowledge: as many tasks as robots, {KNOWLEDGE_STEPS} steps": knowledge,
    "Start-up: CPU time of a command, interpreter and 100 runs included": start_up,
    "Memory: peak of a process": memory,
    "Answers: robot-steps, by equal runs of each variant and size in a grid": answers,
}
"""The cases by title, in the order of the table."""
