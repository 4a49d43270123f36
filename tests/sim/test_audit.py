"""Audits: whether a recorded trajectory was possible in a world and, if not, where, when and by how
much.
"""

import itertools
import math
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzz.failure import Failure
from sim import simulate
from sim.audit import Trajectory, audit
from tests.helpers.audit_referee import second_opinion
from tests.helpers.audit_room import ROOM, path, room
from tests.helpers.drawn_worlds import changing_worlds, still_worlds
from worldgen import Pose, generate, read_world
from worldgen.timeline import CellState

FREE, SOLID, BURNING = CellState


def small_room(size, walls=()):
    """The same room with a different cell size, m."""
    start, target = Pose(size, size), replace(ROOM.target, x=size, y=size)
    return room(walls=walls, start=start, target=target, cell_size=size, robot_radius=0.3 * size)


def kinds(world, *samples, **options):
    options = {"straight": True, "slack": 100.0, **options}
    return [finding.kind for finding in audit(world, path(*samples), **options).findings]


def only(world, *samples, **options):
    (finding,) = audit(
        world, path(*samples), **{"straight": True, "slack": 100.0, **options}
    ).findings
    return finding


def recorded(episode, *, corners=False):
    """Return an episode as a recording of the ends of its steps.

    It includes the corners within steps, with times in proportion to length.
    """
    trace, step = episode.trace, episode.trace.time_step
    times = np.arange(len(trace.x)) * step
    if not corners:
        return Trajectory(times, trace.x, trace.y)
    driven = np.cumsum(
        np.hypot(
            np.diff(trace.path_x, prepend=trace.x[0]), np.diff(trace.path_y, prepend=trace.y[0])
        )
    )
    last = np.searchsorted(trace.path_step, np.arange(len(trace.x)), side="right") - 1
    before = np.concatenate([[0.0], driven[last]])[trace.path_step]
    length = driven[last][trace.path_step] - before
    share = np.where(length > 0.0, (driven - before) / np.where(length > 0.0, length, 1.0), 1.0)
    fine = np.where(trace.path_step > 0, (trace.path_step - 1 + share) * step, 0.0)
    fine[last] = times
    return Trajectory(fine, trace.path_x, trace.path_y)


@st.composite
def recordings(draw, worlds):
    """A world and a trajectory: arbitrary ones in and around the grid, or short walks in it.

    Some samples share a time.
    """
    world = draw(worlds)
    side, grain = world.cell_size, draw(st.sampled_from([1, 2, 50]))
    count, stride = draw(st.integers(2, 5)), draw(st.sampled_from([None, 1, 25]))

    def places(cells):
        if stride is None:
            reach = st.integers(-grain, (cells + 1) * grain)
            return [round(draw(reach) * side / grain, 9) for _ in range(count)]
        first, steps = draw(st.integers(0, 50 * cells)), st.integers(-stride, stride)
        walk = np.cumsum([first, *(draw(steps) for _ in range(count - 1))])
        return np.round(np.clip(walk, 0, 50 * cells) * side / 50, 9)

    waits = draw(st.lists(st.integers(0, 3), min_size=count, max_size=count))
    return world, Trajectory(np.cumsum(waits) / 4.0, places(world.width), places(world.height))


@given(recordings(still_worlds() | changing_worlds()))
def test_clearance_and_depths_are_those_that_shapely_measures(recording):
    world, trajectory = recording
    result, opinion = audit(world, trajectory, straight=True), second_opinion(world, trajectory)
    assert result.clearance == pytest.approx(opinion.clearance, abs=1e-9)
    for kind, depth in opinion.depth.items():
        found = max(
            (finding.depth for finding in result.findings if finding.kind == kind), default=0.0
        )
        assert found == pytest.approx(depth if depth > 2e-6 else found, abs=1e-9)
        assert found == 0.0 or depth > 0.9e-6


