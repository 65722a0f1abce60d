/* The paper's world in a page: torus, walk, sight and radio (docs/model.md 1 to 4) around the firmware's controller.
 *
 * The page writes the numbers of a scenario to world_numbers(), calls world_begin() and then world_step(), and
 * reads the arrays. Each run equals that of the engine to the last bit.
 */
#include "draws.h"
#include "limits.h" /* made by build.py: WORLD_ROBOTS, WORLD_TASKS, WORLD_STRATEGIES */

#define FEASIBEE_INBOX WORLD_ROBOTS
#define FEASIBEE_DOUBLE
#define FEASIBEE_LOG natural_log
#include "feasibee.h"

#define EXPORT(name) __attribute__((export_name(#name)))

/* The numbers of a scenario, in the order of numbers_of in lowering.py; a test compares them. */
enum number {
    ROBOTS, TASKS, REACH, MEAN_RUN, SIGHT_HIGH, SIGHT_LOW, RADIO_HIGH, RADIO_LOW, COUNT_SELF, STRATEGY, EXPLORATION,
    GAIN, DISSEMINATION_FLOOR, QUALITY_FLOOR, LISTENS_FOR, INBOX_SIZE, OWN_VOTE, EVERY_MESSAGE, SWITCHING, ROUNDS,
    HEARD, QUORUM, QUORUM_OF, K, VOTERS, CREDENCE, POSITIVE_FEEDBACK, ID_BITS, NEEDED, NUMBERS
};

/* Bits of a robot's flags, as FLAGS in simulation/snapshot.py; a test compares them. */
enum flag { FEASIBLE = 1, NEUTRAL = 2, DISSEMINATING = 4, DECLARED = 8, WORKING = 16, THERE = 128 };

/* A robot's body: its place is in the arrays that the page reads. */
struct body {
    uint32_t number;
    uint32_t step_x, step_y;    /* of a step; adding them wraps round the torus */
    uint32_t walks, walk_left;
    uint32_t phases;
};

static double numbers[NUMBERS];
static uint64_t seed;
static uint32_t run;
static uint32_t x[WORLD_ROBOTS], y[WORLD_ROBOTS], task_x[WORLD_TASKS], task_y[WORLD_TASKS];
static uint16_t flags[WORLD_ROBOTS];
static uint8_t headings[WORLD_ROBOTS];
static struct body bodies[WORLD_ROBOTS];
static struct feasibee_settings settings;
static struct feasibee_robot minds[WORLD_ROBOTS];
static struct feasibee_message messages[WORLD_ROBOTS];
static bool speaks[WORLD_ROBOTS];
static feasibee_id ids[WORLD_ROBOTS];
static uint32_t feasible, infeasible;

static uint32_t whole(enum number which)
{
    return (uint32_t)numbers[which];
}

static uint64_t limit(enum number high)
{
    return (uint64_t)numbers[high] << 32 | (uint64_t)numbers[high + 1];
}

/* Return the square of the distance, the short way round on the torus. */
static uint64_t squared_distance(uint32_t from_x, uint32_t from_y, uint32_t to_x, uint32_t to_y)
{
    int64_t across = (int32_t)(to_x - from_x), along = (int32_t)(to_y - from_y);
    return (uint64_t)(across * across) + (uint64_t)(along * along);
}

/* Draw a heading and how long it lasts (model.md 2.1). */
static void turn(struct body *body)
{
    struct words drawn = philox(seed, run, body->number, body->walks++, WALK);
    double cosine, sine;
    cos_sin(drawn.word[0], &cosine, &sine);
    body->step_x = (uint32_t)(int64_t)__builtin_floor(numbers[REACH] * cosine + 0.5);
    body->step_y = (uint32_t)(int64_t)__builtin_floor(numbers[REACH] * sine + 0.5);
    body->walk_left = duration(drawn.word[1], numbers[MEAN_RUN]);
    headings[body->number] = (uint8_t)(drawn.word[0] >> 24);
}

