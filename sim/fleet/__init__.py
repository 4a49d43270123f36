"""Several robots in one world, each with its own controller.

Contents:
    FleetEpisode: What happened in a run, with an episode for each robot.
    fleet_traces: Records each robot, even past the end of a joint loop.
    simulate_fleet: Runs it; :func:`sim.simulate` calls this for worlds of several robots.
    FleetRun: A world, controllers and options, packed for the core.
    assigned: Finds out which controller drives which robot.
"""

from sim.fleet.assignment import assigned
from sim.fleet.episode import FleetEpisode, fleet_traces, simulate_fleet
from sim.fleet.run import FleetRun

__all__ = ["FleetEpisode", "FleetRun", "assigned", "fleet_traces", "simulate_fleet"]
