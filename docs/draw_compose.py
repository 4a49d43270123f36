"""Draws the pictures of docs/howto/compose.md: ``python docs/draw_compose.py``."""

from __future__ import annotations

from pathlib import Path

from worldgen.compose import Piece, of_family
from worldgen.render import Panel, Trail, draw_sheet
from worldgen.world import Witness, World

HERE = Path(__file__).parent


def panel(world: World, title: str) -> Panel:
    """Return a world with its witness."""
    way = world.certificate
    return Panel(world, title, (Trail(way.x, way.y) if isinstance(way, Witness) else None,))


def pieces() -> bytes:
    """Return one trap, put into one maze in different ways, as a PNG file's bytes."""
    maze = of_family("maze", seed=7, size=60)
    trap = of_family("trap", seed=3, size=20, shape="U").crop(1, 1, 18, 18)
    fire = of_family("fire", seed=2, size=24, over="trap", debris=0.05).crop(1, 1, 22, 22)
    shown: dict[str, Piece] = {
        'place(trap, at="way", seed=5)': maze.place(trap, at="way", seed=5),
        'place(trap.rotate(1), at="centre")': maze.place(trap.rotate(1), at="centre"),
        'place(trap.rotate(1).mirror("x"), at="centre")': maze.place(
            trap.rotate(1).mirror("x"), at="centre"
        ),
        'place(fire.mirror("x"), at="way", seed=5)': maze.place(fire.mirror("x"), at="way", seed=5),
    }
    return draw_sheet(
        [panel(piece.world(), title) for title, piece in shown.items()], ["witness"], columns=4
    )


if __name__ == "__main__":
    (HERE / "pictures" / "compose-pieces.png").write_bytes(pieces())
