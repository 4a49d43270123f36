"""Worlds of Webots become cells, whichever axis is up, and bad ones are refused in a sentence."""

import pytest

from tests.helpers.foreign_samples import WEBOTS
from tests.helpers.raising import raises
from worldgen.errors import FormatError
from worldgen.interop import read_map

NEW = "#VRML_SIM R2022a utf8\n"
OLD = "#VRML_SIM R2021b utf8\n"


def cells(folder, text, name=None, **options):
    path = folder / "w.wbt"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    found = read_map(path, name, options)
    return found, ["".join("#" if cell else "." for cell in row) for row in found.walls[::-1]]


def test_an_arena_is_its_walls_around_the_floor(tmp_path):
    found, rows = cells(tmp_path, WEBOTS, cell_size=0.1)
    inside = ["#" + "." * 20 + "#"] * 4 + ["#" + "." * 9 + "##" + "." * 9 + "#"] * 6
    assert rows == ["#" * 22, *inside, "#" * 22]
    assert found.unread == () and found.origin == pytest.approx((-1.1, -0.6))


# The same wall of 0.4 x 0.2 m in the south-west, and a post in the north-east, in four frames.
ROOM = {
    "ENU": f"""{NEW}Solid {{ translation 0.2 0.1 0.5 boundingObject Shape {{ geometry Box {{ size 0.4 0.2 1 }} }} }}
        Pose {{ translation 0.5 0.3 0.5 children [ Shape {{ geometry Cylinder {{ height 1 radius 0.1 }} }} ] }}""",
    "NUE": f"""{OLD}Solid {{ translation 0.1 0.5 0.2 boundingObject Shape {{ geometry Box {{ size 0.2 1 0.4 }} }} }}
        Transform {{ translation 0.3 0.5 0.5 children [ Shape {{ geometry Cylinder {{ height 1 radius 0.1 }} }} ] }}""",
    "old, with z up": f"""{OLD}WorldInfo {{ coordinateSystem "ENU" }}
        Wall {{ translation 0.2 0.1 0 rotation 1 0 0 1.5708 size 0.4 1 0.2 }}
        Transform {{ translation 0.5 0.3 0.5 rotation 1 0 0 1.5708 children [
          Shape {{ geometry Cylinder {{ height 1 radius 0.1 }} }} ] }}""",
    "turned, scaled and used twice": f"""{NEW}Group {{ children [
        DEF BOX Solid {{ translation 0.2 0.1 0 rotation 0 0 1 -1.5708 children [ Shape {{ geometry Mesh {{ }} }} ]
          boundingObject Pose {{ translation 0 0.1 0.5 children [ Box {{ size 0.2 0.2 1 }} ] }} }}
        Transform {{ translation -0.2 0 0 children [ USE BOX ] }} ] }}
        Transform {{ translation 0.5 0.3 0.5 scale 0.5 0.5 0.5 children [
          Shape {{ geometry Cylinder {{ height 2 radius 0.2 }} }} ] }}""",
}


@pytest.mark.parametrize("frame", ROOM)
def test_a_world_looks_the_same_in_every_frame(frame, tmp_path):
    found, rows = cells(tmp_path, ROOM[frame], cell_size=0.1)
    assert (found.unread, rows) == ((), ["....##", "....##", "####..", "####.."])


def test_the_first_robot_gives_the_start(tmp_path):
    robot = 'Robot { translation 0.5 0.5 0 rotation 0 0 -1 1.5 children [ Camera { } ] name "a" }'
    found, _ = cells(tmp_path, WEBOTS + robot.encode())
    assert found.robots[0].start == pytest.approx((1.6, 1.1, -1.5)) and found.unread == ()


PUCK = """EXTERNPROTO "webots://projects/robots/gctronic/e-puck/protos/E-puck.proto"
E-puck { translation 0.5 0.5 0 controller "<extern>" turretSlot [ Camera { } ] }"""


