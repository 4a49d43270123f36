"""Passages that lead from a place, as counted by worldgen/core/making/openings.c."""

import math

import numpy as np


def ring_of(size):
    """(n, 2) offsets of the nodes from 1.5 to a little over 2 radii of a disc of squared radius
    ``size``.
    """
    outer = math.isqrt(4 * size) + 2
    dx, dy = np.mgrid[-outer : outer + 1, -outer : outer + 1].reshape(2, -1)
    squared = dx * dx + dy * dy
    kept = (4 * squared >= 9 * size) & (squared <= outer * outer)
    return np.stack((dx[kept], dy[kept]), axis=1)


def count_openings(  # noqa: PLR0912 - it is one kernel
    clear,
    middle,
    stride,
    shifts,
    corners,
    places,
    sizes,
    kind,
    begins,
    ring_x,
    ring_y,
    mark,
    queue,
    found,
):
    """Counts the parts of each place's ring; the same code runs plain and compiled.

    First count all parts of the ring, which is cheap and decides most places; if there are three or
    more, count those that a flood from the place reaches. ``mark`` numbers floods: a multiple of 4
    and 1 for the disc, 2 for the ring, 3 for its parts.
    """
    for k in range(len(places)):
        x = places[k] % stride
        y = places[k] // stride
        first = begins[kind[k]]
        last = begins[kind[k] + 1]
        stamp = 4 * (k + 1)
        outer = ring_x[last - 1] * ring_x[last - 1] + ring_y[last - 1] * ring_y[last - 1]
        for only_reached in range(2):
            tail = 0
            if only_reached:
                mark[places[k]] = stamp + 1
                queue[0] = places[k]
                head, tail = 0, 1
                while head < tail:
                    node = queue[head]
                    head += 1
                    for direction in range(8):
                        other = node + shifts[direction]
                        if clear[other] == 0 or mark[other] == stamp + 1:
                            continue
                        if direction > 3 and middle[node + corners[direction]] == 0:
                            continue
                        dx = other % stride - x
                        dy = other // stride - y
                        if dx * dx + dy * dy <= outer:
                            mark[other] = stamp + 1
                            queue[tail] = other
                            tail += 1
            for r in range(first, last):
                i = x + ring_x[r]
                j = y + ring_y[r]
                node = j * stride + i
                if (
                    0 <= i < stride
                    and j >= 0
                    and node < len(mark)
                    and clear[node]
                    and (only_reached == 0 or mark[node] == stamp + 1)
                ):
                    mark[node] = stamp + 2
            parts = 0
            for r in range(first, last):
                i = x + ring_x[r]
                j = y + ring_y[r]
                node = j * stride + i
                if i < 0 or i >= stride or j < 0 or node >= len(mark) or mark[node] != stamp + 2:
                    continue
                mark[node] = stamp + 3
                queue[0] = node
                head, tail, leads_on = 0, 1, 0
                while head < tail:
                    node = queue[head]
                    head += 1
                    dx = node % stride - x
                    dy = node // stride - y
                    if dx * dx + dy * dy >= 4 * sizes[k]:
                        leads_on = 1
                    for direction in range(8):
                        other = node + shifts[direction]
                        if mark[other] != stamp + 2 or (
                            direction > 3 and middle[node + corners[direction]] == 0
                        ):
                            continue
                        mark[other] = stamp + 3
                        queue[tail] = other
                        tail += 1
                parts += leads_on
            found[k] = parts
            if parts < 3:
                break
