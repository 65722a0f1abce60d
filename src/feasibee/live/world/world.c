/* The world in a page: arena, walk, sight and radio (docs/model.md 1 to 4, 6.1, 6.17, 6.20) around the controller of robots in C.
 *
 * The page writes the numbers of a scenario to world_numbers(), calls world_begin() and then world_step(), and
 * reads the arrays. Each run equals that of the engine to the last bit.
 */
#include "draws.h"
#include "limits.h" /* made by build.py: WORLD_ROBOTS, WORLD_TASKS, WORLD_EVENTS, ..., WORLD_STRATEGIES */
#include "place.h"

#define FEASIBEE_INBOX WORLD_ROBOTS
#define FEASIBEE_WORDS WORLD_WORDS
#define FEASIBEE_DOUBLE
#define FEASIBEE_LOG natural_log
#define FEASIBEE_LAYOUT(layout) NULL /* messages stay words: 17 KB less */
#include "feasibee.h"
#include "given.h"

#define EXPORT(name) __attribute__((export_name(#name)))
#define GIVES(type, name, value) EXPORT(name) type name(void) { return value; }

/* The numbers of a scenario, in the order of numbers_of in lowering.py; a test compares them. Those of given.h follow. */
enum number {
    ROBOTS, TASKS, SPAN_X, SPAN_Y, UNIT, WALLED, RADIUS, REACH, MEAN_RUN, SIGHT_HIGH, SIGHT_LOW, RADIO_HIGH, RADIO_LOW,
    MISS, LOST, COUNT_SELF, STRATEGY, ID_BITS, SHARE_HIGH, SHARE_LOW, WHOLE_HIGH, WHOLE_LOW, EVENTS, NUMBERS
};

/* An event: its step; how many tasks and robots come, or go if negative; the task and the robot that it names, or -1; and
 * if it puts, where (model.md 6.17). Written by rowsOf in world.js. */
enum event { STEP, TASKS_MORE, ROBOTS_MORE, TASK_NAMED, ROBOT_NAMED, PUTS, PUT_X, PUT_Y, EVENT };

/* Bits of a robot's flags, as FLAGS in simulation/snapshot.py; a test compares them. */
enum flag { FEASIBLE = 1, NEUTRAL = 2, DISSEMINATING = 4, DECLARED = 8, WORKING = 16, THERE = 128 };

/* A robot's body: its place is in the arrays that the page reads. */
struct body {
    uint32_t number;
    int64_t step_x, step_y;     /* of a step, in units of fixed point */
    uint32_t walks, walk_left;
    uint32_t phases, joined;    /* joined: how many have had its number before it */
    bool blocked, there;
};

/* A side of the arena in units of fixed point, and the length of the way round; none within walls is as long. */
struct side {
    uint64_t length, round;
};

static double numbers[NUMBERS + GIVEN_PARAMETERS + FEASIBEE_PARAMETERS];
static struct side side_x, side_y;
static uint64_t seed;
static uint32_t run, now;
static int32_t events[WORLD_EVENTS][EVENT]; /* in the order in which they happen */
static uint32_t happened, most_robots, most_tasks, robots_there, tasks_there, appeared;
static uint32_t x[WORLD_ROBOTS], y[WORLD_ROBOTS], task_x[WORLD_TASKS], task_y[WORLD_TASKS];
static uint16_t flags[WORLD_ROBOTS];
static uint8_t headings[WORLD_ROBOTS];
static struct body bodies[WORLD_ROBOTS];
static struct feasibee_settings settings;
static struct feasibee_setting setting;
static struct feasibee_robot minds[WORLD_ROBOTS];
static struct feasibee_message messages[WORLD_ROBOTS];
static bool speaks[WORLD_ROBOTS];
static struct feasibee_thing robots_seen[WORLD_ROBOTS], tasks_seen[WORLD_TASKS];
static uint8_t robot_pieces[WORLD_ROBOTS], task_pieces[WORLD_TASKS];
static uint32_t feasible, infeasible, missing;

static uint32_t whole(enum number which)
{
    return (uint32_t)numbers[which];
}

/* Return a number from its two halves. */
static uint64_t joined(const double *halves)
{
    return (uint64_t)halves[0] << 32 | (uint64_t)halves[1];
}