@pytest.mark.parametrize(
    ("text", "unread"),
    [
        (PUCK, ()),
        (PUCK.replace('controller "<extern>"', ""), ("1 node of E-puck",)),
        (PUCK.replace("webots://projects", "../protos"), ("1 node of E-puck",)),
    ],
    ids=["Webots' own", "without a controller", "the project's"],
)
def test_a_robot_of_webots_own_gives_the_start(text, unread, tmp_path):
    found, _ = cells(tmp_path, WEBOTS + text.encode())
    assert found.unread == unread
    assert found.robots[0].start == (None if unread else pytest.approx((1.6, 1.1, 0.0)))


def test_heights_count_from_a_files_only_floor(tmp_path):
    flat = ROOM["ENU"] + " Solid { boundingObject Plane { } }"
    low = flat.replace("0.5 boundingObject", "-0.1 boundingObject").replace(
        "Solid { boundingObject Plane", "Solid { translation 0 0 -0.6 boundingObject Plane"
    )
    expected = cells(tmp_path, flat, cell_size=0.1)[1]
    found, rows = cells(tmp_path, low.replace("0.3 0.5", "0.3 -0.1"), cell_size=0.1)
    assert (rows, found.params["floor_height"], found.unread) == (expected, -0.6, ())
    both = cells(tmp_path, f"{flat} Solid {{ translation 0 0 1 boundingObject Plane {{ }} }}")[0]
    assert both.unread == ("1 shape of Plane, above or below the floor",)


def test_a_projects_own_wall_is_not_webots_wall(tmp_path):
    text = f"{ROOM['ENU']} Wall {{ translation 3 3 0 size 1 1 1 }}"
    assert cells(tmp_path, text)[0].unread == ()
    (tmp_path / "protos").mkdir()
    (tmp_path / "protos" / "Wall.proto").touch()
    assert cells(tmp_path, text)[0].unread == ("1 node of another Wall",)


USES = "DEF A0 Box {} " + "".join(
    f"DEF A{n} Group {{ children [ {f'USE A{n - 1} ' * 20}] }}" for n in range(1, 9)
)
HOSTILE = {
    "endless nesting": ("Group { children [ " * 5000, "nested-too-deep"),
    "nesting by USE": (
        "DEF A0 Group { }"
        + "".join(f"DEF A{n} Group {{ children USE A{n - 1} }}" for n in range(1, 99)),
        "nested-too-deep",
    ),
    "copies of copies": (USES, "too-large"),
    "its own part": ("DEF A Group { children [ USE A ] }", "unknown-name"),
    "no end": ("Solid { children [", "cut-off"),
    "string without an end": ('Solid { name "a } ', "unterminated"),
    "nan": ("Shape { geometry Box { size nan 1 1 } }", "wrong-form"),
    "NaN": ("Shape { geometry Box { size 1 NaN 1 } }", "wrong-type"),
    "1e999": ("Shape { geometry Box { size 1e999 1 1 } }", "wrong-type"),
    "1e99999999": ("Shape { geometry Box { size 1e99999999 1 1 } }", "wrong-type"),
    "node for a number": ("Shape { geometry Box { size Box { } } }", "wrong-type"),
    "number for a node": ("Solid { children [ 1 2 ] }", "wrong-type"),
    "axis of length 0": ("Solid { rotation 0 0 0 1 }", "out-of-range"),
    "negative side": ("Shape { geometry Box { size 1 -1 1 } }", "not-positive"),
    "field twice": ("Solid { name 1 name 2 }", "twice"),
    "PROTO": ("PROTO A [ ] { }", "unsupported"),
    "left-handed": ('WorldInfo { coordinateSystem "EUN" }', "unsupported"),
    "stray bracket": ("} ]", "wrong-form"),
    "nothing": ("Floor { }", "empty"),
}  # fmt: skip


@pytest.mark.parametrize("label", HOSTILE)
def test_a_hostile_world_is_refused_in_a_sentence(label, tmp_path):
    text, code = HOSTILE[label]
    with raises(FormatError, code) as caught:
        cells(tmp_path, NEW + text)
    assert len(str(caught.value)) < 400
