"""The strip under the map: title, scale, and a key to the picture."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from worldgen.render.content import Content
from worldgen.render.disturbance_parts import decoy_mark, push_arrow
from worldgen.render.fleet_parts import COLOURS, colour_of
from worldgen.render.named_parts import named_mark
from worldgen.render.overlay import Trail
from worldgen.render.palette import (
    APPROACH,
    FIRE,
    FLOOR,
    FULL_TINT,
    GREY,
    INK,
    LOOP,
    LOOP_HEAD,
    MEMORY,
    MISSED,
    PAPER,
    PIERCED,
    PIERCED_GROUND,
    PUSH,
    START,
    TARGET,
    TUNNEL,
    WALL,
    mix,
)
from worldgen.render.primitives import DrawnCircle, DrawnLine, Paint, Primitive, Text
from worldgen.render.trail_parts import (
    arrow,
    arrow_head,
    cross,
    heading_tick,
    ring_and_cross,
    robot_at,
    robot_disc,
    stays_put,
)
from worldgen.robot_overrides import describe_goal
from worldgen.world import Cut, JointWitness, Witness, World

# Sizes in units.
TITLE_SIZE = 16.0
TEXT_SIZE = 12.5
# Line distance divided by type size.
LEADING = 1.5
MOST_LINES = 3
# Width of a key's sample, units.
ICON = 26.0
# Distance between two keys, units.
GAP = 18.0
# Largest share of a map's width that its scale bar takes. Round lengths are up to 2.5 times apart,
# so it takes at least a seventh.
BAR = 0.35

Sample = Callable[[float, float, float], list[Primitive]]
"""Draws a key's sample, given its left end, the y of its middle, and the unit, all px."""


def facts(world: World) -> str:
    """Return the scale, the world's origin, and its failure, in one line."""
    width = world.width * world.cell_size
    height = world.height * world.cell_size
    parts = [
        f"{width:.6g} x {height:.6g} m, cell {world.cell_size:.6g} m, robot radius "
        f"{world.robot_radius:.6g} m"
    ]
    if goal := describe_goal(world.target):
        parts.append(f"its goal asks for {goal}")
    if world.provenance is not None:
        parts.append(f"{world.provenance.family}, seed {world.provenance.seed}")
        parts += world.provenance.changed
    if world.failure is not None:
        parts.append(f"{world.failure.who}: {world.failure.outcome}")
    return printable("; ".join(parts))


def printable(text: str) -> str:
    """Replace line ends and characters that no file format can hold.

    They become a blank or ``?``.
    """
    return "".join(char if char.isprintable() else " " if char.isspace() else "?" for char in text)


def text_width(text: str, size: float) -> float:
    """Estimate the width of a line in a common sans-serif face, the same for every backend."""
    narrow = "iljtfrI.,:;'|!()[] "
    wide = "mwMW@%"
    ems = sum(
        0.30 if c in narrow else 0.88 if c in wide else 0.68 if c.isupper() else 0.58 for c in text
    )
    return ems * size


def wrapped(text: str, width: float, size: float, most: int) -> list[str]:
    """Wrap the text into at most ``most`` lines; end text that does not fit in three dots."""
    lines: list[str] = []
    for word in text.split():
        joined = f"{lines[-1]} {word}" if lines else word
        if lines and text_width(joined, size) <= width:
            lines[-1] = joined
        else:
            lines.append(word)
    if len(lines) > most:
        lines = [*lines[: most - 1], " ".join(lines[most - 1 :])]
    return [_cut_off(line, width, size) for line in lines]


def _cut_off(line: str, width: float, size: float) -> str:
    if text_width(line, size) <= width:
        return line
    # No letter is narrower than this, which bounds the work on a long line.
    line = line[: int(width / (0.25 * size))]
    while line and text_width(line + "...", size) > width:
        line = line[:-1]
    return line + "..."


