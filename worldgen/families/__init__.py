"""The families of worlds that are installed.

Call one for a proved world: ``maze(seed=7, size=60)``.

Contents, each imported when it is first used:
    cave, corridor, forest, maze, rooms, rubble, trap: Worlds at rest.
    fire, shift: Worlds that change with time.
    alley, crossing, doorway, junction, warehouse: Worlds in which several robots meet.

Families of other packages have the name that they are registered under, with underscores for
dashes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from worldgen.families.builtin.alley import alley
    from worldgen.families.builtin.cave import cave
    from worldgen.families.builtin.corridor import corridor
    from worldgen.families.builtin.crossing import crossing
    from worldgen.families.builtin.doorway import doorway
    from worldgen.families.builtin.fire import fire
    from worldgen.families.builtin.forest import forest
    from worldgen.families.builtin.junction import junction
    from worldgen.families.builtin.maze import maze
    from worldgen.families.builtin.rooms import rooms
    from worldgen.families.builtin.rubble import rubble
    from worldgen.families.builtin.shift import shift
    from worldgen.families.builtin.trap import trap
    from worldgen.families.builtin.warehouse import warehouse

__all__ = [
    "alley",
    "cave",
    "corridor",
    "crossing",
    "doorway",
    "fire",
    "forest",
    "junction",
    "maze",
    "rooms",
    "rubble",
    "shift",
    "trap",
    "warehouse",
]


def _registered() -> dict[str, str]:
    """Return the registered names by what they are called here."""
    from worldgen.family import FAMILIES

    return {name.replace("-", "_"): name for name in FAMILIES.names()}


def __getattr__(name: str) -> Any:
    if not name.startswith("_"):
        from worldgen.family import FAMILIES

        registered = _registered()
        if name in registered:
            return FAMILIES.get(registered[name])
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*_registered(), *(name for name in globals() if name.startswith("__"))})
