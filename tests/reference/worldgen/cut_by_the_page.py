"""A checker of cuts, written from docs/reference/grid-format.md alone.

It reads the file itself and imports nothing of ours, so that the page is enough for a stranger.
"""

import itertools
import math
import tomllib
from decimal import Decimal
from fractions import Fraction

# Cells: points that are nearer than this to being clear, or to the target's disc, count as both.
DOUBT = 1e-9
HALF = Fraction(1, 2)


class Scene:
    """One robot's world, in cells, and the cut in its file."""

    def __init__(self, text):
        head, sections = split(text)
        header = tomllib.loads(head, parse_float=Decimal)
        side = Fraction(header["cell_size"])
        certificate = header["certificate"]
        assert certificate["kind"] == "cut"
        robot = header
        radius = "robot_radius"
        if "robot" in header:
            robot = header["robot"][certificate["robot"] - 1]
            radius = "radius"
        rows = sections["cells"][::-1]
        self.width = len(rows[0])
        self.height = len(rows)
        self.radius = Fraction(robot[radius]) / side
        self.clearance = Fraction(certificate["clearance"]) / side
        self.start, _ = placed(robot.get("start"), rows, "S", side)
        self.target, self.reach = placed(robot.get("target"), rows, "G", side)
        self.chain = [tuple(map(int, line.split())) for line in sections.get("cut", ())]
        self.at_start, self.always = blocked_cells(rows, sections.get("timeline", ()))

    def is_outside(self, cell):
        return not (0 <= cell[0] < self.width and 0 <= cell[1] < self.height)


def split(text):
    """Return the header and the lines of each section."""
    first, *lines = text.splitlines()
    assert first.startswith("%worldgen-grid")
    begins = [n for n, line in enumerate(lines) if line.startswith("%")]
    ends = [*begins[1:], len(lines)]
    sections = {
        lines[begin][1:]: lines[begin + 1 : end] for begin, end in zip(begins, ends, strict=True)
    }
    return "\n".join(lines[: begins[0]]), sections


def placed(value, rows, mark, side):
    """Return a place and its radius, from the header or a marked cell."""
    if value is not None:
        x, y, last = (Fraction(number) / side for number in value)
        return (x, y), last
    ((ix, iy),) = [
        (ix, iy) for iy, row in enumerate(rows) for ix, word in enumerate(row) if word == mark
    ]
    return (ix + HALF, iy + HALF), HALF


def blocked_cells(rows, timeline):
    """Return the cells that are blocked at time 0, and those blocked at all times from then on."""
    every = {(ix, iy) for iy, row in enumerate(rows) for ix in range(len(row))}
    now = {(ix, iy) for ix, iy in every if rows[iy][ix] == "#"}
    times = {Fraction(0): []}
    for line in timeline:
        time, ix, iy, state = line.split()
        times.setdefault(Fraction(Decimal(time)), []).append(((int(ix), int(iy)), state))
    # Of the changes of a cell at one time the last one counts, so look only between the times.
    at_start = None
    always = every
    for time in sorted(times):
        for cell, state in times[time]:
            now = now - {cell} if state == "free" else now | {cell}
        at_start = now if at_start is None else at_start
        always = always & now
    return at_start, always


def proves(text):
    """Return True if the cut in a file proves that its robot cannot reach its target."""
    scene = Scene(text)
    chain = scene.chain
    ring = all(-1 <= ix <= scene.width and -1 <= iy <= scene.height for ix, iy in chain)
    if not chain or not ring:
        return False
    links = [*zip(chain, [*chain[1:], chain[0]], strict=True)]
    widest = max(gap_squared(a, b) for a, b in links)
    claim = scene.clearance
    if widest >= (2 * scene.radius) ** 2 or claim >= scene.radius:
        return False
    if float(claim) * (1 + DOUBT) < math.sqrt(widest) / 2:
        return False
    return is_start_covered(scene) or is_grid_too_small(scene) or separates(scene, links)


def gap_squared(a, b):
    return sum(max(abs(one - other) - 1, 0) ** 2 for one, other in zip(a, b, strict=True))