@pytest.mark.gate
@given(recordings(still_worlds() | changing_worlds()))
def test_every_move_that_shapely_sees_inside_a_wall_is_in_a_finding(recording):
    world, trajectory = recording
    result, opinion = audit(world, trajectory, straight=True), second_opinion(world, trajectory)
    for kind, moves in (("tunnel", opinion.inside), ("outside", opinion.beyond)):
        spans = [
            (finding.begin, finding.end) for finding in result.findings if finding.kind == kind
        ]
        for begin, end in ((trajectory.times[move], trajectory.times[move + 1]) for move in moves):
            assert any(low <= end + 1e-9 and high >= begin - 1e-9 for low, high in spans)
        assert moves or all(finding.depth <= 2e-7 or on_a_face(world, finding) for finding in result.findings
                            if finding.kind == kind)  # fmt: skip


def on_a_face(world, finding):
    """Return whether the centre is between two cells, which shapely counts as inside neither."""
    return any(
        abs(place / world.cell_size - round(place / world.cell_size)) < 1e-6
        for place in (finding.x, finding.y)
    )


@given(recordings(still_worlds() | changing_worlds()))
def test_a_finding_names_a_place_of_the_trajectory_and_its_distance_to_the_cell(recording):
    world, trajectory = recording
    for finding in audit(world, trajectory, straight=True).findings:
        assert finding.begin <= finding.t <= finding.end
        if finding.kind in ("overlap", "burned"):
            (ix, iy), side = finding.cell, world.cell_size
            dx = (
                0.0
                if ix in (-1, world.width)
                else max(ix * side - finding.x, 0.0, finding.x - (ix + 1) * side)
            )
            dy = (
                0.0
                if iy in (-1, world.height)
                else max(iy * side - finding.y, 0.0, finding.y - (iy + 1) * side)
            )
            assert ix in (-1, world.width) or iy in (-1, world.height) or finding.depth == pytest.approx(
                world.robot_radius - math.hypot(dx, dy), abs=1e-9)  # fmt: skip


def test_through_a_wall_is_a_tunnel_from_face_to_face():
    found = [
        f
        for f in audit(room(walls=[(4, 3)]), path((0, 2.5, 3.5), (4, 6.5, 3.5))).findings
        if f.kind == "tunnel"
    ]
    assert [(f.begin, f.end, f.t, f.x, f.y, f.depth, f.cell) for f in found] == [
        (1.5, 2.5, 2.0, 4.5, 3.5, 0.5, (4, 3))
    ]


def test_a_tunnel_is_as_deep_as_the_centre_is_from_the_nearest_face():
    found = audit(room(walls=[(4, 3)]), path((0, 3.0, 2.4), (1, 5.5, 4.9)), straight=True).findings
    deepest = next(finding for finding in found if finding.kind == "tunnel")
    assert (deepest.depth, deepest.x, deepest.y) == pytest.approx((0.3, 4.3, 3.7))


def test_a_long_step_that_only_ends_near_a_wall_is_looked_at():
    assert kinds(room(walls=[(5, 3)], robot_radius=0.1), (0, 2.95, 3.5), (1, 4.95, 3.5)) == [
        "overlap"
    ]


def test_three_walls_in_one_step_are_three_tunnels():
    world = room(walls=[(2, 3), (4, 3), (6, 3)], robot_radius=0.01)
    assert kinds(world, (0, 0.5, 3.5), (1, 8.5, 3.5)).count("tunnel") == 3


def test_a_wall_of_many_cells_is_one_tunnel():
    assert (
        kinds(room(walls=[(3, 3), (4, 3), (5, 3)]), (0, 0.5, 3.4), (1, 8.5, 3.6)).count("tunnel")
        == 1
    )


@pytest.mark.parametrize("size", [1.0, 0.1, 0.3])
def test_along_the_face_of_a_wall_the_centre_is_in_no_wall(size):
    world = small_room(size, [(2, 3), (3, 3), (4, 3)])
    samples = [(t, round(t * size, 9), round(4 * size, 9)) for t in range(1, 8)]
    assert kinds(world, *samples) == ["overlap"]


@pytest.mark.parametrize("size", [1.0, 0.1, 0.3])
def test_along_the_face_between_two_solid_cells_the_centre_is_in_the_wall(size):
    world = small_room(size, [(4, 3), (4, 2)])
    found = [
        f
        for f in audit(
            world, path((0, size, round(3 * size, 9)), (4, 7 * size, round(3 * size, 9)))
        ).findings
        if f.kind == "tunnel"
    ]
    assert [f.depth for f in found] == [pytest.approx(0.5 * size)]


