"""Draws the pictures of docs/howto/compose.md: ``python docs/draw_compose.py``."""

from __future__ import annotations

from pathlib import Path

from worldgen.compose import Piece, of_family
from worldgen.generation import generate
from worldgen.render import Panel, Trail, draw_sheet
from worldgen.world import Witness, World

HERE = Path(__file__).parent
RECIPES = HERE.parent / "examples" / "recipes"
SEEDS = {
    "double-comb": (1,),
    "gauntlet": (1,),
    "office-wing": (1, 2),
    "trap-in-maze": (1, 4),
    "walled-garden": (1, 2),
}


def panel(world: World, title: str) -> Panel:
    """Return a world with its witness."""
    way = world.certificate
    return Panel(world, title, (Trail(way.x, way.y) if isinstance(way, Witness) else None,))


def pieces() -> bytes:
    """Return one trap, put into one maze in different ways, as a PNG file's bytes."""
    maze = of_family("maze", seed=7, size=60)
    trap = of_family("trap", seed=3, size=20, shape="U").inside()
    fire = of_family("fire", seed=2, size=24, over="trap", debris=0.05).inside()
    shown: dict[str, Piece] = {
        'place(trap, at="way", seed=5)': maze.place(trap, at="way", seed=5),
        'place(trap.rotate(1), at="centre")': maze.place(trap.rotate(1), at="centre"),
        'place(trap.turn(30), at="centre")': maze.place(trap.turn(30), at="centre"),
        'place(fire.mirror("x"), at="way", seed=5)': maze.place(fire.mirror("x"), at="way", seed=5),
    }
    return draw_sheet(
        [panel(piece.world(), title) for title, piece in shown.items()], ["witness"], columns=4
    )


def recipes() -> bytes:
    """Return the recipes of examples/recipes, as a PNG file's bytes."""
    shown = [
        panel(generate(str(RECIPES / f"{name}.toml"), seed), f"{name}, seed {seed}")
        for name, seeds in SEEDS.items()
        for seed in seeds
    ]
    return draw_sheet(shown, ["witness"], columns=4)


if __name__ == "__main__":
    for name, drawn in (("compose-pieces", pieces()), ("compose-recipes", recipes())):
        (HERE / "pictures" / f"{name}.png").write_bytes(drawn)
