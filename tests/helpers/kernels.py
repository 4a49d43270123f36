"""``python -m tests.helpers.kernels WORKERS``: compiles the kernels that many test files need, each in one process.

A worker that meets a kernel that is not in the cache compiles it, and so do all that meet it at the same time: the
minute that this takes would be spent once for each worker.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import multiprocessing
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import version
from pathlib import Path

from worldgen.jit import cache_root

ROOT = Path(__file__).parents[2]
PREPARED = ROOT / "build" / "kernels-prepared"  # says for which sources that was done


def prepare(workers: int, say: Callable[[str], object]) -> None:
    """Compile what is not in the cache yet, in a process of its own: the one that calls stays free of Numba.

    A failure is no concern of this helper: the test that needs the kernel shows it.

    Args:
        workers: How many processes share the work.
        say: Told what takes so long, if there is something to do.
    """
    now = _state()
    if PREPARED.is_file() and PREPARED.read_text(encoding="utf-8") == now:
        return
    say("compiling kernels for all workers; on new sources this takes a minute")
    words = [sys.executable, "-m", "tests.helpers.kernels", str(workers)]
    done = subprocess.run(words, cwd=ROOT, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if done.returncode == 0:
        with contextlib.suppress(OSError):  # then it is looked for again the next time
            PREPARED.parent.mkdir(exist_ok=True)
            PREPARED.write_text(now, encoding="utf-8")


def _state() -> str:
    """Return what the compiled kernels depend on: where they are kept, who compiles, and every source file."""
    digest = hashlib.sha256(f"{sys.version} {version('numba')} {cache_root()}".encode())
    for package in ("worldgen", "sim", "fuzz", "worldgen_plugins"):
        for file in sorted((ROOT / package).rglob("*.py")):
            digest.update(f"{file} {file.stat().st_mtime_ns} {file.stat().st_size}\n".encode())
    return digest.hexdigest()


def _episodes(motion: str, *controllers: str) -> None:
    from sim import simulate
    from worldgen import generate

    for controller in controllers:
        simulate(generate("trap", 1), controller, motion=motion, steps=100)


def _batch() -> None:
    from sim import simulate_many
    from worldgen import generate

    simulate_many(generate("trap", 1), "turn-right", steps=4000, seeds=range(2))


def _first_looks() -> None:
    import numpy as np

    from fuzz.features import SCENE_BYTES
    from fuzz.native import evaluate
    from sim.scenario import Scenario

    scenes = np.zeros((1, SCENE_BYTES), np.uint8)
    evaluate(scenes, Scenario.parse("turn-right"), np.zeros(1, np.uint64), 0.015, 100)


def _edits() -> None:
    from sim import edited_runs

    edited_runs._kernel()


def _python_class() -> None:
    from sim import Command, simulate
    from worldgen import generate

    class Straight:
        def reset(self):
            return ()

        def act(self, observation, memory):
            return Command(observation.top_speed, 0.0), memory

    simulate(generate("trap", 1), Straight(), steps=100)


def _fleet() -> None:
    import numpy as np

    from sim import Commands, simulate_many
    from worldgen import generate

    class Straight:
        def reset(self):
            return ()

        def act_many(self, observation, memory):
            return Commands(np.full(len(memory), 1.0), np.zeros(len(memory))), memory

    simulate_many(generate("trap", 1), Straight(), steps=100, seeds=range(2))


def _outcomes() -> None:
    from sim import chance

    chance._typed_outcomes()


def _environment() -> None:
    from worldgen_plugins.for_gymnasium import NavigateEnv

    env = NavigateEnv(family="trap")
    env.reset(seed=1)
    env.step(env.action_space.sample())


# In the order in which they are begun: what takes long first, and what shares helpers with another after it.
TASKS: dict[str, Callable[[], None]] = {
    "swept": functools.partial(_episodes, "swept", "turn-right"),
    "stepped": functools.partial(_episodes, "stepped", "turn-right"),
    "python": _python_class,
    "library": functools.partial(_episodes, "swept", "mapper", "three-layer", "tangent-bug", "vfh", "dynamic-window"),
    "looks": _first_looks,
    "edits": _edits,
    "batch": _batch,
    "fleet": _fleet,
    "outcomes": _outcomes,
    "environment": _environment,
    "walls": functools.partial(_episodes, "swept", "bug1", "bug2", "wall-left", "potential-field", "q-learning"),
}


def _run(name: str) -> None:
    TASKS[name]()


if __name__ == "__main__":
    with ProcessPoolExecutor(int(sys.argv[1]), multiprocessing.get_context("fork")) as pool:
        list(pool.map(_run, TASKS))
