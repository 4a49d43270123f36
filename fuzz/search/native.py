"""The native strategy: screen random scenes by the thousand in the C core.

For each behaviour key, only the smallest few failures are proved.
"""

from __future__ import annotations

import contextlib
from collections import Counter, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fuzz.layouts.features import arena_for
from fuzz.layouts.layout_bytes import SCENE_BYTES
from fuzz.layouts.variation import OF_THE_ROBOT, WAYPOINTS, applied
from fuzz.screening import WIDEST, Screening, can_screen, evaluate
from fuzz.search.task import SearchTask
from fuzz.unit.config import CampaignConfig
from fuzz.unit.live import count_live
from sim._core import lib
from sim.clock.stopping import OutOfTime, check_time, is_out_of_time, stopping_when
from sim.controllers import CONTROLLERS, CompiledController, ProcessController, VectorController
from sim.controllers.base import robot_for
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bytes

NATIVE = "native"

Draw = Callable[[RandomStream], Bytes]
"""Returns (n, SCENE_BYTES) uint8, the next scenes."""

Seen = Callable[[Screening], None]
"""Called with the result of each screening run."""

_SCENES = 80  # limit on a unit's scenes, per example
_TICK = 1e-7  # s, the cost of work is counted in these: about a compiled controller's step
_SCENE_TICKS = 250  # handling a scene in the core
_WORK = 20_000  # ticks of a unit, per example: 0.8 s in all
_DEATH = 40_000  # ticks to start another process
# Steps of a disc that take as long as one of a robot with a footprint.
_BODY_STEP = 4
# Seconds of typical runs that are screened together.
_AT_ONCE = 2.0
# Number of runs of each key that are proved. Equal keys need not have the same signature, hence more
# than one.
_OF_EACH_KEY = 2
_SCENE_WORDS = -(-SCENE_BYTES // 8)  # words of 8 bytes


@dataclass(frozen=True)
class UnitSize:
    """The amount of work in a unit, chosen so that it takes a second or two whatever a step costs.

    Args:
        at_once: Scenes that are drawn and screened together.
        generation: Scenes of a generation of the archive strategy.
        one_in: One in this many drawn scenes is screened.
        scene: Cost of a scene, relative to a compiled controller's.
        step: Cost of a step; 1 is 0.1 us.
        beam: Cost that a range beam adds to a step.
        proved: Maximum number of runs of a unit that are proved.
        undecided: Maximum number of these that only spent their budget. Their proofs take ten times
            the steps of a screening run, and record them.
        asked: Arriving runs of each batch that the oracles judge, if there are any oracles. Each
            takes as long as hundreds of screening runs.
    """

    at_once: int = 1_000
    generation: int = 500
    one_in: int = 1
    scene: int = 1
    step: int = 1
    beam: int = 1
    proved: int = 32
    undecided: int = 4
    asked: int = 4


_COMPILED = UnitSize()
_VECTOR = UnitSize(at_once=16_000, generation=4_000, proved=8, undecided=2)
_PYTHON = UnitSize(at_once=100, generation=100, scene=16, proved=8, undecided=2, asked=1)
_PROCESS = UnitSize(at_once=100, generation=100, scene=16, proved=4, asked=1)
# A proof of a slow controller's failure takes longer than a unit, so few are in one.
_SLOW_PROVED = 2
_SLOW_UNDECIDED = 1


def unit_size_of(config: CampaignConfig) -> UnitSize:
    """Return the size of a campaign's units, which depends on the controller's kind and pace."""
    controller = CONTROLLERS.get(config.scenario.controller)
    pace = config.pace
    step = max(1, round(pace.step / _TICK))
    if isinstance(controller, CompiledController):
        has_body = any(one.name == "robot_footprint" for one in config.vary)
        own = step * _BODY_STEP if has_body else step
        return replace(_COMPILED, one_in=pace.slower, step=own, beam=min(step, pace.slower))
    size = _PYTHON
    if isinstance(controller, ProcessController):
        size = _PROCESS
    elif isinstance(controller, VectorController):
        size = _VECTOR
    most = max(1, int(_AT_ONCE / pace.run))
    return replace(
        size,
        at_once=min(size.at_once, most),
        generation=min(size.generation, most),
        scene=max(size.scene, round(pace.reset / _TICK / _SCENE_TICKS)),
        step=step,
        proved=_SLOW_PROVED if pace.is_slow else size.proved,
        undecided=_SLOW_UNDECIDED if pace.is_slow else size.undecided,
    )


def fits(config: CampaignConfig) -> bool:
    """Return True if the strategy suits a campaign.

    It takes a motion model on the pose lattice and one robot without waypoints that is not too wide
    for its worlds.
    """
    if any(one.name == WAYPOINTS for one in config.vary):
        return False
    radii = [value for one in config.vary if one.name == "robot_radius" for value in one.values]
    small = all(isinstance(value, float) and value <= WIDEST for value in radii)
    return small and config.robots == 1 and can_screen(config.scenario)


def search(task: SearchTask) -> None:
    """Screen random scenes, and pass the smallest failures of each key to triage."""
    count = unit_size_of(task.config).at_once
    look_through(task, lambda stream: scenes(stream, count))


def look_through(task: SearchTask, draw: Draw, seen: Seen | None = None) -> None:
    """Screen scenes until the unit's work is done; prove the smallest failures of each key.

    Oracles judge the runs that arrive with the longest detours.

    Args:
        task: The unit.
        draw: Draws the next scenes from the unit's random stream.
        seen: Called with each batch's result before the next is drawn.
    """
    few = Few()
    size = unit_size_of(task.config)
    to_prove: deque[tuple[Screening, int]] | None = None
    try:
        asked = _look(task, draw, seen, few, size)
        to_prove = deque(few.in_order(size))
        _prove(task, to_prove)
        few.count_others(task)
    except KeyboardInterrupt:
        # If screening was interrupted, nothing is proved yet, so prove all that it found.
        task.triage.stop()
        with contextlib.suppress(OutOfTime), stopping_when(lambda: True):
            _prove(task, deque(few.in_order(size)) if to_prove is None else to_prove)
        raise
    check_time()
    for looks, n in asked:
        check_time()
        task.triage.ask(looks.world(n), looks.scenario_of(n))


def _look(
    task: SearchTask, draw: Draw, seen: Seen | None, few: Few, size: UnitSize
) -> list[tuple[Screening, int]]:
    """Screen the unit's scenes and add the failures to ``few``.

    Returns:
        The runs that the oracles judge, each a batch and an index into it.
    """
    result = task.triage.result
    asked = list[tuple[Screening, int]]()
    for looks in _looks(task, draw, size):
        if seen is not None:
            seen(looks)
        words, counts = np.unique(looks.verdict[looks.ran], return_counts=True)
        result.verdicts.update(dict(zip(words.tolist(), counts.tolist(), strict=True)))
        result.worlds += int(counts.sum())
        result.steps += looks.simulated
        # Live counts have no steps per verdict, so share them by frequency.
        for word, count in zip(words.tolist(), counts.tolist(), strict=True):
            count_live(word, count, looks.simulated * count // max(int(counts.sum()), 1))
        few.add(looks)
        if task.config.oracles:
            asked += [(looks, n) for n in _most_winding(looks, size.asked)]
    return asked


def _prove(task: SearchTask, failed: deque[tuple[Screening, int]]) -> None:
    """Pass failures to triage, removing each from the queue first."""
    while failed:
        looks, n = failed.popleft()
        task.triage.enter(looks.world(n), looks.scenario_of(n), *_kind(looks, n))


def _kind(looks: Screening, n: int) -> tuple[str, str]:
    """Return a failed run's verdict and cause, as triage tells kinds apart."""
    return str(looks.verdict[n]), f"key {looks.key[n]}"


def _most_winding(looks: Screening, most: int) -> list[int]:
    """Return the arriving runs that drove furthest, relative to the shortest path."""
    arrived = np.flatnonzero(looks.ran & ~looks.failed)
    order = np.argsort(-looks.driven[arrived] / np.maximum(looks.way[arrived], 1), kind="stable")
    return [int(n) for n in arrived[order[:most]]]


class Few:
    """Keeps, for each key, the failures with the fewest solid cells."""

    def __init__(self) -> None:
        self._of_key: dict[int, list[tuple[int, Screening, int]]] = {}
        self._kinds: Counter[tuple[str, str]] = Counter()

    def add(self, looks: Screening) -> None:
        """Add the failures of a batch."""
        failed = np.flatnonzero(looks.failed)
        solid = looks.solid
        keys = looks.key
        for n in failed[np.argsort(solid[failed], kind="stable")].tolist():
            self._kinds[_kind(looks, n)] += 1
            found = self._of_key.setdefault(int(keys[n]), [])
            if len(found) < _OF_EACH_KEY or solid[n] < found[-1][0]:
                found.append((int(solid[n]), looks, n))
                found.sort(key=lambda one: one[0])
                del found[_OF_EACH_KEY:]

    def count_others(self, task: SearchTask) -> None:
        """Count the failed runs that were not examined."""
        for kind, runs in self._kinds.items():
            task.triage.count_alike(*kind, runs - task.triage.examined(*kind))

    def in_order(self, size: UnitSize = _COMPILED) -> list[tuple[Screening, int]]:
        """Return the smallest failure of each key, then the second smallest, up to the limit."""
        ranked = sorted(
            (rank, solid, key, looks, n)
            for key, found in self._of_key.items()
            for rank, (solid, looks, n) in enumerate(found)
        )
        chosen: list[tuple[Screening, int]] = []
        undecided = 0
        for _, _, _, looks, n in ranked:
            undecided += looks.ending[n] == lib.WG_LIMIT
            if looks.ending[n] != lib.WG_LIMIT or undecided <= size.undecided:
                chosen.append((looks, n))
        return chosen[: size.proved]


def _looks(task: SearchTask, draw: Draw, size: UnitSize) -> Iterator[Screening]:
    """Yield screened batches of scenes until the unit's work is done.

    The amount of work depends only on their results, not on the clock.
    """
    config = task.config
    stream = task.stream
    # Varied options keep one value for the whole unit.
    values = {one.name: stream.choice(one.values) for one in config.vary}
    _, scenario = applied(values, arena_for(values), config.scenario)
    robot: Any = {name: value for name, value in values.items() if name in OF_THE_ROBOT}
    times = np.array([scenario.run.time_step] if "time_step" in values else config.time_steps)
    # Each beam of a step adds its own cost.
    step = size.step + size.beam * robot_for(task.controller, scenario.run.robot).beams
    work = 0
    count = 0
    while work < _WORK * config.examples and count < _SCENES * config.examples:
        drawn = draw(stream)[:: size.one_in]
        numbers = stream.bits(len(drawn))
        steps = times[(numbers >> np.uint64(32)) % np.uint64(len(times))]
        looks = evaluate(drawn, scenario, numbers & np.uint64(2**32 - 1), steps, **robot)
        yield looks
        if is_out_of_time():
            return
        work = work + looks.simulated * step + looks.deaths * _DEATH
        count = count + len(drawn) * size.scene


def scenes(stream: RandomStream, count: int) -> Bytes:
    """Return (count, SCENE_BYTES) uint8, random scenes."""
    words = stream.bits(count * _SCENE_WORDS).astype("<u8")
    return words.view(np.uint8).reshape(count, 8 * _SCENE_WORDS)[:, :SCENE_BYTES].copy()
