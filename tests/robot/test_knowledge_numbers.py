"""Functions of knowledge in C whose limits no run of a test reaches: large totals and counts."""

from __future__ import annotations

import ctypes
import random
from fractions import Fraction

import pytest

from feasibee.robot.firmware import header
from feasibee.robot.knowledge import Knowledge
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES, totals
from feasibee.strategies.contract import Me, Thing
from tests.robot.driving import built

SOURCE = """
#define FEASIBEE_WORDS 400
#include "feasibee.h"
uint32_t row_of(uint32_t robots, uint32_t tasks);
void write_counts(uint64_t robots_found, uint64_t tasks_found, uint32_t *counts);
uint32_t changed(int number, bool is_robot, int32_t id);
void seen(int number, uint32_t robots, uint32_t tasks, bool is_robot, uint32_t *counts);
double kept(uint32_t robots, uint32_t tasks);
uint32_t row_of(uint32_t robots, uint32_t tasks)
{
    return feasibee_totals_row_of(robots, tasks);
}
void write_counts(uint64_t robots_found, uint64_t tasks_found, uint32_t *counts)
{
    feasibee_write_counts(robots_found, tasks_found, &counts[0], &counts[1]);
}
static uint32_t draw_duration(void *context, const struct feasibee_mean *mean)
{
    (void)context, (void)mean;
    return 1;
}
static struct feasibee_choice draw_choice(void *context)
{
    struct feasibee_choice choice = {0, 0};
    (void)context;
    return choice;
}
void seen(int number, uint32_t robots, uint32_t tasks, bool is_robot, uint32_t *counts)
{
    static const struct feasibee_strategy *const strategies[] = {
        &feasibee_tally, &feasibee_estimate, &feasibee_totals};
    static struct feasibee_robot robot;
    struct feasibee_setting setting = {0};
    struct feasibee_settings settings = feasibee_defaults(strategies[number]);
    struct feasibee_me me = {NULL, 0, 0, 0};
    struct feasibee_thing thing = {0};
    setting.robots = setting.robot_ids = 20;
    settings.setting = &setting;
    settings.draw_duration = draw_duration;
    feasibee_begin(&robot, &settings, &me, 1);
    robot.known[0] = robots;
    robot.known[1] = tasks;
    thing.is_robot = is_robot;
    feasibee_recognise(&robot, &thing);
    counts[0] = robot.known[0];
    counts[1] = robot.known[1];
    settings.strategy->knowledge->count(&robot, &counts[2], &counts[3]);
}
double kept(uint32_t robots, uint32_t tasks) /* quality after one more exploration of a life */
{
    static struct feasibee_robot robot;
    struct feasibee_settings settings = feasibee_defaults(&feasibee_average);
    struct feasibee_me me = {NULL, 0, 0, 0};
    settings.draw_duration = draw_duration;
    settings.draw_choice = draw_choice;
    feasibee_begin(&robot, &settings, &me, 1);
    feasibee_end_step(&robot);
    robot.robots_seen = robots;
    robot.tasks_seen = tasks;
    feasibee_end_step(&robot);
    feasibee_observe(&robot, UINT16_MAX, UINT16_MAX);
    feasibee_end_step(&robot);
    return feasibee_double(robot.feasible_quality);
}
uint32_t changed(int number, bool is_robot, int32_t id) /* words that seeing a thing changes */
{
    static const struct feasibee_strategy *const strategies[] = {
        &feasibee_census, &feasibee_quiet_census, &feasibee_roster_turns, &feasibee_totals};
    static struct feasibee_robot robot, before;
    struct feasibee_setting setting = {0};
    struct feasibee_settings settings = feasibee_defaults(strategies[number]);
    struct feasibee_me me = {NULL, 3, 0, 0};
    struct feasibee_thing thing = {0};
    uint32_t found = 0;
    setting.robots = setting.robot_ids = 20;
    setting.tasks = setting.task_ids = 40;
    setting.id_bits = 5;
    setting.width = setting.height = setting.sight = setting.radio = 20.0;
    setting.speed = setting.exploration = 20.0;
    setting.parameters[0] = number == 3 ? 1.0 : 20.0;
    settings.setting = &setting;
    settings.draw_duration = draw_duration;
    feasibee_begin(&robot, &settings, &me, 1);
    before = robot;
    thing.is_robot = is_robot;
    thing.id = id;
    feasibee_recognise(&robot, &thing);
    for (uint32_t k = 0; k < FEASIBEE_WORDS; k++)
        found += robot.known[k] != before.known[k];
    return found;
}
"""
GENERATOR_SEED = 17


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """Return the functions of SOURCE."""
    folder = tmp_path_factory.mktemp("numbers")
    library = ctypes.CDLL(str(built(folder, SOURCE, header(), "-DFEASIBEE_DOUBLE", "-shared", "-fPIC")))
    library.kept.restype = ctypes.c_double
    return library


