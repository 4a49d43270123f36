"""Controllers whose memory is a bounded map: a graph of places, and a grid of goodness."""

from dataclasses import dataclass

import numpy as np
import pytest

from sim import Command, simulate
from sim.controllers import CONTROLLERS
from sim.controllers.library import topological as places
from sim.drawing.picture import remembered_at_the_end, trail_of
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import InvalidParameter, generate, render
from worldgen.families import cave, maze, rooms, trap
from worldgen.render.marks import hue
from worldgen.world import Pose, Target, World

WORLDS = [trap(3, size=24), rooms(101), cave(101), maze(5, size=20)]


def test_by_a_map_of_places_it_arrives_where_a_local_view_is_trapped():
    assert [simulate(world, "topological").verdict for world in WORLDS] == ["reached"] * 4
    assert simulate(WORLDS[0], "gestalt").verdict == "loop"


def test_with_little_memory_it_explores_the_same_part_again_and_that_is_proved():
    world = maze(3, size=24)
    assert simulate(world, "topological").verdict == "reached"
    episode = simulate(world, "topological+places=6", record=True)
    assert episode.verdict == "loop"
    controller = CONTROLLERS.get("topological+places=6")
    assert len(controller.memory) == places.PLACES + 6 * places.PLACE
    entry = episode.trace.memory(episode.evidence.entry)
    again = episode.trace.memory(episode.evidence.entry + episode.evidence.period)
    assert entry.tobytes() == again.tobytes()


@pytest.mark.parametrize("name", ["topological", "topological+places=12"])
def test_its_graph_is_bounded_and_joins_places_where_it_has_been(name):
    world = maze(3, size=24)
    episode = simulate(world, name, record=True)
    controller = CONTROLLERS.get(name)
    path = np.column_stack((episode.trace.x, episode.trace.y))
    most = int(controller.memory[places.MOST])
    seen = 0
    for step in range(0, episode.steps + 1, 20):
        shown = controller.memory_map(episode.trace.memory(step))
        assert len(shown.nodes) <= most
        seen = max(seen, len(shown.nodes))
        for point in shown.nodes:
            assert np.abs(path[: step + 1] - point).sum(axis=1).min() < 1e-9
        ends = shown.edges.reshape(-1, 2).tolist()
        assert all(end in shown.nodes.tolist() for end in ends)
    assert seen > 4 and len(shown.edges) >= len(shown.nodes) - 1


def test_a_link_is_known_at_both_of_its_ends():
    controller = CONTROLLERS.get("topological+places=9")
    episode = simulate(maze(3, size=24), controller, record=True, steps=900)
    for step in range(0, 900, 7):
        memory = episode.trace.memory(min(step, episode.steps))
        rows = memory[places.PLACES :].reshape(-1, places.PLACE)[: int(memory[places.COUNT])]
        links = [
            {((int(row[3]) >> (10 * slot)) & 1023) - 1 for slot in range(5)} - {-1} for row in rows
        ]
        for one, others in enumerate(links):
            assert all(one in links[other] for other in others)


def test_walls_are_bad_ground_and_the_floor_between_is_good():
    walls = np.zeros((12, 12), np.bool_)
    walls[:, 8] = True
    world = World(walls, Pose(0.4, 0.6, 0.0), Target(1.1, 0.6, 0.05))
    episode = simulate(world, "gestalt", record=True, steps=40)
    shown = CONTROLLERS.get("gestalt").memory_map(episode.trace.memory(episode.steps))
    middle_x = shown.degrees[:, [0, 2]].mean(axis=1)
    middle_y = shown.degrees[:, [1, 3]].mean(axis=1)
    inside = (middle_y > 0.3) & (middle_y < 0.9)
    good = shown.degrees[inside & (middle_x > 0.3) & (middle_x < 0.6), 4]
    bad = shown.degrees[inside & (np.abs(middle_x - 0.8) < 0.03), 4]
    assert len(good) > 20 and len(bad) > 5
    assert good.min() > bad.max()


def test_memory_is_a_number_that_a_user_can_set():
    sizes = {name: len(CONTROLLERS.get(f"gestalt{name}").memory) for name in ("", "+side=12")}
    assert sizes == {"": 7 + 134, "+side=12": 7 + 12}
    scenario = Scenario.parse("topological+places=16+slip=0.1+motion=endpoint")
    assert scenario.controller == "topological+places=16" and scenario.run.robot.slip == 0.1
    assert Scenario.parse(scenario.label("swept")) == scenario


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("topological+places=3", "out-of-range"),
        ("topological+places=many", "not-a-number"),
        ("topological+nodes=8", "unknown-name"),
        ("bug2+places=8", "unknown-name"),
    ],
)
def test_options_that_a_controller_has_not_are_refused(name, code):
    with raises(InvalidParameter, code):
        CONTROLLERS.get(name)


def test_a_typing_error_is_met_with_the_controller_s_own_option():
    with raises(InvalidParameter, "unknown-name") as caught:
        Scenario.parse("topological+place=8")
    assert caught.value.message.facts["near"] == "places"


@pytest.mark.parametrize("name", ["topological", "gestalt", "mapper", "bug2"])
def test_the_picture_of_a_run_shows_what_the_robot_remembers(tmp_path, name):
    world = tmp_path / "w.grid"
    worldgen("trap", "--seed", 3, "--size", 24, "--out", world)
    out = tmp_path / "run.svg"
    worldgen("run", world, "--controller", name, "--picture", out)
    assert hue("memory") in out.read_text() and "the robot&#x27;s own map" in out.read_text()


@dataclass(frozen=True)
class Forgetful:
    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        return Command(observation.top_speed), memory

    def memory_map(self, memory):
        raise ValueError("no map")


def test_a_memory_that_cannot_be_read_is_an_error_with_a_code():
    episode = simulate(generate("trap", 1), Forgetful(), record=True, steps=5)
    with raises(InvalidParameter, "code-failed"):
        remembered_at_the_end(episode, Forgetful())
    assert remembered_at_the_end(episode, CONTROLLERS.get("vfh")) is None
    assert hue("memory") not in render.draw_svg(generate("trap", 1), trail=trail_of(episode))