def is_start_covered(scene):
    return any(
        (scene.is_outside(cell) or cell in scene.at_start)
        and distance_squared(scene.start, cell) < scene.radius**2
        for cell in scene.chain
    )


def distance_squared(point, cell):
    """Return the squared distance of a point from a cell."""
    return sum(
        max(low - value, 0, value - low - 1) ** 2 for low, value in zip(cell, point, strict=True)
    )


def is_grid_too_small(scene):
    return 2 * scene.radius > min(scene.width, scene.height)


def separates(scene, links):
    if not all(scene.is_outside(cell) or cell in scene.always for cell in scene.chain):
        return False
    line = [point for a, b in links for point in four_points(a, b)]
    home = crosses(line, scene.start)
    return all(crosses(line, point) != home for point in clear_points(scene))


def four_points(a, b):
    signs = [(other > one) - (other < one) for one, other in zip(a, b, strict=True)]
    first = [value + HALF for value in a]
    second = [value + HALF for value in b]
    return [
        tuple(first),
        tuple(value + HALF * sign for value, sign in zip(first, signs, strict=True)),
        tuple(value - HALF * sign for value, sign in zip(second, signs, strict=True)),
        tuple(second),
    ]


def crosses(line, point):
    """Return True if a ray to the right crosses a closed line an odd number of times."""
    x, y = point
    odd = False
    for (x1, y1), (x2, y2) in itertools.pairwise([*line, line[0]]):
        if (y1 > y) != (y2 > y) and x1 + (y - y1) * (x2 - x1) / (y2 - y1) > x:
            odd = not odd
    return odd


def clear_points(scene):
    """Return the points of the target's disc to examine, as far as they are clear."""
    x, y = map(float, scene.target)
    r = float(scene.radius)
    near = float(scene.reach) + DOUBT
    far = near + r + 1.0
    cells = [
        (ix, iy)
        for iy in range(max(math.floor(y - far), -1), min(math.ceil(y + far), scene.height) + 1)
        for ix in range(max(math.floor(x - far), -1), min(math.ceil(x + far), scene.width) + 1)
        if scene.is_outside((ix, iy)) or (ix, iy) in scene.always
    ]
    columns = sorted({side for ix, _ in cells for side in (ix - r, ix + 1 + r)})
    rows = sorted({side for _, iy in cells for side in (iy - r, iy + 1 + r)})
    corners = sorted({(ix + i, iy + j) for ix, iy in cells for i in (0, 1) for j in (0, 1)})
    points = [(x, y), *((x, row) for row in rows), *((column, y) for column in columns)]
    points += itertools.product(columns, rows)
    for cx, cy in corners:
        away = math.hypot(x - cx, y - cy)
        if away > 0:
            points.append((cx + r * (x - cx) / away, cy + r * (y - cy) / away))
        points += [(cx + half, row) for row in rows for half in chord(r, row - cy)]
        points += [(column, cy + half) for column in columns for half in chord(r, column - cx)]
    for one, other in itertools.combinations(corners, 2):
        points += where_circles_meet(one, other, r)
    return [
        point
        for point in points
        if math.dist(point, (x, y)) <= near
        and 0 <= point[0] <= scene.width
        and 0 <= point[1] <= scene.height
        and all(math.sqrt(distance_squared(point, cell)) >= r - DOUBT for cell in cells)
    ]


def chord(radius, height):
    square = radius**2 - height**2
    if square < -DOUBT:
        return ()
    return (math.sqrt(max(square, 0.0)), -math.sqrt(max(square, 0.0)))


def where_circles_meet(one, other, radius):
    dx, dy = other[0] - one[0], other[1] - one[1]
    apart = math.hypot(dx, dy)
    square = radius**2 - apart**2 / 4
    if square < -DOUBT:
        return ()
    half = math.sqrt(max(square, 0.0)) / apart
    middle = ((one[0] + other[0]) / 2, (one[1] + other[1]) / 2)
    return (
        (middle[0] - dy * half, middle[1] + dx * half),
        (middle[0] + dy * half, middle[1] - dx * half),
    )
