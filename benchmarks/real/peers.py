"""What a user would do without a campaign: a plain loop over small worlds, and a Hypothesis test."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass
from itertools import count

from hypothesis import HealthCheck, Phase, Verbosity, given, settings
from hypothesis import strategies as st

from sim import simulate
from sim.verdict import Verdict
from worldgen import generate
from worldgen.world import Witness, World

FAMILIES = ("cave", "corridor", "forest", "maze", "rooms", "rubble", "trap")
"""The families of worlds with one robot in which nothing changes."""
SIZES = range(13, 21)
TIMES = 8
"""A run that takes longer than the witness by this factor counts as a failure."""


@dataclass
class Peer:
    """What a peer found in its time.

    Args:
        first: CPU seconds until the first failing world; None if there was none.
        first_world: Number of that world.
        failing: Failing worlds in all.
        worlds: Worlds tried.
        seconds: CPU seconds in all.
    """

    first: float | None = None
    first_world: int | None = None
    failing: int = 0
    worlds: int = 0
    seconds: float = 0.0

    def count(self, arrives: bool, begun: float) -> None:
        """Count a world."""
        self.worlds += 1
        self.seconds = round(time.process_time() - begun, 3)
        if not arrives:
            self.failing += 1
            if self.first is None:
                self.first, self.first_world = self.seconds, self.worlds


def arrives(world: World, controller: str) -> bool:
    """Return True if a controller arrives within a few times the witness's time."""
    if not isinstance(world.certificate, Witness):
        raise TypeError("the world has no witness")
    seconds = TIMES * world.certificate.length / world.robot_speed
    return (
        simulate(world, controller, steps=max(60, int(seconds / 0.015))).verdict == Verdict.REACHED
    )


def plain_loop(controller: str, seconds: float, worlds: int | None = None) -> Peer:
    """Run a controller in one small world after another, from every family in turn.

    Args:
        controller: Its name.
        seconds: CPU time after which no further world begins.
        worlds: Number of worlds; if omitted, time alone decides.
    """
    peer = Peer()
    begun = time.process_time()
    for k in count() if worlds is None else range(worlds):
        family = FAMILIES[k % len(FAMILIES)]
        seed = k // len(FAMILIES)
        world = generate(family, seed, size=SIZES[seed % len(SIZES)])
        peer.count(arrives(world, controller), begun)
        if peer.seconds >= seconds:
            break
    return peer


def hypothesis_test(controller: str, seconds: float) -> Peer:
    """Let Hypothesis draw the worlds, until one fails; it does not shrink that world."""
    peer = Peer()
    begun = time.process_time()

    @settings(
        max_examples=1_000_000,
        deadline=None,
        database=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
        verbosity=Verbosity.quiet,
    )
    @given(st.sampled_from(FAMILIES), st.integers(0, 2**32 - 1), st.sampled_from(SIZES))
    def test_it_arrives(family: str, seed: int, size: int) -> None:
        # Hypothesis stops at a failure; an end without one looks the same from here.
        if peer.seconds >= seconds:
            raise AssertionError("the time is over")
        arrived = arrives(generate(family, seed, size=size), controller)
        peer.count(arrived, begun)
        assert arrived

    with contextlib.suppress(AssertionError):
        test_it_arrives()
    return peer
