"""Boxes as a mesh of trimesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import trimesh

from worldgen.interop.geometry.placed_boxes import BOX_CORNERS, BOX_TRIANGLES, PlacedBox

__all__ = ["box_mesh"]


def box_mesh(boxes: Sequence[PlacedBox]) -> Any:
    """Return one mesh of all boxes in the given order, eight vertices and twelve triangles each."""
    ends = np.array(
        [[*map(float, box.low), *map(float, box.high)] for box in boxes], np.float64
    ).reshape(-1, 2, 3)
    corners = np.stack([ends[:, pick, range(3)] for pick in BOX_CORNERS], axis=1)
    faces = np.array(BOX_TRIANGLES, np.int64) + 8 * np.arange(len(boxes))[:, None, None]
    return trimesh.Trimesh(
        corners.reshape(-1, 3), faces.reshape(-1, 3), process=False, validate=False
    )
