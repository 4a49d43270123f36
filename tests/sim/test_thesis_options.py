"""The options of the thesis's simulator.

Each works as documented, according to a separate reference or to the evidence.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from sim import simulate
from sim.options.robot import RobotOptions
from sim.options.thesis import ARBITERS, ThesisOptions
from sim.thesis.core_calls import STATE_FIELDS, WALL, ThesisSetup, signal_map
from sim.thesis.run import signal_in
from tests.helpers import thesis_parts
from tests.helpers.raising import raises
from tests.reference.sim.thesis_signal import bearing
from tests.sim.test_thesis_vectors import VECTORS, world_of
from worldgen import InvalidParameter, Pose, Target, World, read_world

SIDE = 14


def hall(target, n=30, walls=()):
    """A closed square hall, the thesis's start, and the target in cell (x, y), counted from the
    upper left.
    """
    cells = np.zeros((n, n), bool)
    cells[[0, -1], :] = cells[:, [0, -1]] = True
    for x, y in walls:
        cells[n - 1 - y, x] = True
    centre = (round(target[0] / 10 + 0.05, 3), round((n - 1 - target[1]) / 10 + 0.05, 3))
    return World(cells, Pose(0.35, round(n / 10 - 0.35, 3), math.pi - 4.5), Target(*centre, 0.05))


def run(world, controller="thesis-1", **switches):
    return simulate(world, controller, motion="stepped", **switches)


@pytest.mark.parametrize(
    ("reading", "centre", "corner"),
    [
        ("A0", 107, 198),
        ("A1", 114, 203),
        ("A2", 103, 187),
        ("A3", 92, 170),
        ("A4", 97, 184),
        ("A5", 123, 251),
        ("A6", 107, 198),  # the robot touches nothing on its path
    ],
)
def test_every_reading_of_the_arbiter_takes_the_ticks_that_were_worked_out_from_the_listing(
    reading, centre, corner
):
    steps = [run(hall(target), arbiter=reading).steps for target in ((15, 15), (27, 27))]
    assert steps == [centre, corner]


def test_every_reading_of_the_arbiter_is_another_run_where_walls_are_met():
    world = hall((20, 20), walls=[(x, 12) for x in range(5, 16)])
    digests = {
        reading: run(world, arbiter=reading, steps=3000).trace_digest for reading in ARBITERS
    }
    assert len(set(digests.values())) == len(ARBITERS)


def test_an_interruptible_robot_begins_its_escape_afresh_at_each_collision():
    world = hall((20, 20), walls=[(x, 12) for x in range(5, 16)])
    plain, interruptible = (
        simulate(world, "thesis-1", motion="stepped", arbiter=reading, steps=400, record=True).trace
        for reading in ("A0", "interruptible")
    )
    moved = [np.hypot(np.diff(t.x), np.diff(t.y)) > 0 for t in (plain, interruptible)]
    went_on = [
        bool((t.bump[1:-1] & m[1:]).any())
        for t, m in zip((plain, interruptible), moved, strict=True)
    ]
    assert went_on == [
        True,
        False,
    ]  # after a bump the plain one may drive on; the other always stops first


def clear(walls, x, y):
    """Return whether the thesis's disc is clear of cells, using only distances."""
    gaps = [
        math.hypot(max(10 * i - x, 0, x - 10 * i - 10), max(10 * j - y, 0, y - 10 * j - 10))
        for i, j in walls
    ]
    return min(gaps) >= 7.0 - 1e-9


@given(
    st.sets(st.tuples(st.integers(1, SIDE - 2), st.integers(1, SIDE - 2)), max_size=40),
    st.tuples(st.floats(17, SIDE * 10 - 17), st.floats(17, SIDE * 10 - 17)),
    st.lists(st.tuples(st.floats(-math.pi, math.pi), st.floats(0, 30)), min_size=1, max_size=20),
    st.sampled_from([0.0, 0.3, 1.0]),
)
def test_with_all_three_repairs_no_move_ever_cuts_a_wall(inner, place, moves, friction):
    border = {
        (i, j)
        for i in range(SIDE)
        for j in range(SIDE)
        if not (0 < i < SIDE - 1 and 0 < j < SIDE - 1)
    }
    assume(clear(inner | border, *place))
    cells = np.zeros((SIDE, SIDE), np.int32)
    for wall in inner | border:
        cells[wall] = WALL
    x, y = place
    for heading, length in moves:
        goal = (x + math.cos(heading) * length, y + math.sin(heading) * length)
        move = thesis_parts.move(cells, x, y, *goal, 7.0, 7, friction)
        x, y = move.x, move.y
        assert clear(inner | border, x, y)


