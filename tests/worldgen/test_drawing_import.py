"""Plans in SVG, DXF, GeoJSON and Open-RMF's buildings become cells."""

import json
import math

import numpy as np
import pytest

from tests.helpers.foreign_samples import BUILDING, DXF
from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop import read_map
from worldgen.interop.geometry.drawing import filled

pytest.importorskip("ezdxf")


def svg(body, attributes='width="4m" height="3m" viewBox="0 0 40 30"'):
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        f"{attributes}>{body}</svg>"
    ).encode()


def cells(folder, name, data, **options):
    """Return the solid cells of a drawing with cells of 0.1 m as text, top row first."""
    path = folder / name
    path.write_bytes(data)
    found = read_map(path, None, {"cell_size": 0.1, **options})
    return found, ["".join(".#"[int(cell)] for cell in row) for row in found.walls[::-1]]


def box(rows, left, top, right, low):
    """Return rows with a rectangle of cells that are solid."""
    return [
        "".join("#" if left <= x < right and top <= y < low else cell for x, cell in enumerate(row))
        for y, row in enumerate(rows)
    ]


EMPTY = ["." * 40] * 30
# One rectangle, 10 to 20 to the right and 5 to 7 down, drawn in every way.
SAME = [
    '<rect x="10" y="5" width="10" height="2"/>',
    '<path d="M10 5h10v2H10z"/>',
    '<path d="m 10,5 l10 0 0,2 -10 0"/>',
    '<polygon points="10,5 20,5 20,7 10,7"/>',
    '<line x1="10" y1="6" x2="20" y2="6" stroke="#000" stroke-width="2"/>',
    '<polyline points="10,6 20,6" style="stroke:navy;stroke-width:2;fill:none"/>',
    '<path d="M11 6H19" stroke="red" stroke-width="2" stroke-linecap="square"/>',
    '<g transform="translate(10 5)"><g transform="scale(10,2)"><rect width="1" height="1"/></g></g>',
    '<g transform="rotate(90 10 5)"><rect x="10" y="-5" width="2" height="10"/></g>',
    '<g transform="matrix(-1 0 0 1 20 0)"><rect y="5" width="10" height="2"/></g>',
    '<defs><rect id="a" width="5" height="2"/></defs><use href="#a" x="10" y="5"/>'
    '<use xlink:href="#a" transform="translate(15,5)"/>',
    '<symbol id="s" viewBox="0 0 1 1" preserveAspectRatio="none"><rect width="1" height="1"/>'
    '</symbol><use href="#s" x="10" y="5" width="10" height="2"/>',
    '<svg x="10" y="5" width="10" height="2"><rect width="99" height="99"/></svg>',
    '<style>.w{fill:#333} rect{fill:none}</style><rect class="w" x="10" y="5" width="10" height="2"/>',
    '<style>a{x:"/*"} b{x:url(;{/*)} .w{fill:#333!important} c{x:"*/}"} rect{fill:none}</style>'
    '<rect class="w" style="fill:none" x="10" y="5" width="10" height="2"/>',
    '<style>@charset "a;b"; /* {} */ {display:none} rect,{display:none} @font-face{src:url(x)}</style>'
    '<style type="text/x">rect{display:none}</style>'
    '<rect style="/*;fill:none;*/fill:#333" x="10" y="5" width="10" height="2"/>',
    '<clipPath id="c"><rect x="10" y="5" width="10" height="2"/></clipPath>'
    '<circle cx="15" cy="6" r="9" clip-path="url(#c)"/>',
    '<rect x="10" y="5" width="10" height="9"/><rect x="5" y="7" width="20" height="9" fill="#fff"/>',
    '<path fill-rule="evenodd" d="M10 5h10v2h-10zM30 9h1v1h-1zM30 9h1v1h-1z"/>',
    '<path d="M10 5h10v2h-10z M12 5.5h3v1h-3z"/>',
    '<rect x="10" y="5" width="10" height="2"/><g display="none"><rect width="9" height="9"/></g>'
    '<rect style="visibility:hidden" width="9" height="9"/><rect opacity="0" width="9" height="9"/>'
    '<rect fill="none" width="9" height="9"/><rect fill="#f7f7f7" y="20" width="9" height="9"/>'
    '<rect x="100" width="9" height="9"/><title>t</title><x:y/>',
    '<rect x="10" y="5" width="10" height="2"/><text x="5" y="20">Room <tspan>A</tspan></text>',
]  # fmt: skip


