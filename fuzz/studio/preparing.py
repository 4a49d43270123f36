"""The simulators' kernels, compiled while the page is looked at: on a new installation that takes most of a minute."""

from __future__ import annotations

import contextlib
import sys
from importlib.metadata import version
from importlib.resources import files
from multiprocessing.process import BaseProcess
from pathlib import Path

from fuzz.studio.beside import start_beside
from worldgen.jit import cache_folder

__all__ = ["prepare_beside"]

_RUNS = (("turn-right", "swept"), ("thesis-2", "stepped"))  # of both simulators; in the world below they loop
_NICE = 5  # the page comes first


def prepare_beside(done: Path | None = None) -> BaseProcess | None:
    """Starts a process that compiles what the first runs need; none where that was done before.

    Args:
        done: A file that says so; beside the compiled kernels if left out.
    """
    mark = _mark() if done is None else done
    return None if mark is None or mark.exists() else start_beside(_prepare, mark, nice=_NICE)


def _mark() -> Path | None:
    """In a folder that is another one when the simulators' kernels change; None where compiled kernels are not kept."""
    folder = cache_folder(Path(str(files("sim"))) / "kernels")
    if folder is None:
        return None
    return folder / f"studio-prepared-{sys.implementation.cache_tag}-numba-{version('numba')}"


def _prepare(mark: Path) -> None:
    from sim.episode import simulate  # noqa: PLC0415 - heavy: in that process only
    from sim.run_options import RunOptions  # noqa: PLC0415
    from worldgen.generation import generate  # noqa: PLC0415

    world = generate("trap", 1)
    for controller, motion in _RUNS:
        simulate(world, controller, RunOptions(motion=motion), record=True, lean=True)
    with contextlib.suppress(OSError):  # then it is looked for again at the next start
        mark.touch()
