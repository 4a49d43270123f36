"""Properties of every registered format; each also has its own tests."""

import hashlib
import re
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.bags import WHY_NOT, drive, write_bag
from tests.helpers.command_line import worldgen
from tests.helpers.foreign_samples import AS_OTHERS_WRITE, LACKING
from tests.helpers.raising import raises
from worldgen.cli.main import cli
from worldgen.errors import FormatError, InvalidParameter, InvalidWorld, OutputError
from worldgen.family import FAMILIES
from worldgen.files.grid import dumps, read_world, write_world
from worldgen.files.worlds import files_in, read_worlds
from worldgen.generation import generate
from worldgen.interop import (
    FORMATS,
    Destination,
    Exported,
    Format,
    ImportedRobot,
    export_world,
    find_format,
    guess_format,
    import_world,
    read_map,
    write_export,
)
from worldgen.interop.exporting import frozen_at
from worldgen.interop.format import PLAIN_FACTS, decimal, foreign_map
from worldgen.interop.format.foreign_map import origin_of
from worldgen.timeline import CellState, Timeline
from worldgen.world import Pose, Provenance, Target, World

PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "formats.md").read_text()
BOTH_WAYS = [name for name in FORMATS if FORMATS.get(name).direction == "both"]
WRITTEN = [name for name in FORMATS if FORMATS.get(name).write is not None]
# Families have these sizes; micromouse mazes need odd ones and the thesis's maps need even ones.
SIZES = (13, 16)


def room(**changes):
    """A closed room of 6 x 6 cells that every format except micromouse accepts."""
    walls = np.ones((6, 6), np.bool_)
    walls[1:-1, 1:-1] = False
    return replace(
        World(walls, Pose(0.15, 0.15), Target(0.45, 0.45, 0.05), robot_radius=0.04), **changes
    )


@st.composite
def family_worlds(draw):
    """A world of any family, with numbers as unusual as a file may have to hold."""
    size = draw(st.sampled_from(SIZES))
    world = generate(draw(st.sampled_from(FAMILIES.names())), draw(st.integers(0, 3)), size=size)
    return replace(
        world,
        start=replace(
            world.start,
            heading=draw(st.floats(-3.2, 3.2) | st.sampled_from([0.0, np.pi / 2, -np.pi])),
        ),
        target=replace(world.target, radius=draw(st.floats(0.01, 1.0))),
        robot_speed=draw(st.floats(0.1, 30.0)),
    )


origins = st.tuples(*[st.sampled_from([0.0, -10.0, 1.25]) | st.floats(-1e4, 1e4)] * 2)


def back(folder, world, name, **options):
    """Return the world that is read from a file, and the map as stored in the file."""
    export = export_world(world, name, **options)
    path = write_export(export, folder, force=True)[0]
    assert find_format(path).name == name
    return import_world(path).world, read_map(path)


@pytest.mark.nightly
@pytest.mark.parametrize("name", BOTH_WAYS)
@settings(max_examples=20)
@given(family_worlds(), origins)
def test_import_after_export_is_the_same_world(name, tmp_path, world, origin):
    try:
        again, found = back(tmp_path, world, name, origin=origin, at=0.0)
    except InvalidWorld as refusal:
        assert (
            len(str(refusal)) > 20
        )  # the thesis's maps are closed squares, and micromouse mazes have posts
        return
    assert np.array_equal(again.walls, frozen_at(world, 0.0).walls)
    assert again.start == world.start and again.target == world.target
    for number in ("cell_size", "robot_radius", "robot_speed"):
        assert getattr(again, number) == getattr(world, number)
    assert found.origin == origin == origin_of(again)


@pytest.mark.parametrize("name", ["stl", "obj", "glb"])
def test_an_origin_of_many_digits_comes_back(name, tmp_path):
    world = generate("maze", 1, size=13)
    origin = (-2.4667304188517965e-07, 1234.5678901234567)
    again, found = back(tmp_path, world, name, origin=origin)
    assert np.array_equal(again.walls, world.walls) and again.cell_size == world.cell_size
    assert found.origin == origin == origin_of(again)


