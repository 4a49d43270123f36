"""Options that replace a world's robot: what they mean, and what a wrong one is answered."""

import dataclasses
import json

import pytest

from tests.helpers.command_line import worldgen
from tests.helpers.drawn_worlds import drawn
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.files.grid import read_world, write_world
from worldgen.reach import decide
from worldgen.render.caption import facts as caption_facts
from worldgen.robot import Drive
from worldgen.robot_overrides import RobotOverrides, describe_body, describe_goal, parse_footprint
from worldgen.world import Provenance, Robot

ROOM = "##########\n#S......G#\n#........#\n##########"
TWO_ROOMS = "##########\n#....#...#\n#.S..#.G.#\n#....#...#\n##########"
BOX = ((-0.31, -0.45), (0.31, -0.45), (0.31, 0.45), (-0.31, 0.45))


@pytest.fixture
def room(tmp_path):
    world = drawn(ROOM, radius=0.05)
    write_world(
        dataclasses.replace(world, certificate=decide(world).certificate), tmp_path / "w.grid"
    )
    return tmp_path / "w.grid"


def fleet():
    one = drawn(ROOM).robots[0]
    start = dataclasses.replace(one.start, y=one.start.y - 0.1)
    target = dataclasses.replace(one.target, y=one.target.y - 0.1)
    other = dataclasses.replace(one, start=start, target=target, radius=0.03)
    return dataclasses.replace(
        drawn(ROOM, radius=0.03), robots=(other, dataclasses.replace(one, radius=0.03))
    )


@pytest.mark.parametrize(
    ("text", "corners"),
    [
        ("0.62x0.9", BOX),
        (" 0.62 X 0.9 ", BOX),
        ("0.62x0.9@0.1", ((-0.21, -0.45), (0.41, -0.45), (0.41, 0.45), (-0.21, 0.45))),
        ("0.62x0.9@-0.1", ((-0.41, -0.45), (0.21, -0.45), (0.21, 0.45), (-0.41, 0.45))),
        ("-0.31,-0.45 0.31,-0.45 0.31,0.45 -0.31,0.45", BOX),
        ("[[-0.31, -0.45], [0.31, -0.45], [0.31, 0.45], [-0.31, 0.45]]", BOX),
        # Clockwise corners are turned around, and those on a straight side are left out.
        ("-0.31,-0.45 -0.31,0.45 0.31,0.45 0.31,0 0.31,-0.45", BOX),
    ],
)
def test_a_footprint_is_read_in_every_form(text, corners):
    assert parse_footprint(text) == corners


@pytest.mark.parametrize(
    ("words", "code", "corrected"),
    [
        (("--footprint", "0.3,0.2 -0.3,-0.2"), "wrong-footprint", "--footprint 0.62x0.9"),
        (
            ("--footprint", "0,0 1,0 1,1 0.5,0.2 0,1"),
            "wrong-footprint",
            "--footprint '0,0 1,0 1,1 0,1'",
        ),
        (("--footprint", "0,0 1,1 1,0 0,1"), "wrong-footprint", "--footprint '0,0 1,0 1,1 0,1'"),
        (("--footprint", "0,0 1,1 2,2"), "wrong-footprint", "--footprint 0.62x0.9"),
        (("--footprint", "0x0.9"), "not-positive", "--footprint 0.62x0.9"),
        (("--footprint", "-0.62x0.9"), "not-positive", "--footprint 0.62x0.9"),
        (("--footprint", "0.62 by 0.9 m"), "wrong-form", "--footprint 0.62x0.9"),
        (("--footprint", "0.62"), "wrong-form", "--footprint 0.62x0.9"),
        (("--footprint", "1e400x1"), "not-finite", "--footprint 0.62x0.9"),
        (("--footprint", "100x100"), "out-of-range", ""),
        (("--target-radius", "0"), "", "--target-radius 1"),
        (("--target-radius", "-0.25"), "", "--target-radius 1"),
        (("--target-radius", "nan"), "not-finite", ""),
        (("--target-radius", "1e9"), "out-of-range", ""),
        (("--target-heading", "1:-0.1"), "below-minimum", ""),
        (("--target-heading", "north"), "wrong-form", ""),
        (("--waypoints", "1.2;0.4"), "wrong-form", "--waypoints 1.2,0.4"),
        (("--waypoints", "there"), "wrong-form", ""),
        (("--arrival", "stopp"), "unknown-name", "--arrival stop"),
        (("--arrival", "stop:-1"), "below-minimum", ""),
        (("--arrival", "step:1"), "wrong-form", "--arrival step"),
        (("--reverse",), "option-missing", "--reverse --drive car --turning-radius 0.5"),
        (("--turning-radius", "2"), "option-missing", "--turning-radius 2 --drive car"),
        (
            ("--steering-rate", "2"),
            "option-missing",
            "--steering-rate 2 --drive car --turning-radius 0.5",
        ),
        (("--drive", "car"), "option-missing", "--drive car --turning-radius 0.5"),
        (("--drive", "car", "--turning-radius", "0.2", "--contact", "slide"), "car-slides", ""),
        (("--drive", "boat"), "", "--drive car"),
        (("--contact", "slid"), "", "--contact slide"),
        (("--turning-radius", "0"), "", "--turning-radius 0.5"),
        (("--steering-rate", "-1"), "", ""),
        (("--radius", "0.1", "--footprint", "0.2x0.1"), "", "--footprint 0.2x0.1"),
    ],
)
def test_a_wrong_option_is_answered_in_a_sentence_and_with_the_corrected_command(
    room, words, code, corrected
):
    result = worldgen("verify", room, *words)
    assert (result.code, result.error_code, result.out) == (2, code, "")
    sentence, *commands = result.err.splitlines()
    assert sentence.startswith("worldgen")
    assert len(commands) <= 1
    if corrected:
        assert commands == [f"  worldgen verify {room} {corrected}"]


