"""Import and export in the studio give the same bytes as the command line."""

import base64
import io
import json
import zipfile

import pytest

from tests.helpers.buildings import building_file
from tests.helpers.command_line import worldgen
from tests.helpers.foreign_samples import LACKING
from tests.helpers.raising import raises
from tests.helpers.studio import Answers, message_of
from worldgen import generate
from worldgen.errors import FormatError, InvalidParameter, WorldgenError
from worldgen.files.grid import read_world, write_world
from worldgen.interop import FORMATS

pytest.importorskip("starlette", reason="the studio's extra is not here")


MAZES = {"micromouse"}  # formats that cannot hold other worlds
WRITTEN = [
    name for name in FORMATS.names() if FORMATS.get(name).write is not None and name not in MAZES
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exchange")
    write_world(generate("corridor", 3), folder / "w.grid")
    write_world(generate("fire", 3), folder / "fire.grid")
    return folder


@pytest.fixture
def answers(folder):
    return Answers(folder)


def exported(answers, folder, world, name, **asked):
    """Return what the page gets for an export, by name: one file, or an archive's contents."""
    usual = {
        "name": "out" + FORMATS.get(name).suffixes[0],
        "world": message_of(read_world(folder / world)),
    }
    said = answers.ask("export", **({"format": name, "keep": False, **usual, **asked}))
    (file,) = said["files"]
    data = base64.b64decode(file["data"])
    if len(said["inside"]) == 1:
        return {file["name"]: data}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert file["name"] == "out.zip" and archive.namelist() == said["inside"]
        return {name: archive.read(name) for name in archive.namelist()}


def by_command(out, world, name, *words):
    """Return what the command line writes, by name."""
    out.mkdir()
    place = out / ("out" + FORMATS.get(name.partition("+")[0]).suffixes[0])
    assert worldgen("export", world, "--to", name, "--out", place, *words).code == 0
    return {path.name: path.read_bytes() for path in out.iterdir()}


@pytest.mark.gate
@pytest.mark.parametrize("name", WRITTEN)
def test_every_format_s_export_is_the_command_line_s(answers, folder, tmp_path, name):
    asked = {"at": 1.5, "origin": [0.5, -2], "sidecar": True}
    wanted = by_command(
        tmp_path / "out", folder / "fire.grid", name, "--at", "1.5", "--origin", "0.5,-2"
    )
    assert exported(answers, folder, "fire.grid", name, **asked) == wanted


@pytest.mark.nightly
@pytest.mark.parametrize("name", WRITTEN)
def test_every_option_of_a_format_is_offered_and_does_what_it_does_on_the_command_line(
    answers, folder, tmp_path, name
):
    (offered,) = [known for known in answers.ask("hello")["formats"] if known["name"] == name]
    options = {one["name"]: other_than_usual(one) for one in offered["options"]}
    words = "".join(f"+{option}={str(value).lower()}" for option, value in options.items())
    wanted = by_command(tmp_path / "out", folder / "w.grid", name + words, "--no-sidecar")
    assert exported(answers, folder, "w.grid", name, options=options, sidecar=False) == wanted
    assert [one["name"] for one in offered["options"]] == [
        one.name for one in FORMATS.get(name).write_options
    ]


@pytest.mark.parametrize("name", sorted(MAZES))
def test_a_world_that_a_format_does_not_hold_is_refused_as_on_the_command_line(
    answers, folder, tmp_path, name
):
    done = worldgen("export", folder / "w.grid", "--to", name, "--out", tmp_path / "out.maze")
    with pytest.raises(WorldgenError) as refused:
        exported(answers, folder, "w.grid", name)
    assert done.code != 0 and str(refused.value).strip() in done.err


def other_than_usual(option):
    """Return an allowed value that is not the default, if there is one."""
    usual = option["default"]
    if option["choices"]:
        return option["choices"][-1]
    return not usual if option["kind"] == "bool" else usual


def dropped(*places):
    return {
        "files": [
            {"name": one.name, "data": base64.b64encode(one.read_bytes()).decode()}
            for one in places
        ]
    }


@pytest.mark.parametrize("name", ["ros", "irsim", "tiled", "thesis", "movingai"])
def test_what_was_exported_is_dropped_together_and_imported_as_by_the_command_line(
    answers, folder, tmp_path, name
):
    out = tmp_path / "out"
    by_command(out, folder / "w.grid", name)
    main = out / ("out" + FORMATS.get(name).suffixes[0])
    scenario = ["--scen", f"{main}.scen"] if name == "movingai" else []
    assert worldgen("import", main, *scenario, "--out", tmp_path / "again.grid").code == 0
    brought = answers.ask("bring", **(dropped(*sorted(out.iterdir(), reverse=True))))
    assert brought["main"] == main.name
    assert brought["world"] == message_of(read_world(tmp_path / "again.grid"))


def test_a_scenario_that_is_dropped_with_its_map_gives_start_and_target(answers, tmp_path):
    (tmp_path / "a.map").write_text("type octile\nheight 4\nwidth 8\nmap\n" + "........\n" * 4)
    (tmp_path / "a.map.scen").write_text("version 1\n0\ta.map\t8\t4\t1\t1\t6\t2\t5.41421356\n")
    world = answers.ask("bring", **(dropped(tmp_path / "a.map", tmp_path / "a.map.scen")))["world"]
    assert (world["start"][:2], world["target"][:2]) == ([0.15, 0.25], [0.65, 0.15])


READ = [
    (known.name, option)
    for known in map(FORMATS.get, FORMATS.names())
    if known.name not in LACKING
    for option in known.read_options
]
OTHERS = {
    "agent": "b",
    "layer": "solid",
    "slice_height": 0.3,
    "unit": "cm",
    "cell_size": {"png": 0.099},
    "threshold": {"irsim": 0.3, "png": 200},
}


# Options that another one requires: read in centimetres, a world 3 m wide is only 3 cm wide.
ALONG = {"unit": {"slice_height": 0.005, "cell_size": 0.001}}


def file_of(name, folder, tmp_path):
    """A file of a format, with the files that it names, in its own folder."""
    place = tmp_path / "out" / ("out" + FORMATS.get(name).suffixes[0])
    if name == "micromouse":
        place.parent.mkdir()
        place.write_text("o---o---o\n| S     |\no   o   o\n|   | G |\no---o---o\n")
    elif name == "pogema":
        place.parent.mkdir()
        place.write_text("a....\n.###.\nb...B\n....A\n")
    elif name == "dae":
        place.parent.mkdir()
        place.write_bytes(building_file("dae"))
    elif name == "gltf":  # it can be read but not written; GLB holds the same
        by_command(place.parent, folder / "w.grid", "glb", "--no-sidecar")
        (glb,) = place.parent.iterdir()
        place.write_text(json_of(glb.read_bytes()))
        glb.unlink()
    else:
        by_command(place.parent, folder / "w.grid", name, "--no-sidecar")
    if name == "movingai":
        place.with_name(
            f"{place.name}.scen"
        ).unlink()  # it has only one problem, which would be used
    if name == "tiled":
        place.write_text(place.read_text().replace('"walls"', '"solid"'))
    return place


def json_of(glb):
    """The JSON of a GLB file, with its binary part in it."""
    length = int.from_bytes(glb[12:16], "little")
    tree = json.loads(glb[20 : 20 + length])
    binary = base64.b64encode(glb[28 + length :]).decode()
    tree["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{binary}"
    return json.dumps(tree)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "option"), READ, ids=[f"{name}-{option.name}" for name, option in READ]
)
def test_every_option_of_a_format_that_is_read_is_offered_and_does_what_it_does_by_the_command_line(
    answers, folder, tmp_path, name, option
):
    (known,) = [known for known in answers.ask("hello")["formats"] if known["name"] == name]
    (offered,) = [one for one in known["read_options"] if one["name"] == option.name]
    value = OTHERS.get(option.name) or other_than_usual(offered)
    value = value.get(name, 0.05) if isinstance(value, dict) else value
    main = file_of(name, folder, tmp_path)
    options = {option.name: value} | ALONG.get(option.name, {})
    named = "+".join([name, *(f"{key}={one}" for key, one in options.items())])
    words = ["--from", named, "--radius", "0.001", "--seed", "5"]
    assert worldgen("import", main, *words, "--out", tmp_path / "again.grid").code == 0
    asked = {"format": name, "options": options, "radius": 0.001, "seed": "5"}
    brought = answers.ask("bring", **(dropped(*main.parent.iterdir()) | asked))
    assert brought["world"] == message_of(read_world(tmp_path / "again.grid"))
    assert brought["format"] == name