@pytest.mark.parametrize("name", BOTH_WAYS)
def test_without_the_sidecar_the_cells_come_back(name, tmp_path):
    for size in SIZES:
        world = replace(generate("maze", 1, size=size, robot_radius=0.04), certificate=None)
        try:
            export = export_world(world, name, sidecar=False)
        except InvalidWorld:
            continue
        path = write_export(export, tmp_path)[0]
        assert not list(tmp_path.glob("*.worldgen.grid"))
        assert np.array_equal(read_map(path).walls, world.walls)
        return
    pytest.fail(f"{name} takes no maze")


@pytest.mark.parametrize("name", WRITTEN)
def test_a_world_that_changes_is_written_as_such_or_refused_until_a_time_is_given(name):
    changing = room(timeline=Timeline.of([(1.0, 3, 3, CellState.SOLID)]))
    if FORMATS.get(name).changes:
        assert export_world(changing, name).data != export_world(room(), name).data
    else:
        with raises(InvalidWorld, "world-changes", changes=1):
            export_world(changing, name)
    still = _or_none(changing, name, at=0.5)
    if still is not None:
        assert still.data == export_world(room(), name).data
        assert (
            "the world's 1 changes are not stored; the file has the cells at 0.5 s" in still.notes
        )


def _or_none(world, name, **options):
    try:
        return export_world(world, name, **options)
    except InvalidWorld:
        return None


@pytest.mark.parametrize("name", WRITTEN)
def test_the_same_world_is_the_same_bytes(name):
    export = _or_none(generate("maze", 1, size=13), name)
    if export is not None:
        assert export.files == export_world(generate("maze", 1, size=13), name).files


@pytest.mark.parametrize("name", FORMATS.names())
def test_the_table_of_formats_has_a_row_with_way_and_command(name):
    known = FORMATS.get(name)
    row = re.search(rf"^\| `{name}` \| (\w+) \| (.+) \|(.*)\| (.+) \|$", PAGE, re.MULTILINE)
    assert row is not None and row[1] == known.direction and "worldgen " in row[4]
    assert ("everything" in row[2]) == (known.holds >= PLAIN_FACTS)


def commands_of_the_table():
    """Return the commands in the page's table, by the format of their row."""
    return re.findall(r"^\| `(\w+)` \|.*`worldgen ((?:ex|im)port [^`]*)` \|$", PAGE, re.MULTILINE)


def test_the_table_has_a_command_for_every_format():
    assert [name for name, _ in commands_of_the_table()] == sorted(FORMATS.names())


@pytest.fixture(scope="module")
def world_of_the_page(tmp_path_factory):
    """The world that the page's first command makes."""
    folder = tmp_path_factory.mktemp("page")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        line = re.search(r"^\$ worldgen (.* --out w.grid)\n(.*)$", PAGE, re.MULTILINE)
        done = worldgen(*line[1].split())
    assert done.code == 0 and line[2] in (done.out + done.err).splitlines()
    return folder / "w.grid"


@pytest.mark.gate
@pytest.mark.parametrize("name", FORMATS.names())
def test_the_tables_command_works_on_the_world_of_the_page(
    name, world_of_the_page, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    shutil.copy(world_of_the_page, "w.grid")
    words = dict(commands_of_the_table())[name].split()
    if not FORMATS.get(name).write and name in AS_OTHERS_WRITE:  # which nothing here writes
        if name in LACKING:
            pytest.skip("pip install 'worldgen[collada,dxf]'")
        Path("w.grid").unlink()
        Path(words[1]).write_bytes(next(iter(AS_OTHERS_WRITE[name][0].values())))
    if name == "bag":
        if WHY_NOT:
            pytest.skip(WHY_NOT)
        write_bag(tmp_path / "run", drive(through=True)).rename("run.mcap")
    done = worldgen(*words)
    assert done.code == 0, done.err
    # sdf's reader reads every Gazebo file, including barn's.
    is_read_back = FORMATS.get(name).read is not None or name == "barn"
    if words[0] == "export" and is_read_back:
        imported = worldgen("import", words[-1], "--out", "back.grid")
        assert imported.code == 0, imported.err
        assert np.array_equal(
            read_world(Path("back.grid")).walls, read_world(world_of_the_page).walls
        )


@pytest.mark.gate
@pytest.mark.parametrize("ending", ["usda"])
def test_a_file_of_a_format_that_is_only_written_is_refused_as_such(ending, tmp_path):
    (tmp_path / f"w.{ending}").write_bytes(b"solid")
    name = guess_format(f"w.{ending}")
    with raises(FormatError, "only-written", suffix=f".{ending.lower()}", formats=name):
        find_format(tmp_path / f"w.{ending}")


@pytest.mark.parametrize("text", ["[[1, 0], [0, 1]]", '[["r", 1],\n [1, "g"]]\n', "\ufeff[ [1] ]"])
def test_a_maze_map_is_refused_as_what_it_is_and_not_as_another_programs_json(text, tmp_path):
    (tmp_path / "maze.json").write_text(text, "utf-8")
    with raises(FormatError, "only-written", format="pointmaze"):
        find_format(tmp_path / "maze.json")


def test_the_page_names_every_option_of_export():
    options = [
        word
        for known in cli.get_command(None, "export").params
        for word in known.opts
        if word[:2] == "--"
    ]
    assert [word for word in options if f"`{word}`" not in PAGE] == []


def test_the_pages_own_format_works(tmp_path):
    code = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1]
    (tmp_path / "count.py").write_text(code)
    write_world(room(), tmp_path / "w.grid")
    name = f"{tmp_path / 'count.py'}:count+letter=o"
    assert (
        worldgen("export", tmp_path / "w.grid", "--to", name, "--out", tmp_path / "n.txt").code == 0
    )
    assert (tmp_path / "n.txt").read_text() == "o" * 20


