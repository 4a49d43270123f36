"""Reachability of robots with footprints: limits in closed form, symmetries, and the checker."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from tests.helpers.bodies import aisle, bend, body_world, longest_in_bend, rectangle
from worldgen.reach import BLOCKED, REACHABLE, UNDECIDED, check_certificate, decide
from worldgen.reach.body.prove import also_for_smaller
from worldgen.reach.verifying import verify_world
from worldgen.robot import Drive, Pose, Robot, Target
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import Cut, Witness, World

# Between the discs, so that neither decides.
LONG = rectangle(1.198, 0.778)


def decided(world):
    """The result of a decision whose proof, if it has one, the checker accepts."""
    decision = decide(world)
    if decision.certificate is not None:
        report = check_certificate(world, decision.certificate)
        assert report.valid, report.reason
    return decision


@pytest.mark.parametrize("width", [0.2, 0.5, 0.778])
@pytest.mark.parametrize(("share", "result"), [(0.995, REACHABLE), (1.005, BLOCKED)])
def test_the_longest_rectangle_in_a_bend_is_that_of_the_closed_form(width, share, result):
    length = round(share * longest_in_bend(width), 4)
    assert decided(bend(rectangle(length, width))).result == result


@pytest.mark.parametrize(
    ("width", "result"),
    [(0.9, REACHABLE), (0.999, REACHABLE), (1.0, REACHABLE), (1.001, BLOCKED), (1.1, BLOCKED)],
)
@pytest.mark.parametrize("ahead", [0.0, 0.55], ids=["axle-in-the-middle", "axle-at-the-rear"])
def test_a_straight_aisle_lets_through_what_is_no_wider(width, result, ahead):
    decision = decided(aisle(rectangle(1.198, width, ahead)))
    assert decision.result == result


def test_the_rectangle_of_the_warehouse_gets_around_its_bend():
    world = bend(LONG)
    witness = decided(world).certificate
    assert isinstance(witness, Witness)
    assert witness.headings is not None
    assert witness.clearance > 0.002
    assert decide(world, radius=world.robot_radius).result == BLOCKED
    assert verify_world(world)["certificate_valid"]


def test_the_clearance_of_a_path_is_what_the_footprint_can_be_padded_by():
    # The body passes the aisle along its middle: 0.111 m are left on both sides.
    world = aisle(LONG)
    witness = decided(world).certificate
    assert witness.clearance == pytest.approx(0.111, abs=0.0005)
    claimed = replace(witness, clearance=0.112)
    assert not check_certificate(world, claimed).valid


def test_a_blocked_body_has_a_cut_of_poses():
    world = bend(rectangle(1.3, 0.778))
    decision = decided(world)
    assert isinstance(decision.certificate, Cut)
    assert decision.certificate.boxes is not None
    assert verify_world(world)["certificate"] == "cut"


def test_a_blocked_body_says_how_much_smaller_it_would_have_to_be():
    # The aisle is 1 m wide.
    world = aisle(rectangle(1.198, 1.1, 0.3))
    answer = verify_world(world)
    assert answer["certificate_valid"]
    assert 0.04 < answer["clearance"] < 0.05
    assert "also stop a footprint" in answer["reason"]
    # In a bend it is known as closely.
    answer = verify_world(bend(rectangle(1.3, 0.778)))
    less = answer["clearance"]
    assert less > 0.0
    fits = rectangle(1.3 - 2 * (less + 0.01), 0.778 - 2 * (less + 0.01))
    assert decide(bend(fits)).result == REACHABLE
    stopped = rectangle(1.3 - 2 * less, 0.778 - 2 * less)
    assert decide(bend(stopped)).result == BLOCKED


def test_a_cut_that_claims_to_stop_much_smaller_bodies_is_refused():
    world = aisle(rectangle(1.198, 1.1, 0.3))
    decision = also_for_smaller(world, decide(world))
    cut = decision.certificate
    assert check_certificate(world, cut).valid
    for claim, reason in ((0.051, "no single rectangle"), (0.6, "no such sides"), (-1.0, "claims")):
        report = check_certificate(world, replace(cut, clearance=claim))
        assert not report.valid and reason in report.reason


def test_no_proof_is_made_that_is_not_wanted():
    assert decide(bend(LONG), certificate=False).certificate is None
    blocked = decide(bend(rectangle(1.3, 0.778)), cut=False)
    assert (blocked.result, blocked.certificate) == (BLOCKED, None)


def test_equal_worlds_have_equal_proofs():
    for world in (bend(LONG), bend(rectangle(1.3, 0.778))):
        assert decide(world) == decide(world)


def turned(world):
    """The world after a quarter turn."""
    robot = world.robots[0]
    far = world.height * world.cell_size
    start = Pose(round(far - robot.start.y, 6), robot.start.x, robot.start.heading + math.pi / 2)
    target = replace(robot.target, x=round(far - robot.target.y, 6), y=robot.target.x)
    walls = np.rot90(world.walls, -1)
    return World(walls[:, ::-1][:, ::-1], robots=[replace(robot, start=start, target=target)])


def mirrored(world):
    """The world and its body, mirrored left to right in the body's frame."""
    robot = world.robots[0]
    far = world.height * world.cell_size
    start = replace(robot.start, y=round(far - robot.start.y, 6), heading=-robot.start.heading)
    target = replace(robot.target, y=round(far - robot.target.y, 6))
    footprint = tuple((x, -y) for x, y in robot.footprint)
    return World(
        world.walls[::-1], robots=[replace(robot, start=start, target=target, footprint=footprint)]
    )


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_mirrored_and_turned_worlds_have_equal_results(share):
    length = round(share * longest_in_bend(0.5), 4)
    # A body without any symmetry, inside the rectangle.
    a, b = length / 2, 0.25
    world = bend(((-a, -b), (a, -b), (a, b), (-a + 0.1, b), (-a, b - 0.1)))
    result = decided(world).result
    assert decided(mirrored(world)).result == result
    assert decided(turned(world)).result == result


