/* Run the e-puck2 for 600 seconds among five robots that say infeasible, and three tasks; one robot leaves, and
 * something is ahead at times. Print both LEDs, the last byte while it spoke, or the last if it never did, whether
 * it saw all robots and tasks in each step of its explorations, and whether it turned.
 */

#define main robot_main
#include "epuck2.c"
#undef main

#include <stdio.h>
#include <stdlib.h>

enum { SECONDS = 600, ME = 9, ROBOTS = 5, TASKS = 3, ERRORS = 2 };

rcc_t rcc;
static rng_t rng;
static uint32_t now, next;
static unsigned int body, front;
static long int last = -1, spoken = -1;
static bool sending, listening, sees_all = true, straight, turned;

rng_t *rng_of_the_board(void)
{
    rng.SR ^= rng.CR == RNG_CR_RNGEN && rcc.AHB2ENR == RCC_AHB2ENR_RNGEN ? RNG_SR_DRDY : 0;
    rng.DR = rng.DR * 1664525 + 1013904223;
    return &rng;
}

static uint32_t robots_now(void)
{
    return now < SECONDS * 500u ? ROBOTS : ROBOTS - 1;
}

/* Give what came in the last half second: damaged bytes, an echo, robots, tasks. */
void ircomPopMessage(IrcomMessage *message)
{
    static int left;
    message->error = -1;
    if (!listening)
        return;
    if (left == 0 && now >= next) {
        next = now + 500;
        left = ERRORS + 1 + ROBOTS + TASKS;
    }
    if (left == 0)
        return;
    left--;
    message->error = left >= 1 + ROBOTS + TASKS;
    if (message->error)
        message->value = SPEAKS | FEASIBLE | left;
    else if (left == ROBOTS + TASKS)
        message->value = last < 0 ? ME | (TASK ? IS_TASK : 0) : last;
    else
        message->value = left >= ROBOTS ? IS_TASK | left : left < (int)robots_now() ? SPEAKS | left : ME;
}

void chThdSleepMilliseconds(uint32_t milliseconds)
{
    if (milliseconds == 0)
        abort(); /* ChibiOS forbids it */
    now += milliseconds;
    sending = false;
    if (now < SECONDS * 1000u)
        return;
    printf("%u%u %lx %d%d\n", body, front, spoken, sees_all, straight && turned);
    exit(0);
}

void set_body_led(unsigned int value)
{
    body = value;
}

/* The last call of a step. While the robot explores, it has counted what was near. */
void set_front_led(unsigned int value)
{
    static uint32_t robots, tasks;
    front = value;
    bool leaving = now - SECONDS * 500u < 5000;
    if (robot.robots_seen > robots && !robot.disseminating && !leaving)
        sees_all = sees_all && robot.robots_seen == robots + robots_now() && robot.tasks_seen == tasks + TASKS;
    robots = robot.robots_seen;
    tasks = robot.tasks_seen;
}

void ircomSend(long int value)
{
    if (sending)
        abort();
    sending = true;
    last = value;
    spoken = value & SPEAKS || spoken < 0 ? value : spoken;
}

int ircomSendDone(void)
{
    return !sending;
}

int ircom_get_calibrated_prox(unsigned int sensor)
{
    return sensor == 7 && now % 60000 < 1000 ? 400 : 0;
}

void left_motor_set_speed(int speed)
{
    straight = straight || speed > 0;
}

void right_motor_set_speed(int speed)
{
    turned = turned || speed < 0;
}

int get_selector(void)
{
    return ME;
}

void ircomListen(void)
{
    listening = true;
}

void chSysHalt(const char *reason)
{
    puts(reason);
    abort();
}

void messagebus_init(messagebus_t *messages, void *lock, void *condition)
{
    messages->lock = lock;
    messages->condition = condition;
}

void ircomEnableContinuousListening(void)
{
}

void ircomStart(void)
{
}

void motors_init(void)
{
}

void mpu_init(void)
{
}

void chSysInit(void)
{
}

void halInit(void)
{
}

int main(void)
{
    return robot_main();
}
