"""Whether a simpler world still fails in the same manner, and still carries a certificate."""

from __future__ import annotations

from dataclasses import dataclass, field

from fuzz.asked import Asked, Trial, asked_by
from fuzz.failure import certified, regardless_of_walls, scenario_of, walled_off
from sim.controllers import CONTROLLERS, Controller
from sim.episode import prepare, simulate
from sim.outcome import BY_THE_CONTROLLER, Outcome
from sim.run_options import RunOptions
from sim.scenario import Scenario
from worldgen.errors import InvalidWorld
from worldgen.world import Cut, World

__all__ = ["StillFails"]

_PROVED_BY_THE_RUN = ("loop", "tunnel", "overlap", "burned", *BY_THE_CONTROLLER)


@dataclass
class StillFails:
    """Judges candidates; counts the simulations that it cost.

    Args:
        scenario: What runs.
        verdict: The verdict to keep.
        budget: Steps for verdicts that the run itself proves; others get the budget of their own witness.
        manner: What to keep beside the verdict: the cause of a tunnel or overlap, the kind of a stalled run;
            empty for whatever it is.
        breach: Whether the target is to stay walled off, and to be reached regardless of walls.
        asked: The oracle that is to object still, for a failure by one; then the manner is its class.
    """

    scenario: Scenario
    verdict: str
    budget: int
    manner: str = ""
    breach: bool = False
    asked: Asked | None = None
    simulations: int = 0
    _controller: Controller | None = field(default=None, repr=False)

    @classmethod
    def of(cls, failure: World, budget: int | None = None) -> StillFails:
        """The predicate that keeps what a failure's record says.

        Args:
            failure: A world with a failure record.
            budget: See above; the record's own where left out.
        """
        record, options = scenario_of(failure)
        manner = record.evidence.get("kind" if record.verdict == "stalled" else "cause", "")
        asked, said = asked_by(record.evidence), record.evidence.get("objection")
        if asked is not None:
            manner = asked.kind(said if isinstance(said, dict) else {})
        return cls(
            Scenario.of(record.controller, options),
            record.verdict,
            options.steps if budget is None else budget,
            manner=str(manner),
            breach=isinstance(failure.certificate, Cut),
            asked=asked,
        )

    @property
    def proof_budget(self) -> int | None:
        """Budget that the final failure must have; ``None`` where its witness decides."""
        return self.budget if self.verdict in _PROVED_BY_THE_RUN and self.asked is None else None

    def __call__(self, candidate: World) -> World | None:
        """The candidate with a fresh certificate if it still fails the same way, else ``None``."""
        try:
            if self.asked is not None:
                return self._objected(self.asked, candidate)
            if self.verdict in _PROVED_BY_THE_RUN:
                if not self._fails(candidate, self.budget):
                    return None
                return walled_off(candidate) if self.breach else certified(candidate)
            proved = certified(candidate)
            if proved is None or not self._fails(proved, self.scenario.options(proved).steps):
                return None
        except InvalidWorld:
            return None
        return proved

    def _objected(self, asked: Asked, candidate: World) -> World | None:
        """The candidate with a fresh witness if the oracle objects in the same manner."""
        proved = certified(candidate)
        if proved is None:
            return None
        self.simulations += 1
        said = asked.objection(Trial(proved, self.scenario.controller, self.scenario.options(proved)))
        return proved if said is not None and asked.kind(said) == self.manner else None

    def _fails(self, world: World, steps: int) -> bool:
        if self._controller is None:
            self._controller = CONTROLLERS.get(self.scenario.controller)
        self.simulations += 1
        options = self.scenario.options(world, steps)
        outcome = self._run(world, options)
        if self.verdict == "tunnel":
            return outcome.ending == "tunnel" and self._likewise(outcome.cause) and self._arrives(world, options)
        if self.verdict in ("burned", *BY_THE_CONTROLLER):
            return outcome.ending == self.verdict
        if outcome.ending in ("tunnel", "burned", *BY_THE_CONTROLLER):
            return False
        if self.verdict == "overlap":
            return outcome.overlap_step >= 0 and self._likewise(outcome.cause)
        if outcome.overlap_step >= 0 or outcome.ending == "reached":
            return False
        episode = simulate(world, self._controller, options)
        return episode.verdict == self.verdict and self._likewise(episode.evidence.get("kind"))

    def _run(self, world: World, options: RunOptions) -> Outcome:
        controller = self.scenario.controller if self._controller is None else self._controller
        return prepare(world, controller, options).run(options.steps, find_loop=True, record=False, digest=False)

    def _likewise(self, manner: object) -> bool:
        return self.manner in ("", manner)

    def _arrives(self, world: World, options: RunOptions) -> bool:
        """For a breach, whether the robot arrives regardless of walls; else nothing is asked."""
        return not self.breach or self._run(world, regardless_of_walls(options)).ending == "reached"
