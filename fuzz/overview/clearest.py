"""Choose the failure of a cause that a person understands at a glance.

The smallest world of a cause is often a room of three cells in which the robot covers its target.
It is kept because small worlds make good tests, but the one to look at first is the clearest.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from fuzz.cause import Circumstance
from fuzz.failure import Failure, ShrinkState
from fuzz.simplicity import FailureOrder
from fuzz.triage.behaviour import behaviour_of
from fuzz.triage.diagnosis import diagnosis_of
from sim.clock.stopping import OutOfTime
from worldgen.errors import WorldgenError

# Cells between the edges of robot and target at the start; with less, the robot seems to be there
# already.
_APART = 1.0

# Cells. In a narrower room hardly any walls are visible; in a wider one no single wall is.
_NARROWEST = 4
_WIDEST = 30

# Times the longer side of the world. A longer period fills the picture with lines.
_TANGLE = 30.0

# Limits on the shrunk and on the other candidates examined per cause, the simplest first.
_MOST = 12


@dataclass(frozen=True, order=True)
class Clarity:
    """How hard a failure is to understand from its picture; smaller is clearer.

    Of equally clear failures, the first in order is the one to show.

    Args:
        robots: Number of its robots. Each has to be understood, and only shrinking shows whether
            it matters.
        is_degenerate: True if the robot seems to be at its target from the start, or covers it.
        is_tangled: True if the period fills the picture with lines.
        is_unshrunk: True if it has walls that do not matter.
        flaws: Number of the other reasons against it.
        windings: Number of doublings by which the period's path is longer than a path around its
            box.
        order: Its place in the order of failures.
    """

    robots: int
    is_degenerate: bool
    is_tangled: bool
    is_unshrunk: bool
    flaws: int
    windings: int
    order: FailureOrder


def clarity(failure: Failure) -> Clarity:
    """Return how clear a failure's picture is. This runs its controller.

    Raises:
        WorldgenError: If it cannot be run.
        OutOfTime: If it cannot be run in time.
    """
    world = failure.world
    side = world.cell_size
    robot = world.robot_radius / side
    target = world.target.radius / side

    # Look at the flaws that the world alone shows.
    apart = math.dist((world.start.x, world.start.y), (world.target.x, world.target.y)) / side
    is_degenerate = apart < robot + target + _APART
    flaws = int(min(world.width, world.height) < _NARROWEST)
    flaws += max(world.width, world.height) > _WIDEST

    # Consider what only the run shows: a robot drawn over its target, and a tangled period.
    episode = failure.run(through_walls=failure.is_breach)
    behaviour = behaviour_of(world, episode)
    windings = 0
    is_tangled = False
    if behaviour is not None:
        around = 4.0 * max(behaviour.extent, 1.0)
        windings = math.floor(math.log2(max(1.0, behaviour.length / around)))
        at_target = diagnosis_of(failure).circumstance == Circumstance.AT_THE_TARGET
        is_degenerate |= not at_target and behaviour.nearest < robot
        is_tangled = behaviour.length > _TANGLE * max(world.width, world.height)
    is_unshrunk = failure.shrinking != ShrinkState.DONE
    return Clarity(
        len(world.robots), is_degenerate, is_tangled, is_unshrunk, flaws, windings, failure.order
    )


def clearest(failures: Iterable[Failure]) -> Failure | None:
    """Return the clearest of several failures of one cause; ``None`` if there are none.

    Args:
        failures: The candidates. The simplest dozen of the shrunk ones and of the others are examined.
    """
    candidates = sorted(failures, key=lambda failure: failure.order)
    # Examine both shrunk and unshrunk ones, the simplest of each.
    shrunk = [one for one in candidates if one.shrinking == ShrinkState.DONE][:_MOST]
    others = [one for one in candidates if one.shrinking != ShrinkState.DONE][:_MOST]
    best: tuple[Clarity, Failure] | None = None
    for failure in (*shrunk, *others):
        try:
            found = clarity(failure)
        except (WorldgenError, OutOfTime):
            continue
        if best is None or found < best[0]:
            best = (found, failure)
    if best is not None:
        return best[1]
    return candidates[0] if candidates else None
