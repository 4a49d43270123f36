"""VFH+: drive through the opening between obstacles that requires the least turning.

Obstacles around the robot fill a polar histogram, each widened by the robot's radius. The free
sectors form openings. Of the directions through them, the robot takes the cheapest; cost grows with
the angle to the target's direction, the heading, and the previous choice. It drives fast and
smoothly through clutter. It sees no farther than its beams and has no map, so in a cup that is
deeper than that, or behind a long wall, it drives back and forth forever.

Source: Iwan Ulrich and Johann Borenstein, "VFH+: reliable obstacle avoidance for fast mobile
    robots", IEEE International Conference on Robotics and Automation, 1998: the four stages and the
    weights of section 3. Departures: the histogram is filled from the scan of one step rather than
    from a certainty grid, so the nearest obstacle of a sector counts, not a sum; the speed falls
    with the density in the chosen direction as in their "The vector field histogram" (1991),
    equation 11.
"""

from __future__ import annotations

from typing import NamedTuple

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, default_of, memory_at_reset, size_of
from sim.controllers.library._common import tuned_controller
from sim.kernels.layout import place
from sim.options.robot import RobotOptions

_DEFAULT = default_of("wg_vfh_default")


class VfhPlus(NamedTuple):
    """Tuned parameters.

    Args:
        safety: Safety distance added to obstacles, besides the robot's radius, in radii.
        window: Distance beyond which obstacles do not count, in radii of the robot.
        low: Density below which a blocked sector becomes free; 0 is at the window's edge, 1 at the
            robot.
        high: Density above which a free sector becomes blocked.
        wide: Sectors of an opening that is passed along its side instead of through its middle.
        to_target: Cost per sector between a direction and the target's; larger than the other two
            together.
        to_heading: Cost per sector between a direction and the heading.
        to_last: Cost per sector between a direction and the previous choice.
        turning_radius: Turning radius of a robot that cannot turn on the spot, m; 0 masks no
            directions.
        slowest: Fraction of the top speed that remains in the densest direction.
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
    """Return a VFH+ controller with these parameters."""
    return tuned_controller(vfh, tuned, name)


vfh = CompiledController(
    "vfh",
    CoreAct("vfh"),
    memory_at_reset(size_of("WgVfhMemory"), {place("WgVfhMemory", "last"): -1.0}),
    about="Drive through the opening that requires the least turning.",
    senses=("heading", "target_heading", "time_step", "top_speed", "radius", "beams"),
    needs=RobotOptions(beams=72, beam_range=2.0),
)
