"""Memory that C and Python share lives as long as either uses it."""

import gc
from dataclasses import dataclass, field

import numpy as np

from sim import Commands, Observations, RobotOptions, RunOptions, simulate
from sim.controllers import CONTROLLERS
from sim.runners import core_calls
from sim.runners.core_calls import CoreEpisode, Driver
from sim.runners.lattice import LatticeRun
from tests.sim.test_episode import cup


@dataclass(frozen=True)
class KeepsWhatItSees:
    """Drives ahead, and keeps references to its argument arrays."""

    kept: list[Observations] = field(default_factory=list, compare=False)
    senses = ("beams",)

    def reset(self):
        return (0.0,)

    def act_many(self, observation, memory):
        self.kept.append(observation)
        return Commands(1.0, 0.0, False), memory


def test_a_controller_may_keep_what_it_saw_in_a_run_that_is_gone():
    controller = KeepsWhatItSees()
    simulate(cup(), controller, steps=5, beams=36, beam_range=2.0)
    gc.collect()
    overwritten = [np.full(size, np.nan) for size in range(20, 80) for _ in range(20)]
    last = controller.kept[-1]
    assert len(overwritten) == 1200
    assert np.isfinite(last.beams).all()
    assert last.time_step.tolist() == [0.015]


def test_an_arena_keeps_its_table_of_rays():
    options = RunOptions(steps=50, robot=RobotOptions(beams=36))
    controller = CONTROLLERS.get("vfh")
    run = LatticeRun(cup(), controller, options)
    run.settings.steps = options.steps
    ended = []
    for forgets in (False, True):
        arena = run.arena()
        if forgets:
            # A second thread makes the same table at the same time.
            core_calls.ray_table.cache_clear()
        episode = CoreEpisode(arena, run.settings, Driver(controller, controller.memory))
        episode.run_to_the_end()
        ended.append(episode.state_words().tolist())
    assert ended[0] == ended[1]
