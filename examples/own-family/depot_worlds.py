"""A depot: racks in rows, aisles between them, and pallets left standing in the aisles."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidParameter
from worldgen.family import check_between, family
from worldgen.random_streams import RandomStream
from worldgen.world import Pose, Target, World


@family("depot", version=1)
def depot(
    rng: RandomStream,
    *,
    size: int = 40,
    layout: Literal["aisles", "fishbone"] = "aisles",
    aisle: int = 3,
    rack: int = 2,
    pallets: float = 0.1,
    cell_size: float = 0.1,
    robot_radius: float = 0.07,
    robot_speed: float = 2.0,
) -> World:
    """Build a depot: racks in rows with aisles between them, and pallets in the aisles.

    From one end of an aisle the other looks the same, and a pallet turns an aisle into a dead end.

    Args:
        rng: The only source of randomness; equal state gives an equal world.
        size: Cells per side, including the solid border; 16 to 500.
        layout: Racks in straight rows, or in two halves offset against each other.
        aisle: Width of the aisles, cells; at least the robot's.
        rack: Depth of a rack, cells, 1 to 20.
        pallets: Share of the places between two racks with a pallet, 0 to 1.
        cell_size: Side of a cell, m.
        robot_radius: Radius of the robot, m.
        robot_speed: Top speed of the robot, m/s.

    Raises:
        InvalidParameter: If a number is out of range, or an aisle is narrower than the robot.
    """
    # Check, then draw, then build, then return.
    check_between("size", size, 16, 500, "cells")
    check_between("rack", rack, 1, 20, "cells")
    check_between("pallets", pallets, 0.0, 1.0)
    check_between("cell_size", cell_size, 0.001, 1000.0, "m")
    check_between("robot_speed", robot_speed, 0.001, 1000.0, "m/s")
    check_between("robot_radius", robot_radius, 1e-6, 1000.0, "m")
    check_between("aisle", aisle, 1, size - 2, "cells")
    if 2 * robot_radius > aisle * cell_size:
        raise InvalidParameter(
            "below-minimum",
            "aisle={aisle} cells of {cell_size:g} m are narrower than the robot, {width:g} m wide",
            "use at least {least}",
            aisle=aisle,
            cell_size=cell_size,
            width=2 * robot_radius,
            least=math.ceil(2 * robot_radius / cell_size),
        )

    walls = np.ones((size, size), dtype=bool)
    walls[1:-1, 1:-1] = False
    _put_racks(rng, walls, layout, aisle, rack, pallets)
    near = (1 + aisle / 2) * cell_size
    far = (size - 1 - aisle / 2) * cell_size
    return World(
        walls,
        start=Pose(round(near, 9), round(near, 9)),
        target=Target(round(far, 9), round(far, 9), cell_size / 2),
        cell_size=cell_size,
        robot_radius=robot_radius,
        robot_speed=robot_speed,
    )


def _put_racks(
    rng: RandomStream,
    walls: npt.NDArray[np.bool_],
    layout: str,
    aisle: int,
    rack: int,
    pallets: float,
) -> None:
    """Make racks solid in two halves, and pallets next to them."""
    size = len(walls)
    # First row of the aisle that crosses the others.
    across = size // 2 - aisle // 2
    lower = (1 + aisle, across)
    upper = (across + aisle, size - 1 - aisle)
    set_off = (rack + aisle) // 2 if layout == "fishbone" else 0
    for (low, high), offset in ((lower, 0), (upper, set_off)):
        for x in range(1 + aisle + offset, size - aisle - rack, rack + aisle):
            walls[low:high, x : x + rack] = True
            for y in range(low, high - 1, 2):
                if rng.random() < pallets:
                    walls[y : y + 2, x + rack : x + rack + aisle - 1] = True
