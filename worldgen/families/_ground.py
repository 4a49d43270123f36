"""The ground of a world that changes: a world of another family, its shape drawn."""

from __future__ import annotations

from itertools import product

from worldgen.errors import InvalidParameter
from worldgen.families._layout import Arena
from worldgen.family import FAMILIES
from worldgen.random_streams import RandomStream
from worldgen.world import Value, World

__all__ = ["lay_ground"]

MAZE_BRAID = 0.3  # in a maze without loops, a change could only delay

# Words that are drawn, where not all are: those that came later would move every seed to another world.
DRAWN: dict[str, dict[str, tuple[str, ...]]] = {
    "maze": {"algorithm": ("wilson", "backtracker"), "mask": ("square",)},
    "corridor": {"shape": ("bends", "dead-ends", "junctions")},
    "trap": {"shape": ("U", "L", "spiral")},
}


def lay_ground(rng: RandomStream, over: str, arena: Arena) -> World:
    """A world of the family ``over``, its words drawn from those that fit.

    Raises:
        InvalidParameter: If none fits.
    """
    below = FAMILIES.get(over)
    params: dict[str, Value] = {
        "size": arena.size,
        "cell_size": arena.cell_size,
        "robot_radius": arena.robot_radius,
        "robot_speed": arena.robot_speed,
    }
    if over == "maze":
        params["braid"] = MAZE_BRAID
    drawn = DRAWN.get(over, {})
    words_of = {known.name: drawn.get(known.name, known.choices) for known in below.parameters if known.choices}
    names, shapes = list(words_of), list(product(*words_of.values()))
    rng.shuffle(shapes)
    refusals: list[InvalidParameter] = []
    for words in shapes:
        try:
            complete = below.complete({**params, **dict(zip(names, words, strict=True))})
            return below.build(rng.child("layout"), **complete)
        except InvalidParameter as refusal:
            refusals.append(refusal)
    raise InvalidParameter(
        f"size={arena.size} with robot_radius={arena.robot_radius:g} m has no room for over={over}; "
        f"give a larger size or a smaller robot_radius (for one of its shapes: {refusals[0]})"
    )
