"""A robot's radius, in m, or in cells of whatever map it is put in."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction

from worldgen.errors import InvalidParameter
from worldgen.family import check_between
from worldgen.lattice import exact, in_cells

__all__ = ["DEFAULT_RADII", "Radius"]

_FORM = re.compile(r"([0-9]{1,40}\.?[0-9]{0,40}(?:[eE][+-]?[0-9]{1,3})?)\s*(m|c|cells?)?")


@dataclass(frozen=True)
class Radius:
    """What ``--radius`` takes.

    Args:
        value: The number.
        cells: Whether it counts cells rather than m.
    """

    value: float
    cells: bool = False

    @classmethod
    def parse(cls, text: str) -> Radius:
        """``0.3`` or ``0.3m`` is m, ``0.7c`` cells.

        Raises:
            InvalidParameter: If it is neither, or out of range.
        """
        found = _FORM.fullmatch(text.strip())
        if found is None:
            raise InvalidParameter(
                "wrong-form",
                "radius={text!r} is no radius",
                "write 0.3 for m, or 0.7c for cells",
                text=text[:40],
            )
        radius = cls(float(found[1]), (found[2] or "m").startswith("c"))
        check_between("radius", radius.value, 1e-9, 1e9, "cells" if radius.cells else "m")
        return radius

    def metres(self, cell_size: float) -> float:
        """The radius, m, in a map of cells of ``cell_size`` m."""
        return float(exact(self.value) * exact(cell_size)) if self.cells else self.value

    def in_cells(self, cell_size: float) -> Fraction:
        """The radius, cells, as it is judged: that of :meth:`metres`, exactly."""
        return in_cells(self.metres(cell_size), cell_size)

    def __str__(self) -> str:
        return f"{self.value:g} cells" if self.cells else f"{self.value:g} m"


DEFAULT_RADII = (Radius(0.45, True), Radius(0.7, True), Radius(1.0, True))
