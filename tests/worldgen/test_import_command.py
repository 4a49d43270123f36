"""``worldgen import``: from a map to a world with start, target and a proof."""

import importlib.resources
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tests.helpers.command_line import worldgen
from tests.helpers.raising import check_says, raises
from worldgen.cli.main import cli
from worldgen.errors import FormatError, InvalidParameter, InvalidWorld, OutputError
from worldgen.files.grid import read_world, write_world
from worldgen.interop import ImportedRobot, import_world, place, read_map
from worldgen.interop.place import is_clear as place_is_clear
from worldgen.reach import check_certificate, decide
from worldgen.timeline import CellState, Timeline
from worldgen.world import Pose, Provenance, Target, World

MAPS = importlib.resources.files("corpora") / "maps"
MAZE, HALL = str(MAPS / "maze-32-32-2.map"), str(MAPS / "mrpt-uwb-demo.yaml")
PROBLEMS = str(MAPS / "maze-32-32-2-even-1.scen")


@pytest.fixture
def run(tmp_path, capsys):
    """Run the command with --json; return the object, the world and stderr."""

    def run_import(*args):
        out = tmp_path / "w.grid"
        cli.main(
            ["import", *map(str, args), "--out", str(out), "--json", "--force"],
            standalone_mode=False,
        )
        captured = capsys.readouterr()
        return json.loads(captured.out), read_world(out), captured.err

    return run_import


def drawing(tmp_path, *rows, name="a.map"):
    path = tmp_path / name
    lines = ["type octile", f"height {len(rows)}", f"width {len(rows[0])}", "map", *rows]
    path.write_text("\n".join(lines) + "\n")
    return path


SHIPPED = [
    ("maze", [MAZE], "reachable"),
    (
        "maze, tight",
        [MAZE, "--radius", "0.1", "--start", "0.2,0.2", "--target", "2.9,2.7"],
        "reachable",
    ),
    (
        "maze, too tight",
        [MAZE, "--radius", "0.11", "--start", "0.8,0.85", "--target", "2.9,2.7"],
        "blocked",
    ),
    ("maze, scenario", [MAZE, "--scen", PROBLEMS, "--row", "16"], "reachable"),
    ("hall", [HALL], "reachable"),
    (
        "hall, small",
        [HALL, "--radius", "0.35", "--start", "8,9", "--target", "2.2,1.2"],
        "reachable",
    ),
    ("hall, huge", [HALL, "--radius", "0.45", "--start", "8,9", "--target", "2.2,1.2"], "blocked"),
]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("args", "result"), [case[1:] for case in SHIPPED], ids=[case[0] for case in SHIPPED]
)
def test_shipped_maps_are_decided_with_a_proof_that_the_checker_accepts(run, args, result):
    answer, world, _ = run(*args)
    assert answer["result"] == result
    report = check_certificate(world)
    assert report.valid, report.reason


def test_the_answer_is_the_file(run, tmp_path):
    answer, world, _ = run(MAZE, "--seed", 3)
    assert answer == {
        "file": str(tmp_path / "w.grid"),
        "result": "reachable",
        "reason": f"a path of {world.certificate.length:.4g} m lets discs of up to "
        f"{world.certificate.clearance:.4g} m through",
        "clearance": world.certificate.clearance,
        "radius": 0.04,
        "radius_from": "0.4 cells, so that it fits through a corridor one cell wide",
        "unread": [],
        "width": 32,
        "height": 32,
        "cell_size": 0.1,
        "start": [world.start.x, world.start.y, world.start.heading],
        "target": [world.target.x, world.target.y, 0.04],
        "origin": [0.0, 0.0],
        "placement": "start and target at the ends of a longest path in the largest region (100 % of the free "
        "space); 0.1 and 0.1 m from the nearest walls",
        "notes": [],
        "warnings": [],
    }


