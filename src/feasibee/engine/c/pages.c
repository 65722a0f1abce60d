/* What a page of a browser needs in addition: a swarm whose numbers it changes, and what it draws of it. Only
 * WebAssembly has it.
 *
 * feasibee.live.packet writes a scenario as packets. A packet has the number of its parts, their sizes in bytes, and
 * the parts, each padded to whole words. One is for all strategies that the page offers, and each has one of its own. */

#include "memory.h"

#ifdef __wasm__

#include <stdlib.h>

#include "dynamics.h"
#include "few.h"

#define MOST_BYTES (INT64_C(1) << 30) /* of a swarm */
#define FIRST_SLOTS 64
#define NO_TASK 65535
#define MOST_AT_ONCE (1 << 18) /* robots times steps of a run that is played by one call */

/* The parts, in the order of packet.py. */
enum common_part { CLASSES, ADDS, GIVEN_POINTS, RANKS, ABLE, PASSABLE, BOXES, TILES, STANDS, PIECES, FIRSTS, LATTICE };
enum own_part { PARAMS, SETTING, PARAMETERS, NAME, LIMITS, SHAPE };

/* The numbers of SHAPE. */
enum shape { MEMORY, SKILL_SETS, ALL_CLASSES, TASK_CLASSES, IS_FAST, MOST_ROBOTS, STREAMING, PIECE_COUNT };

/* Arrays and numbers of the present step, which the page reads: in the order of world.js. */
enum array { ROBOT_X, ROBOT_Y, FLAGS, AIMS, TASK_X, TASK_Y, TASK_NUMBERS, LOOKS, ALONG_X, ALONG_Y, KINDS, ARRAYS };
enum number { ROBOTS, THERE_NOW, TASKS, COUNTED_NOW, FEASIBLE_NOW, INFEASIBLE_NOW, NEEDED, HELD, MISSING, NUMBERS };

/* Numbers of a robot and of its world, likewise; what follows them says `feasibee_robot`. */
enum robot_number {
    FLAGS_NOW, LASTS, SAID, CLASS_NOW, QUALITY, VOTES_NOW, FEASIBLE_VOTES_NOW, HEARD_NOW, INBOX_SIZE, /* itself */
    AIM, AIM_IS_THERE, AIM_HOLDER, AIM_AWAY, MARKS, TASKS_KNOWN, TASKS_FREE,                        /* if robots act */
    ROBOT_COLUMNS, COLUMNS, MEMORY_KEPT, AT_START, KNOWS_COUNT, DECLARES_BY_VOTES, SEES_ONCE, RANDOM_IDS, ACTS_FROM,
    ACTS_BY_WORD, TASKS_STAY, ROBOT_NUMBERS
};

#pragma GCC visibility push(default)

/* Take the packets of a scenario and of a strategy, which stay in memory. */
void feasibee_open(const int64_t *all, const int64_t *one);

/* Return room for the events of the next run, which the page writes. */
int64_t *feasibee_events(int32_t count);

/* Let robots of the next runs see, hear and walk so far: as squared distances and a step of fixed point, and in units. */
void feasibee_patch(uint64_t sight_limit, uint64_t radio_limit, double reach, double sight, double radio, double speed);

/* Begin a run with so many robots and tasks at the start; return whether there is memory for it.
 *
 * One that stops at its decision, or keeps its curves, may be played by one call, and then nothing else of it can be
 * shown. */
bool feasibee_begin(int32_t robots, int32_t tasks, uint32_t seed_low, uint32_t seed_high, uint32_t run, bool stops,
                    bool curves);

/* Simulate up to a step; return it, or -1 without memory. */
int32_t feasibee_to(int32_t step);

/* Simulate so many steps of a run that stops, or more; return the step. */
int32_t feasibee_play_on(int32_t steps);

/* Write the arrays of the present step; return its numbers. */
const int32_t *feasibee_show(void);
void *feasibee_array(int32_t which);

/* Return the first decision, how many robots are missing, and the account of the run. */
int32_t feasibee_decision(void);
int32_t feasibee_missing(void);
const int64_t *feasibee_account(void);

/* Return how many robots were for feasible at each step of a run that keeps its curves. */
const int32_t *feasibee_course(void);

/* Return numbers of a robot at the present step: those of enum robot_number; what it has counted, by class of robots,
 * then of tasks; what its strategy keeps; id, opinion and number of each message in its inbox. They stay until the next
 * call. */
