"""Searches over open ground in plain Python.

Does the same as worldgen/core/making/ground.c, in the same order.
"""


def breadth_first(windows, came, queue, start, goal, stride):
    """Fills ``came`` with the cell from which each was first reached, until the goal is reached.

    Args:
        windows: (n,) 1 where a step may lead; none on the rim, so that no step leaves the grid.
        came: (n,) -1, to be filled.
        queue: (n,) room for cells.
        start: Cell to begin at.
        goal: Cell to end at.
        stride: Cells a row.
    """
    came[start] = start
    queue[0] = start
    first, count = 0, 1
    while first < count and came[goal] < 0:
        at = queue[first]
        first += 1
        for way in range(4):
            if way == 0:
                there = at + 1
            elif way == 1:
                there = at + stride
            elif way == 2:
                there = at - 1
            else:
                there = at - stride
            if windows[there] != 0 and came[there] < 0:
                came[there] = at
                queue[count] = there
                count += 1


def flood(windows, steps, queue, start, stride):
    """Counts the steps from a place to all that can be reached, breadth first.

    Args:
        windows: (n,) 1 where a step may lead; none on the rim, so that no step leaves the grid.
        steps: (n,) -1, to be filled.
        queue: (n,) room for places; in the end the reached ones, nearest first.
        start: Place to begin at.
        stride: Cells a row.

    Returns:
        Places reached.
    """
    steps[start] = 0
    queue[0] = start
    first, count = 0, 1
    while first < count:
        at = queue[first]
        first += 1
        for way in range(4):
            if way == 0:
                there = at + 1
            elif way == 1:
                there = at + stride
            elif way == 2:
                there = at - 1
            else:
                there = at - stride
            if windows[there] != 0 and steps[there] < 0:
                steps[there] = steps[at] + 1
                queue[count] = there
                count += 1
    return count


def label(windows, owner, queue, stride):
    """Numbers the components in order of their first places.

    Args:
        windows: (n,) 1 where a step may lead; none on the rim.
        owner: (n,) -1, to be filled with the number of each place's component.
        queue: (n,) room for places.
        stride: Cells a row.

    Returns:
        Components.
    """
    found = 0
    for begin in range(len(windows)):
        if windows[begin] == 0 or owner[begin] >= 0:
            continue
        owner[begin] = found
        queue[0] = begin
        first, count = 0, 1
        while first < count:
            at = queue[first]
            first += 1
            for way in range(4):
                if way == 0:
                    there = at + 1
                elif way == 1:
                    there = at + stride
                elif way == 2:
                    there = at - 1
                else:
                    there = at - stride
                if windows[there] != 0 and owner[there] < 0:
                    owner[there] = found
                    queue[count] = there
                    count += 1
        found += 1
    return found


def spread(waits, owner, came, depth, queue, count, stride):
    """Lets owners grow over the grid at the same pace; each place takes its hardness in rounds.

    Args:
        waits: (n,) rounds left until a place is crossed, 0 where nothing may grow; changed.
        owner: (n,) the owner of each place, -1 for none; to be filled.
        came: (n,) the place from which each was reached; itself at the beginnings.
        depth: (n,) rounds in which each was reached; 0 at the beginnings.
        queue: (n,) the beginnings, then room for places.
        count: Beginnings.
        stride: Cells a row.
    """
    room = len(queue)
    first = 0
    while first < count:
        at = queue[first % room]
        first += 1
        if waits[at] > 1:
            waits[at] -= 1
            queue[count % room] = at
            count += 1
            continue
        for way in range(4):
            if way == 0:
                there = at + 1
            elif way == 1:
                there = at + stride
            elif way == 2:
                there = at - 1
            else:
                there = at - stride
            if waits[there] != 0 and owner[there] < 0:
                owner[there] = owner[at]
                came[there] = at
                depth[there] = depth[at] + waits[there]
                queue[count % room] = there
                count += 1
