"""Count the seeds with which a run that draws random numbers fails."""

from __future__ import annotations

from dataclasses import replace

from fuzz.failure import regardless_of_walls
from sim.controllers import CONTROLLERS, CompiledController
from sim.controllers.noise import is_random
from sim.episode import prepare, simulate
from sim.scenario import Scenario
from sim.verdict import ARRIVALS
from worldgen.support.intervals import interval_95
from worldgen.world import Cut, Value, World


def seeds_that_fail(world: World, scenario: Scenario, count: int = 40) -> dict[str, Value]:
    """Return how many of ``count`` seeds fail to arrive, and the share of all seeds this implies.

    Either the controller draws random numbers, or the simulator does, for slip or sensor noise. If
    the target is walled off, arriving is the failure: seeds that get there through walls count.

    Returns:
        ``failing_seeds`` as [k, n], and ``failing_share_at_least``, the lower end of the two-sided
        95 % interval. Empty for a run without randomness or a controller that is not compiled,
        which would be too slow.

    Source: Charles Clopper and Egon Pearson, "The use of confidence or fiducial limits illustrated
        in the case of the binomial", Biometrika 1934.
    """
    controller = CONTROLLERS.get(scenario.controller)
    if not (isinstance(controller, CompiledController) and is_random(controller, scenario.run)):
        return {}
    options = scenario.options(world)
    sealed = isinstance(world.certificate, Cut)
    # In a walled-off world a run should continue past the wall, to see where it ends.
    options = regardless_of_walls(options) if sealed else options
    failing = 0
    for seed in range(count):
        seeded = replace(options, seed=seed)
        if world.is_fleet:
            arrives = simulate(world, controller, seeded).verdict in ARRIVALS
        else:
            run = prepare(world, controller, seeded)
            outcome = run.run(options.steps, find_loop=False, record=False, digest=False)
            arrives = outcome.ending in ARRIVALS
        failing += arrives == sealed
    least, _ = interval_95(failing, count)
    return {"failing_seeds": [failing, count], "failing_share_at_least": round(least, 4)}