const double *feasibee_robot(int32_t i);

#pragma GCC visibility pop

#define ACCOUNT_COLUMNS (sizeof(struct account) / sizeof(int64_t))
#define TASKS_STAND 16 /* bit of a cell of the plan, as 1 for a wall: feasibee.strategies.sight */

static const int64_t *common, *own; /* packets */
static int64_t *events, event_count;
static struct params params;
static struct setting setting;
static struct tables tables;
static struct state state;
static struct room room;
static int8_t decision;
static int32_t decision_step, numbers[NUMBERS], *course; /* NULL without curves */
static int64_t account[ACCOUNT_COLUMNS], steps_done, run_number, missing_at_start;
static const bool cancelled = false;
static struct control control = {&steps_done, &cancelled, {0}};
static uintptr_t before, before_fit, before_block;
static bool is_fast;
static struct {
    bool is_set;
    uint64_t sight_limit, radio_limit;
    double reach, sight, radio, speed;
} patch;
static void *shown[ARRAYS];
static int32_t *stands, *boxes;
static uint64_t *walls;

/* --- Packets --- */

static const void *part_of(const int64_t *packet, int k)
{
    const int64_t *at = packet + 1 + packet[0];
    for (int part = 0; part < k; part++)
        at += (packet[1 + part] + 7) / 8;
    return at;
}

static int64_t *copy_of(const void *array, size_t size) { return memcpy(malloc(size), array, size); }

/* A user's strategy, if the module is compiled with one. */
__attribute__((weak)) const struct rules *feasibee_own_rules(const char *name)
{
    (void)name;
    return NULL;
}

__attribute__((weak)) void feasibee_bind(void (*fail)(int32_t what, int32_t line, double first, double second))
{
    (void)fail;
}

/* Return the numbers of a part, which has the difference of each from the one before. */
static int32_t *summed(int k)
{
    const size_t size = (size_t)common[1 + k];
    int32_t *sums = (int32_t *)copy_of(part_of(common, k), size);
    for (size_t at = 1; at < size / sizeof *sums; at++)
        sums[at] += sums[at - 1];
    return sums;
}

/* Store what of a place is the same in all runs. Its walls are the cells of the boxes. */
static void open_place(void)
{
    const struct place *place = &((const struct params *)part_of(own, PARAMS))->arena.place;
    stands = summed(STANDS);
    boxes = summed(BOXES);
    walls = calloc((size_t)(place->row_words * place->rows), sizeof *walls);
    for (const int32_t *box = boxes; box < boxes + place->boxes; box++)
        for (int32_t row = box[2 * place->boxes]; row <= box[3 * place->boxes]; row++)
            for (int32_t column = box[0]; column <= box[place->boxes]; column++)
                walls[row * place->row_words + column / 64] |= UINT64_C(1) << (column & 63);
    before = room_taken();
}

void feasibee_open(const int64_t *all, const int64_t *one)
{
    const bool is_first = common != all;
    feasibee_bind(feasibee_fail);
    common = all;
    own = one;
    if (is_first)
        open_place();
}

int64_t *feasibee_events(int32_t count)
{
    take_back(before);
    event_count = count;
    events = malloc((size_t)(count * EVENT_COLUMNS) * sizeof *events);
    before_fit = room_taken();
    return events;
}

/* --- Numbers that follow from how many robots and tasks there are: those of feasibee.simulation.lowering --- */

static int64_t root_of(uint64_t square)
{
    uint64_t root = (uint64_t)__builtin_sqrt((double)square);
    while (root * root > square)
        root--;
    while ((root + 1) * (root + 1) <= square)
        root++;
    return (int64_t)root;
}

/* Return cells per unit times 2**52, rounded down. */
static uint64_t scale_of(uint64_t cells, uint64_t side)
{
    const uint64_t half = cells << 26;
    return (half / side << 26) + (half % side << 26) / side;
}

static struct grid grid_for(int64_t points, int64_t reach)
{
    const struct arena *arena = &params.arena;
    const int64_t most = points > WORD ? root_of((uint64_t)points) : 1, cell = 2 * reach * 65537;
    const int64_t columns = kept_between(arena->width * 65536 / cell, 0, most);
    const int64_t rows = kept_between(arena->height * 65536 / cell, 0, most);
    struct grid grid = {columns > 0 ? columns : 1, rows > 0 ? rows : 1, arena->width, arena->height};
    grid.half_width = arena->width / (2 * grid.columns);
    grid.half_height = arena->height / (2 * grid.rows);
    grid.scale_x = scale_of((uint64_t)grid.columns, (uint64_t)(arena->width + arena->walls));
    grid.scale_y = scale_of((uint64_t)grid.rows, (uint64_t)(arena->height + arena->walls));
    return grid;
}