def test_provenance_names_the_source_and_its_digest(run):
    provenance = run(HALL, "--seed", 5)[1].provenance
    assert (provenance.family, provenance.version, provenance.seed) == ("import", 5, 5)
    params = provenance.params
    assert (params["format"], params["source"], params["origin"]) == (
        "ros",
        "mrpt-uwb-demo.yaml",
        [-3.16, -9.36],
    )
    assert params["sha256"] == "79a5abb21c59e7df1514ac7c378668f96196655b1247378053da2e7f617891a2"


def test_people_get_four_lines_and_the_origin_as_a_note(tmp_path, capsys):
    out = tmp_path / "w.grid"
    cli.main(["import", HALL, "--out", str(out)], standalone_mode=False)
    captured = capsys.readouterr()
    assert (
        captured.out.splitlines()[0]
        == f"{out}: 384 x 482 cells of 0.04 m, robot radius 0.22 m (Nav2's default, a TurtleBot's)"
    )
    assert captured.out.splitlines()[2].startswith(
        "placed: start and target at the ends of a longest"
    )
    assert captured.out.splitlines()[3].startswith("reachable: ")
    assert "the world's (0, 0) is the map's (-3.16, -9.36) m" in captured.err


def test_places_may_be_given_in_the_coordinates_of_the_file(run):
    _, of_corner, _ = run(HALL, "--start", "8,9,0.5", "--target", "2.25,1.25,0.1")
    answer, of_map, _ = run(
        HALL, "--frame", "map", "--start", "4.84,-0.36,0.5", "--target=-0.91,-8.11,0.1"
    )
    assert answer["origin"] == [-3.16, -9.36]
    start, target = of_map.start, of_map.target
    assert start == of_corner.start and start.heading == 0.5
    assert target == of_corner.target and target.radius == 0.1


def test_errors_name_places_in_the_coordinates_in_which_they_are_given(run):
    with raises(InvalidWorld, code="not-clear") as caught:
        run(HALL, "--frame", "map", "--start=-3.1,-9.3")
    facts = caught.value.facts
    assert (facts["x"], facts["y"]) == pytest.approx((-3.1, -9.3), abs=1e-3)
    x, y = facts["clear"]
    _, world, _ = run(HALL, "--frame", "map", f"--start={x!r},{y!r}")
    assert (world.start.x - 3.16, world.start.y - 9.36) == pytest.approx((x, y))
    with raises(InvalidWorld, code="outside-grid") as caught:
        run(HALL, "--frame", "map", "--target", "20,1")
    assert caught.value.facts["x"] == pytest.approx(20)
    assert "x from -3.16 to 12.2 and y from -9.36 to 9.92" in str(caught.value)


def test_places_are_printed_in_the_frame_that_was_asked_for(tmp_path, capsys):
    places = ["--start", "4.84,-0.36,0.5", "--target=-0.91,-8.11,0.1"]
    args = ["import", HALL, "--frame", "map", *places, "--out", str(tmp_path / "w.grid")]
    cli.main(args, standalone_mode=False)
    assert capsys.readouterr().out.splitlines()[1] == (
        "start (4.84, -0.36) m, heading 0.5 rad; "
        "target (-0.91, -8.11) m in the file's coordinates, radius 0.1 m"
    )


def test_equal_seeds_place_equally_and_the_file_is_the_same_to_the_byte(run, tmp_path):
    run(HALL, "--seed", 9)
    once = (tmp_path / "w.grid").read_bytes()
    run(HALL, "--seed", 9)
    assert (tmp_path / "w.grid").read_bytes() == once


def test_given_places_stay_and_missing_ones_are_found_far_away(run):
    _, world, _ = run(MAZE, "--start", "0.2,0.2,1.5")
    assert world.start == Pose(0.2, 0.2, 1.5)
    _, world, _ = run(MAZE, "--target", "0.2,0.2,0.03")
    assert world.target == Target(0.2, 0.2, 0.03)
    assert world.certificate.length > 3.2


def test_without_a_heading_the_robot_looks_at_the_target(run):
    _, world, _ = run(MAZE, "--start", "0.2,0.2", "--target", "0.2,0.5")
    assert world.start.heading == pytest.approx(np.pi / 2)


