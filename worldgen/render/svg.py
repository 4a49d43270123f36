"""Render a scene as SVG: small, sharp at any size, with one path for all walls."""

from __future__ import annotations

import base64
import html
import io
import zlib

import numpy as np
from PIL import Image

from worldgen.render.caption import printable
from worldgen.render.coverage import coverage
from worldgen.render.frame import DEFAULT_PIXELS
from worldgen.render.marks import mix, rgb
from worldgen.render.outline import corner_count, outlines
from worldgen.render.overlay import Trails
from worldgen.render.primitives import DrawnCells, DrawnCircle, DrawnLine, Glow, Paint, Text
from worldgen.render.scene import Picture, compose
from worldgen.support.arrays import Floats, Ints
from worldgen.world import World

# Limit on the corners of cells drawn as a path; beyond that, an image of them is smaller.
MOST_CORNERS = 40_000
# Stops of the floor's gradient: it is logarithmic, and SVG's are linear between stops.
STOPS = 12


def draw_svg(
    world: World,
    *,
    trail: Trails = None,
    signal: bool = True,
    witness: bool = True,
    title: str = "",
    pixels: int = DEFAULT_PIXELS,
) -> str:
    """Return the picture of a world, and of a run in it, as the text of an SVG file.

    Args:
        world: What to draw.
        trail: A robot's trail; for several robots, one trail for each.
        signal: True to tint the floor by the strength of the target's signal.
        witness: True to draw the certificate's path, or its cut.
        title: First line of the caption.
        pixels: Longer side of the map in SVG units; the picture can be shown at any size.

    Raises:
        InvalidParameter: If ``pixels`` is out of range.
    """
    scene = compose(world, trail, signal=signal, witness=witness, title=title, pixels=pixels)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + svg_element(scene, standalone=True)


def svg_element(scene: Picture, *, standalone: bool) -> str:
    """Return the ``<svg>`` element; ``standalone`` adds the namespace for a separate file."""
    writer = _Writer(scene)
    body = [writer.draw(part) for part in scene.primitives]
    space = 'xmlns="http://www.w3.org/2000/svg" ' if standalone else ""
    name = html.escape(printable(scene.title)) or "A world"
    head = (
        f'<svg {space}viewBox="0 0 {scene.width} {scene.height}" width="{scene.width}" '
        f'height="{scene.height}" role="img" font-family="Helvetica, Arial, sans-serif" '
        'stroke-linecap="round" stroke-linejoin="round">'
    )
    defs = "".join(writer.definitions.values())
    return "\n".join([head, f"<title>{name}</title>", f"<defs>{defs}</defs>", *body, "</svg>", ""])


def _number(value: float) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".") if value % 1.0 else str(int(value))


def _points(points: Floats) -> str:
    return " ".join(f"{_number(float(x))},{_number(float(y))}" for x, y in points)


def _look(paint: Paint) -> str:
    parts = [f'fill="{paint.fill or "none"}"']
    if paint.stroke:
        parts.append(f'stroke="{paint.stroke}" stroke-width="{_number(paint.width)}"')
    if paint.opacity < 1.0:
        parts.append(f'opacity="{_number(paint.opacity)}"')
    if paint.dash:
        parts.append(
            f'stroke-linecap="butt" stroke-dasharray="{" ".join(map(_number, paint.dash))}"'
        )
    return " ".join(parts)