static struct side side_of(enum number span)
{
    uint64_t length = (uint64_t)numbers[span];
    return (struct side){length, whole(WALLED) ? UINT64_MAX : length};
}

/* Return the distance of two coordinates, the short way round on the torus. */
static uint64_t distance(const struct side *side, uint32_t from, uint32_t to)
{
    uint64_t straight = from < to ? to - from : from - to, other = side->round - straight;
    return straight < other ? straight : other;
}

/* Return whether a place is within a range of a robot; walls shorten that of radio, and hide from sight. */
static bool within(uint32_t robot, uint32_t to_x, uint32_t to_y, enum number range)
{
    uint64_t across = distance(&side_x, x[robot], to_x), along = distance(&side_y, y[robot], to_y);
    uint64_t squared = across * across + along * along;
    if (squared > joined(numbers + range) || columns == 0)
        return squared <= joined(numbers + range);
    bool passes = range == RADIO_HIGH && joined(place_numbers + BEYOND) > 0;
    int walls = walls_between(x[robot], y[robot], to_x, to_y, passes ? MOST_WALLS : 1);
    return walls == 0 || (passes && squared < joined(place_numbers + BEYOND + 2 * (walls - 1)));
}

/* Return whether an event of a probability in 1/2^32 happens to a robot with another, or a task, in this step. */
static bool happens(uint32_t robot, uint32_t other, enum number probability, enum purpose purpose)
{
    double limit = numbers[probability];
    return limit > 0 && philox(seed, run, robot, now, purpose + PAIR * other).word[0] < limit;
}

/* Draw a heading and how long it lasts (model.md 2.1). */
static void turn(struct body *body)
{
    struct draw drawn = philox(seed, run, body->number, body->walks++, WALK);
    double cosine, sine;
    cos_sin(drawn.word[0], &cosine, &sine);
    body->step_x = (int64_t)__builtin_floor(numbers[REACH] * cosine + 0.5);
    body->step_y = (int64_t)__builtin_floor(numbers[REACH] * sine + 0.5);
    body->walk_left = duration(drawn.word[1], numbers[MEAN_RUN]);
    headings[body->number] = (uint8_t)(drawn.word[0] >> 24);
}

static uint32_t draw_steps(void *context, const struct feasibee_mean *mean)
{
    struct body *body = context;
    double share = (double)mean->share.part / mean->share.whole;
    uint32_t word = philox(seed, run, body->number, body->phases++, PHASE).word[0];
    return duration(word, mean->steps * (mean->complement ? 1.0 - share : share));
}

static struct feasibee_choice choice(void *context)
{
    const struct body *body = context;
    struct draw drawn = philox(seed, run, body->number, body->phases, PHASE);
    return (struct feasibee_choice){drawn.word[1], drawn.word[2]};
}

/* Count the most robots at a time, and the tasks of the whole run; lowering.py and the page refuse too many. */
static void read_events(void)
{
    most_robots = whole(ROBOTS);
    most_tasks = whole(TASKS);
    for (uint32_t k = 0; k < whole(EVENTS); k++) {
        most_robots += events[k][ROBOTS_MORE] > 0 ? (uint32_t)events[k][ROBOTS_MORE] : 0;
        most_tasks += events[k][TASKS_MORE] > 0 ? (uint32_t)events[k][TASKS_MORE] : 0;
    }
    if (most_robots > WORLD_ROBOTS || most_tasks > WORLD_TASKS)
        __builtin_trap();
}

/* Read what knowledge may depend on; the page's sliders change the numbers of robots and tasks. */
static void read_setting(void)
{
    int16_t robots = (int16_t)most_robots, tasks = (int16_t)most_tasks;
    setting = feasibee_setting_given(numbers + NUMBERS);
    setting.plan = (struct feasibee_plan){cells, (int32_t)(columns * rows)};
    setting.robots = setting.robot_ids = robots;
    setting.count = (int16_t)whole(ROBOTS);
    setting.tasks = setting.task_ids = tasks;
    if (whole(ID_BITS) == 0)
        setting.id_bits = robots > 2 ? (uint8_t)(32 - __builtin_clz(robots - 1u)) : 1;
    const struct feasibee_knowledge *knowledge = settings.strategy->knowledge;
    if (knowledge && (knowledge->words(&setting) > FEASIBEE_WORDS ||
                      feasibee_message_words(knowledge, &setting) > FEASIBEE_MESSAGE_WORDS))
        __builtin_trap(); /* lowering.py has refused it for the most robots and tasks */
}