def test_a_line_through_the_corner_of_a_cell_is_no_tunnel():
    assert kinds(room(walls=[(4, 3)]), (0, 3.0, 3.0), (1, 5.0, 5.0)) == ["overlap"]


def test_a_centre_that_touches_a_wall_and_goes_back_is_in_no_wall():
    assert kinds(room(walls=[(4, 3)]), (0, 2.5, 3.5), (1, 4.0, 3.5), (2, 2.5, 3.5)) == ["overlap"]


def test_of_two_lines_a_billionth_apart_the_one_inside_is_a_tunnel():
    world = room(walls=[(4, 3)])
    assert "tunnel" in kinds(world, (0, 2.5, 3.0 + 1e-10), (1, 6.5, 3.0 + 1e-10))
    assert "tunnel" not in kinds(world, (0, 2.5, 3.0 - 1e-10), (1, 6.5, 3.0 - 1e-10))


def test_a_cell_that_falls_shut_behind_the_robot_is_no_tunnel_and_one_that_falls_on_it_is():
    drive = ((0, 2.5, 3.5), (4, 6.5, 3.5))  # the centre is in cell 4 from 1.5 to 2.5 s
    assert "tunnel" not in kinds(room((2.5, 4, 3, SOLID)), *drive)
    assert "tunnel" in kinds(room((2.499, 4, 3, SOLID)), *drive)
    assert "tunnel" not in kinds(room((1.5, 4, 3, FREE), walls=[(4, 3)]), *drive)
    assert "tunnel" in kinds(room((1.501, 4, 3, FREE), walls=[(4, 3)]), *drive)


def test_a_cell_that_opens_at_the_time_of_a_sample_is_open_for_it():
    world = room((1.0, 4, 3, FREE), walls=[(4, 3)])
    assert kinds(world, (0, 2.5, 3.5), (1, 2.5, 3.5), (1, 4.5, 3.5), (2, 4.5, 3.5)) == []


def test_a_cell_that_falls_shut_at_the_time_of_the_last_sample_counts():
    assert "tunnel" in kinds(room((1.0, 4, 3, SOLID)), (0, 4.5, 3.5), (1, 4.5, 3.5))


def test_an_event_parts_a_step_at_its_very_time():
    found = only(room((1.0, 4, 3, SOLID), (1.25, 4, 3, FREE)), (0, 3.5, 3.5), (2, 4.1, 3.5))
    assert (found.kind, found.begin, found.end, found.t) == ("overlap", 1.0, 1.25, 1.25)
    assert found.depth == pytest.approx(0.3 + 3.875 - 4.0)


def test_a_cell_that_is_solid_time_and_again_is_a_finding_each_time():
    world = room(*[(float(t), 4, 3, SOLID if t % 2 else FREE) for t in range(1, 9)])
    assert kinds(world, (0, 3.9, 3.5), (10, 3.9, 3.5)) == ["overlap"] * 4


def test_a_touched_fire_is_burned_by_how_deep_the_disc_is_in_it():
    found = only(room((1.0, 4, 3, BURNING)), (0, 3.8, 3.5), (2, 3.8, 3.5))
    assert (found.kind, found.begin, found.end, found.cell) == ("burned", 1.0, 2.0, (4, 3))
    assert found.depth == pytest.approx(0.1)


def test_fire_at_the_edge_burns_a_robot_whose_centre_is_outside():
    assert "burned" in kinds(room((0.0, 8, 3, BURNING)), (0, 9.2, 3.5), (1, 9.25, 3.5))


def test_what_burned_before_the_robot_came_does_it_no_harm():
    assert (
        kinds(
            room((0.0, 4, 3, BURNING), (1.0, 4, 3, FREE)),
            (0, 2.5, 3.5),
            (1, 3.5, 3.5),
            (2, 6.5, 3.5),
        )
        == []
    )