@pytest.mark.parametrize("body", SAME, ids=range(len(SAME)))
def test_svg_is_read_as_it_is_drawn(tmp_path, body):
    found, rows = cells(tmp_path, "a.svg", svg(body))
    assert rows == box(EMPTY, 10, 5, 20, 7)
    assert found.unread == () and found.origin == (0.0, 0.0)


@pytest.mark.parametrize(
    ("style", "what"),
    [
        ("<style>@media all{rect{fill:#333}}</style>", "1 rule of <style> under a condition"),
        ("<style>g{rect{fill:#333}}</style>", "1 rule of <style> under a condition"),
        ("<style media='print'>rect{fill:#333}</style>", "1 rule of <style> under a condition"),
        ("<style>@import 'a.css'</style>", "1 import of style sheets"),
        ("<?xml-stylesheet href='a.css'?>", "1 import of style sheets"),
    ],
    ids=["medium", "nested", "print", "import", "instruction"],
)
def test_rules_of_style_that_are_not_applied_are_reported(style, what, tmp_path):
    body = '<rect x="10" y="5" width="10" height="2"/>'
    assert cells(tmp_path, "a.svg", svg(style + body))[0].unread == (what,)


@pytest.mark.parametrize(
    "body",
    [
        f"<style>{'/*' * 50_000}</style>", f"<style>{'@import ' * 20_000}</style>",
        f"<style>{'@' * 100_000}</style>", f"<rect x='{'1' * 100_000}!'/>",
        f"<rect transform='{'a' * 100_000}'/>",
        f"<path d='M0 0A1 1 0{' ' * 100_000}x'/>",
    ],
    ids=["comments", "imports", "rules", "digits", "words", "flags"],
)  # fmt: skip
def test_words_without_an_end_are_read_once(body, tmp_path):
    """A rule for words that tries every beginning takes minutes here."""
    wall = '<rect x="10" y="5" width="10" height="2"/>'
    assert cells(tmp_path, "a.svg", svg(wall + body))[1] == box(EMPTY, 10, 5, 20, 7)


def test_curves_of_svg_cover_their_area(tmp_path):
    shapes = {
        '<circle cx="20" cy="15" r="10"/>': math.pi,
        '<ellipse cx="20" cy="15" rx="10" ry="5"/>': math.pi / 2,
        '<path d="M10 15a10 10 0 1120 0 10,10 0 01-20 0"/>': math.pi,
        '<rect x="10" y="5" width="20" height="20" rx="10"/>': math.pi,
        '<path d="M10 5 C10 20 30 20 30 5"/>': 1.8,
        '<path d="M10 5Q20 25 30 5"/>': 4 / 3,
    }
    for body, area in shapes.items():
        path = tmp_path / "a.svg"
        path.write_bytes(svg(body))
        walls = read_map(path, None, {"cell_size": 0.01}).walls
        assert walls.sum() * 1e-4 == pytest.approx(area, abs=0.06)


# A room of 4 x 3 m with a wall in the middle that leaves a door of 1 m.
ROOM = EMPTY
for side in ((0, 0, 40, 1), (0, 29, 40, 30), (0, 0, 1, 30), (39, 0, 40, 30), (19, 9, 21, 30)):
    ROOM = box(ROOM, *side)
LINES = [[[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]], [[2, 0], [2, 2]]]


def test_lines_in_dxf_and_geojson_are_walls_of_the_cells_that_they_touch(tmp_path):
    assert cells(tmp_path, "plan.dxf", DXF)[1] == ROOM
    lines = {"type": "MultiLineString", "coordinates": LINES}
    assert cells(tmp_path, "l.geojson", json.dumps(lines).encode())[1] == ROOM
    degrees = [[[8 + x * 1e-5, y * 1e-5] for x, y in line] for line in LINES]
    text = json.dumps({**lines, "coordinates": degrees}).encode()
    found, rows = cells(tmp_path, "d.geojson", text)
    # At the equator 1e-5 degrees are 1.113 m east and 1.106 m north.
    assert (len(rows[0]), len(rows)) == (45, 34) and "degrees" in found.notes[0]
    assert len(cells(tmp_path, "d.geojson", text, unit="deg")[1][0]) == 45


