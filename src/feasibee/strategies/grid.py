"""Names of tasks by their place: the cell of a grid over the arena, whose number has so many bits."""

from feasibee.strategies.roster import CERTAIN, distance


def name_of(thing, name_bits, setting):
    """Return the name of a task: the number of its cell in a grid of the arena, and never 0."""
    columns, rows = columns_of(name_bits), rows_of(name_bits)
    column = min(int(thing.x / setting.width * columns), columns - 1)
    row = min(int(thing.y / setting.height * rows), rows - 1)
    return max(column * rows + row, 1)


def columns_of(name_bits):
    """Return the number of columns of the grid of names."""
    return 1 << ((name_bits + 1) // 2)


def rows_of(name_bits):
    """Return the number of rows of the grid of names."""
    return 1 << (name_bits // 2)


def is_near(name, name_bits, me):
    """Return whether a cell is so near that a task anywhere in it must be seen."""
    setting = me.setting
    columns, rows = columns_of(name_bits), rows_of(name_bits)
    x = (name // rows + 0.5) * setting.width / columns
    y = (name % rows + 0.5) * setting.height / rows
    dx = distance(x, me.x, setting.width, setting.walled) + 0.5 * setting.width / columns
    dy = distance(y, me.y, setting.height, setting.walled) + 0.5 * setting.height / rows
    reach = CERTAIN * setting.sight
    return dx * dx + dy * dy < reach * reach
