"""The cases of the benchmark: short functions that return rows of the table."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec

import brute_force
from measure import Row, command_cpu_seconds, peak_mebibytes, speed

import feasibee
from feasibee.strategies import STRATEGIES

SPACE_PER_ROBOT = 20.0  # square units: the paper's 20 robots on 20 x 20
PAPER_TASKS = 100
PAPER_STEPS = 1000
SHORT_STEPS = 100
LARGE = 10_000

RUN = ["-m", "feasibee", "run", "--set", f"tasks.count={PAPER_TASKS}", "--runs", "100", "--seed", "1"]

OPINIONS_TARGET = 20.0  # million robot-steps per second and core
KNOWLEDGE_TARGETS = {"tally": 3.0, "census": 3.0}

BEYOND: dict[str, dict] = {
    "walls and collisions": {"arena": {"boundary": "walls"}, "robots": {"avoid_collisions": True}},
    "unique observation": {"sensing": {"observation": "unique"}},
    "three classes": {
        "robots": {
            "classes": [
                {"name": "porters", "count": 10, "skills": ["lift"]},
                {"name": "all-rounders", "count": 6, "skills": ["lift", "scan"]},
                {"name": "spares", "count": 4},
            ]
        },
        "tasks": {
            "classes": [
                {"name": "carry", "count": 10, "needs": {"lift": 2, "scan": 1}},
                {"name": "push", "count": 10, "needs": {"lift": 1}},
            ]
        },
    },
}

KEEP_CURVES = f"""
import feasibee
scenario = feasibee.Scenario(tasks={{"count": {PAPER_TASKS}}})
swarms = feasibee.simulate(scenario, runs=RUNS, seed=1, threads=1, curves=True)
"""


@dataclass(frozen=True)
class Plan:
    """The sizes and numbers of measurements."""

    repeats: int = 7
    runs: int = 400
    robot_steps: int = 4_000_000
    sizes: tuple[int, ...] = (20, 32, 33, 64, 100, 316, 1000, 3162, LARGE)
    processes: int = 3


QUICK = Plan(repeats=3, runs=200, robot_steps=1_000_000, sizes=(20, 32, 33, 100, 1000, LARGE), processes=1)


def paper_swarm(plan: Plan) -> list[Row]:
    """Measure the paper's swarm of 20 robots in feasibee, in the brute-force loop and in Mesa."""
    ours = replace(swarm_speed(plan, 20, PAPER_TASKS, PAPER_STEPS, plan.runs), name="feasibee")
    rows = [ours, brute_force_speed(plan).against(ours, "feasibee")]
    if find_spec("mesa"):
        rows.append(mesa_speed(plan).against(ours, "feasibee"))
    return rows


