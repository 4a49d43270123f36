"""Behaviours, and the controllers that are composed of them.

Contents, each imported when it is first used:
    Behaviour: When a behaviour applies (trigger), what it then does (action), and how it competes.
    BEHAVIOURS: The registered behaviours by name; also ``./mine.py:name``.
    Layer: A behaviour in a composition, with its priority, duration and options.
    composed: Return the controller that is composed of some parts.
    Arbitration: A controller's description of its parts, and of which part acts when.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from sim.controllers.behaviours.arbitration import Arbitration
    from sim.controllers.behaviours.base import Behaviour, Layer
    from sim.controllers.behaviours.catalogue import BEHAVIOURS
    from sim.controllers.behaviours.composition import composed

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "arbitration": ("Arbitration",),
        "base": ("Behaviour", "Layer"),
        "catalogue": ("BEHAVIOURS",),
        "composition": ("composed",),
    },
)

__all__ = ["BEHAVIOURS", "Arbitration", "Behaviour", "Layer", "composed"]
