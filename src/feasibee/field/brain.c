/* The C program of one robot, as it is flashed, for a process whose body is simulated (brain.py).
 *
 * The process gives it what its sensors see and its radio receives, and draws its random numbers, so that they can be
 * logged. STRATEGY and NAME are the strategy's, in C and in Python.
 */
#include "feasibee.h"
#include "given.h"

#define EXPORT __attribute__((visibility("default")))

/* Which robot it is, in the order of CompiledMind in brain.py; then come the numbers of given.h. */
enum own { ID, KIND, MARK, STEP, OPINION, STUBBORN, X, Y, GIVEN };

struct brain {
    uint32_t (*draw_steps)(double mean);
    void (*draw_words)(uint32_t *words);
    struct feasibee_setting setting;
    struct feasibee_settings settings;
    struct feasibee_wire wire;
    struct feasibee_robot robot;
    struct feasibee_message received;
};

static uint32_t duration(void *context, const struct feasibee_mean *mean)
{
    const struct brain *brain = context;
    return brain->draw_steps(feasibee_mean_steps(mean));
}

static struct feasibee_choice choice(void *context)
{
    const struct brain *brain = context;
    uint32_t words[2];
    struct feasibee_choice drawn;
    brain->draw_words(words);
    drawn.chance = words[0];
    drawn.message = words[1];
    return drawn;
}

EXPORT uint32_t brain_size(void)
{
    return sizeof(struct brain);
}

EXPORT void brain_begin(struct brain *brain, const double *numbers, uint32_t (*steps)(double),
                        void (*words)(uint32_t *), int32_t (*task_of)(uint32_t), const struct feasibee_set *sets,
                        uint16_t set_count, const uint8_t *cells, int32_t length)
{
    struct feasibee_me me = {.context = brain, .x = numbers[X], .y = numbers[Y]};
    brain->draw_steps = steps;
    brain->draw_words = words;
    brain->setting = feasibee_setting_given(numbers + GIVEN);
    brain->setting.plan.cells = cells;
    brain->setting.plan.length = length;
    brain->settings = feasibee_settings_given(numbers + GIVEN, &STRATEGY, &brain->setting);
    brain->settings.stubborn = numbers[STUBBORN] != 0.0;
    brain->settings.draw_duration = duration;
    brain->settings.draw_choice = choice;
    brain->settings.task_of = task_of;
    brain->settings.sets = sets;
    brain->settings.set_count = set_count;
    brain->wire = feasibee_wire_of(&brain->settings, NAME, brain->setting.id_bits);
    me.id = (feasibee_id)numbers[ID];
    me.kind = (uint8_t)numbers[KIND];
    me.hash = (uint32_t)numbers[MARK];
    me.step = (uint32_t)numbers[STEP];
    feasibee_begin(&brain->robot, &brain->settings, &me, (int8_t)numbers[OPINION]);
}

EXPORT void brain_move(struct brain *brain, double x, double y)
{
    brain->robot.x = x;
    brain->robot.y = y;
}

/* Write the frame of this step; return its length, 0 if the robot is silent, -1 if the message can't be encoded. */
EXPORT int32_t brain_speak(struct brain *brain, uint8_t *frame, uint32_t room)
{
    struct feasibee_message message;
    if (!feasibee_message(&brain->robot, &message))
        return 0;
    size_t length = feasibee_encode(&brain->wire, brain->robot.me.id, &message, frame, room);
    return length > 0 ? (int32_t)length : -1;
}

EXPORT void brain_observe(struct brain *brain, bool is_robot, uint8_t kind)
{
    feasibee_observe_one(&brain->robot, is_robot, kind);
}

EXPORT void brain_recognise(struct brain *brain, bool is_robot, int32_t id, uint8_t kind, uint32_t hash,
                            double x, double y)
{
    struct feasibee_thing thing = {is_robot, id, kind, hash, x, y};
    feasibee_recognise(&brain->robot, &thing);
}

/* Decode a frame and keep its message; return the sender's id, -1 if it isn't sent, -2 if it is no frame. */
EXPORT int32_t brain_decode(struct brain *brain, const uint8_t *frame, uint32_t length)
{
    feasibee_id sender;
    if (!feasibee_decode(&brain->wire, frame, length, &sender, &brain->received))
        return -2;
    return (int32_t)sender;
}

EXPORT void brain_hear(struct brain *brain, uint32_t sender)
{
    feasibee_hear(&brain->robot, sender, &brain->received);
}

EXPORT void brain_end_step(struct brain *brain)
{
    feasibee_end_step(&brain->robot);
}

/* Write opinion, declaration, phase, steps left in it, and whether messages count. */
EXPORT void brain_state(struct brain *brain, int32_t *state)
{
    state[0] = brain->robot.opinion;
    state[1] = brain->robot.declared;
    state[2] = brain->robot.disseminating;
    state[3] = (int32_t)brain->robot.phase_left;
    state[4] = feasibee_listens(&brain->robot);
}