def test_an_edit_of_the_file_counts_and_the_sidecar_is_for_the_rest(tmp_path):
    export = export_world(room(robot_speed=3.0), "thesis")
    write_export(export, tmp_path)
    sidecar = tmp_path / "world.gex.worldgen.grid"
    sidecar.write_text(sidecar.read_text().replace("robot_speed = 3.0", "robot_speed = 4.5"))
    assert import_world(tmp_path / "world.gex").world.robot_speed == 4.5


def test_a_sidecar_of_another_map_is_passed_over_with_a_warning(tmp_path):
    write_export(export_world(room(), "thesis"), tmp_path)
    sidecar = tmp_path / "world.gex.worldgen.grid"
    sidecar.write_text(re.sub(r"(?m)^([#.]{6})$", r"\1#", sidecar.read_text()))
    imported = import_world(tmp_path / "world.gex")
    assert "a map of 7 x 6 cells, not 6 x 6; it was ignored" in imported.warnings[0]
    assert imported.world.robot_radius != 0.04


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"", "empty"),
        (dumps(room()), "not-a-sidecar"),
        (
            dumps(room(provenance=Provenance("export", 1, 0, {"kept": [["start"]]}))),
            "not-a-sidecar",
        ),
        (dumps(room(provenance=Provenance("export", 2, 0, {"kept": ["start"]}))), "other-version"),
    ],
)
def test_a_sidecar_that_cannot_be_read_is_refused_with_its_own_way_out(tmp_path, content, code):
    write_export(export_world(room(), "thesis", sidecar=False), tmp_path)
    (tmp_path / "world.gex.worldgen.grid").write_bytes(content)
    with raises(FormatError, code) as caught:
        read_map(tmp_path / "world.gex")
    assert "export the world again" in str(caught.value)


def test_the_rule_that_a_sidecar_breaks_is_in_the_message_with_its_line(tmp_path):
    write_export(export_world(room(), "thesis"), tmp_path)
    sidecar = tmp_path / "world.gex.worldgen.grid"
    sidecar.write_text(sidecar.read_text().replace("robot_radius = ", 'robot_radius = "a" #'))
    with raises(FormatError, "wrong-type", line=3) as caught:
        read_map(tmp_path / "world.gex")
    assert str(caught.value).endswith(
        "; write a number, like 0.1, or delete it, or export the world again"
    )


def test_an_export_deletes_a_sidecar_but_no_world_that_has_its_name(tmp_path):
    sidecar = tmp_path / "world.gex.worldgen.grid"
    write_world(room(), sidecar)
    kept = sidecar.read_bytes()
    export = export_world(room(), "thesis", sidecar=False)
    write_export(export, tmp_path)
    assert sidecar.read_bytes() == kept
    sidecar.unlink()
    write_export(export_world(room(), "thesis"), tmp_path, force=True)
    write_export(export, tmp_path, force=True)
    assert not sidecar.exists()


