"""Judge whether a trajectory recorded in any simulator was possible in a world.

The audit is an independent check: it shares no code with the simulator.
"""

from sim.audit.judge import *  # noqa: F403
from sim.audit.judge import __all__ as __all__
