"""The interface of an oracle: look at a trial and return a violation, or nothing."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from fuzz.facts.proofs import certified
from fuzz.oracles.trial import Trial
from fuzz.violation import Violation
from worldgen.world import World


class Oracle(ABC):
    """Judges runs and returns its finding.

    It raises only if it is misused or fails itself.
    """

    by_verdict: ClassVar[bool] = True
    """True if the run's verdict itself is the violation."""

    def prove(self, world: World) -> World | None:
        """Return the world with the certificate that a violation requires, here a witness.

        ``None`` if there isn't one.
        """
        return certified(world)

    @abstractmethod
    def check(self, trial: Trial) -> Violation | None:
        """Return what is wrong with a run; ``None`` if nothing is wrong.

        Args:
            trial: The run, and the means to run it again.

        Raises:
            InvalidParameter: If the oracle does not fit the run, or fails.
        """
