/* What a robot heard: the latest message of each sender, newest last, or counts of all (model.md 4.5). */

#include "controller.h"

static inline int8_t feasibee_opinion_at(const struct feasibee_robot *robot, uint16_t place)
{
    return (int8_t)(robot->opinions[place >> 3] >> (place & 7) & 1);
}

/* Write a sender and its message at a place. */
static inline void feasibee_put(struct feasibee_robot *robot, uint16_t place, feasibee_id sender,
                                int8_t opinion, uint16_t value)
{
    uint8_t bit = (uint8_t)(1u << (place & 7));
    uint8_t *byte = &robot->opinions[place >> 3];
    robot->senders[place] = sender;
    *byte = opinion == FEASIBEE_FEASIBLE ? (uint8_t)(*byte | bit) : (uint8_t)(*byte & ~bit);
#if FEASIBEE_VALUES
    robot->values[place] = value;
#else
    (void)value;
#endif
}

static inline uint16_t feasibee_value_at(const struct feasibee_robot *robot, uint16_t place)
{
#if FEASIBEE_VALUES
    return robot->values[place];
#else
    (void)robot, (void)place;
    return 0;
#endif
}

/* Remove the message at a place; those after it move up. */
static inline void feasibee_drop(struct feasibee_robot *robot, uint16_t place)
{
#if FEASIBEE_INBOX > 1 /* in an inbox of 1 nothing moves up */
    for (uint16_t next = (uint16_t)(place + 1); next < robot->heard; place = next++)
        feasibee_put(robot, place, robot->senders[next], feasibee_opinion_at(robot, next),
                     feasibee_value_at(robot, next));
#else
    (void)place;
#endif
    robot->heard--;
}

/* Keep a message as the newest; without room, the oldest goes. */
static inline void feasibee_keep(struct feasibee_robot *robot, feasibee_id sender,
                                 const struct feasibee_message *message)
{
    uint16_t place = 0;
    while (place < robot->heard && robot->senders[place] != sender)
        place++;
    if (place < robot->heard)
        feasibee_drop(robot, place);
    else if (robot->heard == robot->settings->inbox_size)
        feasibee_drop(robot, 0);
    feasibee_put(robot, robot->heard++, sender, message->opinion, message->value);
}

/* Count a message if every message is a vote; 65535 at most. */
static inline void feasibee_count(struct feasibee_robot *robot, int8_t opinion)
{
    if ((uint32_t)robot->heard_feasible + robot->heard_infeasible == UINT16_MAX)
        return;
    if (opinion == FEASIBEE_FEASIBLE)
        robot->heard_feasible++;
    else
        robot->heard_infeasible++;
}

#if FEASIBEE_VALUES

/* Return the value in the message of this rank among those with this opinion, by sender. */
static inline uint16_t feasibee_value_of_rank(const struct feasibee_robot *robot, int8_t opinion,
                                              uint16_t rank)
{
    for (uint16_t place = 0; place < robot->heard; place++) {
        uint16_t lower = 0;
        for (uint16_t other = 0; other < robot->heard; other++)
            if (feasibee_opinion_at(robot, other) == opinion)
                lower = (uint16_t)(lower + (robot->senders[other] < robot->senders[place]));
        if (feasibee_opinion_at(robot, place) == opinion && lower == rank)
            return feasibee_value_at(robot, place);
    }
    return 0;
}

#endif

/* Return the counts of the messages heard, one drawn message, and a chance. */
static inline struct feasibee_votes feasibee_votes_of(const struct feasibee_robot *robot,
                                                      struct feasibee_choice choice)
{
#if FEASIBEE_VALUES
    uint16_t one = (uint16_t)((UINT32_C(1) << robot->settings->strategy->value_bits) - 1);
    one = one > 0 ? one : 1;
#else
    uint16_t one = 1;
#endif
    struct feasibee_votes votes = {robot->heard_feasible, robot->heard_infeasible, FEASIBEE_NONE, 0, one,
                                   0, choice.chance};
    for (uint16_t place = 0; place < robot->heard; place++) {
        if (feasibee_opinion_at(robot, place) == FEASIBEE_FEASIBLE)
            votes.feasible++;
        else
            votes.infeasible++;
        votes.sum += feasibee_value_at(robot, place);
    }
    uint16_t all = (uint16_t)(votes.feasible + votes.infeasible);
    if (all == 0)
        return votes;
    /* The draw is among all those that say feasible, in the order of their senders, and then the others. */
    uint16_t drawn = (uint16_t)((uint64_t)choice.message * all >> 32);
    votes.heard = drawn < votes.feasible ? FEASIBEE_FEASIBLE : FEASIBEE_INFEASIBLE;
#if FEASIBEE_VALUES
    uint16_t before = votes.heard == FEASIBEE_FEASIBLE ? 0 : votes.feasible;
    if (robot->settings->strategy->value_bits > 0)
        votes.value = feasibee_value_of_rank(robot, votes.heard, (uint16_t)(drawn - before));
#endif
    return votes;
}