def test_a_scenario_runs_from_its_start_to_its_goal(run):
    _, world, _ = run(MAZE, "--scen", PROBLEMS, "--row", 1, "--cell-size", 0.5)
    assert (world.start.x, world.start.y, world.target.x, world.target.y) == (
        8.75,
        5.25,
        7.75,
        7.75,
    )
    assert (world.robot_radius, world.provenance.params["optimal"]) == (0.2, 13.82842712)


def test_both_ends_lie_in_the_largest_region(tmp_path, run):
    _, world, _ = run(drawing(tmp_path, "..@....", "..@....", "..@....", "@@@@@@@", "......."))
    assert min(world.start.x, world.target.x) > 0.3
    assert min(world.start.y, world.target.y) > 0.2


def test_a_map_of_rooms_behind_narrow_doors_is_warned_of(tmp_path, run):
    answer, _, err = run(
        drawing(tmp_path, "...@...@...", "...........", "...@...@..."), "--radius", 0.07
    )
    assert "there are 3 separate regions" in answer["warnings"][0]
    assert "warning: for a disc of radius 0.07 m" in err


def test_one_free_spot_gives_a_world_and_a_warning(tmp_path, run):
    answer, _, _ = run(drawing(tmp_path, "@@@", "@.@", "@@@"), "--radius", 0.05)
    assert answer["warnings"] == ["the largest region is a single place; start and target coincide"]


@settings(max_examples=40)
@given(
    hnp.arrays(np.bool_, (7, 9), elements=st.booleans(), fill=st.just(False)),
    st.sampled_from([0.3, 0.5, 0.7, 1.0]),
)
def test_placed_ends_can_always_be_joined(walls, radius):
    try:
        placed = place(walls, 1.0, radius, 0)
    except InvalidWorld as error:
        check_says(error, "no-room")
        return
    world = World(walls, Pose(*placed.start), Target(*placed.target, 0.1), 1.0, radius)
    assert decide(world).result == "reachable"


def test_a_world_of_ours_keeps_its_places_its_robot_and_its_timeline(tmp_path, run):
    old = import_world(MAPS / "maze-32-32-2.map").world
    timeline = Timeline.of([(1.0, 0, 0, CellState.BURNING)])
    old = World(
        old.walls,
        old.start,
        old.target,
        0.1,
        0.06,
        1.5,
        timeline,
        provenance=Provenance("maze", 1, 7, {"size": 32}),
    )
    write_world(old, tmp_path / "old.grid")
    _, world, _ = run(tmp_path / "old.grid")
    assert (world.start, world.target, world.timeline) == (old.start, old.target, timeline)
    assert (world.robot_radius, world.robot_speed) == (0.06, 1.5)
    assert world.provenance.params["made_by"]["seed"] == 7


def test_a_world_of_ours_gets_new_places_with_a_seed_and_new_numbers_where_given(tmp_path, run):
    write_world(
        World(np.zeros((9, 9), bool), Pose(0.45, 0.45), Target(0.5, 0.5, 0.02)),
        tmp_path / "old.grid.gz",
    )
    _, world, _ = run(tmp_path / "old.grid.gz", "--seed", 1, "--radius", "0.1", "--speed", 3)
    assert {(world.start.x, world.start.y), (world.target.x, world.target.y)} in (
        {(0.2, 0.2), (0.7, 0.7)}, {(0.2, 0.7), (0.7, 0.2)},
    )  # fmt: skip
    assert (world.robot_radius, world.robot_speed) == (0.1, 3.0)


@pytest.mark.parametrize(("name", "file"), [("movingai", MAZE), ("ros", HALL)])
def test_a_format_is_known_by_its_contents_or_by_name(tmp_path, run, name, file):
    assert run(file, "--from", name)[0]["result"] == "reachable"
    if name == "movingai":
        (tmp_path / "noname").write_bytes((MAPS / "maze-32-32-2.map").read_bytes())
        assert run(tmp_path / "noname")[1].provenance.params["format"] == "movingai"