static void read_settings(void)
{
    static const struct feasibee_strategy *const strategies[] = {WORLD_STRATEGIES};
    settings = feasibee_settings_given(numbers + NUMBERS, strategies[whole(STRATEGY)], &setting);
    settings.draw_duration = draw_steps;
    settings.draw_choice = choice;
    read_setting();
}

/* Return a robot's id: the number of the first robot with the same random id (model.md 6.10.5). */
static uint32_t id_of(uint32_t number)
{
    if (whole(ID_BITS) == 0)
        return number;
    uint32_t other = 0, lost = 32 - whole(ID_BITS), word = philox(seed, run, number, 0, IDENTITY).word[0];
    while (philox(seed, run, other, 0, IDENTITY).word[0] >> lost != word >> lost)
        other++;
    return other;
}

/* Share robots and tasks out among the pieces, and count the robots that are missing there (model.md 6.20.10).
 *
 * In a world that changes there is one piece with robots: who comes later is in it.
 */
static void fill_pieces(void)
{
    uint32_t robots[PIECES] = {0}, tasks[PIECES] = {0};
    share(robot_pieces, whole(ROBOTS), &robots_stand, NULL);
    for (uint32_t i = 0; i < whole(ROBOTS); i++)
        robots[robot_pieces[i]]++;
    share(task_pieces, whole(TASKS), &tasks_stand, robots);
    for (uint32_t j = 0; j < whole(TASKS); j++)
        tasks[task_pieces[j]]++;
    for (uint32_t i = whole(ROBOTS); i < most_robots; i++)
        robot_pieces[i] = robot_pieces[0];
    for (uint32_t j = whole(TASKS); j < most_tasks; j++)
        task_pieces[j] = robot_pieces[0];
    missing = 0;
    for (int piece = 0; piece < PIECES; piece++)
        missing += tasks[piece] > robots[piece] ? tasks[piece] - robots[piece] : 0;
    for (int64_t k = 0; k < columns * rows; k++)
        cells[k] &= (uint8_t)~TASKS_THERE;
    for (int piece = 0; piece < PIECES; piece++)
        for (uint32_t k = tasks_stand.first[piece]; robots[piece] && k < tasks_stand.first[piece + 1]; k++)
            cells[tasks_stand.cells[k]] |= TASKS_THERE;
}

/* Draw a position in a piece's cells (model.md 6.20.7). */
static void place_in(const struct draw *drawn, const struct stands *stands, int piece, uint32_t *to_x, uint32_t *to_y)
{
    uint64_t first = stands->first[piece], count = stands->first[piece + 1] - first;
    int64_t cell = stands->cells[first + (drawn->word[0] * count >> 32)];
    *to_x = (uint32_t)((cell % columns << cell_bits) + (int64_t)((uint64_t)drawn->word[1] << cell_bits >> 32));
    *to_y = (uint32_t)((cell / columns << cell_bits) + (int64_t)((uint64_t)drawn->word[2] << cell_bits >> 32));
}

/* Draw the place of a task, or of a robot, at least its radius away from walls. */
static void place(uint32_t number, bool is_robot, uint32_t *to_x, uint32_t *to_y)
{
    uint32_t counter = is_robot ? ATTEMPTS * bodies[number].joined : 0, margin = is_robot ? whole(RADIUS) : 0;
    struct draw drawn = philox(seed, run, number, counter, is_robot ? PLACE_ROBOT : PLACE_TASK);
    if (columns > 0) {
        const struct stands *stands = is_robot ? &robots_stand : &tasks_stand;
        place_in(&drawn, stands, is_robot ? robot_pieces[number] : task_pieces[number], to_x, to_y);
        return;
    }
    *to_x = margin + (uint32_t)(drawn.word[0] * (side_x.length - 2 * margin) >> 32);
    *to_y = margin + (uint32_t)(drawn.word[1] * (side_y.length - 2 * margin) >> 32);
}

