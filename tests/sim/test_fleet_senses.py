"""What robots sense of each other, in all kinds of controllers."""

import itertools
import json
import math
import sys

import numpy as np
import pytest

from sim import RobotOptions, simulate
from sim.controllers import CONTROLLERS, Command, CompiledController
from sim.controllers.base import Commands, Observation
from sim.controllers.programs.process import observation_line, read_command
from sim.verdict import Verdict
from tests.helpers.fleets import EAST, Ahead, fleet_world, hall
from worldgen import generate
from worldgen.errors import InvalidParameter
from worldgen.world import Pose, Robot, Target

FAR = Target(0.5, 1.7, 0.05)


def in_a_row():
    """Return a hall with a robot and two others, 0.5 m ahead of it and 0.8 m to its left."""
    return fleet_world(
        hall(),
        Robot(Pose(1.0, 0.5, math.pi / 2), FAR),
        Robot(Pose(1.0, 1.0, EAST), Target(3.5, 1.7, 0.05), radius=0.05),
        Robot(Pose(0.2, 0.5, EAST), Target(3.5, 0.3, 0.05)),
    )


class Keeping:
    """Stands still, and stores the result of ``look`` on its observation in its memory."""

    size = 1

    def reset(self):
        return (0.0,) * self.size

    def act(self, seen, memory):
        return Command(), tuple(self.look(seen, memory))


def memory_after(controller, steps, robot=0, **settings):
    """Return a robot's memory after some steps."""
    world = in_a_row()
    episode = simulate(world, controller, steps=steps, record=True, **settings)
    trace = episode.robots[robot].trace
    return trace.memory(trace.steps)


class Beams(Keeping):
    size = 4

    def look(self, seen, _memory):
        return seen.beams


def test_beams_see_other_robots():
    ahead, left, behind, right = memory_after(Beams, 1, beams=4)
    assert ahead == pytest.approx(0.5 - 0.05)
    assert left == pytest.approx(0.8 - 0.07)
    assert behind == pytest.approx(0.4)
    assert right == pytest.approx(2.9)


class Nearest(Keeping):
    size = 10

    def look(self, seen, _memory):
        return [number for one in seen.neighbours for number in one[:5]]


def test_neighbours_are_relative_to_the_robot_and_the_nearest_comes_first():
    found = memory_after(Nearest, 1, neighbour_range=2.0)
    assert found[:5] == pytest.approx([0.5, 0.0, -math.pi / 2, 0.0, 0.05], abs=1e-4)
    assert found[5:] == pytest.approx([0.0, 0.8, -math.pi / 2, 0.0, 0.07], abs=1e-4)


class Count(Keeping):
    def look(self, seen, _memory):
        return [len(seen.neighbours)]


@pytest.mark.parametrize(
    ("settings", "count"),
    [
        ({}, 0),
        ({"neighbour_range": 0.6}, 1),
        ({"neighbour_range": 2.0}, 2),
        ({"neighbour_range": 2.0, "neighbours": 1}, 1),
    ],
)
def test_only_robots_within_range_are_sensed(settings, count):
    assert memory_after(Count, 1, **settings) == [count]


class Speaking(Keeping):
    """Sends the number of the step, and stores the nearest neighbour's message."""

    size = 2

    def act(self, seen, memory):
        heard = seen.neighbours[0].message[0]
        return Command(message=(memory[0] + 1.0,)), (memory[0] + 1.0, heard)


def test_a_message_arrives_in_the_next_step():
    settings = {"neighbour_range": 2.0, "message": 1}
    assert list(memory_after(Speaking, 1, **settings)) == [1.0, 0.0]
    assert list(memory_after(Speaking, 7, **settings)) == [7.0, 6.0]


class SpeakingMany:
    """Does the same for many robots."""

    def reset(self):
        return (0.0, 0.0)

    def act_many(self, seen, memory):
        step = memory[:, 0] + 1.0
        heard = seen.neighbours[:, 0, 5]
        return Commands(0.0, 0.0, False, step[:, None]), np.column_stack((step, heard))


def test_a_vector_controller_hears_and_speaks_as_a_class_does():
    settings = {"neighbour_range": 2.0, "message": 1}
    assert list(memory_after(SpeakingMany, 7, **settings)) == [7.0, 6.0]


def test_a_controller_that_numba_compiles_hears_and_speaks_too():
    pytest.importorskip("numba")
    from sim.kernels import layout

    first = layout.OBS_SIZE + layout.NEIGHBOUR_MESSAGE
    message = layout.CMD_MESSAGE

    def act(observation, memory, command):
        memory[0] += 1.0
        memory[1] = observation[first]
        command[message] = memory[0]

    speaking = CompiledController("speaking", act, (0.0, 0.0))
    settings = {"neighbour_range": 2.0, "message": 1}
    assert list(memory_after(speaking, 7, **settings)) == [7.0, 6.0]


class Shouting(Keeping):
    def act(self, _seen, memory):
        return Command(message="loud"), memory