def test_nav2s_parameters_are_not_taken_for_a_map(tmp_path):
    path = tmp_path / "nav2_params.yaml"
    path.write_text("amcl:\n  ros__parameters:\n    alpha1: 0.2\n")
    with raises(FormatError, "no-map-found", option="ros+params=nav2_params.yaml"):
        read_map(path)


REFUSED = [
    (["none.map"], FormatError, {"code": "no-such-file"}),
    (["."], FormatError, {"code": "not-a-regular-file"}),
    (["junk"], FormatError, {"code": "unknown-format"}),
    ([PROBLEMS], FormatError, {"code": "no-map-found"}),
    (
        [MAZE, "--from", "moving-ai"],
        InvalidParameter,
        {"code": "unknown-name", "name": "moving-ai", "near": "movingai"},
    ),
    ([HALL, "--from", "movingai"], FormatError, {"code": "wrong-form", "line": 1}),
    (
        [HALL, "--cell-size", "1"],
        InvalidParameter,
        {"code": "unknown-name", "name": "cell_size", "owner": "format ros on import"},
    ),
    (
        [MAZE, "--from", "movingai+unknown=free"],
        InvalidParameter,
        {"code": "unknown-name", "name": "unknown", "owner": "format movingai on import"},
    ),
    ([MAZE, "--cell-size", "0"], InvalidParameter, {"code": "out-of-range", "name": "cell_size"}),
    ([MAZE, "--cell-size", "nan"], InvalidParameter, {"code": "not-finite", "name": "cell_size"}),
    ([MAZE, "--radius", "0"], InvalidParameter, {"code": "out-of-range", "name": "radius"}),
    ([MAZE, "--radius", "-1"], InvalidParameter, {"code": "out-of-range", "name": "radius"}),
    ([MAZE, "--speed", "inf"], InvalidParameter, {"code": "out-of-range", "name": "speed"}),
    ([MAZE, "--radius", "2"], InvalidWorld, {"code": "no-room"}),
    (
        [MAZE, "--start", "1"],
        InvalidParameter,
        {"code": "wrong-form", "name": "start", "text": "1", "third": "HEADING"},
    ),
    (
        [MAZE, "--start", "1,2,3,4"],
        InvalidParameter,
        {"code": "wrong-form", "name": "start", "text": "1,2,3,4"},
    ),
    (
        [MAZE, "--target", "a,b"],
        InvalidParameter,
        {"code": "wrong-form", "name": "target", "text": "a,b", "third": "RADIUS"},
    ),
    ([MAZE, "--start", "1e999,0"], InvalidWorld, {"code": "outside-grid", "name": "start"}),
    (
        [MAZE, "--start=-1,0.5"],
        InvalidWorld,
        {"code": "outside-grid", "name": "start", "y": 0.5, "width": 3.2},
    ),
    ([MAZE, "--target", "3,4"], InvalidWorld, {"code": "outside-grid", "name": "target"}),
    (
        [MAZE, "--target", "0.2,0.2,0"],
        InvalidWorld,
        {"code": "not-positive", "name": "target radius"},
    ),
    ([MAZE, "--start", "0.2,0.15,1e999"], InvalidWorld, {"code": "not-finite"}),
    ([MAZE, "--radius", "0.07", "--start", "0.05,0.3"], InvalidWorld, {"code": "not-clear"}),
    (
        [MAZE, "--radius", "0.07", "--start", "0.15,0.25"],
        InvalidWorld,
        {"code": "not-clear", "y": 0.25, "distance": 0.05},
    ),
    (
        [MAZE, "--radius", "0.07", "--start", "0.5,0.05"],
        InvalidWorld,
        {"code": "not-clear", "y": 0.05, "distance": 0.05},
    ),
    ([MAZE, "--scen", "none.scen"], FormatError, {"code": "no-such-file"}),
    (
        [MAZE, "--scen", PROBLEMS, "--row", "231"],
        FormatError,
        {"code": "out-of-range", "row": 231, "rows": 230},
    ),
    ([MAZE, "--scen", PROBLEMS, "--start", "1,1"], InvalidParameter, {"code": "conflict"}),
    ([HALL, "--scen", PROBLEMS], InvalidParameter, {"code": "conflict"}),
]


