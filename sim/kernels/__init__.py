"""Names for use in controllers that numba compiles: :mod:`sim.kernels.layout`."""
