"""Several robots in other programs' files: all of them, in order, or a refusal in one sentence."""

import math
from dataclasses import replace

import pytest

from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidParameter, InvalidWorld
from worldgen.files.grid import read_world, write_world
from worldgen.generation import generate
from worldgen.interop import (
    FORMATS,
    ImportedRobot,
    export_world,
    find_format,
    import_world,
    write_export,
)
from worldgen.interop.recognising import read_map_alone
from worldgen.interop.sidecar import with_sidecar
from worldgen.lattice import in_cells
from worldgen.reach import check_certificate

ABLE = ["irsim", "mjcf", "movingai", "pogema", "sdf"]


@pytest.fixture(scope="module")
def fleet():
    """Three robots, each with start and target in its own cells."""
    return generate("warehouse", 3, robots=3, robot_radius=0.04, size=20, aisle=1, shelf_depth=1)


def exported(world, name, tmp_path, file):
    """Return the main file of an export, written with all of its files except the sidecar."""
    export = export_world(world, name, file=file, sidecar=False)
    for beside, data in export.files.items():
        (tmp_path / beside).write_bytes(data)
    return tmp_path / file


def cells(world):
    """The cells of all starts and targets."""
    side = world.cell_size
    return [
        tuple(
            math.floor(in_cells(value, side))
            for value in (r.start.x, r.start.y, r.target.x, r.target.y)
        )
        for r in world.robots
    ]


def test_the_formats_that_take_several_robots_say_so():
    assert [name for name in sorted(FORMATS.names()) if FORMATS.get(name).robots] == ABLE


@pytest.mark.parametrize(
    "name",
    sorted(
        name for name in FORMATS.names() if FORMATS.get(name).write and not FORMATS.get(name).robots
    ),
)
def test_every_other_format_refuses_several_robots_or_is_a_map(fleet, name):
    known = FORMATS.get(name)
    if "start" in known.holds:
        with raises(InvalidWorld, "several-robots", format=name, count=3):
            export_world(fleet, name)
    else:
        assert any("3 robots" in note for note in export_world(fleet, name).notes)


@pytest.mark.parametrize(
    ("name", "word", "times"),
    [
        ("irsim", "goal_threshold", 3),
        ("mjcf+robot", "<actuator>", 1),
        ("mjcf+robot", '_turn" ', 3),
        ("sdf+robot", '<model name="robot', 3),
        ("sdf+robot", '<model name="target', 3),
    ],
)
def test_an_export_has_a_part_for_each_robot(fleet, name, word, times):
    data = export_world(fleet, name).data.decode()
    assert data.count(word) == times


def test_a_scenario_comes_back_with_all_its_robots(fleet, tmp_path):
    path = exported(fleet, "movingai", tmp_path, "w.map")
    robot = ImportedRobot(scenario=tmp_path / "w.map.scen", robots=3)
    found = import_world(path, robot)
    assert cells(found.world) == cells(fleet)
    assert check_certificate(found.world).valid
    assert found.world.provenance.params["robots"] == 3


def test_more_robots_than_a_scenario_has_are_refused(fleet, tmp_path):
    path = exported(fleet, "movingai", tmp_path, "w.map")
    with raises(FormatError, "out-of-range", row=4, rows=3):
        import_world(path, ImportedRobot(scenario=tmp_path / "w.map.scen", robots=5))
    with raises(InvalidParameter, "conflict", robots=2):
        import_world(path, ImportedRobot(robots=2))


def test_a_pogema_map_comes_back_with_all_its_agents(fleet, tmp_path):
    path = exported(fleet, "pogema", tmp_path, "w.pogema")
    found = import_world(path, name="pogema+agents=all")
    assert cells(found.world) == cells(fleet)
    assert check_certificate(found.world).valid
    alone = import_world(path)
    assert not alone.world.is_fleet and "agents=all" in alone.notes[0]


def test_agents_that_share_a_cell_are_refused(fleet):
    first, second, *_ = fleet.robots
    second = replace(second, target=replace(fleet.target, radius=1.0))
    with raises(InvalidWorld, "cells-taken", number=2):
        export_world(replace(fleet, robots=(first, second), certificate=None), "pogema")


def test_an_agent_without_a_target_is_refused(tmp_path):
    path = tmp_path / "w.pogema"
    path.write_text("a..A\n.b..\n....\n")
    with raises(FormatError, "missing-target", letter="b"):
        import_world(path, name="pogema+agents=all")


def test_a_grid_file_keeps_its_robots_when_it_is_imported(fleet, tmp_path):
    write_world(fleet, tmp_path / "w.grid")
    done = worldgen("import", str(tmp_path / "w.grid"), "--out", str(tmp_path / "v.grid"))
    assert done.code == 0
    assert read_world(tmp_path / "v.grid").robots == fleet.robots


def test_robots_that_overlap_are_one_line_and_code_2(tmp_path):
    path = tmp_path / "w.pogema"
    path.write_text("a..A\nb..B\n....\n")
    done = worldgen(
        "import", str(path), "--from", "pogema+agents=all", "--radius", "0.08",
        "--out", str(tmp_path / "v.grid"),
    )  # fmt: skip
    assert done.code == 2
    assert "overlap" in done.err


def facts(world):
    """Start, heading, target, radii and speed of every robot."""
    return [
        (*vars_of(robot.start), *vars_of(robot.target), robot.radius, robot.speed)
        for robot in world.robots
    ]


def vars_of(item):
    """The values of a pose or a target, numbers to a nanometre."""
    values = (getattr(item, name) for name in item.__slots__)
    return tuple(round(value, 9) if isinstance(value, float) else value for value in values)