def test_a_number_of_waypoints_is_corrected_to_a_place_in_the_world(room):
    target = read_world(room).target
    result = worldgen("verify", room, "--waypoints", "2")
    assert (result.code, result.error_code) == (2, "no-places")
    near = f"{target.x:.6g},{target.y:.6g}"
    assert result.err.splitlines()[1:] == [f"  worldgen verify {room} --waypoints {near}"]
    assert worldgen("verify", room, "--waypoints", near).code == 0


def test_a_body_that_does_not_cover_its_axle_is_accepted_and_mentioned(room):
    result = worldgen("verify", room, "--footprint", "0.02x0.02@0.05")
    assert "the axle, (0, 0), is outside the footprint" in result.err
    assert "outside" not in worldgen("verify", room, "--footprint", "0.1x0.02@0.05").err


def test_the_body_is_named_with_the_answer(room):
    said = worldgen("verify", room, "--footprint", "0.06x0.04")
    answer = json.loads(worldgen("verify", room, "--footprint", "0.06x0.04", "--json").out)
    assert "for a body of 0.06 x 0.04 m" in said.out
    assert answer["footprint"] == [[-0.03, -0.02], [0.03, -0.02], [0.03, 0.02], [-0.03, 0.02]]
    assert "footprint" not in json.loads(worldgen("verify", room, "--json").out)


def test_a_radius_asks_about_a_disc_in_place_of_a_footprint(tmp_path):
    world = RobotOverrides(footprint="0.06x0.04").applied_to(drawn(ROOM))
    write_world(world, tmp_path / "b.grid")
    said = worldgen("verify", tmp_path / "b.grid", "--radius", "0.05").out
    assert "reachable for a disc of 0.05 m" in said


def test_options_are_refused_for_several_robots():
    with raises(InvalidParameter, "not-for-fleets", option="--arrival", robots=2):
        RobotOverrides(arrival="step").applied_to(fleet())


def test_no_option_leaves_the_world_as_it_is():
    world = drawn(ROOM)
    assert RobotOverrides().applied_to(world) is world
    assert RobotOverrides(arrival="touch").applied_to(world) is world


def test_another_body_needs_another_proof_and_another_goal_does_not():
    made = Provenance("maze", 1, 7)
    world = dataclasses.replace(drawn(ROOM), certificate=decide(drawn(ROOM)).certificate)
    world = dataclasses.replace(world, provenance=made)
    goal = RobotOverrides(arrival="stop:0.1:0.2", contact="fail").applied_to(world)
    assert (goal.target.arrival, goal.target.arrival_speed) == ("stop", 0.1)
    assert (goal.certificate, goal.provenance) == (world.certificate, None)
    body = RobotOverrides(footprint="0.1x0.08").applied_to(world)
    assert (body.certificate, body.provenance) == (None, None)


def test_another_radius_of_the_target_needs_another_proof_and_leaves_waypoints_as_they_are():
    plain = drawn(ROOM)
    first = dataclasses.replace(plain.target, x=0.35, radius=0.03)
    robot = dataclasses.replace(plain.robots[0], waypoints=(first,))
    world = dataclasses.replace(plain, robots=(robot,))
    world = dataclasses.replace(world, certificate=decide(world).certificate)
    larger = RobotOverrides(target_radius=0.2).applied_to(world)
    assert (larger.target.radius, larger.robots[0].waypoints) == (0.2, (first,))
    assert larger.certificate is None
    assert RobotOverrides(target_radius=plain.target.radius).applied_to(world) is world
    other = RobotOverrides(target_radius=0.2, waypoints="0.35,0.15 0.5,0.15,0.04")
    radii = [goal.radius for goal in other.applied_to(world).robots[0].goals]
    assert radii == [0.2, 0.04, 0.2]


