/* The decisions of one robot: feasibee.h with a random generator, and its messages as bytes. */

#include "mind.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FEASIBEE_DOUBLE   /* a simulated robot can afford doubles */
#define FEASIBEE_INBOX 1024
#include "feasibee.h"     /* feasibee robot header > feasibee.h */

struct mind {
    struct feasibee_setting setting;
    struct feasibee_settings settings;
    struct feasibee_robot robot;
    struct feasibee_wire wire;
    double (*uniform)(void *context);
    void *context;
};

static const struct {
    const char *name;
    const struct feasibee_strategy *strategy;
} STRATEGIES[] = {
    {"dmmd", &feasibee_dmmd},
    {"dmvd", &feasibee_dmvd},
    {"dc", &feasibee_dc},
    {"voter", &feasibee_voter},
    {"majority", &feasibee_majority},
    {"k-unanimity", &feasibee_k_unanimity},
    {"cross-inhibition", &feasibee_cross_inhibition},
    {"bayes", &feasibee_bayes},
};

/* A uniform word of 32 bits; `uniform` may return 1. */
static uint32_t word(struct mind *mind)
{
    double drawn = mind->uniform(mind->context) * 4294967296.0;
    return drawn < 4294967295.0 ? (uint32_t)drawn : UINT32_MAX;
}

/* Exponential around its mean, in whole steps, at least one (model.md 3.4). */
static uint32_t duration(void *context, const struct feasibee_mean *mean)
{
    struct mind *mind = context;
    double share = (double)mean->share.part / mean->share.whole;
    double steps = mean->steps * (mean->complement ? 1.0 - share : share);
    double drawn = ceil(-steps * log(1.0 - word(mind) / 4294967296.0));
    return drawn < 1.0 ? 1 : drawn > 1073741824.0 ? 1073741824 : (uint32_t)drawn;
}

static struct feasibee_choice choice(void *context)
{
    struct feasibee_choice drawn;
    drawn.chance = word(context);
    drawn.message = word(context);
    return drawn;
}

/* The parameters of a strategy, in the order of its file in Python. */
static struct feasibee_setting setting_of(const struct mind_settings *given,
                                          const struct feasibee_strategy *strategy)
{
    struct feasibee_setting setting = {0};
    if (strategy == &feasibee_k_unanimity) {
        setting.parameters[0] = given->k;
    } else if (strategy == &feasibee_bayes) {
        setting.parameters[0] = given->credence;
        setting.parameters[1] = given->positive_feedback;
    }
    return setting;
}

static struct feasibee_settings settings_of(const struct mind_settings *given,
                                            const struct feasibee_strategy *strategy)
{
    struct feasibee_settings settings = feasibee_defaults(strategy);
    settings.exploration = given->exploration;
    settings.gain = given->gain;
    settings.dissemination_floor = (uint16_t)given->dissemination_floor;
    settings.quality_floor = (uint16_t)given->quality_floor;
    settings.listens_for = given->listens_for;
    settings.inbox_size = (uint16_t)given->inbox_size;
    settings.own_vote = given->own_vote;
    settings.random_ties = given->random_ties;
    settings.first_sight = given->first_sight;
    settings.every_message = given->every_message;
    settings.declare.rounds = (uint16_t)given->declare_rounds;
    settings.declare.heard = (uint16_t)given->declare_heard;
    settings.declare.quorum = (uint16_t)lround(given->declare_quorum * 10000);
    settings.declare.quorum_of = 10000;
    settings.draw_duration = duration;
    settings.draw_choice = choice;
    return settings;
}

struct mind *mind_new(const struct mind_settings *given, uint16_t id, double (*uniform)(void *context),
                      void *context)
{
    const struct feasibee_strategy *strategy = NULL;
    for (size_t i = 0; i < sizeof STRATEGIES / sizeof *STRATEGIES; i++)
        if (strcmp(STRATEGIES[i].name, given->strategy) == 0)
            strategy = STRATEGIES[i].strategy;
    struct mind *mind = strategy ? calloc(1, sizeof *mind) : NULL;
    if (!mind)
        return NULL;
    mind->uniform = uniform;
    mind->context = context;
    mind->setting = setting_of(given, strategy);
    mind->settings = settings_of(given, strategy);
    mind->settings.setting = &mind->setting;
    mind->wire = feasibee_wire_of(&mind->settings, given->strategy, (uint8_t)given->id_bits);
    struct feasibee_me me = {0};
    me.context = mind;
    me.id = id;
    feasibee_begin(&mind->robot, &mind->settings, &me, (int8_t)(word(mind) >> 31));
    return mind;
}

void mind_free(struct mind *mind)
{
    free(mind);
}

void mind_see(struct mind *mind, int robots, int tasks)
{
    feasibee_observe(&mind->robot, (uint16_t)robots, (uint16_t)tasks);
}

bool mind_hear(struct mind *mind, const uint8_t *bytes, size_t size)
{
    struct feasibee_message message;
    feasibee_id sender;
    if (size < MIND_MESSAGE_BYTES || bytes[0] == 0 || bytes[0] >= MIND_MESSAGE_BYTES ||
        !feasibee_decode(&mind->wire, bytes + 1, bytes[0], &sender, &message))
        return false;
    if (feasibee_listens(&mind->robot))
        feasibee_hear(&mind->robot, sender, &message);
    return true;
}

size_t mind_say(struct mind *mind, uint8_t bytes[MIND_MESSAGE_BYTES])
{
    struct feasibee_message message;
    memset(bytes, 0, MIND_MESSAGE_BYTES);
    if (!feasibee_message(&mind->robot, &message))
        return 0;
    size_t length = feasibee_encode(&mind->wire, mind->robot.me.id, &message, bytes + 1, MIND_MESSAGE_BYTES - 1);
    bytes[0] = (uint8_t)length;
    return MIND_MESSAGE_BYTES;
}

void mind_end_step(struct mind *mind)
{
    feasibee_end_step(&mind->robot);
}

int mind_opinion(const struct mind *mind)
{
    return mind->robot.opinion;
}

bool mind_declared(const struct mind *mind)
{
    return mind->robot.declared != FEASIBEE_NONE;
}
