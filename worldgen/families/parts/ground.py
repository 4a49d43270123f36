"""Build the ground of a changing world: a static world of another family."""

from __future__ import annotations

from itertools import product

from worldgen.errors import InvalidParameter
from worldgen.families.parts.layout import Arena
from worldgen.family import FAMILIES, Family
from worldgen.parameters import parse_options, split_options
from worldgen.random_streams import RandomStream
from worldgen.world import Value, World

# Share of dead ends to open in a maze; without loops, a change could only delay the robot.
MAZE_BRAID = 0.3

# Choices to draw from, for parameters that gained choices later. Drawing from the new ones too
# would change every seed's world.
DRAWN: dict[str, dict[str, tuple[str, ...]]] = {
    "maze": {"algorithm": ("wilson", "backtracker"), "mask": ("square",)},
    "corridor": {"shape": ("bends", "dead-ends", "junctions")},
    "trap": {"shape": ("U", "L", "spiral")},
}


def lay_ground(rng: RandomStream, over: str, arena: Arena) -> World:
    """Build a world of the family that ``over`` names, with choices drawn from those that fit.

    Args:
        rng: The only source of randomness.
        over: Name of a family of static worlds, followed by any number of ``+parameter=value``.
        arena: Size, cells and robot, which both families share. A family that lacks one of these
            parameters ignores it.

    Raises:
        InvalidParameter: If the family is unknown or not static, a parameter is wrong, or no
            combination of choices fits.
    """
    # Combine the shared parameters with the given ones.
    below, given = _parse(over)
    shared: dict[str, Value] = {
        "size": arena.size,
        "cell_size": arena.cell_size,
        "robot_radius": arena.robot_radius,
        "robot_speed": arena.robot_speed,
    }
    for name in given:
        if name in shared:
            raise InvalidParameter(
                "not-of-the-ground",
                "over={over}: {name} belongs to the whole world",
                "give it as a separate parameter",
                over=over,
                name=name,
            )
    if below.name == "maze":
        given.setdefault("braid", MAZE_BRAID)
    params = {name: value for name, value in shared.items() if name in below.defaults()} | given
    if below.places_robots:  # the family that changes this world places them
        params["robots"] = 1

    # Try all combinations of the choices that are not given, in random order. Some of them may need
    # more room than there is.
    drawn = DRAWN.get(below.name, {})
    words_of = {
        known.name: drawn.get(known.name, known.choices)
        for known in below.parameters
        if known.choices and known.name not in given
    }
    names = list(words_of)
    shapes = list(product(*words_of.values()))
    rng.shuffle(shapes)
    refusals: list[InvalidParameter] = []
    for words in shapes:
        complete = below.complete({**params, **dict(zip(names, words, strict=True))})
        try:
            ground = below.build(rng.child("layout"), **complete)
        except InvalidParameter as refusal:
            refusals.append(refusal)
            continue
        return _still(ground, over)
    raise InvalidParameter(
        "no-room",
        "size={size} with robot_radius={robot_radius:g} m has no room for over={over}",
        "use a larger size or a smaller robot_radius (for one of its shapes: {refusal})",
        size=arena.size,
        robot_radius=arena.robot_radius,
        over=over,
        refusal=refusals[0],
    )


def _parse(over: str) -> tuple[Family, dict[str, Value]]:
    """Return the family and the parameters that ``over`` gives."""
    name, words = split_options(over, "maze+algorithm=eller")
    below = FAMILIES.get(name)
    if below.changes:
        raise InvalidParameter(
            "world-changes",
            "over={over}: the worlds of {family} already change",
            "use one of {known!l}",
            over=over,
            family=below.name,
            known=[name for name in FAMILIES if not FAMILIES.get(name).changes],
        )
    return below, parse_options(words, below.parameters, f"over={over}: {below.name}")


def _still(ground: World, over: str) -> World:
    """Return the ground, after checking that it does not change."""
    if ground.is_dynamic:
        raise InvalidParameter(
            "world-changes",
            "over={over}: its worlds already change",
            "use a family whose worlds do not change, and declare this one with changes=True",
            over=over,
        )
    return ground
