"""The command ``audit``: recordings that it reads, its options, and what it prints."""

import io
import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from sim.audit import KINDS, Trajectory, audit
from sim.audit.frames import MapFrame
from tests.helpers.audit_room import ROOM, path, room
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import (
    FormatError,
    InvalidParameter,
    Pose,
    Target,
    World,
    generate,
    read_world,
    write_world,
)
from worldgen.logs.reading import parse_log
from worldgen.world import Provenance


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("", None, {"code": "too-few-samples"}),
        ("t,vx,y\n0,1,1\n", 1, {"code": "columns-missing", "shown": "t, vx, y", "axis": "x"}),
        ("t,x,y,x\n0,1,1,1\n", 1, {"code": "ambiguous-columns", "needs": ["--columns=x=2,y=y"]}),
        ("t,x,y\n", None, {"code": "too-few-samples"}),
        ("t,x,y\n0,1,1\n", None, {"code": "too-few-samples", "count": 1}),
        ("t,x,y\n0,1,1\n\n1,1\n", 4, {"code": "line-too-short", "count": 2}),
        ("t,x,y\n0,1,1\n1,one,1\n", 3, {"code": "not-a-number", "name": "x", "value": "one"}),
        ("t;x;y\n0;1;1\n1;1.234,5;1\n", 3, {"code": "not-a-number", "name": "x"}),
        ("t,x,y\n0,1,1\n1,1_0,1\n", 3, {"code": "not-a-number", "name": "x", "value": "1_0"}),
        ('t,x,y\n0,1,1\n1,"1,1\n', 3, {"code": "invalid-csv"}),
        ("t,x,y\n\n0,1,1\n1,nan,1\n", 4, {"code": "out-of-range", "name": "x"}),
        ("t,x,y\n0,1,1\ninf,1,1\n", 3, {"code": "out-of-range", "name": "t"}),
        ("t,x,y\n0,1,1\n1,1,-1e300\n", 3, {"code": "out-of-range", "name": "y"}),
        ("t,x,y\n0,1,1\n\n2,1,1\n1.5,1,1\n", 5, {"code": "times-fall", "time": 1.5}),
    ],
)
def test_a_recording_that_cannot_be_read_is_named_with_its_line(text, line, expected):
    with raises(FormatError, **expected) as raised:
        parse_log(text, "bad.csv")
    assert raised.value.line == line


@pytest.mark.parametrize(
    "text",
    [
        "t,x,y,heading\n0,1.5,2,0.1\n0.5,3,4,nan\n",
        "y;t;note;x\n2;0;a;1.5\n4;0.5;;3\n",
        "t\tx\ty\n0\t1.5\t2\n0.5\t3\t4\n",
        "\n# T, X , Y\n\n0, 1.5, 2\n\n  0.5, 3, 4",
        't,x,y\r\n0,1.5,2\r\n"0.5","3","4"\r\n',
        "t,x,y\r0,1.5,2\r0.5,3,4\r",
    ],
)
def test_columns_go_by_name_whatever_stands_between(text):
    read = parse_log(text, "good.csv").trajectories[1]
    assert [list(values) for values in (read.times, read.x, read.y)] == [
        [0.0, 0.5],
        [1.5, 3.0],
        [2.0, 4.0],
    ]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"tolerance": 0.0}, {"code": "out-of-range", "name": "tolerance"}),
        ({"tolerance": math.nan}, {"code": "out-of-range", "name": "tolerance"}),
        ({"slack": -1.0}, {"code": "out-of-range", "name": "slack"}),
    ],
)
def test_options_out_of_range_are_refused(options, expected):
    with raises(InvalidParameter, **expected):
        audit(ROOM, path((0, 1, 1), (1, 1, 1)), **options)


def test_places_beyond_all_cells_are_refused():
    tiny = World(
        ROOM.walls, Pose(0.0, 0.0), Target(0.0, 0.0, 1e-6), cell_size=1e-6, robot_radius=1e-6
    )
    with raises(InvalidParameter, "out-of-range"):
        audit(tiny, path((0, 1e4, 1), (1, 1e4, 1)))


@pytest.fixture
def files(tmp_path):
    write_world(room(walls=[(5, 3)]), tmp_path / "w.grid")
    (tmp_path / "clean.csv").write_bytes(b"\xef\xbb\xbft,x,y\r\n0,3.5,3.5\r\n1,3.5,5.0\r\n")
    (tmp_path / "bad.csv").write_text("t,x,y\n0,3.5,3.5\n2,7.5,3.5\n3,7.5,3.5\n")
    return tmp_path


def test_the_command_says_possible_and_ends_with_0(files):
    result = worldgen("audit", files / "w.grid", files / "clean.csv")
    assert result.code == 0 and result.out.startswith(
        "possible: 2 samples, 1 s, 1.5 m, target not reached; smallest "
    )


def test_the_command_says_what_was_not_possible_and_ends_with_1(files):
    result = worldgen("audit", files / "w.grid", files / "bad.csv")
    assert result.code == 1
    assert [line.split()[0] for line in result.out.splitlines()] == ["overlap", "tunnel", "not"]
    assert (
        "tunnel 0.75 to 1.25 s: the centre is up to 0.5 m deep in cell (5, 3), at t = 1 s, (5.5, "
        "3.5) m" in result.out
    )
    assert "not possible, 1 tunnel, 1 overlap: 3 samples" in result.out


