"""Train the library's Q-learning robot and write its table.

The table is the same each time, bit for bit. ``python -m benchmarks.train_q_learning`` takes a
minute or two. With ``--check`` it compares instead of writing.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import click
import numpy as np
import numpy.typing as npt

from benchmarks.thesis_faults import KINDS, draw_worlds
from sim import Command, Observation, _core
from sim.controllers.base import Memory
from sim.controllers.library.q_learning import AT_RESET, DRIVEN, NEEDS, SENSES, SITUATIONS, TURNS
from sim.episode import prepare
from sim.kernels import layout
from sim.options.run import RunOptions
from sim.verdict import Verdict
from worldgen.random_streams import RandomStream

# The words of a round that takes seconds; the gate runs it.
TINY = ("--check",)

TABLE = Path(__file__).parent.parent / "sim" / "core" / "controllers" / "shared" / "q_table.c"

EPISODES = 12_000
# Situations per line of the file.
_ON_A_LINE = 2
# Steps of an episode.
_BUDGET = 800
_SEED = 1
# Worlds of each kind.
_WORLDS = 150
# Discount of the value of what follows a decision.
_DISCOUNT = 0.98
# Learning rate, at first and at last
_LEARN = 0.3
_LEARN_LEAST = 0.02
# Share of random decisions, at first and at last
_EXPLORE = 0.4
_EXPLORE_LEAST = 0.05
# Rewards.
_ARRIVED = 30.0
_BUMP = -1.0
_DECISION = -0.2
# Share of an error that is passed to the previous decision, and so on.
_TRACE = 0.8
# Reward for coming nearer.
_PER_METRE = 5.0


class Learner:
    """Drives by a table, and learns it: ``act`` changes the table.

    Args:
        stream: Source of all randomness.

    Source: Watkins and Dayan (1992), equation 1. Coming nearer is rewarded as a potential, which
        leaves the best policy unchanged: Andrew Y. Ng, Daishi Harada and Stuart Russell, "Policy
        invariance under reward transformations" (1999).
    """

    senses = (*SENSES, "target_distance")
    needs = NEEDS

    def __init__(self, stream: RandomStream) -> None:
        self.table = np.zeros((SITUATIONS, len(TURNS)))
        self.learn = _LEARN
        self.explore = _EXPLORE
        self._stream = stream
        self._before: tuple[int, int, float] | None = None
        self._traces: dict[tuple[int, int], float] = {}

    def reset(self) -> Memory:
        """Begin an episode."""
        self._before = None
        self._traces.clear()
        return AT_RESET

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Make a decision if it is time to.

        It acts like the robot, and learns from the result of the previous decision.
        """
        wait, turned = memory
        turn = 0
        # Decide again at the end of a stretch, or at once after a bump.
        if wait <= 0.0 or observation.bump:
            # The situation is a row of the table, and the choice a column.
            now = _situation(observation, memory)
            self._learn(now, observation)
            choice = self._choose(now)
            self._before = (now, choice, observation.target_distance)
            turn = TURNS[choice]
            # A stretch of fixed length makes decisions comparable.
            wait = float(DRIVEN)
            turned = 0.0 if turn % 4 == 0 else 1.0 if turn < 4 else 2.0
        rate = (turn if turn <= 4 else turn - 8) * (2.0 * np.pi / 8.0) / observation.time_step
        return Command(observation.top_speed, rate), (wait - 1.0, turned)

    def arrived(self) -> None:
        """Learn that the last decision led to the target."""
        if self._before is not None:
            now, choice, _ = self._before
            self._credit(now, choice, _ARRIVED - self.table[now, choice])

    def _learn(self, now: int, observation: Observation) -> None:
        if self._before is None:
            return
        before, choice, distance = self._before
        reward = _DECISION + (_BUMP if observation.bump else 0.0)
        reward += _PER_METRE * (distance - _DISCOUNT * observation.target_distance)
        worth = reward + _DISCOUNT * self.table[now].max()
        self._credit(before, choice, worth - self.table[before, choice])

    def _credit(self, now: int, choice: int, surprise: float) -> None:
        """Spread an error over the decisions that led to it."""
        self._traces[now, choice] = 1.0
        for (situation_before, choice_before), share in list(self._traces.items()):
            self.table[situation_before, choice_before] += self.learn * share * surprise
            if share * _DISCOUNT * _TRACE < 0.01:
                del self._traces[situation_before, choice_before]
            else:
                self._traces[situation_before, choice_before] = share * _DISCOUNT * _TRACE

    def _choose(self, now: int) -> int:
        best = int(np.argmax(self.table[now]))
        if self._stream.below(1_000_000) >= self.explore * 1_000_000:
            return best
        choice = self._stream.below(len(TURNS))
        if choice != best:
            # Its result says nothing about earlier decisions.
            self._traces.clear()
        return choice


def train(episodes: int = EPISODES, seed: int = _SEED) -> npt.NDArray[np.int64]:
    """Return the table after this many episodes, in thousandths."""
    stream = RandomStream(seed)
    learner = Learner(stream.child("decisions"))
    choose = stream.child("worlds")
    worlds = [world for kind in KINDS for world in draw_worlds(kind, _WORLDS, seed)]
    for episode in range(episodes):
        left = 1.0 - episode / episodes
        learner.learn = _LEARN_LEAST + (_LEARN - _LEARN_LEAST) * left
        learner.explore = _EXPLORE_LEAST + (_EXPLORE - _EXPLORE_LEAST) * left
        run = prepare(choose.choice(worlds), learner, RunOptions(steps=_BUDGET))
        if run.run(_BUDGET, find_loop=False, record=False, digest=False).ending == Verdict.REACHED:
            learner.arrived()
    return np.floor(learner.table * 1000.0 + 0.5).astype(np.int64)


def _situation(observation: Observation, memory: Memory) -> int:
    """Return the number of the situation that the robot sees."""
    ffi: Any = _core.ffi
    beams = ffi.new("double[]", observation.beams)
    seen = ffi.new("WgObservation *", (*observation[: layout.OBS_SIZE], beams, len(beams)))
    return int(_core.lib.wg_q_situation(seen, ffi.new("WgQMemory *", memory)))


def as_c(table: npt.NDArray[np.int64]) -> str:
    """Return the text of ``q_table.c``."""
    situations = [f"{{{', '.join(map(str, worths))}}}," for worths in table.tolist()]
    pairs = zip(*[iter(situations)] * _ON_A_LINE, strict=True)
    lines = "\n".join(f"    {' '.join(pair)}" for pair in pairs)
    return (
        "// The Q-learning robot's table, written by `python -m benchmarks.train_q_learning`.\n\n"
        '#include "q_table.h"\n\n'
        f"const int16_t wg_q_table[WG_Q_SITUATIONS][WG_Q_TURNS] = {{\n{lines}\n}};\n"
    )


def main() -> None:
    """Write the table, or report whether it equals the existing one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare with the table that is there")
    given = parser.parse_args()
    path = TABLE
    text = as_c(train())
    if not given.check:
        path.write_text(text, encoding="utf-8")
        click.echo(f"wrote {path.name}")
    elif path.read_text(encoding="utf-8") != text:
        raise SystemExit(f"{path.name} is another table; train again without --check")
    else:
        click.echo(f"{path.name} is what training gives")


if __name__ == "__main__":
    main()
