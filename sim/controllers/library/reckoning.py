"""Controllers that estimate where they are, or where the target is.

``odometry-bug`` is Bug2 by odometry: it learns once where the target is, and from then on derives
its own position and heading only from its wheels. With ``odometry_noise`` its world turns and
drifts away from the real one, and it ends up where it believes the target to be.

``signal-mapper`` is the mapper with the same restriction, except that it has a compass, and it
corrects itself: the strength of the signal reveals the distance to the target, and it corrects its
estimated position by a fifth of the error in that distance. This pulls its map back into place,
whichever side it approaches from.

``scan-mapper`` is the mapper without a compass. It keeps a map of points on walls, from its range
beams, and finds its pose by matching each scan with it; ``sim/core/controllers/shared/scan_map.h``
describes how. What it sees blocks edges on the mapper's map, too.

``signal-three-layer`` knows its own position, but senses only the target's signal. Two signal
strengths measured 0.25 m apart leave two possible places for the source; the direction of the
strongest signal decides between them. Without a signal it searches. It assumes that the signal
falls to a half within a cell of 0.1 m, as in the families' worlds; :func:`signal_three_layer_robot`
accepts another length.

Sources: Johann Borenstein, H. R. Everett and Liqiang Feng, "Where am I? Sensors and methods for
    mobile robot positioning", University of Michigan (1996), chapters 1 and 6. They drive like
    ``bug2``, ``mapper`` and ``three-layer``. For ``scan-mapper``, Andrea Censi, "An ICP variant
    using a point-to-line metric", IEEE International Conference on Robotics and Automation (2008).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sim._core import lib
from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, fields_of, memory_at_reset, size_of
from sim.controllers.library import bug2, mapper, three_layer
from sim.controllers.memory_view import MemoryMap
from sim.options.robot import RobotOptions
from worldgen.parameters.bounds import check_positive
from worldgen.support.arrays import Floats

AT = fields_of("WgReckoning")

SIZE = size_of("WgReckoning")

SCAN = fields_of("WgScanMap")

SCAN_SIZE = size_of("WgScanMap")

# The map of scans: the side of a cell, m, and how ``sim/core/controllers/shared/scan_map.c`` packs
# cells into a number.
_SCAN_PITCH = 0.1
_CELLS_A_WORD = 3
_BITS = 17
_PARTS = 256

# Distance at which the signal falls to a half in the families' worlds, m.
_CELL = 0.1
_ODOMETRY = ("odometry_x", "odometry_y", "odometry_heading")


def _senses(
    controller: CompiledController, less: tuple[str, ...], more: tuple[str, ...]
) -> tuple[str, ...]:
    return (*(sense for sense in controller.senses if sense not in less), *more)


def scanned_points(scans: Floats) -> Floats:
    """Return the points of a map of scans: (n, 2), m.

    Args:
        scans: The part of a memory that is the map.
    """
    side = int(lib.WG_SCAN_SIDE)
    words = scans[SCAN.cells :].astype(np.int64)
    entries = (words[:, None] >> (_BITS * np.arange(_CELLS_A_WORD))) & ((1 << _BITS) - 1)
    cells = entries.ravel()[: side * side].reshape(side, side)
    row, column = np.nonzero(cells)
    part_y, part_x = np.divmod(cells[row, column] - 1, _PARTS)

    # A cell's place in the memory is its place in the world, modulo the window's side.
    low = scans[[SCAN.window_x, SCAN.window_y]]
    cell = low + (np.column_stack((column, row)) - low) % side
    inside = (np.column_stack((part_x, part_y)) + 0.5) / _PARTS
    places: Floats = (cell + inside) * scans[SCAN.pitch]
    return places


def _reckoning(
    name: str,
    driven: CompiledController,
    senses: tuple[str, ...],
    about: str,
    *,
    cell: float = 0.0,
    shows_itself: bool,
) -> CompiledController:
    """Return a controller that estimates, and then drives like another one."""
    # The other controller's memory follows this one's, so its indices shift by this one's size.
    read = driven.memory_map

    def shown_map(memory: Floats) -> MemoryMap:
        """Return the other controller's map, and the estimates, in m."""
        shown = MemoryMap() if read is None else read(memory[SIZE:])
        places = dict(shown.places)
        known = {"target": AT.target_x} | ({"itself": AT.x} if shows_itself else {})
        for who, at in known.items() if memory[AT.known] != 0.0 else ():
            places[f"{who}, estimated"] = (float(memory[at]), float(memory[at + 1]))
        return replace(shown, places=places)

    own = (AT.known, AT.x, AT.x + 1, AT.target_x, AT.target_x + 1)
    return replace(
        driven,
        name=name,
        act=CoreAct(name),
        memory=(*memory_at_reset(SIZE, {AT.cell: cell}), *driven.memory),
        senses=senses,
        about=about,
        memory_fields=tuple(one._replace(place=one.place + SIZE) for one in driven.memory_fields),
        memory_map=shown_map,
        memory_map_on=(*own, *(at + SIZE for at in driven.memory_map_on)),
    )


