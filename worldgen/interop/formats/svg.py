"""Plans in SVG: read as a drawing, and written to scale.

In what is written, one unit is a metre, and every element is named after what it shows. ``worldgen show --picture``
draws a picture to look at, in pixels, with caption and signal; this format is for programs that
measure, cut or edit. Its coordinates are the world's own, as exact decimals, and all other facts are in the
metadata.

Source: W3C, "Scalable Vector Graphics (SVG) 1.1, second edition", 2011.
"""

from __future__ import annotations

import html
import itertools
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from worldgen.interop.format import (
    PLAIN_FACTS,
    Destination,
    Exported,
    Format,
    decimal_text,
    degrees_text,
    held_values,
)
from worldgen.interop.format.foreign_map import FLOOR_ROBOT, ForeignMap
from worldgen.interop.geometry.drawing_options import DrawingOptions
from worldgen.interop.geometry.placed_boxes import GridLines
from worldgen.interop.geometry.polygons import Polygon, border_cells, cell_polygons
from worldgen.lattice import exact
from worldgen.parameters.bounds import check_between
from worldgen.render.caption import printable
from worldgen.render.marks import hue
from worldgen.world import Witness, World

MAX_SVG_BYTES = 32 << 20
_STYLE = (
    f".floor{{fill:{hue('floor')}}}.wall{{fill:{hue('wall')};fill-rule:evenodd}}"
    f".border{{fill:{hue('quiet')};fill-rule:evenodd}}"
    f".target{{fill:{hue('target')};fill-opacity:.6}}.robot{{fill:{hue('start')};fill-opacity:.6}}"
    f".heading,.witness{{fill:none;stroke:{hue('start')};stroke-linejoin:round}}"
)


@dataclass(frozen=True)
class SvgOptions(DrawingOptions):
    """Options of a drawing with colours.

    Args:
        layer: Names of the layers, groups, ids or classes that are walls, with commas between them;
            * and ? stand for any letters. If omitted, all that is drawn.
        unit: Length of a unit of the drawing: m, cm, mm, in, ft, or a number of metres; if omitted,
            the page's.
        thickness: Thickness of the outlines of areas, m; lines have the width that is drawn.
        threshold: Darkness, 0 white to 1 black, from which a shape is a wall.
    """

    threshold: float = 0.1


def read_svg(path: Path, options: SvgOptions) -> ForeignMap:
    """Read a drawing: what is drawn dark is a wall, and white on top of it is floor.

    Raises:
        FormatError: If it is not SVG, or has no walls.
        InvalidParameter: If an option is out of range.
    """
    from worldgen.interop.geometry.drawing import geometry_errors
    from worldgen.interop.readers.svg_drawing import read_svg_drawing

    with geometry_errors():
        return read_svg_drawing(path, options, options.threshold, MAX_SVG_BYTES)


def write_svg(
    world: World, destination: Destination, *, scale: float = 20.0, witness: bool = True
) -> Exported:
    """Return the plan: floor, walls, target, robot, and the path that proves reachability.

    Args:
        world: A static world.
        destination: Where the file is written.
        scale: Scale of the print, as 1 to this number; 1 is life size.
        witness: True to draw the certificate's path, if there is one.

    Raises:
        InvalidParameter: If the scale is below 0.001 or above a million.
        InvalidWorld: If the coordinates need more than 64 bits.
    """
    check_between("scale", scale, 1e-3, 1e6)
    more = 1 if border_cells(world).any() else 0
    lines = GridLines(world, destination)
    left = lines.x[-more]
    right = lines.x[world.width + more]
    bottom = lines.y[-more]
    top = lines.y[world.height + more]
    view = " ".join(decimal_text(value) for value in (left, -top, right - left, top - bottom))
    across, down = (float(1000 * length / exact(scale)) for length in (right - left, top - bottom))
    name = html.escape(printable(destination.name))
    said = {"frame": "local", "units": "m", **held_values(world, destination)}
    text = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{view}" width="{across!r}mm" '
        f'height="{down!r}mm">',
        f"<title>{name}</title>",
        f"<desc>A plan of {world.width} x {world.height} cells; 1 unit is 1 m, "
        f"1:{decimal_text(exact(scale))} in print; x right, y up in #world.</desc>",
        f'<metadata id="worldgen">{html.escape(json.dumps(said), quote=False)}</metadata>',
        f"<style>{_STYLE}</style>",
        '<g id="world" transform="scale(1,-1)">',
        *_cells(world, lines),
        *(_path(world.certificate, world, destination) if witness else ()),
        *_places(world, destination),
        "</g>",
        "</svg>",
    ]
    return Exported({destination.name: ("\n".join(text) + "\n").encode()})


