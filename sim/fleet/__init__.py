"""Several robots in one world, each with its own controller.

Contents, each imported when it is first used:
    fleet_traces: Records each robot, even past the end of a joint loop.
    simulate_fleet: Runs it; :func:`sim.simulate` calls this for worlds of several robots.
    FleetRun: A world, controllers and options, packed for the core.
    assigned: Finds out which controller drives which robot.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from sim.fleet.assignment import assigned
    from sim.fleet.episode import fleet_traces, simulate_fleet
    from sim.fleet.run import FleetRun

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "assignment": ("assigned",),
        "episode": ("fleet_traces", "simulate_fleet"),
        "run": ("FleetRun",),
    },
)

__all__ = ["FleetRun", "assigned", "fleet_traces", "simulate_fleet"]