@pytest.mark.gate
@pytest.mark.parametrize(("args", "kind", "expected"), REFUSED, ids=range(len(REFUSED)))
def test_what_cannot_be_imported_is_refused_and_nothing_is_written(
    tmp_path, monkeypatch, run, args, kind, expected
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "junk").write_bytes(b"\x00\x01junk")
    (tmp_path / "m.pgm").write_bytes(b"P5\n1 1\n255\n\0")
    with raises(kind, **expected):
        run(*args)
    assert not (tmp_path / "w.grid").exists()


def test_the_nearest_clear_place_of_a_message_is_clear(tmp_path, run):
    with raises(InvalidWorld, "not-clear") as caught:
        run(HALL, "--radius", "0.3", "--start", "8,3")
    x, y = caught.value.facts["clear"]
    offered = f"{x},{y}"
    assert run(HALL, "--radius", "0.3", "--start", offered)[0]["result"] == "reachable"


def test_an_existing_file_is_kept_unless_forced(tmp_path):
    out = tmp_path / "w.grid"
    out.write_text("mine")
    with raises(OutputError, "file-exists"):
        cli.main(["import", MAZE, "--out", str(out)], standalone_mode=False)
    assert out.read_text() == "mine"


@pytest.mark.gate
def test_the_program_ends_with_2_and_one_line(tmp_path):
    (tmp_path / "a.map").write_bytes(b"type octile\nheight 9\n")
    command = [
        sys.executable,
        "-c",
        "from worldgen.cli.main import main; main()",
        "import",
        "a.map",
        "--out",
        "w.grid",
    ]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert (
        done.stderr.startswith("worldgen: a.map:3: the end of the file is")
        and done.stderr.count("\n") == 1
    )


def test_every_shipped_map_is_credited():
    text = (MAPS / "README.md").read_text()
    for file in MAPS.iterdir():
        assert f"`{file.name}`" in text or file.name == "README.md", file.name


YAML = "origin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"


@pytest.mark.parametrize(
    ("name", "text", "radius"),
    [
        pytest.param(
            "a.map",
            "type octile\nheight 3\nwidth 3\nmap\n...\n...\n...\n",
            0.04,
            id="a corridor is a cell",
        ),
        pytest.param("a.txt", "....\n....\n....\n", 0.07, id="a drawing of ours"),
        pytest.param(
            "a.yaml", "image: a.pgm\nresolution: 0.5\n" + YAML, 0.22, id="a map of a real floor"
        ),
    ],
)
def test_the_default_robot_is_one_that_such_maps_are_drawn_for(tmp_path, run, name, text, radius):
    (tmp_path / name).write_text(text)
    (tmp_path / "a.pgm").write_bytes(b"P5\n4 4\n255\n" + b"\xfe" * 16)
    answer, world, _ = run(tmp_path / name, *(["--from", "text"] if name == "a.txt" else []))
    assert world.robot_radius == radius and answer["radius_from"]


def test_a_radius_that_is_given_is_said_to_be(run):
    answer, _, _ = run(MAZE, "--radius", "0.05")
    assert (answer["radius"], answer["radius_from"]) == (0.05, "as given")


def test_placed_ends_have_room_to_turn_where_the_map_has_it():
    world = import_world(MAPS / "mrpt-uwb-demo.yaml").world
    for end in (world.start, world.target):
        assert place_is_clear(world.walls, world.cell_size, 2 * world.robot_radius, (end.x, end.y))


def test_a_start_without_room_is_better_than_one_beside_its_target(tmp_path):
    corridor = [
        "@" * 40,
        "@" + "." * 34 + "@" * 5,
        "@" * 34 + "....@@",
        "@" * 34 + "....@@",
        "@" * 40,
    ]
    world = import_world(drawing(tmp_path, *corridor)).world
    assert abs(world.start.x - world.target.x) > 2.0


