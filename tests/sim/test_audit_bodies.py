"""Audits of bodies that are not discs, and of plans without times."""

import itertools
import json
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import simulate
from sim.audit import Trajectory, audit
from tests.helpers.audit_room import ROOM, room
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import Event, InvalidParameter, Robot, Timeline, generate, read_world, write_world
from worldgen.lattice import footprint_on_lattice
from worldgen.robot import Drive
from worldgen.robot_overrides import RobotOverrides
from worldgen.timeline import CellState

BAR = ((1.0, 0.25), (-1.0, 0.25), (-1.0, -0.25), (1.0, -0.25))
QUARTER = 0.5 * math.pi
# Share of the move between two poses that the sampled reference jumps.
SAMPLES = 30


def with_body(footprint=BAR, walls=(), **changes):
    """The room of 9 x 7 m with a robot of this body, a bar of 2 x 0.5 m."""
    world = room(walls=walls)
    robot = replace(world.robots[0], footprint=footprint, **changes)
    return replace(world, robots=[robot], certificate=None)


def judged(world, poses, **options):
    return audit(world, Trajectory.plan(*np.array(poses, float).T), **options)


def kinds(result):
    return [finding.kind for finding in result.findings]


def outline(world, x, y, heading):
    """The body at a pose, as shapely's polygon."""
    size = world.cell_size
    corners = footprint_on_lattice(world.robots[0].footprint, size) * (size / 1024)
    cos, sin = math.cos(heading), math.sin(heading)
    return shapely.Polygon(corners @ np.array([[cos, sin], [-sin, cos]]) + (x, y))


def solid(world):
    """Solid cells and the four sides of the outside, as shapely's boxes."""
    size, far = world.cell_size, 100.0
    width, height = world.width * size, world.height * size
    boxes = [
        shapely.box(ix * size, iy * size, (ix + 1) * size, (iy + 1) * size)
        for iy, ix in np.argwhere(world.walls)
    ]
    sides = [
        (-far, -far, 0, far), (width, -far, far, far), (-far, -far, far, 0),
        (-far, height, far, far),
    ]  # fmt: skip
    return np.array([*boxes, *(shapely.box(*side) for side in sides)])


def drive(begin, end, how):
    """Poses between two poses: straight and then a turn, a turn first, or on an arc."""
    (x, y, h), (u, v, _) = begin, end
    turn = math.remainder(end[2] - h, 2 * math.pi)
    shares = np.linspace(0.0, 1.0, SAMPLES)
    if how == "arc":
        half = 0.5 * turn
        for s in shares:
            length = math.sin(s * half) / math.sin(half) if abs(half) > 1e-9 else s
            cos, sin = math.cos((s - 1) * half), math.sin((s - 1) * half)
            dx, dy = (u - x) * length, (v - y) * length
            yield x + dx * cos - dy * sin, y + dx * sin + dy * cos, h + s * turn
        return
    at = {"turn last": (h, u, v), "turn first": (h + turn, x, y)}[how]
    yield from ((x + s * (u - x), y + s * (v - y), at[0]) for s in shares)
    yield from ((at[1], at[2], h + s * turn) for s in shares)


def depth_and_distance(world, poses):
    """The deepest point of a cell in the body, and the body's distance from all, by shapely."""
    boxes, deepest, nearest = solid(world), 0.0, math.inf
    for body in (outline(world, *pose) for pose in poses):
        nearest = min(nearest, shapely.distance(boxes, body).min())
        for part in shapely.intersection(boxes, body):
            if part.area > 0.0:
                low, high = 0.0, 10.0
                for _ in range(18):
                    middle = 0.5 * (low + high)
                    smaller = body.buffer(-middle, join_style="mitre", mitre_limit=1e6)
                    inside = not smaller.is_empty and smaller.distance(part) == 0.0
                    low, high = (middle, high) if inside else (low, middle)
                deepest = max(deepest, low)
    return deepest, nearest