static struct band band_for(uint64_t limit, uint32_t shift)
{
    const double reach = __builtin_sqrt((double)limit) / (double)(UINT64_C(1) << shift), near = reach - 1.5;
    const double low = near > 0.0 ? __builtin_floor(near * near) : 0.0;
    const double high = __builtin_ceil((reach + 1.5) * (reach + 1.5)), widest = (double)UINT32_MAX;
    if (low == 0.0 || high > (double)(UINT32_C(1) << 31))
        return (struct band){0, UINT32_MAX};
    return (struct band){(uint32_t)low, (uint32_t)(high - low < widest ? high - low : widest)};
}

static struct list lists_for(int64_t tasks, uint64_t limit)
{
    int64_t bits = tasks >= 64 ? 4 : tasks >= 16 ? 3 : 2;
    const int64_t reach = root_of(limit) + 1, side = INT64_C(1) << (32 - bits);
    const int64_t length = 64 - __builtin_clzll((uint64_t)(2 * (reach + side) + 7));
    int64_t shift = length > 16 ? length - 16 : 0;
    if (tasks == 0 || reach >= ((INT64_C(1) << (bits - 1)) - 1) * side || shift > 16) {
        bits = 0;
        shift = 16;
    }
    return (struct list){bits, (uint32_t)shift, band_for(limit, (uint32_t)shift)};
}

static bool may_change(void)
{
    const struct robot *robots = &params.robots;
    return event_count > 0 || robots->arrival_rate > 0.0 || robots->failure_time > 0.0 || params.tasks.arrival_rate > 0.0 ||
           params.tasks.lifetime > 0.0 || (robots->work > 0 && !robots->away_counts);
}

/* Store how many robots and tasks have numbers. */
static void count_numbers(int64_t robots, int64_t tasks)
{
    const int64_t *shape = part_of(own, SHAPE);
    int64_t most = robots, appearing = shape[STREAMING];
    for (const int64_t *event = events; event < events + event_count * EVENT_COLUMNS; event += EVENT_COLUMNS) {
        most += event[EVENT_ROBOTS] > 0 ? event[EVENT_ROBOTS] : 0;
        appearing += event[EVENT_TASKS] > 0 ? event[EVENT_TASKS] : 0;
    }
    if (params.robots.arrival_rate > 0.0 && most < 2 * robots)
        most = 2 * robots;
    if (may_change() && shape[MOST_ROBOTS] > 0)
        most = shape[MOST_ROBOTS] > robots ? shape[MOST_ROBOTS] : robots;
    params.robots.at_start = robots;
    params.robots.count = most;
    params.tasks.at_start = tasks;
    params.tasks.count = tasks + appearing;
}

/* Store what knowledge may depend on. */
static void fit_setting(const struct rules *rules)
{
    const int64_t robots = params.robots.count, tasks = params.tasks.count, old_bits = setting.id_bits;
    struct knowledge *knowledge = &params.strategy.knowledge;
    const bool liars = params.faults.byzantine > 0, told = knowledge->enabled && !params.decision.declare.enabled;
    setting.robots = robots;
    setting.count = params.robots.at_start;
    setting.tasks = tasks;
    setting.robot_ids = robots + (liars ? tasks : 0);
    setting.task_ids = tasks + (liars ? robots + 1 : 0) + (params.sensing.misname > 0 ? tasks : 0);
    if (!params.radio.random_ids)
        setting.id_bits = robots > 2 ? 64 - __builtin_clzll((uint64_t)robots - 1) : 1;
    params.radio.id_bits = setting.id_bits;
    params.radio.message_bits += told ? 0 : setting.id_bits - old_bits;
    knowledge->robot_ids = setting.robot_ids;
    knowledge->task_ids = setting.task_ids;
    if (!rules->words)
        return;
    knowledge->words = rules->words(&setting);
    knowledge->message_words = rules->message_words ? rules->message_words(&setting) : knowledge->words;
}

void feasibee_patch(uint64_t sight_limit, uint64_t radio_limit, double reach, double sight, double radio, double speed)
{
    patch.is_set = true;
    patch.sight_limit = sight_limit;
    patch.radio_limit = radio_limit;
    patch.reach = reach;
    patch.sight = sight;
    patch.radio = radio;
    patch.speed = speed;
}

