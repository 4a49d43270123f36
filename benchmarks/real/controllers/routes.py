"""Plan a path for a disc on a grid with A*; the planner that several controllers share."""

import heapq
import math

import numpy as np

# Steps to the eight neighbours on the lattice of half cells, with their lengths.
STEPS = [
    (dx, dy, math.hypot(dx, dy)) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if (dx, dy) != (0, 0)
]


def clear_points(walls, reach):
    """Return where a disc fits, on a lattice of quarter cells: (4 ny + 1, 4 nx + 1).

    Args:
        walls: (ny, nx) true where a cell is solid; everything outside is solid too.
        reach: Radius of the disc, cells.
    """
    solid = np.pad(np.asarray(walls, bool), 1, constant_values=True)
    ny, nx = solid.shape
    far = math.ceil(4 * reach)
    blocked = np.zeros((4 * ny + 2 * far + 1, 4 * nx + 2 * far + 1), bool)
    for dy in range(-far, far + 5):
        for dx in range(-far, far + 5):
            off = math.hypot(max(0, -dx, dx - 4), max(0, -dy, dy - 4))
            if off < 4 * reach - 1e-9:
                blocked[far + dy : far + dy + 4 * ny : 4, far + dx : far + dx + 4 * nx : 4] |= solid
    return ~blocked[far + 4 : far + 4 * ny - 3, far + 4 : far + 4 * nx - 3]


def plan(walls, cell, radius, start, target, roomy=1.4):
    """Return the cheapest path as places (n, 2), m, half a cell apart, or None.

    A place closer to a wall than ``roomy`` radii costs three times as much.

    Args:
        walls: (ny, nx) true where a cell is solid.
        cell: Side of a cell, m.
        radius: Radius of the robot, m.
        start: (x, y), m.
        target: (x, y), m; the last place of the path.
        roomy: Distance from walls that the path prefers, radii.
    """
    fits = clear_points(walls, radius / cell)
    price = np.where(clear_points(walls, roomy * radius / cell), 1.0, 3.0)[::2, ::2].tolist()
    free = fits[::2, ::2].tolist()
    between = fits[1::2, 1::2].tolist()
    half = cell / 2
    begin = _nearest(fits, start, half)
    end = _nearest(fits, target, half)
    if begin is None or end is None:
        return None
    cost = {begin: 0.0}
    before = {}
    queue = [(math.dist(begin, end), begin)]
    done = set()
    while queue:
        _, here = heapq.heappop(queue)
        if here == end:
            break
        if here in done:
            continue
        done.add(here)
        x, y = here
        for dx, dy, length in STEPS:
            to = (x + dx, y + dy)
            if not (0 <= to[1] < len(free) and 0 <= to[0] < len(free[0]) and free[to[1]][to[0]]):
                continue
            if dx and dy and not between[y + (dy - 1) // 2][x + (dx - 1) // 2]:
                continue
            total = cost[here] + length * price[to[1]][to[0]]
            if total < cost.get(to, math.inf):
                cost[to] = total
                before[to] = here
                heapq.heappush(queue, (total + math.dist(to, end), to))
    if end not in cost:
        return None
    nodes = [end]
    while nodes[-1] != begin:
        nodes.append(before[nodes[-1]])
    return np.array([(x * half, y * half) for x, y in reversed(nodes)] + [tuple(target)])


def _nearest(fits, place, half):
    """Return the node closest to a place where the disc fits."""
    ys, xs = np.nonzero(fits[::2, ::2])
    if not len(xs):
        return None
    k = int(np.argmin(np.hypot(xs * half - place[0], ys * half - place[1])))
    return int(xs[k]), int(ys[k])


def plan_in(world, roomy=1.4):
    """Return a path from a world's start to its target, or else the straight line."""
    start = (world.start.x, world.start.y)
    target = (world.target.x, world.target.y)
    path = plan(world.walls, world.cell_size, world.robot_radius, start, target, roomy)
    return np.array([start, target]) if path is None else path


def progress(path, k, x, y, window=8):
    """Return the index of the place closest to the robot, no earlier than ``k``."""
    near = path[k : k + window]
    return k + int(np.argmin(np.hypot(near[:, 0] - x, near[:, 1] - y)))


def wrapped(angle):
    """Return an equal angle between -pi and pi."""
    return math.remainder(angle, math.tau)