BODIES = st.lists(
    st.tuples(st.integers(-12, 12), st.integers(-12, 12)), min_size=3, max_size=6, unique=True
).map(lambda corners: [(x / 8, y / 8) for x, y in corners]).map(
    lambda corners: shapely.MultiPoint(corners).convex_hull
).filter(lambda hull: hull.geom_type == "Polygon" and hull.area > 0.1).map(
    lambda hull: tuple(hull.exterior.coords)[:-1]
)  # fmt: skip
POSES = st.lists(
    st.tuples(st.integers(-4, 40), st.integers(-4, 32), st.integers(-8, 8)), min_size=2, max_size=3
).map(lambda poses: [(x / 4, y / 4, h * math.pi / 8) for x, y, h in poses])
WALLS = st.lists(st.tuples(st.integers(0, 8), st.integers(0, 6)), max_size=4)


@pytest.mark.nightly
@settings(max_examples=15)
@given(BODIES, POSES, WALLS, st.sampled_from(["line", "arc"]))
def test_depth_and_clearance_of_a_body_are_those_that_shapely_measures(body, poses, walls, how):
    world = with_body(body, walls)
    result = judged(world, poses, interpolate=how)
    found = max((each.depth for each in result.findings if each.kind == "overlap"), default=0.0)
    deep, clear = 0.0, math.inf
    for begin, end in itertools.pairwise(poses):
        ways = ["arc"] if how == "arc" else ["turn last", "turn first"]
        measured = [depth_and_distance(world, list(drive(begin, end, way))) for way in ways]
        first = measured[0]
        best = first if first[0] == 0.0 else min(measured, key=lambda one: one[0])
        deep, clear = max(deep, best[0]), min(clear, best[1])
    # Between two samples of the reference, no point of the body moves farther than this.
    reach = world.robots[0].radius
    motion = max(
        2 * math.dist(a[:2], b[:2]) + math.pi * reach for a, b in itertools.pairwise(poses)
    )
    grain = motion / SAMPLES
    assert deep - 4e-3 <= found <= deep + grain
    assert clear - grain <= result.clearance <= clear + 4e-3


def test_a_body_that_turns_next_to_a_wall_overlaps_it():
    (found,) = judged(with_body(walls=[(4, 4)]), [(3.5, 3.3, 0), (3.5, 3.3, QUARTER)]).findings
    assert (found.kind, found.cell, found.begin, found.end) == ("overlap", (4, 4), 1.0, 1.0)
    # The cell's corner is 0.86 m from the axle, so the bar's end passes over it.
    deepest = depth_and_distance(
        with_body(walls=[(4, 4)]), [(3.5, 3.3, angle) for angle in np.linspace(0, QUARTER, 400)]
    )[0]
    assert found.depth == pytest.approx(deepest, abs=4e-3)


def test_a_body_passes_where_its_outer_disc_does_not():
    aisle = [(x, y) for x in range(9) for y in (2, 4)]
    poses = [(1.5, 3.5, 0.0), (7.5, 3.5, 0.0)]
    assert judged(with_body(walls=aisle), poses).clearance == pytest.approx(0.25)
    assert kinds(judged(with_body(walls=aisle), [(x, y, 0.1) for x, y, _ in poses])) == []
    assert set(kinds(judged(with_body(walls=aisle), [(x, y, 0.4) for x, y, _ in poses]))) == {
        "overlap"
    }
    disc = replace(room(walls=aisle), robot_radius=with_body().robots[0].radius)
    assert "overlap" in kinds(judged(disc, [(x, y) for x, y, _ in poses]))


@pytest.mark.parametrize("leaving", [False, True], ids=["yaw of arriving", "yaw of leaving"])
def test_a_turn_counts_at_the_end_of_the_leg_where_there_is_room(leaving):
    # An L of 2 m whose corner has room to turn, behind an aisle that has none.
    walls = [(x, 2) for x in range(5)] + [(x, 4) for x in range(5)]
    poses = [(1.5, 3.5, 0.0), (6.5, 3.5, QUARTER if leaving else 0.0), (6.5, 5.5, QUARTER)]
    assert judged(with_body(walls=walls), poses).ok