/* Let robots know where a robot or task is. */
static void show_at(struct feasibee_thing *thing, uint32_t at_x, uint32_t at_y)
{
    thing->x = at_x * numbers[UNIT];
    thing->y = at_y * numbers[UNIT];
}

/* Write the point of an event; return whether it has one. */
static bool puts(const int32_t *event, uint32_t *to_x, uint32_t *to_y)
{
    if (!event || !event[PUTS])
        return false;
    *to_x = (uint32_t)event[PUT_X];
    *to_y = (uint32_t)event[PUT_Y];
    return true;
}

/* Let the next task appear; those there are in the order of their numbers. */
static void appear(const int32_t *event)
{
    uint32_t number = appeared++, k = tasks_there++;
    if (!puts(event, &task_x[k], &task_y[k]))
        place(number, false, &task_x[k], &task_y[k]);
    uint32_t hash = philox(seed, run, most_robots + number, 0, IDENTITY).word[1];
    tasks_seen[k] = (struct feasibee_thing){.id = (int32_t)number, .hash = hash};
    show_at(&tasks_seen[k], task_x[k], task_y[k]);
}

static void vanish(uint32_t k)
{
    for (tasks_there--; k < tasks_there; k++) {
        task_x[k] = task_x[k + 1];
        task_y[k] = task_y[k + 1];
        tasks_seen[k] = tasks_seen[k + 1];
    }
}

static void show_robot(uint32_t number)
{
    show_at(&robots_seen[number], x[number], y[number]);
    minds[number].x = robots_seen[number].x;
    minds[number].y = robots_seen[number].y;
}

/* Let the robot with the lowest free number come; its draws go on where the last of its number left them (6.17.6). */
static void join(const int32_t *event)
{
    uint32_t number = 0;
    while (bodies[number].there)
        number++;
    if (!puts(event, &x[number], &y[number]))
        place(number, true, &x[number], &y[number]);
    bodies[number].number = number;
    bodies[number].there = true;
    robots_there++;
    turn(&bodies[number]);
    uint32_t id = id_of(number), hash = philox(seed, run, id, 0, IDENTITY).word[1];
    robots_seen[number] = (struct feasibee_thing){.is_robot = true, .id = (int32_t)id, .hash = hash};
    show_at(&robots_seen[number], x[number], y[number]);
    struct feasibee_me me = {.context = &bodies[number], .id = (feasibee_id)id, .hash = hash};
    me.step = now > 0 ? now - 1 : 0;
    me.x = robots_seen[number].x;
    me.y = robots_seen[number].y;
    int8_t opinion = philox(seed, run, number, bodies[number].joined, FIRST_OPINION).word[0] >> 31;
    feasibee_begin(&minds[number], &settings, &me, opinion);
}

/* Return the number of a robot, given its place among those there. */
static uint32_t robot_at(uint32_t place)
{
    uint32_t number = 0;
    while (!bodies[number].there || place-- > 0)
        number++;
    return number;
}

static void leave(uint32_t number)
{
    bodies[number].there = false;
    bodies[number].joined++;
    robots_there--;
}

/* Return one of so many, drawn at random; before: how many events have drawn in this step. */
static uint32_t chosen(uint32_t before, enum purpose purpose, uint32_t count)
{
    return (uint32_t)((uint64_t)philox(seed, run, before, now, purpose).word[0] * count >> 32);
}

/* Take away the task or robot that an event names, or put it at its point, if it is there (model.md 6.17.12). */
static void take_or_put(const int32_t *event)
{
    for (uint32_t k = 0; k < tasks_there; k++) {
        if (tasks_seen[k].id != event[TASK_NAMED])
            continue;
        if (puts(event, &task_x[k], &task_y[k]))
            show_at(&tasks_seen[k], task_x[k], task_y[k]);
        else
            vanish(k);
    }
    uint32_t number = (uint32_t)event[ROBOT_NAMED];
    if (number >= most_robots || !bodies[number].there)
        return;
    if (puts(event, &x[number], &y[number]))
        show_robot(number);
    else
        leave(number);
}