@pytest.mark.parametrize(
    ("name", "cause", "since", "step"),
    [("demo-1", "slide", 97, 148), ("demo-2", "back-off", 717, 773), ("demo-6", "slide", 564, 609)],
)
def test_a_tunnel_names_the_move_that_let_the_robot_in(name, cause, since, step):
    vector = VECTORS[name]
    evidence = run(
        world_of(vector), f"thesis-{vector['rule']}", draws=vector.get("draws", []), steps=2000
    ).evidence
    assert (evidence.cause, evidence.since, evidence.step) == (cause, since, step)


@pytest.mark.parametrize("name", [f"demo-{k}" for k in range(1, 9)])
def test_a_run_that_keeps_going_is_the_recorded_one_walls_or_not(name):
    vector = VECTORS[name]
    switches = {"keep_going": True, "draws": vector.get("draws", []), "steps": vector["maxTicks"]}
    episode = run(world_of(vector), f"thesis-{vector['rule']}", **switches)
    if vector["verdict"] != "limit":
        assert (episode.verdict, episode.trace_digest) == (vector["verdict"], vector["hash"])
    wall_step = getattr(episode.evidence, "wall_step", None)
    assert wall_step in (None, vector["firstCentreInWall"])


@pytest.mark.parametrize("name", [f"demo-{k}" for k in range(1, 7)])
def test_a_repaired_robot_does_not_enter_the_walls_that_the_thesis_enters(name):
    vector = VECTORS[name]
    repairs = dict.fromkeys(("repair_slide", "repair_back_off", "repair_corner"), True)
    episode = run(
        world_of(vector),
        f"thesis-{vector['rule']}",
        draws=vector.get("draws", []),
        steps=20_000,
        **repairs,
    )
    assert episode.verdict in ("reached", "loop", "stalled", "timeout")


def test_endless_runs_that_are_no_exact_loop_drift_or_are_confined():
    drifting = run(world_of(VECTORS["demo-2"]), "thesis-2", keep_going=True, steps=20_000)
    confined = run(world_of(VECTORS["demo-1"]), "thesis-1", repair_slide=True, steps=20_000)
    assert (drifting.evidence.kind, drifting.evidence.period, drifting.evidence.box) == (
        "drifting", 101, (2, 1),
    )  # fmt: skip
    assert (confined.evidence.kind, confined.evidence.box) == ("confined", (6, 4))


def speeds(**switches):
    """Distance per tick, px, of an unobstructed run straight to the right.

    The thesis's robot drives 3 px per tick.
    """
    world = replace(hall((27, 3)), start=Pose(0.35, 2.65, 0.0))
    trace = simulate(
        world, "thesis-1", motion="stepped", steps=60, record=True, arbiter="A3", **switches
    ).trace
    return np.hypot(np.diff(trace.x), np.diff(trace.y)) * 100


def test_acceleration_bounds_the_gain_of_speed_and_friction_its_loss():
    plain, heavy = speeds(), speeds(acceleration=2.0, friction=2.0)
    assert plain.max() > 1.9 and (np.diff(plain) > 1.9).any()
    # 2 m/s2 adds 0.45 px per tick of 15 ms; only whole pixels are driven
    assert heavy.max() > 1.9 and np.diff(heavy).max() < 1.1 and np.diff(heavy).min() > -1.1


def test_without_friction_a_robot_stops_at_once_and_with_it_rolls_out():
    turning = {"arbiter": "A0", "steps": 26}
    world = replace(hall((3, 25)), start=Pose(1.5, 1.5, 0.0))
    still, rolls = (
        simulate(
            world, "thesis-1", motion="stepped", record=True, friction=friction, **turning
        ).trace
        for friction in (0.0, 5.0)
    )
    assert abs(rolls.x[8] - 1.5) > abs(still.x[8] - 1.5) + 0.02


def test_slip_shortens_the_way_and_differs_from_tick_to_tick():
    slipping = speeds(slip=0.9)
    moving = slipping[slipping > 0]
    assert moving.mean() < speeds()[speeds() > 0].mean() and len(set(np.round(moving, 6))) > 1


