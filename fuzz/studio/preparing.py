"""The simulators' kernels, compiled while the page is looked at: on a new installation that takes most of a minute."""

from __future__ import annotations

import contextlib
from importlib.resources import files
from multiprocessing.process import BaseProcess
from pathlib import Path

from fuzz.studio.beside import start_beside
from worldgen.jit import cache_folder

__all__ = ["prepare_beside"]

_DONE = "studio-prepared"  # name of a file beside the compiled kernels, whose folder is another one when they change
_RUNS = (("turn-right", "swept"), ("thesis-2", "stepped"))  # of both simulators; in the world below they loop


def prepare_beside() -> BaseProcess | None:
    """Starts a process that compiles what the first runs need; none where that was done before."""
    return None if _done().exists() else start_beside(_prepare, nice=19)


def _done() -> Path:
    return Path(cache_folder(Path(str(files("sim"))) / "kernels")) / _DONE


def _prepare() -> None:
    from sim.episode import simulate  # noqa: PLC0415 - heavy: in that process only
    from sim.run_options import RunOptions  # noqa: PLC0415
    from worldgen.generation import generate  # noqa: PLC0415

    world = generate("trap", 1)
    for controller, motion in _RUNS:
        simulate(world, controller, RunOptions(motion=motion), record=True, lean=True)
    with contextlib.suppress(OSError):  # then it is looked for again at the next start
        _done().touch()