def test_a_radius_of_the_target_is_proved_run_and_stored(tmp_path):
    # No door leads to the target, but a large one reaches through the wall.
    write_world(drawn(TWO_ROOMS, radius=0.08), tmp_path / "w.grid")
    blocked, larger = tmp_path / "w.grid", ("--target-radius", "0.4")
    assert "blocked" in worldgen("verify", blocked).out
    assert "reachable" in worldgen("verify", blocked, *larger).out
    run = ("run", blocked, "--controller", "bug2")
    assert [worldgen(*run).code, worldgen(*run, *larger).code] == [1, 0]
    made = ("maze", "--size", "12", "--seed", "3", "--out")
    for name, options in (("m", ()), ("r", larger)):
        assert worldgen(*made, tmp_path / f"{name}.grid", *options).code == 0
    plain, other = (read_world(tmp_path / f"{name}.grid") for name in "mr")
    assert (other.walls == plain.walls).all()
    assert (other.target.radius, other.provenance.params["target_radius"]) == (0.4, 0.4)
    assert "target_radius" not in plain.provenance.params


def test_a_target_that_covers_the_start_is_mentioned(room, tmp_path):
    sentence = "the start is in the target, which has a radius of 3 m, so there is no way to go"
    run = ("run", room, "--controller", "bug2")
    maze = ("maze", "--size", "12", "--seed", "3", "--force", "--out")
    made = (*maze, tmp_path / "m.grid")
    wanted = (*made, "--where", "detour > 0")
    several = (*maze, tmp_path / "set", "--count", "2")
    for command in (("verify", room), run, made, wanted, several):
        assert sentence not in worldgen(*command).err
        said = worldgen(*command, "--target-radius", "3")
        assert (said.code, sentence in said.err) == (0, True)


def test_a_fuzz_campaign_gives_no_answer_where_the_target_covers_every_start(tmp_path):
    done = worldgen(
        "fuzz", "--controller", "turn-left", "--target-radius", "50", "--units", "1", "--examples", "9",
        "--seed", "1", "--workers", "1", "--out", tmp_path / "found",
    )  # fmt: skip
    assert "no answer: none of the" in done.out and "give it more time" not in done.out
    assert "a smaller --target-radius" in done.out
    assert done.code == 4


def test_import_takes_one_radius_of_the_target(room, tmp_path):
    command = ("import", room, "--out", tmp_path / "i.grid", "--target-radius", "0.1")
    assert worldgen(*command).code == 0
    assert read_world(tmp_path / "i.grid").target.radius == 0.1
    both = worldgen(*command, "--force", "--target", "0.8,0.25,0.2")
    assert both.code == 2
    assert "--target X,Y,RADIUS or --target-radius" in both.err


def test_a_foreign_map_keeps_what_was_not_read_of_it():
    made = Provenance("import", 3, 0, {"unread": ["1 shape of <mesh>"]})
    world = dataclasses.replace(drawn(ROOM), provenance=made)
    assert RobotOverrides(footprint="0.1x0.08").applied_to(world).unread == world.unread


def test_a_car_of_the_world_takes_a_car_s_options_alone():
    world = RobotOverrides(drive="car", turning_radius=0.5).applied_to(drawn(ROOM))
    both = RobotOverrides(reverse=True, steering_rate=2.0).applied_to(world)
    assert both.robots[0].drive == Drive(0.5, True, 2.0)
    assert RobotOverrides(reverse=False).applied_to(both).robots[0].drive == Drive(0.5, False, 2.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "disc of 0.07 m"),
        ({"footprint": "0.62x0.9"}, "body of 0.62 x 0.9 m"),
        ({"footprint": "0.5,0 -0.3,0.2 -0.3,-0.2"}, "body of 3 corners, 0.8 x 0.4 m"),
        (
            {"drive": "car", "turning_radius": 0.5},
            "car of radius 0.07 m with a turning radius of 0.5 m",
        ),
        (
            {"footprint": "0.62x0.9", "drive": "car", "turning_radius": 0.5, "reverse": True},
            "car of 0.62 x 0.9 m with a turning radius of 0.5 m that reverses",
        ),
    ],
)
def test_a_body_is_described(options, words):
    robot: Robot = RobotOverrides(**options).applied_to_robot(drawn(ROOM).robots[0])
    assert describe_body(robot) == words


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, ""),
        ({"arrival": "step"}, "the end of a step"),
        ({"target_heading": "1.5:0.1"}, "heading 1.5 rad (+- 0.1)"),
        (
            {"arrival": "stop", "target_heading": "1.5", "contact": "fail"},
            "a stop at heading 1.5 rad (+- 0.25), no contact with walls",
        ),
    ],
)
def test_a_goal_is_described_in_words_pictures_and_json(options, words, tmp_path):
    world = RobotOverrides(**options).applied_to(drawn(ROOM))
    assert describe_goal(world.target) == words
    assert (f"its goal asks for {words}" in caption_facts(world)) == bool(words)
    write_world(world, tmp_path / "w.grid")
    shown = json.loads(worldgen("show", tmp_path / "w.grid", "--json").out)
    keys = {"arrival", "contact", "target_heading", "heading_tolerance"} & shown.keys()
    heading = {"target_heading", "heading_tolerance"} if "target_heading" in options else set()
    assert keys == ({"arrival", "contact"} | heading if words else set())
