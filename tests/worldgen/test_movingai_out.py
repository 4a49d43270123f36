"""Writing MovingAI maps, and the scenario next to a map."""

import math

import pytest

from tests.helpers.drawn_worlds import drawn
from worldgen.generation import generate
from worldgen.interop import (
    ImportedRobot,
    export_world,
    import_world,
    read_map,
    read_scenario,
    write_export,
)

ROOM = "######\n#S...#\n##.#.#\n#...G#\n######"


def test_map_and_scenario_are_in_the_benchmarks_idiom():
    export = export_world(drawn(ROOM), "movingai", file="room.map")
    assert export.data.decode() == (
        "type octile\nheight 5\nwidth 6\nmap\n@@@@@@\n@....@\n@@.@.@\n@....@\n@@@@@@\n"
    )
    assert (
        export.files["room.map.scen"].decode()
        == "version 1\n1\troom.map\t6\t5\t1\t1\t4\t3\t5.00000000\n"
    )


def test_the_optimal_length_is_the_roots_sum_to_eight_decimals():
    open_room = "\n".join(["S......", *["......."] * 4, "....G.."])
    optimal = (
        export_world(drawn(open_room), "movingai").files["world.map.scen"].split()[-1].decode()
    )
    assert optimal == f"{1 + 4 * math.sqrt(2):.8f}"


def test_a_target_that_no_cells_lead_to_has_no_scenario():
    export = export_world(drawn("S#G"), "movingai")
    assert set(export.files) == {"world.map", "world.map.worldgen.grid"}
    assert any("no path of cells leads" in sentence for sentence in export.lost)


def test_start_and_goal_come_from_the_only_problem_beside_the_map(tmp_path):
    world = drawn(ROOM, radius=0.04)
    path = write_export(export_world(world, "movingai", sidecar=False), tmp_path)[0]
    again = import_world(path)
    assert again.world.start.x == world.start.x and again.world.target.y == world.target.y
    assert again.world.robot_radius == 0.04  # as with --scen
    assert any("the only problem in" in note for note in again.notes)


def test_of_several_problems_beside_the_map_none_is_taken(tmp_path):
    path = write_export(export_world(drawn(ROOM), "movingai", sidecar=False), tmp_path)[0]
    scenario = tmp_path / "world.map.scen"
    scenario.write_text(scenario.read_text() + scenario.read_text().splitlines()[1] + "\n")
    assert read_map(path).robot.start is None


def test_the_robots_of_an_exported_map_come_back_without_naming_its_scenario(tmp_path):
    world = generate("alley", 0, size=13)
    path = write_export(export_world(world, "movingai"), tmp_path)[0]
    assert import_world(path).world.robots == world.robots
    assert import_world(path, ImportedRobot(robots=1)).world.robots == world.robots[:1]
    # A start that the user gives is for a single robot.
    start = (world.start.x, world.start.y)
    assert len(import_world(path, ImportedRobot(start=start)).world.robots) == 1
    # The sidecar counts two robots; a file with another number of problems is not the exported one.
    scenario = tmp_path / "world.map.scen"
    scenario.write_text(scenario.read_text() + scenario.read_text().splitlines()[1] + "\n")
    assert len(import_world(path).world.robots) == 1


@pytest.mark.parametrize("text", ["version 1\n0\tm\t9\t9\t1\t1\t2\t2\t1.4\n", "no scenario"])
def test_a_problem_that_does_not_fit_the_map_is_passed_over_with_a_warning(tmp_path, text):
    path = write_export(export_world(drawn(ROOM), "movingai", sidecar=False), tmp_path)[0]
    (tmp_path / "world.map.scen").write_text(text)
    found = read_map(path)
    assert (
        found.robot.start is None
        and "world.map.scen next to the map was skipped" in found.warnings[0]
    )


def test_our_own_reader_of_scenarios_finds_the_same_cells(tmp_path):
    world = drawn(ROOM)
    write_export(export_world(world, "movingai"), tmp_path)
    problem = read_scenario(tmp_path / "world.map.scen", 1, 6, 5, 0.1)
    assert (problem.start, problem.goal) == (
        (world.start.x, world.start.y),
        (world.target.x, world.target.y),
    )