def test_a_message_that_is_not_numbers_breaks_the_contract():
    world = in_a_row()
    episode = simulate(world, Shouting, steps=5, neighbour_range=2.0, message=1)
    assert episode.verdict == Verdict.INVALID_COMMAND
    assert episode.evidence.robot == 1


class Saying(Keeping):
    """Sends the same message in every step."""

    def __init__(self, message):
        self.message = message

    def act(self, _seen, memory):
        return Command(message=self.message), memory


class SayingToMany:
    """Does the same for many robots."""

    def __init__(self, message):
        self.message = message

    def reset(self):
        return (0.0,)

    def act_many(self, seen, memory):
        return Commands(0.0, 0.0, False, [self.message] * len(memory)), memory


@pytest.mark.parametrize("form", [Saying, SayingToMany])
@pytest.mark.parametrize(
    ("message", "rule"),
    [
        ((1.0, 2.0, 3.0), "message-has-another-length"),
        ((1.0,), "message-has-another-length"),
        ((math.nan, 0.0), "message-is-not-finite"),
        ((0.0, -math.inf), "message-is-not-finite"),
    ],
)
def test_a_message_of_another_length_or_without_finite_numbers_breaks_a_rule(form, message, rule):
    episode = simulate(in_a_row(), form(message), steps=5, neighbour_range=2.0, message=2)
    assert episode.verdict == Verdict.INVALID_COMMAND
    assert episode.evidence.rule == rule
    assert episode.evidence.step == 1


@pytest.mark.parametrize("form", [Saying, SayingToMany])
@pytest.mark.parametrize("message", [(), (1.0, 2.0)])
def test_a_robot_may_send_all_numbers_or_none(form, message):
    episode = simulate(in_a_row(), form(message), steps=5, neighbour_range=2.0, message=2)
    assert episode.verdict == Verdict.DEADLOCK


def test_a_message_without_a_channel_breaks_the_rule_too():
    episode = simulate(in_a_row(), Saying((1.0,)), steps=5, neighbour_range=2.0)
    assert episode.evidence.rule == "message-has-another-length"


def test_a_controller_may_send_what_it_needs_although_the_run_allows_more():
    class Needing(Saying):
        needs = RobotOptions(message=1)

    settings = {"steps": 5, "neighbour_range": 2.0, "message": 3}
    assert simulate(in_a_row(), Needing((1.0,)), **settings).verdict == Verdict.DEADLOCK
    found = simulate(in_a_row(), Needing((1.0, 2.0)), **settings)
    assert found.verdict == Verdict.INVALID_COMMAND


def test_a_compiled_controller_that_sends_nan_gives_an_invalid_command():
    pytest.importorskip("numba")
    from sim.kernels import layout

    last = layout.CMD_MESSAGE + 1

    def act(observation, memory, command):
        memory[0] += 1.0
        if memory[0] == 3.0:
            command[last] = math.nan

    muttering = CompiledController("muttering", act, (0.0,))
    settings = {"steps": 9, "neighbour_range": 2.0, "record": True}
    episode = simulate(in_a_row(), muttering, message=2, **settings)
    assert episode.verdict == Verdict.INVALID_COMMAND
    assert (episode.evidence.rule, episode.evidence.step) == ("message-is-not-finite", 3)
    assert simulate(in_a_row(), muttering, message=1, **settings).verdict != episode.verdict


def test_a_message_of_a_vector_controller_that_is_not_numbers_breaks_the_contract():
    episode = simulate(in_a_row(), SayingToMany("loud"), steps=5, neighbour_range=2.0, message=1)
    assert episode.evidence.rule == "the-message-is-not-a-tuple-of-numbers"


