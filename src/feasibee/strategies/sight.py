"""What the walls of a place hide from a robot that knows the plan (model.md 6.20.11)."""

WALL, TASKS = 1, 16
"""Bits of a cell of the plan: whether it is a wall, and whether tasks may be in it."""


def cell_at(distance, side, number):
    """Return the row or column at a distance from the edge, of so many with this side."""
    return max(min(int(distance / side), number - 1), 0)


def sees(left, low, right, high, me):
    """Return whether walls hide no cell of a rectangle in which tasks may be, from whatever distance."""
    columns = me.setting.columns
    if columns == 0:
        return True
    side, rows = me.setting.width / columns, len(me.setting.plan) // columns
    column, row = cell_at(me.x, side, columns), cell_at(me.y, side, rows)
    first, last = cell_at(left, side, columns), cell_at(right, side, columns)
    for y in range(cell_at(low, side, rows), cell_at(high, side, rows) + 1):
        for x in range(first, last + 1):
            if me.setting.plan[y * columns + x] & TASKS != 0 and hidden(column, row, x, y, me.setting):
                return False
    return True


def holds_tasks(left, low, right, high, setting):
    """Return whether tasks may be in a cell of a rectangle, by the plan."""
    columns = setting.columns
    side, rows = setting.width / columns, len(setting.plan) // columns
    first, last = cell_at(left, side, columns), cell_at(right, side, columns)
    for y in range(cell_at(low, side, rows), cell_at(high, side, rows) + 1):
        for x in range(first, last + 1):
            if setting.plan[y * columns + x] & TASKS != 0:
                return True
    return False


def hidden(column, row, to_column, to_row, setting):
    """Return whether the line between the centres of two cells touches a wall; at a corner it touches four.

    ``ahead`` says which border of a cell the line meets first: at 0 both.
    """
    across, along = abs(to_column - column), abs(to_row - row)
    step, jump = 1 if to_column > column else -1, setting.columns if to_row > row else -setting.columns
    cell, ahead, left = row * setting.columns + column, along - across, across + along
    while left > 0:
        if ahead < 0:
            cell, ahead, left = cell + step, ahead + 2 * along, left - 1
        elif ahead > 0:
            cell, ahead, left = cell + jump, ahead - 2 * across, left - 1
        else:
            if (setting.plan[cell + step] | setting.plan[cell + jump]) & WALL != 0:
                return True
            cell, ahead, left = cell + step + jump, ahead + 2 * (along - across), left - 2
        if setting.plan[cell] & WALL != 0:
            return True
    return False