def strategies(plan: Plan) -> list[Row]:
    """Measure every strategy on the paper's swarm, against the paper's strategy and the target speeds."""
    rows: list[Row] = []
    for name, strategy in STRATEGIES.items():
        scenario = feasibee.Scenario(
            tasks={"count": PAPER_TASKS}, decision={"strategy": name}, run={"steps": PAPER_STEPS}
        )
        runs = max(1, plan.runs // 8) if strategy.knowledge else plan.runs
        work = partial(feasibee.simulate, scenario, runs=runs, seed=1, threads=1)
        target = KNOWLEDGE_TARGETS.get(name) if strategy.knowledge else OPINIONS_TARGET
        row = speed(name, work, 20 * PAPER_STEPS * runs, plan.repeats)
        rows.append(row.against(rows[0] if rows else row, "dmmd").aiming(target))
    return rows


def brute_force_speed(plan: Plan) -> Row:
    """Measure the brute-force loop over all pairs."""
    runs = plan.runs // 4
    work = partial(brute_force.simulate, runs, 1, tasks=PAPER_TASKS, steps=PAPER_STEPS)
    return speed("brute-force loop in numba", work, 20 * PAPER_STEPS * runs, plan.repeats)


def mesa_speed(plan: Plan) -> Row:
    """Measure the Mesa model with one run, which takes seconds."""
    import mesa_model

    work = partial(mesa_model.play, tasks=PAPER_TASKS, steps=PAPER_STEPS)
    return speed("Mesa", work, 20 * PAPER_STEPS, plan.repeats)


def growth(plan: Plan) -> list[Row]:
    """Measure swarms of all sizes, at the paper's density and with as many tasks as robots."""
    rows: list[Row] = []
    for robots in plan.sizes:
        row = swarm_speed(plan, robots, robots, SHORT_STEPS, enough_runs(plan, robots))
        rows.append(row.against(rows[0], "20 robots") if rows else row)
    return rows


def large_swarm(plan: Plan) -> list[Row]:
    """Measure one run of 10,000 robots, start included, against many runs of 20 at equal density."""
    rows = []
    for tasks_per_robot in (1, PAPER_TASKS // 20):
        few = swarm_speed(plan, 20, 20 * tasks_per_robot, SHORT_STEPS, enough_runs(plan, 20))
        many = swarm_speed(plan, LARGE, LARGE * tasks_per_robot, SHORT_STEPS, 1)
        rows += [few, many.against(few, "20 robots")]
    return rows


def enough_runs(plan: Plan, robots: int) -> int:
    """Return the number of short runs that take long enough to be timed."""
    return max(1, plan.robot_steps // (robots * SHORT_STEPS))


def swarm_speed(plan: Plan, robots: int, tasks: int, steps: int, runs: int) -> Row:
    """Measure feasibee on one thread, at the density of the paper's swarm."""
    scenario = feasibee.Scenario(
        arena={"side": math.sqrt(SPACE_PER_ROBOT * robots)},
        robots={"count": robots},
        tasks={"count": tasks},
        run={"steps": steps},
    )
    work = partial(feasibee.simulate, scenario, runs=runs, seed=1, threads=1)
    return speed(f"{robots:,} robots, {tasks:,} tasks", work, robots * steps * runs, plan.repeats)


def beyond(plan: Plan) -> list[Row]:
    """Measure the worlds beyond the paper at 20 and 10,000 robots, with five tasks per robot and with one."""
    rows = []
    for name, changes in BEYOND.items():
        for tasks_per_robot in (PAPER_TASKS // 20, 1):
            few = beyond_speed(f"{name}, 20 robots", plan, changes, 20, tasks_per_robot)
            many = beyond_speed(f"{name}, {LARGE:,} robots", plan, changes, LARGE, tasks_per_robot)
            rows += [few, many.against(few, "20 robots")]
    return rows


def beyond_speed(name: str, plan: Plan, changes: dict, robots: int, tasks_per_robot: int) -> Row:
    """Measure one world beyond the paper on one thread, at the paper's density."""
    tables = {section: dict(fields) for section, fields in changes.items()}
    tables.setdefault("arena", {})["side"] = math.sqrt(SPACE_PER_ROBOT * robots)
    share = robots // 20
    for section, count in (("robots", robots), ("tasks", robots * tasks_per_robot)):
        table = tables.setdefault(section, {})
        if "classes" in table:
            scale = share if section == "robots" else count // 20
            table["classes"] = [{**each, "count": each["count"] * scale} for each in table["classes"]]
        else:
            table["count"] = count
    scenario = feasibee.Scenario(**tables, run={"steps": SHORT_STEPS})
    runs = enough_runs(plan, robots)
    work = partial(feasibee.simulate, scenario, runs=runs, seed=1, threads=1)
    title = f"{name}, {tasks_per_robot} tasks per robot"
    return speed(title, work, robots * SHORT_STEPS * runs, plan.repeats)


def start_up(plan: Plan) -> list[Row]:
    """Measure three commands: the help, the first simulation, which compiles the engine, and the next one."""
    asked, first, second = [], [], []
    for _ in range(plan.repeats):
        asked.append(command_cpu_seconds(["-m", "feasibee", "--help"]))
    for _ in range(plan.processes):
        with tempfile.TemporaryDirectory() as folder:
            first.append(command_cpu_seconds(RUN, {"FEASIBEE_CACHE": folder}))
            second.append(command_cpu_seconds(RUN, {"FEASIBEE_CACHE": folder}))
    return [
        Row.of("feasibee --help", "s", asked),
        Row.of("feasibee run, for the first time", "s", first),
        Row.of("feasibee run, again", "s", second),
    ]


def memory(plan: Plan) -> list[Row]:
    """Measure the memory of a process with one run, and of one with the curves of 1,000 runs."""
    return [memory_of("1 run", 1, plan), memory_of("1,000 runs with curves", 1000, plan)]


def memory_of(name: str, runs: int, plan: Plan) -> Row:
    """Measure the peak memory of a process that simulates the paper's swarm."""
    code = KEEP_CURVES.replace("RUNS", str(runs))
    return Row.of(name, "MiB", [peak_mebibytes(code) for _ in range(plan.processes)])


CASES: dict[str, Callable[[Plan], list[Row]]] = {
    f"The paper's swarm: 20 robots, {PAPER_TASKS} tasks, {PAPER_STEPS} steps": paper_swarm,
    "Strategies: the paper's swarm; target speeds in millions of robot-steps/s": strategies,
    f"Growth: equal density, as many tasks as robots, {SHORT_STEPS} steps": growth,
    f"A large swarm: equal densities, {SHORT_STEPS} steps": large_swarm,
    f"Beyond the paper: equal densities, {SHORT_STEPS} steps": beyond,
    "Start-up: CPU time of a command, interpreter and 100 runs included": start_up,
    f"Memory: peak of a process, 20 robots, {PAPER_TASKS} tasks, {PAPER_STEPS} steps": memory,
}
"""The cases by title, in the order of the table."""
