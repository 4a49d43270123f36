"""Two controllers that are compositions of behaviours, and know the target only by its signal.

``signal-bug`` approaches the signal; if a wall blocks its path, it follows the wall until the
signal is stronger than where it met the wall, and in a direction away from it. It is a bug
algorithm that needs neither a map nor a position, only a comparison of two readings.

``subsumption`` has four layers. The lowest wanders, in case no signal is received. The next
approaches the signal, and the one above follows walls. The highest escapes when the signal has not
become stronger for a long time, as on a wall that leads around in circles.

Sources: Kamilah Taylor and Steven M. LaValle, "I-Bug: an intensity-based bug algorithm", IEEE
    International Conference on Robotics and Automation (2009); Rodney A. Brooks, "A robust layered
    control system for a mobile robot", IEEE Journal of Robotics and Automation 2 (1986).
"""

from __future__ import annotations

from sim.controllers.behaviours.base import Layer
from sim.controllers.behaviours.composition import composed
from sim.controllers.behaviours.library import approach, escape, follow, wander

# Steps without progress before it escapes: long enough to follow most walls to their end, because
# an escape starts the walk over again.
_PATIENCE = 4000
_ESCAPE = 150.0

signal_bug = composed((follow, approach), name="signal-bug")
subsumption = composed(
    (Layer(escape, duration=_ESCAPE, options={"patience": _PATIENCE}), follow, approach, wander),
    name="subsumption",
)
