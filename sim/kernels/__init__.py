"""Names for controllers that numba compiles: :mod:`sim.kernels.layout`."""
