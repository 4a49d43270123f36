"""The strip under the map: title, scale, and a key to the picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from worldgen.render.body_parts import spare_words
from worldgen.render.content import Content
from worldgen.render.disturbance_parts import decoy_mark, push_arrow
from worldgen.render.lettering import TEXT_SIZE, length_words, scale_bar, text_width
from worldgen.render.marks import MARKS, SPECIFICATION, Mark, hue, mix, robot_colours
from worldgen.render.named_parts import named_mark
from worldgen.render.overlay import Trail
from worldgen.render.primitives import DrawnCircle, DrawnLine, Paint, Primitive, Text
from worldgen.render.robot_parts import dot, start_disc, target_mark, waypoint_mark
from worldgen.render.shortfall_parts import barred_arrow
from worldgen.render.trail_parts import arrow, arrow_head, breach_cross, heading_tick, stays_put
from worldgen.robot_overrides import describe_body, describe_goal
from worldgen.world import Cut, JointWitness, Witness, World

# Sizes in units.
TITLE_SIZE = 16.0
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
    robot = world.robots[0]
    body = f"robot radius {robot.radius:.6g} m"
    if not robot.is_disc or robot.drive.is_car:
        body = describe_body(robot)
    parts = [f"{width:.6g} x {height:.6g} m, cell {world.cell_size:.6g} m, {body}"]
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
        (printable(content.title), TITLE_SIZE * unit, hue("ink")),
        (facts(content.world), TEXT_SIZE * unit, hue("quiet")),
    ):
        for line in wrapped(text, room, size, MOST_LINES):
            y += LEADING * size
            parts.append(Text(left, y - 0.35 * size, size, line, colour))
    bar = scale_bar(BAR * frame.width / frame.scale)
    length = bar * frame.scale
    keys = [
        (length_words(bar), _scale_sample(length), length),
        *((words, sample, ICON * unit) for words, sample in _keys(content)),
    ]
    placed, y = _place(keys, left, room, y + 4.0 * unit, unit)
    return parts + placed, round(y + 10.0 * unit)


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
        return [DrawnLine(points, MARKS["scale"].line(unit))]

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
        parts.append(Text(begin, y - 0.5 * row + 0.35 * size, size, words, hue("ink")))
        x += width + GAP * unit
    return parts, y


def key_of_cards(
    contents: Sequence[Content], left: float, room: float, unit: float
) -> tuple[list[Primitive], float]:
    """Return the key to many small pictures, and its height, px.

    Args:
        contents: The pictures' contents.
        left: px.
        room: Its width, px.
        unit: Pixels of a unit.
    """
    shown = set().union(*(_shown(content) for content in contents))
    keys = [
        (MARKS[name].label, _sample(name, contents[0]), ICON * unit)
        for name in SPECIFICATION.legend
        if name in shown and MARKS[name].on_cards
    ]
    return _place(keys, left, room, 0.0, unit)


def _keys(content: Content) -> list[tuple[str, Sample]]:
    """Return the words and the samples of the marks in a picture, in the order of ``marks.json``."""
    shown = _shown(content)
    fleet = _robot_keys(content) if content.has_several else []
    marks = [
        (MARKS[name].label, _sample(name, content))
        for name in SPECIFICATION.legend
        if name in shown
    ]
    keys = [*fleet, *marks]
    proof = content.world.certificate
    if "witness" in shown and isinstance(proof, Witness):
        spare = spare_words(content.world, proof)
        if spare is not None:
            keys.append((spare, _ghost_sample))
    return keys


def _shown(content: Content) -> set[str]:
    """Return the names of the marks in a picture that its legend explains."""
    proof = content.world.certificate
    view = content.view
    names = {
        "began" if content.trails else "start",
        "target",
        *(["waypoint"] if content.world.robots[0].waypoints else ()),
        *(["signal"] if view.signal else ()),
        *(["named"] if content.named else ()),
    }
    if view.witness and isinstance(proof, Witness | JointWitness):
        names.add("witness")
    if view.witness and isinstance(proof, Cut):
        names.add("cut" if proof.boxes is None else "cut-poses")
    for name in ("burns", "closes", "opens"):
        if getattr(content.changes, name).any():
            names.add(name)
    for number, trail in enumerate(content.trails):
        names |= _of_trail(trail, is_one=not content.has_several)
        if stays_put(trail, content.frame, content.robot(number)):
            names.add("spot")
    if "spot" in names and not content.has_several:
        names -= {"loop", "stay"}
    if content.shortfall is not None:
        between = "short" if content.shortfall.contact is None else "barred"
        names = names - {"end"} | {"nearest", between}
    return names


def _of_trail(trail: Trail, *, is_one: bool) -> set[str]:
    kinds = {mark.kind for mark in trail.marks}
    disturbances = trail.disturbances
    memory = trail.memory
    present = {
        "trail": trail.repeats_from is None,
        "approach": bool(trail.repeats_from),
        "loop": trail.loop_from is not None,
        "stay": trail.stays_from is not None,
        "end": is_one,
        "touched": "bump" in kinds,
        "pierced": any(cell.is_entered for cell in trail.pierced),
        "caught": not all(cell.is_entered for cell in trail.pierced),
        "overlap": "overlap" in kinds and not trail.pierced,
        "breach": "tunnel" in kinds and not trail.pierced,
        "blocked": bool(trail.blocked_by),
        "pushed": bool(disturbances.pushes),
        "pushes": bool(disturbances.places),
        "missed": trail.missed is not None and bool(trail.missed.any()),
        "remembered": memory is not None and not memory.is_empty,
        "drift": disturbances.drift_heading is not None,
        "decoy": bool(disturbances.decoys),
    }
    return {name for name, is_there in present.items() if is_there}


def _robot_keys(content: Content) -> list[tuple[str, Sample]]:
    """Return the names and colours of several robots, as long as the colours differ."""
    names = [trail.name for trail in content.trails] or [""] * len(content.world.robots)
    return [
        (f"{number + 1}: {name}" if name else f"robot {number + 1}", _line(MARKS["trail"], colour))
        for number, (name, colour) in enumerate(zip(names, robot_colours(), strict=False))
    ]


def _sample(name: str, content: Content) -> Sample:
    """Return the sample of a mark; of one of several robots in a colour of none."""
    mark = MARKS[name]
    grey = hue("quiet") if content.has_several else ""
    robot = content.robot(0)
    if name in ("start", "end", "nearest") and not robot.is_disc:
        return _body_sample(mark)
    if name in _SAMPLES:
        return _SAMPLES[name]
    if mark.width and not mark.fill:
        return _line(mark, grey, arrow=name in ("loop", "stay", "trail"))
    return _striped(mark) if mark.size else _swatch(mark)


def _line(mark: Mark, colour: str = "", *, arrow: bool = False) -> Sample:
    def sample(x: float, y: float, unit: float) -> list[Primitive]:
        ends = np.array(((x, y), (x + ICON * unit, y)))
        middle = x + 0.5 * ICON * unit
        drawn = colour or hue(mark.colour)
        faded = mix(hue("floor"), drawn, mark.fade[-1] if mark.fade else 1.0)
        parts: list[Primitive] = [DrawnLine(ends, mark.line(unit, faded))]
        if arrow:
            size = 1.25 * mark.size * unit
            parts.append(arrow_head(middle, y, 0.0, size, drawn, casing=unit))
        return parts

    return sample


def _swatch(mark: Mark) -> Sample:
    def sample(x: float, y: float, unit: float) -> list[Primitive]:
        tint = mix(hue("floor"), hue(mark.colour), max(mark.fill, 0.5))
        return [_square(x, y, unit, Paint(fill=tint))]

    return sample


def _striped(mark: Mark) -> Sample:
    """Return the sample of cells with stripes."""

    def sample(x: float, y: float, unit: float) -> list[Primitive]:
        stripes = [np.array(((left, 6.0), (left + 6.0, -6.0))) for left in (4.0, 10.0, 16.0)]
        return [
            _square(x, y, unit, mark.inside()),
            *(DrawnLine(np.array((x, y)) + line * unit, mark.line(unit)) for line in stripes),
        ]

    return sample


def _square(x: float, y: float, unit: float, paint: Paint) -> DrawnLine:
    corners = np.array(((4.0, -6.0), (22.0, -6.0), (22.0, 6.0), (4.0, 6.0))) * unit
    return DrawnLine(np.array((x, y)) + corners, paint, closed=True)


def _start_sample(x: float, y: float, unit: float) -> list[Primitive]:
    x += 0.5 * ICON * unit
    tick = MARKS["heading"].line(unit)
    return [
        *start_disc(x, y, 7.0 * unit, unit, hue("start")),
        heading_tick(x, y, 7.0 * unit, 0.0, tick),
    ]


def _target_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return target_mark(x + 0.5 * ICON * unit, y, 5.0 * unit, unit, hue("target"))


def _waypoint_sample(x: float, y: float, unit: float) -> list[Primitive]:
    colour = hue("target")
    middle = x + 0.5 * ICON * unit
    number = Text(middle - 2.3 * unit, y + 2.9 * unit, 8.0 * unit, "1", colour)
    return [*waypoint_mark(middle, y, 6.0 * unit, unit, colour), number]


def _named_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return named_mark(x + 0.5 * ICON * unit, y, 6.0 * unit, unit)


def _body_sample(mark: Mark) -> Sample:
    """Return the sample of a body with its front."""

    def sample(x: float, y: float, unit: float) -> list[Primitive]:
        wedge = np.array(((20.0, 0.0), (13.0, -4.0), (13.0, 4.0))) * unit
        return [
            _square(x, y, unit, mark.inside()),
            _square(x, y, unit, mark.line(unit)),
            DrawnLine(np.array((x, y)) + wedge, Paint(fill=hue(mark.colour)), closed=True),
        ]

    return sample


def _ghost_sample(x: float, y: float, unit: float) -> list[Primitive]:
    mark = MARKS["tightest"]
    return [_square(x, y, unit, mark.inside()), _square(x, y, unit, mark.line(unit))]


def _signal_sample(x: float, y: float, unit: float) -> list[Primitive]:
    steps = 8
    step = ICON * unit / steps
    parts: list[Primitive] = []
    for index in range(steps):
        tint = mix(MARKS["signal"].full_tint, hue("floor"), index / (steps - 1))
        corners = np.array(
            ((0.0, -6.0 * unit), (step, -6.0 * unit), (step, 6.0 * unit), (0.0, 6.0 * unit))
        )
        parts.append(
            DrawnLine(np.array((x + index * step, y)) + corners, Paint(fill=tint), closed=True)
        )
    return parts


def _end_sample(x: float, y: float, unit: float) -> list[Primitive]:
    mark = MARKS["end"]
    x += 0.5 * ICON * unit
    return [
        DrawnCircle(x, y, 6.0 * unit, mark.inside()),
        DrawnCircle(x, y, 6.0 * unit, mark.line(unit)),
        DrawnCircle(x, y, 1.5 * unit, Paint(fill=hue(mark.colour))),
        heading_tick(x, y, 6.0 * unit, 0.0, mark.line(unit)),
    ]


def _began_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return dot(x + 0.5 * ICON * unit, y, unit, hue("start"))


def _barred_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return barred_arrow((x, y), (x + (ICON - 4.0) * unit, y), (0.0, 1.0), 0.7 * unit)


def _short_sample(x: float, y: float, unit: float) -> list[Primitive]:
    mark = MARKS["short"]
    lines = (((2.0, 0.0), (24.0, 0.0)), ((2.0, -5.0), (2.0, 5.0)), ((24.0, -5.0), (24.0, 5.0)))
    return [DrawnLine(np.array((x, y)) + np.array(line) * unit, mark.line(unit)) for line in lines]


def _spot_sample(x: float, y: float, unit: float) -> list[Primitive]:
    mark = MARKS["spot"]
    x += 0.5 * ICON * unit
    return [
        DrawnCircle(x, y, 5.5 * unit, mark.inside()),
        DrawnCircle(x, y, 5.5 * unit, mark.line(0.7 * unit)),
        DrawnCircle(x, y, 2.0 * unit, Paint(fill=hue(mark.colour))),
    ]


def _touched_sample(x: float, y: float, unit: float) -> list[Primitive]:
    mark = MARKS["touched"]
    ends = np.array(((x + 6.0 * unit, y - 4.0 * unit), (x + 20.0 * unit, y - 4.0 * unit)))
    return [_square(x, y, unit, Paint(fill=hue("wall"))), DrawnLine(ends, mark.line(unit))]


def _pierced_sample(x: float, y: float, unit: float) -> list[Primitive]:
    mark = MARKS["pierced"]
    stripes = [np.array(((left, 6.0), (left + 6.0, -6.0))) for left in (5.0, 10.0, 15.0)]
    return [
        *_caught_sample(x, y, unit),
        *(DrawnLine(np.array((x, y)) + line * unit, mark.line(0.7 * unit)) for line in stripes),
    ]


def _caught_sample(x: float, y: float, unit: float) -> list[Primitive]:
    mark = MARKS["caught"]
    return [_square(x, y, unit, mark.inside()), _square(x, y, unit, mark.line(unit))]


def _overlap_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return [DrawnCircle(x + 0.5 * ICON * unit, y, 6.0 * unit, MARKS["overlap"].line(unit))]


def _breach_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return breach_cross(x + 0.5 * ICON * unit, y, 0.7 * unit)


def _blocked_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return arrow((x, y), (x + (ICON - 8.0) * unit, y), unit, "blocked")


def _push_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return push_arrow((x, y), (x + (ICON - 4.0) * unit, y), unit)


def _decoy_sample(x: float, y: float, unit: float) -> list[Primitive]:
    return decoy_mark(x + 0.5 * ICON * unit, y, 0.8 * unit)


def _memory_sample(x: float, y: float, unit: float) -> list[Primitive]:
    mark = MARKS["memory"]
    ends = np.array(((x + 4.0 * unit, y), (x + 22.0 * unit, y)))
    return [
        _square(x, y, unit, MARKS["remembered"].inside()),
        DrawnLine(ends, mark.line(unit)),
        *(DrawnCircle(end, y, 2.6 * unit, Paint(fill=hue(mark.colour))) for end in ends[:, 0]),
    ]


_SAMPLES: Mapping[str, Sample] = {
    "start": _start_sample,
    "target": _target_sample,
    "waypoint": _waypoint_sample,
    "signal": _signal_sample,
    "end": _end_sample,
    "nearest": _end_sample,
    "began": _began_sample,
    "barred": _barred_sample,
    "short": _short_sample,
    "touched": _touched_sample,
    "pierced": _pierced_sample,
    "caught": _caught_sample,
    "overlap": _overlap_sample,
    "breach": _breach_sample,
    "blocked": _blocked_sample,
    "pushed": _push_sample,
    "decoy": _decoy_sample,
    "remembered": _memory_sample,
    "spot": _spot_sample,
    "named": _named_sample,
}
"""Samples of the marks that are neither a line nor an area."""
