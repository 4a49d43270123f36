"""VFH+: the robot drives through the opening between obstacles that costs it the fewest turns.

Obstacles around the robot fill a polar histogram, each widened by the robot's radius. What is left
free are openings; of the directions through them the cheapest is taken: near to the target's, to
the heading, and to the choice before. It drives fast and smoothly past clutter. It sees no further
    than its beams, and has no map: in a cup deeper than
that, or behind a long wall, it drives to and fro for ever.

Source: Iwan Ulrich and Johann Borenstein, "VFH+: reliable obstacle avoidance for fast mobile
    robots", IEEE
International Conference on Robotics and Automation, 1998: the four stages and the weights of
    section 3. Departures:
the histogram is filled from the scan of one step rather than from a certainty grid, so the nearest
obstacle of a sector counts, not a sum; the speed falls with the density in the chosen direction as
in their "The vector field histogram" (1991), equation 11.
"""

from __future__ import annotations

from typing import NamedTuple

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, default_of, memory_at_reset, place, size_of
from sim.options.robot import RobotOptions

__all__ = ["VfhPlus", "vfh", "vfh_robot"]

_DEFAULT = default_of("wg_vfh_default")
AT_RESET = memory_at_reset(size_of("WgVfhMemory"), {place("WgVfhMemory", "last"): -1.0})
SENSES = ("heading", "target_heading", "time_step", "top_speed", "radius", "beams")
NEEDS = RobotOptions(beams=72, beam_range=2.0)


class VfhPlus(NamedTuple):
    """Tuned numbers.

    Args:
        safety: What obstacles are widened by beside the robot's radius, in radii.
        window: Distance, in radii of the robot, beyond which obstacles do not count.
        low: Density, 0 (at the window's edge) to 1 (at the robot), below which a blocked sector
            becomes free.
        high: Density above which a free sector becomes blocked.
        wide: Sectors of an opening that is passed along its side instead of through its middle.
        to_target: Cost of a sector between a direction and the target's; larger than the two others
            together.
        to_heading: Cost of a sector between it and the heading.
        to_last: Cost of a sector between it and the direction chosen last.
        turning_radius: m, of a robot that cannot turn on the spot; 0 masks no directions.
        slowest: Share of the top speed that is left in the densest direction.
    """

    safety: float = _DEFAULT["safety"]
    window: float = _DEFAULT["window"]
    low: float = _DEFAULT["low"]
    high: float = _DEFAULT["high"]
    wide: int = int(_DEFAULT["wide"])
    to_target: float = _DEFAULT["to_target"]
    to_heading: float = _DEFAULT["to_heading"]
    to_last: float = _DEFAULT["to_last"]
    turning_radius: float = _DEFAULT["turning_radius"]
    slowest: float = _DEFAULT["slowest"]


def vfh_robot(tuned: VfhPlus, name: str = "vfh") -> CompiledController:
    """Return a robot under VFH+ with these numbers."""
    act = CoreAct("vfh") if tuned == VfhPlus() else CoreAct("vfh-tuned")
    memory = AT_RESET if tuned == VfhPlus() else AT_RESET + tuple(map(float, tuned))
    return CompiledController(name, act, memory, senses=SENSES, needs=NEEDS)


vfh = vfh_robot(VfhPlus())