def test_an_open_rmf_building_has_its_scale_and_open_doors(tmp_path):
    found, rows = cells(tmp_path, "room.building.yaml", BUILDING)
    path = tmp_path / "room.building.yaml"
    assert (
        found.unread == ()
        and not found.walls[22:28, 18:24].any()
        and found.walls[2:20, 20:22].all()
    )
    assert read_map(path, None, {"layer": "walls,doors", "cell_size": 0.1}).walls[:, 20:22].all()
    assert (len(rows[0]), len(rows)) == (42, 32)
    with raises(InvalidParameter, "level-missing", name="L9"):
        read_map(path, "building+level=L9")


@pytest.fixture
def drawn(tmp_path):
    """A drawing of a CAD program in millimetres."""
    import ezdxf

    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = 4
    space = document.modelspace()
    document.layers.add("OFF").off()
    document.layers.add("FROZEN").freeze()
    door = document.blocks.new("DOOR", base_point=(100, 0))
    door.add_lwpolyline([(100, 0), (1100, 0)], dxfattribs={"const_width": 100})
    both = document.blocks.new("BOTH")
    both.add_blockref("DOOR", (0, 0))
    both.add_line((0, 0), (0, 9000), dxfattribs={"layer": "FROZEN"})
    space.add_lwpolyline(
        [(1000, 50), (2000, 50)], dxfattribs={"layer": "A-WALL", "const_width": 100}
    )
    # 1 m up from (3, 1), mirrored and turned.
    turned = {"layer": "A-DOOR", "rotation": 90, "yscale": -1}
    space.add_blockref("BOTH", (3050, 1000), dxfattribs=turned)
    hatch = space.add_hatch(dxfattribs={"layer": "COLUMNS"})
    for low, high in ((2000, 2500), (2100, 2400)):
        hatch.paths.add_polyline_path([(low, low), (high, low), (high, high), (low, high)])
    space.add_lwpolyline([(500, 2000, 0, 0, 1), (500, 2600)], dxfattribs={"layer": "A-WALL"})
    for layer in ("OFF", "FROZEN"):
        space.add_line((0, 0), (4000, 2900), dxfattribs={"layer": layer})
    space.add_text("Kitchen")
    document.layout("Layout1").add_line((0, 0), (9, 9))
    space.add_line((0, 0), (10, 0), dxfattribs={"layer": "A-WALL"})
    document.saveas(tmp_path / "cad.dxf")
    return tmp_path / "cad.dxf"


def test_dxf_has_units_widths_blocks_hatches_and_hidden_layers(drawn):
    found = read_map(drawn, None, {"cell_size": 0.1})
    walls = found.walls
    assert walls[0, 10:20].all() and not walls[0, 2:10].any()
    assert walls[10:20, 30].all() and not walls[10:20, 31:].any() and not walls[20:, 27:].any()
    assert walls[20:25, 20:25].sum() == 25 - 9
    # The bulge of 1 is half a circle to the right of the line, of 0.3 m radius.
    assert walls[22:24, 7].all() and not walls[21:25, 3:6].any()
    assert found.unread == () and any("A-DOOR" in note for note in found.notes)
    some = read_map(drawn, None, {"cell_size": 0.1, "layer": "a-*", "free": "A-DOOR"})
    assert not some.walls[10:26, 18:].any() and some.walls[0, 10:20].all()


def test_a_dxf_with_the_ends_of_lines_of_windows_is_the_same_drawing(drawn):
    walls = read_map(drawn, None, {"cell_size": 0.1}).walls
    drawn.write_bytes(drawn.read_bytes().replace(b"\r\n", b"\n").replace(b"\n", b"\r\n"))
    found = read_map(drawn, None, {"cell_size": 0.1})
    assert (found.walls == walls).all() and found.unread == ()