/* Store what follows from how far robots see, hear and walk, in an open arena. */
static void fit_ranges(void)
{
    if (!patch.is_set)
        return;
    params.sensing.limit = patch.sight_limit;
    params.sensing.band = band_for(patch.sight_limit, 16);
    params.radio.limit = patch.radio_limit;
    params.radio.band = band_for(patch.radio_limit, 16);
    params.radio.as_sight = patch.sight == patch.radio && !params.sensing.ahead;
    params.robots.reach = patch.reach;
    setting.sight = patch.sight;
    setting.radio = patch.radio;
    setting.speed = patch.speed;
}

static void fit_params(bool fast)
{
    const uint64_t sight = params.sensing.limit, radio = params.radio.limit;
    const int64_t robots = params.robots.count, tasks = params.tasks.count;
    const bool together = robots <= FEW, numbered = params.arena.wraps && tasks <= 128 && !params.sensing.misname;
    const int64_t heard = root_of((sight > radio ? sight : radio) - 1), met = root_of(params.robots.meet_limit);
    params.together = together;
    params.decision.inbox_is_set = together && params.decision.inbox_size == 0 && !params.radio.random_ids;
    params.robots.grid = grid_for(robots, (params.robots.avoid_collisions && met > heard ? met : heard) + 1);
    params.tasks.grid = grid_for(tasks, root_of(sight - 1) + 1);
    params.tasks.lists = lists_for(fast && together ? params.tasks.at_start : 0, sight);
    params.tasks.numbered = together && !fast && numbered && !params.sensing.merges;
}

static void fit_changes(void)
{
    const bool changes = may_change();
    params.changes = changes || params.robots.work > 0;
    params.truth_stays = !changes;
    if (changes && params.acting.acts && !params.acting.come_free) {
        params.acting.come_free = true;
        params.acting.task_bits += 8;
    }
}

/* --- Places --- */

/* Give robots or tasks their pieces: each goes to the one farthest behind its share of the cells (model.md 6.20.7). */
static void share(int64_t *piece_of, int64_t count, const int64_t *first, const int64_t *held, int64_t pieces)
{
    int64_t *area = calloc(2 * (size_t)pieces, sizeof *area), *given = area + pieces, total = 0;
    for (int64_t piece = 0; piece < pieces; piece++)
        total += area[piece] = held[piece] > 0 ? first[piece + 1] - first[piece] : 0;
    for (int64_t k = 0; k < count; k++) {
        int64_t best = 0;
        for (int64_t piece = 1; piece < pieces; piece++)
            if (area[piece] * (k + 1) - given[piece] * total > area[best] * (k + 1) - given[best] * total)
                best = piece;
        given[best]++;
        piece_of[k] = best;
    }
}

static int64_t *count_pieces(const int64_t *piece_of, int64_t count, int64_t pieces)
{
    int64_t *counts = calloc((size_t)pieces, sizeof *counts);
    for (int64_t k = 0; k < count; k++)
        counts[piece_of[k]]++;
    return counts;
}