def scenario_in(folder):
    """A MovingAI map of 8 x 4 cells with three problems next to it."""
    (folder / "a.map").write_text("type octile\nheight 4\nwidth 8\nmap\n" + "........\n" * 4)
    rows = [f"0\ta.map\t8\t4\t{column}\t1\t6\t2\t5\n" for column in (1, 2, 3)]
    (folder / "a.map.scen").write_text("version 1\n" + "".join(rows))
    return folder / "a.map", folder / "a.map.scen"


def test_a_row_of_a_scenario_is_chosen_of_dropped_files_and_of_the_folder_s(
    answers, folder, tmp_path
):
    pair = dropped(*scenario_in(tmp_path))
    said = [answers.ask("bring", **(pair | more)) for more in ({}, {"row": 3}, {"row": 0})]
    assert [(one["row"], one["rows"]) for one in said] == [(1, 3), (3, 3), (None, 3)]
    assert [one["world"]["start"][0] for one in said[:2]] == [0.15, 0.35]
    scenario_in(folder)
    said = [answers.ask("bring", **({"name": "a.map"} | more)) for more in ({}, {"row": 2})]
    assert [(one["row"], one["rows"]) for one in said] == [(None, 3), (2, 3)]
    assert said[1]["world"]["start"][0] == 0.25 != said[0]["world"]["start"][0]


