"""The decorators of these kernels, which are built on the simulator's."""

from __future__ import annotations

import functools
from pathlib import Path

from sim import kernels
from worldgen.jit import kernel as _kernel

__all__ = ["kernel", "rare_kernel"]

_SIMULATOR = Path(kernels.__path__[0])

kernel = functools.partial(_kernel, allocates=False, inline=True, built_on=_SIMULATOR)
"""Its code stands in place of each call."""

rare_kernel = functools.partial(_kernel, allocates=False, inline=False, built_on=_SIMULATOR)
"""A call of its own, compiled once however many call it."""
