"""Render a scene as PNG: shapes are drawn large as masks, shrunk, and composited.

This gives smooth edges and true colours.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont
from PIL.PngImagePlugin import PngInfo

from worldgen.render.coverage import coverage
from worldgen.render.frame import DEFAULT_PIXELS, Frame
from worldgen.render.marks import hue, rgb
from worldgen.render.overlay import Trails
from worldgen.render.polyline import dashes
from worldgen.render.primitives import (
    DrawnCells,
    DrawnCircle,
    DrawnLine,
    Glow,
    Paint,
    Primitive,
    Text,
)
from worldgen.render.scene import compose
from worldgen.support.arrays import Floats
from worldgen.world import World

# Oversampling of masks.
FINE = 4
# Oversampling for pictures so large that FINE would take gigabytes.
COARSE = 2
# Sizes, px.
LARGE = 2500


def draw_png(
    world: World,
    *,
    trail: Trails = None,
    signal: bool = True,
    witness: bool = True,
    title: str = "",
    pixels: int = DEFAULT_PIXELS,
) -> bytes:
    """Return the picture of a world, and of a run in it, as the bytes of a PNG file.

    The file also has its words as text, under ``Description``: the caption, the legend, and the
    numbers in the map, a line each. Programs that describe pictures to people read it there.

    Args:
        world: What to draw.
        trail: A robot's trail; for several robots, one trail for each.
        signal: True to tint the floor by the strength of the target's signal.
        witness: True to draw the certificate's path, or its cut.
        title: First line of the caption.
        pixels: Longer side of the map, px; margins and caption are added.

    Raises:
        InvalidParameter: If ``pixels`` is out of range.
    """
    scene = compose(world, trail, signal=signal, witness=witness, title=title, pixels=pixels)
    image = draw_parts(scene.primitives, scene.frame, (scene.width, scene.height))
    words = PngInfo()
    words.add_text(
        "Description", "\n".join(part.text for part in scene.primitives if isinstance(part, Text))
    )
    stream = io.BytesIO()
    image.save(stream, "PNG", pnginfo=words)
    return stream.getvalue()


def draw_parts(
    parts: Iterable[Primitive],
    frame: Frame,
    size: tuple[int, int],
    *,
    onto: Image.Image | None = None,
) -> Image.Image:
    """Render primitives, the lowest first.

    Args:
        parts: The primitives.
        frame: The map's place in the picture.
        size: Width and height of the picture, px.
        onto: A picture of this size to draw on; it is changed in place.
    """
    canvas = _Canvas(frame, size)
    canvas.image = onto or canvas.image
    for part in parts:
        canvas.draw(part)
    return canvas.image


class _Canvas:
    """A picture under construction.

    Args:
        frame: The map's place in the picture.
        size: Width and height, px.
    """

    def __init__(self, frame: Frame, size: tuple[int, int]) -> None:
        self.frame = frame
        self.image = Image.new("RGB", size, rgb(hue("paper")))
        self.times = FINE if max(size) <= LARGE else COARSE

    def draw(self, part: DrawnCircle | DrawnLine | DrawnCells | Glow | Text) -> None:
        """Draw one primitive on the picture."""
        if isinstance(part, DrawnCircle):
            self._circle(part)
        elif isinstance(part, DrawnLine):
            self._path(part)
        elif isinstance(part, DrawnCells):
            self._cells(part)
        elif isinstance(part, Glow):
            self._glow(part)
        else:
            self._text(part)

    def _map_box(self) -> tuple[int, int, int, int]:
        frame = self.frame
        return frame.left, frame.top, frame.left + frame.width, frame.bottom

    def _box(
        self, low: npt.ArrayLike, high: npt.ArrayLike, grow: float, *, clipped: bool
    ) -> tuple[int, int, int, int]:
        """Return the pixels that a shape can touch: left, top, right, bottom."""
        x0, y0 = np.asarray(low, np.float64) - grow
        x1, y1 = np.asarray(high, np.float64) + grow
        left, top, right, bottom = self._map_box() if clipped else (0, 0, *self.image.size)
        return (
            int(min(max(left, math.floor(x0)), right)), int(min(max(top, math.floor(y0)), bottom)),
            int(max(left, min(right, math.ceil(x1)))), int(max(top, min(bottom, math.ceil(y1)))),
        )  # fmt: skip

    def _lay(
        self, mask: Image.Image, box: tuple[int, int, int, int], colour: str, opacity: float
    ) -> None:
        if opacity < 1.0:
            mask = mask.point([round(value * opacity) for value in range(256)])
        self.image.paste(rgb(colour), box, mask)

    def _circle(self, part: DrawnCircle) -> None:
        paint = part.paint
        outer = part.radius + (0.5 * paint.width if paint.stroke else 0.0)
        centre = np.array((part.x, part.y))
        box = self._box(centre - outer, centre + outer, 1.0, clipped=part.clipped)
        if box[0] >= box[2] or box[1] >= box[3]:
            return
        # Pillow has no antialiasing: draw larger on a mask, then reduce it.
        x, y = (centre - box[:2]) * self.times

        def disc(pen: ImageDraw.ImageDraw, radius: float, value: int) -> None:
            reach = radius * self.times
            if reach > 0.0:
                pen.ellipse((x - reach, y - reach, x + reach - 1.0, y + reach - 1.0), fill=value)

        if paint.fill:
            mask, pen = self._mask(box)
            disc(pen, part.radius, 255)
            self._lay(mask.reduce(self.times), box, paint.fill, paint.opacity)
        if paint.stroke:
            mask, pen = self._mask(box)
            # A ring is a disc with a smaller disc removed.
            disc(pen, outer, 255)
            disc(pen, part.radius - 0.5 * paint.width, 0)
            self._lay(mask.reduce(self.times), box, paint.stroke, paint.opacity)

    def _mask(self, box: tuple[int, int, int, int]) -> tuple[Image.Image, ImageDraw.ImageDraw]:
        mask = Image.new("L", ((box[2] - box[0]) * self.times, (box[3] - box[1]) * self.times), 0)
        return mask, ImageDraw.Draw(mask)

    def _path(self, part: DrawnLine) -> None:
        paint = part.paint
        points = part.points
        box = self._box(points.min(axis=0), points.max(axis=0), paint.width + 1.0, clipped=False)
        if box[0] >= box[2] or box[1] >= box[3]:
            return
        if paint.fill:
            # Fill and stroke have different opacities, so each has its own mask.
            mask, pen = self._mask(box)
            _fill(pen, self._fine(points, box))
            self._lay(mask.reduce(self.times), box, paint.fill, paint.opacity)
        if paint.stroke:
            mask, pen = self._mask(box)
            line = np.concatenate((points, points[:1])) if part.closed else points
            for piece in dashes(line, paint.dash) if paint.dash else [line]:
                self._stroke(pen, self._fine(piece, box), paint)
            self._lay(mask.reduce(self.times), box, paint.stroke, paint.opacity)

    def _fine(self, points: Floats, box: tuple[int, int, int, int]) -> list[tuple[float, float]]:
        fine = (points - np.array(box[:2])) * self.times
        return [(float(x), float(y)) for x, y in fine]

    def _stroke(
        self, pen: ImageDraw.ImageDraw, points: list[tuple[float, float]], paint: Paint
    ) -> None:
        width = max(1, round(paint.width * self.times))
        pen.line(points, fill=255, width=width)
        reach = 0.5 * width
        # Round joins and ends.
        for x, y in points if width > 2 else ():
            pen.ellipse((x - reach, y - reach, x + reach - 1.0, y + reach - 1.0), fill=255)

    def _cells(self, part: DrawnCells) -> None:
        frame = self.frame
        values = coverage(frame.part(part.mask), frame.width, frame.height)
        if part.hatch > 0.0:
            y, x = np.indices(values.shape, dtype=np.float32)
            phase = np.abs(((x + y) / (part.hatch * math.sqrt(2.0))) % 1.0 - 0.5)
            stripe = np.clip((0.14 - phase) * part.hatch + 0.5, 0.0, 1.0)
            values = np.rint(values * stripe).astype(np.uint8)
        self._lay(Image.fromarray(values), self._map_box(), part.fill, part.opacity)

    def _glow(self, part: Glow) -> None:
        frame = self.frame
        x = np.arange(frame.width, dtype=np.float32) + np.float32(frame.left + 0.5 - part.x)
        y = np.arange(frame.height, dtype=np.float32) + np.float32(frame.top + 0.5 - part.y)
        square = np.maximum(x * x + (y * y)[:, None], part.near**2)
        share = np.clip(
            np.log(square / part.near**2) / (2.0 * math.log(part.far / part.near)), 0.0, 1.0
        )
        inner = np.array(rgb(part.inner), np.float32)
        outer = np.array(rgb(part.outer), np.float32)
        tint = np.rint(inner + share[:, :, None] * (outer - inner)).astype(np.uint8)
        self.image.paste(Image.fromarray(tint), self._map_box())

    def _text(self, part: Text) -> None:
        font = ImageFont.load_default(part.size)
        ImageDraw.Draw(self.image).text(
            (part.x, part.y), part.text, fill=rgb(part.fill), font=font, anchor="ls"
        )


def _fill(pen: ImageDraw.ImageDraw, points: list[tuple[float, float]]) -> None:
    """Fill a polygon.

    A rectangle ends one pixel early, because Pillow includes its right and lower edges.
    """
    across = sorted({x for x, _ in points})
    up = sorted({y for _, y in points})
    if len(points) == 4 and len(across) == len(up) == 2 and len(set(points)) == 4:
        left, right, top, bottom = (round(value) for value in (*across, *up))
        if left < right and top < bottom:
            pen.rectangle((left, top, right - 1, bottom - 1), fill=255)
            return
    pen.polygon(points, fill=255)