class _Writer:
    """Turns primitives into elements and collects the definitions that they refer to."""

    def __init__(self, scene: Picture) -> None:
        self.frame = scene.frame
        self.definitions: dict[str, str] = {}

    def draw(self, part: DrawnCircle | DrawnLine | DrawnCells | Glow | Text) -> str:
        """Return the element of one primitive."""
        if isinstance(part, DrawnCircle):
            return self._circle(part)
        if isinstance(part, DrawnLine):
            kind = "polygon" if part.closed else "polyline"
            return f'<{kind} points="{_points(part.points)}" {_look(part.paint)}/>'
        if isinstance(part, DrawnCells):
            return self._cells(part)
        if isinstance(part, Glow):
            return self._glow(part)
        place = f'x="{_number(part.x)}" y="{_number(part.y)}" font-size="{_number(part.size)}"'
        return f'<text {place} fill="{part.fill}">{html.escape(part.text)}</text>'

    def _define(self, template: str) -> str:
        """Add a definition with ``{id}`` in it.

        Equal ids denote equal definitions, even across pictures.
        """
        name = f"wg{zlib.crc32(template.encode()):08x}"
        self.definitions[name] = template.replace("{id}", name)
        return f"url(#{name})"

    def _map_rectangle(self) -> str:
        frame = self.frame
        return f'x="{frame.left}" y="{frame.top}" width="{frame.width}" height="{frame.height}"'

    def _circle(self, part: DrawnCircle) -> str:
        clip = ""
        if part.clipped:
            area = self._define(f'<clipPath id="{{id}}"><rect {self._map_rectangle()}/></clipPath>')
            clip = f' clip-path="{area}"'
        place = (
            f'cx="{_number(part.x)}" cy="{_number(part.y)}" r="{_number(max(0.0, part.radius))}"'
        )
        return f"<circle {place} {_look(part.paint)}{clip}/>"

    def _cells(self, part: DrawnCells) -> str:
        # A mask with very many corners is smaller as an embedded picture than as a path.
        if corner_count(part.mask) > MOST_CORNERS:
            return self._image(part)
        frame = self.frame
        steps = "".join(_closed_line(line) for line in outlines(part.mask))
        if not steps:
            return ""
        fill = part.fill
        if part.hatch > 0.0:
            fill = self._stripes(part, 1.0 / frame.cell)
        opacity = f' opacity="{_number(part.opacity)}"' if part.opacity < 1.0 else ""
        # Draw in cells and let the browser scale, so the numbers stay short.
        across = frame.width / part.mask.shape[1]
        down = frame.height / part.mask.shape[0]
        place = f"translate({frame.left} {frame.bottom}) scale({across:.8g} {-down:.8g})"
        return f'<path transform="{place}" fill="{fill}" fill-rule="evenodd"{opacity} d="{steps}"/>'

    def _stripes(self, part: DrawnCells, scale: float) -> str:
        period = part.hatch * scale
        return self._define(
            f'<pattern id="{{id}}" width="{period:.5g}" height="{period:.5g}" '
            f'patternUnits="userSpaceOnUse" '
            f'patternTransform="rotate(-45)"><rect width="{0.28 * period:.5g}" '
            f'height="{period:.5g}" '
            f'fill="{part.fill}"/></pattern>'
        )

    def _image(self, part: DrawnCells) -> str:
        """Return an image for cells with too many corners for a path; it becomes the opacity."""
        frame = self.frame
        rows, columns = part.mask.shape
        share = min(1.0, max(frame.width, frame.height) / max(rows, columns))
        grey = coverage(part.mask, max(1, round(columns * share)), max(1, round(rows * share)))
        # Sixteen levels are enough for edges, and compress well.
        levels = np.rint(grey / 17.0).astype(np.uint8)
        image = Image.fromarray(levels)
        image.putpalette([channel for _ in range(256) for channel in rgb(part.fill)])
        stream = io.BytesIO()
        image.save(
            stream,
            "PNG",
            optimize=True,
            bits=4,
            transparency=bytes(17 * level for level in range(16)),
        )
        data = base64.b64encode(stream.getvalue()).decode()
        opacity = f' opacity="{_number(part.opacity)}"' if part.opacity < 1.0 else ""
        return (
            f'<image {self._map_rectangle()} preserveAspectRatio="none"{opacity} '
            f'href="data:image/png;base64,{data}"/>'
        )

    def _glow(self, part: Glow) -> str:
        stops = []
        for index in range(STOPS + 1):
            share = index / STOPS
            radius = part.near * (part.far / part.near) ** share
            tint = mix(part.inner, part.outer, share)
            stops.append(f'<stop offset="{radius / part.far:.5g}" stop-color="{tint}"/>')
        place = f'cx="{_number(part.x)}" cy="{_number(part.y)}" r="{_number(part.far)}"'
        fill = self._define(
            f'<radialGradient id="{{id}}" gradientUnits="userSpaceOnUse" '
            f"{place}>{''.join(stops)}</radialGradient>"
        )
        return f'<rect {self._map_rectangle()} fill="{fill}"/>'


def _closed_line(line: Ints) -> str:
    """Return a rectilinear closed line as relative path steps: across, up, across, ..."""
    x, y = line[0]
    steps = np.diff(line, axis=0)
    words = [f"h{dx}" if dx else f"v{dy}" for dx, dy in steps.tolist()]
    return f"M{x} {y}{''.join(words)}z"
