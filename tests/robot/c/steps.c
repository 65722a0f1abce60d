/* Feed a controller with random steps, and print its state after each: boards.py has the same in Python.
 *
 * CASES is the number of settings, and settings_of(case, settings) writes them; boards.py makes both. With
 * FRAMES, the controller hears and sends frames.
 */

#include "feasibee.h"

#include "board.h"
#include "cases.h"

static uint32_t state;
#ifdef FRAMES
static struct feasibee_wire wire;
static uint8_t frame[FEASIBEE_FRAME];
#endif

static uint32_t random_word(void)
{
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
}

static uint32_t whole_steps(const struct feasibee_mean *mean)
{
    uint32_t part = mean->share.part;
    if (mean->complement)
        part = mean->share.whole - part;
#ifdef FEASIBEE_DOUBLE
    double share = (double)mean->share.part / mean->share.whole;
    return (uint32_t)(mean->steps * (mean->complement ? 1.0 - share : share));
#else
    return (uint32_t)((uint64_t)mean->steps * part / mean->share.whole / FEASIBEE_STEP);
#endif
}

static uint32_t draw_duration(void *context, const struct feasibee_mean *mean)
{
    (void)context;
    return whole_steps(mean) + 1 + (random_word() & 7);
}

static struct feasibee_choice draw_choice(void *context)
{
    (void)context;
    struct feasibee_choice choice;
    choice.chance = random_word();
    choice.message = random_word();
    return choice;
}

static char *hex(char *to, uint32_t number, int digits)
{
    for (int digit = digits - 1; digit >= 0; digit--)
        *to++ = "0123456789abcdef"[number >> (4 * digit) & 15];
    return to;
}

static struct feasibee_settings settings;
static struct feasibee_robot robot;

static void hear(uint32_t word)
{
    feasibee_id sender = (word & 255) % 40;
    struct feasibee_message message;
    message.opinion = word >> 8 & 1;
    message.declared = false;
    message.value = settings.strategy->value_bits ? word >> 16 : 0;
#ifdef FRAMES
    size_t length = feasibee_encode(&wire, sender, &message, frame, sizeof frame);
    message.opinion = message.value = 0;
    if (!feasibee_decode(&wire, frame, length, &sender, &message))
        print_line("no frame");
#endif
    if (feasibee_listens(&robot))
        feasibee_hear(&robot, sender, &message);
}

static void step(void)
{
    struct feasibee_message message;
    uint32_t word = random_word();
    feasibee_observe(&robot, word & 3, word >> 2 & 3);
    for (uint8_t left = word >> 4 & 3; left > 0; left--)
        hear(random_word());
    bool sends = feasibee_message(&robot, &message);
    feasibee_end_step(&robot);
    char line[20];
    char *end = hex(line, (robot.opinion + 1) | (robot.declared != FEASIBEE_NONE) << 2 | robot.disseminating << 3, 1);
    end = hex(end, robot.phase_left, 2);
    end = hex(end, sends ? message.opinion | message.declared << 1 : 15, 1);
    end = hex(end, sends ? message.value : 0, 4);
#ifdef FRAMES
    size_t length = sends ? feasibee_encode(&wire, robot.me.id, &message, frame, sizeof frame) : 0;
    end = hex(end, feasibee_crc(frame, length), 8);
#endif
    *end = '\0';
    print_line(line);
}

int main(void)
{
    for (int each = 0; each < CASES; each++) {
        struct feasibee_me me = {0};
        state = 17 + each;
        settings = feasibee_defaults(&STRATEGY);
        settings.draw_duration = draw_duration;
        settings.draw_choice = draw_choice;
        settings_of(each, &settings);
#ifdef FRAMES
        wire = feasibee_wire_of(&settings, FRAMES, 6);
#endif
        feasibee_begin(&robot, &settings, &me, each & 1);
        for (uint16_t left = STEPS; left > 0; left--)
            step();
    }
    char line[16];
    *hex(line, stack_used(), 4) = '\0';
    print_line(line);
    stop();
    return 0;
}