static uint32_t draw_duration(void *context, const struct feasibee_mean *mean)
{
    struct body *body = context;
    double share = (double)mean->share.part / mean->share.whole;
    uint32_t word = philox(seed, run, body->number, body->phases++, PHASE).word[0];
    return duration(word, mean->steps * (mean->complement ? 1.0 - share : share));
}

static struct feasibee_choice draw_choice(void *context)
{
    const struct body *body = context;
    struct words drawn = philox(seed, run, body->number, body->phases, PHASE);
    return (struct feasibee_choice){drawn.word[1], drawn.word[2]};
}

static bool draw_switch(void *context)
{
    const struct body *body = context;
    return philox(seed, run, body->number, body->phases, PHASE).word[3] < numbers[SWITCHING];
}

static void read_settings(void)
{
    static const struct feasibee_strategy *const strategies[] = {WORLD_STRATEGIES};
    settings = feasibee_defaults(strategies[whole(STRATEGY)]);
    settings.exploration = numbers[EXPLORATION];
    settings.gain = numbers[GAIN];
    settings.dissemination_floor = (uint16_t)whole(DISSEMINATION_FLOOR);
    settings.quality_floor = (uint16_t)whole(QUALITY_FLOOR);
    settings.listens_for = (int32_t)numbers[LISTENS_FOR];
    settings.inbox_size = (uint16_t)whole(INBOX_SIZE); /* at most WORLD_ROBOTS */
    settings.own_vote = whole(OWN_VOTE);
    settings.every_message = whole(EVERY_MESSAGE);
    settings.declare = (struct feasibee_declare){(uint16_t)whole(ROUNDS), (uint16_t)whole(HEARD),
                                               (uint16_t)whole(QUORUM), (uint16_t)whole(QUORUM_OF)};
    settings.parameters = (struct feasibee_parameters){(uint16_t)whole(K), whole(VOTERS), numbers[CREDENCE],
                                                       whole(POSITIVE_FEEDBACK)};
    settings.draw_duration = draw_duration;
    settings.draw_choice = draw_choice;
    settings.draw_switch = numbers[SWITCHING] < 0 ? NULL : draw_switch;
}

/* Return a robot's id: the number of the first robot with the same random id (model.md 6.10.5). */
static feasibee_id id_of(uint32_t number)
{
    if (whole(ID_BITS) == 0)
        return (feasibee_id)number;
    uint32_t other = 0, lost = 32 - whole(ID_BITS), word = philox(seed, run, number, 0, IDENTITY).word[0];
    while (philox(seed, run, other, 0, IDENTITY).word[0] >> lost != word >> lost)
        other++;
    return (feasibee_id)other;
}

static void begin_robot(uint32_t number)
{
    struct words place = philox(seed, run, number, 0, PLACE_ROBOT);
    x[number] = place.word[0];
    y[number] = place.word[1];
    bodies[number] = (struct body){.number = number};
    turn(&bodies[number]);
    ids[number] = id_of(number);
    struct feasibee_me me = {.context = &bodies[number], .id = ids[number]};
    int8_t opinion = philox(seed, run, number, 0, FIRST_OPINION).word[0] >> 31;
    feasibee_begin(&minds[number], &settings, &me, opinion);
}

/* Write the flags of all robots, and count opinions. */
static void show(void)
{
    feasible = infeasible = 0;
    for (uint32_t i = 0; i < whole(ROBOTS); i++) {
        const struct feasibee_robot *mind = &minds[i];
        feasible += mind->opinion == FEASIBEE_FEASIBLE;
        infeasible += mind->opinion == FEASIBEE_INFEASIBLE;
        flags[i] = (uint16_t)(WORKING | THERE | (mind->opinion == FEASIBEE_FEASIBLE ? FEASIBLE : 0) |
                              (mind->opinion == FEASIBEE_NONE ? NEUTRAL : 0) |
                              (mind->disseminating ? DISSEMINATING : 0) | (mind->declared != FEASIBEE_NONE ? DECLARED : 0));
    }
}

