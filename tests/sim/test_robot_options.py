"""Dynamics, sensors and events of the lattice robot.

Each works as documented, and keeps every promise.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from sim import Command, CompiledController, Observation, RobotOptions, RunOptions, simulate
from sim.audit import Trajectory, audit
from sim.episode import prepare
from tests.helpers.raising import raises
from tests.reference.sim import layout
from tests.sim.test_episode import arena
from worldgen import CellState, Event, InvalidParameter, Pose, Target, Timeline

STEP = 0.015


@dataclass(frozen=True)
class Drive:
    """Commands one speed and one turn rate for this many steps, then stops."""

    speed: float = 2.0
    rate: float = 0.0
    steps: int = 10**9

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        on = memory[0] < self.steps
        return Command(self.speed if on else 0.0, self.rate if on else 0.0), (memory[0] + 1.0,)


class Eyes:
    """Stores every observation, and drives ahead."""

    senses = Observation._fields

    def __init__(self, speed=0.5, rate=0.3):
        self.seen, self.speed, self.rate = [], speed, rate

    def reset(self):
        self.seen = []
        return ()

    def act(self, observation, memory):
        self.seen.append(observation)
        return Command(self.speed, self.rate), memory


def hall(**changes):
    """A wide hall with the target far away."""
    return replace(arena(60, (0.55, 2.95, 0.0), (5.45, 5.45)), **changes)


def speeds(**switches):
    trace = simulate(hall(), Drive(steps=40), steps=80, record=True, **switches).trace
    return np.hypot(np.diff(trace.x), np.diff(trace.y)) / STEP


def test_a_robot_without_dynamics_is_at_full_speed_at_once_and_stands_at_once():
    found = speeds()
    assert found[1] == pytest.approx(2.0, abs=0.01) and found[45] == 0.0


def test_acceleration_bounds_the_gain_of_speed_and_friction_its_loss():
    found = speeds(acceleration=5.0, friction=10.0)
    gains = np.diff(found)
    assert (
        gains.max() <= 5.0 * STEP + 0.014 and gains.min() >= -10.0 * STEP - 0.014
    )  # one lattice unit a step
    assert found.max() == pytest.approx(2.0, abs=0.01) and found[-1] == 0.0
    assert 20 <= np.flatnonzero(found > 1.95)[0] <= 32


def test_a_robot_that_is_told_to_turn_back_stops_first():
    class Reverse:
        def reset(self):
            return (0.0,)

        def act(self, observation, memory):
            return Command(2.0 if memory[0] < 30 else -2.0), (memory[0] + 1.0,)

    trace = simulate(
        hall(), Reverse(), steps=70, record=True, acceleration=20.0, friction=20.0
    ).trace
    way = np.diff(trace.x)
    assert way[20] > 0 > way[60] and np.abs(np.diff(way)).max() <= 20.0 * STEP * STEP + 2e-4


@given(st.floats(0.1, 20.0), st.floats(-50.0, 50.0))
def test_a_turn_limit_bounds_every_turn(limit, rate):
    trace = simulate(hall(), Drive(0.0, rate), steps=5, record=True, turn_limit=limit).trace
    turns = np.abs(np.angle(np.exp(1j * np.diff(trace.heading))))
    assert turns.max() <= min(limit, abs(rate)) * STEP + 1e-4


def test_friction_at_a_wall_takes_its_share_of_a_slide():
    world = arena(40, (0.25, 0.55, -math.pi / 4), (3.5, 3.5))
    ends = {
        share: simulate(world, Drive(1.0), steps=60, record=True, wall_friction=share).trace.x[-1]
        for share in (0.0, 0.5, 1.0)
    }
    start = ends[1.0]
    assert ends[0.5] - start == pytest.approx((ends[0.0] - start) / 2, rel=0.05) and start < 0.8


def test_slip_loses_up_to_its_share_of_each_step_and_depends_on_the_seed_alone():
    runs = {seed: speeds(slip=0.5, seed=seed) for seed in (1, 2)}
    assert (runs[1] == speeds(slip=0.5, seed=1)).all() and not (runs[1] == runs[2]).all()
    driven = runs[1][1:40]
    assert driven.min() >= 0.98 and driven.max() <= 2.0 and driven.std() > 0.1


@pytest.mark.parametrize(
    "noise", ["slip", "odometry_noise", "sensor_noise", "beam_noise", "beam_dropout"]
)
def test_with_noise_no_loop_is_ever_claimed(noise):
    circle = Drive(0.5, 512 / 65536 * 2 * math.pi / STEP)
    world = arena()
    still = CompiledController("still", lambda observation, memory, command: None)
    assert simulate(world, still, steps=500).verdict == "loop"
    assert simulate(world, still, steps=500, beams=4, **{noise: 0.1}).verdict == "stalled"
    assert simulate(world, circle, steps=500, beams=4, **{noise: 0.1}).verdict != "loop"


def test_who_reads_the_clock_is_never_said_to_loop():
    still = CompiledController("still", lambda observation, memory, command: None, senses=("time",))
    assert simulate(arena(), still, steps=500).verdict == "stalled"


def test_the_clock_counts_the_steps():
    simulate(hall(), eyes := Eyes(), steps=5)
    assert [seen.time for seen in eyes.seen] == pytest.approx([STEP * k for k in range(1, 6)])


def test_without_noise_odometry_is_the_pose():
    simulate(hall(), eyes := Eyes(), steps=50)
    assert all(
        (s.odometry_x, s.odometry_y, s.odometry_heading) == (s.x, s.y, s.heading) for s in eyes.seen
    )


def test_odometry_drifts_away_with_noise_and_not_faster_than_its_share():
    episode = simulate(
        hall(),
        eyes := Eyes(),
        RunOptions(steps=400, seed=3, robot=RobotOptions(odometry_noise=0.1)),
    )
    gaps = [math.hypot(s.odometry_x - s.x, s.odometry_y - s.y) for s in eyes.seen]
    turned = 400 * 0.3 * STEP
    assert 0.0 < gaps[-1] <= episode.path_length * (0.1 + 0.1 * turned)
    assert any(s.odometry_heading != s.heading for s in eyes.seen)


def test_the_first_of_the_beams_looks_ahead_and_the_others_go_round():
    world = arena(20, (0.55, 0.75, 0.0), (1.6, 1.6))
    simulate(world, eyes := Eyes(0.0, 0.0), steps=1, beams=4)
    assert eyes.seen[0].beams == pytest.approx(
        (1.9 - 0.55, 1.9 - 0.75, 0.55 - 0.1, 0.75 - 0.1), abs=2e-4
    )


def test_beams_end_at_their_range_and_are_wrong_by_at_most_their_noise():
    world = arena(20, (0.55, 0.75, 0.0), (1.6, 1.6))
    simulate(world, plain := Eyes(0.0, 0.0), steps=30, beams=8, beam_range=1.0)
    simulate(world, noisy := Eyes(0.0, 0.0), steps=30, beams=8, beam_range=1.0, beam_noise=0.1)
    simulate(world, lossy := Eyes(0.0, 0.0), steps=30, beams=8, beam_range=1.0, beam_dropout=0.5)
    right = np.array([seen.beams for seen in plain.seen])
    wrong = np.array([seen.beams for seen in noisy.seen])
    lost = np.array([seen.beams for seen in lossy.seen])
    assert (
        right.max() == 1.0
        and (np.abs(wrong - right) <= 0.1 * right + 1e-9).all()
        and wrong.std(axis=0).max() > 0.01
    )
    dropped = lost != right
    assert (lost[dropped] == 1.0).all() and 0.3 < dropped[:, right[0] < 1.0].mean() < 0.7


def strength(world, **switches):
    simulate(world, eyes := Eyes(0.0, 0.0), steps=1, **switches)
    return eyes.seen[0]


def test_walls_weaken_or_block_the_signal():
    clear, behind = (
        arena(20, (0.55, 1.05, 0.0), (1.55, 1.05)),
        arena(20, (0.55, 1.05, 0.0), (1.55, 1.05), [(10, 10), (10, 12)]),
    )
    free = strength(clear).signal
    assert strength(behind).signal == free == pytest.approx(1 / 101, rel=0.02)
    assert (
        strength(behind, signal="weakened").signal == free / 4
        and strength(behind, signal="blocked").signal == 0.0
    )
    assert strength(clear, signal="blocked").signal == free


def smoky(*events):
    """A hall in which cells burn between the robot and its target, 10 cells ahead, or elsewhere."""
    return replace(arena(20, (0.55, 1.05, 0.0), (1.55, 1.05)), timeline=Timeline.of(events))


def test_smoke_weakens_the_signal_in_each_cell_of_its_way():
    clear, burning = smoky(), smoky((0.0, 10, 10, CellState.BURNING))
    free = strength(clear).signal
    assert strength(clear, smoke=0.5).signal == strength(burning).signal == free
    for reach, cells in ((0, 1), (1, 3), (2, 5)):
        assert strength(burning, smoke=0.5, smoke_reach=reach).signal == free / 2**cells
    assert strength(burning, smoke=1.0).signal == 0.0
    both = strength(
        replace(burning, walls=arena(20, (0.5, 1, 0), (1.5, 1), [(10, 12)]).walls),
        smoke=0.5,
        signal="weakened",
    )
    assert both.signal == free / 2**6


def test_smoke_beside_the_way_reaches_it_or_does_not():
    beside = smoky((0.0, 10, 12, CellState.BURNING))
    free = strength(beside).signal
    assert [
        strength(beside, smoke=0.5, smoke_reach=reach).signal == free for reach in (0, 1, 2)
    ] == [True, True, False]


def test_smoke_is_gone_when_the_fire_is_out():
    world = smoky((0.0, 10, 10, CellState.BURNING), (0.3, 10, 10, CellState.FREE))
    simulate(world, eyes := Eyes(0.0, 0.0), steps=40, smoke=0.5)
    seen = [look.signal for look in eyes.seen]
    assert seen[0] == seen[-1] / 2**5 and len(set(seen)) == 2


def test_a_robot_is_led_round_smoke_and_blind_where_it_ends_the_signal():
    world = smoky(*[(0.0, 8, iy, CellState.BURNING) for iy in range(8, 12)])
    plain, led = (
        strength(world, sensor_cells=4, smoke_reach=1, smoke=share).signal_heading
        for share in (0.0, 0.9)
    )
    assert plain == pytest.approx(0.0, abs=1e-3) and abs(led) > 0.5
    everywhere = smoky(*[(0.0, ix, iy, CellState.BURNING) for ix in (9, 12) for iy in range(1, 19)])
    blind = strength(replace(everywhere, start=Pose(0.55, 1.05, 1.0)), smoke=1.0)
    assert blind.signal_heading == blind.heading


def test_a_signal_has_a_range_and_a_sensor_a_field():
    world = arena(20, (0.55, 1.05, math.pi), (1.55, 1.05))
    assert (
        strength(world, sensor_range=0.9).signal == 0.0 < strength(world, sensor_range=1.1).signal
    )
    assert (
        strength(world, sensor_field=3.0).signal
        == 0.0
        < strength(world, sensor_field=2 * math.pi).signal
    )
    blind = strength(world, sensor_range=0.5)
    assert blind.signal_heading == blind.heading


def test_a_sensor_that_sees_further_gives_a_finer_direction():
    world = arena(20, (0.55, 0.55, 0.0), (1.65, 0.75))
    right = math.atan2(0.2, 1.1)
    errors = [abs(strength(world, sensor_cells=cells).signal_heading - right) for cells in (1, 3)]
    assert errors[1] < errors[0]


def test_noise_on_the_signal_stays_within_its_share():
    world = arena(20, (0.55, 1.05, 0.0), (1.55, 1.05))
    simulate(world, eyes := Eyes(0.0, 0.0), steps=100, sensor_noise=0.2)
    found, right = np.array([seen.signal for seen in eyes.seen]), strength(world).signal
    assert (np.abs(found / right - 1) <= 0.2).all() and found.std() > 0.05 * right


def falling(time, cell, state=CellState.SOLID, **changes):
    """A hall in which a cell changes at a given time."""
    return hall(timeline=Timeline.of([Event(time, *cell, state)]), **changes)


def front(world, **switches):
    """Return how far the front of a robot that drives along the row gets."""
    episode = simulate(world, Drive(1.0), record=True, steps=60, **switches)
    return episode, float(episode.trace.x.max()) + world.robot_radius


def test_debris_stops_the_robot_only_if_it_falls_before_the_robot_is_there():
    arrival = (1.0 - 0.07 - 0.55) / 1.0 + STEP  # the robot stands still in the first step
    early, late = falling(arrival - 0.004, (10, 29)), falling(arrival + 0.004, (10, 29))
    assert front(early)[0].verdict != "burned" and front(early)[1] == pytest.approx(1.0, abs=1e-3)
    episode, _ = front(late)
    assert (episode.verdict, episode.evidence.state) == ("burned", "solid")
    assert episode.evidence.step == math.floor((arrival + 0.004) / STEP) + 1


@given(st.floats(0.02, 0.6))
def test_the_robot_is_where_it_should_be_when_fire_breaks_out(time):
    world = falling(time, (12, 29), CellState.BURNING)
    episode = simulate(world, Drive(1.0), record=True, steps=80)
    reach = 0.55 + max(time - STEP, 0.0)  # the place of the centre at that time
    there = reach + 0.07 > 1.2
    assert episode.verdict == "burned"
    step = episode.evidence.step
    expected = math.floor(time / STEP) + 1 if there else math.ceil((1.2 - 0.07 - 0.55) / STEP) + 1
    assert abs(step - expected) <= (0 if abs(reach + 0.07 - 1.2) > 0.02 and there else 1)


@given(
    st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(4, 14), st.integers(20, 38), st.sampled_from([0, 1]))),
    st.floats(-3, 3), st.floats(0.0, 30.0),
)  # fmt: skip
def test_no_path_cuts_a_wall_that_stands_at_that_moment(events, rate, speed):
    timeline = Timeline.of([Event(t, ix, iy, CellState(state)) for t, ix, iy, state in events])
    world = hall(timeline=timeline, robot_speed=30.0, start=Pose(0.95, 2.95, 0.0))
    if any(walls_at(world, 0.0, 9, 29)):
        return
    episode = simulate(world, Drive(speed, rate), record=True, steps=80)
    trace, caught = (
        episode.trace,
        episode.verdict == "burned",
    )  # and then the wall is at the end of the path
    times = path_times(trace)
    assert (np.diff(times) >= 0).all() and len(np.unique(trace.path_step)) == len(trace.x)
    for k in range(1, len(times) - caught):
        line = shapely.LineString([(trace.path_x[j], trace.path_y[j]) for j in (k - 1, k)])
        assert (
            not any(times[k - 1] + 1e-9 < event.time < times[k] - 1e-9 for event in world.timeline)
            or line.length == 0
        )
        middle = (times[k - 1] + times[k]) / 2
        solid = [
            cell for cell in cells_of(world) if state_at(world, cell, middle) == CellState.SOLID
        ]
        boxes = [
            shapely.box(ix * 0.1, iy * 0.1, ix * 0.1 + 0.1, iy * 0.1 + 0.1) for ix, iy in solid
        ]
        assert all(line.distance(box) >= 0.07 - 1e-9 for box in boxes)


def test_a_robot_that_waits_at_a_door_has_a_path_that_waits_too():
    door = [Event(0.0, 11, 29, CellState.SOLID), Event(0.85, 11, 29, CellState.FREE)]
    world = hall(timeline=Timeline.of(door))
    trace = simulate(world, Drive(1.0), record=True, steps=12, time_step=0.1).trace
    waits = np.flatnonzero(np.abs(trace.path_x - (1.1 - 0.07)) < 2e-3)
    assert trace.path_step[waits].tolist() == [6, 6, 7, 8, 9]
    assert trace.path_share[waits].tolist() == [pytest.approx(0.8, abs=0.01), 1.0, 1.0, 1.0, 0.5]
    assert audit(world, Trajectory(path_times(trace), trace.path_x, trace.path_y)).findings == ()


def path_times(trace):
    return (np.maximum(trace.path_step - 1, 0) + trace.path_share) * trace.time_step


def cells_of(world):
    return {(event.ix, event.iy) for event in world.timeline}


def state_at(world, cell, time):
    past = [
        event.state
        for event in world.timeline
        if (event.ix, event.iy) == cell and event.time <= time
    ]
    return past[-1] if past else CellState.FREE


def walls_at(world, time, ix, iy):
    """Return for each cell around a place whether it is solid at a time."""
    return [
        state_at(world, (ix + i, iy + j), time) == CellState.SOLID
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
    ]


def test_an_event_between_two_steps_belongs_to_the_later_one():
    run = prepare(falling(2 * STEP, (40, 40)), Drive(), RunOptions())
    assert run.last_event_step == 3


def test_a_recording_of_the_lattice_has_the_times_of_its_corners():
    world = arena(40, (0.25, 0.55, -math.pi / 4), (3.5, 3.5))
    trace = simulate(world, Drive(1.0), steps=60, record=True).trace
    inside = (trace.path_share > 0) & (trace.path_share < 1)
    assert inside.any() and (np.diff(trace.path_step + trace.path_share) >= 0).all()


def test_options_of_the_robot_are_stored_and_read_back():
    options = RunOptions("swept", 99, robot=RobotOptions(slip=0.5, beams=3))
    stored = options.parameters()
    assert stored == {"steps": 99, "time_step": 0.015, "slip": 0.5, "beams": 3}
    assert RunOptions.of("swept", 0, stored) == options


def test_the_same_run_comes_out_for_a_python_and_a_compiled_controller_with_everything_on():
    def act(observation, memory, command):
        memory[0] += (
            observation[layout.OBS_SIZE] + observation[layout.OBS_SIGNAL] + observation[layout.OBS_SIGNAL_HEADING]
            + observation[layout.OBS_ODOMETRY_X]
        )  # fmt: skip
        command[0], command[1] = 1.0, math.sin(memory[0])

    class Same:
        def reset(self):
            return (0.0,)

        def act(self, o, memory):
            total = memory[0] + (o.beams[0] + o.signal + o.signal_heading + o.odometry_x)
            return Command(1.0, math.sin(total)), (total,)

    everything = RobotOptions(
        turn_limit=3.0, acceleration=4.0, friction=3.0, wall_friction=0.3, slip=0.2, odometry_noise=0.1,
        sensor_cells=2, sensor_range=9.0, sensor_field=4.0, sensor_noise=0.1, signal="weakened", smoke=0.1,
        beams=5, beam_range=2.0, beam_field=3.0, beam_noise=0.1, beam_dropout=0.1,
    )  # fmt: skip
    options = RunOptions(steps=400, seed=9, robot=everything)
    world = arena(16, (0.75, 0.35, math.pi / 2), (0.75, 1.35), [(8, x) for x in range(3, 13)])
    world = replace(world, timeline=Timeline.of([Event(1.0, 6, 11, CellState.BURNING)]))
    one = simulate(world, CompiledController("all", act, (0.0,)), options)
    two = simulate(world, Same(), options)
    assert (one.trace_digest, one.verdict) == (two.trace_digest, two.verdict)


@pytest.mark.parametrize(
    ("switches", "expected"),
    [
        ({"slip": 1.5}, {"code": "out-of-range", "name": "slip", "value": 1.5, "high": 1}),
        ({"beams": 1001}, {"code": "out-of-range", "name": "beams", "high": 1000}),
        ({"signal": "off"}, {"code": "unknown-name", "name": "signal"}),
        ({"smoke": 1.5}, {"code": "out-of-range", "name": "smoke", "value": 1.5, "high": 1}),
        (
            {"smoke_reach": 11},
            {"code": "out-of-range", "name": "smoke_reach", "value": 11, "high": 10},
        ),
        ({"slip": True}, {"code": "wrong-type", "name": "slip", "expected": "float"}),
        ({"beam_range": math.inf}, {"code": "not-finite", "name": "beam_range"}),
    ],
)
def test_a_bad_option_gets_a_sentence(switches, expected):
    with raises(InvalidParameter, **expected):
        simulate(hall(), Drive(), **switches)


def test_a_target_seen_by_nobody_is_still_reached():
    world = replace(hall(), start=Pose(5.0, 5.45, 0.0), target=Target(5.45, 5.45, 0.05))
    assert simulate(world, Drive(), sensor_range=0.1).verdict == "reached"


@pytest.mark.parametrize("limit", [0.0033, 2.0, 31.0])
def test_no_turn_is_above_the_limit(limit):
    trace = simulate(hall(), Drive(0.0, 100.0), turn_limit=limit, record=True, steps=30).trace
    turned = np.abs(np.angle(np.exp(1j * np.diff(trace.heading))))
    assert turned.max() <= limit * STEP + 1e-12 and (
        turned.max() > 0.9 * limit * STEP or limit < 0.01
    )
