/* A Kilobot that decides with others whether the tasks are feasible; with -DTASK=1, one that marks a task.
 *
 * Kilobots see by their infrared radio: all send who they are about twice per second, and a robot sees those
 * whose message it has received in a step from at most SIGHT_MM.
 */

#include <kilolib.h>

#define FEASIBEE_INBOX 32
#include "feasibee.h"

enum { STEP_TICKS = 32, SIGHT_MM = 100, MOST_IN_SIGHT = 24, QUEUE = 16 };

#ifndef TASK
#define TASK 0
#endif

/* The message: kind and flags in data[0], the id in data[1] and data[2]. kilolib adds a checksum. */
enum { IS_TASK = 1, SPEAKS = 2, FEASIBLE = 4, DECLARED = 8 };

struct heard {
    uint8_t flags;
    uint8_t distance;
    uint16_t id;
};

static struct feasibee_settings settings;
static struct feasibee_robot robot;
static uint32_t random_state, next_step;

/* message_rx and message_tx interrupt loop: one index of 8 bits each says what is ready. */
static struct heard queue[QUEUE];
static volatile uint8_t queue_end, queue_start;
static message_t outgoing[2];
static volatile uint8_t shown;

static struct heard in_sight[MOST_IN_SIGHT]; /* each once per step */
static uint8_t number_in_sight;

static uint32_t random_word(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state;
}

static uint32_t draw_duration(void *context, const struct feasibee_mean *mean)
{
    (void)context;
    return feasibee_exponential(mean, random_word());
}

static struct feasibee_choice draw_choice(void *context)
{
    struct feasibee_choice choice;
    (void)context;
    choice.chance = random_word();
    choice.message = random_word();
    return choice;
}

/* Show a new message to the radio; the one before may be on its way. */
static void say(uint8_t flags)
{
    message_t *message = &outgoing[shown ^ 1];
    message->type = NORMAL;
    message->data[0] = flags;
    message->data[1] = (uint8_t)kilo_uid;
    message->data[2] = (uint8_t)(kilo_uid >> 8);
    message->crc = message_crc(message);
    shown ^= 1;
}

static message_t *message_tx(void)
{
    return &outgoing[shown];
}

static void message_rx(message_t *message, distance_measurement_t *distance)
{
    uint8_t next = (uint8_t)((queue_end + 1) % QUEUE);
    if (message->type != NORMAL || next == queue_start)
        return; /* not ours, or no room: a lost message */
    queue[queue_end].flags = message->data[0];
    queue[queue_end].distance = estimate_distance(distance);
    queue[queue_end].id = (uint16_t)(message->data[1] | message->data[2] << 8);
    queue_end = next;
}

/* See a neighbour once per step. */
static void see(const struct heard *heard)
{
    if (heard->distance > SIGHT_MM || number_in_sight == MOST_IN_SIGHT)
        return;
    for (uint8_t place = 0; place < number_in_sight; place++)
        if (in_sight[place].id == heard->id)
            return;
    in_sight[number_in_sight++] = *heard;
}

static void take_in_messages(void)
{
    for (; queue_start != queue_end; queue_start = (uint8_t)((queue_start + 1) % QUEUE)) {
        const struct heard *heard = &queue[queue_start];
        see(heard);
        if ((heard->flags & SPEAKS) && feasibee_listens(&robot)) {
            struct feasibee_message message = {0};
            message.opinion = heard->flags & FEASIBLE ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
            feasibee_hear(&robot, heard->id, &message);
        }
    }
}

/* Walk straight for ten steps on average, then turn for up to four. */
static void walk(void)
{
    static uint8_t turns;
    if (turns > 0)
        turns--;
    else if (random_word() % 10 == 0)
        turns = (uint8_t)(1 + random_word() % 4);
    spinup_motors();
    set_motors(turns > 0 ? kilo_turn_left : kilo_straight_left, turns > 0 ? 0 : kilo_straight_right);
}

/* End a step: what was seen, what to say, where to go. */
static void end_step(void)
{
    uint8_t tasks = 0;
    for (uint8_t place = 0; place < number_in_sight; place++)
        tasks = (uint8_t)(tasks + (in_sight[place].flags & IS_TASK));
    feasibee_observe(&robot, (uint16_t)(number_in_sight - tasks), tasks);
    number_in_sight = 0;
    struct feasibee_message message;
    uint8_t flags = 0;
    if (feasibee_message(&robot, &message))
        flags = (uint8_t)(SPEAKS | (message.opinion == FEASIBEE_FEASIBLE ? FEASIBLE : 0) |
                          (message.declared ? DECLARED : 0));
    feasibee_end_step(&robot);
    say(flags);
    if (robot.opinion == FEASIBEE_FEASIBLE)
        set_color(robot.declared != FEASIBEE_NONE ? RGB(0, 3, 0) : RGB(0, 1, 0));
    else
        set_color(robot.declared != FEASIBEE_NONE ? RGB(3, 0, 0) : RGB(1, 0, 0));
    walk();
}

static void setup(void)
{
    struct feasibee_me me = {0};
    for (uint8_t byte = 0; byte < 4; byte++)
        random_state = random_state << 8 | rand_hard();
    random_state |= 1; /* never 0 */
    settings = feasibee_defaults(&feasibee_dmmd);
    settings.draw_duration = draw_duration;
    settings.draw_choice = draw_choice;
    settings.declare.rounds = 3;
    feasibee_begin(&robot, &settings, &me, (int8_t)(random_word() & 1));
    say(TASK ? IS_TASK : 0);
    set_color(TASK ? RGB(0, 0, 1) : RGB(0, 0, 0));
    next_step = kilo_ticks + STEP_TICKS;
}

static void loop(void)
{
    if (TASK)
        return;
    take_in_messages();
    if ((int32_t)(kilo_ticks - next_step) >= 0) {
        next_step += STEP_TICKS;
        end_step();
    }
}

int main(void)
{
    kilo_init();
    kilo_message_rx = message_rx;
    kilo_message_tx = message_tx;
    kilo_start(setup, loop);
    return 0;
}