def test_a_program_that_sends_too_many_numbers_gives_an_invalid_command(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(
        "import sys\n"
        "for line in sys.stdin:\n"
        "    if '\"reset\"' not in line:\n"
        '        print(\'{"speed": 0, "turn_rate": 0, "message": [1, 2, 3]}\', flush=True)\n'
    )
    settings = {"neighbour_range": 2.0, "message": 2, "steps": 5}
    episode = simulate(in_a_row(), f"cmd:{sys.executable} {file}", **settings)
    assert episode.evidence.rule == "message-has-another-length"


def test_a_program_gets_neighbours_only_if_there_are_some():
    alone = Observation.of(np.zeros(17))
    assert "neighbours" not in json.loads(observation_line(alone))
    answer = read_command(b'{"speed": 1, "turn_rate": 0, "message": [0.5]}')
    assert answer == Command(1.0, 0.0, False, (0.5,))


@pytest.mark.gate
def test_a_program_for_each_robot_hears_the_others(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(
        "from sim.controllers import Command\n"
        "class Robot:\n"
        "    def reset(self):\n"
        "        return (0.0,)\n"
        "    def act(self, seen, memory):\n"
        "        heard = seen.neighbours[0].message[0]\n"
        "        return Command(0.1 * heard, 0.0, message=(heard + 1.0,)), memory\n"
    )
    command = f"cmd:{sys.executable} -m sim.host {file}:Robot"
    settings = {"neighbour_range": 2.0, "message": 1, "steps": 12, "record": True}
    program = simulate(in_a_row(), command, **settings)
    alike = simulate(in_a_row(), f"{file}:Robot", **settings)
    for one, other in zip(program.robots, alike.robots, strict=True):
        assert np.array_equal(one.trace.x, other.trace.x)
        assert one.path_length > 0.0


def test_messages_belong_to_the_joint_state():
    class Talking(Ahead):
        """Never sends the same message twice, while it stands still forever."""

        needs = RobotOptions(neighbour_range=1.0, message=1)

        def act(self, seen, memory):
            heard = seen.neighbours[0].message[0] if seen.neighbours else 0.0
            return super().act(seen, memory)[0]._replace(message=(heard + 1.0,)), memory

    from tests.helpers.fleets import passage

    assert simulate(passage(), Talking, steps=4_000).verdict == Verdict.STALLED


def test_too_many_numbers_are_refused():
    with pytest.raises(InvalidParameter) as caught:
        RobotOptions(message=9)
    assert caught.value.code == "out-of-range"


class AllNearest(Keeping):
    """Stores the places of its neighbours, nearest first, and their number."""

    size = 41

    def look(self, seen, _memory):
        places = [number for one in seen.neighbours for number in one[:2]]
        return [len(seen.neighbours), *places, *[0.0] * (40 - len(places))]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("count", "reach"), [(3, 1.0), (12, 0.6), (40, 0.5), (90, 0.9), (90, 30.0)]
)
def test_the_neighbours_are_those_that_a_look_at_every_pair_finds(count, reach):
    rng = np.random.default_rng(count)
    # A crowd in a corner and a few robots far away, so that any grid has empty and full cells.
    spots = np.stack(np.meshgrid(np.arange(20), np.arange(20)), -1).reshape(-1, 2)
    near = rng.permutation(spots)[: count - 2] * 0.2 + 0.2 + rng.uniform(0, 0.04, (count - 2, 2))
    places = np.vstack((near, [[9.5, 0.5], [4.7, 9.7]]))
    world = fleet_world(
        hall(100, 100),
        *(
            Robot(Pose(*places[k], EAST), Target(*places[k - 1], 0.01), radius=0.07)
            for k in range(count)
        ),
    )
    episode = simulate(
        world, AllNearest, steps=1, record=True, neighbour_range=reach, neighbours=20
    )
    for k, robot in enumerate(episode.robots):
        memory = robot.trace.memory(robot.trace.steps)
        offsets = np.delete(places - places[k], k, axis=0)
        away = np.hypot(*offsets.T)
        order = np.argsort(away)[: min(20, int((away <= reach).sum()))]
        assert memory[0] == len(order)
        seen = np.reshape(memory[1:], (-1, 2))[: len(order)]
        assert np.hypot(*seen.T) == pytest.approx(away[order], abs=1e-3)


def test_mappers_that_share_their_maps_arrive_sooner():
    worlds = [generate("forest", seed, robots=6) for seed in range(12)]
    # A message of one number has no room for a place.
    alone, together = (
        [simulate(world, "team-mapper", steps=6000, **channel) for world in worlds]
        for channel in ({"message": 1}, {})
    )
    assert all(episode.verdict == "reached" for episode in (*alone, *together))
    assert sum(one.steps for one in together) < 0.9 * sum(one.steps for one in alone)
    touches = [
        sum(robot.collisions for episode in episodes for robot in episode.robots)
        for episodes in (alone, together)
    ]
    assert touches[1] < 0.9 * touches[0]


def test_a_mapper_alone_drives_like_one_of_a_team_that_says_nothing():
    world = generate("trap", 0, robots=2)
    runs = [simulate(world, "mapper"), simulate(world, "team-mapper", message=1)]
    assert [one.steps for one in runs[0].robots] == [one.steps for one in runs[1].robots]


def test_every_place_that_a_mapper_of_a_team_knows_is_on_a_wall():
    controller = CONTROLLERS.get("team-mapper")
    world = generate("trap", 0, robots=4)
    episode = simulate(world, "team-mapper", steps=400, record=True)
    solid = np.pad(world.walls, 1, constant_values=True)
    known = [
        controller.memory_map(robot.trace.memory(robot.steps)).nodes for robot in episode.robots
    ]
    for x, y in np.concatenate(known):
        around = [
            solid[
                math.floor(y / world.cell_size + dy) + 1, math.floor(x / world.cell_size + dx) + 1
            ]
            for dx in (-0.05, 0.05)
            for dy in (-0.05, 0.05)
        ]
        assert any(around), (x, y)

    # Robots know places that they have not touched.
    places = [set(map(tuple, points.tolist())) for points in known]
    assert any(one & other for one, other in itertools.combinations(places, 2))
