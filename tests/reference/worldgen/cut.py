"""The walk over cells and links with bits: the specification of ``cut.c``."""

from typing import Any


def odd_walk(
    rank: Any, place: Any, rows: Any, slot: Any, begins: Any, ends: Any, odd: Any, before: Any, order: Any, skip: Any,
    chain: Any, bits: Any, source: Any, limit: Any, thorough: Any,
) -> Any:  # fmt: skip
    """Breadth-first search from (source, no bit) to (source, all bits), below ``limit`` links.

    ``before[state]`` is the state before it. ``skip[layer * (n + 1) + u]`` leads to the next cell,
    starting with u, that was not seen in that layer. Unless the search is thorough, both end as
    they began.

    Returns:
        Number of cells in ``chain``, from the last back to the source; and the number of visits.
    """
    full = (1 << bits) - 1
    layer_size = len(place) + 1
    goal, head, tail, level_end, depth, looked = (source << bits) + full, 0, 1, 1, 0, 0
    order[0] = source << bits
    before[source << bits] = source << bits
    skip[source] = source + 1
    while head < tail and (thorough or before[goal] < 0):
        if head == level_end:
            depth += 1
            level_end = tail
            if depth + 1 >= limit:
                break
        state = order[head]
        head += 1
        u = state >> bits
        layer = state & full
        if slot[u] >= 0:
            for link in range(begins[slot[u]], begins[slot[u] + 1]):
                other_layer = layer ^ odd[link]
                cell = ends[link]
                other = (cell << bits) + other_layer
                looked += 1
                if before[other] < 0:
                    before[other] = state
                    skip[other_layer * layer_size + cell] = other_layer * layer_size + cell + 1
                    order[tail] = other
                    tail += 1
            continue
        base = layer * layer_size
        for row in range(len(rows) // 2):
            at = place[u] + rows[2 * row]
            wide = rows[2 * row + 1]
            last = base + rank[at + wide + 1]
            v = base + rank[at - wide]
            looked += 1
            while v < last:
                while skip[v] != v:
                    skip[v] = skip[skip[v]]
                    v = skip[v]
                if v >= last:
                    break
                other = ((v - base) << bits) + layer
                before[other] = state
                skip[v] = v + 1
                order[tail] = other
                tail += 1
                looked += 1
    found = before[goal] >= 0 and not thorough
    count = 0
    if found:
        state = goal
        while state != source << bits:
            chain[count] = state >> bits
            count += 1
            state = before[state]
    if not thorough:
        for i in range(tail):
            state = order[i]
            before[state] = -1
            place_in_rows = (state & full) * layer_size + (state >> bits)
            skip[place_in_rows] = place_in_rows
    return count, looked