svg = Format(
    "svg",
    "drawing or plan to scale, .svg",
    (".svg",),
    re.compile(
        rb"(?s)\s*(?:<\?xml|<!--|<!DOCTYPE svg|<(?:svg:)?svg[\s>]).*?<(?:svg:)?svg[\s>]|\s*<(?:svg:)?svg[\s>]"
    ),
    read_svg,
    write=write_svg,
    holds=PLAIN_FACTS,
    client="browsers, Inkscape, cutters",
    usual_robot=FLOOR_ROBOT,
    most_bytes=MAX_SVG_BYTES,
    options=SvgOptions,
)


def _cells(world: World, lines: GridLines) -> Iterator[str]:
    xs, ys = (
        {at: decimal_text(value) for at, value in axis.items()} for axis in (lines.x, lines.y)
    )
    size = [
        decimal_text(end[side] - end[0])
        for end, side in ((lines.x, world.width), (lines.y, world.height))
    ]
    yield f'<rect class="floor" x="{xs[0]}" y="{ys[0]}" width="{size[0]}" height="{size[1]}"/>'
    for kind, solid, first in (("wall", world.walls, 0), ("border", border_cells(world), -1)):
        for polygon in cell_polygons(solid, first):
            yield f'<path class="{kind}" d="{_outline(polygon, xs, ys)}"/>'


def _outline(polygon: Polygon, xs: dict[int, str], ys: dict[int, str]) -> str:
    """Return path data; every side of a ring is parallel to an axis."""
    words = []
    for ring in polygon:
        words.append(f"M{xs[ring[0][0]]} {ys[ring[0][1]]}")
        for (ax, _), (bx, by) in itertools.pairwise(ring):
            words.append(f"H{xs[bx]}" if ax != bx else f"V{ys[by]}")
        words.append("z")
    return "".join(words)


def _path(certificate: object, world: World, destination: Destination) -> Iterator[str]:
    if isinstance(certificate, Witness) and len(certificate.times) > 1:
        points = zip(certificate.x.tolist(), certificate.y.tolist(), strict=True)
        corners = " ".join(f"{destination.x(x)},{destination.y(y)}" for x, y in points)
        yield (
            f'<polyline class="witness" stroke-width="{_part(world.robot_radius, 8)}" '
            f'points="{corners}"/>'
        )


def _places(world: World, destination: Destination) -> Iterator[str]:
    for name, point, radius in (
        ("target", world.target, world.target.radius),
        ("robot", world.start, world.robot_radius),
    ):
        x = destination.x(point.x)
        y = destination.y(point.y)
        yield f'<circle class="{name}" cx="{x}" cy="{y}" r="{_part(radius)}"/>'
    rim = decimal_text(
        exact(world.start.x) + exact(destination.origin[0]) + exact(world.robot_radius)
    )
    turn = f"{degrees_text(world.start.heading)} {x} {y}"
    yield (
        f'<path class="heading" stroke-width="{_part(world.robot_radius, 8)}" '
        f'transform="rotate({turn})" '
        f'd="M{x} {y}H{rim}"/>'
    )


def _part(value: float, share: int = 1) -> str:
    return decimal_text(exact(value) / Fraction(share))
