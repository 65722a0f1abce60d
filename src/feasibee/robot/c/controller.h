/* The controller of one robot: explore, disseminate, decide (docs/model.md 4).
 *
 * In each step, by the robot's own clock:
 *
 *   feasibee_observe(&robot, robots, tasks);               how many are in sight
 *   if (feasibee_listens(&robot))
 *       feasibee_hear(&robot, sender, &message);           once per message received
 *   if (feasibee_message(&robot, &message))
 *       broadcast(id, message);                            your radio
 *   feasibee_end_step(&robot);
 *
 * No heap, no recursion, no state outside struct feasibee_robot. The caller keeps values in the ranges that
 * the comments name: nothing checks them.
 *
 * Macros, to be defined before the file is included:
 *
 *   FEASIBEE_INBOX    most senders whose latest message is kept, 1 to 65535; by default 64
 *   FEASIBEE_ID       unsigned type of ids; by default uint16_t
 *   FEASIBEE_VALUES   0 if no strategy in use sends values (dc does): saves 2 bytes per sender
 *   FEASIBEE_DOUBLE   durations and qualities in double, as in Python bit for bit; by default whole numbers
 *   FEASIBEE_LOG      a function of a double, where there is no math.h; by default log
 *   FEASIBEE_WORDS, FEASIBEE_MESSAGE_WORDS
 *                     most words of knowledge, and of knowledge in a message; by default 0: none
 *   FEASIBEE_CLASSES  most classes of robots, and of tasks; needs FEASIBEE_DOUBLE. By default all are alike
 *   FEASIBEE_INT32    whole numbers of translated strategies have 32 bits with FEASIBEE_DOUBLE, too, instead of 64
 *   FEASIBEE_STOP     what a robot does that would need FEASIBEE_DOUBLE; by default it stops for good
 */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef FEASIBEE_INBOX
#define FEASIBEE_INBOX 64
#endif
#if FEASIBEE_INBOX < 1 || FEASIBEE_INBOX > 65535
#error "FEASIBEE_INBOX must be from 1 to 65535"
#endif
#ifndef FEASIBEE_ID
#define FEASIBEE_ID uint16_t
#endif
#ifndef FEASIBEE_VALUES
#define FEASIBEE_VALUES 1
#endif
#ifndef FEASIBEE_WORDS
#define FEASIBEE_WORDS 0
#endif
#ifndef FEASIBEE_MESSAGE_WORDS
#define FEASIBEE_MESSAGE_WORDS FEASIBEE_WORDS
#endif

#ifdef FEASIBEE_CLASSES
#ifndef FEASIBEE_DOUBLE
#error "FEASIBEE_CLASSES needs FEASIBEE_DOUBLE"
#endif
#define FEASIBEE_CLASSES_OF(number) (number)
#define FEASIBEE_CLASS_OF(number) (number)
#define FEASIBEE_LENGTH_OF(counts) (int)(counts).length
#else
#define FEASIBEE_CLASSES_OF(number) 1
#define FEASIBEE_CLASS_OF(number) 0
#define FEASIBEE_LENGTH_OF(counts) 2
#endif
#ifndef FEASIBEE_MEMORY
#define FEASIBEE_MEMORY 1
#endif
#ifndef FEASIBEE_PARAMETERS
#define FEASIBEE_PARAMETERS 1
#endif
#ifndef FEASIBEE_STOP
#define FEASIBEE_STOP() \
    do {                \
    } while (1)
#endif

enum { FEASIBEE_NONE = -1, FEASIBEE_INFEASIBLE = 0, FEASIBEE_FEASIBLE = 1 };

/* Values of listens_for that are no number of steps. */
enum { FEASIBEE_ALWAYS = -1, FEASIBEE_DISSEMINATION = 0 };

typedef FEASIBEE_ID feasibee_id;

/* Numbers of strategies: real ones, whole ones, and counts that are rated. */
#ifdef FEASIBEE_DOUBLE
typedef double feasibee_real;
typedef double feasibee_amount;
#else
typedef float feasibee_real;
typedef uint32_t feasibee_amount;
#endif
#if defined(FEASIBEE_DOUBLE) && !defined(FEASIBEE_INT32)
typedef int64_t feasibee_int;
typedef uint64_t feasibee_unsigned;
#else
typedef int32_t feasibee_int;
typedef uint32_t feasibee_unsigned;
#endif
#define FEASIBEE_REAL(number) ((feasibee_real)(number))

/* Mean durations in steps: 10 * FEASIBEE_STEP is ten steps, 2.5 * FEASIBEE_STEP two and a half. */
#ifdef FEASIBEE_DOUBLE
typedef double feasibee_steps;
#define FEASIBEE_STEP 1.0
#else
typedef uint32_t feasibee_steps; /* in 1/65536 steps, so below 65536 steps */
#define FEASIBEE_STEP UINT32_C(65536)
#endif

