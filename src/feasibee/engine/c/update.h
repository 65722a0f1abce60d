/* What robots know, for one strategy: its functions are inlined into loops over all robots that wait for them.
 *
 * Included once for each strategy, after these are defined: PART(name), the name of a part of its own;
 * PARAMETERS, their number; REPEATS, if a message is a copy of what is known, and its length depends on nothing
 * else; its functions OBSERVE_BY, MERGE_BY, COUNT_BY and BITS_BY; and those of START_BY, ENCODE_BY, LIE_BY, DECLARE_BY
 * and JUDGE_BY that it has. It defines PART(update). */

#include "given.h"

/* Let robots know what they know when they begin. */
ALWAYS void PART(start_all)(struct state *s, int64_t number)
{
    for (int64_t k = 0; k < number; k++) {
        const int64_t i = s->pending_who[k];
        const struct known known = known_by(s, i);
        memset(known.words, 0, (size_t)known.length * sizeof *known.words);
        s->counts[SENT_BITS][i] = UNSENT;
#ifdef START_BY
        const struct me me = me_of(s, i);
        START_BY(known, &me);
#endif
    }
}

/* Add what was seen to what is known. */
ALWAYS void PART(observe_all)(struct state *s, int64_t number)
{
    for (int64_t k = 0; k < number; k++) {
        const int64_t i = s->pending_who[k], seen = s->pending_number[k];
        const uint32_t mark = (uint32_t)s->pending_mark[k];
        const struct me me = me_of(s, i);
        const struct thing thing =
            RARELY(seen < 0) ? false_thing(s->params, s->pending_column[k], mark) : thing_seen(s, seen, mark);
        learns(s, i);
        OBSERVE_BY(known_by(s, i), &thing, &me);
    }
}

/* Let a Byzantine robot's message support an opinion (model.md 6.12, 6.16). */
ALWAYS void PART(falsify)(struct state *s, struct known message, int64_t feasible, const struct me *me)
{
#ifdef LIE_BY
    (void)s;
    LIE_BY(message, feasible, me);
#else
    const int64_t robots = s->params->robots.count, tasks = s->params->tasks.count;
    const int64_t first = feasible ? robots : tasks, marks = feasible ? robots + tasks : robots + 2 * tasks;
    const int64_t invented = feasible ? s->clock->invented_robots : s->clock->invented_tasks;
    if (feasible && s->params->faults.colluding)
        memset(message.words, 0, (size_t)message.length * sizeof *message.words);
    for (int64_t k = 0; k < invented; k++) {
        const struct thing thing = {feasible == 1, first + k, 0, s->hashes[marks + k], 0.0, 0.0};
        OBSERVE_BY(message, &thing, me);
    }
#endif
}

/* Write the messages; return their length in bits. What a robot repeats has the length that it had. */
ALWAYS int64_t PART(speak_all)(struct state *s, int64_t number)
{
    int64_t total = 0;
    for (int64_t k = 0; k < number; k++) {
        const int64_t i = s->pending_who[k], says = s->pending_number[k];
        const struct known message = told_by(s, i), known = known_by(s, i);
        int64_t length = UNSENT;
#ifdef REPEATS
        length = s->counts[SENT_BITS][i];
        if (UNSENT < length && length < 0 && is_copy(message, known))
            length = s->counts[SENT_BITS][i] = ~length;
#endif
        if (length < 0) {
            const struct me me = me_of(s, i);
#ifdef ENCODE_BY
            ENCODE_BY(message, known, &me);
#else
            for (int64_t word = 0; word < known.length; word++)
                message.words[word] = known.words[word];
#endif
            if (RARELY(says >= 0))
                PART(falsify)(s, message, says, &me);
            length = BITS_BY(message, &me);
#ifdef REPEATS
            if (says < 0)
                s->counts[SENT_BITS][i] = length;
#endif
        }
        if (s->params->radio.delay > 0)
            kept_message(s, s->clock->step, i)[LENGTH] = length;
        else
            total += length;
    }
    return total;
}

/* Add what was heard to what is known. */
ALWAYS void PART(merge_all)(struct state *s, int64_t number)
{
    for (int64_t k = 0; k < number; k++) {
        const int64_t i = s->pending_who[k], sender = s->pending_number[k];
        const struct me me = me_of(s, i);
        learns(s, i);
        MERGE_BY(known_by(s, i), told_by(s, sender), s->robots[IDENTITY][sender], &me);
    }
}

/* Count what is known, by class. */
ALWAYS void PART(count_all)(struct state *s, int64_t number)
{
    for (int64_t k = 0; k < number; k++) {
        const int64_t i = s->pending_who[k], classes = s->tables.classes;
        const struct feasibee_counts counts = {s->seen + i * classes, classes};
        const struct me me = me_of(s, i);
        memset(counts.numbers, 0, (size_t)classes * sizeof *counts.numbers);
        COUNT_BY(known_by(s, i), counts, &me);
    }
}

#ifdef DECLARE_BY
/* Ask all working robots that haven't declared whether they are sure (model.md 6.15). */
ALWAYS void PART(declare_all)(struct state *s)
{
    for (int64_t w = 0; w < s->words; w++)
        for (uint32_t left = s->sets[WORKING][w] & ~s->sets[DECLARED][w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            const struct me me = me_of(s, i);
            learns(s, i);
            const int64_t declared = DECLARE_BY(known_by(s, i), &me);
            if (declared >= 0) {
                adopt(s, i, declared);
                set_declared(s, i, declared);
            }
        }
}
#endif

#ifdef JUDGE_BY
/* Let all working robots adopt the opinions that follow from what they know. */
ALWAYS void PART(judge_all)(struct state *s)
{
    for (int64_t w = 0; w < s->words; w++)
        for (uint32_t left = s->sets[WORKING][w]; left; left = without_lowest(left)) {
            const int64_t i = lowest_member(w, left);
            const struct me me = me_of(s, i);
            learns(s, i);
            const int64_t judged = JUDGE_BY(known_by(s, i), &me);
            if (judged >= 0)
                adopt(s, i, judged);
        }
}
#endif

/* Call a function for the first robots that wait for it; return the bits sent.
 *
 * The parts work with copies of the swarm's description, its numbers and its setting: else the compiler must assume
 * that each word of knowledge that a function writes may change them. */
static int64_t PART(update)(struct state *given, int32_t action, int64_t number)
{
    const struct params params = *given->params;
    struct setting setting = *given->setting;
    struct state own = *given, *s = &own;
    own.params = &params;
    own.setting = &setting;
#ifdef PARAMETERS
    double parameters[PARAMETERS + 1];
    for (int k = 0; k < PARAMETERS; k++)
        parameters[k] = setting.parameters[k];
    setting.parameters = parameters;
    setting.parameter_count = PARAMETERS;
#endif
    switch ((enum action)action) {
    case START: PART(start_all)(s, number); break;
    case SPEAK: return PART(speak_all)(s, number);
    case OBSERVE: PART(observe_all)(s, number); break;
    case MERGE: PART(merge_all)(s, number); break;
    case COUNT: PART(count_all)(s, number); break;
#ifdef DECLARE_BY
    case DECLARE: PART(declare_all)(s); break;
#endif
#ifdef JUDGE_BY
    case JUDGE: PART(judge_all)(s); break;
#endif
    default: break;
    }
    return 0;
}

#undef PART
#undef PARAMETERS
#undef REPEATS
#undef START_BY
#undef OBSERVE_BY
#undef ENCODE_BY
#undef LIE_BY
#undef MERGE_BY
#undef COUNT_BY
#undef BITS_BY
#undef DECLARE_BY
#undef JUDGE_BY
