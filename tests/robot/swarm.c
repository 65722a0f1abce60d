/* Several controllers that pass on knowledge by frames: reads a swarm from standard input, writes what it does. */

#include "stream.h"

enum { ROBOTS = 8 };

static struct feasibee_robot robots[ROBOTS];
static uint32_t last[ROBOTS];
static uint8_t frames[ROBOTS][FRAME];
static size_t lengths[ROBOTS];
static uint32_t bits[ROBOTS], lies[ROBOTS];

/* The functions of a strategy that a robot doesn't need: the length of a message, and lies. */
static const struct extra {
    feasibee_int (*bits)(struct feasibee_row message, struct feasibee_robot *me);
    void (*lie)(struct feasibee_row message, feasibee_int feasible, struct feasibee_robot *me);
} extras[] = {EXTRAS};
static const struct extra *extra;

static void hear_frame(struct feasibee_robot *robot, const uint8_t *frame, size_t length)
{
    struct feasibee_message message;
    feasibee_id sender;
    if (feasibee_listens(robot) && feasibee_decode(&wire, frame, length, &sender, &message))
        feasibee_hear(robot, sender, &message);
}

static void observe(struct feasibee_robot *robot)
{
#ifdef FEASIBEE_DOUBLE
    take(&robot->x, sizeof robot->x);
    take(&robot->y, sizeof robot->y);
#endif
    for (uint8_t left = read_byte(); left > 0; left--) {
        struct feasibee_thing thing = {0};
        thing.is_robot = read_byte();
        int16_t id;
        take(&id, sizeof id);
        thing.id = id;
        thing.kind = read_byte();
        take(&thing.hash, sizeof thing.hash);
#ifdef FEASIBEE_DOUBLE
        take(&thing.x, sizeof thing.x);
        take(&thing.y, sizeof thing.y);
#endif
        feasibee_recognise(robot, &thing);
    }
}

/* Note how many bits a message has, and what a Byzantine robot would make of it. */
static void measure(uint8_t number, const struct feasibee_message *message)
{
    struct feasibee_message lie = *message;
    struct feasibee_row row = feasibee_words_of(&robots[number], lie.words);
    if (extra->bits)
        bits[number] = (uint32_t)extra->bits(row, &robots[number]);
    if (extra->lie && setting.robot_ids > setting.robots)
        extra->lie(row, number & 1, &robots[number]);
    lies[number] = feasibee_crc((const uint8_t *)row.words, (size_t)row.length * sizeof row.words[0]);
}

static void speak(uint8_t number)
{
    struct feasibee_message message;
    lengths[number] = bits[number] = lies[number] = 0;
    if (feasibee_message(&robots[number], &message)) {
        measure(number, &message);
        lengths[number] = feasibee_encode(&wire, robots[number].me.id, &message, frames[number], FRAME);
        if (lengths[number] == 0)
            exit(5);
    }
}

static void write_state(uint8_t number, uint32_t words)
{
    struct feasibee_robot *robot = &robots[number];
    uint8_t flags = (uint8_t)robot->disseminating;
    uint8_t bytes[3] = {(uint8_t)(robot->opinion + 1), (uint8_t)(robot->declared + 1), flags};
    uint16_t length = (uint16_t)lengths[number];
    uint32_t frame = feasibee_crc(frames[number], length);
    uint32_t known = feasibee_crc((const uint8_t *)robot->known, words * sizeof robot->known[0]);
    uint32_t remembered = 0; /* the checksum of nothing */
    uint16_t quality = 0;
#ifdef FEASIBEE_DOUBLE
    remembered = feasibee_crc((const uint8_t *)robot->memory, memory * sizeof robot->memory[0]);
    quality = (uint16_t)(feasibee_double(robot->feasible_quality) * 4096.0);
#endif
    give(bytes, 3);
    give(&robot->phase_left, 4);
    give(&length, 2);
    give(&frame, 4);
    give(&known, 4);
    give(&remembered, 4);
    give(&quality, 2);
    give(&bits[number], 4);
    give(&lies[number], 4);
}

static void step(uint8_t number, uint32_t words)
{
    static uint8_t frame[FRAME];
    for (uint8_t k = 0; k < number; k++)
        speak(k);
    for (uint8_t k = 0; k < number; k++) {
        observe(&robots[k]);
        uint8_t heard = read_byte();
        for (uint8_t other = 0; other < number; other++)
            if (heard >> other & 1 && lengths[other] > 0)
                hear_frame(&robots[k], frames[other], lengths[other]);
        for (uint8_t left = read_byte(); left > 0; left--) {
            uint16_t length = read_short();
            take(frame, length);
            hear_frame(&robots[k], frame, length);
        }
    }
    for (uint8_t k = 0; k < number; k++) {
        feasibee_end_step(&robots[k]);
        write_state(k, words);
    }
}

int main(void)
{
    for (int byte = getchar(); byte != EOF; byte = getchar()) {
        ungetc(byte, stdin);
        uint8_t strategy = read_setting();
        extra = &extras[strategy];
        uint32_t words = (uint32_t)strategies[strategy]->knowledge->words(&setting);
        uint32_t steps;
        uint8_t number = read_byte();
        take(&steps, sizeof steps);
        if (words > FEASIBEE_WORDS || number > ROBOTS)
            return 2;
        for (uint8_t k = 0; k < number; k++) {
            struct feasibee_me me = {.context = &last[k], .id = k};
            me.kind = read_byte();
            take(&last[k], 4);
            take(&me.hash, 4);
            take(&me.step, 4);
            feasibee_begin(&robots[k], &settings, &me, (int8_t)read_byte());
        }
        for (; steps > 0; steps--)
            step(number, words);
    }
    return 0;
}
