"""Several robots in one world: how they move, and what proves that they never arrive."""

import dataclasses
import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest

from fuzz.evidence_checks.fleet import check_fleet
from fuzz.player.runs import drawn_robots
from sim import simulate
from sim.controllers import Command, controller_of
from sim.drawing.picture import trails_of
from sim.fleet import FleetRun
from sim.fleet.apart import separate_loops
from sim.fleet.episode import fleet_traces
from sim.fleet.run import robot_seed
from sim.motion import MOTIONS
from sim.options.run import options_of
from sim.outcome import LIMIT
from sim.verdict import Verdict
from tests.helpers.fleets import (
    EAST,
    WEST,
    Ahead,
    Counting,
    closest,
    crowd,
    fleet_world,
    hall,
    passage,
)
from worldgen import generate
from worldgen.errors import InvalidParameter
from worldgen.render import draw_svg
from worldgen.world import Pose, Robot, Target


def far_apart():
    """Return a hall in which two robots drive along walls that are far from each other."""
    walls = hall(60, 30)
    walls[14:16] = True
    return fleet_world(
        walls,
        Robot(Pose(0.5, 0.5, EAST), Target(5.5, 0.9, 0.05)),
        Robot(Pose(5.5, 2.5, WEST), Target(0.5, 2.2, 0.05)),
    )


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize("controller", ["turn-right", "bug2", "random-walk", "vfh"])
def test_a_robot_far_from_others_drives_as_alone(motion, controller):
    world = far_apart()
    fleet = simulate(world, controller, motion=motion, steps=700)
    for number, together in enumerate(fleet.robots):
        seed = robot_seed(world, number, 0)
        alone = simulate(
            world.alone(number + 1), controller, motion=motion, steps=together.steps, seed=seed
        )
        assert together.steps > 100
        assert together.trace_digest == alone.trace_digest
        assert (together.path_length, together.collisions) == (alone.path_length, alone.collisions)


@pytest.mark.parametrize("seed", range(12))
def test_no_two_robots_ever_overlap(seed):
    world = crowd(np.random.default_rng(seed))
    controller = ["turn-right", "random-walk", "bug2", Ahead][seed % 4]
    episode = simulate(world, controller, steps=300, seed=seed, record=True)
    assert episode.collisions > 0
    for number, robot in enumerate(world.robots):
        for other in range(number):
            far = robot.radius + world.robots[other].radius
            own = episode.robots[number].trace
            assert closest(own, episode.robots[other].trace) >= far - 1e-12


@pytest.mark.parametrize("seed", range(6))
def test_renumbering_the_robots_changes_only_their_numbers(seed):
    rng = np.random.default_rng(100 + seed)
    world = crowd(rng)
    order = rng.permutation(len(world.robots))
    renumbered = fleet_world(world.walls, *(world.robots[number] for number in order))
    for controller in ("turn-right", "random-walk", Ahead):
        one = simulate(world, controller, steps=200, seed=seed)
        two = simulate(renumbered, controller, steps=200, seed=seed)
        assert (one.verdict, one.steps) == (two.verdict, two.steps)
        digests = [one.robots[number].trace_digest for number in order]
        assert digests == [robot.trace_digest for robot in two.robots]


def test_two_robots_that_meet_in_a_narrow_passage_are_a_proved_deadlock():
    world = passage()
    episode = simulate(world, Ahead, steps=2_000, record=True)
    assert episode.verdict == Verdict.DEADLOCK
    evidence = episode.evidence
    assert (evidence.waiting, evidence.moving, evidence.parked) == ((1, 2), (), ())
    assert evidence.blocked == ((1, 2), (2, 1))
    assert episode.steps == evidence.entry + evidence.period
    assert [one.verdict for one in episode.robots] == [Verdict.DEADLOCK] * 2
    gap = closest(episode.robots[0].trace, episode.robots[1].trace)
    assert 0.14 <= gap < 0.1402