def test_json_has_the_promised_keys(files):
    result = worldgen("audit", files / "w.grid", files / "bad.csv", "--json")
    found = json.loads(result.out)
    assert result.code == 1 and found["ok"] is False
    assert set(found) == {
        "ok", "findings", "notes", "samples", "reached", "path_length", "duration", "clearance", "nearest", "shaved",
        "shaved_depth", "is_plan", "tolerance",
    }  # fmt: skip
    tunnel = found["findings"][1]
    assert tunnel == {"kind": "tunnel", "t": 1.0, "x": 5.5, "y": 3.5, "depth": 0.5, "cell": [5, 3], "t_begin": 0.75,
                      "t_end": 1.25, "sample": 0}  # fmt: skip


def test_the_reference_names_every_key_and_kind(files):
    page = (Path(__file__).parents[2] / "docs" / "reference" / "tables.md").read_text(
        encoding="utf-8"
    )
    found = json.loads(worldgen("audit", files / "w.grid", files / "bad.csv", "--json").out)
    assert all(f"`{name}`" in page for name in (*found, *found["findings"][0], *KINDS))


def test_a_minus_reads_from_stdin(files, monkeypatch):
    monkeypatch.setattr(
        sys, "stdin", SimpleNamespace(buffer=io.BytesIO((files / "bad.csv").read_bytes()))
    )
    assert worldgen("audit", files / "w.grid", "-").code == 1


@pytest.mark.gate
def test_the_picture_marks_the_tunnel(files):
    out = files / "a.png"
    result = worldgen("audit", files / "w.grid", files / "bad.csv", "--picture", out)
    drawn_pixels = np.asarray(Image.open(out).convert("RGB")).reshape(-1, 3)
    clean = worldgen("audit", files / "w.grid", files / "clean.csv", "--picture", files / "b.png")
    clean_pixels = np.asarray(Image.open(files / "b.png").convert("RGB")).reshape(-1, 3)
    red = np.array([0xC0, 0x00, 0x18])  # "pierced" in worldgen/render/marks.json
    assert (result.code, clean.code) == (1, 0)
    assert (drawn_pixels == red).all(axis=1).any() and not (clean_pixels == red).all(axis=1).any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["{}/w.grid", "{}/none.csv"], "none.csv: there is no such file"),
        (["{}/none.grid", "{}/bad.csv"], "none.grid"),
        (["{}/w.grid", "{}"], ": this is a folder"),
        (["{}/w.grid", "{}/bad.csv", "--picture", "a.svg"], "use a name that ends in .png"),
        (["{}/w.grid", "{}/bad.csv", "--tolerance", "0"], "at least 1e-09"),
        (["{}/w.grid", "{}/w.grid"], "this is a world, not a log"),
    ],
)
def test_bad_input_is_one_line(files, arguments, message):
    result = worldgen("audit", *(text.format(files) for text in arguments))
    assert result.code == 2 and message in result.err and "Traceback" not in result.err


@pytest.fixture
def fleet(tmp_path):
    """A world with two robots, and the trace of a ``run`` in it."""
    write_world(generate("doorway", 5, robots=2), tmp_path / "d.grid")
    trace = ["--trace", tmp_path / "own.csv"]
    done = worldgen("run", tmp_path / "d.grid", "--controller", "turn-right", *trace)
    # The second robot never arrives.
    assert done.code == 1
    return tmp_path


def test_a_recording_by_run_of_several_robots_is_possible(fleet):
    done = worldgen("audit", fleet / "d.grid", fleet / "own.csv")
    assert done.code == 0
    lines = done.out.splitlines()
    assert [line.split(":")[0] for line in lines if "samples" in line] == ["robot 1", "robot 2"]
    assert lines[-1] == "possible; contacts between robots are not judged"


def test_one_robot_of_a_recording_can_be_chosen(fleet):
    done = worldgen("audit", fleet / "d.grid", fleet / "own.csv", "--robot", "2", "--json")
    found = json.loads(done.out)
    both = json.loads(worldgen("audit", fleet / "d.grid", fleet / "own.csv", "--json").out)
    assert both["ok"]
    assert [one.pop("robot") for one in both["robots"]] == [1, 2]
    assert found == both["robots"][1]


def test_the_robot_with_a_finding_is_named(fleet):
    lines = (fleet / "own.csv").read_text().splitlines()
    at = next(number for number, line in enumerate(lines) if line.startswith("2,")) + 3
    fields = lines[at].split(",")
    lines[at] = ",".join([*fields[:2], "-1.0", *fields[3:]])
    (fleet / "bad.csv").write_text("\n".join(lines))
    out = fleet / "bad.png"
    done = worldgen("audit", fleet / "d.grid", fleet / "bad.csv", "--picture", out)
    assert done.code == 1
    assert "robot 2: outside" in done.out
    assert "robot 1: outside" not in done.out
    assert done.out.splitlines()[-1].startswith("not possible: robot 2;")
    assert out.read_bytes().startswith(b"\x89PNG")
    assert worldgen("audit", fleet / "d.grid", fleet / "bad.csv", "--robot", "1").code == 0