/* Store where robots and tasks are placed, in which pieces robots are missing, and what robots know of the plan. */
static void fit_place(bool is_given)
{
    const int64_t pieces = ((const int64_t *)part_of(own, SHAPE))[PIECE_COUNT], robots = params.robots.at_start;
    const int64_t tasks = params.tasks.at_start, things = params.robots.count + params.tasks.count;
    const int64_t *first = part_of(common, FIRSTS), *of_tasks = first + pieces + 1;
    int64_t *piece_of = copy_of(part_of(common, PIECES), (size_t)(robots + tasks) * sizeof *piece_of);
    int32_t *stand_of = malloc(2 * (size_t)things * sizeof *stand_of);
    if (!is_given)
        share(piece_of, robots, first, first + 1, pieces); /* any piece with cells */
    const int64_t *held = count_pieces(piece_of, robots, pieces);
    if (!is_given)
        share(piece_of + robots, tasks, of_tasks, held, pieces);
    const int64_t *wanted = count_pieces(piece_of + robots, tasks, pieces);
    missing_at_start = 0;
    for (int64_t piece = 0; piece < pieces; piece++)
        missing_at_start += wanted[piece] > held[piece] ? wanted[piece] - held[piece] : 0;
    for (int64_t k = 0; k < things; k++) { /* who comes later is where the first robot is */
        const bool is_task = k >= params.robots.count;
        const int64_t place = is_task ? k - params.robots.count : k;
        const int64_t piece = place < (is_task ? tasks : robots) ? piece_of[is_task ? robots + place : place] : piece_of[0];
        const int64_t *from = is_task ? of_tasks : first;
        stand_of[2 * k] = (int32_t)from[piece];
        stand_of[2 * k + 1] = (int32_t)(from[piece + 1] - from[piece]);
    }
    tables.ground.stand_of = stand_of;
    if (setting.plan_length == 0)
        return;
    const struct place *place = &params.arena.place;
    uint8_t *plan = malloc((size_t)setting.plan_length);
    for (int64_t k = 0; k < setting.plan_length; k++)
        plan[k] = has_cell(place, walls, (uint32_t)(k % place->columns), (uint32_t)(k / place->columns));
    for (int64_t piece = 0; piece < pieces; piece++)
        for (int64_t k = of_tasks[piece]; held[piece] > 0 && k < of_tasks[piece + 1]; k++)
            plan[stands[k]] |= TASKS_STAND;
    const int32_t *points = tables.points + 2 * robots;
    for (int64_t task = 0; params.tasks.placement.how == AT_POINTS && task < tasks; task++)
        plan[(points[2 * task + 1] >> place->bits) * place->columns + (points[2 * task] >> place->bits)] |= TASKS_STAND;
    setting.plan = plan;
}

static void fit_tables(bool is_given)
{
    const int64_t *shape = part_of(own, SHAPE);
    const struct params *given = part_of(own, PARAMS);
    const int32_t *class_of = part_of(common, CLASSES);
    const size_t one = sizeof *class_of, robots = (size_t)given->robots.at_start, tasks = (size_t)given->tasks.at_start;
    int32_t *classes = calloc((size_t)(params.robots.count + params.tasks.count), one);
    if (is_given) {
        memcpy(classes, class_of, robots * one);
        memcpy(classes + params.robots.count, class_of + given->robots.count, tasks * one);
    }
    tables = (struct tables){
        .class_of = classes,
        .adds = part_of(common, ADDS),
        .skill_sets = shape[SKILL_SETS],
        .classes = shape[ALL_CLASSES],
        .task_classes = shape[TASK_CLASSES],
        .points = part_of(common, GIVEN_POINTS),
        .ranks = part_of(common, RANKS),
        .able = part_of(common, ABLE),
        .events = events,
        .event_count = event_count,
        .ground = {walls, part_of(common, PASSABLE), boxes, part_of(common, TILES), part_of(own, LIMITS), stands, NULL,
                   part_of(common, LATTICE)},
    };
}

/* Put points of events into the arena, off the walls by a margin, as given points are. */
static void hold_events_inside(void)
{
    for (int64_t *row = events; row < events + event_count * EVENT_COLUMNS; row += EVENT_COLUMNS) {
        const bool of_tasks = row[EVENT_TASKS] > 0 || row[EVENT_TASK] >= 0, place = params.arena.place.exists;
        const int64_t margin = of_tasks ? 0 : params.robots.placement.margin, edge = margin > place ? margin : place;
        if (row[EVENT_X] < 0)
            continue;
        row[EVENT_X] = kept_between(row[EVENT_X], margin, params.arena.width - edge);
        row[EVENT_Y] = kept_between(row[EVENT_Y], margin, params.arena.height - edge);
    }
}

/* Store all numbers of the scenario with so many robots and tasks at the start, and the events. */
static void fit(int32_t robots, int32_t tasks, bool fast)
{
    const struct params *given = part_of(own, PARAMS);
    const bool is_given = robots == given->robots.at_start && tasks == given->tasks.at_start;
    const char *name = part_of(own, NAME);
    const struct rules *rules = *name ? feasibee_rules(name) : feasibee_own_rules(name);
    take_back(before_fit);
    params = *given;
    setting = *(const struct setting *)part_of(own, SETTING);
    setting.parameters = part_of(own, PARAMETERS);
    params.strategy.gives_probability = params.run.stop_at_declarations = params.run.stop_when_taken = false;
    count_numbers(robots, tasks);
    fit_ranges();
    fit_setting(rules);
    fit_params(fast);
    fit_changes();
    hold_events_inside();
    fit_tables(is_given);
    missing_at_start = tasks > robots ? tasks - robots : 0;
    if (params.arena.place.exists)
        fit_place(is_given);
    if (!is_given)
        params.truth = missing_at_start == 0;
    state = (struct state){&params, rules, &setting, tables};
    state.memory_length = ((const int64_t *)part_of(own, SHAPE))[MEMORY];
    state.threads = 1;
    const int64_t most = 1024 + params.robots.count / 16;
    room.slots = FIRST_SLOTS;
    room.tables = params.decision.inbox_is_set ? 0 : params.robots.count < most ? params.robots.count : most;
}

