"""Writing MJCF; MuJoCo itself is tested in tests/clients."""

import ast
import json
import re
from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.drawn_worlds import changing_worlds, drawn
from tests.helpers.exact_rays import solid_at
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.interop import export_world
from worldgen.timeline import CellState, Timeline

GOLDEN = Path(__file__).parent / "golden"
TINY = """
    #####
    #.#G#
    #...#
    #S..#
    ####."""
HOSTILE = ['a"b<c>&d', "__world__", "ä\x01\udcff", "]]>", "7", "\u202e", "-->"]


def tiny():
    """Walls that merge, a cell that opens and burns, one that falls; an open corner."""
    events = [
        (2.5, 2, 3, CellState.FREE),
        (2.5, 2, 3, CellState.BURNING),
        (4.0, 2, 3, CellState.FREE),
    ]
    return drawn(TINY, timeline=Timeline.of([*events, (0.125, 3, 1, CellState.SOLID)]))


def test_a_tiny_world_is_these_bytes():
    files = export_world(
        tiny(), "mjcf+robot+height=0.4+timestep=0.001", file="tiny.xml", origin=(-1.05, 2.0)
    ).files
    assert list(files) == ["tiny.xml", "tiny_player.py", "tiny_events.json"]
    assert files["tiny.xml"].decode() == (GOLDEN / "tiny.xml").read_text()
    assert files["tiny_events.json"].decode() == (GOLDEN / "tiny_events.json").read_text()


def cells_of(geom, origin, size):
    """Return the cells that a box covers; the box must be exactly on the cells' edges."""
    spans = []
    for axis in (0, 1):
        middle, half = (Fraction(geom.get(key).split()[axis]) for key in ("pos", "size"))
        ends = [(middle + sign * half - Fraction(repr(origin[axis]))) / size for sign in (-1, 1)]
        assert all(end.denominator == 1 for end in ends)
        spans.append(range(int(ends[0]), int(ends[1])))
    return [(ix, iy) for iy in spans[1] for ix in spans[0]]


@given(changing_worlds(), st.sampled_from([(0.0, 0.0), (-12.7, 1e-3)]))
def test_boxes_cover_what_is_always_solid_exactly_once(world, origin):
    export = export_world(world, "mjcf", file="w.xml", origin=origin, sidecar=False)
    geoms = ElementTree.fromstring(export.data).findall("worldbody/geom[@type='box']")
    covered = [
        cell for geom in geoms for cell in cells_of(geom, origin, Fraction(repr(world.cell_size)))
    ]
    inside = {(ix, iy) for ix, iy in covered if 0 <= ix < world.width and 0 <= iy < world.height}
    always = np.logical_and.reduce(
        [solid_at(world, time) for time in (0.0, *world.timeline.times.tolist())]
    )
    assert len(covered) == len(set(covered)) and inside == {
        (ix, iy) for iy, ix in np.argwhere(always).tolist()
    }


@given(changing_worlds(), st.floats(0.0, 20.0))
def test_boxes_and_table_say_what_is_solid_at_any_time(world, time):
    files = export_world(world, "mjcf", file="w.xml", sidecar=False).files
    geoms = ElementTree.fromstring(files["w.xml"]).findall("worldbody/geom[@type='box']")
    table = json.loads(files.get("w_events.json", '{"events": []}'))
    shown = {name: z > 0 for when, name, z in table["events"] if when <= time}
    there = [
        cell
        for geom in geoms
        for cell in cells_of(geom, (0.0, 0.0), Fraction(repr(world.cell_size)))
    ]
    there += [
        tuple(map(int, name.split("_")[1:]))
        for name, is_there in shown.items()
        if is_there and name[0] == "c"
    ]
    inside = [(ix, iy) for ix, iy in there if 0 <= ix < world.width and 0 <= iy < world.height]
    assert sorted(inside) == [(ix, iy) for ix, iy in np.argwhere(solid_at(world, time).T).tolist()]


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("kind", ["mjcf"])
def test_names_of_files_cannot_break_the_xml(kind, name):
    root = ElementTree.fromstring(export_world(tiny(), kind, file=f"{name}.xml").data)
    said = root.get("model") if kind == "mjcf" else root.find("world").get("name")
    assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", said)


def test_the_player_is_python_that_needs_mujoco_alone():
    tree = ast.parse(export_world(tiny(), "mjcf", file="w.xml").files["w_player.py"])
    modules = {
        node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
    }
    assert modules <= {
        "__future__",
        "collections.abc",
        "json",
        "mujoco",
        "mujoco.viewer",
        "pathlib",
        "time",
        "typing",
    }


@pytest.mark.parametrize(
    "option", ["height=0", "height=-1", "height=1e300", "timestep=0", "timestep=1e300"]
)
@pytest.mark.parametrize("kind", ["mjcf"])
def test_sizes_that_cannot_be_are_refused(kind, option):
    with raises(InvalidParameter, "out-of-range", low=1e-06):
        export_world(tiny(), f"{kind}+{option}")