def test_a_target_with_a_heading_needs_room_to_turn():
    # A body that is longer than its dead end is wide cannot turn around there.
    footprint = rectangle(1.2, 0.5)
    dead_end = [(0.2, 0.2, 5.0, 1.2)]
    at = (4.0, 0.7, 0.1)
    there = body_world(dead_end, (1.0, 0.7, 0.0), at, footprint, heading=0.0)
    back = body_world(dead_end, (1.0, 0.7, 0.0), at, footprint, heading=math.pi)
    assert decided(there).result == REACHABLE
    assert decided(back).result == BLOCKED
    # With a room next to its start it can.
    room = [*dead_end, (0.2, 0.2, 2.2, 2.4)]
    roomy = body_world(room, (1.0, 0.7, 0.0), at, footprint, heading=math.pi)
    witness = decided(roomy).certificate
    off = math.remainder(float(witness.headings[-1]) - math.pi, 2 * math.pi)
    assert abs(off) <= roomy.target.heading_tolerance


def test_a_path_begins_at_the_start_and_a_covered_start_is_a_cut():
    world = aisle(LONG)
    robot = world.robots[0]
    off = replace(robot, start=Pose(1.40003, 2.00004, 0.01))
    witness = decided(World(world.walls, robots=[off])).certificate
    assert math.dist((witness.x[0], witness.y[0]), (1.40003, 2.00004)) < 1e-4
    covered = replace(robot, start=Pose(0.5, 2.0, 0.0))
    decision = decided(World(world.walls, robots=[covered]))
    assert decision.result == BLOCKED
    assert len(decision.certificate.boxes) == 1


def scattered(seed):
    """A world of scattered cells, and a random body in it."""
    rng = np.random.default_rng(seed)
    walls = rng.random((14, 16)) < 0.08
    count = int(rng.integers(3, 7))
    angles = np.sort(rng.uniform(0, 2 * math.pi, count))
    angles[:3] = np.linspace(0, 4, 3)
    radii = rng.uniform(0.15, 0.3, count)
    ring = shapely.convex_hull(
        shapely.multipoints(np.stack([radii * np.cos(angles), radii * np.sin(angles)], 1))
    )
    footprint = tuple(map(tuple, np.round(shapely.get_coordinates(ring)[:-1], 3).tolist()))
    walls[1:6, 1:6] = False
    target = Target(1.3, 1.1, 0.1, heading=0.5 if seed % 3 == 0 else None)
    return World(walls, robots=[Robot(Pose(0.4, 0.4, 0.2), target, footprint=footprint)])


@pytest.mark.parametrize("seed", range(12))
def test_the_checker_accepts_every_proof_about_scattered_cells(seed):
    assert decided(scattered(seed)).result in (REACHABLE, BLOCKED)