def test_every_robot_comes_back_with_its_sidecar(tmp_path):
    world, path = pogema_with_sidecar(tmp_path)
    found = import_world(path, name="pogema+agents=all")
    assert facts(found.world) == facts(world)
    assert found.decision.result == "reachable"


def pogema_with_sidecar(tmp_path):
    """The doorway's files for POGEMA, and the world."""
    world = generate("doorway", 5, robots=3)
    write_export(export_world(world, "pogema", file="w.pogema"), tmp_path)
    return world, tmp_path / "w.pogema"


def test_the_sidecars_values_follow_the_letter_of_an_agent(tmp_path):
    world, path = pogema_with_sidecar(tmp_path)
    found = import_world(path, name="pogema+agent=b")
    assert facts(found.world) == facts(world)[1:2]
    all_of_them = import_world(path, name="pogema+agents=all+agent=b")
    first, second, third = facts(world)
    assert facts(all_of_them.world) == [second, first, third]


def test_an_agent_that_was_moved_in_the_file_is_where_the_file_has_it(tmp_path):
    world, path = pogema_with_sidecar(tmp_path)
    drawing = path.read_text().replace("b", ".")
    at = drawing.index("....", drawing.index("a")) + 2
    path.write_text(drawing[:at] + "b" + drawing[at + 1 :])
    found = import_world(path, name="pogema+agents=all")
    expected = facts(world)
    moved = facts(found.world)[1]
    assert moved[:2] != expected[1][:2]
    assert (facts(found.world)[0], moved[3:]) == (expected[0], expected[1][3:])


def test_a_sidecar_of_one_robot_still_helps_and_says_what_it_lacks(tmp_path):
    world, path = pogema_with_sidecar(tmp_path)
    sidecar = path.with_name("w.pogema.worldgen.grid")
    alone = replace(read_world(sidecar), robots=world.robots[:1])
    write_world(alone, sidecar, force=True)
    found = import_world(path, name="pogema+agents=all")
    assert facts(found.world)[0] == facts(world)[0]
    assert any("no values of robots 2 to 3" in warning for warning in found.warnings)


def test_a_robot_that_is_missing_from_a_list_leaves_the_sidecars_robots_unknown(tmp_path):
    _, path = pogema_with_sidecar(tmp_path)
    alone, sidecar = read_map_alone(path, "pogema+agents=all")
    listed = replace(alone, robots=alone.robots[:2], numbers=())
    found = with_sidecar(listed, sidecar)
    assert found.robots == listed.robots
    assert "values of 3 robots, but the file has 2" in found.warnings[0]


def movingai_with_sidecar(tmp_path, robots):
    """The doorway's map and scenario, and the world."""
    world = generate("doorway", 5, robots=robots)
    path = write_export(export_world(world, "movingai", file="w.map"), tmp_path)[0]
    return world, path


@pytest.mark.parametrize("robots", [1, 3])
def test_a_maps_own_scenario_brings_what_the_sidecar_holds(tmp_path, robots):
    world, path = movingai_with_sidecar(tmp_path, robots)
    robot = ImportedRobot(scenario=tmp_path / "w.map.scen", robots=robots)
    found = import_world(path, robot)
    assert facts(found.world) == facts(world)
    assert found.radius_from == "from the file"


def test_the_sidecars_values_follow_the_row_of_a_scenario(tmp_path):
    world, path = movingai_with_sidecar(tmp_path, 3)
    robot = ImportedRobot(scenario=tmp_path / "w.map.scen", row=2, robots=2)
    assert facts(import_world(path, robot).world) == facts(world)[1:]


def test_a_row_of_an_exported_map_brings_the_robots_from_there(tmp_path):
    world, path = movingai_with_sidecar(tmp_path, 3)
    assert facts(import_world(path, ImportedRobot(row=3)).world) == facts(world)[2:]
    with raises(FormatError, "out-of-range", row=4, rows=3):
        import_world(path, ImportedRobot(row=4))


def test_another_scenario_does_not_get_the_sidecars_robots(tmp_path):
    _, path = movingai_with_sidecar(tmp_path, 3)
    other = (tmp_path / "w.map.scen").rename(tmp_path / "other.scen")
    found = import_world(path, ImportedRobot(scenario=other, robots=3))
    assert {robot.radius for robot in found.world.robots} == {0.04}
    assert not any("says" in note for note in found.notes)


def test_a_radius_that_is_given_is_every_robots(tmp_path):
    _, path = movingai_with_sidecar(tmp_path, 3)
    robot = ImportedRobot(scenario=tmp_path / "w.map.scen", robots=3, radius=0.06, speed=1.0)
    found = import_world(path, robot)
    assert {(one.radius, one.speed) for one in found.world.robots} == {(0.06, 1.0)}


ROBOT = "{kinematics: {name: diff}, state: [1, 1, 0], goal: [3, 3, 0]}"


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (f"world: {{height: 4, width: 4}}\nrobot:\n  - {ROBOT}\n  - {ROBOT}\n", "irsim"),
        (f"robot:\n  - {ROBOT}\n  - {ROBOT}\nworld: {{height: 4, width: 4}}\n", "irsim"),
        ("world:\n  height: 4\nenvironment:\n  wind: 1\n", "irsim"),
    ],
)
def test_yaml_files_are_recognised_by_their_own_keys(tmp_path, text, name):
    path = tmp_path / "w.yaml"
    path.write_text(text)
    assert find_format(path).name == name
