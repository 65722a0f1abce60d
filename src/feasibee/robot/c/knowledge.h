/* Strategies that pass on knowledge (model.md 6.11). They need FEASIBEE_WORDS. */

#include "controller.h"
#include "bits.h"

#ifndef FEASIBEE_LAYOUT /* NULL in programs without frames */
#define FEASIBEE_LAYOUT(layout) layout
#endif

/* The words that a robot knows, or that a message holds. */
struct feasibee_row {
    int32_t *words;
    int16_t length;
};

#ifdef FEASIBEE_DOUBLE
/* What a robot knows of a place with walls: a byte for each cell, row by row, with 1 for a wall and 16 where tasks
 * may be. */
struct feasibee_plan {
    const uint8_t *cells;
    int32_t length;
};
#endif

struct feasibee_counts;
struct feasibee_layout; /* words.h */

/* The numbers of a scenario on which knowledge may depend, as Setting in strategies/contract.py. */
struct feasibee_setting {
    int16_t robots;        /* number of robots that have ids, which are below it */
    int16_t count;         /* number of robots at the start: what a robot knows with knows_count */
    int16_t tasks;         /* number of tasks that have ids, which are below it */
    int16_t robot_ids;     /* number of ids of robots; more than robots if Byzantine ones invent some */
    int16_t task_ids;      /* number of ids of tasks */
    uint8_t robot_classes;  /* number of classes of robots, at least 1 */
    uint8_t task_classes;   /* number of classes of tasks, at least 1 */
    uint8_t id_bits;        /* length of a robot's id in a message */
    bool knows_count;       /* whether robots know how many there are */
    bool colluding;         /* for lies: whether Byzantine robots collude */
    feasibee_real parameters[FEASIBEE_PARAMETERS]; /* those of the strategy, in the order of its file */
#ifdef FEASIBEE_DOUBLE
    /* For what strategies compute in floating point, such as a quiet time that isn't given. */
    bool walled;
    double width, height, sight, radio, speed; /* in units, and units per step */
    double exploration, dissemination, mean_run; /* mean durations, in steps; mean_run: between two turns */
    double flooding; /* in a place: step by which all surely know all names; elsewhere 0 */
    double delay; /* of messages, in steps */
    int16_t columns; /* of the plan; 0 without walls */
    struct feasibee_plan plan;
    double work, charge; /* steps that a robot works, then charges; 0 if none does */
#endif
};

/* The functions of a strategy for knowledge, as in its file in Python. The robot is `me`. */
struct feasibee_knowledge {
    uint8_t parameters; /* number of its parameters */
    bool by_name;       /* whether false sightings mean nothing */
    bool exact;         /* whether messages have the bits that Python counts, and none for the opinion */
    feasibee_int (*words)(const struct feasibee_setting *setting); /* at most FEASIBEE_WORDS */
    feasibee_int (*message_words)(const struct feasibee_setting *setting); /* NULL: as many */
    void (*start)(struct feasibee_row known, struct feasibee_robot *me); /* NULL: it begins with zeros */
    void (*observe)(struct feasibee_row known, const struct feasibee_thing *thing, struct feasibee_robot *me);
    void (*encode)(struct feasibee_row message, struct feasibee_row known, struct feasibee_robot *me);
    void (*merge)(struct feasibee_row known, struct feasibee_row message, feasibee_int sender,
                  struct feasibee_robot *me);
    void (*count)(struct feasibee_row known, struct feasibee_counts counts, struct feasibee_robot *me);
    feasibee_int (*declare)(struct feasibee_row known, struct feasibee_robot *me); /* NULL: it doesn't */
    feasibee_int (*judge)(struct feasibee_row known, struct feasibee_robot *me);   /* NULL: it doesn't */
    /* Writes a message as bits, or reads it into words that are 0; returns the sender's id, -1 if it isn't
     * sent. */
    feasibee_int (*layout)(struct feasibee_layout *wire, struct feasibee_row message, feasibee_int sender,
                           const struct feasibee_setting *setting);
};

/* Return whether a thing has an id below the number of ids: a false sighting has none, nor a misread tag. */
static inline bool feasibee_has_id(const struct feasibee_thing *thing, const struct feasibee_setting *setting)
{
    return thing->id >= 0 && thing->id < (thing->is_robot ? setting->robot_ids : setting->task_ids);
}

static inline uint16_t feasibee_message_words(const struct feasibee_knowledge *knowledge,
                                              const struct feasibee_setting *setting)
{
    return (uint16_t)(knowledge->message_words ? knowledge->message_words(setting) : knowledge->words(setting));
}