def test_a_blocked_world_is_written_and_ends_with_1(tmp_path, capsys):
    out = tmp_path / "w.grid"
    args = [
        "import",
        MAZE,
        "--radius",
        "0.11",
        "--start",
        "0.8,0.85",
        "--target",
        "2.9,2.7",
        "--out",
        str(out),
    ]
    assert cli.main(args, standalone_mode=False) == 1
    assert "\nblocked: " in capsys.readouterr().out and decide(read_world(out)).result == "blocked"


BOX = (
    "<model name='{name}'><link name='l'><collision "
    "name='c'><geometry><box><size>{size}</size></box></geometry>"
    "</collision></link><pose>{pose} 0.5 0 0 0</pose></model>"
)
MESH = (
    "<model name='shelf'><link name='l'><collision "
    "name='c'><geometry><mesh><uri>model://shelf.dae</uri></mesh>"
    "</geometry></collision></link></model>"
)


def gazebo(tmp_path, *parts):
    """A Gazebo world: two walls of 6 m, 6 m apart, and the given elements."""
    walls = [BOX.format(name=f"wall{x}", size="0.2 6 1", pose=f"{x} 0") for x in (-3, 3)]
    path = tmp_path / "shelf.world"
    path.write_text(
        f"<sdf version='1.6'><world name='default'>{''.join([*walls, *parts])}</world></sdf>"
    )
    return path


@pytest.fixture
def unread(tmp_path, capsys):
    """The file of a world of whose map a mesh was not read, and the answer of the import."""
    out = tmp_path / "w.grid"
    code = cli.main(
        ["import", str(gazebo(tmp_path, MESH)), "--out", str(out), "--json"], standalone_mode=False
    )
    return out, code, json.loads(capsys.readouterr().out)


def test_a_world_with_a_mesh_is_undecided_and_written_without_a_proof(unread):
    out, code, answer = unread
    assert (code, answer["result"], answer["file"]) == (2, "undecided", str(out))
    assert answer["unread"] == ["1 mesh not found"]
    world = read_world(out)
    assert world.certificate is None and world.unread == ("1 mesh not found",)


def test_a_world_read_in_part_stays_undecided(unread):
    out = unread[0]
    for words in (["verify", out], ["verify", out, "--radius", "0.1"], ["verify", out, "--widest"]):
        answer = worldgen(*words, "--json")
        said = json.loads(answer.out)
        assert (answer.code, said["result"], said["certificate_valid"]) == (2, "undecided", False)
        assert said["unread"] == ["1 mesh not found"]
    assert decide(read_world(out)).result == "undecided"
    again = worldgen("import", out, "--out", out.with_name("again.grid"))
    assert again.code == 2 and read_world(out.with_name("again.grid")).unread


def test_a_run_in_a_world_read_in_part_does_not_say_that_its_target_is_reachable(unread):
    done = worldgen("run", unread[0], "--controller", "bug2", "--json")
    assert json.loads(done.out)["reachable"] is None
    assert "1 mesh not found was not read" in done.err


@pytest.mark.parametrize(
    "words",
    [
        ["fuzz", "--controller", "bug2", "--units", "1", "--seed", "1", "--out", "f", "--world"],
        ["find", "--outcome", "bug2=loop", "--seed", "1", "--out", "f.grid", "--from"],
        ["boundary", "--controller", "bug2", "--axis", "heading"],
        ["export", "--to", "ros", "--out", "r.yaml"],
    ],
    ids=lambda words: words[0],
)
def test_nothing_is_searched_or_copied_in_a_world_read_in_part(unread, words, monkeypatch):
    monkeypatch.chdir(unread[0].parent)
    done = worldgen(*words, unread[0])
    assert (done.code, done.error_code) == (2, "part-not-read"), done.err
    assert "--ignore-unread" in done.err


