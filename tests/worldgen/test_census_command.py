"""``worldgen census``: its options, its output, and its errors for invalid sources."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.command_line import worldgen
from tests.helpers.foreign_maps import (
    GAP,
    write_each_kind,
    write_octile,
    write_scenario,
    write_text,
)
from worldgen import Pose, Target, World, read_world, write_world
from worldgen.commands.census import census as command
from worldgen.interop.census.report import CSV_COLUMNS, ROWS
from worldgen.reach import check_certificate

TARGET = Target(0.65, 0.65, 0.05)
GENERATOR = """
import numpy as np
print('loading')

from worldgen.interop.census import CensusMap

def maps(seed, *, side=6, density=0.2, border=False, kind="noise"):
    rng = np.random.default_rng(seed)
    for number in range(1000):
        walls = rng.random((side, side)) < density
        walls[0, 0] = walls[-1, -1] = False
        yield f"{kind}-{number}", walls, (0, 0), (side - 1, side - 1)

def unplaced(seed):
    yield "open", [[0, 0, 0]] * 3

def talks(seed):
    print("one map")
    yield "only", np.zeros((4, 4), bool)

def few(seed):
    yield "only", np.zeros((4, 4), bool)

def rubbish(seed):
    yield "good", np.zeros((4, 4), bool)
    yield 17
    yield "flat", np.zeros(4, bool)
    yield "words", [["a", "b"]]
    yield "greys", np.full((3, 3), 7)
    yield "outside", np.zeros((3, 3), bool), (0, 0), (3, 0)
    yield "no cell", np.zeros((3, 3), bool), 1, (0, 0)
    yield "ragged", [[0, 1], [0]]
    yield "empty", np.zeros((0, 3), bool)
    yield None

def metres(seed):
    yield CensusMap("good", np.eye(4, dtype=np.uint8))
    yield CensusMap("list", [[0, 1], [0]])
    yield CensusMap("flat", np.zeros(4, bool))
    yield CensusMap("greys", np.full((3, 3), 7))
    yield CensusMap("none", np.zeros((4, 4), bool), float("nan"))
    yield CensusMap("word", np.zeros((4, 4), bool), "1 m")

def alike(seed):
    walls = np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]])
    for name in ("m", "m", "m-2", "n" * 300, "\\udcff"):
        yield name, walls, (0, 0), (2, 2)

def breaks(seed):
    yield "good", np.zeros((4, 4), bool)
    raise RuntimeError("out of mazes")

def breaks_at_once(seed):
    raise RuntimeError("no mazes")

def leaves(seed):
    raise SystemExit(3)

def no_seed(size=3):
    return []

