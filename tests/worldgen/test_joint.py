"""Joint plans: found if there is one, checked by separate code, never claimed if there is none."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from worldgen._core import ffi, lib
from worldgen.errors import InvalidWorld
from worldgen.reach import (
    BLOCKED,
    REACHABLE,
    UNDECIDED,
    Swap,
    check_certificate,
    check_swap,
    decide,
    decide_in_time,
)
from worldgen.reach.joint.plan import RobotOrder, find_plan
from worldgen.reach.joint.question import crossing_steps, joint_question
from worldgen.reach.still.disc import disc_of
from worldgen.reach.still.lattice_graph import Graph
from worldgen.support.ccall import check
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import Cut, JointWitness, Pose, Robot, Target, World

ALLEY = ["#########", "#.......#", "####.####", "#########"]
TUBE = ["#########", "#.......#", "#########"]
BENT = ["#########", "#.......#", "#######.#", "#######.#", "#########"]


def fleet(rows, *ends, radius=0.04, **changes):
    """A world from rows of cells, top row first, with robots between cells counted from the lower
    left.
    """
    walls = np.array([[sign == "#" for sign in row] for row in rows])[::-1]
    robots = [
        Robot(
            Pose(*((k + 0.5) / 10 for k in begin)),
            Target(*((k + 0.5) / 10 for k in end), 0.05),
            radius,
        )
        for begin, end in ends
    ]
    return replace(World(walls, robots=robots), **changes)


def proved(world, **asked):
    """Return the decision, after checking its proof."""
    decision = decide(world, **asked)
    if decision.certificate is not None:
        radius = asked.get("radius")
        report = check_certificate(world, decision.certificate, radius=radius)
        assert report.valid, report.reason
    return decision


def test_one_robot_waits_in_the_bay_while_the_other_passes():
    decision = proved(fleet(ALLEY, ((1, 2), (7, 2)), ((7, 2), (1, 2))))
    assert decision.result == REACHABLE
    assert isinstance(decision.certificate, JointWitness)


def test_a_swap_in_a_straight_passage_is_impossible_in_the_plane():
    world = fleet(TUBE, ((1, 1), (7, 1)), ((7, 1), (1, 1)))
    decision = decide(world)
    assert decision.result == BLOCKED
    assert decision.swap == Swap(1, 2, "x")
    assert check_swap(world, decision.swap).valid


def test_a_swap_in_an_upright_passage_is_found_too():
    rows = ["".join(row) for row in zip(*TUBE, strict=True)]
    world = fleet(rows, ((1, 1), (1, 7)), ((1, 7), (1, 1)))
    assert decide(world).swap == Swap(1, 2, "y")


def test_a_bent_passage_is_undecided_with_a_statement_about_the_grid():
    decision = decide(fleet(BENT, ((1, 3), (7, 1)), ((7, 1), (1, 3))))
    assert decision.result == UNDECIDED
    assert "a statement about the grid" in decision.reason


@pytest.mark.parametrize(
    ("world", "swap"),
    [
        (fleet(TUBE, ((1, 1), (5, 1)), ((3, 1), (7, 1))), Swap(1, 2, "x")),  # the order stays
        (fleet(TUBE, ((1, 1), (7, 1)), ((7, 1), (1, 1))), Swap(1, 2, "y")),  # long enough
        (
            fleet(TUBE, ((1, 1), (7, 1)), ((7, 1), (1, 1)), radius=0.025),
            Swap(1, 2, "x"),
        ),  # they fit
        (fleet(ALLEY, ((1, 2), (7, 2)), ((7, 2), (1, 2))), Swap(1, 2, "x")),  # there is a bay
        (fleet(["#.#.#"], ((1, 0), (3, 0)), ((3, 0), (1, 0))), Swap(1, 2, "x")),  # two rooms
        (fleet(TUBE, ((1, 1), (7, 1)), ((7, 1), (1, 1))), Swap(2, 1, "x")),
        (fleet(TUBE, ((1, 1), (7, 1)), ((7, 1), (1, 1))), Swap(1, 3, "x")),
        (
            fleet(
                TUBE,
                ((1, 1), (7, 1)),
                ((7, 1), (1, 1)),
                timeline=Timeline.of([Event(1.0, 4, 2, CellState.FREE)]),
            ),
            Swap(1, 2, "x"),
        ),
    ],
    ids=["order", "axis", "thin", "bay", "rooms", "numbers", "unknown", "opens"],
)
def test_a_false_claim_of_a_swap_is_refused(world, swap):
    assert not check_swap(world, swap).valid


def test_a_larger_radius_turns_a_meeting_into_a_swap():
    world = fleet(TUBE, ((1, 1), (7, 1)), ((7, 1), (1, 1)), radius=0.025)
    assert proved(world).result == REACHABLE
    assert decide(world, radius=0.03).swap is not None


def test_a_robot_that_is_walled_off_has_a_cut_with_its_number():
    decision = proved(fleet(["#..#..#"], ((1, 0), (2, 0)), ((4, 0), (2, 0)), radius=0.02))
    assert decision.result == BLOCKED
    assert isinstance(decision.certificate, Cut) and decision.certificate.robot == 2


def test_robots_of_different_sizes_and_speeds_keep_their_own():
    world = fleet(ALLEY, ((1, 2), (7, 2)), ((7, 2), (1, 2)))
    slow = replace(world.robots[1], speed=0.1, radius=0.02)
    decision = proved(replace(world, robot_speed=4.0, robots=(world.robots[0], slow)))
    paths = decision.certificate.paths
    for path, speed in zip(paths, (4.0, 0.1), strict=True):
        steps = np.hypot(np.diff(path.x), np.diff(path.y))
        assert (steps <= speed * np.diff(path.times) * (1 + 1e-9)).all()
    assert paths[1].duration >= 0.55 / 0.1


def test_starts_and_targets_need_not_be_on_nodes():
    world = fleet(ALLEY, ((1, 2), (7, 2)), ((7, 2), (1, 2)))
    odd = Robot(Pose(0.7431, 0.2489), Target(0.1471, 0.2511, 0.001), 0.04)
    decision = proved(replace(world, start=Pose(0.1529, 0.2501), robots=(world.robots[0], odd)))
    assert decision.result == REACHABLE


def test_a_robot_that_starts_in_its_target_stays_there():
    world = fleet(TUBE, ((1, 1), (7, 1)), ((4, 1), (4, 1)))
    assert decide(world).result != REACHABLE
    aside = fleet(ALLEY, ((1, 2), (7, 2)), ((4, 1), (4, 1)))
    decision = proved(aside)
    assert decision.result == REACHABLE
    assert decision.certificate.paths[1].duration == 0.0


def narrow_targets(world, radius=0.04):
    """The same world with targets that only diagonal steps between nodes cross."""
    robots = [replace(robot, target=replace(robot.target, radius=radius)) for robot in world.robots]
    return replace(world, robots=robots)


def test_no_plan_leads_a_robot_across_its_own_target():
    # The quickest detour of robot 1 would cut the corner of its target, where it parks.
    rows = ["..#.#", "...#.", "....."]
    world = narrow_targets(fleet(rows, ((0, 2), (1, 0)), ((4, 0), (1, 1)), radius=0.04))
    assert proved(world).result == REACHABLE


def test_a_world_whose_only_plan_crosses_a_target_is_undecided():
    rows = [".#...", "....."]
    ends = (((0, 0), (2, 0)), ((2, 1), (0, 1)), ((3, 0), (4, 1)))
    world = fleet(rows, *ends, radius=0.03)
    assert proved(narrow_targets(world)).result == UNDECIDED


def test_steps_across_a_target_join_two_nodes_outside_it():
    # Around a node, four diagonals pass nearer than the radius; nodes are 0.05 m apart.
    steps = crossing_steps(disc_of(0.25, 0.15, 0.04, 0.1), 2, 15)
    ends = {(step // 8 % 15, step // 8 // 15) for step in steps.tolist()}
    assert ends == {(4, 3), (6, 3), (5, 2), (5, 4)}
    assert len(steps) == 8
    assert len(crossing_steps(disc_of(0.25, 0.15, 0.035, 0.1), 2, 15)) == 0
    assert len(crossing_steps(disc_of(0.25, 0.15, 0.05, 0.1), 2, 15)) == 0


def test_robots_wait_for_a_door_that_opens_and_are_gone_before_it_closes():
    rows = ["#########", "#...#...#", "#...#...#", "#########"]
    line = Timeline.of([Event(1.0, 4, 1, CellState.FREE), Event(5.0, 4, 1, CellState.SOLID)])
    ends = (((1, 1), (7, 1)), ((2, 2), (6, 2)), ((7, 2), (1, 2)))
    decision = proved(fleet(rows, *ends, timeline=line))
    assert decision.result == REACHABLE
    late = proved(fleet(rows, *ends, timeline=line), margin=1.0)
    assert late.result == REACHABLE


def test_a_parked_robot_must_be_safe_until_the_last_one_arrives():
    rows = ["##########", "#........#", "#........#", "##########"]
    burns = Timeline.of([Event(2.0, 3, 1, CellState.BURNING)])
    ends = (((1, 1), (3, 1)), ((1, 2), (8, 2)))
    world = fleet(rows, *ends, timeline=burns)
    slow = replace(world.robots[1], speed=0.2)
    world = replace(world, robots=(world.robots[0], slow))
    paths = decide(replace(world, timeline=Timeline())).certificate
    assert paths.paths[0].duration < 2.0 < paths.duration
    assert not check_certificate(world, paths).valid


def test_a_deadline_that_the_plan_misses_leaves_the_question_open():
    world = fleet(ALLEY, ((1, 2), (7, 2)), ((7, 2), (1, 2)))
    assert decide_in_time(world, 100.0).result == REACHABLE
    assert decide_in_time(world, 0.1).result == UNDECIDED


def _cells(width, height):
    return st.tuples(st.integers(0, width - 1), st.integers(0, height - 1))


@st.composite
def small_fleets(draw, most=3):
    width, height = draw(st.integers(2, 6)), draw(st.integers(1, 4))
    solid = draw(
        st.lists(st.sampled_from("...#"), min_size=width * height, max_size=width * height)
    )
    rows = ["".join(solid[k * width : (k + 1) * width]) for k in range(height)]
    count = draw(st.integers(2, most))
    begins = draw(st.lists(_cells(width, height), min_size=count, max_size=count, unique=True))
    ends = draw(st.lists(_cells(width, height), min_size=count, max_size=count, unique=True))
    radius = draw(st.sampled_from([0.02, 0.03, 0.05]))
    within = draw(st.sampled_from([0.05, 0.04, 0.02, 0.11]))
    try:
        return narrow_targets(fleet(rows, *zip(begins, ends, strict=True), radius=radius), within)
    except InvalidWorld:
        assume(False)


@settings(max_examples=60, deadline=None)
@given(small_fleets())
def test_what_the_planner_finds_the_checker_accepts(world):
    decision = proved(world)
    if decision.swap is not None:
        assert check_swap(world, decision.swap).valid


def _searched(search, question):
    begun = ffi.new("WgJointSearch **")
    made = ffi.new("WgJointPlan **")
    progress = ffi.new("WgProgress *")
    described = question.described()
    check(search(described, 200_000, begun))
    # A portion of one move divides the work in as many places as there are.
    while progress[0] == lib.WG_GOING:
        check(lib.wg_joint_search_advance(begun[0], 1, made, progress))
    lib.wg_joint_search_free(begun[0])
    lib.wg_joint_free(made[0])
    return int(progress[0])


@pytest.mark.gate
@settings(max_examples=25, deadline=None)
@given(small_fleets(most=2))
def test_the_searches_agree_with_plain_python(world):
    question = joint_question(world, k=2, radius=None, margin=0.0)
    if question is None:
        return
    solvable = _solvable(world, question)
    assert (find_plan(question).nodes is not None) == solvable
    expected = lib.WG_FOUND if solvable else lib.WG_EXHAUSTED
    assert _searched(lib.wg_joint_exhaust, question) == expected
    assert _searched(lib.wg_joint_lacam, question) == expected


@pytest.mark.parametrize("search", [lib.wg_joint_exhaust, lib.wg_joint_lacam])
def test_a_joint_search_returns_after_each_portion_so_that_ctrl_c_is_heard(search):
    world = fleet(["...."] * 4, *(((n % 4, n // 4), (n // 4, n % 4)) for n in range(12)))
    question = joint_question(world, k=2, radius=None, margin=0.0)
    begun = ffi.new("WgJointSearch **")
    made = ffi.new("WgJointPlan **")
    progress = ffi.new("WgProgress *")
    described = question.described()
    check(search(described, 200_000, begun))
    for _ in range(20):
        check(lib.wg_joint_search_advance(begun[0], 1, made, progress))
        assert progress[0] == lib.WG_GOING
    lib.wg_joint_search_free(begun[0])


# Later robots have to wait, to step aside, or to take a longer path than the first one.
CROWDED = [
    fleet(ALLEY, ((1, 2), (7, 2)), ((7, 2), (1, 2))),
    fleet(ALLEY, ((7, 2), (1, 2)), ((4, 2), (4, 1)), radius=0.05),
    fleet(["####", "#..#", "#..#", "####"], ((1, 1), (2, 2)), ((2, 1), (1, 2)), radius=0.05),
    # The first path has more than 130 ticks; the other robot passes it, or follows behind it.
    fleet(["." * 68] * 2, ((0, 0), (67, 0)), ((67, 0), (0, 0)), radius=0.05),
    fleet(["." * 68], ((0, 0), (67, 0)), ((1, 0), (66, 0)), radius=0.05),
    # Six robots change sides in a field of several buckets.
    fleet(
        ["." * 10] * 6,
        *(((0, y), (9, 5 - y)) for y in range(0, 6, 2)),
        *(((9, y), (0, 5 - y)) for y in range(0, 6, 2)),
    ),
    # Robots of two sizes, and a door that opens and closes while they wait.
    replace(
        fleet(["...#...", "...#..."], ((0, 0), (6, 0)), ((0, 1), (6, 1)), radius=0.03),
        robots=(
            Robot(Pose(0.05, 0.05), Target(0.65, 0.05, 0.05), 0.03),
            Robot(Pose(0.05, 0.15), Target(0.65, 0.15, 0.05), 0.05, 1.0),
        ),
        timeline=Timeline.of(
            [
                Event(0.7, 3, 0, CellState.FREE),
                Event(1.0, 3, 0, CellState.SOLID),
                Event(1.9, 3, 0, CellState.FREE),
            ]
        ),
    ),
]


@st.composite
def changing_fleets(draw):
    """Small fleets whose cells become solid or free."""
    world = draw(small_fleets())
    events = draw(
        st.lists(st.tuples(st.integers(1, 12), _cells(6, 4), st.booleans()), min_size=1, max_size=4)
    )
    timeline = Timeline.of(
        [
            Event(0.1 * time, x, y, CellState.SOLID if solid else CellState.FREE)
            for time, (x, y), solid in events
            if x < world.width and y < world.height
        ]
    )
    try:
        return replace(world, timeline=timeline)
    except InvalidWorld:
        assume(False)


SLOW = (3, 5)


@pytest.mark.parametrize(
    "number",
    [
        pytest.param(number, marks=[pytest.mark.gate] if number in SLOW else [])
        for number in range(len(CROWDED))
    ],
)
def test_crowded_robots_are_planned_to_arrive_as_early_as_possible(number):
    _check_arrivals(CROWDED[number])


@pytest.mark.gate
@settings(max_examples=150, deadline=None)
@given(changing_fleets())
def test_robots_are_planned_to_arrive_as_early_as_those_before_them_permit(world):
    _check_arrivals(world)


def _check_arrivals(world):
    """Compare each robot's arrival with a search of every node in every tick, without any C."""
    question = joint_question(world, k=2, radius=None, margin=0.0)
    if question is None:
        return
    assert not question.has_first_leg
    nodes = np.empty((1, 0), np.int64)
    for robot in range(len(world.robots)):
        after = _prioritised(question, robot + 1)
        arrives = (
            None
            if after is None
            else int(np.argmax(question.distances[robot][after[:, robot]] == 0))
        )
        assert arrives == _earliest(world, question, nodes)
        if after is None:
            return
        nodes = after