def test_pictures_show_which_robot_blocks_which():
    world = passage()
    episode = simulate(world, Ahead, steps=2_000, record=True)
    assert (episode.blockers(1), episode.blockers(2)) == ((2,), (1,))
    assert [trail.blocked_by for trail in trails_of(episode, world)] == [(2,), (1,)]
    drawn = drawn_robots(episode, world.cell_size)
    assert [one["run"]["blocked_by"] for one in (drawn, *drawn["others"])] == [[2], [1]]
    # The legend names the arrows, of which there are two.
    blocked = draw_svg(world, trail=trails_of(episode, world))
    moving = simulate(world, "turn-right", steps=4_000, record=True)
    assert moving.verdict == Verdict.LIVELOCK and not moving.blockers(1)
    assert "is blocked by" in blocked
    assert "is blocked by" not in draw_svg(world, trail=trails_of(moving, world))


def test_robots_that_go_back_and_forth_are_a_proved_livelock():
    episode = simulate(passage(), "turn-right", steps=4_000)
    assert episode.verdict == Verdict.LIVELOCK
    assert episode.evidence.moving == (1, 2)


def test_a_robot_that_a_parked_one_shuts_out_is_starved():
    world = passage()
    first, second = world.robots
    world = fleet_world(
        world.walls, dataclasses.replace(first, target=Target(1.0, 0.2, 0.05)), second
    )
    episode = simulate(world, Ahead, steps=4_000)
    assert episode.verdict == Verdict.STARVED
    assert episode.evidence.waiting == (2,)
    assert episode.evidence.parked == ((1, episode.robots[0].steps),)
    assert [one.verdict for one in episode.robots] == [Verdict.REACHED, Verdict.STARVED]


def test_a_counter_that_only_grows_is_never_a_proof():
    episode = simulate(passage(), Counting, steps=4_000)
    assert episode.verdict == Verdict.STALLED


class Hidden(Ahead):
    """Keeps a counter outside its memory."""

    def __init__(self):
        self.steps = 0

    def act(self, seen, memory):
        self.steps += 1
        command, memory = super().act(seen, memory)
        return (command if self.steps < 3_000 else command._replace(speed=-1.0)), memory


def test_robots_that_hide_their_memory_are_not_proved_to_be_stuck():
    assert simulate(passage(), Hidden, steps=4_000).verdict in (Verdict.STALLED, Verdict.TIMEOUT)


@pytest.mark.parametrize("controller", [Ahead, "turn-right"])
def test_a_joint_loop_repeats_for_two_periods(controller):
    world = passage()
    episode = simulate(world, controller, steps=4_000)
    entry = episode.evidence.entry
    period = episode.evidence.period
    options = options_of(world, {"steps": entry + 2 * period})
    run = FleetRun(world, [controller_of(controller)] * 2, [options] * 2)
    whole = run.run(entry + 2 * period, find_loop=False, record=True)
    for one in whole.members:
        states = one.trace.states
        assert np.array_equal(states[entry : entry + period + 1], states[entry + period :])


@pytest.mark.parametrize("seed", [1, 11, 20, 24])
def test_loops_apart_from_each_other_are_proved_as_if_they_were_driven(seed):
    world = generate("doorway", seed=seed, robots=2)
    proved = simulate(world, "turn-right")
    driven = simulate(world, "turn-right", steps=1_000_000)
    assert driven.evidence.periods is None
    assert dataclasses.replace(proved.evidence, periods=None) == driven.evidence
    assert (proved.verdict, proved.evidence.period) == (Verdict.LIVELOCK, driven.evidence.period)
    assert driven.evidence.period > options_of(world, {}).steps


class Shuttle:
    """Drives ahead and back; how long that takes depends on its top speed."""

    def reset(self):
        return (0.0,)

    def act(self, seen, memory):
        half = round(100.0 * seen.top_speed)
        speed = seen.top_speed if memory[0] < half else -seen.top_speed
        return Command(0.3 * speed), ((memory[0] + 1.0) % (2 * half),)