def test_friction_at_the_wall_takes_its_share_of_a_slide():
    cells = np.full((SIDE, SIDE), 1, np.int32)
    cells[:, 8] = WALL
    slides = [thesis_parts.move(cells, 50.0, 72.5, 53.0, 75.0, 7.0, 0, f) for f in (0.0, 0.5, 1.0)]
    assert [slide.ending for slide in slides] == [thesis_parts.SLIDE] * 3
    along = [slide.x - 50.0 for slide in slides]
    assert along[0] > along[1] > along[2] and along[1] == pytest.approx((along[0] + along[2]) / 2)


@given(
    st.sets(st.tuples(st.integers(0, 11), st.integers(0, 11)), max_size=40),
    st.tuples(*[st.integers(0, 11)] * 4),
)
def test_walls_between_two_cells_are_those_that_the_straight_line_crosses(walls, ends):
    cells = np.ones((12, 12), np.int32)
    for wall in walls:
        cells[wall] = WALL
    x, y, to_x, to_y = ends
    line = shapely.LineString([(x + 0.5, y + 0.5), (to_x + 0.5, to_y + 0.5)])
    crossed = [
        wall
        for wall in walls - {(x, y), (to_x, to_y)}
        if line.intersection(shapely.box(wall[0], wall[1], wall[0] + 1, wall[1] + 1)).length > 1e-9
    ]
    assert thesis_parts.walls_between(cells, x, y, to_x, to_y) == (
        len(crossed) if x != to_x or y != to_y else 0
    )


def sensed(cells, x, y, heading=0.0, step=1, **changes):
    setup = ThesisSetup(rule=1, time_step=15.0, target_x=12, target_y=6, **changes)
    return thesis_parts.sensed(cells, setup, x, y, heading, step)


def lit(walls=()):
    cells = signal_map(SIDE, SIDE, 12, 6)
    for wall in walls:
        cells[wall] = WALL
    return cells


def test_a_wall_in_the_way_hides_the_target_so_the_robot_heads_for_a_lit_cell():
    cells = lit([(9, 6)])
    assert sensed(cells, 75.0, 65.0) == math.pi  # straight at the target, as if there were no wall
    assert sensed(cells, 75.0, 65.0, signal=thesis_parts.BLOCKED) == bearing(
        10.0, -10.0
    )  # cell (8, 5)


def test_a_signal_is_worth_half_behind_each_wall_cell():
    # from cell (7, 6): (8, 6) is at 16 behind two walls, so 64; (8, 5) is at 17 behind one, so 34
    cells = lit([(9, 6), (10, 6)])
    assert sensed(cells, 75.0, 65.0) == math.pi
    assert sensed(cells, 75.0, 65.0, signal=thesis_parts.WEAKENED) == bearing(10.0, -10.0)


def test_a_directed_sensor_sees_only_what_lies_ahead():
    ahead = sensed(lit(), 65.0, 65.0, heading=math.pi, sensor_field=1.0)
    away = sensed(lit(), 65.0, 65.0, heading=0.0, sensor_field=1.0)
    assert ahead == pytest.approx(math.pi)
    assert away == bearing(0.0, 0.0)  # no better cell in sight than its own


def test_a_noisy_sensor_errs_anew_in_each_tick_and_the_same_again():
    heads = [
        sensed(lit(), 65.0, 65.0, step=step, sensor_noise=0.5, seed=7) for step in range(1, 30)
    ]
    again = [
        sensed(lit(), 65.0, 65.0, step=step, sensor_noise=0.5, seed=7) for step in range(1, 30)
    ]
    assert heads == again and len(set(heads)) > 2
    assert sensed(lit(), 65.0, 65.0, sensor_noise=1e-9) == sensed(lit(), 65.0, 65.0)


def test_a_coarse_map_makes_the_robot_head_for_the_middle_of_blocks():
    # blocks of 4 cells: from cell (2, 2) the best neighbour has the cells (4..7, 4..7); its middle
    # is (60, 60) px
    assert sensed(lit(), 25.0, 25.0, map_scale=4) == bearing(60.0 - 25.0, 60.0 - 25.0)
    assert (
        sensed(lit(), 125.0, 78.0, map_scale=4) == math.pi / 2
    )  # in the best block, cell by cell: up to the target