@pytest.mark.nightly
@pytest.mark.parametrize("begin", range(100, 900, 100))
def test_the_checker_accepts_every_proof_about_many_scattered_cells(begin):
    undecided = [
        seed for seed in range(begin, begin + 100) if decided(scattered(seed)).result == UNDECIDED
    ]
    assert len(undecided) <= 2


def hulls(body, angles, x, y):
    """Hulls of a body at several angles and places, for each of many places."""
    turns = [np.array([[math.cos(a), math.sin(a)], [-math.sin(a), math.cos(a)]]) for a in angles]
    ring = np.concatenate([body @ turn for turn in turns])
    points = [ring[None] + np.stack([px, py], 1)[:, None] for px, py in zip(x, y, strict=True)]
    return shapely.convex_hull(shapely.multipoints(np.concatenate(points, axis=1)))


def lattice_reaches(world, per_cell=2, turns=16):
    """Search poses on a coarse lattice with shapely; True is a proof, False is none."""
    robot = world.robots[0]
    size = world.cell_size
    iy, ix = np.nonzero(~world.walls)
    free = shapely.union_all(shapely.box(ix, iy, ix + 1, iy + 1))
    shapely.prepare(free)
    body = np.array(robot.footprint) / size
    shape = (world.height * per_cell, world.width * per_cell)
    # Nodes are at the start's place within a cell.
    y, x = (values.ravel() / per_cell for values in np.indices(shape))
    unit = 2 * math.pi / turns
    count = turns * len(x)
    nodes = np.arange(count).reshape(turns, *shape)
    links = []
    for k in range(turns):
        angle = robot.start.heading + k * unit
        # Five angles, grown by what a corner can be outside of their hull, cover the turn.
        covers = hulls(body, [angle + part / 4 * unit for part in range(5)], [x], [y])
        turn = shapely.contains(free, shapely.buffer(covers, 0.02 * robot.radius / size))
        links.append((nodes[k].ravel()[turn], nodes[(k + 1) % turns].ravel()[turn]))
        for axis, (dx, dy) in enumerate(((0.0, 1 / per_cell), (1 / per_cell, 0.0))):
            moves = hulls(body, [angle], [x, x + dx], [y, y + dy])
            move = shapely.contains(free, moves).reshape(shape)
            ahead = np.roll(nodes[k], -1, axis=axis)
            links.append((nodes[k][move], ahead[move]))
    a, b = (np.concatenate(ends) for ends in zip(*links, strict=True))
    graph = coo_matrix((np.ones(len(a), np.int8), (a, b)), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    start = nodes[0, round(robot.start.y / size * per_cell), round(robot.start.x / size * per_cell)]
    goal = robot.target
    near = np.hypot(x * size - goal.x, y * size - goal.y) < goal.radius
    return bool((label.reshape(turns, -1)[:, near] == label[start]).any())


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.gate) for seed in (13, 17, 19, 26))]
)
def test_nothing_is_blocked_that_a_search_with_shapely_reaches(seed):
    world = scattered(seed)
    assert lattice_reaches(world)
    assert decide(world).result == REACHABLE


@pytest.fixture(scope="module")
def blocked():
    """A world in which a body is just too long, and its cut."""
    world = bend(rectangle(1.3, 0.778))
    return world, decide(world).certificate


def test_a_cut_without_one_of_its_boxes_is_refused(blocked):
    world, cut = blocked
    refused = 0
    # Those that only guard a corner are not all needed.
    for part in range(0, len(cut.boxes), 10):
        report = check_certificate(world, replace(cut, boxes=np.delete(cut.boxes, part, axis=0)))
        refused += not report.valid and "way from the start" in report.reason
    assert refused > len(cut.boxes) // 20


def test_a_cut_with_a_box_of_poses_that_are_clear_is_refused(blocked):
    world, cut = blocked
    x, y = (round(value / 0.1 * 1024) for value in (world.start.x, world.start.y))
    for row in ([0, 100, 100, y, x, x + 50], [0, 0, 0, y, x - 5, x + 5]):
        report = check_certificate(world, replace(cut, boxes=np.vstack([cut.boxes, [row]])))
        assert not report.valid
        assert "no single rectangle" in report.reason