def test_a_recording_without_numbers_is_of_the_chosen_robot(fleet):
    lines = (fleet / "own.csv").read_text().splitlines()
    own = [line.split(",", 1)[1] for line in lines if line.startswith(("robot", "2,"))]
    (fleet / "two.csv").write_text("\n".join(own))
    arguments = ["audit", fleet / "d.grid", fleet / "two.csv", "--from-start"]
    assert worldgen(*arguments, "--robot", "2").code == 0
    assert "start" in worldgen(*arguments).out


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("robot,t,x,y\n1,0,1,1\n3,0,1,1\n", [], ":3: robot 3 is not in the world"),
        ("robot,t,x,y\n1,0,1,1\n0.5,0,1,1\n", [], ":3: robot 0.5 is not in the world"),
        ("robot,t,x,y\n1,0,1,1\n2,0,1,1\n1,1,1,1\n", [], "robot 2: a trajectory needs"),
        ("robot,t,x,y\n1,0,1,1\n1,1,1,1\n", ["--robot", "2"], "no samples of robot 2"),
        ("robot,t,x,y\n", [], "no samples of robot 1"),
        ("robot,t,x,y\n1,0,1,1\n2,1,1,1\n2,0,1,1\n1,2,1,1\n", [], ":4: robot 2: t = 0.0 s"),
        ("robot,t,x,y\none,0,1,1\n", [], "robot 'one' is not a number"),
        ("robot,t,x,y\n1,0,1,1\n1,1,1,1\n", ["--robot", "3"], "robot 3 is not in the world"),
    ],
)
def test_a_fault_in_a_recording_of_several_robots_is_one_line(fleet, text, options, message):
    (fleet / "bad.csv").write_text(text)
    done = worldgen("audit", fleet / "d.grid", fleet / "bad.csv", *options)
    assert done.code == 2
    assert message in done.err
    assert len(done.err.strip().splitlines()) == 1


def test_in_a_world_of_one_robot_a_column_of_names_is_ignored(files):
    (files / "named.csv").write_text("robot,t,x,y\nburger,0,3.5,3.5\nburger,1,3.5,5.0\n")
    assert worldgen("audit", files / "w.grid", files / "named.csv").code == 0


@pytest.fixture
def imported(tmp_path):
    """A world from a map whose lower-left corner is at (-20, -30) m, and a drive through a wall."""
    made = Provenance("import", 4, 0, {"origin": [-20.0, -30.0]})
    write_world(replace(room(walls=[(5, 3)]), provenance=made), tmp_path / "w.grid")
    for name, (x, y) in {"corner": (0.0, 0.0), "map": (-20.0, -30.0), "lost": (500.0, 0.0)}.items():
        rows = [
            f"{t},{px + x},{py + y}" for t, px, py in ((0, 2.5, 2.5), (2, 2.5, 4.5), (9, 7.5, 4.5))
        ]
        (tmp_path / f"{name}.csv").write_text("\n".join(["t,x,y", *rows, ""]))
    return tmp_path


@pytest.mark.parametrize(
    ("log", "options", "code", "message"),
    [
        ("corner", [], 0, "possible"),
        ("map", [], 2, "in the world's frame 0 of 3 poses are free"),
        ("map", ["--frame", "map"], 0, "possible"),
        ("map", ["--frame", "corner"], 1, "note: in the world's frame 0 of 3 poses are free"),
        ("corner", ["--frame", "map"], 1, "1 way outside"),
        ("lost", [], 2, "3 of 3 poses are outside the world, which is 9 x 7 m"),
    ],
)
def test_a_log_in_another_frame_is_not_called_impossible(imported, log, options, code, message):
    result = worldgen("audit", imported / "w.grid", imported / f"{log}.csv", *options)
    assert result.code == code and message in result.out + result.err
    if log == "map" and not options:
        assert result.err.rstrip().endswith("map.csv --frame map")


def test_a_run_that_leaves_the_world_from_its_start_is_judged(imported):
    start = room().start
    (imported / "out.csv").write_text(f"t,x,y\n0,{start.x},{start.y}\n9,-5,-5\n99,-25,-25\n")
    assert worldgen("audit", imported / "w.grid", imported / "out.csv").code == 1


def test_poses_of_a_map_are_turned_into_a_world_with_its_pictures_cells(imported):
    made = Provenance("import", 5, 0, {"picture": [10.0, 20.0, math.pi / 2], "origin": [0.0, 0.0]})
    write_world(replace(room(), provenance=made), imported / "picture.grid")
    found = MapFrame.of(read_world(imported / "picture.grid")).into_world(
        Trajectory([0.0, 1.0], [10.0, 9.0], [21.0, 21.0], [math.pi / 2, math.pi])
    )
    assert found.x == pytest.approx([1.0, 1.0]) and found.y == pytest.approx([0.0, 1.0])
    assert found.headings == pytest.approx([0.0, math.pi / 2])
