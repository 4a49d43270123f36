"""glTF 2.0: export worlds as one binary file, and read meshes in both forms, cut at a height.

A world is one cube mesh and one node per wall that puts the cube into place.

Source: The Khronos Group, "glTF 2.0 Specification", 2021.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, SupportsFloat, TypeAlias

from worldgen.interop.format import PLAIN_FACTS, Destination, Exported, Format, held_values
from worldgen.interop.format.foreign_map import FLOOR_ROBOT
from worldgen.interop.geometry.placed_boxes import BOX_CORNERS, BOX_TRIANGLES, solid_boxes
from worldgen.interop.readers.mesh_slice import metric_reader
from worldgen.render.marks import hue, rgb
from worldgen.world import Value, World

Shape: TypeAlias = tuple[Sequence[Sequence[float]], Sequence[Sequence[int]]]
"""Corners, and triangles as numbers of corners."""

# The cube from (0, 0, 0) to (1, 1, 1).
_CUBE: Shape = (BOX_CORNERS, BOX_TRIANGLES)
# Sides of the discs of robot and target.
_SIDES = 48
_COLOURS = {
    "wall": hue("wall"),
    "floor": hue("floor"),
    "robot": hue("start"),
    "target": hue("target"),
}


def write_glb(
    world: World,
    destination: Destination,
    *,
    height: float = 1.0,
    floor: bool = False,
    markers: bool = False,
) -> Exported:
    """Return a scene in metres, y up: (x, y, z) of the world is (x, z, -y) here.

    Only leaf nodes turn or scale, because some readers combine nested transforms in the wrong
    order.

    Args:
        world: A static world.
        destination: Where the file is written.
        height: Height of the walls, m.
        floor: Whether to add a floor, a box one cell thick below z = 0.
        markers: Whether to show the robot at its start and the target's disc.

    Raises:
        InvalidParameter: If the height isn't a valid length.
        InvalidWorld: If the coordinates need more than 32 bits.
    """
    # Round as readers do.
    boxes = solid_boxes(world, destination, height=height, floor=floor, bits=24)
    kinds = ["wall", *(["floor"] if floor else []), *(["robot", "target"] if markers else [])]
    nodes: list[dict[str, Any]] = [
        {
            "name": box.name,
            "mesh": kinds.index("floor" if box.name == "floor" else "wall"),
            "translation": _y_up(box.low[0], box.high[1], box.low[2]),
            "scale": [float(length) for length in (box.size[0], box.size[2], box.size[1])],
        }
        for box in boxes
    ]
    places = _places(world, destination, first=1 + len(nodes), kinds=kinds)
    root = {
        "name": "worldgen",
        "children": list(range(1, 1 + len(nodes) + 2)),
        "extras": _extras(world, destination),
    }
    return Exported({destination.name: _packed([root, *nodes, *places], kinds)})


glb = Format(
    "glb",
    "walls as a scene; meshes, cut at a height, binary glTF, .glb",
    (".glb",),
    read=metric_reader("glb"),
    write=write_glb,
    holds=PLAIN_FACTS,
    client="browsers, Blender, game engines",
    usual_robot=FLOOR_ROBOT,
)

# The text form is only read, because the binary form is one file.
gltf = Format(
    "gltf",
    "mesh or scene, cut at a height, glTF, .gltf",
    (".gltf",),
    read=metric_reader("gltf"),
    client="browsers, Blender, game engines",
    usual_robot=FLOOR_ROBOT,
)


def _extras(world: World, destination: Destination) -> dict[str, Value]:
    """Return the size in cells and the world's other facts, as plain numbers.

    Lists in here make Assimp 5.2 abort with an assertion.
    """
    plain: dict[str, Value] = {}
    for name, value in held_values(world, destination).items():
        plain |= (
            {f"{name}_{axis}": part for axis, part in zip("xy", value, strict=True)}
            if isinstance(value, list)
            else {name: value}
        )
    return plain


def _places(
    world: World, destination: Destination, *, first: int, kinds: list[str]
) -> list[dict[str, Any]]:
    """Yield the nodes of start and target, and of their discs if wanted.

    The first node has the number ``first``.
    """
    start = world.start
    target = world.target
    sine, cosine = _sine_cosine(math.fmod(start.heading, 2.0 * math.pi) / 2.0)
    nodes: list[dict[str, Any]] = [
        {
            "name": "start",
            "translation": _y_up(float(destination.x(start.x)), float(destination.y(start.y)), 0),
            "rotation": [0, sine, 0, cosine],
            "extras": {"heading": start.heading},
        },
        {
            "name": "target",
            "translation": _y_up(float(destination.x(target.x)), float(destination.y(target.y)), 0),
            "extras": {"radius": target.radius},
        },
    ]
    # The robot's disc is tall, the target's is flat.
    robot = world.robot_radius
    flat = target.radius / 16.0
    for kind, radius, tall in (("robot", robot, robot), ("target", target.radius, flat)):
        if kind in kinds:
            node = nodes[("robot", "target").index(kind)]
            node["children"] = [first + len(nodes)]
            nodes.append(
                {
                    "name": f"{node['name']}_disc",
                    "mesh": kinds.index(kind),
                    "scale": [radius, tall, radius],
                }
            )
    return nodes


def _y_up(x: SupportsFloat, y: SupportsFloat, z: SupportsFloat) -> list[float]:
    return [float(x), float(z), 0.0 - float(y)]


def _packed(nodes: list[dict[str, Any]], kinds: list[str]) -> bytes:
    """Return the nodes and the meshes that they place, one for each kind, as a binary file.

    trimesh packs the meshes. The nodes are ours, because trimesh writes a place as a matrix.
    """
    import trimesh

    # Walls and floor share the cube, robot and target the disc.
    shapes = {"wall": _CUBE, "floor": _CUBE, "robot": _disc(), "target": _disc()}
    scene = trimesh.Scene()
    for kind in kinds:
        # Without normals faces are flat and shells closed.
        corners, faces = shapes[kind]
        visual = trimesh.visual.TextureVisuals(material=_material(kind))
        scene.geometry[kind] = trimesh.Trimesh(
            corners, faces, visual=visual, process=False, validate=False
        )

    def place(tree: dict[str, Any]) -> None:
        tree["asset"]["generator"] = "worldgen"
        tree["scenes"] = [{"name": "world", "nodes": [0]}]
        tree["nodes"] = nodes

    data = trimesh.exchange.gltf.export_glb(scene, include_normals=False, tree_postprocessor=place)
    return bytes(data)


def _material(kind: str) -> Any:
    """Return the colour of a kind; glTF's colours are linear, to a good approximation squares."""
    from trimesh.visual.material import PBRMaterial

    shares = [channel / 255.0 for channel in rgb(_COLOURS[kind])]
    return PBRMaterial(
        name=kind,
        baseColorFactor=[*(round(255.0 * share * share) for share in shares), 255],
        metallicFactor=0.0,
        roughnessFactor=0.9,
    )


