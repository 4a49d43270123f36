"""Controllers that estimate where they are, or where the target is.

``odometry-bug`` is Bug2 by odometry: it learns once where the target is, and from then on derives
its own position and heading only from its wheels. With ``odometry_noise`` its world turns and
drifts away from the real one, and it ends up where it believes the target to be.

``signal-mapper`` is the mapper with the same restriction, except that it has a compass, and it
corrects itself: the strength of the signal reveals the distance to the target, and it corrects its
estimated position by a fifth of the error in that distance. This pulls its map back into place,
whichever side it approaches from.

``signal-three-layer`` knows its own position, but senses only the target's signal. Two signal
strengths measured 0.25 m apart leave two possible places for the source; the direction of the
strongest signal decides between them. Without a signal it searches. It assumes that the signal
falls to a half within a cell of 0.1 m, as in the families' worlds; :func:`signal_three_layer_robot`
accepts another length.

Sources: Johann Borenstein, H. R. Everett and Liqiang Feng, "Where am I? Sensors and methods for
    mobile robot positioning", University of Michigan (1996), chapters 1 and 6. They drive like
    ``bug2``, ``mapper`` and ``three-layer``.
"""

from __future__ import annotations

from dataclasses import replace

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, fields_of, memory_at_reset, size_of
from sim.controllers.library import bug2, mapper, three_layer
from sim.controllers.memory_view import MemoryMap
from worldgen.parameters.bounds import check_positive
from worldgen.support.arrays import Floats

AT = fields_of("WgReckoning")

SIZE = size_of("WgReckoning")

# Distance at which the signal falls to a half in the families' worlds, m.
_CELL = 0.1
_ODOMETRY = ("odometry_x", "odometry_y", "odometry_heading")


def _senses(
    controller: CompiledController, less: tuple[str, ...], more: tuple[str, ...]
) -> tuple[str, ...]:
    return (*(sense for sense in controller.senses if sense not in less), *more)


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
