/* An e-puck2 that decides with others whether the tasks are feasible; with -DTASK=1, one that marks a task.
 *
 * For the main processor, with GCtronic's e-puck2_main-processor as library. Robots see and talk by infrared:
 * each sends a byte about twice per second, and sees those whose byte it has received in a step. The selector's
 * position is its id.
 */

#include "ch.h"
#include "hal.h"
#include "ircom/ircom.h"
#include "ircom/ircomMessages.h"
#include "ircom/ircomReceive.h"
#include "ircom/ircomSend.h"
#include "leds.h"
#include "main.h"
#include "memory_protection.h"
#include "motors.h"
#include "selector.h"

#define FEASIBEE_INBOX 16
#include "feasibee.h"

#ifndef TASK
#define TASK 0
#endif

/* The byte: the id in four bits, and flags. ircom adds a checksum of two bits. */
enum { SENDER = 0x0f, IS_TASK = 0x10, SPEAKS = 0x20, FEASIBLE = 0x40, TICK_MS = 100, TICKS = 20, NEAR = 150 };

messagebus_t bus;
parameter_namespace_t parameter_root;
static MUTEX_DECL(bus_lock);
static CONDVAR_DECL(bus_condvar);

static struct feasibee_settings settings;
static struct feasibee_robot robot;
static uint32_t in_sight; /* a bit per robot, then a bit per task */
static uint8_t said;

static uint32_t random_word(void)
{
    while (!(RNG->SR & RNG_SR_DRDY))
        ; /* the hardware draws one in a microsecond */
    return RNG->DR;
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

static void receive_all(void)
{
    IrcomMessage got;
    struct feasibee_message message = {0};
    for (ircomPopMessage(&got); got.error >= 0; ircomPopMessage(&got)) {
        uint8_t byte = (uint8_t)got.value;
        if (got.error || (byte & (SENDER | IS_TASK)) == (said & (SENDER | IS_TASK)))
            continue; /* damaged, or an echo */
        in_sight |= 1UL << (byte & (SENDER | IS_TASK));
        message.opinion = byte & FEASIBLE ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
        if ((byte & SPEAKS) && feasibee_listens(&robot))
            feasibee_hear(&robot, byte & SENDER, &message);
    }
}

/* Drive straight for ten steps on average, and turn where something is ahead. */
static void drive(void)
{
    bool blocked = ircom_get_calibrated_prox(0) > NEAR || ircom_get_calibrated_prox(7) > NEAR;
    bool turns = blocked || random_word() % (10 * TICKS) == 0;
    left_motor_set_speed(TASK ? 0 : 500);
    right_motor_set_speed(TASK ? 0 : turns ? -500 : 500);
    if (turns && !TASK)
        chThdSleepMilliseconds(1 + random_word() % 1000);
}

static uint16_t count(uint32_t bits)
{
    return (uint16_t)__builtin_popcount(bits);
}

static void end_step(void)
{
    struct feasibee_message message;
    feasibee_observe(&robot, count(in_sight & 0xffff), count(in_sight >> 16));
    in_sight = 0;
    said &= SENDER;
    if (feasibee_message(&robot, &message))
        said |= (uint8_t)(SPEAKS | (message.opinion == FEASIBEE_FEASIBLE ? FEASIBLE : 0));
    feasibee_end_step(&robot);
    set_body_led(robot.opinion == FEASIBEE_FEASIBLE);    /* green */
    set_front_led(robot.opinion == FEASIBEE_INFEASIBLE); /* red */
}

int main(void)
{
    struct feasibee_me me = {0};
    halInit();
    chSysInit();
    mpu_init();
    messagebus_init(&bus, &bus_lock, &bus_condvar);
    RCC->AHB2ENR |= RCC_AHB2ENR_RNGEN;
    RNG->CR = RNG_CR_RNGEN;
    motors_init();
    ircomStart();
    ircomEnableContinuousListening();
    ircomListen();
    said = (uint8_t)(get_selector() | (TASK ? IS_TASK : 0));
    settings = feasibee_defaults(&feasibee_dmmd);
    settings.draw_duration = draw_duration;
    settings.draw_choice = draw_choice;
    feasibee_begin(&robot, &settings, &me, (int8_t)(random_word() & 1));
    for (uint32_t tick = 1;; tick++) {
        receive_all();
        if (random_word() % 5 == 0) { /* at random, as two at once are lost */
            ircomSend(said);
            while (!ircomSendDone())
                chThdSleepMilliseconds(1);
        }
        if (tick % TICKS == 0 && !TASK)
            end_step();
        drive();
        chThdSleepMilliseconds(TICK_MS);
    }
}

uintptr_t __stack_chk_guard = 0xe2dee396; /* as in the library's template */

void __stack_chk_fail(void)
{
    chSysHalt("stack overflow");
}