def _prioritised(question, robots):
    """Plan the first robots in their order; (ticks + 1, robots) nodes, or ``None``."""
    described = question.described()
    described.robots = robots
    order = RobotOrder(described)
    for robot in range(robots):
        if not order.add(robot, question.ends[robot], question.distances[robot], 200_000):
            return None
    return order.plan()


def _earliest(world, question, nodes):
    """The earliest tick at which the next robot can park, around robots with given nodes."""
    robot = nodes.shape[1]
    distances = question.distances[robot]
    rasters = question.rasters
    which = sorted(set(question.radii)).index(question.radii[robot])
    last = max(len(nodes), len(rasters.raster_of)) - 1

    def graph_at(tick):
        raster = rasters.raster_of[min(tick, len(rasters.raster_of) - 1)]
        return Graph(rasters.k, rasters.clear[raster, which], rasters.middle[raster, which])

    def is_safe(tick, node, after):
        now, then = (nodes[min(t, len(nodes) - 1)].tolist() for t in (tick, tick + 1))
        return _all_apart(question, [*now, node], [*then, after], [robot])

    def can_stay(tick, node):
        return all(
            graph_at(t).clear.ravel()[node] and is_safe(t, node, node)
            for t in range(min(tick, last), last + 1)
        )

    here = {question.ends[robot].node}
    if distances[question.ends[robot].node] < 0:
        return None
    for tick in range(last + distances.size):
        if any(distances[node] == 0 and can_stay(tick, node) for node in here):
            return tick
        graph = graph_at(tick)
        here = {
            after
            for node in here
            if distances[node] > 0 and graph.clear.ravel()[node]
            for after in _steps(graph, node, distances, world.robots[robot].target)
            if distances[after] >= 0 and is_safe(tick, node, after)
        }
    return None


