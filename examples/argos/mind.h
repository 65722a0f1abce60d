/* The decisions of one robot, without ARGoS: feasibee.h and its messages as bytes. */

#ifndef MIND_H
#define MIND_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A message: the length of a frame, the frame, and zeros; all zeros if nothing is said. docs/wire.md has the
 * layout of frames. */
enum { MIND_MESSAGE_BYTES = 15 };

/* The section [decision] of a scenario; feasibee's docs/fields.md says what each field means. */
struct mind_settings {
    const char *strategy;     /* one of opinions, such as "dmmd" */
    double exploration;       /* mean steps */
    double gain;              /* mean steps */
    int id_bits;              /* length of an id in messages, 1 to 16 */
    int dissemination_floor;
    int quality_floor;
    int listens_for;          /* -1 always, 0 while disseminating, or its last so many steps */
    int inbox_size;           /* 1 to 1,024 */
    bool every_message;
    bool own_vote;
    bool random_ties;         /* ties = "random-message" */
    bool first_sight;         /* start = "first-sight" */
    int declare_rounds;       /* 0: it never declares */
    int declare_heard;
    double declare_quorum;    /* in ten thousandths */
    int k;                    /* k-unanimity */
    double credence;          /* bayes */
    bool positive_feedback;   /* bayes */
};

struct mind;

/* Begin exploring. `uniform` draws a number of 0 to 1. Return NULL if there is no such strategy. */
struct mind *mind_new(const struct mind_settings *settings, uint16_t id, double (*uniform)(void *context),
                      void *context);
void mind_free(struct mind *mind);

/* Once per step, in this order. `mind_say` returns the number of bytes written, 0 for none. */
size_t mind_say(struct mind *mind, uint8_t bytes[MIND_MESSAGE_BYTES]);
void mind_see(struct mind *mind, int robots, int tasks);
bool mind_hear(struct mind *mind, const uint8_t *bytes, size_t size); /* false: not a message */
void mind_end_step(struct mind *mind);

int mind_opinion(const struct mind *mind); /* 1 feasible, 0 infeasible, -1 none */
bool mind_declared(const struct mind *mind);

#ifdef __cplusplus
}
#endif

#endif