/* --- Runs --- */

/* Put the swarm at step 0, in new memory. */
static bool start(void)
{
    take_back(before_block);
    const int64_t size = feasibee_lay_out(&state, room, NULL);
    char *block = size <= MOST_BYTES ? calloc(1, (size_t)size) : NULL;
    if (!block)
        return false;
    feasibee_lay_out(&state, room, block);
    const size_t robots = (size_t)params.robots.count, tasks = (size_t)params.tasks.count;
    const size_t counts[ARRAYS] = {[ROBOT_X] = robots, [ROBOT_Y] = robots, [FLAGS] = robots, [AIMS] = robots,
                                   [TASK_X] = tasks, [TASK_Y] = tasks, [TASK_NUMBERS] = tasks, [LOOKS] = tasks};
    for (int k = 0; k < ARRAYS; k++)
        shown[k] = malloc(counts[k] * sizeof(uint16_t) + 1);
    shown[ALONG_X] = state.robots[STEP_X];
    shown[ALONG_Y] = state.robots[STEP_Y];
    shown[KINDS] = state.class_of;
    decision = UNDECIDED;
    decision_step = -1;
    feasibee_start(&state, run_number);
    return true;
}

static const struct outcome *outcome(void)
{
    static struct outcome one = {.decision = &decision, .decision_step = &decision_step, .account = account, .runs = 1,
                                 .columns = ACCOUNT_COLUMNS};
    one.curve_length = course ? params.run.steps + 1 : 0;
    one.feasible_count = course;
    one.infeasible_count = course + one.curve_length;
    return &one;
}

bool feasibee_begin(int32_t robots, int32_t tasks, uint32_t seed_low, uint32_t seed_high, uint32_t run, bool stops,
                    bool curves)
{
    const bool may_be_fast = ((const int64_t *)part_of(own, SHAPE))[IS_FAST];
    const bool fast = (stops || curves) && event_count == 0 && robots <= FEW && may_be_fast;
    fit(robots, tasks, fast);
    course = curves ? malloc(2 * (size_t)(params.run.steps + 1) * sizeof *course) : NULL;
    before_block = room_taken();
    params.seed = (struct seed){seed_low, seed_high};
    params.run.stop_at_decision = stops;
    run_number = run;
    is_fast = fast && robots * params.run.steps <= MOST_AT_ONCE && feasibee_has(&params);
    if (is_fast) {
        decision = UNDECIDED;
        return true;
    }
    fit_params(false);
    return start() && feasibee_to(0) == 0;
}

int32_t feasibee_to(int32_t step)
{
    for (;;) {
        feasibee_advance(&state, 0, step, outcome(), &control, 0);
        if (!state.clock->full)
            return (int32_t)state.clock->step;
        *(state.clock->full == SLOTS_LACK ? &room.slots : &room.tables) *= 2; /* and play it again */
        if (!start())
            return -1;
    }
}

int32_t feasibee_play_on(int32_t steps)
{
    if (!is_fast)
        return feasibee_to((int32_t)kept_between(state.clock->step + steps, 0, params.run.steps));
    const uintptr_t taken = room_taken();
    feasibee_play(&params, state.rules, &setting, state.memory_length, run_number, outcome(), &control);
    take_back(taken);
    return (int32_t)account[LAST_STEP];
}

/* --- What is shown --- */

/* Return how many robots are missing, by what skills they lack. */
static int64_t missing_skills(void)
{
    int64_t most = 0;
    for (int64_t k = 0; k < tables.skill_sets; k++) {
        const int64_t *adds = tables.adds + k * tables.classes, *of_tasks = adds + params.robots.classes;
        const int64_t lack = sum_of(state.tasks_there, params.tasks.count, state.class_of + params.robots.count, of_tasks) -
                             sum_of(state.sets[PRESENT], params.robots.count, state.class_of, adds);
        most = lack > most ? lack : most;
    }
    return most;
}

