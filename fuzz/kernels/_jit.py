"""The decorators of the fuzzer's kernels, which are built on the simulator's."""

from __future__ import annotations

import functools
from pathlib import Path

from sim import kernels
from worldgen.jit import kernel as _kernel

__all__ = ["allocating_kernel", "kernel", "rare_kernel"]

_SIMULATOR = Path(kernels.__path__[0])

kernel = functools.partial(_kernel, allocates=False, inline=True, built_on=_SIMULATOR)
"""Its code stands in place of each call."""

rare_kernel = functools.partial(_kernel, allocates=False, inline=False, built_on=_SIMULATOR)
"""Called once for each world, or less often."""

allocating_kernel = functools.partial(_kernel, allocates=True, built_on=_SIMULATOR)
"""For generators, which numba keeps in memory of its own."""