def test_the_edges_of_a_route_graph_are_no_walls(tmp_path):
    def feature(coordinates, **properties):
        geometry = {"type": "LineString", "coordinates": coordinates}
        return {"type": "Feature", "properties": properties, "geometry": geometry}

    walls = [feature(line) for line in LINES]
    edge = feature([[0.5, 0.5], [3.5, 2.5]], id=3, startid=1, endid=2)
    graph = {"type": "FeatureCollection", "date_generated": "today", "features": [*walls, edge]}
    found, rows = cells(tmp_path, "g.geojson", json.dumps(graph).encode())
    assert rows == ROOM and found.unread == () and "1 edge" in found.notes[0]
    with raises(FormatError, "no-walls", edges=1):
        cells(tmp_path, "g.geojson", json.dumps({**graph, "features": [edge]}).encode())
    # An area is no edge, whatever its properties are called.
    solid = {"type": "Polygon", "coordinates": [[[1, 1], [2, 1], [2, 2], [1, 2], [1, 1]]]}
    block = {**edge, "geometry": solid}
    _, more = cells(
        tmp_path, "b.geojson", json.dumps({**graph, "features": [*walls, block]}).encode()
    )
    assert more != ROOM


@pytest.mark.parametrize(
    ("body", "unread"),
    [
        ('<clipPath id="c"><text>W</text></clipPath>', "clips to texts"),
        ('<clipPath id="c" clipPathUnits="objectBoundingBox"><rect/></clipPath>', "clips in units of their object"),
    ],
)  # fmt: skip
def test_walls_behind_clips_that_are_not_read_stay_whole_and_are_reported(tmp_path, body, unread):
    wall = '<rect x="{}" y="5" width="5" height="2" clip-path="url(#c)"/>'
    walls = wall.format(10) + wall.format(15)
    found, rows = cells(tmp_path, "a.svg", svg(body + walls))
    assert rows == box(EMPTY, 10, 5, 20, 7)
    assert [words for words in found.unread if unread in words]


def test_a_colour_that_is_no_number_is_black(tmp_path):
    wall = '<rect x="10" y="5" width="10" height="2" fill="rgb(nan,0,0)"/>'
    assert cells(tmp_path, "a.svg", svg(wall))[1] == box(EMPTY, 10, 5, 20, 7)


def test_a_door_of_a_free_layer_opens_a_wall(tmp_path):
    walls = {
        "type": "FeatureCollection",
        "features": [
            {
                "type": "Feature",
                "properties": {"category": kind},
                "geometry": {"type": "LineString", "coordinates": line},
            }
            for kind, line in (
                ("wall", LINES[0]),
                ("wall", [[2, 0], [2, 3]]),
                ("opening", [[2, 1], [2, 2]]),
                ("label", [[3, 1], [3.5, 1]]),
            )
        ],
    }
    text = json.dumps(walls).encode()
    options = {"layer": "wall", "free": "opening", "thickness": 0.2}
    found, _ = cells(tmp_path, "w.geojson", text, **options)
    middle = found.walls[:, 20]
    assert middle.sum() == 22 and not middle[11:21].any() and not found.walls[8:14, 25:38].any()
    with raises(FormatError, "layer-missing", name="walls"):
        cells(tmp_path, "w.geojson", text, layer="walls")


def test_a_winding_is_counted_as_svg_does():
    outer = np.array([[0, 0], [4, 0], [4, 4], [0, 4]], float)
    inner = np.array([[1, 1], [2, 1], [2, 2], [1, 2]], float)
    crossed = np.array([[0, 0], [2, 2], [2, 0], [0, 2]], float)
    assert filled([outer, inner], even_odd=True).area == 15
    assert filled([outer, inner], even_odd=False).area == 16
    assert filled([outer, inner[::-1]], even_odd=False).area == 15
    assert filled([crossed], even_odd=True).area == 2