def _solvable(world, question):
    """Search all joint states breadth first, with fractions and without any C."""
    classes = sorted(set(question.radii))
    graphs = [question.rasters.ever(classes.index(radius)) for radius in question.radii]
    starts = tuple(end.node for end in question.ends)
    if any(question.distances[robot][node] < 0 for robot, node in enumerate(starts)):
        return False
    seen = {starts}
    queue = [starts]
    for state in queue:
        if all(question.distances[robot][node] == 0 for robot, node in enumerate(state)):
            return True
        moves = [
            _steps(graphs[robot], node, question.distances[robot], world.robots[robot].target)
            for robot, node in enumerate(state)
        ]
        for following in itertools.product(*moves):
            if following not in seen and _all_apart(question, state, following):
                seen.add(following)
                queue.append(following)
    return False


def _steps(graph, node, distances, target):
    if distances[node] == 0:
        return [node]
    found = [node]
    disc = shapely.Point(target.x * 10 * graph.k, target.y * 10 * graph.k)
    radius = target.radius * 10 * graph.k
    y, x = divmod(node, graph.stride)
    for dy, dx in itertools.product((-1, 0, 1), repeat=2):
        if not (dx or dy) or not graph.clear[y + dy, x + dx]:
            continue
        step = shapely.LineString([(x, y), (x + dx, y + dy)])
        crosses = distances[(y + dy) * graph.stride + x + dx] != 0 and step.distance(disc) <= radius
        if crosses:
            continue
        if not (dx and dy) or graph.middle[min(y, y + dy), min(x, x + dx)]:
            found.append((y + dy) * graph.stride + x + dx)
    return found


def _all_apart(question, state, following, robots=None):
    """Return whether robots (all, unless some are given) keep apart from the others in a tick."""
    for one, other in itertools.combinations(range(len(state)), 2):
        if robots is not None and one not in robots and other not in robots:
            continue
        px, py = np.subtract(question.point(state[one]), question.point(state[other])).tolist()
        qx, qy = np.subtract(
            question.point(following[one]), question.point(following[other])
        ).tolist()
        ex, ey = qx - px, qy - py
        length_sq = ex * ex + ey * ey
        along = min(max(-(px * ex + py * ey), 0), length_sq)
        # Squared distance from the origin to the nearest point of the segment, times length_sq.
        x, y = (px * length_sq + along * ex, py * length_sq + along * ey) if length_sq else (px, py)
        scale = length_sq or 1
        if x * x + y * y < question.apart_sq(one, other) * scale * scale:
            return False
    return True