def shuttles(gap):
    """Return a hall where two robots go back and forth with different periods, ``gap`` m apart."""
    return fleet_world(
        hall(40, 20),
        Robot(Pose(0.5, 0.6, EAST), Target(3.0, 0.3, 0.05), speed=1.01),
        Robot(Pose(0.5, 0.6 + gap, EAST), Target(3.0, 1.7, 0.05), speed=1.03),
    )


def test_robots_with_periods_of_their_own_never_come_near_each_other():
    episode = simulate(generate("doorway", seed=1, robots=2), "turn-right")
    periods = dict(episode.evidence.periods)
    assert periods.keys() == {1, 2}
    assert math.lcm(*periods.values()) == episode.evidence.period
    assert episode.steps == episode.evidence.entry + max(periods.values())


def test_loops_of_robots_that_could_sense_each_other_are_driven_together():
    world = generate("doorway", seed=1, robots=2)
    apart = simulate(world, "turn-right", neighbour_range=0.5)
    sensed = simulate(world, "turn-right", neighbour_range=4.0)
    assert apart.evidence.periods
    assert sensed.evidence == dataclasses.replace(apart.evidence, periods=None)
    assert sensed.steps == sensed.evidence.entry + sensed.evidence.period


def test_loops_of_a_python_class_are_proved_apart():
    episode = simulate(shuttles(0.5), Shuttle, steps=2_000)
    assert episode.verdict == Verdict.LIVELOCK
    assert episode.evidence.periods == ((1, 202), (2, 206))
    assert episode.evidence.period == 101 * 206


def test_a_python_class_must_show_two_periods():
    world = shuttles(0.5)
    enough = simulate(world, Shuttle, steps=2_000).evidence.entry + 2 * 206
    assert simulate(world, Shuttle, steps=enough).verdict == Verdict.LIVELOCK
    assert simulate(world, Shuttle, steps=enough - 1).verdict != Verdict.LIVELOCK


@pytest.mark.gate
def test_loops_of_robots_that_could_touch_are_driven_together():
    evidence = simulate(shuttles(0.15), Shuttle, steps=2_000).evidence
    assert (evidence.periods, evidence.period) == (None, 101 * 206)


def test_all_robots_that_arrive_are_reached():
    world = far_apart()
    episode = simulate(world, Ahead, steps=2_000)
    assert episode.verdict == Verdict.REACHED
    assert episode.steps == max(one.steps for one in episode.robots)
    assert all(one.verdict == Verdict.REACHED for one in episode.robots)


def test_a_parked_robot_stays_an_obstacle():
    walls = hall()
    world = fleet_world(
        walls,
        Robot(Pose(1.0, 1.0, EAST), Target(1.3, 1.0, 0.05)),
        Robot(Pose(0.3, 1.0, EAST), Target(2.0, 1.0, 0.05)),
    )
    episode = simulate(world, Ahead, steps=2_000, record=True)
    assert episode.verdict == Verdict.STARVED
    assert closest(episode.robots[0].trace, episode.robots[1].trace) >= 0.14


def test_robots_that_jump_through_each_other_collide_under_endpoint():
    fast = {"radius": 0.05, "speed": 20.0}
    world = fleet_world(
        hall(),
        Robot(Pose(1.0, 1.0, EAST), Target(3.0, 1.0, 0.05), **fast),
        Robot(Pose(1.4, 1.0, WEST), Target(0.3, 1.0, 0.05), **fast),
    )
    assert simulate(world, Ahead, steps=100).verdict != Verdict.COLLISION
    episode = simulate(world, Ahead, motion="endpoint", steps=100)
    assert episode.verdict == Verdict.COLLISION
    assert episode.evidence.robots == (1, 2)