LINE = "0\nLINE\n8\n0\n10\n{}\n20\n0\n11\n4\n21\n3\n"
BLOCK = "0\nBLOCK\n8\n0\n2\n{0}\n70\n0\n10\n0\n20\n0\n3\n{0}\n{1}0\nENDBLK\n8\n0\n"
INSERT = "0\nINSERT\n8\n0\n2\n{}\n10\n0\n20\n0\n"


def dxf(body, blocks=""):
    return f"0\nSECTION\n2\nBLOCKS\n{blocks}0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{body}0\nENDSEC\n0\nEOF\n".encode()


def levels(make, count=12):
    return "".join(make(number) for number in range(1, count))


USES = levels(lambda n: f'<g id="a{n}">' + 40 * f'<use href="#a{n - 1}"/>' + "</g>", 5)
CLIPPED = '<rect width="9" height="9" clip-path="url(#c)"/>'
HUGE = 'width="1000000000m" height="1000000000m" viewBox="0 0 9 9"'
ENTITY = b'<!DOCTYPE svg [<!ENTITY a "' + b"x" * 150 + b'">]>'
BLOCKS = BLOCK.format("A0", LINE.format(0)) + levels(
    lambda n: BLOCK.format(f"A{n}", 9 * INSERT.format(f"A{n - 1}"))
)
HOSTILE = {
    "u.svg": (svg('<g id="a"><use href="#a"/></g>'), "nested-too-deep"),
    "b.svg": (svg(f'<g id="a0"><rect width="1" height="1"/></g>{USES}'), "too-large"),
    "c.svg": (svg(f'<clipPath id="c">{CLIPPED}</clipPath>{CLIPPED}'), "too-large"),
    "n.svg": (svg('<path d="M0 0L9 nan"/>'), "not-a-number"),
    "h.svg": (svg("<rect width='9' height='9'/>", HUGE), "wrong-size"),
    "e.svg": (ENTITY + svg("<desc>" + "&a;" * 2000 + "</desc>"), "too-large"),
    "t.svg": (svg("<text>only words</text>"), "no-walls"),
    "i.dxf": (dxf(INSERT.format("A"), BLOCK.format("A", INSERT.format("A"))), "nested-too-deep"),
    "b.dxf": (dxf(INSERT.format("A11"), BLOCKS), "too-large"),
    "m.dxf": (dxf(INSERT.format("A") + "70\n32000\n71\n32000\n", BLOCK.format("A", LINE.format(0))), "too-large"),
    "n.dxf": (dxf(LINE.format("nan")), "not-a-number"),
    "h.dxf": (dxf(LINE.format("1e13")), "wrong-size"),
    "d.dxf": (b"AC1032" + bytes(200), "unsupported"),
    "x.dxf": (b"0\nSECTION\nrubbish\n", "not-dxf"),
    "r.dxf": (b"0\nSECTION\n" + b"999\nx\n" * 20, "no-walls"),
    "n.geojson": (b'{"type": "Polygon", "coordinates": [[[NaN, 0], [1, 0], [1, 1]]]}', "damaged-file"),
    "h.geojson": (b'{"type": "Polygon", "coordinates": [[[0, 0], [1e12, 0], [1e12, 1e12]]]}', "wrong-size"),
    "p.geojson": (b'{"type": "Point", "coordinates": [0, 0]}', "no-walls"),
    "r.geojson": (b'{"type": "GeometryCollection", "geometries": [' * 99 + b"]}" * 99, "nested-too-deep"),
    "n.yaml": (b"levels:\n  L1:\n    vertices:\n      - [.nan, 0]\n    walls:\n      - [0, 0]\n", "wrong-type"),
    "w.yaml": (b"levels:\n  L1:\n    vertices:\n      - [0, 0]\n    walls:\n      - [0, 7]\n", "wrong-type"),
}  # fmt: skip


BOMBS = ("b.svg", "b.dxf")


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.gate if name in BOMBS else ()) for name in HOSTILE],
)
def test_a_hostile_drawing_is_refused_with_a_sentence(tmp_path, name):
    data, code = HOSTILE[name]
    path = tmp_path / name
    path.write_bytes(data)
    options = {} if name[0] != "h" else {"cell_size": 0.1}
    with raises(FormatError, code):
        read_map(path, "building" if name.endswith("yaml") else None, options)
