"""The decorators of the simulator's kernels."""

from __future__ import annotations

import functools

from worldgen.jit import kernel as _kernel

__all__ = ["allocating_kernel", "kernel", "rare_kernel"]

kernel = functools.partial(_kernel, allocates=False, inline=True)
"""For all that makes no array and no slice: it pays for no reference counts and no calls."""

rare_kernel = functools.partial(_kernel, allocates=False, inline=False)
"""The same for what few steps need: kept out of the loop, so that the rest of it fits the processor's registers."""

allocating_kernel = functools.partial(_kernel, allocates=True)
"""For the few that do; call them once an episode, not once a step."""