def test_the_evidence_names_every_pair_of_a_crowd_that_block_each_other():
    # Every robot would jump to the middle of the circle, so all pairs are in each other's way.
    count = 12
    angles = [math.tau * k / count for k in range(count)]
    ways = [(math.cos(angle), math.sin(angle)) for angle in angles]
    near = 0.3  # m, a step at 20 m/s
    robots = [
        Robot(Pose(1.5 - near * x, 1.5 - near * y), Target(1.5 + x, 1.5 + y, 0.02), 0.05, 20.0)
        for x, y in ways
    ]
    episode = simulate(fleet_world(hall(30, 30), *robots), Ahead, motion="endpoint", steps=100)
    assert episode.verdict == Verdict.DEADLOCK
    assert episode.evidence.blocked == tuple(itertools.permutations(range(1, count + 1), 2))


def test_of_several_controllers_each_drives_its_robot():
    world = far_apart()
    mixed = simulate(world, {1: "bug2", 2: Ahead}, steps=2_000)
    alike = simulate(world, "bug2", steps=2_000)
    other = simulate(world, Ahead, steps=2_000)
    assert mixed.robots[0].trace_digest == alike.robots[0].trace_digest
    assert mixed.robots[1].trace_digest == other.robots[1].trace_digest


@pytest.mark.parametrize(
    ("controllers", "code"),
    [
        ({1: "bug2"}, "robot-without-controller"),
        ({1: "bug2", 2: "bug2", 3: "bug2"}, "no-such-robot"),
        ({0: "bug2", 2: "bug2"}, "no-such-robot"),
    ],
)
def test_robots_and_controllers_must_fit_each_other(controllers, code):
    with pytest.raises(InvalidParameter) as caught:
        simulate(far_apart(), controllers)
    assert caught.value.code == code


def test_the_thesis_motion_is_for_one_robot():
    with pytest.raises(InvalidParameter) as caught:
        simulate(far_apart(), "turn-right", motion="stepped")
    assert caught.value.code == "motion-for-one-robot"


def recorded(*robots):
    """Return outcomes of robots whose whole state is one number, at places of their own."""
    return [
        SimpleNamespace(
            ending=LIMIT,
            steps=len(states) - 1,
            trace=SimpleNamespace(
                states=np.array(states, np.uint64)[:, np.newaxis],
                x=np.full(len(states), float(place)),
                y=np.zeros(len(states)),
            ),
        )
        for place, states in robots
    ]


def test_robots_near_each_other_have_the_period_of_their_first_joint_return():
    # The first robot's own state recurs every three steps at the end, and its path every twenty.
    path = [*range(10, 21), 1, 2, 3, 1, 2, 3, 1, 2, 3]
    first = (0.0, path * 10)
    second = (0.1, [k % 4 for k in range(200)])
    third = (9.0, [k % 5 for k in range(200)])
    reaches = {(0, 1): 1.0, (0, 2): 1.0, (1, 2): 1.0}
    for repeats in (1, 2):
        loops = separate_loops(recorded(first, second, third), reaches, 0, repeats=repeats)
        assert (loops.periods, loops.are_shown) == ({0: 20, 1: 20, 2: 5}, True)
        assert loops.joint_period == 20


@pytest.mark.parametrize("seed", range(4))
def test_a_joint_loop_is_the_first_return_of_the_joint_state(seed):
    world = generate("junction", seed, robots=3)
    episode = simulate(world, "turn-right")
    evidence = episode.evidence
    own = dict(evidence.periods or [(number, evidence.period) for number in evidence.waiting])
    traces = fleet_traces(
        world, "turn-right", options_of(world, {}), evidence.entry + 2 * max(own.values())
    )
    assert check_fleet(world, traces, episode.verdict, evidence, MOTIONS.get("swept")) == ""
    twice = dataclasses.replace(
        evidence,
        period=2 * evidence.period,
        periods=tuple((number, 2 * period) for number, period in own.items()),
    )
    traces = fleet_traces(
        world, "turn-right", options_of(world, {}), evidence.entry + 4 * max(own.values())
    )
    reason = check_fleet(world, traces, episode.verdict, twice, MOTIONS.get("swept"))
    assert "return to their states after" in reason