static int64_t missing(void)
{
    if (params.sensing.by_class)
        return missing_skills();
    const int64_t lack = state.clock->tasks - state.clock->robots;
    return params.truth_stays ? missing_at_start : lack > 0 ? lack : 0;
}

/* Return a coordinate in 65,536ths of the longer side. */
static uint16_t coarse(int32_t coordinate)
{
    const int64_t side = params.arena.width > params.arena.height ? params.arena.width : params.arena.height;
    return (uint16_t)kept_between((int64_t)((uint64_t)(uint32_t)coordinate << 16) / side, 0, UINT16_MAX);
}

static uint16_t flags_of(int64_t i)
{
    static const enum set kinds[] = {FOR_FEASIBLE, NEUTRAL, DISSEMINATING, DECLARED, WORKING, BYZANTINE, STUBBORN, THERE, STANDING};
    uint16_t flags = 0;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        flags |= (uint16_t)(has(state.sets[kinds[k]], i) << k);
    return flags;
}

static void show_robots(void)
{
    uint16_t *flags = shown[FLAGS], *x = shown[ROBOT_X], *y = shown[ROBOT_Y];
    for (int64_t i = 0; i < params.robots.count; i++) {
        flags[i] = flags_of(i);
        x[i] = coarse(state.robots[X][i]);
        y[i] = coarse(state.robots[Y][i]);
    }
}

static int32_t show_tasks(void)
{
    uint16_t *x = shown[TASK_X], *y = shown[TASK_Y], *numbers_of = shown[TASK_NUMBERS];
    int32_t there = 0;
    for (int64_t task = 0; task < params.tasks.count; task++) {
        if (!has(state.tasks_there, task))
            continue;
        x[there] = coarse(state.tasks[POINT_X][task]);
        y[there] = coarse(state.tasks[POINT_Y][task]);
        numbers_of[there++] = (uint16_t)task;
    }
    return there;
}

/* Show to which task each robot goes, and which tasks are taken (1) or done (2). */
static void show_acting(int32_t tasks)
{
    uint16_t *aims = shown[AIMS], *looks = shown[LOOKS], *numbers_of = shown[TASK_NUMBERS];
    for (int64_t i = 0; i < params.robots.count; i++) {
        aims[i] = NO_TASK;
        for (int32_t k = 0; has(state.sets[BOUND], i) && k < tasks; k++)
            if (numbers_of[k] == state.robots[TARGET][i])
                aims[i] = (uint16_t)k;
    }
    for (int32_t k = 0; k < tasks; k++) {
        const int32_t holder = state.holders[numbers_of[k]];
        looks[k] = holder >= 0 ? 1 : holder == -2 ? 2 : 0;
        if (holder >= 0 && has(state.sets[STANDING], holder))
            aims[holder] = (uint16_t)k;
    }
}

const int32_t *feasibee_show(void)
{
    const int32_t quorum = (int32_t)state.clock->quorum;
    const int32_t feasible = (int32_t)state.account->feasible_at_end, infeasible = (int32_t)state.account->infeasible_at_end;
    const int32_t held = feasible >= quorum ? FEASIBLE : infeasible >= quorum ? INFEASIBLE : UNDECIDED;
    const int32_t tasks = show_tasks();
    show_robots();
    if (params.acting.acts)
        show_acting(tasks);
    const int32_t found[NUMBERS] = {(int32_t)params.robots.count, (int32_t)state.clock->robots, tasks,
        (int32_t)state.clock->counted, feasible, infeasible, quorum, held, (int32_t)missing()};
    memcpy(numbers, found, sizeof numbers);
    return numbers;
}

void *feasibee_array(int32_t which) { return shown[which]; }
int32_t feasibee_decision(void) { return decision; }
int32_t feasibee_missing(void) { return (int32_t)(is_fast ? missing_at_start : missing()); }
const int64_t *feasibee_account(void) { return account; }
const int32_t *feasibee_course(void) { return course; }

/* --- A robot --- */