struct feasibee_robot;
struct feasibee_knowledge; /* of strategies that pass on knowledge, as is feasibee_setting: knowledge.h */
struct feasibee_setting;

/* A number from 0 to 1 as two numbers, which are whole without FEASIBEE_DOUBLE. */
struct feasibee_ratio {
    feasibee_amount part;
    feasibee_amount whole; /* at least part, at least 1 */
};

/* A mean duration: steps * share, or steps * (1 - share) if complement. May be 0. */
struct feasibee_mean {
    feasibee_steps steps;
    struct feasibee_ratio share;
    bool complement;
};

/* Two random words, each uniform over 32 bits. */
struct feasibee_choice {
    uint32_t chance;  /* what the strategy leaves to chance */
    uint32_t message; /* which message of the inbox is drawn */
};

/* What a robot broadcasts in addition to its id. */
struct feasibee_message {
    int8_t opinion; /* 1 feasible, 0 infeasible; -1 if the bytes that hold knowledge don't have it */
    bool declared; /* the sender has declared its opinion, if it declares by votes */
    uint16_t value; /* of 16 bits; 0 if the strategy sends none */
#if FEASIBEE_WORDS > 0
    int32_t words[FEASIBEE_MESSAGE_WORDS]; /* knowledge */
#endif
};

/* What a robot heard since its last decision. */
struct feasibee_votes {
    uint16_t feasible;   /* messages that say feasible; its own opinion isn't among them */
    uint16_t infeasible; /* feasible + infeasible is at most 65535 */
    int8_t heard;        /* opinion in one message, drawn at random; -1 without messages */
    uint16_t value;      /* value in that message */
    uint16_t one;        /* value that stands for 1 */
    uint32_t sum;        /* sum of the values of all messages */
    uint32_t chance;     /* a random word */
};

/* How opinions are rated, told and chosen: one constant per strategy, such as feasibee_dmmd. */
struct feasibee_strategy {
    bool forgets;        /* whether each exploration counts afresh */
    bool starts_neutral; /* whether robots start without an opinion */
    uint8_t value_bits;  /* length of the value in a message; 0: messages have none */
    bool modulates;      /* whether dissemination lasts in proportion to the quality of the opinion */
    struct feasibee_ratio (*quality)(feasibee_amount robots, feasibee_amount tasks); /* of feasible */
    int8_t (*say)(struct feasibee_robot *robot);              /* NULL: the opinion */
    uint16_t (*value)(struct feasibee_robot *robot);          /* NULL: the quality of feasible */
    feasibee_steps (*lasting)(struct feasibee_robot *robot);  /* NULL: as modulates says */
    int8_t (*decide)(struct feasibee_robot *robot, const struct feasibee_votes *votes);
    const struct feasibee_knowledge *knowledge; /* NULL: the strategy passes on opinions only */
};

/* When a robot declares its opinion, because others hold it, too (model.md 6.14). */
struct feasibee_declare {
    uint16_t rounds;      /* successive decisions that must agree; 0: never */
    uint16_t heard;       /* least number of messages in such an inbox */
    uint16_t quorum;      /* least share of them that must agree: quorum / quorum_of */
    uint16_t quorum_of;
};

#ifdef FEASIBEE_CLASSES
/* A set of skills: what a robot and a task of each class add to its two sides (model.md 6.7). */
struct feasibee_set {
    uint16_t robots[FEASIBEE_CLASSES];
    uint16_t tasks[FEASIBEE_CLASSES];
};
#endif

/* What a scenario sets in [decision], the same for all robots; start with feasibee_defaults(). */
struct feasibee_settings {
    const struct feasibee_strategy *strategy;
    feasibee_steps exploration;   /* mean duration of exploration */
    feasibee_steps gain;          /* mean duration of dissemination for an opinion of quality 1 */
    uint16_t dissemination_floor; /* steps that each dissemination lasts longer */
    uint16_t quality_floor;       /* both counts are taken for at least this when they are rated */
    int32_t listens_for;          /* it hears in so many last steps of dissemination; or a name above */
    uint16_t inbox_size;          /* senders whose message it keeps, 1 to FEASIBEE_INBOX */
    bool own_vote;                /* whether its own opinion counts in its majority */
    bool random_ties;             /* whether it takes a random message when votes tie */
    bool every_message;           /* every message is a vote; not for strategies that send values */
    bool first_sight;             /* whether its first exploration gives its opinion; not with starts_neutral */
    bool stubborn;                /* it never changes its opinion (a fault) */
    struct feasibee_declare declare;
    uint32_t (*draw_duration)(void *context, const struct feasibee_mean *mean); /* steps, 1 to 2^30 */
    struct feasibee_choice (*draw_choice)(void *context);
    int32_t (*task_of)(uint32_t name);  /* the id of a task by its name in messages; NULL: they are equal */
    const struct feasibee_setting *setting; /* for strategies with parameters or knowledge; otherwise NULL */
#ifdef FEASIBEE_CLASSES
    const struct feasibee_set *sets;
    uint16_t set_count;
#endif
};

