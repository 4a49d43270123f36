"""The native lane: random scenes by the thousand, looked at in the core.

The few smallest of each kind are proved.
"""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.variation import applied
from fuzz.screening import Screening, can_screen, evaluate
from fuzz.search.features import decode_scene
from fuzz.search.layout_bytes import SCENE_BYTES
from fuzz.search.task import Task
from sim._core import lib
from sim.controllers import CONTROLLERS, CompiledController, ProcessController, VectorController
from sim.controllers.base import robot_for
from sim.runners.stopping import OutOfTime, check_time, is_out_of_time, stopping_when
from worldgen.random_streams import RandomStream
from worldgen.world import DEFAULT_CELL_SIZE

__all__ = [
    "NATIVE",
    "Draw",
    "Few",
    "Pace",
    "Seen",
    "fits",
    "look_through",
    "pace_of",
    "scenes",
    "search",
]

NATIVE = "native"

Draw = Callable[[RandomStream], npt.NDArray[np.uint8]]
"""(n, SCENE_BYTES) scenes, any number of them."""

Seen = Callable[[Screening], None]
"""Learns from first looks."""

_SCENES = 80  # of a unit at most, for each of its examples
_WORK = 20_000  # steps, for each of its examples: 0.8 s where a step takes 0.1 us
_DEATH = 40_000  # steps that could be made in the time in which another process is started
# Looks that are proved, a second one because what is alike at first look need not be of one class.
_OF_EACH_KEY = 2
_SCENE_WORDS = -(-SCENE_BYTES // 8)  # of 8 bytes


@dataclass(frozen=True)
class Pace:
    """How much of a controller a unit asks for.

    So that units take a second or two whatever a step of it costs.

    Args:
        at_once: Scenes that are drawn and looked at together.
        generation: Scenes of a generation of the archive lane.
        one_in: One scene in so many that are drawn is looked at.
        scene: What a scene costs, compared with a compiled controller's.
        step: What a step costs, likewise: 1 is 0.1 us.
        beam: What a range beam adds to that.
        proved: Looks of a unit that are proved, at most.
        undecided: Of these at most, runs that only spent their budget: such a proof takes ten times
            the steps of a look, and a recording of them.
        asked: Runs of one call that oracles judge, where any are asked for: each takes as long as
            hundreds of looks.
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


_COMPILED = Pace()
_VECTOR = Pace(at_once=16_000, generation=4_000, step=4, proved=8, undecided=2)
_PYTHON = Pace(at_once=100, generation=100, scene=16, step=24, proved=8, undecided=2, asked=1)
_PROCESS = Pace(at_once=100, generation=100, scene=160, step=400, proved=4, asked=1)


def pace_of(config: CampaignConfig) -> Pace:
    """The pace of a campaign, by the kind of its controller."""
    controller = CONTROLLERS.get(config.scenario.controller)
    if isinstance(controller, CompiledController):
        return Pace(one_in=config.slower, step=config.slower, beam=config.slower)
    if isinstance(controller, ProcessController):
        return _PROCESS
    return _VECTOR if isinstance(controller, VectorController) else _PYTHON


def fits(config: CampaignConfig) -> bool:
    """Return True if the lane can work for a campaign.

    On the pose lattice, with robots no wider than two cells.
    """
    radii = [value for one in config.vary if one.name == "robot_radius" for value in one.values]
    small = all(isinstance(value, float) and value <= DEFAULT_CELL_SIZE for value in radii)
    return small and can_screen(config.scenario)


def search(task: Task) -> None:
    """Looks at random scenes, and hands on the smallest failures of each key."""
    count = pace_of(task.config).at_once
    look_through(task, lambda stream: scenes(stream, count))


def look_through(task: Task, draw: Draw, seen: Seen | None = None) -> None:
    """Looks at scenes until the unit's work is done, and hands on the smallest failures of each key.

    Oracles that are asked for judge the most winding of the runs that arrive, as the door does what
    fails.

    Args:
        task: The unit.
        draw: Gives the next scenes from the unit's random numbers.
        seen: Called with what came of them, before the next are drawn.
    """
    few = Few()
    pace = pace_of(task.config)
    to_prove: deque[tuple[Screening, int]] | None = None
    try:
        asked = _look(task, draw, seen, few, pace)
        to_prove = deque(few.in_order(pace))
        _prove(task, to_prove)
    except KeyboardInterrupt:
        # Nothing was proved while the unit looked, so all that it met is still to be proved.
        task.door.stop()
        with contextlib.suppress(OutOfTime), stopping_when(lambda: True):
            _prove(task, deque(few.in_order(pace)) if to_prove is None else to_prove)
        raise
    check_time()
    for looks, n in asked:
        check_time()
        task.door.ask(looks.world(n), looks.scenario_of(n))


def _look(
    task: Task, draw: Draw, seen: Seen | None, few: Few, pace: Pace
) -> list[tuple[Screening, int]]:
    """Look at the unit's scenes and give ``few`` the failures.

    Return the runs that oracles are to judge.
    """
    result = task.door.result
    asked = list[tuple[Screening, int]]()
    for looks in _looks(task, draw, pace):
        if seen is not None:
            seen(looks)
        words, counts = np.unique(looks.verdict[looks.ran], return_counts=True)
        result.verdicts.update(dict(zip(words.tolist(), counts.tolist(), strict=True)))
        result.worlds += int(counts.sum())
        result.steps += looks.simulated
        few.add(looks)
        if task.config.oracles:
            asked += [(looks, n) for n in _most_winding(looks, pace.asked)]
    return asked


def _prove(task: Task, failed: deque[tuple[Screening, int]]) -> None:
    """Hand failures to the door, and take each out of the queue as its turn comes."""
    while failed:
        looks, n = failed.popleft()
        task.door.enter(
            looks.world(n), looks.scenario_of(n), str(looks.verdict[n]), f"key {looks.key[n]}"
        )


def _most_winding(looks: Screening, most: int) -> list[int]:
    """Of the runs that arrived those that drove furthest for their way."""
    arrived = np.flatnonzero(looks.ran & ~looks.failed)
    order = np.argsort(-looks.driven[arrived] / np.maximum(looks.way[arrived], 1), kind="stable")
    return [int(n) for n in arrived[order[:most]]]


class Few:
    """The failures with the fewest solid cells of each key."""

    def __init__(self) -> None:
        self._of_key: dict[int, list[tuple[int, Screening, int]]] = {}

    def add(self, looks: Screening) -> None:
        """Takes in what failed."""
        failed = np.flatnonzero(looks.failed)
        solid = looks.solid
        keys = looks.key
        for n in failed[np.argsort(solid[failed], kind="stable")].tolist():
            found = self._of_key.setdefault(int(keys[n]), [])
            if len(found) < _OF_EACH_KEY or solid[n] < found[-1][0]:
                found.append((int(solid[n]), looks, n))
                found.sort(key=lambda one: one[0])
                del found[_OF_EACH_KEY:]

    def in_order(self, pace: Pace = _COMPILED) -> list[tuple[Screening, int]]:
        """The smallest of each key, then the second smallest, and so on; not too many."""
        ranked = sorted(
            (rank, solid, key, looks, n)
            for key, found in self._of_key.items()
            for rank, (solid, looks, n) in enumerate(found)
        )
        chosen: list[tuple[Screening, int]] = []
        undecided = 0
        for _, _, _, looks, n in ranked:
            undecided += looks.ending[n] == lib.WG_LIMIT
            if looks.ending[n] != lib.WG_LIMIT or undecided <= pace.undecided:
                chosen.append((looks, n))
        return chosen[: pace.proved]


def _looks(task: Task, draw: Draw, pace: Pace) -> Iterator[Screening]:
    """The unit's scenes, until its work is done.

    How much that is depends on nothing but their results.
    """
    config = task.config
    stream = task.stream
    values = {
        one.name: stream.choice(one.values) for one in config.vary
    }  # one of each for a whole unit
    world, scenario = applied(values, decode_scene(bytes(SCENE_BYTES)), config.scenario)
    robot = {
        name: getattr(world, name) for name in values if name in ("robot_radius", "robot_speed")
    }
    times = np.array([scenario.run.time_step] if "time_step" in values else config.time_steps)
    step = (
        pace.step + pace.beam * robot_for(task.controller, scenario.run.robot).beams
    )  # each takes as long as a step
    work = 0
    count = 0
    while work < _WORK * config.examples and count < _SCENES * config.examples:
        drawn = draw(stream)[:: pace.one_in]
        numbers = stream.bits(len(drawn))
        steps = times[(numbers >> np.uint64(32)) % np.uint64(len(times))]
        looks = evaluate(drawn, scenario, numbers & np.uint64(2**32 - 1), steps, **robot)
        yield looks
        if is_out_of_time():
            return
        work = work + looks.simulated * step + looks.deaths * _DEATH
        count = count + len(drawn) * pace.scene


def scenes(stream: RandomStream, count: int) -> npt.NDArray[np.uint8]:
    """(count, SCENE_BYTES) random scenes."""
    words = stream.bits(count * _SCENE_WORDS).astype("<u8")
    return words.view(np.uint8).reshape(count, -1)[:, :SCENE_BYTES].copy()
