"""Pushes, drift and decoys work as documented, drive no robot into a wall, and break no proof."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from sim import CompiledController, Observation, RobotOptions, RunOptions, simulate, simulate_many
from sim.drawing.picture import disturbances_in
from sim.options.disturbances import Doubt, why_arrival_is_not_certain
from sim.options.run import step_budget
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from tests.sim.test_episode import arena
from tests.sim.test_robot_options import Drive, Eyes, hall, strength
from worldgen import InvalidParameter, Pose, Timeline, generate, write_world
from worldgen.reach import decide
from worldgen.timeline import CellState, Event

STEP = 0.015
STILL = CompiledController("still", lambda observation, memory, command: None, senses=())


def stand(world, steps=100, **options):
    return simulate(world, STILL, steps=steps, record=True, **options)


def test_a_push_displaces_and_turns_the_robot_in_the_step_of_its_time():
    trace = simulate(hall(), Drive(0.0), steps=60, record=True, pushes=(0.3, 0.5, -0.25, 1.0)).trace
    assert (trace.x[19], trace.y[19], trace.heading[19]) == (0.55, 2.95, 0.0)
    assert trace.x[20] == pytest.approx(1.05, abs=1e-4)
    assert trace.y[20] == pytest.approx(2.7, abs=1e-4)
    assert trace.heading[20] == pytest.approx(1.0, abs=1e-4)


def test_a_wall_stops_a_push():
    pushed = stand(hall(), pushes=(0.1, -3.0, 0.0, 0.0))
    assert pushed.trace.x[-1] == pytest.approx(0.1 + 0.07, abs=1e-3)
    assert pushed.collisions == 1


@given(
    st.lists(
        st.tuples(st.floats(0.0, 1.0), st.floats(-3, 3), st.floats(-3, 3), st.floats(-9, 9)),
        max_size=6,
    ),
    st.lists(
        st.tuples(st.floats(0, 4), st.floats(0, 4), st.floats(-1, 1), st.floats(-1, 1)), max_size=3
    ),
    st.floats(0.2, 3.0),
    st.sampled_from(["swept", "endpoint"]),
)
def test_no_disturbance_moves_a_robot_through_a_wall(pushes, places, drift, motion):
    walls = [(y, 12) for y in range(2, 30)] + [(20, x) for x in range(5, 30)]
    world = arena(40, (1.05, 1.05, 0.3), (3.5, 3.5), walls)
    options = {
        "pushes": tuple(number for push in pushes for number in push),
        "push_places": tuple(number for place in places for number in (*place, 0.1)),
    }
    if motion == "swept":
        options |= {"drift": drift, "drift_heading": 2.0}
    trace = simulate(world, Drive(0.3, 1.0), steps=90, record=True, motion=motion, **options).trace
    boxes = shapely.union_all(
        [
            shapely.box(x / 10, y / 10, x / 10 + 0.1, y / 10 + 0.1)
            for y, x in np.argwhere(world.walls)
        ]
    )
    path = shapely.LineString(np.column_stack([trace.path_x, trace.path_y]))
    assert path.distance(boxes) >= world.robot_radius - 1e-9


def test_a_place_pushes_whoever_is_in_it_and_nobody_else():
    options = {"push_places": (0.55, 2.95, 0.1, 0.0, 0.0)}
    trace = stand(hall(), **options).trace
    assert trace.x[1] == pytest.approx(0.65, abs=1e-4)
    assert (trace.x[2:] == trace.x[1]).all()


def test_a_floor_carries_the_robot_each_step_as_far_as_its_speed_says():
    trace = stand(hall(), drift=0.5, drift_heading=math.pi / 2).trace
    assert np.diff(trace.y[:50]) == pytest.approx(0.5 * STEP, abs=0.1 / 1024)
    assert (trace.x == 0.55).all()


def test_wheels_measure_neither_pushes_nor_drift():
    eyes = Eyes(0.5, 0.0)
    simulate(hall(), eyes, steps=100, pushes=(0.5, 0.3, 0.4, 2.0), drift=0.2, drift_heading=1.0)
    last = eyes.seen[-1]
    assert (last.odometry_heading, last.odometry_y) == (0.0, pytest.approx(2.95, abs=6e-3))
    assert abs(last.heading - 2.0) < 1e-3 and abs(last.y - 2.95) > 0.3


def test_a_loop_is_proved_only_after_the_last_push():
    before = stand(arena(), steps=500)
    assert (before.verdict, before.evidence.entry) == ("loop", 0)
    after = stand(arena(), steps=500, pushes=(3.0, 0.02, 0.0, 0.0))
    assert after.verdict == "loop" and after.evidence.entry >= 200


def test_drift_and_places_are_part_of_a_step_and_cost_no_proof():
    assert stand(arena(), steps=500, drift=0.3).verdict == "loop"
    assert stand(arena(), steps=500, push_places=(0.55, 0.55, 0.01, 0.0, 1.0)).verdict == "loop"


def test_who_reads_odometry_is_not_said_to_loop_where_pushes_make_it_wrong():
    reads = CompiledController(
        "reads", lambda observation, memory, command: None, senses=("odometry_x",)
    )
    assert simulate(arena(), reads, steps=500).verdict == "loop"
    assert simulate(arena(), reads, steps=500, drift=0.3).verdict == "stalled"


def test_a_decoy_adds_to_the_signal_and_draws_the_robot_away():
    world = arena(20, (0.55, 1.05, 0.0), (1.55, 1.05))
    free = strength(world).signal
    lured = strength(world, decoys=(0.55, 1.55, 3.0))
    assert lured.signal == pytest.approx(free + 3.0 / 26.0, rel=0.02)
    assert lured.signal_heading == pytest.approx(math.pi / 2, abs=0.1)


def test_a_wall_hides_a_decoy_as_it_hides_the_target():
    world = arena(20, (0.55, 1.05, 0.0), (1.55, 1.05), [(13, x) for x in range(2, 9)])
    seen = strength(world, decoys=(0.55, 1.55, 3.0), signal="blocked")
    assert seen.signal == strength(world).signal


def test_many_runs_have_the_disturbances_of_single_ones():
    world = generate("trap", 3)
    options = RunOptions(
        steps=3_000,
        robot=RobotOptions(pushes=(1.0, 0.3, 0.0, 1.0), drift=0.1, decoys=(0.5, 0.5, 1.0)),
    )
    names = ["turn-random", "bug2"]
    many = simulate_many(world, names, options, seeds=3, digest=True)
    for row in range(len(many)):
        one = simulate(
            world, names[many.controller[row]], replace(options, seed=int(many.seed[row]))
        )
        assert one.verdict == many.verdicts[row]
        assert one.trace_digest == f"{many.digest[row]:016x}"
        assert one.area_covered == pytest.approx(many.area_covered[row])


def test_the_area_is_that_of_the_cells_in_which_steps_ended():
    world = generate("maze", 4, size=20)
    episode = simulate(world, "wall-left", record=True)
    cells = {
        (math.floor(x / world.cell_size + 1e-9), math.floor(y / world.cell_size + 1e-9))
        for x, y in zip(episode.trace.x, episode.trace.y, strict=True)
    }
    assert episode.area_covered == pytest.approx(len(cells) * world.cell_size**2)


def test_the_thesis_robot_has_an_area_too():
    episode = simulate(generate("trap", 3), "thesis-3", motion="stepped", record=True)
    cells = {(int(x * 10 + 1e-9), int(y * 10 + 1e-9)) for x, y in zip(
        episode.trace.x, episode.trace.y, strict=True)}  # fmt: skip
    assert abs(episode.area_covered - 0.01 * len(cells)) <= 0.01


def test_arrival_is_certain_where_the_witness_can_still_be_driven():
    world = generate("trap", 3)
    start = (world.start.x, world.start.y)
    certain = [
        {},
        {"pushes": (1.0, 0.5, 0.5, 3.0)},
        {"drift": 0.5},
        {"push_places": (world.cell_size * 1.5, world.cell_size * 1.5, 0.1, 0.0, 0.0)},
        {"decoys": (0.5, 0.5, 9.0)},
    ]
    doubtful = {
        Doubt.FAST_DRIFT: {"drift": world.robot_speed},
        Doubt.SLOW_REACTION: {"drift": 0.5, "turn_limit": 1.0},
        Doubt.PUSHED_ON_THE_WITNESS: {"push_places": (*start, 0.1, 0.0, 0.0)},
    }
    assert not any(why_arrival_is_not_certain(world, RobotOptions(**one)) for one in certain)
    for doubt, one in doubtful.items():
        assert why_arrival_is_not_certain(world, RobotOptions(**one)) == doubt
    burning = replace(world, timeline=Timeline.of([Event(9.0, 3, 3, CellState.BURNING)]))
    pushed = RobotOptions(pushes=(1.0, 0.5, 0.5, 3.0))
    assert why_arrival_is_not_certain(burning, pushed) == Doubt.CHANGING_WORLD


@given(st.integers(0, 50), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_from_wherever_a_push_leads_the_target_is_reachable(seed, dx, dy):
    world = generate("trap", seed)
    trace = stand(world, steps=10, pushes=(0.05, dx, dy, 0.0)).trace
    moved = replace(
        world,
        start=Pose(float(trace.x[-1]), float(trace.y[-1]), 0.0),
        certificate=None,
        provenance=None,
    )
    assert decide(moved).result == "reachable"


def test_a_budget_grows_by_what_a_push_or_a_drift_delays():
    world = generate("maze", 1)
    plain = step_budget(world, RunOptions())
    pushed = step_budget(world, RunOptions(robot=RobotOptions(pushes=(10.0, 0.0, 0.0, 1.0))))
    assert pushed - plain == pytest.approx(50 * 10.0 / STEP, abs=2)
    half = RunOptions(robot=RobotOptions(drift=world.robot_speed / 2))
    assert step_budget(world, half) == pytest.approx(2 * plain, rel=0.01)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"pushes": (1.0, 2.0, 3.0)}, {"code": "wrong-length", "name": "pushes", "size": 4}),
        ({"push_places": (1.0,)}, {"code": "wrong-length", "name": "push_places", "size": 5}),
        ({"decoys": (1.0, 1.0, -1.0)}, {"code": "below-minimum", "name": "decoys"}),
        ({"pushes": (-1.0, 0.0, 0.0, 1.0)}, {"code": "below-minimum", "name": "pushes"}),
        ({"pushes": (1.0, 1e9, 0.0, 1.0)}, {"code": "out-of-range", "name": "pushes"}),
        ({"drift": 1e-6}, {"code": "drift-too-slow"}),
        ({"drift": 1e6}, {"code": "out-of-range"}),
    ],
)
def test_a_disturbance_that_cannot_be_gets_a_sentence(options, expected):
    with raises(InvalidParameter, **expected):
        simulate(hall(), STILL, **options)


def test_a_picture_knows_each_push_as_far_as_it_went():
    options = {
        "pushes": (0.3, 0.5, 0.0, 0.0, 0.6, -9.0, 0.0, 0.0),
        "decoys": (1.0, 1.0, 2.0),
        "drift": 0.2,
    }
    trace = simulate(hall(), Drive(0.5), steps=60, record=True, **options).trace
    found = disturbances_in(trace)
    one, two = found.pushes
    assert one.dx == pytest.approx(0.5, abs=1e-3) and one.dy == pytest.approx(0.0, abs=1e-3)
    assert two.x + two.dx == pytest.approx(0.17, abs=1e-3)
    assert found.decoys == ((1.0, 1.0),) and found.drift_heading == 0.0


def test_the_command_says_where_nobody_is_sure_to_arrive(tmp_path):
    path = tmp_path / "w.grid"
    world = generate("trap", 3)
    write_world(world, path)
    result = worldgen("run", path, "--controller", f"turn-right+drift={world.robot_speed}")
    assert result.code == 1 and "the drift is as fast as the robot" in result.err
    assert "sure" not in worldgen("run", path, "--controller", "turn-right+drift=0.2").err


def test_observations_name_no_disturbance():
    assert not {"drift", "pushes", "decoys"} & set(Observation._fields)
