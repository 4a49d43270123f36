"""What a motion model is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from worldgen.errors import InvalidParameter
from worldgen.plugins.registry import Registry

__all__ = ["LATTICE", "MOTIONS", "THESIS", "Motion"]

LATTICE = "lattice"  # integer poses, any controller
THESIS = "thesis"  # float64 poses in pixels, the thesis's own robots


@dataclass(frozen=True)
class Motion:
    """How commanded motion becomes displacement.

    Args:
        name: As on the command line.
        version: Goes up when equal scenarios no longer give equal traces; failures record it.
        kernel: Which simulator runs it, ``LATTICE`` or ``THESIS``.
        code: The core's number for it.
        overlap_tolerance: Cut of the disc into a wall, in cells, that is not reported as ``overlap``.
        summary: One line for people.
        exact_events: Whether events count at their time inside a step, else from the beginning of that step.
    """

    name: str
    version: int
    kernel: str
    code: int
    overlap_tolerance: float
    summary: str
    exact_events: bool = False


def _accept(name: str, thing: Any) -> Motion:
    if not isinstance(thing, Motion):
        raise InvalidParameter("wrong-type", "motion model {name!r} is {thing!r}, not a Motion", name=name, thing=thing)
    return thing


MOTIONS: Registry[Motion] = Registry("worldgen.motion_models", "motion model", _accept)
