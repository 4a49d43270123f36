"""What a failure's run shows about its controller, for the terminal, reports and JSON."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field, replace

from fuzz.failure import Failure
from fuzz.triage.inside import Inside, described, reads_there, watched
from fuzz.triage.pose_estimate import pose_estimate
from fuzz.triage.reactions import COUNTED, Reaction, Reactions
from fuzz.triage.repeated_moves import describe_period
from sim.clock.stopping import OutOfTime
from sim.episode import Episode
from sim.episode.watched import WatchedPart


@dataclass(frozen=True)
class RunFacts:
    """What a run shows: what the robot repeats, what runs inside its controller, how it reacts.

    ``docs/reference/verdicts.md`` describes its form in JSON.

    Args:
        repeats: What it repeats, to follow ``it``; empty if it doesn't.
        inside: The lines that run and its state; ``None`` for a controller that isn't in Python.
        reactions: Its turns and moves by what is around it.
    """

    repeats: str = ""
    inside: Inside | None = None
    reactions: list[Reaction] = field(default_factory=list)

    def text(self) -> list[str]:
        """Return the lines for the terminal."""
        found = [f"It {self.repeats}."] if self.repeats else []
        found += [] if self.inside is None else self.inside.text()
        if self.reactions:
            found.append(f"what it does by what is around it, {COUNTED}:")
            found += [f"  {one.text()}" for one in self.reactions]
        return found


def run_facts(failure: Failure, episode: Episode, *, with_code: bool = True) -> RunFacts:
    """Return what a failure's run shows, as far as there is time.

    Args:
        failure: The failure.
        episode: Its run, recorded.
        with_code: False to leave out what runs inside the controller.
    """
    # A run that arrives, and that of several robots, has no part that goes wrong in this sense.
    facts = RunFacts()
    if failure.is_breach or failure.oracle is not None or failure.world.is_fleet:
        return facts
    with contextlib.suppress(OutOfTime):
        facts = replace(facts, repeats=describe_period(failure.world, episode))
        if episode.trace is not None:
            seen = Reactions()
            seen.add(failure.world, episode.trace)
            facts = replace(facts, reactions=seen.rows())
        found = watched(failure, episode) if with_code else None
        if found is not None:
            facts = replace(facts, inside=described(found, episode))
            where = _estimate(failure, episode, found)
            if facts.repeats and where:
                facts = replace(facts, repeats=f"{facts.repeats}; {where}")
    return facts


def _estimate(failure: Failure, episode: Episode, found: WatchedPart) -> str:
    """Return where a controller believes it is, if that is wrong and it acts on it."""
    assert episode.trace is not None, "only a recorded run is watched"
    where = pose_estimate(failure.world, episode.trace, found.numbers)
    if where is None or not any(reads_there(found, name) for name in where.names):
        return ""
    return where.describe()