/* Let the events of this step happen (model.md 6.17.2). */
static void happen(void)
{
    uint32_t vanished = 0, left = 0;
    for (; happened < whole(EVENTS) && (uint32_t)events[happened][STEP] == now; happened++) {
        const int32_t *event = events[happened];
        int32_t tasks = event[TASKS_MORE], robots = event[ROBOTS_MORE];
        for (; tasks > 0; tasks--)
            appear(event);
        for (; tasks < 0 && tasks_there > 0; tasks++)
            vanish(chosen(vanished++, VANISH, tasks_there));
        for (; robots > 0; robots--)
            join(event);
        for (; robots < 0 && robots_there > 0; robots++)
            leave(robot_at(chosen(left++, LEAVE, robots_there)));
        take_or_put(event);
        missing = tasks_there > robots_there ? tasks_there - robots_there : 0;
    }
}

/* Write the flags of all robots, and count opinions. */
static void show(void)
{
    feasible = infeasible = 0;
    for (uint32_t i = 0; i < most_robots; i++) {
        flags[i] = 0;
        if (!bodies[i].there)
            continue;
        const struct feasibee_robot *mind = &minds[i];
        feasible += mind->opinion == FEASIBEE_FEASIBLE;
        infeasible += mind->opinion == FEASIBEE_INFEASIBLE;
        flags[i] = (uint16_t)(WORKING | THERE | (mind->opinion == FEASIBEE_FEASIBLE ? FEASIBLE : 0) |
                              (mind->opinion == FEASIBEE_NONE ? NEUTRAL : 0) |
                              (mind->disseminating ? DISSEMINATING : 0) | (mind->declared != FEASIBEE_NONE ? DECLARED : 0));
    }
}

/* Return a coordinate after a step, round the torus; sets blocked at a wall. */
static uint32_t moved(const struct side *side, uint32_t from, int64_t step, bool *blocked)
{
    int64_t to = from + step, length = (int64_t)side->length;
    if (!whole(WALLED))
        return (uint32_t)((to % length + length) % length);
    *blocked = *blocked || to < numbers[RADIUS] || to > length - numbers[RADIUS];
    return (uint32_t)to;
}

/* Let a robot go a step; at a wall it stands, and turns at the end of the step (model.md 3.1, 6.2). */
static void move(uint32_t i)
{
    struct body *body = &bodies[i];
    body->blocked = columns > 0 && !goes(x[i], y[i], body->step_x, body->step_y);
    uint32_t to_x = moved(&side_x, x[i], body->step_x, &body->blocked);
    uint32_t to_y = moved(&side_y, y[i], body->step_y, &body->blocked);
    if (!body->blocked) {
        x[i] = to_x;
        y[i] = to_y;
    }
    show_robot(i);
}

/* Let a robot that explores see all that is within range (model.md 1.4, 4.2, 6.3). */
static void see(uint32_t i)
{
    uint16_t robots = 0, tasks = 0;
    for (uint32_t j = 0; j < most_robots; j++)
        if (!bodies[j].there)
            continue;
        else if (j == i ? whole(COUNT_SELF) : within(i, x[j], y[j], SIGHT_HIGH) && !happens(i, j, MISS, MISS_ROBOT)) {
            feasibee_recognise(&minds[i], &robots_seen[j]);
            robots++;
        }
    for (uint32_t j = 0; j < tasks_there; j++)
        if (within(i, task_x[j], task_y[j], SIGHT_HIGH) && !happens(i, (uint32_t)tasks_seen[j].id, MISS, MISS_TASK)) {
            feasibee_recognise(&minds[i], &tasks_seen[j]);
            tasks++;
        }
    feasibee_observe(&minds[i], robots, tasks);
}

/* Let a robot hear all that speak within range (model.md 4.5, 6.5). */
static void listen(uint32_t i)
{
    for (uint32_t j = 0; j < most_robots; j++)
        if (speaks[j] && j != i && within(i, x[j], y[j], RADIO_HIGH) && !happens(i, j, LOST, LOSS))
            feasibee_hear(&minds[i], (feasibee_id)robots_seen[j].id, &messages[j]);
}

/* What the page writes: the numbers, the events, the numbers of the place, and its cells: the bits of all, then the pieces of all. */
GIVES(double *, world_numbers, numbers)
GIVES(int32_t *, world_events, events[0])
GIVES(double *, world_place, place_numbers)
GIVES(uint8_t *, world_cells, cells)

