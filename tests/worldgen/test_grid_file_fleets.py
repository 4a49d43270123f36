"""The .grid file for several robots: canonical, strict, and never written for one."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from tests.helpers.grid_strategies import fleets_with_everything
from tests.helpers.raising import check_says, raises
from worldgen.domain import MAX_ROBOTS
from worldgen.errors import FormatError, InvalidWorld
from worldgen.files.grid import dumps, loads
from worldgen.world import Cut, JointWitness, Pose, Robot, Target, Witness, World

GOOD = """%worldgen-grid 2
cell_size = 0.1

[[robot]]
start = [0.15, 0.15, 0.0]
target = [0.55, 0.15, 0.05]
radius = 0.07

[[robot]]
start = [0.55, 0.35, 3.0]
target = [0.15, 0.35, 0.05]
radius = 0.04
speed = 1.5

[provenance]
family = "doorway"
version = 1
seed = 7

[certificate]
kind = "witness"
clearance = [0.1, 0.08]
%cells
.......
.......
.......
.......
.......
%witness
1 0.0 0.15 0.15
1 1.0 0.55 0.15
2 0.0 0.55 0.35
2 1.0 0.15 0.35
%end
"""
ROBOTS = GOOD[GOOD.index("[[robot]]") : GOOD.index("[provenance]")]
CUT = GOOD.replace('"witness"\nclearance = [0.1, 0.08]', '"cut"\nrobot = 2\nclearance = 0.03')
CUT = CUT[: CUT.index("%witness")] + "%cut\n1 1\n2 2\n%end\n"
INLINE = GOOD.replace(
    ROBOTS,
    "robot = [{ start = [0.1, 0.1, 0], target = [0.5, 0.1, 0.1], radius = 0.04 },\n"
    "  { start = [0.5, 0.3, 0], target = [0.1, 0.3, 0.1], radius = 0.04 }]\n",
)

# name: (old, new, line, part of the message)
FAULTS = {
    "no-robots": (ROBOTS, "", 12, {"code": "missing-key", "key": "robot"}),
    "not-tables": ("[[robot]]", "[robot]", 9, {"code": "not-toml"}),
    "speed-above": (
        "cell_size = 0.1",
        "cell_size = 0.1\nrobot_speed = 1",
        3,
        {"code": "wrong-place", "key": "robot_speed", "own": "speed"},
    ),
    "unknown": ("speed =", "sped =", 13, {"code": "unknown-name", "name": "sped", "near": "speed"}),
    "no-radius": (
        "radius = 0.04\n",
        "",
        9,
        {"code": "missing-key", "place": "[[robot]] number 2", "key": "radius"},
    ),
    "no-target": (
        "target = [0.55, 0.15, 0.05]\n",
        "",
        4,
        {"code": "missing-key", "place": "[[robot]] number 1", "key": "target"},
    ),
    "two-numbers": ("[0.55, 0.35, 3.0]", "[0.55, 0.35]", 10, {"code": "wrong-type"}),
    "text": ("speed = 1.5", 'speed = "1.5"', 13, {"code": "wrong-type", "what": "robot 2 speed"}),
    "infinite": ("speed = 1.5", "speed = inf", 13, {"code": "not-finite"}),
    "negative": ("radius = 0.04", "radius = -1", 12, {"code": "not-positive"}),
    "flat-target": ("[0.15, 0.35, 0.05]", "[0.15, 0.35, 0.0]", 11, {"code": "not-positive"}),
    "huge": ("speed = 1.5", "speed = 1e300", 13, {"code": "out-of-range"}),
    "huge-target": (
        "[0.15, 0.35, 0.05]",
        "[0.15, 0.35, 1e300]",
        11,
        {"code": "out-of-range", "name": "robot 2 target radius"},
    ),
    "outside": (
        "start = [0.55, 0.35, 3.0]",
        "start = [0.55, 9.0, 3.0]",
        10,
        {"code": "outside-grid", "name": "robot 2 start"},
    ),
    "overlap": (
        "[0.55, 0.35, 3.0]",
        "[0.15, 0.25, 3.0]",
        9,
        {"code": "robots-overlap", "first": 1, "second": 2},
    ),
    "exclude": (
        "[0.15, 0.35, 0.05]",
        "[0.55, 0.15, 0.05]",
        9,
        {"code": "targets-exclude", "first": 1, "second": 2},
    ),
    "mark": (".......\n%witness", "S......\n%witness", 28, {"code": "conflict", "letter": "S"}),
    "one-clearance": ("[0.1, 0.08]", "0.1", 22, {"code": "wrong-type"}),
    "three-clearances": ("[0.1, 0.08]", "[0.1, 0.08, 0.1]", 22, {"code": "wrong-type"}),
    "text-clearance": ("[0.1, 0.08]", '[0.1, "a"]', 22, {"code": "wrong-type"}),
    "robot-of-witness": (
        'kind = "witness"',
        'kind = "witness"\nrobot = 1',
        22,
        {"code": "conflict"},
    ),
    "three-words": ("1 1.0 0.55 0.15", "1.0 0.55 0.15", 31, {"code": "wrong-form"}),
    "robot-word": (
        "2 0.0 0.55",
        "b 0.0 0.55",
        32,
        {"code": "wrong-form", "field": "robot", "word": "b"},
    ),
    "robot-0": ("1 0.0", "0 0.0", 30, {"code": "not-sorted", "robot": 0}),
    "robot-2-first": (
        "1 0.0 0.15 0.15\n1 1.0",
        "2 0.0 0.15 0.15\n2 1.0",
        30,
        {"code": "not-sorted"},
    ),
    "robot-3": ("2 1.0", "3 1.0", 33, {"code": "not-sorted", "robot": 3, "last": 2}),
    "huge-robot": ("2 1.0", "9223372036854775807 1.0", 33, {"code": "not-sorted"}),
    "back-to-1": ("2 1.0", "1 1.0", 33, {"code": "not-sorted", "robot": 1}),
    "no-robot-2": (
        "2 0.0 0.55 0.35\n2 1.0 0.15 0.35\n",
        "",
        31,
        {"code": "missing-section", "robot": 2},
    ),
    "no-points": (
        GOOD[GOOD.index("1 0.0") : GOOD.index("%end")],
        "",
        29,
        {"code": "missing-section"},
    ),
}
CUT_FAULTS = {
    "no-robot": ("robot = 2\n", "", 20, {"code": "missing-key", "key": "robot"}),
    "robot-0": ("robot = 2", "robot = 0", 22, {"code": "out-of-range", "last": 2}),
    "robot-3": ("robot = 2", "robot = 3", 22, {"code": "out-of-range", "robot": 3}),
    "text": ("robot = 2", 'robot = "2"', 22, {"code": "wrong-type"}),
    "list": ("clearance = 0.03", "clearance = [0.03]", 23, {"code": "wrong-type"}),
}


def complaint(text):
    with pytest.raises(FormatError) as caught:
        loads(text.encode())
    return caught.value


FIRST = Robot(Pose(0.15, 0.15), Target(0.55, 0.15, 0.05))


def small(**changes):
    return replace(
        World(
            np.zeros((5, 7), bool),
            robots=(FIRST, Robot(Pose(0.55, 0.35), Target(0.15, 0.35, 0.05))),
        ),
        **changes,
    )


@given(fleets_with_everything())
def test_reading_what_was_written_gives_an_equal_world_and_equal_bytes(world):
    data = dumps(world)
    assert data.startswith(b"%worldgen-grid 2\n")
    assert loads(data) == world
    assert dumps(loads(data)) == data


def test_the_texts_that_are_spoilt_below_are_canonical():
    assert [dumps(loads(text.encode())).decode() for text in (GOOD, CUT)] == [GOOD, CUT]
    assert len(loads(INLINE.replace("[0.1, 0.08]", "[0.1, 0.1]").encode()).robots) == 2


def test_a_file_without_others_is_of_version_1():
    alone = loads(GOOD.encode())
    assert dumps(alone.alone(1)).startswith(b"%worldgen-grid 1\n")


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_has_its_line_and_its_message(name):
    old, new, line, expected = FAULTS[name]
    assert old in GOOD
    error = complaint(GOOD.replace(old, new, 1))
    assert error.line == line, str(error)
    check_says(error, **expected)


@pytest.mark.parametrize("name", CUT_FAULTS)
def test_a_fault_in_a_cut_has_its_line_and_its_message(name):
    old, new, line, expected = CUT_FAULTS[name]
    assert old in CUT
    error = complaint(CUT.replace(old, new, 1))
    assert error.line == line, str(error)
    check_says(error, **expected)


def test_one_plain_robot_in_version_2_is_refused():
    begin = GOOD.index("[[robot]]\nstart = [0.55")
    one = GOOD[:begin] + GOOD[GOOD.index("[provenance]") :]
    check_says(complaint(one), "one-robot", line=4)


def test_robot_tables_in_version_1_are_refused():
    check_says(complaint(GOOD.replace("grid 2", "grid 1", 1)), "other-version", line=4)


def test_a_fault_in_an_inline_list_has_the_line_of_the_list():
    error = complaint(INLINE.replace("radius = 0.04 }]", "radius = -1 }]"))
    check_says(error, "not-positive", line=4)


def test_a_header_full_of_robots_is_refused_in_one_message():
    table = "[[robot]]\nstart = [{x}, 0.15, 0.0]\ntarget = [0.55, 0.15, 0.05]\nradius = 1e-7\n"
    tables = "".join(table.format(x=k / 20000) for k in range(MAX_ROBOTS + 1))
    text = GOOD.replace(ROBOTS, tables).replace(
        '[certificate]\nkind = "witness"\nclearance = [0.1, 0.08]\n', ""
    )
    text = text[: text.index("%witness")] + "%end\n"
    check_says(complaint(text), "too-many-robots", line=4, most=MAX_ROBOTS)


@pytest.mark.parametrize(
    "proof",
    [
        Witness([0.0], [0.15], [0.15], 0.1),
        JointWitness((Witness([0.0], [0.15], [0.15], 0.1),)),
        Cut([[0, 0]], 0.01, robot=3),
        Cut([[0, 0]], 0.01, robot=0),
    ],
    ids=["witness", "short", "cut-3", "cut-0"],
)
def test_a_certificate_for_another_number_of_robots_is_refused(proof):
    with raises(InvalidWorld, "wrong-certificate", count=2):
        small(certificate=proof)


def test_a_joint_witness_of_one_robot_is_refused():
    path = Witness([0.0], [0.15], [0.15], 0.1)
    with raises(InvalidWorld, "wrong-certificate", count=1):
        small(robots=(FIRST,), certificate=JointWitness((path,)))


def test_a_path_without_points_is_refused():
    with raises(InvalidWorld, "empty", number=1):
        JointWitness((Witness([], [], [], 0.1),))


def test_robots_may_touch_at_the_start_and_no_more():
    # 0.14 m is 1433.6 lattice units. The simulator rounds these two starts to 1433 units apart.
    touching = Robot(Pose(0.16, 0.15), Target(0.15, 0.35, 0.05))
    with raises(InvalidWorld, "robots-overlap"):
        small(start=Pose(0.02, 0.15), robots=(FIRST, touching))
    exact = Robot(Pose(0.35, 0.15), Target(0.15, 0.35, 0.05), radius=0.1)
    assert len(small(robot_radius=0.1, robots=(FIRST, exact)).robots) == 2
    with raises(InvalidWorld, "robots-overlap"):
        small(robot_radius=0.1, robots=(FIRST, replace(exact, start=Pose(0.3499, 0.15))))


def test_targets_that_leave_just_enough_room_do_not_exclude_each_other():
    # Two centres in discs of 0.05 m whose centres are 0.04 m apart are 0.14 m apart at most.
    other = Robot(Pose(0.55, 0.35), Target(0.55, 0.19, 0.05))
    assert len(small(robots=(FIRST, other)).robots) == 2
    with raises(InvalidWorld, "targets-exclude", first=1, second=2):
        small(robots=(FIRST, replace(other, target=Target(0.55, 0.1899, 0.05))))
