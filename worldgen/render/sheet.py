"""Many worlds on one sheet, each with the paths of the same robots: small multiples."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from worldgen.errors import InvalidParameter
from worldgen.render.caption import BAR, key_of_cards, wrapped
from worldgen.render.content import Content
from worldgen.render.disturbance_parts import above_the_trail
from worldgen.render.event_window import event_window
from worldgen.render.frame import Frame
from worldgen.render.lettering import length_words, scale_bar
from worldgen.render.marks import SPECIFICATION, darker, hue, rgb
from worldgen.render.overlay import Trail
from worldgen.render.png import draw_parts
from worldgen.render.polyline import simplified
from worldgen.render.primitives import DrawnCircle, DrawnLine, Paint, Primitive
from worldgen.render.scene import card_content, card_parts
from worldgen.world import World

# Longer side of a map, px.
_PANEL = 300
# Distance between panels, px.
_GAP = 14
# Height of a line of text, px.
_LINE = 22
# Margin, px.
_TYPE = 15
# Height of the scale bar below a map, px.
_BAR_ROOM = 20
# Size of the text at a scale bar, px.
_SMALL_TYPE = 12
# Height of a line of small text, px, and the most lines of it.
_SMALL_LINE = 16
_MOST_LINES = 4
# Width of a robot's path, px.
_WIDTH = 2.2
# The end of the legend.
_DOT = "dot: where the run ended"


@dataclass(frozen=True)
class Panel:
    """One world on a sheet.

    Args:
        world: What to draw.
        title: Text above it.
        trails: The robots' paths, in the sheet's order. A list has the paths that all robots drive
            with one controller, in one colour.
        notes: A line below it for each robot, in the robot's colour.
        words: What happens in it; wrapped below the notes.
    """

    world: World
    title: str
    trails: tuple[Trail | list[Trail], ...]
    notes: tuple[str, ...] = ()
    words: str = ""


def draw_sheet(
    panels: Sequence[Panel], robots: Sequence[str], *, columns: int = 0, pixels: int = _PANEL
) -> bytes:
    """Return the worlds next to each other, as the bytes of a PNG file.

    Args:
        panels: The worlds.
        robots: Names of the robots, for the legend; if empty, there is no legend.
        columns: Panels in a row; 0 chooses the number.
        pixels: Longer side of a map, px.

    Raises:
        InvalidParameter: If there is no world, or there are more robots than colours.
    """
    # Refuse what cannot be drawn.
    if not panels:
        raise InvalidParameter("empty", "there is no world to draw", "pass at least one")
    if len(robots) > len(SPECIFICATION.series):
        raise InvalidParameter(
            "too-many-robots",
            "{robots} robots are more than a picture can distinguish",
            "use at most {most}",
            robots=len(robots),
            most=len(SPECIFICATION.series),
        )
    columns = columns or min(len(panels), 5 if len(panels) > 8 else 4)
    # Draw the panels, and arrange them in rows.
    contents: list[Content] = []
    drawn = [_panel(panel, pixels, contents) for panel in panels]
    width = max(image.width for image in drawn)
    rows = [drawn[k : k + columns] for k in range(0, len(drawn), columns)]
    heights = [max(image.height for image in row) + _GAP for row in rows]
    # A sheet of few worlds is as wide as its legend.
    wide = columns * (width + _GAP)
    top = _GAP
    key = None
    if robots:
        wide = max(wide, math.ceil(_legend_width(robots)))
        top += _LINE + _GAP
    elif contents and any(content.trails for content in contents):
        key = _key(contents, wide + _GAP)
        top += key.height
    sheet = Image.new("RGB", (wide + _GAP, top + sum(heights)), hue("paper"))
    if robots:
        _draw_legend(sheet, robots)
    elif key is not None:
        sheet.paste(key, (0, 0))
    # Paste the panels.
    for row, height in zip(rows, heights, strict=True):
        for k, image in enumerate(row):
            sheet.paste(image, (_GAP + k * (width + _GAP), top))
        top += height
    stream = io.BytesIO()
    sheet.save(stream, "PNG")
    return stream.getvalue()


def _key(contents: Sequence[Content], width: int) -> Image.Image:
    """Return the key to pictures of one run each."""
    unit = 1.1
    parts, height = key_of_cards(contents, _GAP, width - 2.0 * _GAP, unit)
    size = (width, math.ceil(height) + _GAP)
    ground = DrawnLine(
        np.array(((0.0, 0.0), (size[0], 0.0), size, (0.0, size[1])), np.float64),
        Paint(fill=hue("paper")),
        closed=True,
    )
    return draw_parts([ground, *parts], contents[0].frame, size)


def _panel(panel: Panel, pixels: int, contents: list[Content]) -> Image.Image:
    # One run is drawn as every failure is, of several each path has a colour of its own.
    world = panel.world
    alone = [trail for trail in panel.trails if isinstance(trail, Trail)]
    if len(alone) == len(panel.trails) and (world.is_fleet or len(alone) < 2):
        frame = Frame.of(world, pixels, window=event_window(world, alone, pixels))
        contents.append(card_content(world, alone, frame))
        parts = card_parts(contents[-1])
    else:
        frame = Frame.of(world, pixels)
        parts = card_parts(card_content(world, (), frame))
        for k, shown in enumerate(panel.trails):
            shift = (k - (len(panel.trails) - 1) / 2) * _WIDTH * 0.6
            for trail in shown if isinstance(shown, list) else [shown]:
                parts += _way(trail, frame, shift, series_colour(k))
                parts += above_the_trail(trail.disturbances, frame, world.cell_size)
    size = (frame.picture_width, frame.bottom + frame.band + frame.margin)
    picture = draw_parts(parts, frame, size)
    box = (
        frame.left - frame.band,
        frame.top - frame.band,
        frame.left + frame.width + frame.band,
        frame.bottom + frame.band,
    )
    chart = picture.crop(box)
    # Add the title above it and the notes below.
    font = ImageFont.load_default(_TYPE)
    text = max(font.getlength(line) for line in (panel.title, *panel.notes))
    # A narrow world keeps its text.
    width = max(chart.width, min(math.ceil(text), pixels))
    below = _LINE + chart.height + _BAR_ROOM
    lines = wrapped(panel.words, width, _SMALL_TYPE, _MOST_LINES)
    high = below + _LINE * len(panel.notes) + _SMALL_LINE * len(lines)
    image = Image.new("RGB", (width, high), hue("paper"))
    image.paste(chart, (0, _LINE))
    pen = ImageDraw.Draw(image)
    _draw_scale(pen, frame, chart.width, below)
    pen.text((0, _LINE - 6), panel.title, fill=rgb(hue("ink")), font=font, anchor="ls")
    for k, note in enumerate(panel.notes):
        baseline = below + (k + 1) * _LINE - 6
        pen.text(
            (0, baseline), note, fill=rgb(darker(series_colour(k), 0.25)), font=font, anchor="ls"
        )
    small = ImageFont.load_default(_SMALL_TYPE)
    for k, line in enumerate(lines, start=1):
        baseline = below + _LINE * len(panel.notes) + k * _SMALL_LINE - 4
        pen.text((0, baseline), line, fill=rgb(hue("ink")), font=small, anchor="ls")
    return image


def series_colour(number: int) -> str:
    """Return the colour of one of several controllers, given its index."""
    return hue(SPECIFICATION.series[number])


def _draw_scale(pen: ImageDraw.ImageDraw, frame: Frame, width: int, bottom: int) -> None:
    """Draw a bar of a round length, with its unit, below a map."""
    metres = scale_bar(BAR * width / frame.scale)
    length = metres * frame.scale
    font = ImageFont.load_default(_SMALL_TYPE)
    words = length_words(metres)
    low = bottom - 7
    bar = ((1, low - 5), (1, low), (1 + length, low), (1 + length, low - 5))
    pen.line(bar, fill=rgb(hue("ink")), width=2)
    pen.text((7 + length, low + 1), words, fill=rgb(hue("ink")), font=font, anchor="ls")


def _way(trail: Trail, frame: Frame, shift: float, colour: str) -> list[Primitive]:
    """Return a robot's path, shifted slightly from the others', so that equal ones stay visible."""
    points = simplified(frame.points(np.column_stack((trail.x, trail.y))), 0.3)
    points = points + shift
    if len(points) < 2:
        points = np.repeat(points, 2, axis=0)
    x, y = (float(value) for value in points[-1])
    return [
        DrawnLine(points, Paint(stroke=hue("paper"), width=_WIDTH + 1.4, opacity=0.6)),
        DrawnLine(points, Paint(stroke=colour, width=_WIDTH)),
        DrawnCircle(x, y, 4.5, Paint(fill=colour, stroke=hue("paper"), width=1.2)),
    ]


def _legend_width(robots: Sequence[str]) -> float:
    """Return where the legend ends, px from the left."""
    font = ImageFont.load_default(_TYPE)
    return _GAP + sum(60 + font.getlength(name) for name in robots) + font.getlength(_DOT)


def _draw_legend(sheet: Image.Image, robots: Sequence[str]) -> None:
    pen = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(_TYPE)
    x = float(_GAP)
    y = _GAP + _LINE / 2
    for k, name in enumerate(robots):
        pen.line((x, y, x + 26, y), fill=rgb(series_colour(k)), width=4)
        pen.text((x + 34, y), name, fill=rgb(hue("ink")), font=font, anchor="lm")
        x += 34 + font.getlength(name) + 26
    pen.text((x, y), _DOT, fill=rgb(hue("quiet")), font=font, anchor="lm")