def test_a_sidecar_is_a_world_but_not_another_one_of_its_folder(tmp_path):
    write_export(export_world(room(), "thesis"), tmp_path)
    sidecar = tmp_path / "world.gex.worldgen.grid"
    assert np.array_equal(read_world(sidecar).walls, room().walls)
    assert files_in(tmp_path) == []
    write_world(room(), tmp_path / "w.grid")
    with zipfile.ZipFile(tmp_path / "both.zip", "w") as archive:
        for name in ("w.grid", sidecar.name):
            archive.write(tmp_path / name, name)
    assert [place.name for place, _ in read_worlds([tmp_path / "both.zip"])] == ["w.grid"]


def test_what_lies_in_the_way_is_overwritten_only_when_forced_and_then_with_its_sidecar(tmp_path):
    write_export(export_world(room(), "thesis"), tmp_path)
    before = (tmp_path / "world.gex").read_bytes()
    (tmp_path / "world.gex").unlink()
    with raises(OutputError, "file-exists"):
        write_export(export_world(room(), "thesis"), tmp_path)
    assert not (tmp_path / "world.gex").exists()
    write_export(export_world(room(), "thesis", sidecar=False), tmp_path, force=True)
    assert (tmp_path / "world.gex").read_bytes() == before and not (
        tmp_path / "world.gex.worldgen.grid"
    ).exists()


def test_the_origin_of_an_imported_map_is_where_its_exports_lie(tmp_path):
    imported = import_world(
        Path(__file__).parents[2] / "corpora" / "maps" / "mrpt-uwb-demo.yaml"
    ).world
    made = replace(
        imported.provenance, params={**imported.provenance.params, "origin": [-7.5, 2.25]}
    )
    assert origin_of(replace(imported, provenance=made)) == (-7.5, 2.25)
    assert origin_of(replace(imported, provenance=None)) == (0.0, 0.0)
    huge = replace(imported.provenance, params={"origin": [(1 << 1024) - 1, 0]})
    assert origin_of(replace(imported, provenance=huge)) == (0.0, 0.0)


def test_another_robot_in_an_imported_map_stands_where_the_map_stood(tmp_path):
    path = write_export(export_world(room(), "ros", origin=(-7.5, 2.25)), tmp_path)[0]
    write_world(import_world(path).world, tmp_path / "w.grid")
    assert origin_of(import_world(tmp_path / "w.grid", ImportedRobot(radius=0.03)).world) == (
        -7.5,
        2.25,
    )


def test_at_a_time_what_burns_is_solid_and_later_changes_are_not_there_yet():
    line = Timeline.of(
        [(1.0, 2, 2, CellState.BURNING), (2.0, 2, 2, CellState.FREE), (2.0, 0, 0, CellState.FREE)]
    )
    world = room(timeline=line)
    solid = [bool(frozen_at(world, time).walls[2, 2]) for time in (0.0, 1.0, 1.9, 2.0)]
    assert solid == [False, True, True, False] and not frozen_at(world, 2.0).walls[0, 0]
    with raises(InvalidParameter, "below-minimum"):
        frozen_at(world, -1.0)


@given(st.floats(-1e12, 1e12), st.floats(-1e12, 1e12))
def test_coordinates_in_files_are_exact_sums_of_decimals(value, shift):
    from fractions import Fraction

    assert Fraction(decimal(value, shift)) == Fraction(repr(value)) + Fraction(repr(shift))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("thesys", {"code": "unknown-name", "name": "thesys", "noun": "format", "near": "thesis"}),
        ("grid", {"code": "only-read", "format": "grid"}),
        (
            "thesis+nois=on",
            {"code": "unknown-name", "name": "nois", "owner": "format thesis on export"},
        ),
        ("thesis+noise=maybe", {"code": "unknown-name", "name": "noise", "value": "maybe"}),
        ("thesis+noise", {"code": "missing-value", "name": "noise", "owner": "thesis"}),
        ("worldgen.world:World", {"code": "wrong-type", "name": "worldgen.world:World"}),
        ("+noise=on", {"code": "wrong-form", "text": "+noise=on"}),
        ("thesis+=on", {"code": "wrong-form"}),
        ("thesis+noise=on+noise=off", {"code": "twice", "option": "noise"}),
    ],
)
def test_a_wrong_format_or_option_is_one_sentence(name, expected):
    with raises(InvalidParameter, **expected):
        export_world(room(), name)


def test_a_format_is_guessed_from_the_ending_of_the_file():
    assert guess_format("old.GEX") == "thesis"
    with raises(InvalidParameter, "unknown-suffix"):
        guess_format("w.doc")