@pytest.mark.parametrize("shift", [(-700, 0), (700, 0), (0, -700), (0, 700)])
def test_a_cut_that_is_moved_is_refused(blocked, shift):
    world, cut = blocked
    boxes = cut.boxes + np.array([0, 0, 0, shift[1], shift[0], shift[0]])
    assert not check_certificate(world, replace(cut, boxes=boxes)).valid


@pytest.mark.parametrize("row", [[-1, 5, 1, 1, 1, 2], [65530, 7, 1, 1, 1, 2], [0, 1, 1, 1, 3, 2]])
def test_a_cut_with_a_box_that_is_not_one_is_refused(blocked, row):
    world, cut = blocked
    report = check_certificate(world, replace(cut, boxes=np.array([row])))
    assert not report.valid
    assert "is not one" in report.reason


@pytest.fixture(scope="module")
def reached():
    """A world in which a body just fits, and its witness."""
    world = bend(rectangle(1.26, 0.778))
    return world, decide(world).certificate


def test_a_path_with_a_pose_that_is_moved_is_refused(reached):
    world, witness = reached
    for point in range(1, len(witness.x) - 1):
        x = witness.x.copy()
        x[point] -= 0.05
        assert not check_certificate(world, replace(witness, x=x, clearance=0.0)).valid


def test_a_path_with_a_wrong_heading_is_refused(reached):
    world, witness = reached
    for point in range(len(witness.headings)):
        headings = witness.headings.copy()
        headings[point] += 0.15
        report = check_certificate(world, replace(witness, headings=headings, clearance=0.0))
        assert not report.valid


def test_a_path_without_headings_proves_nothing_about_a_footprint(reached):
    world, witness = reached
    report = check_certificate(world, replace(witness, headings=None))
    assert not report.valid
    assert "headings" in report.reason


GATE = [(40, k) for k in range(15, 25)]
SOLID, BURNING, FREE = CellState.SOLID, CellState.BURNING, CellState.FREE
# When a gate across the aisle changes, and how long a body of 1.198 m x 0.778 m then takes, s.
GATES = {
    "burns later": ([(9.0, BURNING)], 2.6),
    "opens again": ([(1.0, SOLID), (5.0, FREE)], 6.6),
    "burns for a while": ([(0.5, BURNING), (3.0, FREE)], 4.6),
    "opens twice": ([(0.0, SOLID), (2.0, FREE), (2.1, SOLID), (7.0, FREE)], 8.6),
}


@pytest.mark.parametrize("name", GATES)
def test_a_body_waits_for_a_gate_and_passes_it_in_time(name):
    changes, takes = GATES[name]
    events = [Event(time, ix, iy, state) for time, state in changes for ix, iy in GATE]
    world = replace(aisle(LONG), timeline=Timeline.of(events))
    decision = decided(world)
    assert decision.result == REACHABLE
    witness = decision.certificate
    assert witness.duration == pytest.approx(takes, abs=0.1)
    # A body that does not wait, or that starts late, is met by the gate.
    ways = np.hypot(np.diff(witness.x), np.diff(witness.y))
    times = np.concatenate([[0.0], np.cumsum(ways / 2.0 + 1e-9)])
    times[1:] += 7.5 if name == "burns later" else 0.0
    report = check_certificate(world, replace(witness, times=times))
    assert not report.valid and "overlaps a wall" in report.reason


def changing(world, cells, time, state):
    """The world with an event for some cells."""
    events = [Event(time, ix, iy, state) for ix, iy in cells]
    return replace(world, timeline=Timeline.of(events))


def test_a_body_is_decided_in_a_world_that_changes_far_from_its_path():
    world = aisle(LONG)
    corner = changing(world, [(3, 3)], 1.0, CellState.SOLID)
    assert decided(corner).result == REACHABLE
    # What closes the aisle too soon leaves its question open; what never opens is a cut.
    closed = changing(world, GATE, 1.0, CellState.SOLID)
    assert decided(closed).result == UNDECIDED
    opens = changing(aisle(rectangle(1.3, 1.05, 0.5)), [(3, 3)], 1.0, CellState.SOLID)
    assert decided(opens).result == BLOCKED


