/* What strategies share that wait for a quiet time, or for f + 1 neighbours (strategies/certified.py). */

#include "knowledge.h"
#include "numbers.h"

#if FEASIBEE_WORDS > 0

#define FEASIBEE_NEVER (UINT32_C(1) << 30) /* steps that stand for no end */

/* Return f, the number of Byzantine robots that a parameter tolerates. */
static inline uint16_t feasibee_tolerated(const struct feasibee_setting *setting, uint8_t place)
{
    return (uint16_t)feasibee_whole(setting, place, 0, setting->robots);
}

/* Return whether more neighbours have sent a statement than are tolerated: this one and those listed, of
 * which the list holds one more than their ids. */
static inline bool feasibee_told_enough(uint32_t *list, uint16_t tolerates, feasibee_id sender)
{
    for (uint16_t k = 0; k < tolerates; k++) {
        if (list[k] == (uint32_t)sender + 1)
            return false;
        if (list[k] == 0) {
            list[k] = (uint32_t)sender + 1;
            return false;
        }
    }
    return true;
}

/* Return whether a step has come that was less than 2^31 steps ahead when it was stored. */
static inline bool feasibee_has_come(const struct feasibee_robot *robot, uint32_t deadline)
{
    return robot->me.step - deadline < UINT32_C(1) << 31;
}

/* Return a step, counted from 1, as a word that is never 0, which can then stand for no step. */
static inline uint32_t feasibee_stamp_of(uint32_t step)
{
    return step + 1 > 0 ? step + 1 : 1;
}

/* Return a parameter as a number of steps, rounded up. */
static inline uint32_t feasibee_steps_given(feasibee_number number)
{
#ifdef FEASIBEE_DOUBLE
    if (number >= (double)FEASIBEE_NEVER)
        return FEASIBEE_NEVER;
#endif
    uint32_t whole = (uint32_t)(number / FEASIBEE_NUMBER(1));
    return whole + (number > FEASIBEE_NUMBER(1) * (feasibee_number)whole);
}

#ifdef FEASIBEE_DOUBLE

#ifndef FEASIBEE_POW
#include <math.h>
#define FEASIBEE_POW pow
#define FEASIBEE_SQRT sqrt
#endif

#define FEASIBEE_MUCH 1e30 /* stands for infinity; a double may have 32 bits */

/* Return the area of the arena; within walls twice that, since places near them are seen more rarely. */
static inline double feasibee_room(const struct feasibee_setting *setting)
{
    return setting->width * setting->height * (setting->walled ? 2.0 : 1.0);
}

/* Return the area of the strips that so many robots sweep in a step, with this reach to both sides. */
static inline double feasibee_swept(double reach, uint32_t robots, const struct feasibee_setting *setting)
{
    return 2.0 * reach * setting->speed * (double)robots;
}

/* Return the share of its time that a robot explores. */
static inline double feasibee_exploring(const struct feasibee_setting *setting)
{
    return setting->exploration / (setting->exploration + setting->dissemination);
}

/* Return the time in which a robot comes into range of a place, wherever it began, in steps. */
static inline double feasibee_spreading(const struct feasibee_setting *setting)
{
    bool wide = setting->width > setting->height;
    double longer = wide ? setting->width : setting->height, shorter = wide ? setting->height : setting->width;
    double in_range = 2.0 * (setting->sight < setting->radio ? setting->sight : setting->radio);
    double across = (longer > in_range ? longer - in_range : 0.0) / setting->speed;
    double along = (shorter > in_range ? shorter - in_range : 0.0) / setting->speed;
    double straight = (longer - shorter) / setting->speed;
    double turning = 0.24 * (across * across + along * along);
    turning /= setting->mean_run > 0.5 ? setting->mean_run : 0.5;
    if (setting->walled)
        return 4.0 * turning + 0.3 * straight * (longer + shorter) / shorter;
    return turning + straight;
}

/* Return feasibee_steps_for for robots that explore in this share of their time. */
static inline uint32_t feasibee_steps_with(double exploring, double sightings, uint32_t robots,
                                           const struct feasibee_setting *setting)
{
    double seen = setting->sight * exploring, heard = setting->radio * (1.0 - exploring);
    double each_step = feasibee_swept(seen < heard ? seen : heard, robots, setting);
    double area = feasibee_room(setting);
    if (each_step * FEASIBEE_NEVER <= sightings * area)
        return FEASIBEE_NEVER;
    double steps = sightings * area / each_step;
    double rarer = 2.0 * (exploring < 0.5 ? exploring : 1.0 - exploring);
    double apart = 0.8 * steps + sightings * feasibee_spreading(setting) / (rarer * (double)robots);
    if (apart > steps)
        steps = apart;
    if (steps >= FEASIBEE_NEVER)
        return FEASIBEE_NEVER;
    return (uint32_t)steps + (steps > (double)(uint32_t)steps);
}

/* Return the number of steps in which so many robots see a given place so often, on average. */
static inline uint32_t feasibee_steps_for(double sightings, uint32_t robots,
                                          const struct feasibee_setting *setting)
{
    return feasibee_steps_with(feasibee_exploring(setting), sightings, robots, setting);
}

/* Return c, the number of times that the swarm would find a task in the quiet time (quiet_census.patience).
 */
static inline double feasibee_patience(uint32_t robots, uint32_t tolerates)
{
    double flooding = 5.2 + 1.6 * FEASIBEE_LOG((double)(robots > 0 ? robots : 1));
    if (tolerates == 0)
        return flooding;
    if (robots <= 2 * tolerates)
        return FEASIBEE_MUCH;
    return flooding + 0.9 * (double)tolerates * (double)robots / (double)(robots - 2 * tolerates);
}

#endif

#endif