@pytest.mark.parametrize(
    "switch",
    [
        {"map_scale": 3},
        {"signal": "blocked"},
        {"signal": "weakened"},
        {"sensor_field": 2.0},
        {"sensor_noise": 0.2},
        {"slip": 0.3},
        {"acceleration": 3.0},
        {"friction": 3.0},
        {"wall_friction": 0.5},
        {"sensor_range": 50},
        {"noise": True},
        {"collide_ticks": 9},
        {"drive_ticks": 6},
        {"turn_angle": 1.0},
    ],
    ids="".join,
)
def test_each_switch_changes_the_run_and_repeats_itself(switch):
    world = hall((20, 20), walls=[(x, 12) for x in range(5, 16)])
    plain, once, again = (
        run(world, steps=3000, **changes).trace_digest for changes in ({}, switch, switch)
    )
    assert once == again != plain


@pytest.mark.parametrize(("rule", "side"), [("thesis-1", -1), ("thesis-2", 1)])
@pytest.mark.parametrize("angle", [0.0, 0.4, math.pi / 2, 2.5])
def test_the_escape_turns_by_the_turn_angle_to_the_side_of_the_rule(rule, side, angle):
    world = hall((20, 20), walls=[(x, 12) for x in range(5, 16)])
    trace = run(world, rule, steps=300, turn_angle=angle, record=True).trace
    first = int(np.flatnonzero(trace.bump)[0])  # the tick in which the escape begins
    done = first + math.ceil(angle / 0.08) + 1
    turned = (side * (trace.heading[done] - trace.heading[first - 1]) + 1) % (2 * math.pi) - 1
    assert turned == pytest.approx(angle, abs=1e-9)


@pytest.mark.parametrize("kind", [ThesisOptions, RobotOptions])
def test_each_option_stands_under_one_heading(kind):
    assert all(option.group for option in kind.declared())


@pytest.mark.parametrize("kind", [ThesisOptions, RobotOptions])
def test_each_option_has_help(kind):
    assert [option.name for option in kind.declared() if not option.help] == []


def test_a_quarter_turn_is_the_thesis_s_own_to_the_last_bit():
    world = hall((20, 20), walls=[(x, 12) for x in range(5, 16)])
    assert run(world, turn_angle=math.pi / 2).trace_digest == run(world).trace_digest


def test_chance_in_the_simulator_itself_leaves_no_loop_to_prove():
    world = world_of(VECTORS["demo-7"])
    assert run(world, f"thesis-{VECTORS['demo-7']['rule']}", steps=5000).verdict == "loop"
    verdicts = {
        run(world, f"thesis-{VECTORS['demo-7']['rule']}", steps=5000, slip=0.01, seed=s).verdict
        for s in (1, 2)
    }
    assert "loop" not in verdicts


def test_given_draws_are_used_before_those_of_the_seed():
    vector = VECTORS["demo-3"]
    runs = [
        run(world_of(vector), "thesis-3", draws=vector["draws"], seed=seed, steps=667)
        for seed in (1, 2)
    ]
    assert runs[0].trace_digest == runs[1].trace_digest
    assert run(world_of(vector), "thesis-3", seed=1, steps=667).trace_digest != runs[0].trace_digest


def test_draws_outside_the_unit_interval_are_refused():
    with raises(InvalidParameter, "out-of-range"):
        run(hall((15, 15)), "thesis-3", draws=[1.5])


@pytest.mark.parametrize(
    "switches", [{"friction": 2.0}, {"friction": 0.5, "arbiter": "interruptible"}]
)
def test_a_robot_that_rolls_out_or_is_interrupted_drives_in_every_escape(switches):
    world = read_world(Path(__file__).parents[2] / "corpora" / "thesis" / "config-06.grid")
    states = run(world, record=True, steps=3000, **switches).trace.states
    assert (
        states[:, STATE_FIELDS.index("old_speed")].copy().view(float) > 0
    ).all()  # the speed that an escape returns to


@pytest.mark.parametrize("noise", [False, True])
def test_walls_that_are_stored_by_columns_are_the_same_world(noise):
    world = hall((20, 20), walls=[(x, 12) for x in range(5, 16)])
    turned = replace(world, walls=np.asfortranarray(world.walls))
    assert (
        run(turned, noise=noise, steps=300).trace_digest
        == run(world, noise=noise, steps=300).trace_digest
    )


def test_the_signal_of_a_cell_is_its_squared_distance_and_walls_have_none():
    walls = np.zeros((5, 7), bool)
    walls[[0, -1]] = walls[:, [0, -1]] = walls[1, 4] = True
    signal = signal_in(World(walls, Pose(0.15, 0.35), Target(0.25, 0.15, 0.05), robot_radius=0.04))
    assert signal[1].tolist() == [-2, 1, 0, 1, -2, 9, -2] and signal[3, 5] == 9 + 4