def test_a_car_that_drives_an_arc_is_not_judged_by_its_chord():
    walls = [(x, y) for x in range(2, 9) for y in range(3, 7)]
    poses = [(1.0, 5.0, -QUARTER), (4.5, 1.5, 0.0)]
    car = with_body(((0.4, 0.2), (-0.4, 0.2), (-0.4, -0.2), (0.4, -0.2)), walls, drive=Drive(2.0))
    assert not judged(car, poses, interpolate="line").ok
    assert judged(car, poses).ok
    assert judged(car, poses).path_length == pytest.approx(3.5 * QUARTER)


def test_an_arc_of_a_disc_is_judged_along_the_arc():
    walls = [(x, y) for x in range(2, 9) for y in range(3, 7)]
    poses = [(1.0, 5.0, -QUARTER), (4.5, 1.5, 0.0)]
    world = room(walls=walls, robot_radius=0.29)
    assert set(kinds(judged(world, poses))) == {"tunnel", "overlap"}
    arc = judged(world, poses, interpolate="arc")
    # The arc's centre is at (4.5, 5), and the nearest corner of the walls at (2, 3).
    assert arc.clearance == pytest.approx(3.5 - math.dist((4.5, 5.0), (2.0, 3.0)), abs=1e-6)
    assert arc.ok and arc.reached is None


def test_a_plan_is_taken_at_its_word_and_has_no_speed():
    world = room(walls=[(4, 3)])
    corner = [(3.71, 3.2), (4.2, 2.71)]
    assert kinds(judged(world, corner)) == ["overlap"]
    assert judged(room(), [(0.5, 0.5), (8.5, 6.5)]).duration is None


def test_a_tunnel_of_a_plan_counts_poses():
    poses = [(1.5, 3.5), (2.5, 3.5), (6.5, 3.5)]
    tunnel = judged(room(walls=[(4, 3)]), poses).findings[1]
    assert (tunnel.kind, tunnel.begin, tunnel.end, tunnel.sample) == ("tunnel", 1.375, 1.625, 1)


def test_a_plan_is_judged_in_the_world_as_it_is_at_first():
    world = replace(room(), timeline=Timeline.of([Event(1.0, 4, 3, CellState.SOLID)]))
    result = judged(world, [(1.5, 3.5), (6.5, 3.5)])
    assert result.ok and any("no times" in note for note in result.notes)


def test_a_body_touches_fire_only_while_it_burns():
    events = [Event(2.0, 4, 3, CellState.BURNING), Event(4.0, 4, 3, CellState.FREE)]
    world = replace(with_body(), timeline=Timeline.of(events))
    for begin, expected in ((0.0, []), (2.5, ["burned"]), (4.5, [])):
        times = [begin, begin + 1.0]
        away = Trajectory(times, [4.5, 4.6], [2.9, 2.9], [0.0, 0.0])
        assert kinds(audit(world, away)) == expected


def test_a_body_whose_axle_is_outside_is_judged_by_its_overlaps():
    trailer = ((-0.5, 0.25), (-2.0, 0.25), (-2.0, -0.25), (-0.5, -0.25))
    result = judged(with_body(trailer, [(6, 3)]), [(4.0, 3.5, 0.0), (6.45, 3.5, 0.0)])
    assert result.ok and any("axle" in note for note in result.notes)


def test_a_small_cut_between_two_clear_poses_is_a_note():
    # The bar's corner passes the cell's while it turns by 0.1 rad.
    world = with_body(walls=[(5, 3)])
    angle = math.atan2(0.25, 1.0)
    reach = math.hypot(1.0, 0.25)
    x, y = 5.0 + 0.002 - reach, 3.5
    poses = np.array([(x, y, -angle - 0.1), (x, y, -angle + 0.1)])
    recorded = Trajectory([0.0, 1.0], *poses.T)
    (found,) = audit(world, recorded, straight=True).findings
    assert found.depth == pytest.approx(0.002, abs=2e-3)
    result = audit(world, recorded)
    assert result.ok and result.shaved == 1


