"""The options that every format of drawings has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class DrawingOptions:
    """What a user says about a drawing.

    A format that means something else by one of these has a subclass with its own entry for it.

    Args:
        layer: Names of the layers that are walls, with commas between them; * and ? stand for any
            letters. If omitted, all that are visible.
        free: Names of those that are openings, such as doors, in the same form.
        unit: Length of a unit of the drawing: m, cm, mm, in, ft, or a number of metres; if omitted,
            the file's.
        cell_size: Side of a cell, m; 0 means 0.05, or more for a large drawing.
        thickness: Thickness of lines without a width, m.
        areas: Whether areas are solid, or only outlined by walls.
    """

    layer: str = ""
    free: str = ""
    unit: str = ""
    cell_size: float = 0.0
    thickness: float = 0.0
    areas: Literal["solid", "outline"] = "solid"

    @property
    def outlines(self) -> bool:
        """True if areas are only outlined by walls."""
        return self.areas == "outline"