/* Let a robot see and hear all others within range (model.md 1.4, 4.2, 4.5). */
static void sense(uint32_t i)
{
    uint64_t sight = limit(SIGHT_HIGH), radio = limit(RADIO_HIGH);
    uint16_t robots_seen = (uint16_t)whole(COUNT_SELF), tasks_seen = 0;
    bool listens = feasibee_listens(&minds[i]);
    for (uint32_t j = 0; j < whole(ROBOTS); j++) {
        if (j == i)
            continue;
        uint64_t distance = squared_distance(x[i], y[i], x[j], y[j]);
        robots_seen += distance <= sight;
        if (listens && speaks[j] && distance <= radio)
            feasibee_hear(&minds[i], ids[j], &messages[j]);
    }
    for (uint32_t j = 0; !minds[i].disseminating && j < whole(TASKS); j++)
        tasks_seen += squared_distance(x[i], y[i], task_x[j], task_y[j]) <= sight;
    feasibee_observe(&minds[i], robots_seen, tasks_seen);
}

/* Return the numbers, for the page to write. */
EXPORT(world_numbers) double *world_numbers(void)
{
    return numbers;
}

/* Begin a run with the present numbers. */
EXPORT(world_begin) void world_begin(uint32_t seed_low, uint32_t seed_high, uint32_t number)
{
    seed = (uint64_t)seed_high << 32 | seed_low;
    run = number;
    read_settings();
    for (uint32_t j = 0; j < whole(TASKS); j++) {
        struct words place = philox(seed, run, j, 0, PLACE_TASK);
        task_x[j] = place.word[0];
        task_y[j] = place.word[1];
    }
    for (uint32_t i = 0; i < whole(ROBOTS); i++)
        begin_robot(i);
    show();
}

/* Simulate one step: all move; all observe and receive; timers advance (model.md 3). */
EXPORT(world_step) void world_step(void)
{
    uint32_t robots = whole(ROBOTS);
    for (uint32_t i = 0; i < robots; i++) {
        x[i] += bodies[i].step_x;
        y[i] += bodies[i].step_y;
        speaks[i] = feasibee_message(&minds[i], &messages[i]);
    }
    for (uint32_t i = 0; i < robots; i++)
        sense(i);
    for (uint32_t i = 0; i < robots; i++) {
        if (--bodies[i].walk_left == 0)
            turn(&bodies[i]);
        feasibee_end_step(&minds[i]);
    }
    show();
}

/* Return the opinion that the swarm holds: 1 feasible, 0 infeasible, -1 neither (model.md 4.7). */
EXPORT(world_decision) int32_t world_decision(void)
{
    return feasible >= whole(NEEDED) ? 1 : infeasible >= whole(NEEDED) ? 0 : -1;
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

EXPORT(world_feasible) uint32_t world_feasible(void)
{
    return feasible;
}

EXPORT(world_infeasible) uint32_t world_infeasible(void)
{
    return infeasible;
}

EXPORT(world_x) uint32_t *world_x(void)
{
    return x;
}

EXPORT(world_y) uint32_t *world_y(void)
{
    return y;
}

EXPORT(world_flags) uint16_t *world_flags(void)
{
    return flags;
}

EXPORT(world_headings) uint8_t *world_headings(void)
{
    return headings;
}

EXPORT(world_task_x) uint32_t *world_task_x(void)
{
    return task_x;
}

EXPORT(world_task_y) uint32_t *world_task_y(void)
{
    return task_y;
}

/* Return an exponential duration, for a test of draws.h. */
EXPORT(world_duration) uint32_t world_duration(uint32_t word, double mean)
{
    return duration(word, mean);
}