/* Which robot it is. */
struct feasibee_me {
    void *context;   /* given to the callbacks */
    feasibee_id id;  /* from here on: for strategies that pass on knowledge */
    uint8_t kind;    /* number of its class */
    uint32_t hash;   /* 32 random bits, the same for all who see a robot of this id */
    uint32_t step;   /* steps that have passed, modulo 2^32; not 0 if it joins robots that began earlier */
#ifdef FEASIBEE_DOUBLE
    double x, y; /* its first position in the frame that all robots share, in units */
#endif
};

/* A robot or a task in sight, for strategies that pass on knowledge. */
struct feasibee_thing {
    bool is_robot;
    int32_t id;    /* -1 for a false sighting; of those without an id below the number of ids, none is kept */
    uint8_t kind;  /* number of its class */
    uint32_t hash; /* 32 random bits, the same for all who see it */
#ifdef FEASIBEE_DOUBLE
    double x, y; /* its position in a frame that all robots share, in units */
#endif
};

/* One robot. Read opinion, disseminating, declared, phase_left; the rest is the controller's. */
struct feasibee_robot {
    const struct feasibee_settings *settings;
    struct feasibee_me me;
    int8_t opinion;      /* 1 feasible, 0 infeasible, -1 none */
    int8_t declared;     /* the opinion that it has declared, and keeps; -1 not yet (model.md 6.15) */
    bool disseminating;  /* otherwise it explores */
    bool explored;       /* it has explored once */
    uint32_t phase_left; /* steps until the phase ends */
    uint32_t robots_seen;
    uint32_t tasks_seen;
#ifdef FEASIBEE_CLASSES
    uint32_t seen[2 * FEASIBEE_CLASSES]; /* robots, and then tasks, of each class */
#endif
    struct feasibee_ratio feasible_quality;
    int8_t said; /* what it broadcasts in this dissemination; -1: it is silent */
    uint16_t value;
    uint16_t agreed; /* successive decisions that agreed */
#ifdef FEASIBEE_DOUBLE
    double memory[FEASIBEE_MEMORY]; /* what the strategy keeps for life, 0 at the start */
#endif
    uint16_t heard_feasible; /* messages, if every message is a vote */
    uint16_t heard_infeasible;
    uint16_t heard; /* senders in the inbox, the oldest message first */
    feasibee_id senders[FEASIBEE_INBOX];
    uint8_t opinions[(FEASIBEE_INBOX + 7) / 8];
#if FEASIBEE_VALUES
    uint16_t values[FEASIBEE_INBOX];
#endif
#if FEASIBEE_WORDS > 0
    uint16_t words; /* of knowledge in use, and in a message */
    uint16_t message_words;
    int32_t known[FEASIBEE_WORDS];
#endif
#ifdef FEASIBEE_DOUBLE
    double x, y; /* its position in the shared frame, in units; write it in each step */
#endif
};

/* Return the settings that a scenario has by default, without callbacks. */
static inline struct feasibee_settings feasibee_defaults(const struct feasibee_strategy *strategy);

/* Begin at step 0, exploring; the first opinion, 1 or 0, is a fair coin. Draws a duration. */
static inline void feasibee_begin(struct feasibee_robot *robot, const struct feasibee_settings *settings,
                                  const struct feasibee_me *me, int8_t opinion);

/* Count robots and tasks in sight while exploring (model.md 4.2). */
static inline void feasibee_observe(struct feasibee_robot *robot, uint16_t robots, uint16_t tasks);

#ifdef FEASIBEE_CLASSES
/* Count a robot or task of a class instead. */
static inline void feasibee_observe_one(struct feasibee_robot *robot, bool is_robot, uint8_t kind);
#endif

/* Add a robot or task in sight to the knowledge while exploring (model.md 6.11). */
static inline void feasibee_recognise(struct feasibee_robot *robot, const struct feasibee_thing *thing);

/* Return whether messages count in this step. */
static inline bool feasibee_listens(const struct feasibee_robot *robot);

/* Keep a message: the latest of each sender, or every one (model.md 4.5). */
static inline void feasibee_hear(struct feasibee_robot *robot, feasibee_id sender,
                                 const struct feasibee_message *message);

/* Write the message of this step; return false while exploring or silent. Call it once per step. */
static inline bool feasibee_message(struct feasibee_robot *robot, struct feasibee_message *message);

/* End a step; if its phase ends, the robot changes phase (model.md 3.3). */
static inline void feasibee_end_step(struct feasibee_robot *robot);
