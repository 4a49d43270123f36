"""Pockets in plain Python, like worldgen/core/making/pockets.c."""


def flood(places, squared, middle, rank, shifts, corners, at_start, parent, bottom, mark, joined):
    """Merges the points in the order of their distance; the same code runs plain and compiled.

    ``mark`` of a root has bit 1 if its set contains the target, bit 2 if the robot can step into it
    from the start. Stops beyond the pass of the start. Returns it, squared, or -1; and the number
    of pairs in ``joined``.
    """
    top, count = -1, 0
    for r in range(len(places)):
        level = squared[r]
        if top >= 0 and level > top:
            break
        parent[r] = r
        root = r
        place = places[r]
        for direction in range(8):
            other = rank[place + shifts[direction]]
            if (
                other < 0
                or other >= r
                or (direction > 3 and middle[place + corners[direction]] == 0)
            ):
                continue
            while parent[other] != other:
                parent[other] = parent[parent[other]]
                other = parent[other]
            if other == root:
                continue
            if (
                mark[other] ^ mark[root]
            ) & 1:  # the set without the target is a pocket, with its bottom
                low = bottom[other] if mark[root] & 1 else bottom[root]
                if squared[low] < level:
                    joined[2 * count] = level
                    joined[2 * count + 1] = squared[low]
                    count += 1
            if other > root:
                other, root = root, other
            parent[root] = other
            mark[other] |= mark[root]
            bottom[other] = min(bottom[other], bottom[root])
            root = other
        if top < 0 and mark[root] == 3:
            top = max(level, at_start)
    return top, count