/* Begin a run with the present numbers. */
EXPORT(world_begin) void world_begin(uint32_t seed_low, uint32_t seed_high, uint32_t number)
{
    seed = (uint64_t)seed_high << 32 | seed_low;
    run = number;
    now = 0;
    side_x = side_of(SPAN_X);
    side_y = side_of(SPAN_Y);
    read_events();
    read_grid();
    read_settings();
    fill_pieces();
    happened = robots_there = tasks_there = appeared = 0;
    for (uint32_t i = 0; i < most_robots; i++)
        bodies[i] = (struct body){0};
    while (tasks_there < whole(TASKS))
        appear(NULL);
    while (robots_there < whole(ROBOTS))
        join(NULL);
    happen();
    show();
}

/* Simulate one step: the world changes; all move; all observe and receive; timers advance (model.md 3, 6.17.1). */
EXPORT(world_step) void world_step(void)
{
    now++;
    happen();
    for (uint32_t i = 0; i < most_robots; i++) {
        if (bodies[i].there)
            move(i);
        speaks[i] = bodies[i].there && feasibee_message(&minds[i], &messages[i]);
    }
    for (uint32_t i = 0; i < most_robots; i++) {
        if (bodies[i].there && !minds[i].disseminating)
            see(i);
        if (bodies[i].there && feasibee_listens(&minds[i]))
            listen(i);
    }
    for (uint32_t i = 0; i < most_robots; i++) {
        if (!bodies[i].there)
            continue;
        if (--bodies[i].walk_left == 0 || bodies[i].blocked)
            turn(&bodies[i]);
        feasibee_end_step(&minds[i]);
    }
    show();
}

/* Return the number of one of the tasks there. */
EXPORT(world_task_number) uint32_t world_task_number(uint32_t k)
{
    return (uint32_t)tasks_seen[k].id;
}

/* Return whether a robot can be at a point, in the piece of those of the start. */
EXPORT(world_stands) bool world_stands(uint32_t at_x, uint32_t at_y)
{
    int64_t cell = columns ? (at_y >> cell_bits) * columns + (at_x >> cell_bits) : 0;
    return columns == 0 || (cells[cell] & PASSABLE && cells[columns * rows + cell] == robot_pieces[0]);
}

/* Return how many robots must hold an opinion for the swarm to have decided: strictly more than the share. */
EXPORT(world_needed) uint32_t world_needed(void)
{
    return (uint32_t)(robots_there * joined(numbers + SHARE_HIGH) / joined(numbers + WHOLE_HIGH)) + 1;
}

/* Return the opinion that the swarm holds: 1 feasible, 0 infeasible, -1 neither (model.md 4.7). */
EXPORT(world_decision) int32_t world_decision(void)
{
    return feasible >= world_needed() ? 1 : infeasible >= world_needed() ? 0 : -1;
}

/* Simulate until the swarm has decided, but at most so many steps; return the number of steps simulated. */
EXPORT(world_play) uint32_t world_play(uint32_t steps)
{
    uint32_t step = 0;
    while (step < steps && world_decision() < 0) {
        world_step();
        step++;
    }
    return step;
}

/* What the page reads. Missing are robots of all pieces together: 0 if the tasks are feasible. Arrays have an entry for
 * each number of a robot, and for each task that is there. */
GIVES(uint32_t, world_robots, most_robots)
GIVES(uint32_t, world_there, robots_there)
GIVES(uint32_t, world_tasks, tasks_there)
GIVES(uint32_t, world_missing, missing)
GIVES(uint32_t, world_feasible, feasible)
GIVES(uint32_t, world_infeasible, infeasible)
GIVES(uint32_t *, world_x, x)
GIVES(uint32_t *, world_y, y)
GIVES(uint16_t *, world_flags, flags)
GIVES(uint8_t *, world_headings, headings)
GIVES(uint32_t *, world_task_x, task_x)
GIVES(uint32_t *, world_task_y, task_y)

/* Return an exponential duration, for a test of draws.h. */
EXPORT(world_duration) uint32_t world_duration(uint32_t word, double mean)
{
    return duration(word, mean);
}
