"""Whether a simpler world still fails, and still carries a certificate."""

from __future__ import annotations

from dataclasses import dataclass, field

from fuzz.failure import certified
from sim.controllers import CONTROLLERS, Controller
from sim.episode import prepare, simulate
from sim.scenario import Scenario
from worldgen.errors import InvalidWorld
from worldgen.world import World

__all__ = ["StillFails"]

_PROVED_BY_THE_RUN = ("loop", "tunnel", "overlap", "burned", "crash", "invalid-command")


@dataclass
class StillFails:
    """Judges candidates; counts the simulations that it cost.

    Args:
        scenario: What runs.
        verdict: The verdict to keep.
        budget: Steps for verdicts that the run itself proves; others get the budget of their own witness.
    """

    scenario: Scenario
    verdict: str
    budget: int
    simulations: int = 0
    _controller: Controller | None = field(default=None, repr=False)

    @property
    def proof_budget(self) -> int | None:
        """Budget that the final failure must have; ``None`` where its witness decides."""
        return self.budget if self.verdict in _PROVED_BY_THE_RUN else None

    def __call__(self, candidate: World) -> World | None:
        """The candidate with a fresh witness if it still fails the same way, else ``None``."""
        try:
            if self.verdict in _PROVED_BY_THE_RUN:
                return certified(candidate) if self._fails(candidate, self.budget) else None
            proved = certified(candidate)
            if proved is None or not self._fails(proved, self.scenario.options(proved).steps):
                return None
        except InvalidWorld:
            return None
        return proved

    def _fails(self, world: World, steps: int) -> bool:
        if self._controller is None:
            self._controller = CONTROLLERS.get(self.scenario.controller)
        self.simulations += 1
        options = self.scenario.options(world, steps)
        outcome = prepare(world, self._controller, options).run(steps, find_loop=True, record=False)
        if self.verdict in ("tunnel", "burned", "invalid-command", "crash"):
            return outcome.ending == self.verdict
        if outcome.ending in ("tunnel", "burned", "invalid-command", "crash"):
            return False
        if self.verdict == "overlap":
            return outcome.overlap_step >= 0
        if outcome.overlap_step >= 0 or outcome.ending == "reached":
            return False
        return simulate(world, self._controller, options).verdict == self.verdict