def caption(content: Content) -> tuple[list[Primitive], int]:
    """Return the strip's primitives, and the height of the whole picture in px."""
    frame = content.frame
    unit = frame.unit
    left = float(frame.margin)
    room = frame.picture_width - 2.0 * left
    y = frame.bottom + frame.band + 8.0 * unit
    parts: list[Primitive] = []
    for text, size, colour in (
        (printable(content.title), TITLE_SIZE * unit, INK),
        (facts(content.world), TEXT_SIZE * unit, GREY),
    ):
        for line in wrapped(text, room, size, MOST_LINES):
            y += LEADING * size
            parts.append(Text(left, y - 0.35 * size, size, line, colour))
    bar = scale_bar(BAR * frame.width / frame.scale)
    length = bar * frame.scale
    keys = [
        (f"{bar:g} m", _scale_sample(length), length),
        *((words, sample, ICON * unit) for words, sample in _all_keys(content)),
    ]
    placed, y = _place(keys, left, room, y + 4.0 * unit, unit)
    return parts + placed, round(y + 10.0 * unit)


def scale_bar(most: float) -> float:
    """Return the longest round length up to a limit: 1, 2 or 5 times a power of ten.

    Args:
        most: The limit, m; above 0.
    """
    power = 10.0 ** math.floor(math.log10(most) + 1e-9)
    factor = next(one for one in (5.0, 2.0, 1.0) if one * power <= most * (1.0 + 1e-9))
    # Rounding hides the last digit of a power below 1.
    return float(f"{factor * power:.3g}")


def _scale_sample(length: float) -> Sample:
    """Return the sample of a scale bar.

    Args:
        length: Length of the bar, px.
    """

    def sample(x: float, y: float, unit: float) -> list[Primitive]:
        tick = 4.0 * unit
        points = np.array(
            ((x, y - tick), (x, y + tick), (x + length, y + tick), (x + length, y - tick))
        )
        return [DrawnLine(points, Paint(stroke=INK, width=1.5 * unit))]

    return sample


def _place(
    keys: list[tuple[str, Sample, float]], left: float, room: float, y: float, unit: float
) -> tuple[list[Primitive], float]:
    """Place keys in rows below a y, each as its words, its sample and the sample's width, px."""
    size = TEXT_SIZE * unit
    row = 1.75 * TEXT_SIZE * unit
    parts: list[Primitive] = []
    x = left
    y = y + row
    for words, sample, wide in keys:
        width = wide + 6.0 * unit + text_width(words, size)
        # Start a new row if the entry doesn't fit; the first of a row always stays.
        if x > left and x + width > left + room:
            x = left
            y = y + row
        parts += sample(x, y - 0.5 * row, unit)
        begin = x + wide + 6.0 * unit
        parts.append(Text(begin, y - 0.5 * row + 0.35 * size, size, words, INK))
        x += width + GAP * unit
    return parts, y


def _all_keys(content: Content) -> list[tuple[str, Sample]]:
    named = [("cell named in the text", _named_sample)] if content.named else []
    return [*_keys(content), *named]


def _keys(content: Content) -> list[tuple[str, Sample]]:
    world = content.world
    trail = content.trail
    changes = content.changes
    if world.is_fleet:
        return _robot_keys(content)
    # Start, target, signal and proof.
    keys: list[tuple[str, Sample]] = [("start", _start_sample), ("target", _target_sample)]
    if content.signal:
        keys.append(("signal, halves per ring", _signal_sample))
    if content.witness and isinstance(world.certificate, Witness):
        keys.append(("a path that fits", _line(START, 1.8, dash=(7.0, 5.0))))
    if content.witness and isinstance(world.certificate, Cut):
        keys.append(("cut: every gap too narrow", _line(TUNNEL, 3.0)))
    # Add the run, and the changes.
    if trail is not None:
        keys += _trail_keys(trail, on_the_spot=stays_put(trail, content.frame, world.robot_radius))
    if changes.burns.any():
        keys.append(("burns", _swatch(mix(PAPER, FIRE, 0.65))))
    if changes.closes.any():
        keys.append(("closes later", _swatch(mix(PAPER, GREY, 0.55))))
    if changes.opens.any():
        keys.append(("opens later", _opens_sample))
    return keys


