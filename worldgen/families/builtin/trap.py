"""Traps: an open arena with one concave obstacle between start and target."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from worldgen.errors import InvalidParameter
from worldgen.families.parts.layout import (
    CHOSEN,
    Arena,
    CellSize,
    RobotRadius,
    RobotSpeed,
    Size,
    Wall,
    Width,
    without_effect,
)
from worldgen.families.parts.raster import box
from worldgen.families.parts.turned_trap import (
    TrapShape,
    chevron,
    comb,
    draw_up_to,
    nested,
    pair,
    place_turned,
    room_for,
)
from worldgen.family import Bounds, check_at_least, check_between, family
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools
from worldgen.world import World

Shape: TypeAlias = Literal["U", "L", "spiral", "V", "comb", "nested", "pair"]
Faces: TypeAlias = Literal["start", "target", "side"]
Box: TypeAlias = tuple[int, int, int, int]
Ranges: TypeAlias = tuple[tuple[int, int], tuple[int, int]]

# Limit on the quarter turns drawn for a spiral; a user may request more.
MOST_TURNS = 8
# Shapes that always have a passage on all sides.
_LATER: tuple[Shape, ...] = ("V", "comb", "nested", "pair")
# Shapes with a number of parts, and the range from which it is drawn.
_COUNTED: dict[Shape, tuple[int, int]] = {"comb": (2, 6), "nested": (2, 4)}
# Number of cells by which rasterising and thickening can narrow the space between slanted walls.
SLANTED_SPARE = 2


@family("trap", version=1)
def trap(
    rng: RandomStream,
    *,
    size: Size = 30,
    shape: Shape = "U",
    depth: Width = CHOSEN,
    mouth: Width = CHOSEN,
    thickness: Wall = 1,
    turn: Annotated[int, Bounds(0, 3, "quarter turns", chosen=CHOSEN)] = CHOSEN,
    turns: Annotated[int, Bounds(1, unit="quarter turns", chosen=CHOSEN)] = CHOSEN,
    parts: Annotated[int, Bounds(1, chosen=CHOSEN)] = CHOSEN,
    angle: Annotated[int, Bounds(0, 89, "degrees", chosen=CHOSEN)] = 0,
    faces: Faces = "start",
    inside: bool = False,
    cell_size: CellSize = 0.1,
    robot_radius: RobotRadius = 0.07,
    robot_speed: RobotSpeed = 2.0,
) -> World:
    """Build an open arena with a concave obstacle on the straight line from start to target.

    A robot that heads straight for the target runs into the hollow and must first move away from
    the target to get around. There is a path around on both sides if the square has room for it,
    otherwise on one.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border.
        shape: U: a back wall and two arms; L: a back wall and one arm; spiral: a U with one arm
            that keeps winding around it; V: two slanted arms; comb: a back wall with teeth; nested:
            U's in each other's hollows; pair: a U, and another behind it, offset to the side.
        depth: Inner length of the arms, cells; for a spiral, the length of its innermost chamber;
            for nested U's, the innermost one's; if omitted, drawn.
        mouth: Clear width of the opening, between the arms or along the back wall, cells; for a
            spiral, of its whole winding corridor; also the gap between teeth, and between one U and
            the next; if omitted, drawn.
        thickness: Thickness of the obstacle's walls, cells.
        turn: Where the mouth opens: quarter turns counter-clockwise from +x; if omitted, drawn.
        turns: Quarter turns by which a spiral continues beyond the U; if omitted, drawn.
        parts: Teeth of a comb, or U's that are nested; if omitted, drawn.
        angle: Degrees counter-clockwise by which the obstacle is turned in addition to ``turn``;
            None (-1 on the command line): drawn.
        faces: What the mouth faces: the start, the target, or neither.
        inside: Start in the hollow instead of in front of it.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or the square has no room for the obstacle
            and the paths around it.

    Source: local minima of potential fields; Koren and Borenstein, "Potential field methods and
        their
    inherent limitations for mobile robot navigation", ICRA 1991.
    """
    arena = Arena(size, cell_size, robot_radius, robot_speed)
    request = _checked(
        arena, _Request(shape, depth, mouth, thickness, turns, parts), faces, inside=inside
    )
    angle = rng.child("angle").below(90) if angle == CHOSEN else angle
    if angle or shape in _LATER:
        draw = rng.child("slanted")
        degrees = 90 * (draw.below(4) if turn == CHOSEN else turn) + angle
        return _slanted(draw, arena, request, degrees, faces, inside=inside)

    obstacle = _obstacle(*_draw_to_fit(rng.child("obstacle"), arena, request, faces))
    corner = _place(rng.child("place"), arena, obstacle)
    scene = _scene(rng.child("poses"), arena, obstacle, corner, faces, inside=inside)
    if rng.below(2):
        scene = scene.mirrored()
    scene = scene.turned(rng.below(4) if turn == CHOSEN else turn)

    return arena.world(scene.walls, scene.start, scene.target, scene.quarter)


@dataclass(frozen=True)
class _Request:
    """The requested obstacle; ``CHOSEN`` marks numbers that still have to be drawn."""

    shape: Shape
    depth: int
    mouth: int
    thickness: int
    turns: int
    parts: int


def _checked(arena: Arena, asked: _Request, faces: Faces, *, inside: bool) -> _Request:
    """Check a request, and set numbers that have no effect to 0.

    Raises:
        InvalidParameter: If a number is out of range, or was given although it has no effect.
    """
    # Find the smallest depth that keeps the obstacle in the robot's path.
    if inside and faces == "target":
        raise InvalidParameter(
            "no-effect",
            "inside cannot be combined with faces=target: nothing would be in the way",
            "use faces=start or faces=side",
        )
    least_depth = arena.narrowest if inside else 1
    # From the side, the robot would pass an arm that is shorter than itself.
    if faces == "side":
        least_depth = max(least_depth, arena.narrowest - asked.thickness)
    mouth = asked.mouth
    turns = asked.turns
    parts = asked.parts

    # Check each number that was given.
    if asked.depth != CHOSEN:
        check_at_least("depth", asked.depth, least_depth, "cells")
    if mouth != CHOSEN:
        mouth = arena.passage("mouth", mouth)
    if asked.shape != "spiral":
        turns = without_effect("turns", turns, f"shape={asked.shape}")
    elif turns != CHOSEN:
        check_between("turns", turns, 1, arena.inside, "quarter turns")
    if asked.shape not in _COUNTED:
        parts = without_effect("parts", parts, f"shape={asked.shape}")
    elif parts != CHOSEN:
        check_between("parts", parts, 1, arena.inside)
    return _Request(asked.shape, asked.depth, mouth, asked.thickness, turns, parts)


def _slanted(
    rng: RandomStream, arena: Arena, request: _Request, degrees: int, faces: Faces, *, inside: bool
) -> World:
    """Build the world of an obstacle that may be slanted, with a passage on all sides.

    Space between slanted walls is planned two cells wider than requested. Rasterising and
    thickening need up to that much, so the clear space is never less than requested.
    """
    figure = _draw_figure(rng.child("obstacle"), arena, request, degrees, inside=inside)
    scene = place_turned(rng.child("place"), arena, figure, degrees, faces, inside=inside)
    return arena.world(scene.walls, scene.start, scene.target, scene.quarter)


def _draw_figure(
    rng: RandomStream, arena: Arena, request: _Request, degrees: int, *, inside: bool
) -> TrapShape:
    """Draw the missing numbers in order, and return the obstacle.

    Each number is drawn so that the smallest values of the remaining ones still fit.

    Raises:
        InvalidParameter: If the given numbers do not fit even with the least values of the rest.
    """
    counts = _COUNTED.get(request.shape, (request.turns, request.turns))
    if request.shape == "spiral":
        counts = (1, MOST_TURNS)
    mirrored = rng.below(2) == 1
    least = arena.narrowest * (3 if inside and request.shape == "V" else 1)

    def figure(number: int, mouth: int, depth: int) -> TrapShape:
        spare = SLANTED_SPARE if degrees % 90 or request.shape == "V" else 0
        made = _figure(request.shape, depth + spare, mouth + spare, request.thickness, number)
        return made.mirrored() if mirrored else made

    def fits(number: int, mouth: int, depth: int) -> bool:
        return room_for(arena, figure(number, mouth, depth), degrees) is None

    # Check that the smallest obstacle fits.
    asked = request.turns if request.shape == "spiral" else request.parts
    mouth = least if request.mouth == CHOSEN else request.mouth
    depth = least if request.depth == CHOSEN else request.depth
    number = 1 if asked == CHOSEN else asked
    problem = room_for(arena, figure(number, mouth, depth), degrees)
    if problem is not None:
        raise InvalidParameter(
            "no-room",
            "size={size} has no room for shape={shape} with mouth={mouth}, depth={depth}, "
            "thickness={thickness}, turned by {degrees} degrees: {problem}",
            "use a larger size, or a smaller obstacle or robot_radius",
            size=arena.size,
            shape=request.shape,
            mouth=mouth,
            depth=depth,
            thickness=request.thickness,
            degrees=degrees,
            problem=problem,
        )

    # Draw the number of parts, then the mouth, then the depth.
    if asked == CHOSEN:
        first = counts[0] if fits(counts[0], mouth, depth) else 1
        number = draw_up_to(
            rng, range(first, counts[1] + 1), lambda value: fits(value, mouth, depth)
        )
    if request.mouth == CHOSEN:
        mouth = draw_up_to(
            rng, range(mouth, arena.inside), lambda value: fits(number, value, depth)
        )
    if request.depth == CHOSEN:
        # A flatter V is hardly hollow and would not trap a robot.
        if request.shape == "V" and fits(number, mouth, max(depth, mouth // 2)):
            depth = max(depth, mouth // 2)
        depth = draw_up_to(
            rng, range(depth, arena.inside), lambda value: fits(number, mouth, value)
        )
    return figure(number, mouth, depth)


def _figure(shape: Shape, depth: int, mouth: int, thickness: int, number: int) -> TrapShape:
    if shape == "V":
        return chevron(depth, mouth, thickness)
    if shape == "comb":
        return comb(depth, mouth, thickness, number)
    if shape == "nested":
        return nested(depth, mouth, thickness, number)
    if shape == "pair":
        return pair(depth, mouth, thickness)
    obstacle = _obstacle(shape, depth, mouth, thickness, number if shape == "spiral" else 0)
    pieces = tuple(box(*piece) for piece in obstacle.boxes)
    rows = obstacle.opening
    columns = (0, obstacle.width)
    hollow = box(*obstacle.hollow)
    return TrapShape(
        pieces,
        obstacle.width,
        obstacle.height,
        rows,
        rows,
        columns,
        (0, obstacle.height),
        (hollow,),
    )


@dataclass(frozen=True)
class _Obstacle:
    """Describe an obstacle of axis-parallel walls whose mouth opens to +x.

    Args:
        boxes: Solid boxes (x0, y0, x1, y1) in cells; the first corner is (0, 0).
        width: Cells in x.
        height: Cells in y.
        opening: Rows [low, high) of the mouth.
        hollow: The innermost box, which traps a robot.
    """

    boxes: tuple[Box, ...]
    width: int
    height: int
    opening: tuple[int, int]
    hollow: Box


def _extents(shape: Shape, depth: int, mouth: int, thickness: int, turns: int) -> tuple[int, int]:
    """Return the width and height, in cells, of an obstacle whose mouth opens to +x."""
    width = thickness + depth
    height = mouth + (1 if shape == "L" else 2) * thickness
    for _ in range(turns):
        width, height = height, width + mouth + thickness
    return width, height


def _obstacle(shape: Shape, depth: int, mouth: int, thickness: int, turns: int) -> _Obstacle:
    """Build a U or an L, and extend its upper arm into a spiral by some quarter turns."""
    # Begin with the back and the lower arm.
    width, height = _extents(shape, depth, mouth, thickness, 0)
    boxes = [(0, 0, thickness, height), (0, 0, width, thickness)]
    if shape != "L":
        boxes.append((0, height - thickness, width, height))
    hollow = (thickness, thickness, width, thickness + mouth)
    for wound in range(1, turns + 1):
        boxes, hollow = _wind_on(boxes, hollow, width, height, mouth, thickness)
        width, height = _extents(shape, depth, mouth, thickness, wound)
    top = height if shape == "L" else height - thickness
    return _Obstacle(tuple(boxes), width, height, (top - mouth, top), hollow)


def _wind_on(
    boxes: list[Box], hollow: Box, width: int, height: int, mouth: int, thickness: int
) -> tuple[list[Box], Box]:
    """Extend the wall that ends at the upper right by one more side of a spiral.

    The wall continues to +x, then to -y along the whole right side, ``mouth`` cells away from the
    walls there. The new mouth, at the lower right, opens to -y. A quarter turn makes that +x, and
    moves the wall's end to the upper right again.
    """
    reach = width + mouth + thickness
    longer = [
        *boxes,
        (width, height - thickness, reach, height),
        (reach - thickness, 0, reach, height),
    ]
    return [_quarter_turn(box, height) for box in longer], _quarter_turn(hollow, height)


def _quarter_turn(box: Box, height: int) -> Box:
    """Turn a box counter-clockwise: (x, y) moves to (height - y, x)."""
    return height - box[3], box[0], height - box[1], box[2]


def _draw_to_fit(
    rng: RandomStream, arena: Arena, request: _Request, faces: Faces
) -> tuple[Shape, int, int, int, int]:
    """Draw the missing numbers in order, and return all of them.

    Each number is drawn so that the smallest values of the remaining ones still fit.

    Returns:
        Shape, depth, mouth, thickness and turns.

    Raises:
        InvalidParameter: If the given numbers do not fit even with the least values of the rest.
    """
    shape = request.shape
    thickness = request.thickness
    low = arena.narrowest

    def fits(turns: int, mouth: int, depth: int) -> bool:
        return _room(arena, _extents(shape, depth, mouth, thickness, turns), faces) is None

    # Check that the smallest obstacle fits.
    least_turns = 1 if request.turns == CHOSEN else request.turns
    least_mouth = low if request.mouth == CHOSEN else request.mouth
    least_depth = low if request.depth == CHOSEN else request.depth
    problem = _room(arena, _extents(shape, least_depth, least_mouth, thickness, least_turns), faces)
    if problem is not None:
        turns_said = ", turns={turns}" if shape == "spiral" else ""
        raise InvalidParameter(
            "no-room",
            "size={size} has no room for shape={shape} with mouth={mouth}, depth={depth}, "
            "thickness={thickness}"
            f"{turns_said}: {{problem}}",
            "use a larger size, or a smaller obstacle or robot_radius",
            size=arena.size,
            shape=shape,
            mouth=least_mouth,
            depth=least_depth,
            thickness=thickness,
            turns=least_turns,
            problem=problem,
        )

    # Draw the turns, then the mouth, then the depth.
    turns = request.turns
    mouth = request.mouth
    depth = request.depth
    if turns == CHOSEN:
        turns = draw_up_to(
            rng, range(1, MOST_TURNS + 1), lambda value: fits(value, least_mouth, least_depth)
        )
    if mouth == CHOSEN:
        mouth = draw_up_to(
            rng, range(low, arena.inside), lambda value: fits(turns, value, least_depth)
        )
    if depth == CHOSEN:
        depth = draw_up_to(rng, range(low, arena.inside), lambda value: fits(turns, mouth, value))
    return shape, depth, mouth, thickness, turns


def _room(arena: Arena, extents: tuple[int, int], faces: Faces) -> str | None:
    """Return why an obstacle of these extents does not fit, or ``None`` if it does.

    Along the line from start to target, robot and target need a passage each. Across it, a single
    passage is enough to get around the obstacle.
    """
    along, across = extents
    if faces == "side":
        along, across = across, along
    if along + 2 * arena.narrowest > arena.inside:
        return (
            f"{along} cells and a passage of {arena.narrowest} on both sides are more than the "
            f"{arena.inside} cells inside"
        )
    if across + arena.narrowest > arena.inside:
        return (
            f"{across} cells and a passage of {arena.narrowest} next to them are more than the "
            f"{arena.inside} cells inside"
        )
    return None


def _place(rng: RandomStream, arena: Arena, obstacle: _Obstacle) -> tuple[int, int]:
    """Draw the obstacle's first cell, so that every gap to the border is a passage or closed."""
    spare = (arena.inside - obstacle.width, arena.inside - obstacle.height)
    corner = []
    for axis in range(2):
        slack = spare[axis] - 2 * arena.narrowest
        if slack >= 0:
            corner.append(1 + arena.narrowest + rng.between(0, slack))
        elif axis == 0:
            # Put the back against the border, never the mouth, which must stay open.
            corner.append(1)
        else:
            corner.append(1 + rng.below(2) * spare[axis])
    return corner[0], corner[1]


