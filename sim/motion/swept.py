"""``swept``: exact time of impact and sliding on the pose lattice; no controller can tunnel."""

from sim._core import lib
from sim.motion.base import LATTICE, Motion

__all__ = ["swept"]

swept = Motion(
    "swept", version=3, kernel=LATTICE, code=lib.WG_SWEPT, overlap_tolerance=0.0, exact_events=True,
    summary="exact: the disc stops at walls and slides along them; it cannot tunnel",
)  # fmt: skip