def _robot_keys(content: Content) -> list[tuple[str, Sample]]:
    """Return the key to a picture of several robots: their colours, as long as they differ."""
    robots = content.world.robots
    shown = min(len(robots), len(COLOURS))
    keys: list[tuple[str, Sample]] = [
        (f"robot {number + 1}", _line(colour_of(number), 2.4)) for number in range(shown)
    ]
    keys.append(("target", _target_sample))
    if content.witness and isinstance(content.world.certificate, JointWitness):
        keys.append(("paths that fit", _line(GREY, 1.4, dash=(5.0, 5.0))))
    if any(trail.loop_from is not None for trail in content.trails):
        keys.append(("strong: repeats forever", _line(GREY, 3.2)))
    if any(trail.blocked_by for trail in content.trails):
        keys.append(("is blocked by", _blocked_sample))
    return keys


def _trail_keys(trail: Trail, *, on_the_spot: bool) -> list[tuple[str, Sample]]:
    # The path and its loop.
    if trail.loop_from is None:
        keys: list[tuple[str, Sample]] = [("robot's path", _line(LOOP, 2.2, arrow=True))]
    else:
        keys = [("approach", _line(APPROACH, 1.8))] if trail.loop_from > 0 else []
        spot = ("loop, forever on this spot", _end_sample)
        keys.append(spot if on_the_spot else ("loop, forever", _line(LOOP, 3.2, arrow=True)))
    # The obstacle that the robot hit.
    kinds = {mark.kind for mark in trail.marks}
    if "end" in kinds or trail.loop_from is None:
        keys.append(("end", _end_sample))
    if "bump" in kinds:
        keys.append(("bump", _dot(INK, 2.4)))
    if trail.pierced:
        keys.append(("a wall that it entered", _pierced_sample))
    if "overlap" in kinds and not trail.pierced:
        keys.append(("overlap", _overlap_sample))
    if "tunnel" in kinds and not trail.pierced:
        keys.append(("through a wall", _tunnel_sample))
    # What moved the robot.
    disturbances = trail.disturbances
    if disturbances.pushes:
        keys.append(("push", _push_sample))
    if disturbances.places:
        keys.append(("place that pushes", _swatch(mix(PAPER, PUSH, 0.5))))
    if trail.missed is not None and trail.missed.any():
        keys.append(("not covered", _swatch(mix(PAPER, MISSED, 0.55))))
    if trail.memory is not None and not trail.memory.is_empty:
        keys.append(("the robot's own map", _memory_sample))
    if disturbances.drift_heading is not None:
        keys.append(("tilted floor", _line(mix(PAPER, PUSH, 0.6), 1.6)))
    if disturbances.decoys:
        keys.append(("decoy source", _decoy_sample))
    return keys


def _line(
    colour: str, width: float, *, dash: tuple[float, ...] = (), arrow: bool = False
) -> Sample:
    def sample(x: float, y: float, unit: float) -> list[Primitive]:
        ends = np.array(((x, y), (x + ICON * unit, y)))
        paint = Paint(
            stroke=colour, width=width * unit, dash=tuple(length * unit for length in dash)
        )
        head = (
            [arrow_head(x + 0.5 * ICON * unit, y, 0.0, (2.2 * width + 4.0) * unit, LOOP_HEAD)]
            if arrow
            else []
        )
        return [DrawnLine(ends, paint), *head]

    return sample


def _swatch(colour: str) -> Sample:
    def sample(x: float, y: float, unit: float) -> list[Primitive]:
        return [_square(x, y, unit, Paint(fill=colour, stroke=None))]

    return sample


def _dot(colour: str, radius: float) -> Sample:
    def sample(x: float, y: float, unit: float) -> list[Primitive]:
        return [DrawnCircle(x + 0.5 * ICON * unit, y, radius * unit, Paint(fill=colour))]

    return sample