@pytest.mark.parametrize(
    "side", [step for step in itertools.product((-1, 0, 1), repeat=2) if any(step)]
)
def test_a_wall_on_any_side_is_seen(side):
    cell = (4 + side[0], 3 + side[1])
    place = (4.5 + 0.35 * side[0], 3.5 + 0.35 * side[1])
    found = only(room(walls=[cell]), (0, *place), (1, *place))
    assert found.cell == cell and found.depth == pytest.approx(0.3 - 0.15 * math.hypot(*side))


def test_an_overlap_is_radius_less_distance_and_counts_beyond_the_tolerance():
    world = room(walls=[(4, 3)])
    assert only(world, (0, 1.5, 2.8), (1, 7.5, 2.8)).depth == pytest.approx(0.1, abs=1e-12)
    assert kinds(world, (0, 1.5, 2.8), (1, 7.5, 2.8), tolerance=0.1001) == []
    assert kinds(world, (0, 1.5, 2.7 + 1e-8), (1, 7.5, 2.7 + 1e-8)) == []


def test_an_overlap_begins_and_ends_where_the_disc_meets_the_wall():
    found = only(room(walls=[(4, 3)]), (0, 1.5, 2.76), (6, 7.5, 2.76), tolerance=1e-9)
    reach = math.sqrt(0.3**2 - 0.24**2)
    assert (found.begin, found.end) == pytest.approx((2.5 - reach, 3.5 + reach), abs=1e-6)


@pytest.mark.gate
@pytest.mark.parametrize("count", [3, 200_000])
def test_a_long_slide_along_a_wall_is_one_finding(count):
    world = room(walls=[(ix, 3) for ix in range(9)])
    x = np.linspace(1.0, 8.0, count)
    (found,) = audit(world, Trajectory(np.arange(count) * 10.0, x, np.full(count, 2.9))).findings
    assert (found.kind, found.begin, found.end) == ("overlap", 0.0, 10.0 * (count - 1))
    assert found.depth == pytest.approx(0.2) and found.t == 0.0


def test_two_cuts_with_a_clear_stretch_between_are_two_findings():
    world = room(walls=[(2, 3), (6, 3)])
    assert [f.cell for f in audit(world, path((0, 1.0, 2.8), (8, 8.0, 2.8))).findings] == [
        (2, 3),
        (6, 3),
    ]


def test_beyond_the_grid_is_outside_by_its_distance_and_the_border_is_inside():
    found = [
        f
        for f in audit(ROOM, path((0, 8.0, 3.5), (4, 10.0, 3.5), (8, 8.0, 3.5))).findings
        if f.kind == "outside"
    ]
    assert [(f.begin, f.end, f.t, f.depth) for f in found] == [(2.0, 6.0, 4.0, 1.0)]
    assert "outside" not in kinds(small_room(0.1), (0, 0.5, 0.5), (1, 0.9, 0.7))


def test_faster_than_the_robot_is_a_jump_by_what_is_too_far():
    found = only(ROOM, (0, 1.5, 3.5), (1, 3.5, 3.5), (2, 6.5, 3.5), (3, 7.5, 3.5), slack=0.0)
    assert (found.kind, found.begin, found.end, found.t, found.x) == ("jump", 1.0, 2.0, 2.0, 6.5)
    assert found.depth == pytest.approx(1.0) and found.speed == pytest.approx(3.0)


def test_two_places_at_one_time_are_a_jump_at_infinite_speed():
    found = only(ROOM, (0, 1.5, 3.5), (0, 2.5, 3.5), (9, 2.5, 3.5), slack=0.0)
    assert (found.kind, found.depth, found.speed) == ("jump", 1.0, math.inf)


def test_rounded_places_may_be_a_little_too_far_apart():
    drive = ((0, 1.5, 3.5), (1, 3.503, 3.5))
    assert kinds(ROOM, *drive, slack=None) == [] and kinds(ROOM, *drive, slack=0.002) == ["jump"]


def test_another_start_is_a_note_or_a_finding():
    elsewhere = path((0, 2.5, 3.5), (1, 2.5, 3.5))
    result = audit(ROOM, elsewhere)
    assert result.ok and "1 m away from the world's start" in result.notes[0]
    (found,) = audit(ROOM, elsewhere, from_start=True).findings
    assert (found.kind, found.depth) == ("start", 1.0)