def test_a_row_that_is_not_there_and_a_format_that_is_not_known_are_refused_by_their_names(
    answers, tmp_path
):
    main, scenario = scenario_in(tmp_path)
    (tmp_path / "b.bin").write_bytes(b"junk")
    for files, more, code, source in (
        ((main, scenario), {"row": 4}, "out-of-range", "a.map.scen"),
        ((scenario,), {}, "no-map-found", "a.map.scen"),
        ((tmp_path / "b.bin",), {}, "unknown-format", "b.bin"),
    ):
        with raises(FormatError, code) as caught:
            answers.ask("bring", **(dropped(*files) | more))
        assert caught.value.source == source
    with raises(InvalidParameter, "no-scenario"):
        answers.ask("bring", **(dropped(main) | {"row": 1}))


def test_a_map_without_what_it_names_and_two_maps_at_once_are_refused_in_a_sentence(
    answers, folder, tmp_path
):
    by_command(tmp_path / "out", folder / "w.grid", "ros")
    with raises(WorldgenError, "no-such-file", key="image", name="'out.pgm'", map="out.yaml"):
        answers.ask("bring", **(dropped(tmp_path / "out/out.yaml")))
    with raises(WorldgenError, "several-maps", names="fire.grid, w.grid", count=2):
        answers.ask("bring", **(dropped(folder / "fire.grid", folder / "w.grid")))


def test_names_with_spaces_and_letters_of_all_kinds_are_kept_and_paths_are_not(
    answers, folder, tmp_path
):
    by_command(tmp_path / "out", folder / "w.grid", "ros")
    said = dropped(tmp_path / "out/out.pgm", tmp_path / "out/out.yaml")
    said["files"][1]["name"] = "../../Büro ☃ 1.yaml"
    assert answers.ask("bring", **(said))["main"] == "Büro ☃ 1.yaml"
