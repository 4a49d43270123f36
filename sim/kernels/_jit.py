"""The decorator of every kernel of the simulator."""

from worldgen.jit import kernel

__all__ = ["kernel"]
