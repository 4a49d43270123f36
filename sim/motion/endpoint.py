"""``endpoint``: looks only where a step ends, as most small simulators do; fast robots pass through walls."""

from sim._core import lib
from sim.motion.base import LATTICE, Motion

__all__ = ["endpoint"]

# Between two clear ends a short step can shave a corner by its sagitta: 0.016 cell at 0.3 cell a step and
# radius 0.7. A tenth of a cell leaves that unreported.
endpoint = Motion(
    "endpoint", version=2, kernel=LATTICE, code=lib.WG_ENDPOINT, overlap_tolerance=0.1,
    summary="checks only the end of each step: fast robots tunnel",
)  # fmt: skip