def test_headings_are_asked_for_when_they_matter():
    with raises(InvalidParameter, "no-headings"):
        audit(with_body(), Trajectory.plan([1.0, 2.0], [1.0, 1.0]))
    with raises(InvalidParameter, "no-headings"):
        audit(room(), Trajectory.plan([1.0, 2.0], [1.0, 1.0]), interpolate="arc")


@pytest.mark.parametrize(
    ("goal", "reached"),
    [
        ({}, 0.45),
        ({"arrival": "step"}, 3.0),
        ({"heading": 1.0}, 2.9),
        ({"arrival": "step", "heading": 0.0}, None),
        ({"arrival": "stop"}, 3.0),
    ],
    ids=["touch", "step", "touch with heading", "step with heading", "stop"],
)
def test_arrival_is_the_goals(goal, reached):
    # Past the target, back into it, and standing there.
    target = replace(ROOM.target, x=4.5, y=3.5, radius=0.1, **goal)
    world = replace(room(), robots=[Robot(ROOM.start, target, 0.3, 9.0)], certificate=None)
    x = [3.5, 5.5, 5.5, 4.5, 4.5, 4.5]
    headings = [0.0, 0.0, 1.0, 1.0, 1.0, 1.0]
    result = audit(world, Trajectory(range(6), x, [3.5] * 6, headings))
    assert result.reached == (None if reached is None else pytest.approx(reached))


@pytest.mark.parametrize("footprint", ["0.2x0.12", "0.3x0.1@0.08", "0.1,0 -0.08,0.07 -0.08,-0.05"])
@pytest.mark.parametrize("controller", ["bug2", "vfh"])
def test_own_recordings_of_bodies_are_possible(footprint, controller):
    stored = generate("cave", seed=2)
    world = RobotOverrides(footprint=footprint).applied_to(stored)
    trace = simulate(world, controller, steps=800, record=True).trace
    times = np.arange(len(trace.x)) * trace.time_step
    result = audit(world, Trajectory(times, trace.x, trace.y, trace.heading))
    assert result.findings == ()


@pytest.fixture
def files(tmp_path):
    write_world(room(walls=[(5, 3)]), tmp_path / "w.grid")
    (tmp_path / "plan.csv").write_text("x,y,yaw\n2.5,2.5,0\n6.5,2.5,0\n")
    (tmp_path / "log.csv").write_text("t,x,y\n0,2.5,2.5\n2,6.5,2.5\n")
    return tmp_path


def test_the_command_judges_a_plan_of_another_body(files):
    fits = worldgen("audit", files / "w.grid", files / "plan.csv", "--footprint", "2x0.5")
    assert fits.code == 0 and "2 poses, 4 m" in fits.out and "0.25 m at pose" in fits.out
    wide = worldgen("audit", files / "w.grid", files / "plan.csv", "--footprint", "0.5x2", "--json")
    found = json.loads(wide.out)
    assert wide.code == 1 and found["is_plan"] and found["duration"] is None
    assert found["findings"][0]["heading"] == 0.0


def test_the_command_asks_for_headings(files):
    result = worldgen("audit", files / "w.grid", files / "log.csv", "--footprint", "2x0.5")
    assert result.code == 2 and "has no headings" in result.err


def test_the_picture_of_a_plan_is_drawn(files):
    out = files / "a.png"
    options = ("--footprint", "0.5x2", "--picture", out)
    assert worldgen("audit", files / "w.grid", files / "plan.csv", *options).code == 1
    assert out.read_bytes().startswith(b"\x89PNG") and read_world(files / "w.grid") is not None