def number_of(draw, bits):
    """Return a random number of a random length, often just below a power of two."""
    length = draw.randrange(bits + 1)
    return max(0, draw.choice([draw.getrandbits(bits) >> (bits - length), 2**length - draw.randrange(4)]))


def test_large_totals_are_rounded_as_in_python(compiled):
    draw = random.Random(GENERATOR_SEED)
    for _ in range(20_000):
        robots, tasks = number_of(draw, 31), number_of(draw, 31)
        assert compiled.row_of(robots, tasks) == totals.row_of(robots, tasks)


@pytest.mark.parametrize(("number", "name"), [*enumerate(["tally", "estimate", "totals"])])
def test_totals_that_fill_their_word_are_kept_as_in_python(number, name, compiled):
    draw = random.Random(GENERATOR_SEED)
    setting = setting_from((20, 5), (0, 0), True, None, STRATEGIES[name].parameters.values())
    counts = (ctypes.c_uint32 * 4)()
    for _ in range(2_000):
        robot = Knowledge(STRATEGIES[name], Me(0, 0, 1, 0, [], setting))
        robot.words[:2] = [min(number_of(draw, 31), 2**31 - 1) for _ in range(2)]
        if name == "totals":  # it never holds a full word
            robot.words[:2] = [min(word, 2**31 - 2) for word in robot.words[:2]]
        is_robot = draw.random() < 0.5
        compiled.seen(number, *robot.words[:2], is_robot, counts)
        robot.observe([Thing(is_robot, 0, 0, 0)])
        assert counts[:2] == robot.words[:2]
        exact = [sum(each) for each in robot.counted()]
        assert counts[2] * sum(exact) == pytest.approx(exact[0] * sum(counts[2:]), rel=1e-8)


def test_counts_of_a_long_life_keep_their_ratio(compiled):
    for robots, tasks in ((2**31, 2**29), (2**29, 2**29), (2**30, 2**31), (2**29 - 1, 2**29 - 1)):
        assert compiled.kept(robots, tasks) == pytest.approx(robots / (robots + tasks), abs=1e-3)


def test_large_counts_keep_their_ratio(compiled):
    draw = random.Random(GENERATOR_SEED)
    counts = (ctypes.c_uint32 * 2)()
    for _ in range(20_000):
        robots, tasks = number_of(draw, 60), number_of(draw, 60)
        compiled.write_counts(ctypes.c_uint64(robots), ctypes.c_uint64(tasks), counts)
        assert sum(counts) < 2**32
        if robots + tasks < 2**32:
            assert [*counts] == [robots, tasks]
        else:
            exact = Fraction(robots, robots + tasks)
            assert abs(Fraction(counts[0], sum(counts)) - exact) < Fraction(1, 2**30)


@pytest.mark.parametrize(
    ("number", "name"), [*enumerate(["census", "quiet-census", "roster-turns", "totals"])]
)
@pytest.mark.parametrize("is_robot", [True, False])
def test_a_thing_whose_id_was_misread_is_not_kept(number, name, is_robot, compiled):
    """The total of `totals` counts it all the same; a task of `roster-turns` has a place instead of an id."""
    limit = 20 if is_robot else 40
    assert compiled.changed(number, is_robot, limit - 1) > 0
    kept = 1 if name == "totals" else 0
    if name != "roster-turns" or is_robot:
        for id_ in [*range(limit, limit + 100), -1, 2**31 - 1, -(2**31)]:
            assert compiled.changed(number, is_robot, id_) == kept