def test_a_corner_cut_between_clear_close_samples_is_a_note_unless_the_robot_went_straight():
    round_it = [
        (4.0 + 0.301 * math.cos(angle), 3.0 + 0.301 * math.sin(angle))
        for angle in np.radians([200, 250])
    ]
    trajectory = path((0, 3.6, 3.2), (1, *round_it[0]), (2, *round_it[1]), (3, 4.3, 2.6))
    result = audit(room(walls=[(4, 3)]), trajectory)
    assert result.ok and result.shaved == 1
    assert result.shaved_depth == pytest.approx(
        0.3 - 0.301 * math.cos(math.radians(25.0)), abs=1e-9
    )
    assert "--straight" in result.notes[-1]
    assert [f.kind for f in audit(room(walls=[(4, 3)]), trajectory, straight=True).findings] == [
        "overlap"
    ]


def test_a_cut_between_samples_further_apart_than_the_radius_counts():
    assert kinds(room(walls=[(4, 3)]), (0, 3.5, 3.0), (1, 4.4, 2.6), straight=False) == ["overlap"]


@given(recordings(still_worlds()))
def test_the_target_is_reached_when_the_line_enters_its_disc(recording):
    world, trajectory = recording
    reached = audit(world, trajectory).reached
    fine = np.linspace(trajectory.times[0], trajectory.times[-1], 2001)
    where = [np.interp(fine, trajectory.times, values) for values in (trajectory.x, trajectory.y)]
    near = np.hypot(where[0] - world.target.x, where[1] - world.target.y) <= world.target.radius * (
        1 - 1e-9
    )
    assert not near.any() or (reached is not None and reached <= fine[near][0] + 1e-9)


def test_figures_are_length_duration_and_arrival():
    result = audit(ROOM, path((0, 3.5, 3.5), (1, 5.45 - 1.0, 3.5), (3, 5.45, 3.5)))
    assert (result.path_length, result.duration, result.samples) == (pytest.approx(1.95), 3.0, 3)
    assert result.reached == pytest.approx(3.0) and result.clearance == pytest.approx(3.5)


@pytest.mark.gate
@pytest.mark.parametrize("family", ["maze", "trap", "corridor"])
@pytest.mark.parametrize("controller", ["turn-left", "turn-random"])
def test_what_swept_drives_is_possible(family, controller):
    for seed in range(4):
        world = generate(family, seed=seed)
        episode = simulate(world, controller, steps=2000, seed=seed, record=True)
        assert audit(world, recorded(episode), from_start=True).findings == ()
        result = audit(world, recorded(episode, corners=True), straight=True)
        assert result.findings == () and result.clearance >= world.robot_radius - 1e-9
        assert (result.reached is not None) == (episode.verdict == "reached")


@pytest.mark.parametrize(
    "name", ["thesis-1-back-off", "thesis-2-back-off", "thesis-2-slide", "thesis-1-slide"]
)
def test_a_tunnel_of_stepped_is_found_in_the_same_step(name):
    world = read_world(resources.files("corpora") / "thesis-faults" / f"{name}.grid")
    failure = Failure.of(world)
    record, options = failure.record, failure.options
    episode = simulate(world, record.controller, options, record=True)
    assert_same_step(world, episode)


def test_a_tunnel_of_endpoint_is_found_in_the_same_step():
    seen = 0
    for family, seed in itertools.product(("corridor", "maze", "trap"), range(8)):
        world = generate(family, seed=seed)
        episode = simulate(
            world, "turn-left", motion="endpoint", time_step=0.3, steps=1500, record=True
        )
        if episode.verdict == "tunnel":
            assert_same_step(world, episode)
            seen += 1
    assert seen >= 5


def assert_same_step(world, episode):
    assert episode.verdict == "tunnel"
    step, trajectory = episode.evidence.step, recorded(episode)
    begin, end = trajectory.times[step - 1], trajectory.times[step]
    tunnels = [f for f in audit(world, trajectory).findings if f.kind in ("tunnel", "outside")]
    assert any(finding.begin <= end and finding.end >= begin for finding in tunnels)