def _disc() -> Shape:
    """Return a prism with many sides around the y axis, radius 1, from y = 0 to 1."""
    # Corners of the lower end, then of the upper end.
    turns = [_sine_cosine(2.0 * math.pi * k / _SIDES) for k in range(_SIDES)]
    corners = [(cosine, float(y), -sine) for y in (0, 1) for sine, cosine in turns]

    # Two triangles for each side, and a fan for each end.
    faces: list[tuple[int, int, int]] = []
    for k in range(_SIDES):
        after = (k + 1) % _SIDES
        faces += [(k, after, _SIDES + after), (k, _SIDES + after, _SIDES + k)]
    for k in range(1, _SIDES - 1):
        faces += [(0, k + 1, k), (_SIDES, _SIDES + k, _SIDES + k + 1)]
    return corners, faces


def _sine_cosine(angle: float) -> tuple[float, float]:
    """Return the sine and the cosine, correctly rounded, the same on every machine.

    The last bit of a math library's result depends on the library.

    Args:
        angle: Angle, rad, at most a full turn.
    """
    sums = [Fraction(0)] * 4
    term = Fraction(1)
    # The remainder 7^60 / 60! is below 1e-31.
    for power in range(60):
        sums[power % 4] += term
        term *= Fraction(angle) / (power + 1)
    return float(sums[1] - sums[3]), float(sums[0] - sums[2])