def test_fleets_of_bodies_and_paths_of_cars_are_left_open():
    world = aisle(LONG)
    robot = world.robots[0]
    other = Robot(Pose(1.4, 3.4), Target(6.6, 3.4, 0.1), radius=0.1)
    fleet = decide(World(world.walls, robots=[robot, other]))
    assert fleet.result == UNDECIDED
    assert "footprint" in fleet.reason
    car = replace(robot, drive=Drive(turning_radius=0.5))
    assert (
        decide(
            World(
                bend(rectangle(1.3, 0.778)).walls,
                robots=[replace(bend(rectangle(1.3, 0.778)).robots[0], drive=car.drive)],
            )
        ).result
        == BLOCKED
    )


def test_a_footprint_with_its_axle_outside_may_have_it_over_a_wall():
    # The axle is 0.3 m behind the body, in the wall, and even outside the grid.
    footprint = ((0.3, -0.2), (0.7, -0.2), (0.7, 0.2), (0.3, 0.2))
    free = [(0.1, 0.1, 0.9, 3.0), (0.1, 2.0, 3.0, 3.0)]
    world = body_world(free, (0.5, 0.2, math.pi / 2), (1.5, 2.5, 0.1), footprint)
    assert decided(world).result == REACHABLE


def test_every_pair_of_a_paths_poses_is_a_move_or_a_turn(reached):
    _, witness = reached
    poses = list(zip(witness.x, witness.y, witness.headings, strict=True))
    for (ax, ay, a), (bx, by, b) in itertools.pairwise(poses):
        assert (ax, ay) == (bx, by) or a == b
    assert witness.times[-1] == pytest.approx(witness.length / 2.0, rel=1e-4)


@pytest.mark.parametrize("side", [0.3, 0.6, 0.7])
def test_a_chain_with_a_gap_that_a_body_just_fits_stops_nothing(side):
    cells = round(side / 0.1)
    walls = np.zeros((cells + 6, 40), bool)
    walls[:3, 15:25] = walls[3 + cells :, 15:25] = True
    middle = len(walls) * 0.05
    robot = Robot(Pose(0.8, middle), Target(3.2, middle, 0.05), footprint=rectangle(side, side))
    world = World(walls, robots=[robot])
    assert decided(world).result == REACHABLE
    top = len(walls)
    chain = [(20, y) for y in [*range(-1, 3), *range(3 + cells, top + 1)]]
    chain += [(x, top) for x in range(19, -2, -1)]
    chain += [(-1, y) for y in range(top - 1, -1, -1)]
    chain += [(x, -1) for x in range(-1, 20)]
    forged = Cut(np.array(chain), side / 2 * (1 - 5e-13))
    assert not check_certificate(world, forged).valid


def test_a_body_thinner_than_the_tolerance_does_not_pass_a_wall():
    n = 1000
    corners = ((-500, -500), (500, 499), (501, 500))
    needle = tuple((round(x * 0.1 / 1024, 12), round(y * 0.1 / 1024, 12)) for x, y in corners)
    walls = np.zeros((100, 100), bool)
    walls[:, 50] = True
    world = World(walls, robots=[Robot(Pose(4.0, 5.0), Target(6.0, 7.0, 0.05), footprint=needle)])
    assert decided(world).result == BLOCKED
    up = 2.0 * (n - 0.5) / (n + 0.5)
    forged = Witness(
        np.array([0.0, 1.0, 2.0, 10.0]),
        np.array([4.0, 4.01, 4.0, 6.0]),
        np.array([5.0, 5.0, 5.0, 5.0 + up]),
        0.0,
        np.zeros(4),
    )
    assert not check_certificate(world, forged).valid


@pytest.mark.parametrize("heading", [1e12, 1e16, 1e300])
def test_a_huge_target_heading_means_the_same_to_the_checker(heading):
    world = bend(LONG)
    robot = world.robots[0]
    small = math.remainder(heading, math.tau)
    worlds = [
        replace(world, robots=[replace(robot, target=replace(robot.target, heading=each))])
        for each in (heading, small)
    ]
    assert decided(worlds[0]).result == decided(worlds[1]).result


@pytest.mark.parametrize(
    "row",
    [(0, 65536, 1, 0, -(2**63), 0), (0, 65536, 2_000_000_000, 0, 0, 2_000_000_000)],
    ids=["least-integer", "huge"],
)
def test_a_box_far_beyond_the_grid_is_refused_at_once(row):
    cut = Cut(np.zeros((0, 2), np.int64), 0.0, boxes=np.array([row]))
    assert not check_certificate(bend(LONG), cut).valid