def test_a_format_that_declares_its_options_wrongly_is_refused():
    def write(world, to, letter):
        return Exported({to.name: b""})

    with raises(InvalidParameter, "wrong-declaration", name="letter", owner="format 'x'"):
        Format("x", "x", (".x",), write=write)
    with raises(InvalidParameter, "wrong-declaration", name="x"):
        Format("x", "x", (".x",), holds=frozenset({"colour"}))


def test_export_says_on_stderr_what_the_file_does_not_hold_and_where_it_is(tmp_path):
    write_world(room(), tmp_path / "w.grid")
    done = worldgen("export", tmp_path / "w.grid", "--out", tmp_path / "w.gex", "--origin", "1,2")
    assert done.code == 0 and "the robot's radius is not stored" in done.err
    assert "not stored: the origin (1, 2) m\n" in done.err
    assert "the exact values are in w.gex.worldgen.grid\n" in done.err
    assert str(tmp_path / "w.gex.worldgen.grid") in done.out
    assert worldgen("import", tmp_path / "w.gex", "--out", tmp_path / "again.grid").code == 0
    assert read_world(tmp_path / "again.grid").provenance.params["origin"] == [1.0, 2.0]


@pytest.mark.parametrize(("less", "said"), [(0, False), (1, True)])
def test_a_file_that_import_refuses_for_its_size_is_said_to_be_so(monkeypatch, less, said):
    size = len(export_world(room(), "npy").data)
    known = replace(FORMATS.get("npy"), most_bytes=size - less)
    monkeypatch.setattr(FORMATS, "get", lambda _: known)
    notes = export_world(room(), "npy").notes
    assert (
        any(f"up to {size - less} bytes, but this one has {size}; keep" in note for note in notes)
        == said
    )


@pytest.mark.parametrize("name", FORMATS.names())
def test_formats_says_what_can_be_asked_of_each(name):
    known = FORMATS.get(name)
    shown = worldgen("formats", name)
    assert shown.code == 0 and shown.out.startswith(f"{name} ({known.direction}): ")
    for flag, options in (("--from", known.read_options), ("--to", known.write_options)):
        assert all(
            f"{flag} {name}+{option.name}=" in shown.out and option.help for option in options
        )


@pytest.mark.parametrize("origin", [(np.inf, 0.0), (0.0, -1e13), (np.nan, 0.0)])
def test_an_origin_that_no_cell_is_near_is_refused(origin):
    with raises(InvalidParameter, "out-of-range"):
        export_world(room(), "thesis", origin=origin)


def test_destinations_name_companions_and_shift_coordinates():
    destination = Destination("office.yaml", (0.1, -3.0))
    assert destination.sibling_file(".pgm") == "office.pgm"
    assert (destination.x(0.2), destination.y(1.25)) == ("0.3", "-1.75")
    with raises(InvalidParameter, "reserved-name", name="office.yaml"):
        destination.sibling_file(".yaml")


_FOLDER = """
import numpy as np
from worldgen.interop import ForeignMap, Format

def read(path):
    return ForeignMap(np.zeros((20, 20), bool), 0.1{params})

folder = Format('folder', 'cells', ('.cells',), read=read)
"""


@pytest.mark.parametrize("kind", ["folder", "larger file", "file that its reader hashes"])
def test_a_reader_of_ones_own_may_read_what_ours_would_not(kind, tmp_path, monkeypatch):
    mine = tmp_path / "mine.py"
    own = kind.endswith("hashes")
    mine.write_text(_FOLDER.format(params=", {'sha256': 'own'}" if own else ""))
    monkeypatch.setattr(foreign_map.read_bounded.__wrapped__, "__defaults__", (10,))
    source = tmp_path / "w.cells"
    if kind == "folder":
        source.mkdir()
    else:
        source.write_bytes(b"0" * 20)
    params = read_map(source, f"{mine}:folder").params
    expected = {"folder": None, "larger file": hashlib.sha256(b"0" * 20).hexdigest()}
    assert params.get("sha256") == expected.get(kind, "own")


def test_only_a_sidecar_next_to_its_map_is_left_out_of_a_folder(tmp_path):
    for name in ("own.worldgen.grid", "maze.map.worldgen.grid", "maze.map"):
        (tmp_path / name).touch()
    assert [file.name for file in files_in(tmp_path)] == ["own.worldgen.grid"]