def test_a_certificate_in_a_world_read_in_part_is_refused(unread):
    world = read_world(unread[0])
    proof = decide(replace(world, provenance=None)).certificate
    with raises(InvalidWorld, "part-not-read", unread=["1 mesh not found"]):
        replace(world, certificate=proof)


def test_a_world_of_an_earlier_version_keeps_its_proof(unread):
    world = read_world(unread[0])
    old = replace(world, provenance=replace(world.provenance, version=2))
    assert old.unread == () and decide(old).result == "reachable"


@pytest.mark.parametrize("option", ["--ignore-unread", "--ignore-meshes"])
def test_what_was_not_read_can_be_ignored_and_the_file_says_so(tmp_path, run, option):
    answer, world, err = run(gazebo(tmp_path, MESH), option)
    assert answer["result"] == "reachable" and check_certificate(world).valid
    assert world.provenance.params["unread"] == ["1 mesh not found"] and "1 mesh not found" in err
    assert worldgen("verify", tmp_path / "w.grid").code == 0


def test_a_map_that_looks_blocked_is_undecided_too_because_unread_elements_may_move_walls(tmp_path):
    wall = BOX.format(name="across", size="6 0.2 1", pose="0 0")
    robot = ImportedRobot((3.0, 1.0), (3.0, 5.0))
    imported = import_world(gazebo(tmp_path, MESH, wall), robot)
    assert imported.decision.result == "undecided" and imported.world.certificate is None
    imported = import_world(gazebo(tmp_path, MESH, wall), replace(robot, ignore_unread=True))
    assert imported.decision.result == "blocked" and check_certificate(imported.world).valid


@pytest.mark.parametrize(
    ("part", "unread"),
    [
        ("<include><uri>model://shelf</uri></include>", "1 model not found"),
        (
            "<model name='m'><include><uri>model://shelf</uri></include></model>",
            "1 model not found",
        ),
        ("<population name='p'/>", "1 population of models"),
        (MESH.replace("mesh>", "heightmap>"), "1 shape of <heightmap>"),
        (MESH.replace("mesh>", "image>"), "1 shape of <image>"),
        (MESH.replace("<uri>", "<submesh/><uri>"), "1 mesh not found"),
        (
            MESH.replace(
                "<mesh><uri>model://shelf.dae</uri></mesh>", "<plane><normal>1 0 0</normal></plane>"
            ),
            "1 shape of <plane>, tilted",
        ),
    ],
)
def test_whatever_a_world_of_gazebo_has_and_is_not_read_is_named(tmp_path, part, unread):
    imported = import_world(gazebo(tmp_path, part))
    assert imported.unread == (unread,) and imported.withheld


@pytest.mark.parametrize(
    "name",
    ["sun", "ground_plane", "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Ground Plane"],
)
def test_sun_and_ground_stop_nobody(tmp_path, name):
    uri = name if "/" in name else f"model://{name}"
    assert import_world(gazebo(tmp_path, f"<include><uri>{uri}</uri></include>")).unread == ()


@pytest.mark.parametrize(
    "command", [["verify"], ["show"], ["measure"], ["run", "--controller", "bug2"]]
)
def test_a_foreign_map_given_to_another_command_gets_the_command_that_imports_it(command):
    done = worldgen(*command, MAZE)
    assert done.code == 2 and f"\n  worldgen import {MAZE} --out maze-32-32-2.grid\n" in done.err


@pytest.mark.parametrize("name", ["notes.txt", "notes.grid"])
def test_what_is_no_map_gets_no_such_hint(tmp_path, name):
    (tmp_path / name).write_text("hello, this is a letter\n")
    assert "worldgen import" not in worldgen("verify", tmp_path / name).err


def test_the_command_that_imports_a_map_called_grid_writes_another_file(tmp_path):
    (tmp_path / "maze.grid").write_bytes(Path(MAZE).read_bytes())
    assert worldgen("verify", tmp_path / "maze.grid").err.endswith(
        "maze.grid --out maze-imported.grid\n"
    )
