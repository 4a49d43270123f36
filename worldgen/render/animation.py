"""Render a run as an animated GIF.

The same run gives the same bytes, of bounded size, in a file that every viewer can read. All frames
share one palette of fixed colours, so that nothing flickers and only changes are stored.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence

import numpy as np
from PIL import Image, ImageDraw

from worldgen.errors import InvalidParameter
from worldgen.render.body_parts import BodyPose, body_shapes, front_mark
from worldgen.render.caption import printable, wrapped
from worldgen.render.disturbance_parts import above_the_trail
from worldgen.render.frame import Frame
from worldgen.render.lettering import text_width
from worldgen.render.marks import MARKS, hue, mix, rgb, robot_colours
from worldgen.render.overlay import Drive
from worldgen.render.png import draw_parts
from worldgen.render.primitives import DrawnCircle, DrawnLine, Paint, Primitive, Text
from worldgen.render.robot_parts import colour_of
from worldgen.render.scene import moment_parts
from worldgen.render.trail_parts import breach_crosses, pierced_ground, pierced_parts
from worldgen.support.arrays import Floats
from worldgen.timeline import CellState
from worldgen.world import World

MOST_FRAMES = 120
# Length of an animation, s, before it is extended by another loop.
SECONDS = 9.0
# Fraction of a run: a loop that takes less is shown once more.
BLINK = 0.2
# Time that the last frame is shown, ms.
HELD = 1500
# Lines of the title, and of the names of several robots.
_MOST_TITLE = 2
_MOST_NAMES = 8
# Marks whose insides have a tint.
_TINTED = ("fire", "start", "target")
# Sizes, px.
DEFAULT_SIDE = 480
# Oversampling of trails.
FINE = 2


def draw_gif(
    world: World, drives: Sequence[Drive], *, title: str = "", pixels: int = DEFAULT_SIDE
) -> bytes:
    """Return robots driving in a world as the bytes of an endlessly repeating animated GIF.

    Args:
        world: The world they drive in.
        drives: The robots, which start together; the longest run sets the length.
        title: First line below the map.
        pixels: Longer side of the map, px.

    Raises:
        InvalidParameter: If ``pixels`` is out of range, or there is no robot.
    """
    if not drives:
        raise InvalidParameter("empty", "an animation needs a robot", "use at least one run")
    stage = _Stage(world, Frame.of(world, pixels), tuple(drives), title)
    times = _times(drives)
    palette = _palette()
    frames = (stage.at(time).quantize(palette=palette, dither=Image.Dither.NONE) for time in times)
    # Duration in ms; a GIF counts hundredths of a second.
    pause = max(20, round(100.0 * SECONDS / len(times)) * 10)
    stream = io.BytesIO()
    first = next(frames)
    first.save(
        stream,
        "GIF",
        save_all=True,
        append_images=frames,
        duration=[pause] * (len(times) - 1) + [HELD],
        loop=0,
        disposal=1,
    )
    return stream.getvalue()


def _times(drives: Sequence[Drive]) -> list[float]:
    """Return the times of the frames, s.

    They are evenly spaced over the longest run; a loop that would pass too fast is shown once more,
    slower.
    """
    longest = max(drives, key=lambda drive: drive.end)
    end = longest.end
    entry = longest.trail.loop_from
    count = max(2, min(MOST_FRAMES, max(len(drive.headings) for drive in drives)))
    period = 0.0 if entry is None else end - float(longest.times[entry])
    if not 0.0 < period < BLINK * end:
        return [float(time) for time in np.linspace(0.0, end, count)]
    way = np.linspace(0.0, end, max(2, 2 * count // 3))
    return [
        float(time) for time in (*way, *np.linspace(end, end + period, max(2, count // 3 + 1))[1:])
    ]


class _Stage:
    """The drawing at successive times."""

    def __init__(self, world: World, frame: Frame, drives: Sequence[Drive], title: str) -> None:
        self.world = world
        self.frame = frame
        self.drives = drives
        self.line = 19.0 * frame.unit
        self.type = 14.0 * frame.unit
        room = frame.picture_width - 2.0 * frame.margin
        self.title_lines = wrapped(printable(title), room, self.type, _MOST_TITLE)
        lines = len(self.title_lines) + len(self._named()) + 1.4
        height = frame.bottom + frame.top + round(lines * self.line)
        self.size = frame.picture_width, height
        # Add the marks in the cells.
        self.changes = 0
        self.ground: Image.Image | None = None
        self.trails = [
            trail
            for k, drive in enumerate(drives)
            for trail in _trails(drive, frame, self._colour(k))
        ]
        self.masks = [
            Image.new("L", (FINE * self.size[0], FINE * self.size[1]), 0) for _ in self.trails
        ]

    def _colour(self, robot: int) -> str:
        return colour_of(robot) if len(self.drives) > 1 else hue("loop")

    def at(self, time: float) -> Image.Image:
        """Return the picture at a time later than all earlier ones."""
        # Draw the trails on the ground.
        picture = self._ground_at(time).copy()
        for trail, mask in zip(self.trails, self.masks, strict=True):
            trail.drawn_until(time, mask)
            picture.paste(rgb(trail.colour), None, mask.reduce(FINE))
        # Draw the walls that have been entered by then.
        pierced = [
            cell
            for drive in self.drives
            for cell in drive.trail.pierced
            if cell.time <= time + 1e-9
        ]
        if pierced:
            picture = draw_parts(
                pierced_parts(pierced, self.world.walls.shape, self.frame),
                self.frame,
                self.size,
                onto=picture,
            )
        # Draw the robots above everything else.
        parts = [
            part for k, drive in enumerate(self.drives) for part in self._robot(k, drive, time)
        ]
        disturbed = [
            part
            for drive in self.drives
            for part in above_the_trail(drive.trail.disturbances, self.frame, self.world.cell_size)
        ]
        return draw_parts(
            [*parts, *disturbed, *breach_crosses(pierced, self.frame), *self._words(time)],
            self.frame,
            self.size,
            onto=picture,
        )

    def _ground_at(self, time: float) -> Image.Image:
        time += 1e-9
        until = self.world.timeline.count_until(time)
        if self.ground is None or until > self.changes:
            cells = self.world.cells_at(time)
            self.changes = until
            solid = cells == CellState.SOLID
            burning = cells == CellState.BURNING
            parts = moment_parts(self.world, self.frame, solid, burning, self.size[1])
            self.ground = draw_parts(parts, self.frame, self.size)
        return self.ground

    def _robot(self, number: int, drive: Drive, time: float) -> list[Primitive]:
        colour = self._colour(number)
        x, y, heading = drive.pose(drive.moment(time))
        left, top = self.frame.to_pixels(x, y)
        unit = self.frame.unit
        # Drives of one robot show several controllers in the same world.
        robots = self.world.robots
        robot = robots[number] if len(robots) > 1 else robots[0]
        if not robot.is_disc:
            edge = Paint(stroke=hue("ink") if len(self.drives) == 1 else colour, width=2.0 * unit)
            pose = BodyPose(x, y, heading)
            paints = (Paint(fill=mix(hue("floor"), colour, 0.35)), edge)
            return [
                *body_shapes(robot, pose, self.frame, paints),
                *front_mark(robot, pose, self.frame, hue("ink")),
            ]
        radius = max(robot.radius * self.frame.scale, 3.5 * unit)
        nose = np.array(
            ((left, top), (left + radius * math.cos(heading), top - radius * math.sin(heading)))
        )
        return [
            DrawnCircle(left, top, radius, Paint(fill=mix(hue("floor"), colour, 0.35))),
            DrawnCircle(
                left,
                top,
                radius,
                Paint(stroke=hue("ink") if len(self.drives) == 1 else colour, width=2.0 * unit),
            ),
            DrawnLine(nose, Paint(stroke=hue("ink"), width=2.0 * unit)),
        ]

    def _words(self, time: float) -> list[Primitive]:
        """Return the title, the time, and of several robots the name of each on a line of its own."""
        left = float(self.frame.margin)
        top = self.frame.bottom + self.frame.top + 0.75 * self.line
        parts: list[Primitive] = []
        lines = [(line, hue("ink")) for line in self.title_lines]
        lines.append((f"{time:.2f} s", hue("quiet")))
        lines += [(drive.name, self._colour(k)) for k, drive in enumerate(self._named())]
        for words, colour in lines:
            room = self.size[0] - 2.0 * left
            parts.append(Text(left, top, self.type, _fitted(words, room, self.type), colour))
            top += self.line
        return parts

    def _named(self) -> Sequence[Drive]:
        return self.drives[:_MOST_NAMES] if len(self.drives) > 1 else ()


class _GrowingTrail:
    """A line that grows from frame to frame; each piece is drawn once."""

    def __init__(self, points: Floats, times: Floats, colour: str, width: float) -> None:
        fine = np.rint(points * FINE)
        moved = np.ones(len(fine), np.bool_)
        moved[1:] = (fine[1:] != fine[:-1]).any(axis=1)
        self.points = fine[moved]
        self.times = times[moved]
        self.colour = colour
        self.width = max(1, round(width * FINE))
        self.done = 0

    def drawn_until(self, time: float, mask: Image.Image) -> None:
        """Draw everything added since the last call."""
        # The tolerance keeps a point whose time was rounded to the frame's.
        until = int(np.searchsorted(self.times, time + 1e-9, side="right"))
        if until <= max(self.done, 1):
            return
        pen = ImageDraw.Draw(mask)
        # Only the new piece is drawn, from the last point of the previous one.
        piece = [(float(x), float(y)) for x, y in self.points[max(0, self.done - 1) : until]]
        pen.line(piece, fill=255, width=self.width)
        reach = 0.5 * self.width
        for x, y in piece:
            pen.ellipse((x - reach, y - reach, x + reach - 1.0, y + reach - 1.0), fill=255)
        self.done = until


def _trails(drive: Drive, frame: Frame, colour: str) -> Iterator[_GrowingTrail]:
    """Yield the path to the cycle, and the cycle, each in its own colour."""
    points = frame.points(drive.trail.points)
    unit = frame.unit
    entry = drive.trail.loop_from
    if entry is None:
        yield _GrowingTrail(points, drive.times, colour, MARKS["trail"].width * unit)
        return
    before = mix(hue("floor"), colour, MARKS["approach"].fade[-1])
    yield _GrowingTrail(
        points[: entry + 1], drive.times[: entry + 1], before, MARKS["approach"].width * unit
    )
    yield _GrowingTrail(points[entry:], drive.times[entry:], colour, MARKS["loop"].width * unit)


def _fitted(text: str, room: float, size: float) -> str:
    """Return the text, shortened with three dots if it is wider than the room, px."""
    text = printable(text)
    if text_width(text, size) <= room:
        return text
    while text and text_width(text + "...", size) > room:
        text = text[:-1]
    return text + "..."


def _palette() -> Image.Image:
    """Return all colours of all frames.

    These are each meaning's colour, and its edges against floor, wall and paper.
    """
    names = ("paper", "floor", "wall", "ink", "loop", "start", "target", "fire", "quiet", "breach")
    before = mix(hue("floor"), hue("loop"), MARKS["approach"].fade[-1])
    tints = (mix(hue("floor"), hue(MARKS[name].colour), MARKS[name].fill) for name in _TINTED)
    solid = (*map(hue, names), before, *tints, *robot_colours(), hue("pierced"), pierced_ground())
    shares = (0.2, 0.35, 0.5, 0.65, 0.82)
    edges = [
        mix(ground, colour, share)
        for ground in (hue("floor"), hue("wall"))
        for colour in solid
        for share in shares
    ]
    colours = list(
        dict.fromkeys((*solid, *(mix(hue("paper"), hue("ink"), share) for share in shares), *edges))
    )[:256]
    palette = Image.new("P", (1, 1))
    palette.putpalette([value for colour in colours for value in rgb(colour)])
    return palette
