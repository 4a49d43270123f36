"""Export a world as a stage of Universal Scene Description, in its text form.

Every wall is a cube with collision. The text is written here, so that no library is needed and the
bytes are the same everywhere; the tests let Pixar's own library read and validate it.

Source: Pixar, "Usda File Format Specification"; "UsdPhysics: USD Physics", OpenUSD 25.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from worldgen.interop.format import (
    PLAIN_FACTS,
    Destination,
    Format,
    decimal_text,
    degrees_text,
    held_values,
)
from worldgen.interop.geometry.placed_boxes import PlacedBox, box_writer
from worldgen.lattice import exact
from worldgen.world import World

_HALF = Fraction(1, 2)
# Colours are linear.
_COLOURS = {
    "wall": (0.034, 0.042, 0.056),
    "start": (0.0, 0.342, 0.171),
    "target": (0.0, 0.168, 0.445),
}
_CUBE = ((-_HALF, -_HALF, -_HALF), (_HALF, _HALF, _HALF))


def _contents(world: World, destination: Destination, boxes: list[PlacedBox]) -> bytes:
    """Return a stage in metres, z up."""
    lines = [
        "#usda 1.0",
        "(",
        '    defaultPrim = "World"',
        f'    doc = "A world of {world.width} x {world.height} cells, by worldgen; everything '
        f'else is in the customData of /World."',
        "    kilogramsPerUnit = 1",
        "    metersPerUnit = 1",
        '    upAxis = "Z"',
        ")",
        "",
        'def Xform "World" (',
        *_custom_data(world, destination),
        ")",
        "{",
        '    def Scope "walls"',
        "    {",
    ]
    for box in boxes:
        lines += _cube(box)
    lines += [
        "    }",
        *_place("start", world, destination),
        *_place("target", world, destination),
        "}",
    ]
    return ("\n".join(lines) + "\n").encode()


usd = Format(
    "usd",
    "walls as a stage, text form, .usda",
    (".usda", ".usd"),
    write=box_writer(_contents),
    holds=PLAIN_FACTS,
    client="Isaac Sim, Omniverse, Blender",
)


def _custom_data(world: World, destination: Destination) -> Iterator[str]:
    yield "    customData = {"
    yield "        dictionary worldgen = {"
    for name, value in held_values(world, destination).items():
        if isinstance(value, list):
            kind = "int2" if name == "size" else "double2"
            yield f"            {kind} {name} = ({', '.join(map(repr, value))})"
        else:
            yield f"            double {name} = {value!r}"
    yield "        }"
    yield "    }"
    yield '    kind = "component"'


def _cube(box: PlacedBox) -> Iterator[str]:
    yield f'        def Cube "{box.name}" ('
    yield '            prepend apiSchemas = ["PhysicsCollisionAPI"]'
    yield "        )"
    yield "        {"
    yield f"            float3[] extent = [{_tuple(_CUBE[0])}, {_tuple(_CUBE[1])}]"
    yield f"            color3f[] primvars:displayColor = [{_COLOURS['wall']}]"
    yield "            double size = 1"
    yield f"            double3 xformOp:scale = {_tuple(box.size)}"
    yield f"            double3 xformOp:translate = {_tuple(box.centre)}"
    yield '            uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]'
    yield "        }"


def _place(name: str, world: World, destination: Destination) -> Iterator[str]:
    """Yield a start or a target: a frame on the floor, with a disc that does not collide."""
    # Work out the place and the size.
    start = world.start
    target = world.target
    point, radius = (start, world.robot_radius) if name == "start" else (target, target.radius)
    # The robot's disc is tall, the target's is flat.
    height = radius if name == "start" else radius / 16.0
    turn = degrees_text(start.heading) if name == "start" else "0"
    middle = exact(height) / 2
    low, high = (tuple(sign * exact(value) for value in (radius, radius)) for sign in (-1, 1))
    # Write the frame on the floor.
    yield f'    def Xform "{name}"'
    yield "    {"
    yield f"        double xformOp:rotateZ = {turn}"
    yield (
        f"        double3 xformOp:translate = ({destination.x(point.x)}, "
        f"{destination.y(point.y)}, 0)"
    )
    yield '        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateZ"]'
    yield ""
    # Write the disc in it.
    yield '        def Cylinder "disc"'
    yield "        {"
    yield '            uniform token axis = "Z"'
    yield f"            float3[] extent = [{_tuple((*low, -middle))}, {_tuple((*high, middle))}]"
    yield f"            double height = {decimal_text(exact(height))}"
    yield f"            color3f[] primvars:displayColor = [{_COLOURS[name]}]"
    yield '            uniform token purpose = "guide"'
    yield f"            double radius = {decimal_text(exact(radius))}"
    yield f"            double3 xformOp:translate = (0, 0, {decimal_text(middle)})"
    yield '            uniform token[] xformOpOrder = ["xformOp:translate"]'
    yield "        }"
    yield "    }"


def _tuple(values: Sequence[Fraction]) -> str:
    return f"({', '.join(map(decimal_text, values))})"
