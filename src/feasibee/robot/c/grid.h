/* Names of tasks by their place: the cell of a grid over the arena, whose number has so many bits. */

#include "knowledge.h"

#if FEASIBEE_WORDS > 0 && defined(FEASIBEE_DOUBLE)

static inline uint32_t feasibee_grid_columns(uint8_t name_bits)
{
    return UINT32_C(1) << ((name_bits + 1) / 2);
}

static inline uint32_t feasibee_grid_rows(uint8_t name_bits)
{
    return UINT32_C(1) << (name_bits / 2);
}

/* Return the name of a task: the number of its cell in a grid of the arena, and never 0. */
static inline uint32_t feasibee_grid_name(const struct feasibee_thing *thing, uint8_t name_bits,
                                          const struct feasibee_setting *setting)
{
    uint32_t columns = feasibee_grid_columns(name_bits), rows = feasibee_grid_rows(name_bits);
    uint32_t column = (uint32_t)(thing->x / setting->width * (double)columns);
    uint32_t row = (uint32_t)(thing->y / setting->height * (double)rows);
    column = column < columns ? column : columns - 1;
    row = row < rows ? row : rows - 1;
    uint32_t name = column * rows + row;
    return name > 0 ? name : 1;
}

/* Return the distance of two coordinates, the shorter way round on a torus. */
static inline double feasibee_grid_distance(double first, double second, double side, bool walled)
{
    double apart = first > second ? first - second : second - first;
    return walled || apart < side - apart ? apart : side - apart;
}

/* Return whether a cell is so near that a task anywhere in it must be seen. */
static inline bool feasibee_grid_is_near(const struct feasibee_robot *robot, uint32_t name, uint8_t name_bits)
{
    const struct feasibee_setting *setting = robot->settings->setting;
    uint32_t columns = feasibee_grid_columns(name_bits), rows = feasibee_grid_rows(name_bits);
    double x = ((double)(name / rows) + 0.5) * setting->width / (double)columns;
    double y = ((double)(name % rows) + 0.5) * setting->height / (double)rows;
    double dx = feasibee_grid_distance(x, robot->x, setting->width, setting->walled);
    double dy = feasibee_grid_distance(y, robot->y, setting->height, setting->walled);
    dx += 0.5 * setting->width / (double)columns;
    dy += 0.5 * setting->height / (double)rows;
    double reach = 0.95 * setting->sight;
    return dx * dx + dy * dy < reach * reach;
}

#endif
