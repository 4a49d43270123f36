"""A proof covers what was read: nothing in a map's file is skipped in silence."""

import importlib.resources
from pathlib import Path

import pytest

from tests.helpers.foreign_samples import LACKING, READABLE, samples
from tests.helpers.unread_parts import INJECTIONS, WITH_METADATA
from worldgen.errors import FormatError, InvalidWorld
from worldgen.generation import generate
from worldgen.interop import ImportedRobot, export_world, import_world, read_map, write_export

CASES = [
    (name, label)
    for name, (_, changes) in INJECTIONS.items()
    if name in READABLE
    for label in changes
]
SAMPLES = [(name, number) for name in READABLE for number in range(len(samples(name)))]
MAPS = Path(str(importlib.resources.files("corpora"))) / "maps"


def put_down(folder, files):
    """Write files, and return the path of the main one."""
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return folder / next(iter(files))


def test_every_format_that_is_read_has_unknown_obstacles_to_try():
    assert set(INJECTIONS) == {*READABLE, *LACKING}
    assert all(len(changes) >= 2 for _, changes in INJECTIONS.values())


@pytest.mark.parametrize(("name", "label"), CASES, ids=[f"{a}-{b}" for a, b in CASES])
def test_an_unknown_obstacle_is_read_or_the_map_is_not_certified(name, label, tmp_path):
    number, changes = INJECTIONS[name]
    files = samples(name)[number]
    plain = read_map(put_down(tmp_path, files), name)
    assert plain.unread == ()
    changed = changes[label](files)
    assert changed != files
    for old in files:
        (tmp_path / old).unlink()
    path = put_down(tmp_path, changed)
    try:
        found = read_map(path, name)
    except (FormatError, InvalidWorld):
        return
    if found.unread:
        # The importer is the same for all formats.
        if label == next(iter(changes)):
            imported = import_world(path, ImportedRobot(radius=found.cell_size / 4), name=name)
            assert (imported.decision.result, imported.world.certificate) == ("undecided", None)
            assert imported.world.unread == found.unread
        return
    same_shape = found.walls.shape == plain.walls.shape
    assert (
        same_shape and (found.walls & ~plain.walls).any() and not (plain.walls & ~found.walls).any()
    )


@pytest.mark.parametrize(("name", "number"), SAMPLES)
def test_a_plain_file_is_read_whole(name, number, tmp_path):
    assert read_map(put_down(tmp_path, samples(name)[number]), name).unread == ()


@pytest.mark.parametrize("label", WITH_METADATA)
def test_what_programs_write_besides_walls_keeps_no_map_from_its_proof(label, tmp_path):
    path = put_down(tmp_path, WITH_METADATA[label])
    found = read_map(path)
    assert found.unread == ()
    imported = import_world(path, ImportedRobot(radius=found.cell_size / 4))
    assert imported.world.certificate is not None


@pytest.mark.parametrize(
    "options",
    [
        "sdf+robot",
        "sdf+robot+plugins=fortress",
        "sdf+plugins=harmonic",
        "glb+floor+markers",
        "irsim+walls=image+lidar",
        "irsim+robot=omni",
        "ros+image=png+mode=raw",
        "ros+mode=scale+negate",
        "obj+floor",
        "stl+floor",
    ],
)
def test_whatever_export_writes_is_read_whole(options, tmp_path):
    world = generate("maze", 1, size=13)
    path = write_export(export_world(world, options), tmp_path)[0]
    assert import_world(path).world.certificate is not None


@pytest.mark.parametrize(
    "path", [MAPS / "maze-32-32-2.map", MAPS / "mrpt-uwb-demo.yaml"], ids=["maze", "office"]
)
def test_the_shipped_maps_are_read_whole(path):
    assert read_map(path).unread == ()