@dataclass(frozen=True)
class _TrapLayout:
    """Hold walls, start and target in half cells, and the heading in quarter turns."""

    walls: Bools
    start: tuple[int, int]
    target: tuple[int, int]
    quarter: int

    def turned(self, quarters: int) -> _TrapLayout:
        """Return the layout turned counter-clockwise by quarter turns."""
        side = 2 * len(self.walls)
        scene = self
        for _ in range(quarters):
            sx, sy = scene.start
            tx, ty = scene.target
            # A quarter turn moves (x, y) to (side - y, x).
            walls = scene.walls.T[:, ::-1]
            scene = _TrapLayout(walls, (side - sy, sx), (side - ty, tx), (scene.quarter + 1) % 4)
        return scene

    def mirrored(self) -> _TrapLayout:
        """Return the layout flipped in y; a mouth that opens to +x still does."""
        side = 2 * len(self.walls)
        sx, sy = self.start
        tx, ty = self.target
        return _TrapLayout(self.walls[::-1], (sx, side - sy), (tx, side - ty), -self.quarter % 4)


def _scene(
    rng: RandomStream,
    arena: Arena,
    obstacle: _Obstacle,
    corner: tuple[int, int],
    faces: Faces,
    *,
    inside: bool,
) -> _TrapLayout:
    """Put obstacle, start and target into the arena, with the mouth opening to +x."""
    # Draw the obstacle's walls.
    x, y = corner
    walls = arena.solid()
    walls[1:-1, 1:-1] = False
    for x0, y0, x1, y1 in obstacle.boxes:
        walls[y + y0 : y + y1, x + x0 : x + x1] = True

    # List the areas around the obstacle, and choose those of start and target.
    end = arena.size - 1
    front = (x + obstacle.width, end)
    behind = (1, x)
    rows = (y + obstacle.opening[0], y + obstacle.opening[1])
    columns = (x, x + obstacle.width)
    above = (y + obstacle.height, end)
    below = (1, y)
    start, target, quarter = {
        "start": ((front, rows), (behind, rows), 2),
        "target": ((behind, rows), (front, rows), 0),
        "side": ((columns, above), (columns, below), 3),
    }[faces]
    if inside:
        x0, y0, x1, y1 = obstacle.hollow
        start = ((x + x0, x + x1), (y + y0, y + y1))
    return _TrapLayout(walls, _spot(rng, arena, start), _spot(rng, arena, target), quarter)


def _spot(rng: RandomStream, arena: Arena, box: Ranges) -> tuple[int, int]:
    return arena.spot(rng, *box[0]), arena.spot(rng, *box[1])
