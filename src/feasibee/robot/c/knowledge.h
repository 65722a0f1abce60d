/* Strategies that pass on knowledge (model.md 6.11). They need FEASIBEE_WORDS. */

#include "controller.h"
#include "bits.h"

/* Parameters of a strategy: FEASIBEE_NUMBER(0.5) is a half. */
#ifdef FEASIBEE_DOUBLE
typedef double feasibee_number;
#define FEASIBEE_NUMBER(number) ((double)(number))
#else
typedef int32_t feasibee_number; /* in 1/65536, so from -32768 to 32767 */
#define FEASIBEE_NUMBER(number) ((int32_t)((number) * 65536))
#endif

/* The numbers of a scenario on which knowledge may depend, as Setting in strategies/contract.py. */
struct feasibee_setting {
    uint16_t robots;    /* number of robots that have ids, which are below it */
    uint16_t count;     /* number of robots at the start: what a robot knows with knows_count */
    uint16_t tasks;     /* number of tasks that have ids, which are below it */
    uint16_t robot_ids; /* number of ids of robots; more than robots if Byzantine ones invent some */
    uint16_t task_ids;  /* number of ids of tasks */
    uint8_t id_bits;    /* length of a robot's id in a message */
    bool knows_count;   /* whether robots know how many there are */
    feasibee_number parameters[6]; /* those of the strategy, in the order of its file */
#ifdef FEASIBEE_DOUBLE
    /* For what strategies compute in floating point, such as a quiet time that isn't given. */
    bool walled;
    double width, height, sight, radio, speed; /* in units, and units per step */
    double exploration, dissemination, mean_run; /* mean durations, in steps; mean_run: between two turns */
#endif
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
    /* For how long to broadcast on average; NULL: as the strategy says for the opinion. */
    feasibee_steps (*lasting)(struct feasibee_robot *robot);
    /* How many words it needs: at most FEASIBEE_WORDS, and FEASIBEE_MESSAGE_WORDS for a message. */
    uint32_t (*words)(const struct feasibee_setting *setting);
    uint32_t (*message_words)(const struct feasibee_setting *setting);
    /* A message as bits (model.md 6.13). unpack is given words that are 0; it returns the sender's id, or -1
     * if messages don't have it. */
    void (*pack)(struct feasibee_writer *writer, const uint32_t *words, feasibee_id sender,
                 const struct feasibee_setting *setting);
    int32_t (*unpack)(uint32_t *words, struct feasibee_reader *reader,
                      const struct feasibee_setting *setting);
    uint8_t parameters; /* number of its parameters */
};

/* Return a parameter, cut off to a whole number, and kept between two others. */
static inline int32_t feasibee_whole(const struct feasibee_setting *setting, uint8_t place, int32_t least,
                                     int32_t most)
{
    feasibee_number number = setting->parameters[place] / FEASIBEE_NUMBER(1);
    if (number < (feasibee_number)least)
        return least;
    return number > (feasibee_number)most ? most : (int32_t)number;
}

/* Return whether a thing has an id below the number of ids: a false sighting has none, nor a misread tag. */
static inline bool feasibee_has_id(const struct feasibee_thing *thing, const struct feasibee_setting *setting)
{
    return (uint32_t)thing->id < (thing->is_robot ? setting->robot_ids : setting->task_ids);
}

/* Return how many bits a number has without the zeros before it. */
static inline uint8_t feasibee_bit_length(uint32_t number)
{
    uint8_t bits = 0;
    for (; number > 0; number >>= 1)
        bits++;
    return bits;
}

#define FEASIBEE_FULL UINT32_C(0x7FFFFFFF) /* largest total in a word, as in Python */

/* Return how many bits of so many words are 1. */
static inline uint32_t feasibee_members(const uint32_t *words, uint32_t number)
{
    uint32_t found = 0;
    for (uint32_t k = 0; k < number; k++)
        for (uint32_t word = words[k]; word != 0; word &= word - 1)
            found++;
    return found;
}

/* Write two counts, halved together until their sum has 32 bits: only their ratio matters. */
static inline void feasibee_write_counts(uint64_t robots_found, uint64_t tasks_found, uint32_t *robots,
                                         uint32_t *tasks)
{
    for (; robots_found + tasks_found > UINT32_MAX; robots_found >>= 1)
        tasks_found >>= 1;
    *robots = (uint32_t)robots_found;
    *tasks = (uint32_t)tasks_found;
}

/* Messages of one word. */
static inline uint32_t feasibee_one_word(const struct feasibee_setting *setting)
{
    (void)setting;
    return 1;
}

/* Write a message that is an id and so many bits of one word. */
static inline void feasibee_pack_word(struct feasibee_writer *writer, const uint32_t *words, feasibee_id sender,
                                      const struct feasibee_setting *setting, uint8_t bits)
{
    feasibee_write(writer, sender, setting->id_bits);
    feasibee_write(writer, words[0], bits);
}

/* Read such a message; return who sent it. */
static inline int32_t feasibee_unpack_word(uint32_t *words, struct feasibee_reader *reader,
                                           const struct feasibee_setting *setting, uint8_t bits)
{
    int32_t sender = (int32_t)feasibee_read_below(reader, setting->robots, setting->id_bits);
    words[0] = feasibee_read(reader, bits);
    return sender;
}

/* Write a set of names, so many in a word, in rising order. */
static inline void feasibee_pack_names(struct feasibee_writer *writer, const uint32_t *set, uint8_t in_word,
                                       uint32_t ids, uint8_t bits)
{
    for (uint32_t id = 0; id < ids; id++)
        if (set[id / in_word] >> (id % in_word) & 1) {
            feasibee_write_flag(writer, true);
            feasibee_write(writer, id, bits);
        }
    feasibee_write_flag(writer, false);
}

/* Read a set of names, so many in a word, in rising order. */
static inline void feasibee_unpack_names(struct feasibee_reader *reader, uint32_t *set, uint8_t in_word,
                                         uint32_t ids, uint8_t bits)
{
    uint32_t least = 0;
    while (feasibee_read_flag(reader)) {
        uint32_t id = feasibee_read_below(reader, ids, bits);
        feasibee_check(reader, id >= least);
        if (reader->failed)
            return;
        set[id / in_word] |= UINT32_C(1) << (id % in_word);
        least = id + 1;
    }
}
