"""A family that puts a trap across the path through a maze."""

from worldgen.compose import of_family
from worldgen.family import family
from worldgen.random_streams import RandomStream
from worldgen.world import World


@family("trap-in-maze", version=1)
def trap_in_maze(rng: RandomStream, *, size: int = 60, trap: int = 18) -> World:
    """Build a maze with a trap across the path through it.

    Args:
        rng: The only source of randomness.
        size: Cells per side.
        trap: Cells per side of the trap's own ground.
    """
    maze = of_family("maze", rng.child("maze"), size=size, braid=0.2)
    ground = of_family("trap", rng.child("trap"), size=trap + 2)
    inside = ground.crop(1, 1, trap, trap).rotate(rng.below(4))
    return maze.place(inside, at="way", seed=rng.child("place")).layout()