odometry_bug = _reckoning(
    "odometry-bug",
    bug2.bug2,
    _senses(bug2.bug2, ("x", "y", "heading"), _ODOMETRY),
    "Like bug2, but know its own place only from its wheels.",
    shows_itself=True,
)
signal_mapper = _reckoning(
    "signal-mapper",
    mapper.mapper,
    _senses(mapper.mapper, ("x", "y"), (*_ODOMETRY, "signal")),
    "Like mapper, but estimate its own place from wheels, compass and signal.",
    shows_itself=True,
)


def scan_mapper_robot(driven: CompiledController, name: str) -> CompiledController:
    """Return a mapper that corrects its odometry by matching its scans with a map of them.

    Args:
        driven: The mapper that drives, from :func:`sim.controllers.library.mapper.mapping`.
        name: Name in messages and files.
    """
    senses = _senses(driven, ("x", "y", "heading"), (*_ODOMETRY, "beams"))
    made = _reckoning(
        "scan-mapper",
        driven,
        senses,
        "Like mapper, but know its own place only from wheels and from its map of scans.",
        shows_itself=True,
    )

    # The map of scans follows the other controller's memory.
    at = len(made.memory)
    scans = memory_at_reset(SCAN_SIZE, {SCAN.pitch: _SCAN_PITCH})

    def shown_map(memory: Floats) -> MemoryMap:
        """Return what the mapper knows, and the points of the map of scans, in m."""
        assert made.memory_map is not None
        return replace(made.memory_map(memory), nodes=scanned_points(memory[at:]))

    return replace(
        made,
        name=name,
        memory=(*made.memory, *scans),
        needs=RobotOptions(beams=72, beam_range=3.0),
        memory_map=shown_map,
        memory_map_on=(*made.memory_map_on, *range(at + SCAN.cells, at + SCAN_SIZE)),
    )


scan_mapper = scan_mapper_robot(mapper.mapper, "scan-mapper")


def signal_three_layer_robot(
    cell: float = _CELL, name: str = "signal-three-layer"
) -> CompiledController:
    """Return a three-layer controller that knows the target only by its signal.

    Args:
        cell: Distance at which the signal has fallen to a half: the side of the world's cells, m.
        name: Name in messages and files.

    Raises:
        InvalidParameter: If the distance is not above 0.
    """
    check_positive("cell", cell, "m")
    driven = three_layer.three_layer
    senses = _senses(driven, ("target_heading", "target_distance"), ("signal", "signal_heading"))
    about = "Like three-layer, but know the target only by its signal."
    made = _reckoning("signal-three-layer", driven, senses, about, cell=cell, shows_itself=False)
    return replace(made, name=name)


signal_three_layer = signal_three_layer_robot()
