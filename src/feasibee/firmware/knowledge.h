/* Strategies that pass on knowledge (model.md 6.11). */

#include "controller.h"

/* The numbers of a scenario on which knowledge may depend, as Setting in strategies/contract.py. */
struct feasibee_setting {
    uint16_t robots;    /* number of robots that have ids, which are below it */
    uint16_t count;     /* number of robots at the start: what a robot knows with knows_count */
    uint16_t robot_ids; /* number of ids of robots */
    uint16_t task_ids;  /* number of ids of tasks */
    uint8_t id_bits;    /* length of a robot's id in a message */
    bool knows_count;   /* whether robots know how many there are */
};

/* The functions of a strategy for knowledge. robot->known is the row of words, 0 at the start. robot->me says
 * which robot it is, !robot->disseminating whether it explores. */
struct feasibee_knowledge {
    void (*start)(struct feasibee_robot *robot); /* NULL: it begins with zeros */
    void (*observe)(struct feasibee_robot *robot, const struct feasibee_thing *thing);
    void (*encode)(struct feasibee_robot *robot, uint32_t *words); /* write the words of a message */
    void (*merge)(struct feasibee_robot *robot, const uint32_t *words, feasibee_id sender);
    void (*count)(struct feasibee_robot *robot, uint32_t *robots, uint32_t *tasks); /* what is rated */
    int8_t (*declare)(struct feasibee_robot *robot); /* NULL: it doesn't; -1: it isn't sure */
    int8_t (*judge)(struct feasibee_robot *robot);   /* NULL: it doesn't; -1: it keeps its opinion */
};