/* Write what a robot knows of tasks, and to which one it goes. */
static void tell_acting(double *found, int64_t i)
{
    const int64_t tasks = params.tasks.count, task = state.robots[TARGET][i];
    for (int64_t k = 0; k < tasks; k++) {
        const int32_t version = news_of(&state, i)[k];
        found[TASKS_KNOWN] += is_known(version);
        found[TASKS_FREE] += is_known(version) && (version - 1) % (params.acting.ranks + 1) == 0;
        if (state.holders[k] == i)
            found[has(state.sets[STANDING], i) ? AIM : MARKS] = (double)k;
    }
    if (!has(state.sets[BOUND], i))
        return;
    const struct course way = way_to(&state, i, task);
    found[AIM] = (double)task;
    found[AIM_IS_THERE] = has(state.tasks_there, task);
    found[AIM_HOLDER] = state.holders[task];
    found[AIM_AWAY] = __builtin_sqrt((double)square_of(way.x, way.y)) * params.arena.unit;
}

static double *write_message(double *at, int32_t sender, int64_t opinion, int32_t when)
{
    at[0] = sender;
    at[1] = (double)opinion;
    at[2] = when;
    return at + 3;
}

/* Write the messages that a robot keeps one by one; return their end. */
static double *write_inbox(double *at, int64_t i)
{
    if (params.decision.every_message)
        return at;
    for (int64_t j = 0; params.decision.inbox_is_set && j < params.robots.count; j++)
        if (has_bit(state.links[HEARD][j / WORD * state.padded + i], j))
            at = write_message(at, (int32_t)j, has_bit(state.links[HEARD_FEASIBLE][j / WORD * state.padded + i], j), 0);
    if (params.decision.inbox_is_set)
        return at;
    const struct slots slots = slots_of(&state, i);
    for (int64_t k = slots.first; k < slots.first + slots.count; k++) {
        const int32_t label = state.inbox[SENDER][k];
        if (label >= 0)
            at = write_message(at, sender_in(label), feasible_in(label), state.inbox[WHEN] ? state.inbox[WHEN][k] : 0);
    }
    return at;
}

/* Let the strategy count what a robot knows, which no run reads before it is counted again. */
static void count_known(int64_t i)
{
    if (!params.strategy.knowledge.enabled)
        return;
    state.pending_who[0] = (int32_t)i;
    if (has(state.sets[JOINING], i)) /* at step 0 it knows nothing yet */
        state.rules->update(&state, START, 1);
    state.rules->update(&state, COUNT, 1);
}

const double *feasibee_robot(int32_t i)
{
    const int64_t classes = tables.classes, kept = state.memory_length;
    const uintptr_t taken = room_taken();
    const int64_t messages = params.robots.count + state.clock->table_slots; /* at most */
    double *found = malloc((size_t)(ROBOT_NUMBERS + classes + kept + 3 * messages) * sizeof *found);
    take_back(taken);
    count_known(i);
    const double head[ROBOT_NUMBERS] = {
        [FLAGS_NOW] = flags_of(i), [LASTS] = state.robots[PHASE_LEFT][i], [CLASS_NOW] = state.class_of[i],
        [QUALITY] = state.quality[i],
        [SAID] = has(state.sets[SPEAKING], i) ? has(state.sets[SAYS_FEASIBLE], i) : NO_OPINION,
        [VOTES_NOW] = (double)state.counts[VOTES][i], [FEASIBLE_VOTES_NOW] = (double)state.counts[FEASIBLE_VOTES][i],
        [INBOX_SIZE] = (double)params.decision.inbox_size, [AIM] = -1, [MARKS] = -1,
        [ROBOT_COLUMNS] = (double)params.robots.classes, [COLUMNS] = (double)classes, [MEMORY_KEPT] = (double)kept,
        [AT_START] = (double)params.robots.at_start, [KNOWS_COUNT] = params.robots.knows_count,
        [DECLARES_BY_VOTES] = params.decision.declare.enabled, [SEES_ONCE] = params.sensing.unique,
        [RANDOM_IDS] = params.radio.random_ids, [ACTS_FROM] = (double)params.acting.start,
        [ACTS_BY_WORD] = params.acting.by_word, [TASKS_STAY] = params.tasks.work == 0};
    memcpy(found, head, sizeof head);
    if (params.acting.acts)
        tell_acting(found, i);
    double *at = found + ROBOT_NUMBERS;
    for (int64_t k = 0; k < classes; k++) {
        const int64_t *counted = state.counts[k < params.robots.classes ? ROBOTS_SEEN : TASKS_SEEN];
        *at++ = (double)(state.seen ? state.seen[i * classes + k] : counted[i]);
    }
    for (int64_t k = 0; k < kept; k++)
        *at++ = state.memory[i * kept + k];
    found[HEARD_NOW] = (double)(write_inbox(at, i) - at) / 3;
    return found;
}

#endif
