"""Was a trajectory, recorded in any simulator, possible in a world? Shares no code with the simulator."""

from sim.audit.judge import *  # noqa: F403
from sim.audit.judge import __all__ as __all__