def _square(x: float, y: float, unit: float, paint: Paint) -> DrawnLine:
    corners = np.array(((4.0, -6.0), (22.0, -6.0), (22.0, 6.0), (4.0, 6.0))) * unit
    return DrawnLine(np.array((x, y)) + corners, paint, closed=True)


def _opens_sample(x: float, y: float, unit: float) -> list[Primitive]:
    dotted = Paint(stroke=PAPER, width=1.8 * unit, dash=(1.8 * unit, 3.2 * unit))
    inner = np.array(((7.0, -3.0), (19.0, -3.0), (19.0, 3.0), (7.0, 3.0))) * unit
    return [
        _square(x, y, unit, Paint(fill=WALL)),
        DrawnLine(np.array((x, y)) + inner, dotted, closed=True),
    ]


def _start_sample(x: float, y: float, unit: float) -> list[Primitive]:
    x += 0.5 * ICON * unit
    tick = Paint(stroke=mix(START, "#000000", 0.45), width=3.0 * unit)
    return [
        *robot_disc(x, y, 7.0 * unit, unit, colour=START, tint=0.45, width=2.0),
        heading_tick(x, y, 7.0 * unit, 0.0, tick),
    ]


def _target_sample(x: float, y: float, unit: float) -> list[Primitive]:
    stroke = Paint(stroke=TARGET, width=2.0 * unit)
    return ring_and_cross(x + 0.5 * ICON * unit, y, 5.0 * unit, 8.0 * unit, [stroke])


def _named_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return named_mark(x + 0.5 * ICON * unit, y, 6.0 * unit, unit)


def _signal_sample(x: float, y: float, unit: float) -> list[Primitive]:
    steps = 8
    step = ICON * unit / steps
    parts: list[Primitive] = []
    for index in range(steps):
        tint = mix(FULL_TINT, FLOOR, index / (steps - 1))
        corners = np.array(
            ((0.0, -6.0 * unit), (step, -6.0 * unit), (step, 6.0 * unit), (0.0, 6.0 * unit))
        )
        parts.append(
            DrawnLine(np.array((x + index * step, y)) + corners, Paint(fill=tint), closed=True)
        )
    return parts


def _end_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return robot_at(x + 0.5 * ICON * unit, y, 6.0 * unit, unit)


def _pierced_sample(x: float, y: float, unit: float) -> list[Primitive]:
    stripe = Paint(stroke=PIERCED, width=1.4 * unit)
    stripes = [np.array(((left, 6.0), (left + 6.0, -6.0))) for left in (5.0, 10.0, 15.0)]
    return [
        _square(x, y, unit, Paint(fill=PIERCED_GROUND)),
        *(DrawnLine(np.array((x, y)) + line * unit, stripe) for line in stripes),
        _square(x, y, unit, Paint(stroke=PIERCED, width=2.0 * unit)),
    ]


def _blocked_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return arrow((x, y), (x + (ICON - 8.0) * unit, y), unit, INK, INK)


def _push_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return push_arrow((x, y), (x + (ICON - 4.0) * unit, y), unit)


def _decoy_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return decoy_mark(x + 0.5 * ICON * unit, y, 0.8 * unit)


def _memory_sample(x: float, y: float, unit: float) -> list[Primitive]:
    line = Paint(stroke=MEMORY, width=1.4 * unit)
    ends = np.array(((x + 4.0 * unit, y), (x + 22.0 * unit, y)))
    return [
        _square(x, y, unit, Paint(fill=mix(PAPER, MEMORY, 0.25))),
        DrawnLine(ends, line),
        *(DrawnCircle(end, y, 2.6 * unit, Paint(fill=MEMORY)) for end in ends[:, 0]),
    ]


def _overlap_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return [
        DrawnCircle(x + 0.5 * ICON * unit, y, 6.0 * unit, Paint(stroke=TUNNEL, width=3.0 * unit))
    ]


def _tunnel_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return cross(x + 0.5 * ICON * unit, y, 5.0 * unit, TUNNEL, 3.5 * unit)