nothing = lambda seed: []
number = 17
gives_a_number = lambda seed: 17
"""


@pytest.fixture
def generator(tmp_path):
    path = tmp_path / "adapter.py"
    path.write_text(GENERATOR)
    return lambda name: f"{path}:{name}"


def objects(*args):
    result = worldgen("census", *args, "--json")
    assert result.code == 0, result.err
    return json.loads(result.out)


def test_a_folder_gives_a_table_with_a_column_a_radius(tmp_path):
    write_each_kind(tmp_path)
    result = worldgen("census", tmp_path, "--radius", "0.5c", "--radius", "0.7c", "--seed", 1)
    assert result.code == 0
    head, _, columns, *_ = result.out.splitlines()
    assert head.startswith(
        "5 maps of 9 x 7 cells, 0 refused; 5 starts and targets, 3 named by the map, 2 drawn"
    )
    assert columns.split() == ["0.5", "cells", "0.7", "cells"]
    assert "reachable for the disc" in result.out and "100.0 % (47.8 to 100.0)" in result.out


def test_json_has_counts_shares_and_intervals(tmp_path):
    write_each_kind(tmp_path)
    found = objects(tmp_path, "--radius", "0.5c", "--seed", 1)
    (radius,) = found["radii"]
    assert radius["reachable"] == {
        "count": 5,
        "share": 1.0,
        "interval": [pytest.approx(0.4782, abs=1e-4), 1.0],
    }
    assert found["pairs"] == {"named": 3, "drawn": 2} and radius["undecided"]["count"] == 0


def test_equal_seeds_write_equal_bytes(tmp_path, generator):
    for name in ("a.csv", "b.csv"):
        worldgen("census", generator("maps"), "--count", 5, "--seed", 3, "--csv", tmp_path / name)
    first = (tmp_path / "a.csv").read_bytes()
    assert first == (tmp_path / "b.csv").read_bytes() and first.count(b"\n") == 16


def test_csv_has_a_line_a_question(tmp_path, generator):
    table = tmp_path / "t.csv"
    worldgen(
        "census", generator("few"), "--pairs", 2, "--radius", "0.3c", "--seed", 1, "--csv", table
    )
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert [(row["map"], row["pair"], row["named"]) for row in rows] == [
        ("only", "0", "0"),
        ("only", "1", "0"),
    ]
    assert rows[0]["result"] == "reachable" and rows[0]["radius"] == "0.03"


def test_options_of_a_generator_become_what_their_defaults_are(generator):
    found = objects(
        generator("maps"), "--count", 3, "--seed", 1, "--option", "side=9", "--option", "density=0"
    )
    assert found["maps"] == 3 and found["radii"][0]["reachable"]["count"] == 3


def test_kept_worlds_are_grid_files_whose_cuts_hold(tmp_path):
    write_octile(tmp_path / "a.map")
    write_scenario(tmp_path / "a.scen", "a.map", start=(3, 2), target=(3, 6))
    out = tmp_path / "kept"
    result = worldgen("census", tmp_path, "--radius", "0.7c", "--seed", 1, "--out", out)
    (file,) = out.iterdir()
    assert file.name == "parted-a.map-0-r0.07.grid" and "1 worlds kept" in result.err
    world = read_world(file)
    assert check_certificate(world).valid and world.provenance.params["map"] == "a.map"


def test_what_cannot_be_read_is_listed_and_the_rest_judged(tmp_path):
    write_text(tmp_path / "good.txt")
    (tmp_path / "bad.map").write_text("type octile\nheight 1\nwidth 2\nmap\n.x\n")
    (tmp_path / "bad.npy").write_bytes(b"\x93NUMPY\x01\x00")
    (tmp_path / "README.md").write_text("words")
    found = objects(tmp_path, "--seed", 1)
    assert found["maps"] == 1 and [one["name"] for one in found["refused"]] == [
        "bad.map",
        "bad.npy",
    ]
    assert found["refused"][0]["reason"].startswith("line 5: character 'x' at column 2")


def test_a_scenario_of_another_size_is_listed_and_the_map_judged_with_drawn_ends(tmp_path):
    write_octile(tmp_path / "a.map")
    write_scenario(tmp_path / "a.scen", "a.map", rows=GAP[:5])
    found = objects(tmp_path, "--seed", 1)
    assert found["pairs"] == {"named": 0, "drawn": 1}
    assert found["refused"][0]["name"] == "a.map (its scenarios)"


def test_a_map_of_the_thesis_brings_its_own_start_and_target(tmp_path):
    write_world(
        World(np.pad(np.zeros((8, 8), bool), 1, constant_values=True), Pose(0.3, 0.3), TARGET),
        tmp_path / "w.grid",
    )
    worldgen("export", tmp_path / "w.grid", "--to", "thesis", "--out", tmp_path / "old.gex")
    found = objects(tmp_path / "old.gex", "--seed", 1)
    assert (
        found["pairs"] == {"named": 1, "drawn": 0} and found["radii"][1]["reachable"]["count"] == 1
    )


def test_a_world_that_changes_with_time_is_refused(tmp_path):
    worldgen("fire", "--size", 12, "--seed", 1, "--out", tmp_path / "f.grid")
    result = worldgen("census", tmp_path, "--seed", 1)
    assert (
        result.code == 2
        and "f.grid: the world changes with time; a census judges static maps" in result.err
    )


def test_what_a_generator_yields_wrongly_is_listed_and_the_rest_judged(generator):
    refused = {
        one["name"]: one["reason"] for one in objects(generator("rubbish"), "--seed", 1)["refused"]
    }
    expected = {
        "map 2": "a int was yielded",
        "flat": "shape (4,)",
        "words": "type <U1",
        "greys": "other than 0 and 1",
        "outside": "target (3, 0) is outside",
        "no cell": "start 1 is not a cell",
        "ragged": "shape (0,)",
        "empty": "3 x 0 cells",
        "map 10": "a NoneType was yielded",
    }
    assert refused.keys() == expected.keys()
    assert all(part in refused[name] for name, part in expected.items())


def test_maps_in_metres_are_checked_like_the_others(generator):
    found = objects(generator("metres"), "--seed", 1, "--radius", "0.7c")
    assert found["maps"] == 1
    assert {one["name"]: one["reason"].split("; ")[0] for one in found["refused"]} == {
        "list": "the walls have shape (0,) and type float64",
        "flat": "the walls have shape (4,) and type bool",
        "greys": "the walls have values other than 0 and 1",
        "none": "cell_size=nan m is outside 1e-06 to 1e+06 m",
        "word": "cell_size='1 m' is not a number",
    }


def test_maps_of_one_name_and_of_odd_names_are_counted_and_kept_apart(generator, tmp_path):
    table, kept = tmp_path / "t.csv", tmp_path / "kept"
    found = objects(
        generator("alike"), "--seed", 1, "--radius", "0.6c", "--csv", table, "--out", kept
    )
    assert found["maps"] == found["pairs"]["named"] == len(list(kept.iterdir())) == 5
    names = [line.split(",")[0] for line in table.read_text().splitlines()[1:]]
    assert names == ["m", "m-2", "m-2-2", "n" * 300, "\\udcff"]


def test_a_generator_that_breaks_leaves_the_table_of_what_came_before(generator):
    result = worldgen("census", generator("breaks"), "--seed", 1)
    assert result.code == 2 and result.out.startswith("1 map of 4 x 4 cells")
    assert (
        "map 2 failed: RuntimeError: out of mazes; the table covers the 1 map before it"
        in result.err
    )


def test_ctrl_c_leaves_the_table_of_what_came_before(generator, monkeypatch):
    def stop(*args, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("worldgen.interop.census.take.draw_ends", stop)
    result = worldgen("census", generator("few"), "--seed", 1)
    assert (
        result.code == 130
        and "interrupted after 0 maps" in result.err
        and result.out.startswith("0 maps")
    )


WRONG = [
    (["none"], "no map could be judged; the first reason: none: cannot be read: No such file"),
    (["EMPTY"], "holds no map; `worldgen formats` lists"),
    (
        ["EMPTY/words.md"],
        "no map could be judged; the first reason: words.md: is not a map in a known format",
    ),
    (["GEN:maps", "--radius", "0"], "radius=0 m is outside"),
    (["GEN:maps", "--radius", "1e10"], "radius=1e+10 m is outside"),
    (["GEN:maps", "--radius", "wide"], "radius='wide' is not a radius"),
    (["GEN:maps", "--option", "side"], "option='side' is not NAME=VALUE"),
    (
        ["GEN:maps", "--option", "depth=3"],
        "has no option 'depth'; it has side, density, border, kind",
    ),
    (["GEN:maps", "--option", "side=big"], "option side='big' is not a whole number"),
    (["GEN:maps", "--option", "border=perhaps"], "option border='perhaps' is not yes or no"),
    (["GEN:maps", "--cell-size", "0"], "cell_size=0 m is outside"),
    (["GEN:none"], "has no 'none'"),
    (["GEN:number"], "is a int; name a function"),
    (["GEN:gives_a_number"], "'int' object is not iterable"),
    (["GEN:no_seed"], "takes no seed; write it as def maps(seed)"),
    (["GEN:nothing"], "no map could be judged; the first reason: it gave none"),
    (["GEN:breaks_at_once"], "failed: RuntimeError: no mazes"),
    (["GEN:leaves"], "ends Python (SystemExit: 3)"),
    (["./none.py:maps"], "no such file"),
    (["EMPTY", "--option", "side=3"], "an option is for a generator, but none is named"),
    (["GEN:few", "--out", "EMPTY/words.md"], "is a file; choose a folder"),
    (["GEN:few", "--out", "EMPTY"], "is not empty; use --force"),
    (["GEN:few", "--csv", "EMPTY/words.md"], "already exists"),
]


@pytest.mark.gate
@pytest.mark.parametrize(("args", "message"), WRONG, ids=[" ".join(args) for args, _ in WRONG])
def test_wrong_input_is_one_sentence_and_code_2(tmp_path, generator, args, message):
    folder = tmp_path / "empty"
    folder.mkdir()
    (folder / "words.md").write_text("words\n")
    given = [arg.replace("EMPTY", str(folder)).replace("GEN:", generator("")) for arg in args]
    result = worldgen("census", *given, "--count", 2, "--seed", 1)
    assert result.code == 2 and message in result.err
    assert (
        result.err.replace("loading\n", "").count("\n") <= 2
        and "Traceback" not in result.err
        and not result.out
    )


def test_the_largest_radius_is_blocked_everywhere_and_soon(generator):
    found = objects(
        generator("maps"), "--count", 5, "--radius", "2000", "--radius", "20000c", "--seed", 1
    )
    assert [radius["no_room"]["count"] for radius in found["radii"]] == [5, 5]


def test_a_generator_may_name_no_ends_and_hand_over_lists(generator):
    assert objects(generator("unplaced"), "--seed", 1)["pairs"] == {"named": 0, "drawn": 1}


def test_what_a_generator_prints_goes_to_stderr(generator):
    result = worldgen("census", generator("talks"), "--seed", 1, "--json")
    assert json.loads(result.out)["maps"] == 1 and "one map" in result.err


def test_arrays_are_read_top_row_first(tmp_path):
    np.save(tmp_path / "a.npy", np.array([[1, 0], [0, 0]], np.uint8))
    worldgen("import", tmp_path / "a.npy", "--radius", 0.04, "--out", tmp_path / "w.grid")
    assert read_world(tmp_path / "w.grid").walls.tolist() == [[False, False], [True, False]]


def test_the_page_names_every_option_and_every_key():
    page = (Path(__file__).parents[2] / "docs" / "howto" / "census.md").read_text()
    options = [
        option
        for parameter in command.params
        for option in parameter.opts
        if option.startswith("--")
    ]
    assert [word for word in [*options, *ROWS, *CSV_COLUMNS] if f"`{word}" not in page] == []
