"""A body against solid cells, in plain Python: what worldgen/core/body/hull.c says, exactly.

Coordinates are integers in 2^-30 of 1/1024 cell, so nothing is rounded.
"""

from worldgen.reach.body.core_calls import cosines

_TURN = 65536
_SIDE = 1024 << 30


def corners_at(body, x, y, heading):
    """The corners of a body, (k, 2) lu, at a pose."""
    table = cosines()
    c = int(table[heading % _TURN])
    s = int(table[(heading - _TURN // 4) % _TURN])
    return [((x << 30) + cx * c - cy * s, (y << 30) + cx * s + cy * c) for cx, cy in body]


def hull_of(points):
    """The convex hull, counter-clockwise, by wrapping it around the points."""
    points = sorted(set(points))
    hull = [points[0]]
    while True:
        (ax, ay), best = hull[-1], None
        for x, y in points:
            if (x, y) == hull[-1]:
                continue
            if best is None:
                best = (x, y)
                continue
            turn = (best[0] - ax) * (y - ay) - (best[1] - ay) * (x - ax)
            far = (x - ax) ** 2 + (y - ay) ** 2 > (best[0] - ax) ** 2 + (best[1] - ay) ** 2
            if turn < 0 or (turn == 0 and far):
                best = (x, y)
        if best is None or best == hull[0]:
            return hull
        hull.append(best)


def overlaps(hull, ix, iy):
    """True if the interiors of a polygon and of a cell have a point in common: no axis parts them."""
    cell = [(i * _SIDE, j * _SIDE) for i in (ix, ix + 1) for j in (iy, iy + 1)]
    axes = [(1, 0), (0, 1)]
    axes += [
        (by - ay, ax - bx) for (ax, ay), (bx, by) in zip(hull, hull[1:] + hull[:1], strict=True)
    ]
    for nx, ny in axes:
        ours = [nx * x + ny * y for x, y in hull]
        theirs = [nx * x + ny * y for x, y in cell]
        if max(ours) <= min(theirs) or max(theirs) <= min(ours):
            return False
    return True


def is_clear(walls, hull):
    """True if a polygon overlaps no solid cell; the outside is solid."""
    height, width = walls.shape
    columns = range(min(x for x, _ in hull) // _SIDE, -(-max(x for x, _ in hull) // _SIDE))
    rows = range(min(y for _, y in hull) // _SIDE, -(-max(y for _, y in hull) // _SIDE))
    return not any(
        (not (0 <= ix < width and 0 <= iy < height) or walls[iy, ix]) and overlaps(hull, ix, iy)
        for iy in rows
        for ix in columns
    )


def may_move(walls, body, pose, x, y):
    """True if a body is clear on a line, by the hull of both ends."""
    x0, y0, heading = pose
    ends = corners_at(body, x0, y0, heading) + corners_at(body, x, y, heading)
    return is_clear(walls, hull_of(ends))


def may_turn(walls, body, pose, turn):
    """True if a body is clear at each heading of a turn."""
    x, y, heading = pose
    step = 1 if turn >= 0 else -1
    return all(
        is_clear(walls, hull_of(corners_at(body, x, y, heading + part)))
        for part in range(0, turn + step, step)
    )
